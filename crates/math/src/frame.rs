//! Orthonormal frames.

use crate::Vec3;

/// A right-handed orthonormal basis; in its coordinates the normal `n` is the third axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First tangent.
    pub s: Vec3,
    /// Second tangent.
    pub t: Vec3,
    /// Normal.
    pub n: Vec3,
}

impl Frame {
    /// Some frame with normal `n` (unit).
    #[inline]
    pub fn from_normal(n: Vec3) -> Frame {
        let (s, t) = n.coordinate_system();
        Frame { s, t, n }
    }

    /// The frame with normal `n` (unit) whose first tangent is as near to `tangent` as can be
    /// (Gram-Schmidt); any frame with that normal if the two are parallel or `tangent` is zero.
    #[inline]
    pub fn from_normal_tangent(n: Vec3, tangent: Vec3) -> Frame {
        let s = tangent - n * n.dot(tangent);
        // A tangent that is nearly parallel to the normal says nothing about direction.
        if s.length_squared() <= 1e-10 * tangent.length_squared() {
            return Frame::from_normal(n);
        }
        match s.try_normalize() {
            Some(s) => Frame { s, t: n.cross(s), n },
            None => Frame::from_normal(n),
        }
    }

    /// World to local coordinates.
    #[inline]
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.s), v.dot(self.t), v.dot(self.n))
    }

    /// Local to world coordinates.
    #[inline]
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.s * v.x + self.t * v.y + self.n * v.z
    }

    /// The frame of the other side: normal reversed, first tangent kept.
    #[inline]
    pub fn flipped(&self) -> Frame {
        Frame { s: self.s, t: -self.t, n: -self.n }
    }
}
