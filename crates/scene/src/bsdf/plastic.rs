//! Smooth plastic: a matte base under a smooth dielectric coat, all the scattering between base
//! and coat in closed form.
//!
//! ```text
//! f = s F(ωₒ) δ + ρ' (1 - F(ωₒ)) (1 - F(ωᵢ)) / (π η²)                             (1)
//! ρ' = ρ/(1 - ρ F̄ᵢ)  (nonlinear),   ρ/(1 - F̄ᵢ)  (linear)                          (2)
//! P(coat) ∝ F(ωₒ) w,   P(base) ∝ (1 - F(ωₒ)) (1 - w),   w = s/(s + ρ)             (3)
//! ```
//!
//! F̄ᵢ is the coat's reflectance for diffuse light from inside. The linear form keeps the hue of
//! ρ, as if the light between base and coat met a white base. The model is that of Mitsuba's
//! `plastic` (facts read in its source); F̄ᵢ is exact here, a fit good to 0.1 % there.

use super::fresnel::{fresnel_dielectric, fresnel_diffuse_reflectance};
use super::{BsdfSample, Lobes, Mode, Scatter};
use kaustika_math::{INV_PI, Vec2, Vec3, warp};
use kaustika_spectra::Spectrum;

/// The coat, made once per material: the diffuse reflectance costs two logarithms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlasticCoat {
    eta: f32,
    inv_eta2: f32,
    internal: f32,
    /// 1 - F̄ₑ: what the coat lets in of diffuse light.
    entering: f32,
}

impl PlasticCoat {
    /// A coat of index `eta` > 0 relative to the outside.
    pub fn new(eta: f32) -> PlasticCoat {
        PlasticCoat {
            eta,
            inv_eta2: 1.0 / (eta * eta),
            internal: fresnel_diffuse_reflectance(1.0 / eta),
            entering: 1.0 - fresnel_diffuse_reflectance(eta),
        }
    }
}

/// ρ' of (2): the base's albedo with the light that the coat sends back to it.
#[inline]
pub(super) fn base_albedo(rho: Spectrum, internal: f32, nonlinear: bool) -> Spectrum {
    if nonlinear { rho.map(|r| r / (1.0 - r * internal)) } else { rho * (1.0 / (1.0 - internal)) }
}

/// w of (3): the coat's share of the samples.
#[inline]
pub(super) fn specular_weight(specular: Spectrum, diffuse: Spectrum) -> f32 {
    let (s, d) = (specular.average(), diffuse.average());
    if s + d > 0.0 { s / (s + d) } else { 1.0 }
}

/// Smooth plastic, one-sided.
#[derive(Clone, Copy, Debug)]
pub struct Plastic {
    coat: PlasticCoat,
    specular: Spectrum,
    /// ρ'/η².
    base: Spectrum,
    weight: f32,
}

impl Plastic {
    /// With base colour `diffuse` and factor `specular` of the coat's reflection, both in [0, 1].
    #[inline]
    pub fn new(
        coat: PlasticCoat,
        diffuse: Spectrum,
        specular: Spectrum,
        nonlinear: bool,
    ) -> Plastic {
        Plastic {
            coat,
            specular,
            base: base_albedo(diffuse, coat.internal, nonlinear) * coat.inv_eta2,
            weight: specular_weight(specular, diffuse),
        }
    }

    #[inline]
    fn fresnel(&self, cos: f32) -> f32 {
        fresnel_dielectric(cos, self.coat.eta).reflectance
    }

    /// Probability of the coat's reflection, (3), for its reflectance `f`.
    #[inline]
    fn choice(&self, f: f32, lobes: Lobes) -> f32 {
        if !lobes.has(Lobes::DELTA_REFLECTION) {
            return 0.0;
        }
        if !lobes.has(Lobes::DIFFUSE_REFLECTION) {
            return 1.0;
        }
        let (coat, base) = (f * self.weight, (1.0 - f) * (1.0 - self.weight));
        if coat + base > 0.0 { coat / (coat + base) } else { 1.0 }
    }

    #[inline]
    fn is_lit(wo: Vec3, wi: Vec3, lobes: Lobes) -> bool {
        wo.z > 0.0 && wi.z > 0.0 && lobes.has(Lobes::DIFFUSE_REFLECTION)
    }
}

impl Scatter for Plastic {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> Spectrum {
        if !Plastic::is_lit(wo, wi, lobes) {
            return Spectrum::ZERO;
        }
        let through = (1.0 - self.fresnel(wo.z)) * (1.0 - self.fresnel(wi.z));
        self.base * (through * INV_PI * wi.z) // (1)
    }

    #[inline]
    fn pdf(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> (f32, f32) {
        if !Plastic::is_lit(wo, wi, lobes) {
            return (0.0, 0.0);
        }
        let density = |from: Vec3, to: Vec3| {
            let base = 1.0 - self.choice(self.fresnel(from.z), lobes);
            base * warp::cosine_hemisphere_pdf_w(to.z)
        };
        (density(wo, wi), density(wi, wo))
    }

    #[inline]
    fn sample(&self, wo: Vec3, uc: f32, u2: Vec2, _: Mode, lobes: Lobes) -> Option<BsdfSample> {
        if wo.z <= 0.0 || !lobes.has(self.lobes()) {
            return None;
        }
        let f = self.fresnel(wo.z);
        let coat = self.choice(f, lobes);
        if uc < coat {
            return Some(BsdfSample {
                wi: Vec3::new(-wo.x, -wo.y, wo.z),
                weight: self.specular * (f / coat),
                pdf: coat,
                pdf_rev: coat,
                eta: 1.0,
                lobe: Lobes::DELTA_REFLECTION,
            });
        }
        let wi = warp::cosine_hemisphere(u2);
        let f_i = self.fresnel(wi.z);
        let pdf = (1.0 - coat) * warp::cosine_hemisphere_pdf_w(wi.z);
        (pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: self.base * ((1.0 - f) * (1.0 - f_i) / (1.0 - coat)),
            pdf,
            pdf_rev: (1.0 - self.choice(f_i, lobes)) * warp::cosine_hemisphere_pdf_w(wo.z),
            eta: 1.0,
            lobe: Lobes::DIFFUSE_REFLECTION,
        })
    }

    /// Exact.
    #[inline]
    fn albedo(&self, wo: Vec3) -> Spectrum {
        if wo.z <= 0.0 {
            return Spectrum::ZERO;
        }
        let f = self.fresnel(wo.z);
        self.specular * f + self.base * ((1.0 - f) * self.coat.entering)
    }

    /// The base's; the coat is a Dirac lobe.
    #[inline]
    fn roughness(&self) -> f32 {
        if self.base.is_black() { 0.0 } else { 1.0 }
    }

    #[inline]
    fn lobes(&self) -> Lobes {
        if self.base.is_black() {
            Lobes::DELTA_REFLECTION
        } else {
            Lobes::DELTA_REFLECTION | Lobes::DIFFUSE_REFLECTION
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Expect, check_model};
    use super::*;

    #[test]
    fn smooth_plastic_holds_the_contract() {
        let coat = PlasticCoat::new(1.49);
        let diffuse = Spectrum([0.1, 0.5, 0.9, 0.0]);
        for nonlinear in [false, true] {
            let model = Plastic::new(coat, diffuse, Spectrum::splat(0.8), nonlinear);
            check_model("plastic", &model, Expect::default());
        }
        let glossy = Plastic::new(coat, Spectrum::ZERO, Spectrum::ONE, false);
        check_model("black plastic", &glossy, Expect::default());
    }

    /// A white base loses nothing: all that enters comes out again.
    #[test]
    fn white_plastic_is_lossless() {
        for eta in [1.49, 1.9] {
            for nonlinear in [false, true] {
                let coat = PlasticCoat::new(eta);
                let model = Plastic::new(coat, Spectrum::ONE, Spectrum::ONE, nonlinear);
                let expect = Expect { albedo: Some((1.0, 1e-3)), ..Expect::default() };
                check_model("white plastic", &model, expect);
            }
        }
    }
}
