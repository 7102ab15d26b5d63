//! Meters: sensors that measure radiance along a line, irradiance on a surface, or the light that
//! goes far away in one direction. Every pixel of their film measures the same thing, but for
//! irradiance on a rectangle, whose pixels lie side by side.
//!
//! ```text
//! E = (1/A) ∫ ∫ L cos θ dω dA = mean of L π / (A p_A),  directions by p_ω = cos θ / π       (1)
//! Φ = A E                                                                                  (2)
//! L̄ = (1/A) ∫ L dA = mean of L / (A p_A)                                                   (3)
//! ```

use super::CameraRay;
use crate::description::{GeometryDesc, MeterTarget, ShapeDesc};
use crate::geometry::Geometry;
use crate::shape::{Quadric, ShapeSample};
use kaustika_math::ray::offset_origin;
use kaustika_math::{Frame, ONE_MINUS_EPSILON, Ray, Transform, Vec2, Vec3, gamma, warp};
use kaustika_sampling::distribution::Discrete;
use std::f32::consts::PI;

/// A sensor that is no camera.
#[derive(Clone, Debug)]
pub struct Meter {
    kind: Kind,
    resolution: Vec2,
    /// Where it stands, about.
    position: Vec3,
    /// See [`super::Camera::up`].
    up: Vec3,
}

#[derive(Clone, Debug)]
enum Kind {
    /// Along one ray.
    Radiance(Ray),
    /// (1), times a factor: 1, or A for (2).
    Irradiance(Patch, f32),
    /// (3) along `d`, from points `back` before those of a patch.
    Distant { d: Vec3, back: f32, target: Target },
}

#[derive(Clone, Debug)]
enum Target {
    Point(Vec3),
    /// The disc of this radius across the direction.
    Disc(Vec3, f32),
    Patch(Patch),
}

/// A surface of the scene to choose points of.
#[derive(Clone, Debug)]
struct Patch {
    form: Form,
    area: f32,
}

#[derive(Clone, Debug)]
enum Form {
    /// Corner and sides; film positions run along them.
    Rectangle {
        corner: Vec3,
        sides: [Vec3; 2],
        n: Vec3,
    },
    /// Corners and normals, and probabilities by area.
    Triangles(Vec<([Vec3; 3], Vec3)>, Discrete),
    Quadric(Box<Quadric>),
}

impl Meter {
    /// Radiance along +z of the sensor's space.
    pub fn radiance(to_world: &Transform, resolution: [u32; 2]) -> Meter {
        let o = to_world.point(Vec3::ZERO);
        let d = to_world.vector(Vec3::Z).normalize();
        let kind = Kind::Radiance(Ray::new(o, d));
        Meter { kind, resolution: pixels(resolution), position: o, up: to_world.vector(Vec3::Y) }
    }

    /// Irradiance on a shape, or the flux that it receives; `None` if it has no area.
    pub fn irradiance(
        shape: (u32, &ShapeDesc),
        flux: bool,
        geometry: &Geometry,
        resolution: [u32; 2],
    ) -> Option<Meter> {
        let patch = Patch::new(shape, geometry)?;
        let position = patch.sample(Vec2::splat(0.5)).0.p;
        let factor = if flux { patch.area } else { 1.0 };
        let kind = Kind::Irradiance(patch, factor);
        Some(Meter { kind, resolution: pixels(resolution), position, up: Vec3::ZERO })
    }

    /// Radiance that arrives along +z of the sensor's space from beyond the scene, averaged over
    /// a target; `None` if that has no area.
    pub fn distant(
        to_world: &Transform,
        target: &MeterTarget,
        geometry: &Geometry,
        resolution: [u32; 2],
    ) -> Option<Meter> {
        let (center, radius) = geometry.bounds().bounding_sphere();
        let d = to_world.vector(Vec3::Z).normalize();
        let target = match target {
            MeterTarget::Scene => Target::Disc(center, radius),
            MeterTarget::Point(p) => Target::Point(*p),
            MeterTarget::Rectangle(t) => Target::Patch(Patch::rectangle(t)?),
        };
        let back = 2.0 * radius.max(1e-3);
        let kind = Kind::Distant { d, back, target };
        let up = to_world.vector(Vec3::Y);
        Some(Meter { kind, resolution: pixels(resolution), position: center, up })
    }

    /// See [`super::Camera::up`].
    pub fn up(&self) -> Vec3 {
        self.up
    }

    /// The ray through a film position and a lens sample.
    pub fn sample_we(&self, film: Vec2, lens: Vec2, time: f32) -> CameraRay {
        let (ray, weight, receiver) = match &self.kind {
            Kind::Radiance(ray) => (*ray, 1.0, None),
            Kind::Irradiance(patch, factor) => {
                // Filters wider than a pixel reach beyond the film.
                let within = |x: f32, n: f32| (x / n).clamp(0.0, ONE_MINUS_EPSILON);
                let u =
                    Vec2::new(within(film.x, self.resolution.x), within(film.y, self.resolution.y));
                let (s, pdf_a) = patch.sample(u);
                let d = Frame::from_normal(s.n).to_world(warp::cosine_hemisphere(lens));
                let o = offset_origin(s.p, s.p_error, s.n, d);
                // (1), (2)
                (Ray::new(o, d), PI * factor / (patch.area * pdf_a), Some(s))
            }
            Kind::Distant { d, back, target } => {
                let (p, weight) = match target {
                    Target::Point(p) => (*p, 1.0),
                    Target::Disc(center, radius) => {
                        let (s, t) = d.coordinate_system();
                        let u = warp::disk(lens) * *radius;
                        (*center + s * u.x + t * u.y, 1.0)
                    }
                    Target::Patch(patch) => {
                        let (s, pdf_a) = patch.sample(lens);
                        (s.p, 1.0 / (patch.area * pdf_a)) // (3)
                    }
                };
                (Ray::new(p - *d * *back, *d), weight, None)
            }
        };
        let ray = Ray { time, ..ray };
        let (spread, width) = (0.0, 0.0);
        CameraRay { ray, t_max: f32::INFINITY, spread, width, weight, receiver }
    }

    /// Where it stands, about.
    pub fn position(&self) -> Vec3 {
        self.position
    }
}

fn pixels([x, y]: [u32; 2]) -> Vec2 {
    Vec2::new(x as f32, y as f32)
}

impl Patch {
    /// The shape of this number, in the scene.
    fn new((number, desc): (u32, &ShapeDesc), geometry: &Geometry) -> Option<Patch> {
        if let Some(quadric) = geometry.quadrics.iter().find(|q| q.shape == number) {
            let area = quadric.area();
            let form = Form::Quadric(Box::new(quadric.clone()));
            return (area > 0.0 && area.is_finite()).then_some(Patch { form, area });
        }
        if desc.geometry == GeometryDesc::Rectangle {
            let patch = Patch::rectangle(&desc.transform)?;
            return Some(if desc.flip_normals { patch.turned_over() } else { patch });
        }
        let store = &geometry.triangles;
        let meshes = store.meshes.iter().filter(|m| m.shape == number);
        let triangles: Vec<u32> = meshes.flat_map(|m| m.first..m.first + m.count).collect();
        let areas: Vec<f32> = triangles.iter().map(|&i| store.area(i)).collect();
        let area = areas.iter().map(|&a| f64::from(a)).sum::<f64>() as f32;
        let table = Discrete::new(&areas).ok()?;
        let normal = |i: u32| store.sample(i, Vec2::splat(0.5)).n;
        let list = triangles.iter().map(|&i| (store.corners(i), normal(i))).collect();
        let form = Form::Triangles(list, table);
        (area > 0.0 && area.is_finite()).then_some(Patch { form, area })
    }

    /// [`GeometryDesc::Rectangle`] in the space of `t`.
    fn rectangle(t: &Transform) -> Option<Patch> {
        let at = |x, y| t.point(Vec3::new(x, y, 0.0));
        let corner = at(-1.0, -1.0);
        let sides = [at(1.0, -1.0) - corner, at(-1.0, 1.0) - corner];
        let n = t.normal(Vec3::Z).try_normalize()?;
        let area = sides[0].cross(sides[1]).length();
        let form = Form::Rectangle { corner, sides, n };
        (area > 0.0 && area.is_finite()).then_some(Patch { form, area })
    }

    /// With a rectangle's other side in front.
    fn turned_over(mut self) -> Patch {
        if let Form::Rectangle { n, .. } = &mut self.form {
            *n = -*n;
        }
        self
    }

    /// A point and its density per area.
    fn sample(&self, u: Vec2) -> (ShapeSample, f32) {
        let uniform = |p: Vec3, size: Vec3, n: Vec3| {
            (ShapeSample { p, p_error: size * gamma(6), n }, 1.0 / self.area)
        };
        match &self.form {
            Form::Rectangle { corner, sides: [a, b], n } => {
                uniform(*corner + *a * u.x + *b * u.y, corner.abs() + a.abs() + b.abs(), *n)
            }
            Form::Triangles(list, table) => {
                let s = table.sample(u.x);
                let ([a, b, c], n) = list[s.index];
                let w = warp::triangle(Vec2::new(s.u, u.y));
                uniform(a * w[0] + b * w[1] + c * w[2], a.abs() + b.abs() + c.abs(), n)
            }
            Form::Quadric(quadric) => quadric.sample(u),
        }
    }
}
