//! The arithmetic of the triangle test; the module `triangle` has its equations.
//!
//! Lanes are eight triangles and one ray, or one triangle and several rays: the operations are the
//! same, and so are the bits.

use kaustika_math::Vec3;

use crate::ray::{LATER, PreparedRay, RayLanes, margin};
use crate::simd::Lanes;

/// A hit of one lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LaneHit {
    pub(crate) t: f32,
    pub(crate) b: [f32; 3],
}

/// Hits side by side.
#[derive(Clone, Copy)]
pub(crate) struct LaneHits<V> {
    /// The lanes that are hit, one bit each.
    pub(crate) lanes: u32,
    pub(crate) t: V,
    pub(crate) b: [V; 3],
}

impl<V: Lanes> LaneHits<V> {
    pub(crate) fn set(&mut self, lane: usize, hit: &LaneHit) {
        let with = |v: V, x: f32| {
            let mut a = v.to_array();
            a.as_mut()[lane] = x;
            V::load(&a)
        };
        self.lanes |= 1 << lane;
        self.t = with(self.t, hit.t);
        self.b = [0, 1, 2].map(|i| with(self.b[i], hit.b[i]));
    }
}

/// Where rays enter and leave the boxes of triangles: as they are, and as nodes have them.
#[derive(Clone, Copy)]
pub(crate) struct Passages<V> {
    pub(crate) entry: V,
    pub(crate) exit: V,
    pub(crate) early: V,
    pub(crate) late: V,
}

/// Equation (1), and what it says of each lane.
pub(crate) struct Edges<V> {
    uvw: [V; 3],
    /// Of the corners, relative to the origin.
    z: [V; 3],
    /// The signs agree, and can be trusted.
    pub(crate) inside: u32,
    /// The signs can't be trusted.
    pub(crate) doubtful: u32,
}

impl<V: Lanes> Edges<V> {
    /// `row(corner, axis)` has the coordinates of the lanes.
    #[inline(always)]
    pub(crate) fn new(
        row: impl Fn(usize, usize) -> V,
        axes: [u8; 3],
        ray: &RayLanes<V>,
    ) -> Edges<V> {
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
        Edges { uvw: [u, v, w], z: [az, bz, cz], inside, doubtful: !trusted & V::ALL }
    }

    /// Equation (2), within the triangle's box, of the lanes inside.
    #[inline(always)]
    pub(crate) fn hits(&self, passages: &Passages<V>, inv_dz: V, t_max: V) -> LaneHits<V> {
        let [u, v, w] = self.uvw;
        let inv_det = V::splat(1.0) / (u + v + w);
        let b = [u * inv_det, v * inv_det, w * inv_det];
        let [az, bz, cz] = self.z;
        let t = b[0].mul_add(az, b[1].mul_add(bz, b[2] * cz)) * inv_dz;
        let Passages { entry, exit, early, late } = *passages;
        let t = t.min(exit).max(entry);
        let met = early.le(late * V::splat(LATER));
        LaneHits { lanes: self.inside & met & V::splat(0.0).lt(t) & t.le(t_max), t, b }
    }
}

/// a b - c d with an error below two units in the last place, so of the exact sign (Kahan; proof
/// by Jeannerod, Louvet & Muller 2013), unless c d underflows.
#[inline(always)]
fn difference<V: Lanes>(a: V, b: V, c: V, d: V) -> V {
    let cd = c * d;
    let error = c.neg_mul_add(d, cd);
    a.mul_sub(b, cd) + error
}

/// The test with equations (1) and (2) in double precision, for edge functions that single
/// precision cannot tell from zero. The shear is that of the vector test: the corners must be the
/// same for the neighbours of this triangle.
#[cold]
pub(crate) fn intersect_in_double(corners: &[[f32; 3]; 3], ray: &PreparedRay) -> Option<LaneHit> {
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

/// The scalar twin of [`TriangleBlock::intersect`](crate::triangle::TriangleBlock::intersect): the same operations on one triangle and one
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
