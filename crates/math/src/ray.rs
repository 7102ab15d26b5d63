//! Rays, and origins that rounding cannot put on the wrong side of their surface.

use crate::{Vec3, gamma};

/// A half-line `o + t d`. `d` need not be unit: `t` is in units of its length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Origin.
    pub o: Vec3,
    /// Direction.
    pub d: Vec3,
    /// Shutter time in [0, 1].
    pub time: f32,
}

impl Ray {
    /// A ray at time zero.
    #[inline]
    pub fn new(o: Vec3, d: Vec3) -> Ray {
        Ray { o, d, time: 0.0 }
    }

    /// The point at parameter `t`.
    #[inline]
    pub fn at(&self, t: f32) -> Vec3 {
        self.o + self.d * t
    }
}

/// `p` moved off its surface along the normal `n`, to the side that `d` points to, by no more
/// than its error bound `p_error` needs (Pharr, Jakob & Humphreys 2023, sec. 6.8.6).
#[inline]
pub fn offset_origin(p: Vec3, p_error: Vec3, n: Vec3, d: Vec3) -> Vec3 {
    let reach = n.abs().dot(p_error);
    let offset = if d.dot(n) < 0.0 { n * -reach } else { n * reach };
    let q = p + offset;
    // Each coordinate further from p by one or two units in the last place (|q| ε is at least
    // one), so that the sum's own rounding cannot bring it back. Without branches; where q is 0
    // or subnormal the sum was exact.
    let away = |q: f32, o: f32| {
        let moved = q + (q.abs() * f32::EPSILON).copysign(o);
        if o == 0.0 { q } else { moved }
    };
    Vec3::new(away(q.x, offset.x), away(q.y, offset.y), away(q.z, offset.z))
}

/// Error bound of a point interpolated in a triangle with corners `p` at barycentric weights
/// `b`, for the origin of a ray that must not meet the same triangle again.
///
/// γ₇ Σ|bᵢ pᵢ| bounds the point's own rounding (Pharr et al. 2023, sec. 6.8.5); the term in the
/// triangle's extent bounds the error of the distance at which an intersection test, which works
/// with corners relative to the ray's origin, sees the triangle's plane (sec. 6.8.7). Without it
/// a large triangle in a coordinate plane, whose points are almost exact, meets its own rays.
#[inline]
pub fn triangle_point_error(p: [Vec3; 3], b: [f32; 3]) -> Vec3 {
    let rounding = ((p[0] * b[0]).abs() + (p[1] * b[1]).abs() + (p[2] * b[2]).abs()) * gamma(7);
    let extent = (p[1] - p[0]).abs().max((p[2] - p[0]).abs()).max_component();
    rounding + Vec3::splat(extent * gamma(6))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::warp;
    use crate::{Vec2, mix_bits};

    /// Origins lie at least their offset away from the exact plane, on the side of `d`.
    #[test]
    fn origins_are_at_least_their_offset_away() {
        let mut key = 1;
        let mut u = || {
            key = mix_bits(key + 0x9e37_79b9_7f4a_7c15);
            (key >> 40) as f32 / 16_777_216.0
        };
        for i in 0..20_000 {
            let n = match i % 4 {
                0 => Vec3::Y,
                _ => warp::uniform_sphere(Vec2::new(u(), u())),
            };
            let d = warp::uniform_sphere(Vec2::new(u(), u()));
            let scale = 10f32.powf(12.0 * u() - 6.0);
            let p = (Vec3::new(u(), u(), u()) - Vec3::splat(0.5)) * scale;
            let p_error = p.abs() * gamma(3);
            let q = offset_origin(p, p_error, n, d);
            let reach = f64::from(n.abs().dot(p_error));
            for axis in 0..3 {
                let o = f64::from(n[axis]) * reach * if d.dot(n) < 0.0 { -1.0 } else { 1.0 };
                let moved = f64::from(q[axis]) - f64::from(p[axis]);
                // The product n·reach is itself rounded, by half a unit in its last place.
                assert!(moved * o.signum() >= o.abs() * (1.0 - 1e-7), "{p:?} {n:?} {moved} {o}");
                assert!(n[axis] != 0.0 || q[axis] == p[axis], "moved along an edge of the plane");
            }
        }
    }
}
