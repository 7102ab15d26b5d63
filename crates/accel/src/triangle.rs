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

use crate::ray::{PreparedRay, SLACK};
use crate::simd::{F32x8, LANES};

/// Triangles in a block.
pub(crate) const BLOCK: usize = LANES;

/// Marks a lane without triangle. No triangle has this number, as there are at most 2³¹.
const NO_TRIANGLE: u32 = u32::MAX;

/// Up to eight triangles side by side.
#[derive(Clone, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct TriangleBlock {
    /// Row `3 * corner + axis`.
    rows: [[f32; BLOCK]; 9],
    prims: [u32; BLOCK],
}

/// A hit of one lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LaneHit {
    pub(crate) t: f32,
    pub(crate) b: [f32; 3],
}

/// The lanes that a ray hits.
pub(crate) struct BlockHits {
    /// One bit a lane.
    pub(crate) lanes: u32,
    t: [f32; BLOCK],
    b: [[f32; BLOCK]; 3],
}

impl BlockHits {
    #[inline(always)]
    pub(crate) fn t(&self, lane: usize) -> f32 {
        self.t[lane % BLOCK]
    }

    #[inline(always)]
    pub(crate) fn b(&self, lane: usize) -> [f32; 3] {
        [self.b[0][lane % BLOCK], self.b[1][lane % BLOCK], self.b[2][lane % BLOCK]]
    }
}

impl TriangleBlock {
    /// At least one and at most eight triangles with their numbers.
    pub(crate) fn new(
        triangles: impl ExactSizeIterator<Item = (u32, [[f32; 3]; 3])>,
    ) -> TriangleBlock {
        let count = triangles.len();
        let mut block = TriangleBlock { rows: [[0.0; BLOCK]; 9], prims: [NO_TRIANGLE; BLOCK] };
        for (lane, (prim, corners)) in triangles.enumerate() {
            block.prims[lane] = prim;
            for (row, v) in block.rows.iter_mut().zip(corners.as_flattened()) {
                row[lane] = *v;
            }
        }
        // Copies of a triangle in the lanes left over never need double precision for themselves.
        for row in &mut block.rows {
            let first = row[0];
            row[count..].fill(first);
        }
        block
    }

    #[inline(always)]
    pub(crate) fn prim(&self, lane: usize) -> u32 {
        self.prims[lane % BLOCK]
    }

    /// Triangles in this block.
    pub(crate) fn count(&self) -> usize {
        self.prims.iter().filter(|&&p| p != NO_TRIANGLE).count()
    }

    /// The corners of a lane.
    fn corners(&self, lane: usize) -> [[f32; 3]; 3] {
        let [a, b, c] = [0, 3, 6].map(|r| [r, r + 1, r + 2].map(|r| self.rows[r][lane % BLOCK]));
        [a, b, c]
    }

    /// The lanes hit at `0 < t`, with `t <= t_max`: whether equality counts is for the caller.
    #[inline(always)]
    pub(crate) fn intersect(&self, ray: &PreparedRay, t_max: f32) -> Option<BlockHits> {
        let row =
            |corner: usize, i: usize| F32x8::load(&self.rows[(3 * corner + ray.axes[i]).min(8)]);
        let [sx, sy, sz] = ray.shear;
        let sheared = |corner| {
            let z = row(corner, 2) - ray.o[2];
            let x = sx.neg_mul_add(z, row(corner, 0) - ray.o[0]);
            let y = sy.neg_mul_add(z, row(corner, 1) - ray.o[1]);
            (x, y, z)
        };
        let (ax, ay, az) = sheared(0);
        let (bx, by, bz) = sheared(1);
        let (cx, cy, cz) = sheared(2);
        let u = difference(cx, by, cy, bx);
        let v = difference(ax, cy, ay, cx);
        let w = difference(bx, ay, by, ax);
        let trusted = ray.min_edge.le(u.abs().min(v.abs()).min(w.abs()));
        let inside = !u.differing_signs(v, w);
        let candidates = (inside | !trusted) & 0xff;
        if candidates == 0 {
            return None;
        }

        let inv_det = F32x8::splat(1.0) / (u + v + w);
        let (b0, b1, b2) = (u * inv_det, v * inv_det, w * inv_det);
        let t = b0.mul_add(az, b1.mul_add(bz, b2 * cz)) * sz;

        // The box of each triangle, exactly as a node would test it.
        let slab = |i: usize| {
            let [a, b, c] = [row(0, i), row(1, i), row(2, i)];
            let near = |p: F32x8| p.mul_add(ray.inv_d[i], ray.near_c[i]);
            let far = |p: F32x8| p.mul_add(ray.inv_d[i], ray.far_c[i]);
            (near(a).min(near(b)).min(near(c)), far(a).max(far(b)).max(far(c)))
        };
        let ((x0, x1), (y0, y1), (z0, z1)) = (slab(0), slab(1), slab(2));
        let zero = F32x8::splat(0.0);
        let entry = x0.max(y0).max(z0.max(zero));
        let exit = x1.min(y1).min(z1);
        let slack = F32x8::splat(SLACK);
        let late = z0.min(zero).neg_mul_add(slack, exit.mul_add(slack, exit));
        let t = t.min(exit).max(entry);

        let limit = F32x8::splat(t_max);
        let mut lanes = candidates & trusted & entry.le(late) & zero.lt(t) & t.le(limit);
        let mut hits =
            BlockHits { lanes, t: t.to_array(), b: [b0.to_array(), b1.to_array(), b2.to_array()] };
        let mut doubtful = candidates & !trusted;
        if doubtful != 0 {
            while doubtful != 0 {
                let lane = doubtful.trailing_zeros() as usize;
                doubtful &= doubtful - 1;
                if self.prims[lane] == NO_TRIANGLE {
                    continue;
                }
                if let Some(hit) = intersect_in_double(&self.corners(lane), ray)
                    && hit.t <= t_max
                {
                    lanes |= 1 << lane;
                    hits.t[lane] = hit.t;
                    for (b, v) in hits.b.iter_mut().zip(hit.b) {
                        b[lane] = v;
                    }
                }
            }
        }
        // Lanes left over repeat the first triangle.
        if lanes & !1 != 0 {
            let empty =
                (0..BLOCK).fold(0, |m, i| m | (u32::from(self.prims[i] == NO_TRIANGLE) << i));
            lanes &= !empty;
        }
        hits.lanes = lanes;
        (lanes != 0).then_some(hits)
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
    let first = |v: F32x8| v.to_array()[0];
    let [kx, ky, kz] = ray.axes;
    let ([ox, oy, oz], [sx, sy, sz]) = (ray.o.map(first), ray.shear.map(first));
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
    let (entry, exit, late) = own_box(corners, ray);
    let t = (t as f32).min(exit).max(entry);
    (entry <= late && t > 0.0).then_some(LaneHit { t, b: b64.map(|v| v as f32) })
}

/// Entry into the box of a triangle, exit from it, and the exit with the slack of the box test.
fn own_box(corners: &[[f32; 3]; 3], ray: &PreparedRay) -> (f32, f32, f32) {
    let first = |v: F32x8| v.to_array()[0];
    let (mut entry, mut exit, mut behind) = (0f32, f32::INFINITY, 0f32);
    for i in 0..3 {
        let inv_d = first(ray.inv_d[i]);
        let p = corners.map(|p| p[ray.axes[i]]);
        let near = p.map(|p| p.mul_add(inv_d, first(ray.near_c[i])));
        let far = p.map(|p| p.mul_add(inv_d, first(ray.far_c[i])));
        let near = near[0].min(near[1]).min(near[2]);
        entry = entry.max(near);
        exit = exit.min(far[0].max(far[1]).max(far[2]));
        if i == 2 {
            behind = near.min(0.0);
        }
    }
    (entry, exit, (-behind).mul_add(SLACK, exit.mul_add(SLACK, exit)))
}

/// The scalar twin of [`TriangleBlock::intersect`]: the same operations on one triangle.
#[cfg(test)]
pub(crate) fn intersect_one(corners: &[[f32; 3]; 3], ray: &PreparedRay) -> Option<LaneHit> {
    use kaustika_math::diff_of_products;
    let first = |v: F32x8| v.to_array()[0];
    let [kx, ky, kz] = ray.axes;
    let ([ox, oy, oz], [sx, sy, sz]) = (ray.o.map(first), ray.shear.map(first));
    let [a, b, c] = corners.map(|p| {
        let z = p[kz] - oz;
        [(-sx).mul_add(z, p[kx] - ox), (-sy).mul_add(z, p[ky] - oy), z]
    });
    let u = diff_of_products(c[0], b[1], c[1], b[0]);
    let v = diff_of_products(a[0], c[1], a[1], c[0]);
    let w = diff_of_products(b[0], a[1], b[1], a[0]);
    let least = first(ray.min_edge);
    if ![u, v, w].iter().all(|e| e.abs() >= least) {
        return intersect_in_double(corners, ray);
    }
    if (u > 0.0) != (v > 0.0) || (u > 0.0) != (w > 0.0) {
        return None;
    }
    let inv_det = 1.0 / (u + v + w);
    let bary = [u * inv_det, v * inv_det, w * inv_det];
    let t = bary[0].mul_add(a[2], bary[1].mul_add(b[2], bary[2] * c[2])) * sz;
    let (entry, exit, late) = own_box(corners, ray);
    let t = t.min(exit).max(entry);
    (entry <= late && t > 0.0).then_some(LaneHit { t, b: bary })
}
