//! Vectors of two and three `f32`.

use std::ops::{Add, AddAssign, Div, Index, IndexMut, Mul, MulAssign, Neg, Sub, SubAssign};

/// A point or vector in the plane: uv coordinates, samples, positions on the film.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Vec2 {
    /// First coordinate.
    pub x: f32,
    /// Second coordinate.
    pub y: f32,
}

/// A point, vector or normal in space; [`crate::Transform`] tells the three apart.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Vec3 {
    /// First coordinate.
    pub x: f32,
    /// Second coordinate.
    pub y: f32,
    /// Third coordinate.
    pub z: f32,
}

macro_rules! componentwise {
    ($T:ident { $($c:ident),+ }) => {
        impl Add for $T { type Output = $T; #[inline] fn add(self, o: $T) -> $T { $T { $($c: self.$c + o.$c),+ } } }
        impl Sub for $T { type Output = $T; #[inline] fn sub(self, o: $T) -> $T { $T { $($c: self.$c - o.$c),+ } } }
        /// Componentwise.
        impl Mul for $T { type Output = $T; #[inline] fn mul(self, o: $T) -> $T { $T { $($c: self.$c * o.$c),+ } } }
        impl Mul<f32> for $T { type Output = $T; #[inline] fn mul(self, s: f32) -> $T { $T { $($c: self.$c * s),+ } } }
        impl Mul<$T> for f32 { type Output = $T; #[inline] fn mul(self, v: $T) -> $T { v * self } }
        impl Div<f32> for $T { type Output = $T; #[inline] fn div(self, s: f32) -> $T { self * (1.0 / s) } }
        impl Neg for $T { type Output = $T; #[inline] fn neg(self) -> $T { $T { $($c: -self.$c),+ } } }
        impl AddAssign for $T { #[inline] fn add_assign(&mut self, o: $T) { *self = *self + o; } }
        impl SubAssign for $T { #[inline] fn sub_assign(&mut self, o: $T) { *self = *self - o; } }
        impl MulAssign<f32> for $T { #[inline] fn mul_assign(&mut self, s: f32) { *self = *self * s; } }
        impl $T {
            /// All components equal to `v`.
            #[inline] pub const fn splat(v: f32) -> $T { $T { $($c: v),+ } }
            /// The zero vector.
            pub const ZERO: $T = $T::splat(0.0);
            /// Componentwise minimum.
            #[inline] pub fn min(self, o: $T) -> $T { $T { $($c: self.$c.min(o.$c)),+ } }
            /// Componentwise maximum.
            #[inline] pub fn max(self, o: $T) -> $T { $T { $($c: self.$c.max(o.$c)),+ } }
            /// Componentwise absolute value.
            #[inline] pub fn abs(self) -> $T { $T { $($c: self.$c.abs()),+ } }
            /// Scalar product.
            #[inline] pub fn dot(self, o: $T) -> f32 { 0.0 $(+ self.$c * o.$c)+ }
            /// Squared length.
            #[inline] pub fn length_squared(self) -> f32 { self.dot(self) }
            /// Length.
            #[inline] pub fn length(self) -> f32 { self.length_squared().sqrt() }
            /// The unit vector in this direction; not finite for the zero vector.
            #[inline] pub fn normalize(self) -> $T { self * (1.0 / self.length()) }
            /// True if no component is NaN or infinite.
            #[inline] pub fn is_finite(self) -> bool { true $(&& self.$c.is_finite())+ }
            /// (1-t)·self + t·o.
            #[inline] pub fn lerp(self, o: $T, t: f32) -> $T { self * (1.0 - t) + o * t }
        }
    };
}
componentwise!(Vec2 { x, y });
componentwise!(Vec3 { x, y, z });

impl Vec2 {
    /// From coordinates.
    #[inline]
    pub const fn new(x: f32, y: f32) -> Self {
        Vec2 { x, y }
    }
}

impl Vec3 {
    /// The first axis.
    pub const X: Vec3 = Vec3::new(1.0, 0.0, 0.0);
    /// The second axis.
    pub const Y: Vec3 = Vec3::new(0.0, 1.0, 0.0);
    /// The third axis.
    pub const Z: Vec3 = Vec3::new(0.0, 0.0, 1.0);

    /// From coordinates.
    #[inline]
    pub const fn new(x: f32, y: f32, z: f32) -> Self {
        Vec3 { x, y, z }
    }

    /// Vector product.
    #[inline]
    pub fn cross(self, o: Vec3) -> Vec3 {
        use crate::diff_of_products as dop;
        Vec3::new(
            dop(self.y, o.z, self.z, o.y),
            dop(self.z, o.x, self.x, o.z),
            dop(self.x, o.y, self.y, o.x),
        )
    }

    /// |self · o|.
    #[inline]
    pub fn abs_dot(self, o: Vec3) -> f32 {
        self.dot(o).abs()
    }

    /// The unit vector in this direction, or `None` if the length is zero or not finite.
    #[inline]
    pub fn try_normalize(self) -> Option<Vec3> {
        let l2 = self.length_squared();
        (l2 > 0.0 && l2.is_finite()).then(|| self * (1.0 / l2.sqrt()))
    }

    /// This vector, flipped if needed into the hemisphere of `v`.
    #[inline]
    pub fn face_forward(self, v: Vec3) -> Vec3 {
        if self.dot(v) < 0.0 { -self } else { self }
    }

    /// Largest component.
    #[inline]
    pub fn max_component(self) -> f32 {
        self.x.max(self.y).max(self.z)
    }

    /// Index of the largest component.
    #[inline]
    pub fn max_axis(self) -> usize {
        if self.x > self.y {
            if self.x > self.z { 0 } else { 2 }
        } else if self.y > self.z {
            1
        } else {
            2
        }
    }

    /// Two unit vectors that complete the unit vector `self` to a right-handed orthonormal
    /// basis (s, t, self) (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
    #[inline]
    pub fn coordinate_system(self) -> (Vec3, Vec3) {
        let sign = 1f32.copysign(self.z);
        let a = -1.0 / (sign + self.z);
        let b = self.x * self.y * a;
        (
            Vec3::new(1.0 + sign * self.x * self.x * a, sign * b, -sign * self.x),
            Vec3::new(b, sign + self.y * self.y * a, -self.y),
        )
    }
}

impl From<[f32; 3]> for Vec3 {
    #[inline]
    fn from(a: [f32; 3]) -> Self {
        Vec3::new(a[0], a[1], a[2])
    }
}

impl From<Vec3> for [f32; 3] {
    #[inline]
    fn from(v: Vec3) -> Self {
        [v.x, v.y, v.z]
    }
}

impl From<[f32; 2]> for Vec2 {
    #[inline]
    fn from(a: [f32; 2]) -> Self {
        Vec2::new(a[0], a[1])
    }
}

impl Index<usize> for Vec3 {
    type Output = f32;
    #[inline]
    fn index(&self, i: usize) -> &f32 {
        match i {
            0 => &self.x,
            1 => &self.y,
            _ => &self.z,
        }
    }
}

impl IndexMut<usize> for Vec3 {
    #[inline]
    fn index_mut(&mut self, i: usize) -> &mut f32 {
        match i {
            0 => &mut self.x,
            1 => &mut self.y,
            _ => &mut self.z,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinate_systems_are_right_handed_and_orthonormal() {
        for i in 0..1000 {
            let z = i as f32 / 499.5 - 1.0;
            let phi = i as f32 * 2.399_963;
            let r = (1.0 - z * z).max(0.0).sqrt();
            let n = Vec3::new(r * phi.cos(), r * phi.sin(), z);
            let (s, t) = n.coordinate_system();
            assert!(s.dot(t).abs() < 1e-6 && s.dot(n).abs() < 1e-6 && t.dot(n).abs() < 1e-6);
            assert!((s.cross(t) - n).length() < 1e-5);
        }
    }
}
