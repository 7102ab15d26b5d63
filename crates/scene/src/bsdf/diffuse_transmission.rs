//! A thin matte sheet that reflects and transmits diffusely (pbrt-v4's `diffusetransmission`).
//!
//! ```text
//! f = ρ/π on the side of ωₒ,  τ/π on the other                                    (1)
//! pdf(ωᵢ) = P |cos θᵢ|/π,  P = max ρ/(max ρ + max τ) or max τ/(max ρ + max τ)       (2)
//! ```
//!
//! There is no refraction: η = 1, and both modes agree.

use super::{BsdfSample, Lobes, Mode, Scatter};
use kaustika_math::{INV_PI, Vec2, Vec3, warp};
use kaustika_spectra::Spectrum;

/// A matte sheet, the same from both sides. ρ + τ <= 1 where no light is to be made.
#[derive(Clone, Copy, Debug)]
pub struct DiffuseTransmission {
    /// Albedo ρ of reflection in [0,1].
    pub reflectance: Spectrum,
    /// Albedo τ of transmission in [0,1].
    pub transmittance: Spectrum,
}

impl DiffuseTransmission {
    /// Probability of reflection; `None` if nothing may be drawn.
    #[inline]
    fn choice(&self, lobes: Lobes) -> Option<f32> {
        let on =
            |class, color: Spectrum| if lobes.has(class) { color.max_component() } else { 0.0 };
        let r = on(Lobes::DIFFUSE_REFLECTION, self.reflectance);
        let t = on(Lobes::DIFFUSE_TRANSMISSION, self.transmittance);
        (r + t > 0.0).then(|| r / (r + t))
    }
}

impl Scatter for DiffuseTransmission {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> Spectrum {
        let (class, albedo) = if wo.z * wi.z > 0.0 {
            (Lobes::DIFFUSE_REFLECTION, self.reflectance)
        } else {
            (Lobes::DIFFUSE_TRANSMISSION, self.transmittance)
        };
        if lobes.has(class) { albedo * (INV_PI * wi.z.abs()) } else { Spectrum::ZERO } // (1)
    }

    #[inline]
    fn pdf(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> (f32, f32) {
        let Some(r) = self.choice(lobes) else { return (0.0, 0.0) };
        let p = INV_PI * if wo.z * wi.z > 0.0 { r } else { 1.0 - r };
        (p * wi.z.abs(), p * wo.z.abs()) // (2)
    }

    #[inline]
    fn sample(&self, wo: Vec3, uc: f32, u2: Vec2, mode: Mode, lobes: Lobes) -> Option<BsdfSample> {
        let r = self.choice(lobes)?;
        let reflects = uc < r;
        let mut wi = warp::cosine_hemisphere(u2);
        if (wo.z > 0.0) != reflects {
            wi.z = -wi.z;
        }
        let (albedo, p, lobe) = if reflects {
            (self.reflectance, r, Lobes::DIFFUSE_REFLECTION)
        } else {
            (self.transmittance, 1.0 - r, Lobes::DIFFUSE_TRANSMISSION)
        };
        let (pdf, pdf_rev) = self.pdf(wo, wi, mode, lobes);
        (pdf > 0.0).then(|| BsdfSample { wi, weight: albedo / p, pdf, pdf_rev, eta: 1.0, lobe })
    }

    #[inline]
    fn albedo(&self, _: Vec3) -> Spectrum {
        self.reflectance + self.transmittance
    }

    #[inline]
    fn roughness(&self) -> f32 {
        1.0
    }

    #[inline]
    fn lobes(&self) -> Lobes {
        let on = |class, color: Spectrum| if color.is_black() { Lobes::NONE } else { class };
        on(Lobes::DIFFUSE_REFLECTION, self.reflectance)
            | on(Lobes::DIFFUSE_TRANSMISSION, self.transmittance)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Expect, check_model};
    use super::*;

    #[test]
    fn holds_the_contract() {
        let colors = [
            (Spectrum([0.5, 0.2, 0.1, 0.0]), Spectrum([0.3, 0.7, 0.2, 0.0])),
            (Spectrum::ZERO, Spectrum::splat(0.9)),
            (Spectrum::splat(0.9), Spectrum::ZERO),
        ];
        let expect = Expect { both_sides: true, albedo_error: 1e-4, ..Expect::default() };
        for (reflectance, transmittance) in colors {
            let model = DiffuseTransmission { reflectance, transmittance };
            check_model("diffuse transmission", &model, expect);
        }
        let (reflectance, transmittance) = (Spectrum::splat(0.25), Spectrum::splat(0.75));
        let lossless = Expect { albedo: Some((1.0, 1e-4)), ..expect };
        let model = DiffuseTransmission { reflectance, transmittance };
        check_model("lossless sheet", &model, lossless);
    }
}
