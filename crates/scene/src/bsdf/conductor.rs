//! Metals: reflection only, ideally smooth or from microfacets.
//!
//! ```text
//! f cos θᵢ = F(ωₒ·m) D(m) G₂(ωₒ, ωᵢ) / (4 cos θₒ),   m = (ωₒ + ωᵢ)/|ωₒ + ωᵢ|       (1)
//! pdf(ωᵢ)  = D_ωₒ(m) / (4 ωₒ·m) = G₁(ωₒ) D(m) / (4 cos θₒ)                         (2)
//! weight   = F G₂/G₁(ωₒ)                                                          (3)
//! ```
//!
//! Torrance & Sparrow 1967; visible normals: Heitz & d'Eon 2014. Light scattered between facets
//! is lost, as it is in pbrt and Mitsuba.

use super::albedo::microfacet_albedo;
use super::fresnel::{fresnel_conductor, reflect};
use super::{BsdfSample, Lobes, Microfacet, Mode, Scatter};
use kaustika_math::{Vec2, Vec3};
use kaustika_spectra::Spectrum;

/// Where a conductor's reflectance comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConductorFresnel {
    /// Complex index of refraction `eta` + i `k`, relative to the outside.
    EtaK {
        /// Real part.
        eta: Spectrum,
        /// Imaginary part, positive.
        k: Spectrum,
    },
    /// Reflectance 1 at every angle.
    Mirror,
}

impl ConductorFresnel {
    /// The conductor with reflectance `r` in [0, 1) at normal incidence (clamped to 0.9999) and a
    /// real index of 1: k = 2 √r / √(1 - r), pbrt-v4's rule.
    #[inline]
    pub fn from_reflectance(r: Spectrum) -> ConductorFresnel {
        let k = r.map(|r| {
            let r = r.clamp(0.0, 0.9999);
            2.0 * (r / (1.0 - r)).sqrt()
        });
        ConductorFresnel::EtaK { eta: Spectrum::ONE, k }
    }

    /// Reflectance at `cos` in [0, 1].
    #[inline]
    pub fn reflectance(&self, cos: f32) -> Spectrum {
        match *self {
            ConductorFresnel::EtaK { eta, k } => fresnel_conductor(cos, eta, k),
            ConductorFresnel::Mirror => Spectrum::ONE,
        }
    }
}

/// A metal, one-sided.
#[derive(Clone, Copy, Debug)]
pub struct Conductor {
    /// Reflectance of a facet.
    pub fresnel: ConductorFresnel,
    /// Multiplies it, in [0, 1] (`specular_reflectance`).
    pub tint: Spectrum,
    /// Its facets.
    pub surface: Microfacet,
}

impl Conductor {
    /// True if the arguments can have a value: a rough surface, both directions above.
    #[inline]
    fn shines(&self, wo: Vec3, wi: Vec3, lobes: Lobes) -> bool {
        wo.z > 0.0 && wi.z > 0.0 && lobes.has(Lobes::GLOSSY_REFLECTION) && !self.surface.is_smooth()
    }
}

impl Scatter for Conductor {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> Spectrum {
        if !self.shines(wo, wi, lobes) {
            return Spectrum::ZERO;
        }
        let wm = (wo + wi).normalize();
        let facets = self.surface.d(wm) * self.surface.g2(wo, wi) / (4.0 * wo.z);
        self.tint * self.fresnel.reflectance(wo.dot(wm)) * facets // (1)
    }

    #[inline]
    fn pdf(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> (f32, f32) {
        if !self.shines(wo, wi, lobes) {
            return (0.0, 0.0);
        }
        self.surface.pdf_reflection(wo, wi, (wo + wi).normalize()) // (2)
    }

    #[inline]
    fn sample(&self, wo: Vec3, _: f32, u2: Vec2, _: Mode, lobes: Lobes) -> Option<BsdfSample> {
        if wo.z <= 0.0 || !lobes.has(self.lobes()) {
            return None;
        }
        if self.surface.is_smooth() {
            return Some(BsdfSample {
                wi: Vec3::new(-wo.x, -wo.y, wo.z),
                weight: self.tint * self.fresnel.reflectance(wo.z),
                pdf: 1.0,
                pdf_rev: 1.0,
                eta: 1.0,
                lobe: Lobes::DELTA_REFLECTION,
            });
        }
        let wm = self.surface.sample_visible(wo, u2);
        let wi = reflect(wo, wm);
        if wi.z <= 0.0 {
            return None;
        }
        let (pdf, pdf_rev) = self.surface.pdf_reflection(wo, wi, wm);
        let weight = self.surface.g2_over_g1(wo, wi);
        (pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: self.tint * self.fresnel.reflectance(wo.dot(wm)) * weight, // (3)
            pdf,
            pdf_rev,
            eta: 1.0,
            lobe: Lobes::GLOSSY_REFLECTION,
        })
    }

    /// Exact for smooth metals; else by Schlick's approximation (within 0.06).
    #[inline]
    fn albedo(&self, wo: Vec3) -> Spectrum {
        if wo.z <= 0.0 {
            return Spectrum::ZERO;
        }
        if self.surface.is_smooth() {
            return self.tint * self.fresnel.reflectance(wo.z);
        }
        self.tint * microfacet_albedo(&self.surface, self.fresnel.reflectance(1.0), wo)
    }

    #[inline]
    fn roughness(&self) -> f32 {
        self.surface.roughness()
    }

    #[inline]
    fn lobes(&self) -> Lobes {
        if self.surface.is_smooth() { Lobes::DELTA_REFLECTION } else { Lobes::GLOSSY_REFLECTION }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Masking;
    use super::super::testing::{Expect, check_model};
    use super::*;
    use crate::description::Distribution;

    /// Gold, copper and two others of lower reflectance.
    fn metal() -> ConductorFresnel {
        ConductorFresnel::EtaK {
            eta: Spectrum([0.143, 0.375, 1.44, 2.0]),
            k: Spectrum([3.98, 2.39, 1.60, 0.6]),
        }
    }

    #[test]
    fn smooth_metals_hold_the_contract() {
        let surface = Microfacet::smooth();
        let metal = Conductor { fresnel: metal(), tint: Spectrum([1.0, 0.8, 0.5, 1.0]), surface };
        check_model("smooth metal", &metal, Expect { albedo_error: 1e-5, ..Expect::default() });
        let mirror = Conductor { fresnel: ConductorFresnel::Mirror, tint: Spectrum::ONE, surface };
        let expect = Expect { albedo: Some((1.0, 1e-6)), ..Expect::default() };
        check_model("mirror", &mirror, expect);
    }

    #[test]
    fn rough_metals_hold_the_contract() {
        let expect = Expect { albedo_error: 0.06, samples: 30_000, ..Expect::default() };
        for kind in [Distribution::Ggx, Distribution::Beckmann] {
            for masking in [Masking::HeightCorrelated, Masking::Separable] {
                for (alpha_u, alpha_v) in [(0.05, 0.05), (0.3, 0.1), (0.9, 0.9)] {
                    let surface = Microfacet::new(kind, alpha_u, alpha_v).with_masking(masking);
                    let name = format!("{surface:?}");
                    let model = Conductor { fresnel: metal(), tint: Spectrum::ONE, surface };
                    check_model(&name, &model, expect);
                }
            }
        }
    }

    /// A perfect mirror's facets lose only what is masked: little when nearly smooth.
    #[test]
    fn nearly_smooth_mirrors_lose_little() {
        let surface = Microfacet::new(Distribution::Ggx, 0.01, 0.01);
        let mirror = Conductor { fresnel: ConductorFresnel::Mirror, tint: Spectrum::ONE, surface };
        let expect = Expect {
            albedo: Some((1.0, 0.03)),
            albedo_error: 0.03,
            rounding: 2e-2,
            ..Expect::default()
        };
        check_model("nearly smooth mirror", &mirror, expect);
    }

    #[test]
    fn reflectance_at_normal_incidence_is_met() {
        let r = Spectrum([0.02, 0.4, 0.9, 0.0]);
        let got = ConductorFresnel::from_reflectance(r).reflectance(1.0);
        (0..4).for_each(|i| assert!((got[i] - r[i]).abs() < 1e-5, "{got:?}"));
    }
}
