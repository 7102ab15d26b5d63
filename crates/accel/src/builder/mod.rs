//! From bounds of primitives to a wide tree: a binary tree by binned SAH ([`binary`]), cut into
//! wide nodes and leaves ([`wide`]).
//!
//! Deterministic: what happens to a range of primitives depends on that range alone, never on
//! which thread gets it.

mod binary;
mod binning;
mod partition;
mod wide;

use kaustika_math::{Bounds3, Vec3};

pub(crate) use binary::MAX_DEPTH;
pub(crate) use wide::WideTree;

use crate::ray::MAX_COORDINATE;

/// Trade-offs of the builder. The default suits path tracing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildOptions {
    /// Candidate split planes an axis, 2..=32, in the binned surface area heuristic.
    pub bins: usize,
    /// Cost of testing a block of up to eight triangles, in tests of an eight-wide node; > 0.
    pub leaf_cost: f32,
}

impl Default for BuildOptions {
    fn default() -> Self {
        BuildOptions { bins: 16, leaf_cost: 1.0 }
    }
}

impl BuildOptions {
    /// With the nearest, or the default, in place of what makes no sense.
    pub(crate) fn in_range(&self) -> BuildOptions {
        let bins = self.bins.clamp(2, binning::MAX_BINS);
        let leaf_cost =
            if self.leaf_cost > 0.0 { self.leaf_cost } else { BuildOptions::default().leaf_cost };
        BuildOptions { bins, leaf_cost }
    }
}

/// The bounds of a primitive and its number, in two registers of four lanes.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct PrimRef {
    /// Least corner; the bits of the last lane are the primitive's number.
    lo: [f32; 4],
    /// Greatest corner; the last lane is unused.
    hi: [f32; 4],
}

impl PrimRef {
    /// `None` if the bounds are empty or not finite.
    pub(crate) fn new(prim: u32, bounds: &Bounds3) -> Option<PrimRef> {
        let (lo, hi) = (bounds.min, bounds.max);
        // Written so that NaN fails.
        let valid =
            (0..3).all(|a| lo[a] <= hi[a] && lo[a] >= -MAX_COORDINATE && hi[a] <= MAX_COORDINATE);
        valid.then(|| PrimRef {
            lo: [lo.x, lo.y, lo.z, f32::from_bits(prim)],
            hi: [hi.x, hi.y, hi.z, 0.0],
        })
    }

    pub(crate) fn prim(&self) -> u32 {
        self.lo[3].to_bits()
    }

    pub(crate) fn bounds(&self) -> Bounds3 {
        Box4 { lo: self.lo, hi: self.hi }.bounds()
    }

    /// Twice the centre; the last lane is of no meaning.
    #[inline(always)]
    fn centroid(&self) -> [f32; 4] {
        std::array::from_fn(|i| self.lo[i] + self.hi[i])
    }
}

/// A box in two registers of four lanes; the last lane is of no meaning.
#[derive(Clone, Copy, Debug)]
struct Box4 {
    lo: [f32; 4],
    hi: [f32; 4],
}

impl Box4 {
    const EMPTY: Box4 = Box4 { lo: [f32::INFINITY; 4], hi: [f32::NEG_INFINITY; 4] };

    #[inline(always)]
    fn grow(&mut self, lo: &[f32; 4], hi: &[f32; 4]) {
        // The comparisons of the vector instructions, which f32::min and max are not.
        self.lo = std::array::from_fn(|i| if self.lo[i] < lo[i] { self.lo[i] } else { lo[i] });
        self.hi = std::array::from_fn(|i| if self.hi[i] > hi[i] { self.hi[i] } else { hi[i] });
    }

    #[inline(always)]
    fn merge(&mut self, o: &Box4) {
        self.grow(&o.lo, &o.hi);
    }

    /// Half the surface area of the box times `scale²`.
    #[inline(always)]
    fn half_area(&self, scale: f32) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|i| (self.hi[i] - self.lo[i]) * scale);
        x * y + y * z + z * x
    }

    fn bounds(&self) -> Bounds3 {
        let corner = |c: [f32; 4]| Vec3::new(c[0], c[1], c[2]);
        Bounds3 { min: corner(self.lo), max: corner(self.hi) }
    }
}

/// The box of some primitives, and that of their doubled centres.
#[derive(Clone, Copy, Debug)]
struct Extent {
    bounds: Box4,
    centroids: Box4,
}

impl Extent {
    const EMPTY: Extent = Extent { bounds: Box4::EMPTY, centroids: Box4::EMPTY };

    #[inline(always)]
    fn add(&mut self, r: &PrimRef) {
        let c = r.centroid();
        self.bounds.grow(&r.lo, &r.hi);
        self.centroids.grow(&c, &c);
    }

    fn merge(mut self, o: Extent) -> Extent {
        self.bounds.merge(&o.bounds);
        self.centroids.merge(&o.centroids);
        self
    }
}

/// What the surface area heuristic weighs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Costs {
    /// Most primitives in a leaf.
    pub(crate) leaf_size: usize,
    /// Of a leaf's test, in tests of a wide node.
    pub(crate) leaf: f32,
    /// Candidate planes an axis.
    pub(crate) bins: usize,
    /// Areas are measured with lengths times this, so that none overflows or vanishes.
    pub(crate) scale: f32,
}

/// The number that brings the largest extent of `bounds` to one.
pub(crate) fn unit_scale(bounds: &Bounds3) -> f32 {
    let extent = bounds.diagonal().max_component();
    if extent > 1e-36 { 1.0 / extent } else { 1.0 }
}
