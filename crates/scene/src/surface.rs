//! A point on a surface with everything that shading asks for at every hit. What only some
//! materials ask for, the directions in which u and v grow, is computed by
//! [`Geometry::tangents`](crate::geometry::Geometry::tangents).

use kaustika_math::{Ray, Vec2, Vec3, ray::offset_origin};

/// Index of a light in the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LightId(pub u32);

/// Where a ray met a surface.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// The point, world space.
    pub p: Vec3,
    /// Bound of its rounding error along each axis.
    pub p_error: Vec3,
    /// Distance along the ray in units of its direction's length.
    pub t: f32,
    /// Geometric normal, unit; on the front side.
    pub ng: Vec3,
    /// Shading normal, unit: interpolated, on the side of `ng` where the mesh is consistent.
    pub ns: Vec3,
    /// Surface parameters.
    pub uv: Vec2,
    /// Width of the region this point stands for, in world units; 0 if unknown. Textures filter
    /// over it.
    pub footprint: f32,
    /// Index of the shape in the scene's list.
    pub shape: u32,
    /// Index of the triangle in the scene's list; `u32::MAX` for analytic shapes.
    pub triangle: u32,
    /// Number of the analytic shape, pieces of curves after quadrics; `u32::MAX` for triangles.
    pub analytic: u32,
    /// Through which instance it was met.
    pub instance: Option<u32>,
    /// Barycentric weights of the triangle's corners 1 and 2.
    pub barycentrics: Vec2,
    /// The light that the shape is part of.
    pub light: Option<LightId>,
    /// Shutter time.
    pub time: f32,
}

impl Surface {
    /// The geometric normal on the side of `w`.
    #[inline]
    pub fn facing(&self, w: Vec3) -> Vec3 {
        if self.ng.dot(w) < 0.0 { -self.ng } else { self.ng }
    }

    /// A ray from here along `d`, safe from meeting this surface again.
    #[inline]
    pub fn spawn(&self, d: Vec3) -> Ray {
        Ray { o: offset_origin(self.p, self.p_error, self.ng, d), d, time: self.time }
    }

    /// A ray from here to `q` (a point of another surface or none); it covers the distance in
    /// t in [0, 1).
    #[inline]
    pub fn spawn_to(&self, q: Vec3) -> Ray {
        let o = offset_origin(self.p, self.p_error, self.ng, q - self.p);
        Ray { o, d: q - o, time: self.time }
    }
}
