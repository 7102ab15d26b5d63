//! How the shading normal turns along a surface.
//!
//! ```text
//! n = N / |N|,    ∂n/∂d = (∂N/∂d - n (n · ∂N/∂d)) / |N|                                     (1)
//! triangle   N = Σ bᵢ nᵢ            sphere   N = p            cylinder   N = (x, y, 0)
//! ```
//!
//! N is linear in the point, and stays so under a transform.

use crate::geometry::Geometry;
use crate::shape::{Quadric, QuadricForm, TriangleStore};
use crate::surface::Surface;
use kaustika_math::Vec3;

impl Geometry {
    /// The derivative of the interpolated shading normal where the point of a surface moves along its
    /// tangent `d`, world space, a unit of length; `None` of curves and distance grids.
    pub fn normal_along(&self, s: &Surface, d: Vec3) -> Option<Vec3> {
        let to_world = s.instance.map(|i| self.instances[i as usize].at(s.time));
        let (p, d) = match &to_world {
            None => (s.p, d),
            Some(t) => (t.inverse().point(s.p), t.inverse().vector(d)),
        };
        let (n, dn) = match s.triangle {
            u32::MAX => self.quadrics.get(s.analytic as usize)?.normal_along(p, d),
            triangle => self.triangles.normal_along(triangle, s, d),
        };
        let (n, dn) = match &to_world {
            None => (n, dn),
            Some(t) => (t.normal(n), t.normal(dn)),
        };
        // (1), on the side of the shading normal.
        let length = n.length().copysign(n.dot(s.ns));
        let dn = dn / length;
        (length != 0.0).then(|| dn - s.ns * s.ns.dot(dn))
    }
}

impl Quadric {
    /// N and its derivative, in the space of the group.
    fn normal_along(&self, p: Vec3, d: Vec3) -> (Vec3, Vec3) {
        let own = self.to_world.inverse();
        let of = |v: Vec3| match self.form {
            QuadricForm::Sphere { .. } => v,
            QuadricForm::Cylinder { .. } => Vec3::new(v.x, v.y, 0.0),
            QuadricForm::Disk { .. } => Vec3::ZERO,
        };
        let n = match self.form {
            QuadricForm::Disk { .. } => Vec3::Z,
            _ => of(own.point(p)),
        };
        (self.to_world.normal(n), self.to_world.normal(of(own.vector(d))))
    }
}

impl TriangleStore {
    /// N and its derivative.
    fn normal_along(&self, triangle: u32, s: &Surface, d: Vec3) -> (Vec3, Vec3) {
        if !self.mesh(triangle).has_normals {
            return (s.ng, Vec3::ZERO);
        }
        let [p0, p1, p2] = self.corners(triangle);
        let [n0, n1, n2] = self.indices[triangle as usize].map(|i| self.normals[i as usize]);
        // d = e₁ b₁ + e₂ b₂, by the normal equations.
        let (e1, e2) = (p1 - p0, p2 - p0);
        let (a, b, c) = (e1.dot(e1), e1.dot(e2), e2.dot(e2));
        let (x, y) = (e1.dot(d), e2.dot(d));
        let det = kaustika_math::diff_of_products(a, c, b, b);
        let (b1, b2) = ((c * x - b * y) / det, (a * y - b * x) / det);
        let [w1, w2] = [s.barycentrics.x, s.barycentrics.y];
        let n = n0 * (1.0 - w1 - w2) + n1 * w1 + n2 * w2;
        (n, (n1 - n0) * b1 + (n2 - n0) * b2)
    }
}
