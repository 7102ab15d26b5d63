//! A smooth clear coat over a Lambert base, in closed form.
//!
//! With T = 1 - F at the coat, μ' the cosine inside, τ = exp(-thickness/μ') and n = ⌈max_depth/2⌉
//! reflections by the base at most:
//!
//! ```text
//! f = T(ωₐ)τ(ωₐ) T(ω_b)τ(ω_b) ρ/(π η²) Σ_{k<n} (ρ K)ᵏ                                   (1)
//! K = 2 ∫₀¹ F(μ') τ² μ' dμ'        what comes back to the base                          (2)
//! L = 2 ∫₀¹ (1 - F(μ')) τ μ' dμ'   what leaves                                          (3)
//! albedo = F(ωₐ) + T(ωₐ)τ(ωₐ) ρ L Σ_{k<n} (ρ K)ᵏ                                        (4)
//! ```
//!
//! For the light after a reflection by the base is always Lambert's.

use super::{Coat, geometric};
use crate::bsdf::fresnel::fresnel_dielectric;
use kaustika_math::{INV_PI, sqr};
use kaustika_spectra::Spectrum;

/// Nodes and weights of Gauss and Legendre's rule of eight points on [0,1].
const GAUSS: [(f32, f32); 8] = [
    (0.019_855_072, 0.050_614_27),
    (0.101_666_76, 0.111_190_52),
    (0.237_233_8, 0.156_853_32),
    (0.408_282_68, 0.181_341_89),
    (0.591_717_3, 0.181_341_89),
    (0.762_766_2, 0.156_853_32),
    (0.898_333_2, 0.111_190_52),
    (0.980_144_9, 0.050_614_27),
];

/// The closed form's constants.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slab {
    ior: f32,
    thickness: f32,
    /// ρ Σ (ρ K)ᵏ.
    series: Spectrum,
    /// K of (2).
    kept: f32,
    /// L of (3).
    leaving: f32,
}

impl Slab {
    /// Of a base of albedo `reflectance` under `coat`, whose roughness and scattering are ignored.
    pub fn new(reflectance: Spectrum, coat: &Coat) -> Slab {
        let (kept, leaving) = integrals(coat.ior, coat.thickness);
        let series = reflectance * geometric(reflectance * kept, coat.max_depth.div_ceil(2));
        Slab { ior: coat.ior, thickness: coat.thickness, series, kept, leaving }
    }

    /// K: how much of the base's light comes back to it from the coat's surface.
    pub fn kept(&self) -> f32 {
        self.kept
    }

    /// T τ at a cosine outside.
    #[inline]
    fn passes(&self, cos: f32) -> f32 {
        let f = fresnel_dielectric(cos, self.ior);
        if f.cos_t == 0.0 {
            return 0.0;
        }
        (1.0 - f.reflectance) * (-self.thickness / f.cos_t).exp()
    }

    /// f of (1) for the cosines of both directions.
    #[inline]
    pub fn value(&self, cos_a: f32, cos_b: f32) -> Spectrum {
        self.series * (self.passes(cos_a) * self.passes(cos_b) * INV_PI / sqr(self.ior))
    }

    /// (4) without F.
    #[inline]
    pub fn albedo(&self, cos: f32) -> Spectrum {
        self.series * (self.passes(cos) * self.leaving)
    }
}

/// K and L of (2) and (3), to about 1e-4.
fn integrals(ior: f32, thickness: f32) -> (f32, f32) {
    let passage = |mu: f32| (-thickness / mu).exp();
    let (mut kept, mut leaving) = (0.0, 0.0);
    if ior <= 1.0 {
        for (mu, weight) in GAUSS {
            let (f, tau) = (fresnel_dielectric(-mu, ior).reflectance, passage(mu));
            kept += 2.0 * mu * weight * f * sqr(tau);
            leaving += 2.0 * mu * weight * (1.0 - f) * tau;
        }
        return (kept, leaving);
    }
    // Total reflection up to the critical cosine; beyond, by the cosine c outside, which F is a
    // smooth function of: 2 μ dμ = 2 c dc/η².
    let critical = (1.0 - 1.0 / sqr(ior)).sqrt();
    for (x, weight) in GAUSS {
        let mu = x * critical;
        kept += 2.0 * mu * critical * weight * sqr(passage(mu));
        let outside = fresnel_dielectric(x, ior);
        let (f, tau) = (outside.reflectance, passage(outside.cos_t));
        let measure = 2.0 * x * weight / sqr(ior);
        kept += measure * f * sqr(tau);
        leaving += measure * (1.0 - f) * tau;
    }
    (kept, leaving)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::fresnel::fresnel_diffuse_reflectance;

    /// Without absorption K is the internal diffuse reflectance and L its complement; with it,
    /// both agree with a fine midpoint rule.
    #[test]
    fn integrals_are_right() {
        for ior in [0.7, 1.0, 1.3, 1.5, 2.0] {
            let (kept, leaving) = integrals(ior, 0.0);
            let exact = fresnel_diffuse_reflectance(1.0 / ior);
            assert!((kept - exact).abs() < 3e-4, "{ior}: {kept} {exact}");
            assert!((leaving + kept - 1.0).abs() < 3e-4, "{ior}: {leaving} {kept}");
            for thickness in [0.01, 0.3] {
                let (kept, leaving) = integrals(ior, thickness);
                let n = 20_000;
                let (mut a, mut b) = (0.0, 0.0);
                for i in 0..n {
                    let mu = (i as f64 + 0.5) / n as f64;
                    let f = fresnel_dielectric(-mu as f32, ior).reflectance as f64;
                    let tau = (-thickness as f64 / mu).exp();
                    a += 2.0 * mu * f * tau * tau / n as f64;
                    b += 2.0 * mu * (1.0 - f) * tau / n as f64;
                }
                assert!((kept as f64 - a).abs() < 1e-3, "{ior} {thickness}: {kept} {a}");
                assert!((leaving as f64 - b).abs() < 1e-3, "{ior} {thickness}: {leaving} {b}");
            }
        }
    }
}
