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
    // Round each coordinate away from p, so that the sum itself cannot fall back.
    let away = |q: f32, o: f32| {
        if o > 0.0 {
            q.next_up()
        } else if o < 0.0 {
            q.next_down()
        } else {
            q
        }
    };
    Vec3::new(away(q.x, offset.x), away(q.y, offset.y), away(q.z, offset.z))
}

/// Error bound of a point interpolated in a triangle with corners `p0`, `p1`, `p2` at
/// barycentric weights `b0`, `b1`, `b2`: γ₇ Σ|bᵢ pᵢ| (Pharr et al. 2023, sec. 6.8.5).
#[inline]
pub fn triangle_point_error(p: [Vec3; 3], b: [f32; 3]) -> Vec3 {
    ((p[0] * b[0]).abs() + (p[1] * b[1]).abs() + (p[2] * b[2]).abs()) * gamma(7)
}
