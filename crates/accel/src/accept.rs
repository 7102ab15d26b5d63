//! Which hits count.

use crate::triangle_bvh::TriangleHit;

/// Decides about the hits of many rays.
pub(crate) trait Accept {
    /// All hits count, so that there is no need to ask.
    const ALL: bool;

    /// Whether a hit of the ray with this number counts.
    fn accept(&mut self, ray: usize, hit: &TriangleHit) -> bool;
}

/// All hits count.
pub(crate) struct Everything;

impl Accept for Everything {
    const ALL: bool = true;

    #[inline(always)]
    fn accept(&mut self, _: usize, _: &TriangleHit) -> bool {
        true
    }
}

impl<F: FnMut(usize, &TriangleHit) -> bool> Accept for F {
    const ALL: bool = false;

    #[inline(always)]
    fn accept(&mut self, ray: usize, hit: &TriangleHit) -> bool {
        self(ray, hit)
    }
}
