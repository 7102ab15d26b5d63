//! Axis-aligned boxes.

use crate::Vec3;

/// An axis-aligned box; empty when `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Bounds3 {
    /// Least corner.
    pub min: Vec3,
    /// Greatest corner.
    pub max: Vec3,
}

impl Default for Bounds3 {
    fn default() -> Self {
        Bounds3::EMPTY
    }
}

impl Bounds3 {
    /// The box that holds nothing.
    pub const EMPTY: Bounds3 =
        Bounds3 { min: Vec3::splat(f32::INFINITY), max: Vec3::splat(f32::NEG_INFINITY) };

    /// The smallest box around two points.
    #[inline]
    pub fn new(a: Vec3, b: Vec3) -> Bounds3 {
        Bounds3 { min: a.min(b), max: a.max(b) }
    }

    /// The smallest box around some points.
    pub fn of_points(points: impl IntoIterator<Item = Vec3>) -> Bounds3 {
        points.into_iter().fold(Bounds3::EMPTY, |b, p| b.with_point(p))
    }

    /// Enlarged to hold `p`.
    #[inline]
    pub fn with_point(self, p: Vec3) -> Bounds3 {
        Bounds3 { min: self.min.min(p), max: self.max.max(p) }
    }

    /// The smallest box around both.
    #[inline]
    pub fn union(self, o: Bounds3) -> Bounds3 {
        Bounds3 { min: self.min.min(o.min), max: self.max.max(o.max) }
    }

    /// The common part, possibly empty.
    #[inline]
    pub fn intersection(self, o: Bounds3) -> Bounds3 {
        Bounds3 { min: self.min.max(o.min), max: self.max.min(o.max) }
    }

    /// True if it holds nothing.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.min.x > self.max.x || self.min.y > self.max.y || self.min.z > self.max.z
    }

    /// Extent along each axis.
    #[inline]
    pub fn diagonal(&self) -> Vec3 {
        self.max - self.min
    }

    /// Midpoint.
    #[inline]
    pub fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// Half the surface area, the quantity the surface area heuristic compares; 0 if empty.
    #[inline]
    pub fn half_area(&self) -> f32 {
        if self.is_empty() {
            return 0.0;
        }
        let d = self.diagonal();
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    /// Corner `i` of eight: bit 0 chooses x, bit 1 y, bit 2 z.
    #[inline]
    pub fn corner(&self, i: usize) -> Vec3 {
        Vec3::new(
            if i & 1 == 0 { self.min.x } else { self.max.x },
            if i & 2 == 0 { self.min.y } else { self.max.y },
            if i & 4 == 0 { self.min.z } else { self.max.z },
        )
    }

    /// True if `p` is inside or on the border.
    #[inline]
    pub fn contains(&self, p: Vec3) -> bool {
        p.x >= self.min.x
            && p.x <= self.max.x
            && p.y >= self.min.y
            && p.y <= self.max.y
            && p.z >= self.min.z
            && p.z <= self.max.z
    }

    /// Centre and radius of the sphere through the corners.
    pub fn bounding_sphere(&self) -> (Vec3, f32) {
        if self.is_empty() {
            return (Vec3::ZERO, 0.0);
        }
        let c = self.center();
        (c, (self.max - c).length())
    }

    /// Where the ray `o + t d` is inside, `None` if never for t in [0, t_max].
    pub fn intersect(&self, o: Vec3, d: Vec3, t_max: f32) -> Option<(f32, f32)> {
        let (mut t0, mut t1) = (0f32, t_max);
        for axis in 0..3 {
            let inv = 1.0 / d[axis];
            let mut near = (self.min[axis] - o[axis]) * inv;
            let mut far = (self.max[axis] - o[axis]) * inv;
            if near > far {
                std::mem::swap(&mut near, &mut far);
            }
            // Rounded outward, so that a ray along a face is not lost (Ize 2013).
            far *= 1.0 + 2.0 * crate::gamma(3);
            t0 = if near > t0 { near } else { t0 };
            t1 = if far < t1 { far } else { t1 };
            if t0 > t1 {
                return None;
            }
        }
        Some((t0, t1))
    }
}
