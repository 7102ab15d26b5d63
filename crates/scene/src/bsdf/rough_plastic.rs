//! Rough plastic: a matte base under a rough dielectric coat.
//!
//! ```text
//! f cos θᵢ = s F(ωₒ·m) D(m) G₂/(4 cos θₒ) + ρ' T(ωₒ) T(ωᵢ) cos θᵢ / (π η²)        (1)
//! ρ' = ρ/(1 - ρ R̄)  (nonlinear),   ρ/(1 - R̄)  (linear)                            (2)
//! P(coat) ∝ (1 - T(ωₒ)) w,   P(base) ∝ T(ωₒ) (1 - w),   w = s/(s + ρ)              (3)
//! ```
//!
//! T and R̄ are tables of [`RoughTransmittance`]. The model is that of Mitsuba's `roughplastic`
//! (facts read in its source).

use super::albedo::microfacet_albedo;
use super::fresnel::{fresnel_dielectric, reflect};
use super::plastic::{base_albedo, specular_weight};
use super::rough_transmittance::{AlphaIndex, RoughTransmittance};
use super::{BsdfSample, Lobes, Microfacet, Mode, Scatter};
use kaustika_math::{INV_PI, Vec2, Vec3, sqr, warp};
use kaustika_spectra::Spectrum;

/// Rough plastic, one-sided. Always rough: use [`super::Plastic`] for a smooth coat.
#[derive(Clone, Copy, Debug)]
pub struct RoughPlastic<'a> {
    coat: &'a RoughTransmittance,
    at: AlphaIndex,
    surface: Microfacet,
    specular: Spectrum,
    /// ρ'/η².
    base: Spectrum,
    weight: f32,
}

impl<'a> RoughPlastic<'a> {
    /// With the coat's tables and facets (the same distribution), base colour `diffuse` and
    /// factor `specular` of the coat's reflection, both in [0, 1].
    #[inline]
    pub fn new(
        coat: &'a RoughTransmittance,
        surface: Microfacet,
        diffuse: Spectrum,
        specular: Spectrum,
        nonlinear: bool,
    ) -> RoughPlastic<'a> {
        let at = coat.index(surface.alpha());
        let (base, weight) = RoughPlastic::base(coat, at, diffuse, specular, nonlinear);
        RoughPlastic { coat, at, surface, specular, base, weight }
    }

    /// ρ'/η² of (2) and w of (3).
    #[inline]
    pub(crate) fn base(
        coat: &RoughTransmittance,
        at: AlphaIndex,
        diffuse: Spectrum,
        specular: Spectrum,
        nonlinear: bool,
    ) -> (Spectrum, f32) {
        let base = base_albedo(diffuse, coat.internal_reflectance(at), nonlinear);
        (base / sqr(coat.eta()), specular_weight(specular, diffuse))
    }

    #[inline]
    fn transmittance(&self, cos: f32) -> f32 {
        self.coat.transmittance(self.at, cos)
    }

    /// Probability of the coat's reflection, (3), where the coat lets `t` through.
    #[inline]
    fn choice(&self, t: f32, lobes: Lobes) -> f32 {
        if !lobes.has(Lobes::GLOSSY_REFLECTION) {
            return 0.0;
        }
        if !lobes.has(Lobes::DIFFUSE_REFLECTION) {
            return 1.0;
        }
        let (coat, base) = ((1.0 - t) * self.weight, t * (1.0 - self.weight));
        if coat + base > 0.0 { coat / (coat + base) } else { 1.0 }
    }

    #[inline]
    fn is_lit(wo: Vec3, wi: Vec3, lobes: Lobes) -> bool {
        wo.z > 0.0 && wi.z > 0.0 && lobes.has(Lobes::GLOSSY_REFLECTION | Lobes::DIFFUSE_REFLECTION)
    }

    /// Value (1) and densities of a pair of directions above the surface.
    #[inline]
    fn eval_pdf(&self, wo: Vec3, wi: Vec3, lobes: Lobes) -> (Spectrum, (f32, f32)) {
        let (to, ti) = (self.transmittance(wo.z), self.transmittance(wi.z));
        let (choice_o, choice_i) = (self.choice(to, lobes), self.choice(ti, lobes));
        let mut value = Spectrum::ZERO;
        let mut pdf = (0.0, 0.0);
        if lobes.has(Lobes::GLOSSY_REFLECTION) {
            let wm = (wo + wi).normalize();
            let f = fresnel_dielectric(wo.dot(wm), self.coat.eta()).reflectance;
            let facets = self.surface.d(wm) * self.surface.g2(wo, wi) / (4.0 * wo.z);
            value += self.specular * (f * facets);
            let (forward, reverse) = self.surface.pdf_reflection(wo, wi, wm);
            pdf = (choice_o * forward, choice_i * reverse);
        }
        if lobes.has(Lobes::DIFFUSE_REFLECTION) {
            value += self.base * (to * ti * INV_PI * wi.z);
            pdf.0 += (1.0 - choice_o) * warp::cosine_hemisphere_pdf_w(wi.z);
            pdf.1 += (1.0 - choice_i) * warp::cosine_hemisphere_pdf_w(wo.z);
        }
        (value, pdf)
    }
}

impl Scatter for RoughPlastic<'_> {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> Spectrum {
        if !RoughPlastic::is_lit(wo, wi, lobes) {
            return Spectrum::ZERO;
        }
        self.eval_pdf(wo, wi, lobes).0
    }

    #[inline]
    fn pdf(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> (f32, f32) {
        if !RoughPlastic::is_lit(wo, wi, lobes) {
            return (0.0, 0.0);
        }
        self.eval_pdf(wo, wi, lobes).1
    }

    #[inline]
    fn sample(&self, wo: Vec3, uc: f32, u2: Vec2, _: Mode, lobes: Lobes) -> Option<BsdfSample> {
        if wo.z <= 0.0 || !lobes.has(self.lobes()) {
            return None;
        }
        let coat = uc < self.choice(self.transmittance(wo.z), lobes);
        let (wi, lobe) = if coat {
            (reflect(wo, self.surface.sample_visible(wo, u2)), Lobes::GLOSSY_REFLECTION)
        } else {
            (warp::cosine_hemisphere(u2), Lobes::DIFFUSE_REFLECTION)
        };
        if wi.z <= 0.0 {
            return None;
        }
        let (value, (pdf, pdf_rev)) = self.eval_pdf(wo, wi, lobes);
        (pdf > 0.0).then(|| BsdfSample { wi, weight: value / pdf, pdf, pdf_rev, eta: 1.0, lobe })
    }

    /// The base's part exact, the coat's by Schlick's approximation (about 0.02).
    #[inline]
    fn albedo(&self, wo: Vec3) -> Spectrum {
        if wo.z <= 0.0 {
            return Spectrum::ZERO;
        }
        let eta = self.coat.eta();
        let r0 = Spectrum::splat(sqr((eta - 1.0) / (eta + 1.0)));
        let through = self.transmittance(wo.z) * self.coat.mean_transmittance(self.at);
        self.specular * microfacet_albedo(&self.surface, r0, wo) + self.base * through
    }

    /// The coat's, the glossier of the two.
    #[inline]
    fn roughness(&self) -> f32 {
        self.surface.roughness()
    }

    #[inline]
    fn lobes(&self) -> Lobes {
        if self.base.is_black() {
            Lobes::GLOSSY_REFLECTION
        } else {
            Lobes::GLOSSY_REFLECTION | Lobes::DIFFUSE_REFLECTION
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Masking;
    use super::super::testing::{Expect, check_model};
    use super::*;
    use crate::description::Distribution;

    #[test]
    fn rough_plastic_holds_the_contract() {
        for (kind, alpha) in [(Distribution::Beckmann, 0.1), (Distribution::Ggx, 0.4)] {
            let coat = RoughTransmittance::new(kind, alpha, 1.49);
            let surface = Microfacet::new(kind, alpha, alpha).with_masking(Masking::Separable);
            for nonlinear in [false, true] {
                let diffuse = Spectrum([0.1, 0.5, 0.9, 0.0]);
                let specular = Spectrum::splat(0.8);
                let model = RoughPlastic::new(&coat, surface, diffuse, specular, nonlinear);
                let expect = Expect { albedo_error: 0.05, ..Expect::default() };
                check_model(&format!("{kind:?} {alpha}"), &model, expect);
            }
        }
    }

    /// A textured coat, a black base.
    #[test]
    fn other_coats_hold_the_contract() {
        let coat = RoughTransmittance::with_range(Distribution::Ggx, 0.1, 0.5, 1.6);
        let surface = Microfacet::new(Distribution::Ggx, 0.22, 0.22);
        let expect = Expect { albedo_error: 0.05, samples: 20_000, ..Expect::default() };
        for diffuse in [0.0, 0.7] {
            let diffuse = Spectrum::splat(diffuse);
            let model = RoughPlastic::new(&coat, surface, diffuse, Spectrum::ONE, false);
            check_model("textured coat", &model, expect);
        }
    }
}
