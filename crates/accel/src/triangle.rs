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
//! Lanes are eight triangles and one ray, or one triangle and eight rays: the operations are the
//! same, and so are the bits.

use bytemuck::{Pod, Zeroable};
use kaustika_math::Vec3;

use crate::ray::{LATER, PreparedRay, RayLanes, margin, margins};
use crate::simd::{F32x8, LANES};

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

/// A hit of one lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LaneHit {
    pub(crate) t: f32,
    pub(crate) b: [f32; 3],
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

    fn set(&mut self, lane: usize, hit: &LaneHit) {
        self.lanes |= 1 << lane;
        self.t[lane] = hit.t;
        for (b, v) in self.b.iter_mut().zip(hit.b) {
            b[lane] = v;
        }
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
        (0..BLOCK).map(|lane| usize::from(self.prims[lane] != NO_TRIANGLE)).sum()
    }

    /// The corners of a lane.
    fn corners(&self, lane: usize) -> [[f32; 3]; 3] {
        self.rows.map(|corner| corner.map(|row| row[lane % BLOCK]))
    }

    /// Whether the ray, or its line, may hit anything: false only if not, true seldom without need.
    #[inline(always)]
    pub(crate) fn may_intersect(&self, ray: &RayLanes, axes: [u8; 3]) -> bool {
        let edges = Edges::new(|corner, axis| self.row(corner, axis), axes, ray);
        edges.inside | edges.doubtful != 0
    }

    /// The triangles hit at `0 < t`, with `t <= t_max`: whether equality counts is for the caller.
    /// Lanes without triangle may be among them, after all others. `prepared` gives the ray again.
    #[inline(always)]
    pub(crate) fn intersect(
        &self,
        ray: &RayLanes,
        axes: [u8; 3],
        t_max: f32,
        prepared: impl Fn() -> PreparedRay,
    ) -> Option<Hits> {
        let row = |corner, axis| self.row(corner, axis);
        let edges = Edges::new(row, axes, ray);
        if edges.inside | edges.doubtful == 0 {
            return None;
        }
        let mut hits = edges.hits(row, ray, F32x8::splat(t_max));
        if edges.doubtful != 0 {
            self.doubtful_triangles(&prepared(), t_max, edges.doubtful, &mut hits);
        }
        Some(hits)
    }

    /// Those of the `active` rays that hit triangle `lane` at `0 < t`, with `t <= t_max`. `prepared`
    /// gives each of them again.
    #[inline(always)]
    pub(crate) fn intersect_one(
        &self,
        lane: usize,
        rays: &RayLanes,
        axes: [u8; 3],
        active: u32,
        t_max: F32x8,
        prepared: impl Fn(usize) -> PreparedRay,
    ) -> Option<Hits> {
        let row =
            |corner: usize, axis: usize| F32x8::splat(self.rows[corner][axis.min(2)][lane % BLOCK]);
        let edges = Edges::new(row, axes, rays);
        if (edges.inside | edges.doubtful) & active == 0 {
            return None;
        }
        let mut hits = edges.hits(row, rays, t_max);
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
    fn doubtful_triangles(&self, ray: &PreparedRay, t_max: f32, doubtful: u32, hits: &mut Hits) {
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

#[cold]
#[inline(never)]
fn doubtful_rays(
    corners: &[[f32; 3]; 3],
    prepared: &impl Fn(usize) -> PreparedRay,
    t_max: F32x8,
    doubtful: u32,
    hits: &mut Hits,
) {
    let t_max = t_max.to_array();
    for lane in (0..LANES).filter(|lane| doubtful >> lane & 1 != 0) {
        if let Some(hit) = intersect_in_double(corners, &prepared(lane))
            && hit.t <= t_max[lane]
        {
            hits.set(lane, &hit);
        }
    }
}

/// Equation (1), and what it says of each lane.
struct Edges {
    uvw: [F32x8; 3],
    /// Of the corners, relative to the origin.
    z: [F32x8; 3],
    /// The signs agree, and can be trusted.
    inside: u32,
    /// The signs can't be trusted.
    doubtful: u32,
}

impl Edges {
    /// `row(corner, axis)` has the coordinates of the lanes.
    #[inline(always)]
    fn new(row: impl Fn(usize, usize) -> F32x8, axes: [u8; 3], ray: &RayLanes) -> Edges {
        let [kx, ky, kz] = axes.map(usize::from);
        let [ox, oy, oz] = ray.o;
        let [sx, sy, _] = ray.shear;
        let sheared = |corner| {
            let z = row(corner, kz) - oz;
            let x = sx.neg_mul_add(z, row(corner, kx) - ox);
            let y = sy.neg_mul_add(z, row(corner, ky) - oy);
            (x, y, z)
        };
        let (ax, ay, az) = sheared(0);
        let (bx, by, bz) = sheared(1);
        let (cx, cy, cz) = sheared(2);
        let u = difference(cx, by, cy, bx);
        let v = difference(ax, cy, ay, cx);
        let w = difference(bx, ay, by, ax);
        let trusted = ray.min_edge.le(u.abs().min(v.abs()).min(w.abs()));
        let inside = !u.differing_signs(v, w) & trusted;
        Edges { uvw: [u, v, w], z: [az, bz, cz], inside, doubtful: !trusted & 0xff }
    }

    /// Equation (2), within the triangle's box, of the lanes inside.
    #[inline(always)]
    fn hits(&self, row: impl Fn(usize, usize) -> F32x8, ray: &RayLanes, t_max: F32x8) -> Hits {
        let [u, v, w] = self.uvw;
        let inv_det = F32x8::splat(1.0) / (u + v + w);
        let (b0, b1, b2) = (u * inv_det, v * inv_det, w * inv_det);
        let [az, bz, cz] = self.z;
        let t = b0.mul_add(az, b1.mul_add(bz, b2 * cz)) * ray.shear[2];

        let zero = F32x8::splat(0.0);
        let (mut lo, mut hi) = ([zero; 3], [zero; 3]);
        for axis in 0..3 {
            let [a, b, c] = [row(0, axis), row(1, axis), row(2, axis)];
            (lo[axis], hi[axis]) = (a.min(b).min(c), a.max(b).max(c));
        }
        let margin = margins([hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]]);
        let through = |margin: F32x8| {
            let (mut entry, mut exit) = (zero, F32x8::splat(f32::INFINITY));
            for axis in 0..3 {
                let (lo, hi) = (lo[axis] - margin, hi[axis] + margin);
                let (inv_d, near_c, far_c) = (ray.inv_d[axis], ray.near_c[axis], ray.far_c[axis]);
                let first = lo.mul_add(inv_d, near_c).min(hi.mul_add(inv_d, near_c));
                let last = lo.mul_add(inv_d, far_c).max(hi.mul_add(inv_d, far_c));
                (entry, exit) = (entry.max(first), exit.min(last));
            }
            (entry, exit)
        };
        // The box as it is, then as nodes have it.
        let (entry, exit) = through(zero);
        let (early, late) = through(margin);
        let t = t.min(exit).max(entry);
        let met = early.le(late * F32x8::splat(LATER));
        Hits {
            lanes: self.inside & met & zero.lt(t) & t.le(t_max),
            t: t.to_array(),
            b: [b0.to_array(), b1.to_array(), b2.to_array()],
        }
    }
}

/// a b - c d with an error below two units in the last place, so of the exact sign (Kahan; proof
/// by Jeannerod, Louvet & Muller 2013), unless c d underflows.
#[inline(always)]
fn difference(a: F32x8, b: F32x8, c: F32x8, d: F32x8) -> F32x8 {
    let cd = c * d;
    let error = c.neg_mul_add(d, cd);
    a.mul_sub(b, cd) + error
}

/// The test with equations (1) and (2) in double precision, for edge functions that single
/// precision cannot tell from zero. The shear is that of the vector test: the corners must be the
/// same for the neighbours of this triangle.
#[cold]
fn intersect_in_double(corners: &[[f32; 3]; 3], ray: &PreparedRay) -> Option<LaneHit> {
    let [kx, ky, kz] = ray.axes.map(usize::from);
    let ([ox, oy, oz], [sx, sy, sz]) = (ray.o, ray.shear);
    let [a, b, c] = corners.map(|p| {
        let z = p[kz] - oz;
        [(-sx).mul_add(z, p[kx] - ox), (-sy).mul_add(z, p[ky] - oy), z].map(f64::from)
    });
    let u = c[0] * b[1] - c[1] * b[0];
    let v = a[0] * c[1] - a[1] * c[0];
    let w = b[0] * a[1] - b[1] * a[0];
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let det = u + v + w;
    if det == 0.0 {
        return None;
    }
    let b64 = [u / det, v / det, w / det];
    let t = (b64[0] * a[2] + b64[1] * b[2] + b64[2] * c[2]) * f64::from(sz);
    let (entry, exit, met) = own_box(corners, ray);
    let t = (t as f32).min(exit).max(entry);
    (met && t > 0.0).then_some(LaneHit { t, b: b64.map(|v| v as f32) })
}

/// Entry into the box of a triangle, exit from it, and whether the ray meets it as nodes have it.
fn own_box(corners: &[[f32; 3]; 3], ray: &PreparedRay) -> (f32, f32, bool) {
    let [lo, hi] = [f32::min, f32::max]
        .map(|pick| [0, 1, 2].map(|i| pick(pick(corners[0][i], corners[1][i]), corners[2][i])));
    let margin = margin(Vec3::new(hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]));
    let [(entry, exit), (early, late)] = [0.0, margin].map(|m| {
        let (mut entry, mut exit) = (0f32, f32::INFINITY);
        for i in 0..3 {
            let (lo, hi) = (lo[i] - m, hi[i] + m);
            let (first, last) = if ray.negative[i] != 0 { (hi, lo) } else { (lo, hi) };
            entry = entry.max(first.mul_add(ray.inv_d[i], ray.near_c[i]));
            exit = exit.min(last.mul_add(ray.inv_d[i], ray.far_c[i]));
        }
        (entry, exit)
    });
    (entry, exit, early <= late * LATER)
}

/// The scalar twin of [`TriangleBlock::intersect`]: the same operations on one triangle and one
/// ray.
#[cfg(test)]
pub(crate) fn intersect_one(corners: &[[f32; 3]; 3], ray: &PreparedRay) -> Option<LaneHit> {
    use kaustika_math::diff_of_products;
    let [kx, ky, kz] = ray.axes.map(usize::from);
    let ([ox, oy, oz], [sx, sy, sz]) = (ray.o, ray.shear);
    let [a, b, c] = corners.map(|p| {
        let z = p[kz] - oz;
        [(-sx).mul_add(z, p[kx] - ox), (-sy).mul_add(z, p[ky] - oy), z]
    });
    let u = diff_of_products(c[0], b[1], c[1], b[0]);
    let v = diff_of_products(a[0], c[1], a[1], c[0]);
    let w = diff_of_products(b[0], a[1], b[1], a[0]);
    let least = ray.min_edge;
    if ![u, v, w].iter().all(|e| e.abs() >= least) {
        return intersect_in_double(corners, ray);
    }
    if (u > 0.0) != (v > 0.0) || (u > 0.0) != (w > 0.0) {
        return None;
    }
    let inv_det = 1.0 / (u + v + w);
    let bary = [u * inv_det, v * inv_det, w * inv_det];
    let t = bary[0].mul_add(a[2], bary[1].mul_add(b[2], bary[2] * c[2])) * sz;
    let (entry, exit, met) = own_box(corners, ray);
    let t = t.min(exit).max(entry);
    (met && t > 0.0).then_some(LaneHit { t, b: bary })
}
