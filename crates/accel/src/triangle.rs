//! Eight triangles at a time: the watertight test of Woop, Benthin & Wald (2013, JCGT 2(1)).
//!
//! Relative to the ray's origin, permuted and sheared so that the ray is the z axis, a triangle
//! A B C is hit where the origin of the plane lies inside its projection: where the edge functions
//!
//! ```text
//! U = Cx By - Cy Bx,   V = Ax Cy - Ay Cx,   W = Bx Ay - By Ax                  (1)
//! ```
//!
//! have one sign; zero counts as either. Two triangles at an edge compute the same products, so a
//! ray that misses one by sign hits the other, if only the signs are exact. Here they are, since
//! each difference is taken with Kahan's fused correction, whose error is below two units in the
//! last place (Jeannerod, Louvet & Muller 2013). Only where a product may have underflowed, or a
//! difference is zero, the test is repeated in double precision, where products are exact.
//!
//! ```text
//! (b0, b1, b2) = (U, V, W) / (U + V + W),   t = (b0 Az + b1 Bz + b2 Cz) / d_z          (2)
//! ```
//!
//! At last `t` is clamped to where the ray is inside the triangle's own box. This takes away the
//! error of (2) where triangles lie along an axis plane, and it makes sure that `t` is not before
//! the entry into any box of the tree.
//!
use bytemuck::{Pod, Zeroable};

use crate::edges::{Edges, LaneHits, Passages, intersect_in_double};
use crate::ray::{PreparedRay, RayLanes, margins};
use crate::simd::{F32x8, LANES, Lanes};

/// Triangles in a block.
pub(crate) const BLOCK: usize = LANES;

/// Marks a lane without triangle. No triangle has this number, as there are at most 2³¹.
const NO_TRIANGLE: u32 = u32::MAX;

/// Up to eight triangles side by side.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct TriangleBlock {
    /// Of each corner its coordinates, of all triangles.
    rows: [[[f32; BLOCK]; 3]; 3],
    prims: [u32; BLOCK],
}

/// The lanes that are hit.
pub(crate) struct Hits {
    /// One bit a lane.
    pub(crate) lanes: u32,
    t: [f32; LANES],
    b: [[f32; LANES]; 3],
}

impl Hits {
    #[inline(always)]
    pub(crate) fn t(&self, lane: usize) -> f32 {
        self.t[lane % LANES]
    }

    #[inline(always)]
    pub(crate) fn b(&self, lane: usize) -> [f32; 3] {
        [self.b[0][lane % LANES], self.b[1][lane % LANES], self.b[2][lane % LANES]]
    }

    /// Takes the first lane that is left.
    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<usize> {
        let lane = self.lanes.trailing_zeros() as usize;
        self.lanes &= self.lanes.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    }
}

impl From<LaneHits<F32x8>> for Hits {
    #[inline(always)]
    fn from(hits: LaneHits<F32x8>) -> Hits {
        Hits { lanes: hits.lanes, t: hits.t.to_array(), b: hits.b.map(F32x8::to_array) }
    }
}

impl TriangleBlock {
    /// At least one and at most eight triangles with their numbers.
    pub(crate) fn new(
        triangles: impl ExactSizeIterator<Item = (u32, [[f32; 3]; 3])>,
    ) -> TriangleBlock {
        let count = triangles.len();
        let mut block = TriangleBlock { rows: [[[0.0; BLOCK]; 3]; 3], prims: [NO_TRIANGLE; BLOCK] };
        for (lane, (prim, corners)) in triangles.enumerate() {
            block.prims[lane] = prim;
            let rows = block.rows.as_flattened_mut();
            for (row, v) in rows.iter_mut().zip(corners.as_flattened()) {
                row[lane] = *v;
            }
        }
        // Copies of a triangle in the lanes left over never need double precision for themselves.
        for row in block.rows.as_flattened_mut() {
            let first = row[0];
            row[count..].fill(first);
        }
        block
    }

    /// The number of the triangle in a lane.
    #[inline(always)]
    pub(crate) fn prim(&self, lane: usize) -> Option<u32> {
        let prim = self.prims[lane % BLOCK];
        (prim != NO_TRIANGLE).then_some(prim)
    }

    /// Triangles in this block; they are in its first lanes.
    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        // As numbers all are below 2, but for the one of no triangle, which is none.
        let prims = F32x8::load(&self.prims.map(f32::from_bits));
        prims.lt(F32x8::splat(2.0)).count_ones() as usize
    }

    /// The corners of a lane.
    fn corners(&self, lane: usize) -> [[f32; 3]; 3] {
        self.rows.map(|corner| corner.map(|row| row[lane % BLOCK]))
    }

    /// Whether the ray, or its line, may hit anything: false only if not, true seldom without need.
    #[inline(always)]
    pub(crate) fn may_intersect(&self, ray: &RayLanes<F32x8>, axes: [u8; 3]) -> bool {
        let edges = Edges::new(|corner, axis| self.row(corner, axis), axes, ray);
        edges.inside | edges.doubtful != 0
    }

    /// The triangles hit at `0 < t`, with `t <= t_max`: whether equality counts is for the caller.
    /// Lanes without triangle may be among them, after all others. `prepared` gives the ray again.
    #[inline(always)]
    pub(crate) fn intersect(
        &self,
        ray: &RayLanes<F32x8>,
        axes: [u8; 3],
        t_max: f32,
        prepared: impl Fn() -> PreparedRay,
    ) -> Option<Hits> {
        let edges = Edges::new(|corner, axis| self.row(corner, axis), axes, ray);
        if edges.inside | edges.doubtful == 0 {
            return None;
        }
        let mut hits = edges.hits(&self.passages(ray), ray.shear[2], F32x8::splat(t_max));
        if edges.doubtful != 0 {
            self.doubtful_triangles(&prepared(), t_max, edges.doubtful, &mut hits);
        }
        Some(hits.into())
    }

    /// Of the ray through the boxes of all triangles.
    #[inline(always)]
    fn passages(&self, ray: &RayLanes<F32x8>) -> Passages<F32x8> {
        let OwnBoxes { lo, hi, margin } = self.own_boxes();
        let through = |margin: F32x8| {
            let (mut entry, mut exit) = (F32x8::splat(0.0), F32x8::splat(f32::INFINITY));
            for axis in 0..3 {
                let (lo, hi) = (lo[axis] - margin, hi[axis] + margin);
                let (inv_d, near_c, far_c) = (ray.inv_d[axis], ray.near_c[axis], ray.far_c[axis]);
                let first = lo.mul_add(inv_d, near_c).min(hi.mul_add(inv_d, near_c));
                let last = lo.mul_add(inv_d, far_c).max(hi.mul_add(inv_d, far_c));
                (entry, exit) = (entry.max(first), exit.min(last));
            }
            (entry, exit)
        };
        let ((entry, exit), (early, late)) = (through(F32x8::splat(0.0)), through(margin));
        Passages { entry, exit, early, late }
    }

    #[inline(always)]
    fn own_boxes(&self) -> OwnBoxes {
        let zero = F32x8::splat(0.0);
        let (mut lo, mut hi, mut sides) = ([zero; 3], [zero; 3], [zero; 3]);
        for axis in 0..3 {
            let (a, b, c) = (self.row(0, axis), self.row(1, axis), self.row(2, axis));
            (lo[axis], hi[axis]) = (a.min(b).min(c), a.max(b).max(c));
            sides[axis] = hi[axis] - lo[axis];
        }
        OwnBoxes { lo, hi, margin: margins(sides) }
    }

    /// Made ready to be asked by several rays at a time, whose directions have these signs.
    #[inline(always)]
    pub(crate) fn slabs(&self, negative: [u8; 3]) -> Slabs {
        let OwnBoxes { lo, hi, margin } = self.own_boxes();
        let mut slabs = Slabs { own: [[[0.0; BLOCK]; 2]; 3], wide: [[[0.0; BLOCK]; 2]; 3] };
        for axis in 0..3 {
            let first = usize::from(negative[axis] & 1);
            slabs.own[axis][first] = lo[axis].to_array();
            slabs.own[axis][first ^ 1] = hi[axis].to_array();
            slabs.wide[axis][first] = (lo[axis] - margin).to_array();
            slabs.wide[axis][first ^ 1] = (hi[axis] + margin).to_array();
        }
        slabs
    }

    /// Those of the `active` rays that hit triangle `lane` at `0 < t`, with `t <= t_max`. `slabs`
    /// are those of this block, for the signs of the rays' directions; `prepared` gives each ray
    /// again.
    #[inline(always)]
    pub(crate) fn intersect_one<V: Lanes>(
        &self,
        lane: usize,
        slabs: &Slabs,
        rays: &RayLanes<V>,
        axes: [u8; 3],
        active: u32,
        t_max: V,
        prepared: impl Fn(usize) -> PreparedRay,
    ) -> Option<LaneHits<V>> {
        let row =
            |corner: usize, axis: usize| V::splat(self.rows[corner][axis.min(2)][lane % BLOCK]);
        let edges = Edges::new(row, axes, rays);
        if (edges.inside | edges.doubtful) & active == 0 {
            return None;
        }
        let mut hits = edges.hits(&slabs.passages(lane, rays), rays.shear[2], t_max);
        hits.lanes &= active;
        if edges.doubtful & active != 0 {
            let doubtful = edges.doubtful & active;
            doubtful_rays(&self.corners(lane), &prepared, t_max, doubtful, &mut hits);
        }
        Some(hits)
    }

    #[inline(always)]
    fn row(&self, corner: usize, axis: usize) -> F32x8 {
        F32x8::load(&self.rows[corner][axis.min(2)])
    }

    #[cold]
    #[inline(never)]
    fn doubtful_triangles(
        &self,
        ray: &PreparedRay,
        t_max: f32,
        doubtful: u32,
        hits: &mut LaneHits<F32x8>,
    ) {
        for lane in (0..BLOCK).filter(|lane| doubtful >> lane & 1 != 0) {
            if self.prims[lane] != NO_TRIANGLE
                && let Some(hit) = intersect_in_double(&self.corners(lane), ray)
                && hit.t <= t_max
            {
                hits.set(lane, &hit);
            }
        }
    }
}

/// The boxes of the triangles of a block, and how much wider nodes have them.
struct OwnBoxes {
    lo: [F32x8; 3],
    hi: [F32x8; 3],
    margin: F32x8,
}

/// The boxes of the triangles of a block, as they are and as nodes have them: of each axis the
/// planes that rays meet first, then those they meet last.
pub(crate) struct Slabs {
    own: [[[f32; BLOCK]; 2]; 3],
    wide: [[[f32; BLOCK]; 2]; 3],
}

impl Slabs {
    /// Of several rays through the box of triangle `lane`.
    #[inline(always)]
    fn passages<V: Lanes>(&self, lane: usize, rays: &RayLanes<V>) -> Passages<V> {
        let through = |planes: &[[[f32; BLOCK]; 2]; 3]| {
            let (mut entry, mut exit) = (V::splat(0.0), V::splat(f32::INFINITY));
            for axis in 0..3 {
                let [first, last] = [0, 1].map(|side| V::splat(planes[axis][side][lane % BLOCK]));
                entry = entry.max(first.mul_add(rays.inv_d[axis], rays.near_c[axis]));
                exit = exit.min(last.mul_add(rays.inv_d[axis], rays.far_c[axis]));
            }
            (entry, exit)
        };
        let ((entry, exit), (early, late)) = (through(&self.own), through(&self.wide));
        Passages { entry, exit, early, late }
    }
}

#[cold]
#[inline(never)]
fn doubtful_rays<V: Lanes>(
    corners: &[[f32; 3]; 3],
    prepared: &impl Fn(usize) -> PreparedRay,
    t_max: V,
    doubtful: u32,
    hits: &mut LaneHits<V>,
) {
    let t_max = t_max.to_array();
    for (lane, t_max) in t_max.as_ref().iter().enumerate() {
        if doubtful >> lane & 1 != 0
            && let Some(hit) = intersect_in_double(corners, &prepared(lane))
            && hit.t <= *t_max
        {
            hits.set(lane, &hit);
        }
    }
}
