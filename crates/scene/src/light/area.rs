//! Area lights: triangles and analytic shapes that emit.
//!
//! ```text
//! pdf_ω = pdf_A d² / |cos θ_light|                                         (1)
//! whole spheres from outside: uniform in the cone they fill                (2)
//! ```
//!
//! Rays pass where `alpha` cuts the shape out, so that what they find of it is α L on average; points
//! that are sampled count α L. A light that is cut out everywhere in a pbrt scene shines without being
//! seen (pbrt-v4, `DiffuseAreaLight`): only sampled points find it.

use super::{EmittedRay, LightSample};
use crate::Scene;
use crate::description::TextureId;
use crate::shape::{ShapeSample, area_to_solid_angle};
use crate::surface::Surface;
use crate::texture::TexturePoint;
use kaustika_math::ray::offset_origin;
use kaustika_math::{Frame, Ray, Vec2, Vec3, gamma, safe_sqrt, sqr, warp};
use kaustika_spectra::{Spectrum, Wavelengths};
use std::f32::consts::PI;

/// What emits.
#[derive(Clone, Copy, Debug)]
pub enum AreaShape {
    /// A triangle of the store, with its area.
    Triangle(u32, f32),
    /// An analytic shape.
    Quadric(u32),
    /// An analytic shape that is a whole sphere: number, centre, radius.
    Sphere(u32, Vec3, f32),
}

/// An emitting surface.
#[derive(Clone, Copy, Debug)]
pub struct AreaLight {
    /// Its form.
    pub shape: AreaShape,
    /// Radiance over its uv.
    pub radiance: TextureId,
    /// Multiplies it.
    pub scale: f32,
    /// True if both sides emit.
    pub two_sided: bool,
    /// The part of it that is there, in [0, 1].
    pub alpha: Option<TextureId>,
    /// True if it shines though no ray meets it.
    pub unseen: bool,
}

/// Where on its shape a point lies, for what varies over it.
struct Place {
    uv: Vec2,
    /// Of the store, or `u32::MAX`.
    triangle: u32,
    /// Weights of the triangle's corners 1 and 2.
    barycentrics: Vec2,
}

impl Place {
    /// For what varies over the shape, at its point `p` with normal `n`.
    fn texture_point(self, p: Vec3, n: Vec3) -> TexturePoint {
        let Place { uv, triangle, barycentrics } = self;
        TexturePoint { p, n, uv, uv_width: 0.0, triangle, barycentrics }
    }
}

impl AreaLight {
    /// Radiance leaving the point `p` with normal `n` along `w`; its place is asked for only
    /// where the radiance varies.
    #[inline]
    fn emitted(
        &self,
        scene: &Scene,
        (p, n): (Vec3, Vec3),
        w: Vec3,
        lambda: &Wavelengths,
        place: impl FnOnce() -> Place,
    ) -> Spectrum {
        if !self.two_sided && n.dot(w) <= 0.0 {
            return Spectrum::ZERO;
        }
        if let Some(radiance) = scene.textures.uniform(self.radiance, lambda) {
            return radiance * self.scale;
        }
        let at = place().texture_point(p, n);
        scene.textures.spectrum(self.radiance, &at, lambda) * self.scale
    }

    /// The part of a sampled point that is there.
    #[inline]
    fn presence(&self, scene: &Scene, (p, n): (Vec3, Vec3), place: impl FnOnce() -> Place) -> f32 {
        match self.alpha {
            Some(alpha) => {
                scene.textures.float(alpha, &place().texture_point(p, n)).clamp(0.0, 1.0)
            }
            None => 1.0,
        }
    }

    /// Radiance leaving `s` along `w`.
    #[inline]
    pub fn le(&self, scene: &Scene, s: &Surface, w: Vec3, lambda: &Wavelengths) -> Spectrum {
        self.emitted(scene, (s.p, s.ng), w, lambda, || Place {
            uv: s.uv,
            triangle: s.triangle,
            barycentrics: s.barycentrics,
        })
    }

    /// A point of the surface and its density per area.
    #[inline]
    pub(super) fn sample_area(&self, scene: &Scene, u: Vec2) -> (ShapeSample, f32) {
        let g = &scene.geometry;
        match self.shape {
            AreaShape::Triangle(i, area) => (g.triangles.sample(i, u), 1.0 / area),
            AreaShape::Quadric(i) | AreaShape::Sphere(i, ..) => g.quadrics[i as usize].sample(u),
        }
    }

    /// Radiance leaving along `w` the point `s` that [`AreaLight::sample_area`] gives for `u`.
    #[inline]
    pub(super) fn sampled_radiance(
        &self,
        scene: &Scene,
        s: &ShapeSample,
        w: Vec3,
        u: Vec2,
        lambda: &Wavelengths,
    ) -> Spectrum {
        let place = || self.sampled_place(scene, u, s.p);
        self.emitted(scene, (s.p, s.n), w, lambda, place) * self.presence(scene, (s.p, s.n), place)
    }

    /// The place of what [`AreaLight::sample_area`] gives for `u`.
    fn sampled_place(&self, scene: &Scene, u: Vec2, p: Vec3) -> Place {
        let g = &scene.geometry;
        match self.shape {
            AreaShape::Triangle(triangle, _) => {
                let b = warp::triangle(u);
                let uv = g.triangles.uv(triangle, b);
                Place { uv, triangle, barycentrics: Vec2::new(b[1], b[2]) }
            }
            AreaShape::Quadric(i) | AreaShape::Sphere(i, ..) => {
                let uv = g.quadrics[i as usize].uv_at(p);
                Place { uv, triangle: u32::MAX, barycentrics: Vec2::ZERO }
            }
        }
    }

    /// A direction from `from` to the light.
    #[inline]
    pub fn sample_li(
        &self,
        scene: &Scene,
        from: Vec3,
        u: Vec2,
        lambda: &Wavelengths,
    ) -> Option<LightSample> {
        let (s, wi, pdf_w) = match self.shape {
            AreaShape::Sphere(i, center, radius)
                if (from - center).length_squared() > sqr(radius * 1.0001) =>
            {
                let to_center = center - from;
                let dc2 = to_center.length_squared();
                let sin2_max = sqr(radius) / dc2;
                let one_minus_cos_max = one_minus_cos(sin2_max);
                let local = warp::uniform_cone(u, one_minus_cos_max);
                let dc = dc2.sqrt();
                let frame = Frame::from_normal(to_center / dc);
                let wi = frame.to_world(local);
                // Where the direction meets the sphere, seen from its centre; sums of terms of
                // one sign, since from far away differences would leave little of the radius.
                let sin2 = sqr(local.x) + sqr(local.y);
                let half_chord = safe_sqrt(sqr(radius) - dc2 * sin2);
                let d = dc * local.z - half_chord;
                let z = -(dc * sin2 + local.z * half_chord);
                let n = frame.to_world(Vec3::new(d * local.x, d * local.y, z)).normalize();
                let quadric = &scene.geometry.quadrics[i as usize];
                let p = center + n * radius;
                let outward = if quadric.flip { -n } else { n };
                let p_error = (center.abs() + Vec3::splat(radius)) * gamma(6);
                let s = ShapeSample { p, p_error, n: outward };
                (s, wi, warp::uniform_cone_pdf_w(one_minus_cos_max)) // (2)
            }
            _ => {
                let (s, pdf_a) = self.sample_area(scene, u);
                let to_light = s.p - from;
                let d2 = to_light.length_squared();
                let wi = to_light.try_normalize()?;
                let pdf_w = area_to_solid_angle(pdf_a, d2, s.n.dot(wi)); // (1)
                (s, wi, pdf_w)
            }
        };
        if pdf_w <= 0.0 {
            return None;
        }
        let le = self.sampled_radiance(scene, &s, -wi, u, lambda);
        let delta = self.unseen;
        Some(LightSample { wi, p: s.p, p_error: s.p_error, n: s.n, pdf_w, le, delta })
    }

    /// Density per solid angle of [`AreaLight::sample_li`] choosing `wi`, which met the point
    /// `p` with normal `ng`.
    #[inline]
    pub fn pdf_li(&self, scene: &Scene, from: Vec3, p: Vec3, ng: Vec3, wi: Vec3) -> f32 {
        let pdf_a = match self.shape {
            AreaShape::Triangle(_, area) => 1.0 / area,
            AreaShape::Sphere(_, center, radius)
                if (from - center).length_squared() > sqr(radius * 1.0001) =>
            {
                let sin2_max = sqr(radius) / (center - from).length_squared();
                return warp::uniform_cone_pdf_w(one_minus_cos(sin2_max));
            }
            AreaShape::Quadric(i) | AreaShape::Sphere(i, ..) => {
                scene.geometry.quadrics[i as usize].pdf_a_at(p)
            }
        };
        area_to_solid_angle(pdf_a, (p - from).length_squared(), ng.dot(wi))
    }

    /// A ray that leaves the light: uniform over its area, cosine-distributed.
    pub fn sample_le(
        &self,
        scene: &Scene,
        u: Vec2,
        v: Vec2,
        lambda: &Wavelengths,
    ) -> Option<EmittedRay> {
        let (s, pdf_a) = self.sample_area(scene, u);
        let mut side = 1.0;
        let mut v = v;
        if self.two_sided {
            // One half of the first number chooses the side.
            side = if v.x < 0.5 { 1.0 } else { -1.0 };
            v.x = if v.x < 0.5 { 2.0 * v.x } else { 2.0 * v.x - 1.0 };
        }
        let local = warp::cosine_hemisphere(v);
        let n = s.n * side;
        let w = Frame::from_normal(n).to_world(local);
        let pdf_w = warp::cosine_hemisphere_pdf_w(local.z) * if self.two_sided { 0.5 } else { 1.0 };
        if pdf_w <= 0.0 {
            return None;
        }
        let le = self.sampled_radiance(scene, &s, w, u, lambda);
        let ray = Ray::new(offset_origin(s.p, s.p_error, s.n, w), w);
        Some(EmittedRay { ray, le, n, pdf_a, pdf_w, cos: local.z })
    }

    /// Densities (per area, per solid angle) of [`AreaLight::sample_le`].
    pub fn pdf_le(&self, scene: &Scene, p: Vec3, n: Vec3, w: Vec3) -> (f32, f32) {
        let pdf_a = match self.shape {
            AreaShape::Triangle(_, area) => 1.0 / area,
            AreaShape::Quadric(i) | AreaShape::Sphere(i, ..) => {
                scene.geometry.quadrics[i as usize].pdf_a_at(p)
            }
        };
        let cos = n.dot(w);
        let pdf_w = if self.two_sided {
            0.5 * warp::cosine_hemisphere_pdf_w(cos.abs())
        } else {
            warp::cosine_hemisphere_pdf_w(cos)
        };
        (pdf_a, pdf_w)
    }

    /// Emitted flux: ∫ π L dA, by a fixed set of points where the radiance varies.
    pub fn power(&self, scene: &Scene, lambda: &Wavelengths) -> Spectrum {
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        let radiance = |u: Vec2| {
            let (s, pdf_a) = self.sample_area(scene, u);
            (self.sampled_radiance(scene, &s, s.n, u, lambda), pdf_a)
        };
        if self.alpha.is_none() && scene.textures.constant(self.radiance).is_some() {
            return radiance(Vec2::splat(0.5)).0 * (sides * PI * self.area(scene));
        }
        // Meshes have many triangles, each a small part of the texture.
        let n = if matches!(self.shape, AreaShape::Triangle(..)) { 4 } else { 16 };
        let mut sum = Spectrum::ZERO;
        for i in 0..n * n {
            let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            let (le, pdf_a) = radiance(u);
            sum += le / pdf_a;
        }
        sum * (sides * PI / (n * n) as f32)
    }

    /// World-space area.
    pub fn area(&self, scene: &Scene) -> f32 {
        match self.shape {
            AreaShape::Triangle(_, area) => area,
            AreaShape::Quadric(i) => scene.geometry.quadrics[i as usize].area(),
            AreaShape::Sphere(_, _, r) => 4.0 * PI * r * r,
        }
    }
}

/// 1 - cosθ from sin²θ without cancellation for small angles.
fn one_minus_cos(sin2: f32) -> f32 {
    sin2 / (1.0 + safe_sqrt(1.0 - sin2))
}
