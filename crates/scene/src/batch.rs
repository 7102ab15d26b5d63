//! Many rays against a scene at once, which hides the time that memory takes.

use crate::geometry::Hit;
use kaustika_accel::{Segment, TriangleHit};

/// Answers of batch queries, in the order of the rays; reused from batch to batch.
#[derive(Debug, Default)]
pub struct RayBatch {
    /// What each ray met.
    pub hits: Vec<Option<Hit>>,
    /// Whether anything was in the way of each ray.
    pub occluded: Vec<bool>,
    pub(crate) triangles: Vec<Option<TriangleHit>>,
}

impl RayBatch {
    pub(crate) fn for_hits(&mut self, segments: &[Segment]) {
        self.triangles.clear();
        self.triangles.resize(segments.len(), None);
        self.hits.clear();
    }

    pub(crate) fn for_occlusion(&mut self, segments: &[Segment]) {
        self.occluded.clear();
        self.occluded.resize(segments.len(), false);
    }
}
