//! A thin pane of glass: two parallel interfaces as one surface.
//!
//! ```text
//! R' = R + T R T + T R³ T + … = R + T²R/(1 - R²) = 2R/(1 + R),   T' = 1 - R'      (1)
//! ```
//!
//! Refraction in and out cancel: what is transmitted goes straight on, without the change of
//! radiance that a single interface brings. Stokes 1862, "On the intensity of the light reflected
//! from or transmitted through a pile of plates".

use super::fresnel::fresnel_dielectric;
use super::{BsdfSample, Lobes, Mode, Scatter};
use kaustika_math::{Vec2, Vec3};
use kaustika_spectra::Spectrum;

/// A pane without thickness, the same from both sides; Dirac lobes only.
#[derive(Clone, Copy, Debug)]
pub struct ThinDielectric {
    /// Index of the glass over that of the surroundings.
    pub eta: f32,
    /// Multiplies reflection, in [0, 1].
    pub reflectance: Spectrum,
    /// Multiplies transmission, in [0, 1].
    pub transmittance: Spectrum,
}

impl ThinDielectric {
    /// R' of (1).
    #[inline]
    fn reflected(&self, wo: Vec3) -> f32 {
        let r = fresnel_dielectric(wo.z.abs(), self.eta).reflectance;
        2.0 * r / (1.0 + r)
    }

    /// The part that goes straight on, and the probability that it is sampled.
    #[inline]
    pub fn straight(&self, wo: Vec3) -> (Spectrum, f32) {
        let t = 1.0 - self.reflected(wo);
        (self.transmittance * t, t)
    }
}

impl Scatter for ThinDielectric {
    #[inline]
    fn eval(&self, _: Vec3, _: Vec3, _: Mode, _: Lobes) -> Spectrum {
        Spectrum::ZERO
    }

    #[inline]
    fn pdf(&self, _: Vec3, _: Vec3, _: Mode, _: Lobes) -> (f32, f32) {
        (0.0, 0.0)
    }

    #[inline]
    fn sample(&self, wo: Vec3, uc: f32, _: Vec2, _: Mode, lobes: Lobes) -> Option<BsdfSample> {
        let r = self.reflected(wo);
        let wr = if lobes.has(Lobes::DELTA_REFLECTION) { r } else { 0.0 };
        let wt = if lobes.has(Lobes::DELTA_TRANSMISSION) { 1.0 - r } else { 0.0 };
        if wr + wt <= 0.0 {
            return None;
        }
        let pr = wr / (wr + wt);
        let (wi, weight, pdf, lobe) = if uc < pr {
            let wi = Vec3::new(-wo.x, -wo.y, wo.z);
            (wi, self.reflectance * (r / pr), pr, Lobes::DELTA_REFLECTION)
        } else {
            let pt = 1.0 - pr;
            (-wo, self.transmittance * ((1.0 - r) / pt), pt, Lobes::DELTA_TRANSMISSION)
        };
        Some(BsdfSample { wi, weight, pdf, pdf_rev: pdf, eta: 1.0, lobe })
    }

    /// Exact.
    #[inline]
    fn albedo(&self, wo: Vec3) -> Spectrum {
        self.transmittance.lerp(self.reflectance, self.reflected(wo))
    }

    #[inline]
    fn roughness(&self) -> f32 {
        0.0
    }

    #[inline]
    fn lobes(&self) -> Lobes {
        Lobes::DELTA_REFLECTION | Lobes::DELTA_TRANSMISSION
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Expect, check_model};
    use super::*;

    #[test]
    fn panes_hold_the_contract() {
        let clear =
            ThinDielectric { eta: 1.5, reflectance: Spectrum::ONE, transmittance: Spectrum::ONE };
        let expect = Expect { both_sides: true, ..Expect::default() };
        check_model("pane", &clear, Expect { albedo: Some((1.0, 1e-5)), ..expect });
        let tinted = ThinDielectric {
            reflectance: Spectrum([0.9, 0.5, 0.1, 0.0]),
            transmittance: Spectrum([0.2, 0.8, 1.0, 0.3]),
            ..clear
        };
        check_model("tinted pane", &tinted, expect);
        // Normal incidence: 2·0.04/1.04.
        assert!((clear.reflected(Vec3::Z) - 0.076_923_08).abs() < 1e-6);
    }
}
