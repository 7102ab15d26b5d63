//! A camera that shines: Mitsuba 3's projector.
//!
//! ```text
//! I(ω) = π E(u, v) / cos³θ                                                                 (1)
//! u = ½ (1 - x/tan x_max),  v = ½ (1 - y/tan y_max)   on the plane z = 1                    (2)
//! p(ω) = 1/(A cos³θ),  A = 4 tan x_max tan y_max                                           (3)
//! ```
//!
//! (1) is constant over a plane across the axis: a white plane at distance 1 reflects the radiance
//! E, which the plugin's documentation calls the irradiance.

use super::point::{emitted, slide_point, toward};
use super::{EmittedRay, LightSample};
use crate::Scene;
use crate::description::TextureId;
use kaustika_math::{Transform, Vec2, Vec3};
use kaustika_spectra::{Spectrum, Wavelengths};
use std::f32::consts::PI;

/// A texture thrown along +z.
#[derive(Clone, Debug)]
pub struct Projector {
    /// Light to world.
    pub to_world: Transform,
    /// E over (2).
    pub texture: TextureId,
    /// Multiplies it.
    pub scale: f32,
    /// tan of half the field of view, across and down.
    pub tan: [f32; 2],
}

impl Projector {
    /// Radiant intensity along the world direction `w`.
    fn along(&self, scene: &Scene, w: Vec3, lambda: &Wavelengths) -> Spectrum {
        let d = self.to_world.inverse().vector(w).normalize();
        let [x, y] = [d.x / (d.z * self.tan[0]), d.y / (d.z * self.tan[1])];
        if d.z <= 0.0 || x.abs() > 1.0 || y.abs() > 1.0 {
            return Spectrum::ZERO;
        }
        let at = slide_point(Vec2::new(0.5 * (1.0 - x), 0.5 * (1.0 - y))); // (2)
        scene.textures.spectrum(self.texture, &at, lambda) * (PI * self.scale / (d.z * d.z * d.z))
    }

    fn area(&self) -> f32 {
        4.0 * self.tan[0] * self.tan[1]
    }

    /// The direction through a place of the plane z = 1, and cos θ.
    fn through(&self, u: Vec2) -> (Vec3, f32) {
        let [x, y] = [(2.0 * u.x - 1.0) * self.tan[0], (2.0 * u.y - 1.0) * self.tan[1]];
        let d = Vec3::new(x, y, 1.0);
        (self.to_world.vector(d).normalize(), 1.0 / d.length())
    }

    pub(super) fn sample_li(
        &self,
        scene: &Scene,
        from: Vec3,
        _: Vec2,
        lambda: &Wavelengths,
    ) -> Option<LightSample> {
        let p = self.to_world.point(Vec3::ZERO);
        toward(p, from, |w| self.along(scene, w, lambda)).filter(|s| !s.le.is_black())
    }

    pub(super) fn sample_le(
        &self,
        scene: &Scene,
        _: Vec2,
        v: Vec2,
        lambda: &Wavelengths,
    ) -> Option<EmittedRay> {
        let (w, cos) = self.through(v);
        let pdf_w = 1.0 / (self.area() * cos * cos * cos); // (3)
        let le = self.along(scene, w, lambda);
        Some(emitted(self.to_world.point(Vec3::ZERO), w, pdf_w, le))
    }

    pub(super) fn pdf_le(&self, _: &Scene, _: Vec3, _: Vec3, w: Vec3) -> (f32, f32) {
        let d = self.to_world.inverse().vector(w).normalize();
        let inside =
            d.z > 0.0 && (d.x / d.z).abs() <= self.tan[0] && (d.y / d.z).abs() <= self.tan[1];
        (0.0, if inside { 1.0 / (self.area() * d.z * d.z * d.z) } else { 0.0 })
    }

    /// ∫ I dω = π ∫ E dA over the plane z = 1, by the midpoint rule.
    pub(super) fn power(&self, scene: &Scene, lambda: &Wavelengths) -> Spectrum {
        const N: usize = 32;
        let mut sum = Spectrum::ZERO;
        for i in 0..N * N {
            let (w, cos) =
                self.through(Vec2::new((i % N) as f32 + 0.5, (i / N) as f32 + 0.5) / N as f32);
            sum += self.along(scene, w, lambda) * (cos * cos * cos);
        }
        sum * (self.area() / (N * N) as f32)
    }
}
