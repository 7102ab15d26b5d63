//! What the hierarchy of lights knows of each kind of light.

use super::bvh::LightBounds;
use super::cone::Cone;
use super::{AreaLight, AreaShape, Light, mean_power};
use crate::Scene;
use crate::shape::QuadricForm;
use kaustika_math::{Bounds3, Transform, Vec2, Vec3};
use std::f32::consts::PI;

impl Light {
    /// Where and whereto the light emits; `None` for lights at infinity. The peak intensity is
    /// the power over what a light of its form emits at a peak intensity of 1.
    pub(super) fn bounds(&self, scene: &Scene) -> Option<LightBounds> {
        // (bounds, cone of normals, emission beyond it, ∫ intensity / peak dω, two-sided)
        let point = |p: Vec3| Bounds3::of_points([p]);
        let pyramid = |to_world: &Transform, [tan_x, tan_y]: [f32; 2]| {
            let axis = to_world.vector(Vec3::Z).normalize();
            let corner = (1.0 + tan_x * tan_x + tan_y * tan_y).sqrt();
            let cone = Cone { axis, cos: 1.0 / corner };
            let (sx, sy) = (tan_x.atan().sin(), tan_y.atan().sin());
            let solid_angle = 4.0 * (sx * sy).asin();
            (point(to_world.point(Vec3::ZERO)), cone, 0.0, solid_angle, false)
        };
        let (bounds, cone, emission, solid_angle, two_sided) = match self {
            Light::Environment(_) | Light::Directional(_) => return None,
            // Chosen as little as can be: asking them brings nothing.
            Light::Beam(l) => (point(l.p), Cone::around(l.direction), 0.0, f32::INFINITY, false),
            Light::NormalArea(l) => {
                let (bounds, cone, _) = l.0.extent(scene);
                (bounds, cone, 0.0, f32::INFINITY, false)
            }
            Light::Area(area) => {
                let sides = if area.two_sided { 2.0 } else { 1.0 };
                let (bounds, cone, solid_angle) = area.extent(scene);
                (bounds, cone, 0.5 * PI, sides * solid_angle, area.two_sided)
            }
            Light::Point(l) => (point(l.p), Cone::ALL, 0.5 * PI, 4.0 * PI, false),
            Light::Goniometric(l) => {
                (point(l.to_world.point(Vec3::ZERO)), Cone::ALL, 0.5 * PI, 4.0 * PI, false)
            }
            Light::Spot(l) => {
                let axis = l.to_world.vector(Vec3::Z).normalize();
                // Full intensity within the beam; what lies beyond counts as falling off, over
                // a right angle at most.
                let beam = l.beam_width.max(l.cutoff - 0.5 * PI);
                let cone = Cone { axis, cos: beam.cos() };
                let emission = (l.cutoff - beam).max(0.0);
                (point(l.to_world.point(Vec3::ZERO)), cone, emission, l.solid_angle(), false)
            }
            Light::Projection(l) => pyramid(&l.to_world, [l.tan_x, l.tan_y]),
            Light::Projector(l) => pyramid(&l.to_world, l.tan),
        };
        Some(LightBounds {
            bounds,
            cone,
            // A little more than what is emitted, against rounding.
            cos_emission: (emission.cos() - 1e-5).max(0.0),
            intensity: mean_power(self, scene) / solid_angle.max(1e-6),
            two_sided,
        })
    }
}

impl AreaLight {
    /// Box, cone of normals, and power of one side over peak intensity: π for flat shapes (the
    /// cosine's integral), π² for cylinders, 4π for spheres.
    fn extent(&self, scene: &Scene) -> (Bounds3, Cone, f32) {
        let g = &scene.geometry;
        match self.shape {
            AreaShape::Triangle(i, _) => {
                let n = g.triangles.sample(i, Vec2::splat(0.5)).n;
                (Bounds3::of_points(g.triangles.corners(i)), Cone::around(n), PI)
            }
            AreaShape::Quadric(i) | AreaShape::Sphere(i, ..) => {
                let quadric = &g.quadrics[i as usize];
                let (cone, solid_angle) = match quadric.form {
                    QuadricForm::Disk { .. } => {
                        (Cone::around(quadric.sample(Vec2::splat(0.5)).0.n), PI)
                    }
                    QuadricForm::Cylinder { .. } => (Cone::ALL, PI * PI),
                    QuadricForm::Sphere { .. } => (Cone::ALL, 4.0 * PI),
                };
                (quadric.bounds(), cone, solid_angle)
            }
        }
    }
}
