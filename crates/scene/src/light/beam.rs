//! Lights that send each of their points' light in one direction: no connection meets it, so only
//! paths that start at the light carry it.
//!
//! ```text
//! beam            Φ along one ray                     p(x₀) and p(ω) Dirac                     (1)
//! along normals   dΦ = B dA, ω = n                    p(x₀) = 1/A, p(ω) Dirac                  (2)
//! ```
//!
//! (1) is Mitsuba 0.6's `collimated`, (2) Mitsuba 3's `directionalarea`, whose `radiance` is B:
//! power per area.

use super::{AreaLight, EmittedRay};
use crate::Scene;
use kaustika_math::ray::offset_origin;
use kaustika_math::{INV_PI, Ray, Vec2, Vec3};
use kaustika_spectra::{CompiledSpectrum, Spectrum, Wavelengths};

/// All light on one ray.
#[derive(Clone, Debug)]
pub struct Beam {
    /// Where it begins.
    pub p: Vec3,
    /// Unit direction.
    pub direction: Vec3,
    /// Power, W.
    pub power: CompiledSpectrum,
    /// Multiplies it.
    pub scale: f32,
}

impl Beam {
    pub(super) fn sample_le(
        &self,
        scene: &Scene,
        _: Vec2,
        _: Vec2,
        lambda: &Wavelengths,
    ) -> Option<EmittedRay> {
        let (ray, le) = (Ray::new(self.p, self.direction), self.power(scene, lambda));
        Some(EmittedRay { ray, le, n: self.direction, pdf_a: 1.0, pdf_w: 1.0, cos: 1.0 }) // (1)
    }

    pub(super) fn pdf_le(&self, _: &Scene, _: Vec3, _: Vec3, _: Vec3) -> (f32, f32) {
        (0.0, 0.0)
    }

    pub(super) fn power(&self, _: &Scene, lambda: &Wavelengths) -> Spectrum {
        self.power.eval(lambda) * self.scale
    }
}

/// A surface whose points shine along their normals alone.
#[derive(Clone, Copy, Debug)]
pub struct NormalArea(
    /// The surface, with B in place of its radiance.
    pub AreaLight,
);

impl NormalArea {
    pub(super) fn sample_le(
        &self,
        scene: &Scene,
        u: Vec2,
        _: Vec2,
        lambda: &Wavelengths,
    ) -> Option<EmittedRay> {
        let (s, pdf_a) = self.0.sample_area(scene, u);
        let le = self.0.sampled_radiance(scene, &s, s.n, u, lambda);
        let ray = Ray::new(offset_origin(s.p, s.p_error, s.n, s.n), s.n);
        Some(EmittedRay { ray, le, n: s.n, pdf_a, pdf_w: 1.0, cos: 1.0 }) // (2)
    }

    pub(super) fn pdf_le(&self, scene: &Scene, p: Vec3, n: Vec3, w: Vec3) -> (f32, f32) {
        (self.0.pdf_le(scene, p, n, w).0, 0.0)
    }

    /// ∫ B dA, where a lamp of radiance B has π times that.
    pub(super) fn power(&self, scene: &Scene, lambda: &Wavelengths) -> Spectrum {
        self.0.power(scene, lambda) * INV_PI
    }
}
