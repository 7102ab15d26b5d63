//! Many rays against a scene at once, which hides the time that memory takes.

use crate::geometry::{Hit, Primitive};
use kaustika_accel::{Segment, TriangleHit};

/// Answers of batch queries, in the order of the rays; reused from batch to batch.
#[derive(Debug, Default)]
pub struct RayBatch {
    /// Whether anything was in the way of each ray.
    pub occluded: Vec<bool>,
    /// The world's triangle that each ray met first.
    pub(crate) triangles: Vec<Option<TriangleHit>>,
    /// What each ray met first, where that may be something else than a triangle of the world.
    pub(crate) others: Vec<Option<Hit>>,
}

impl RayBatch {
    /// What ray `i` met.
    #[inline(always)]
    pub fn hit(&self, i: usize) -> Option<Hit> {
        match self.others.get(i) {
            Some(hit) => *hit,
            None => {
                let TriangleHit { t, prim, b } = self.triangles[i]?;
                Some(Hit { t, primitive: Primitive::Triangle(prim, b), instance: None })
            }
        }
    }

    pub(crate) fn for_hits(&mut self, segments: &[Segment]) {
        self.triangles.clear();
        self.triangles.resize(segments.len(), None);
        self.others.clear();
    }

    pub(crate) fn for_occlusion(&mut self, segments: &[Segment]) {
        self.occluded.clear();
        self.occluded.resize(segments.len(), false);
    }
}
