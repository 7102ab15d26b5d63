//! Phong's lobe made physical, with a Lambert part (Lafortune & Willems 1994, "Using the modified
//! Phong reflectance model for physically based rendering").
//!
//! ```text
//! f = ρ_d/π + ρ_s (n+2)/(2π) cosⁿ α,   α between ωᵢ and the mirror direction of ωₒ     (1)
//! pdf_s(ωᵢ) = (n+1)/(2π) cosⁿ α                                                       (2)
//! ```
//!
//! The specular albedo is ρ_s at normal incidence and falls about as cos θₒ, for the lobe sinks
//! below the horizon: with ρ_d + ρ_s <= 1 no light is made. Half maximum at α = arccos(2^(-1/n)).
//! Phong's own form (1975), without the factor (n+2)/2π and the cosine, conserves nothing.

use super::share::{classes, glossy_share};
use super::{BsdfSample, Lobes, Mode, Scatter};
use kaustika_math::{Frame, INV_PI, INV_TWO_PI, Vec2, Vec3, safe_sqrt, special, sqr, warp};
use kaustika_spectra::Spectrum;
use std::f32::consts::PI;

/// A glossy and matte, one-sided surface.
#[derive(Clone, Copy, Debug)]
pub struct Phong {
    /// Diffuse albedo ρ_d.
    pub diffuse: Spectrum,
    /// Specular albedo ρ_s at normal incidence; ρ_d + ρ_s <= 1.
    pub specular: Spectrum,
    /// Exponent n >= 0.
    pub exponent: f32,
}

impl Phong {
    /// cosⁿ α, zero behind the mirror direction. From the distance of the directions, so that
    /// sharp lobes keep their digits.
    #[inline]
    fn lobe(&self, wo: Vec3, wi: Vec3) -> f32 {
        let mirror = Vec3::new(-wo.x, -wo.y, wo.z);
        let one_minus_cos = 0.5 * (mirror - wi).length_squared();
        if one_minus_cos >= 1.0 {
            return 0.0;
        }
        (self.exponent * (-one_minus_cos).ln_1p()).exp()
    }

    #[inline]
    fn share(&self, lobes: Lobes) -> Option<f32> {
        glossy_share(lobes, self.specular, self.diffuse)
    }

    /// Specular albedo over ρ_s. The z of a lobe about height μ behaves like a normal deviate:
    /// E[z⁺] = μ Φ(μ/s) + s φ(μ/s); s from the exact value at grazing incidence,
    /// Γ((n+1)/2)/(2√π Γ(n/2+1)).
    fn specular_albedo(&self, mu: f32) -> f32 {
        let x = 0.5 * self.exponent;
        // Γ(x+½)/Γ(x+1) ≈ 1/√(x + ¼ + 1/(32x+8)); the last number makes it exact at 0.
        let grazing = 0.5 / (PI * (x + 0.25 + 1.0 / (32.0 * x + 14.6))).sqrt();
        let s = (2.0 * PI).sqrt() * grazing * safe_sqrt(1.0 - sqr(mu));
        if mu > 6.0 * s {
            return mu;
        }
        let t = mu / s;
        let below = 0.5 * special::erfc((t * std::f32::consts::FRAC_1_SQRT_2) as f64) as f32;
        mu * (1.0 - below) + s * (-0.5 * sqr(t)).exp() / (2.0 * PI).sqrt()
    }
}

impl Scatter for Phong {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> Spectrum {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Spectrum::ZERO;
        }
        let mut f = Spectrum::ZERO;
        if lobes.has(Lobes::DIFFUSE_REFLECTION) {
            f += self.diffuse * INV_PI;
        }
        if lobes.has(Lobes::GLOSSY_REFLECTION) {
            f += self.specular * ((self.exponent + 2.0) * INV_TWO_PI * self.lobe(wo, wi));
        }
        f * wi.z // (1)
    }

    #[inline]
    fn pdf(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> (f32, f32) {
        let Some(share) = self.share(lobes) else { return (0.0, 0.0) };
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return (0.0, 0.0);
        }
        // α is the same from both ends.
        let specular = share * (self.exponent + 1.0) * INV_TWO_PI * self.lobe(wo, wi); // (2)
        let diffuse = |cos| (1.0 - share) * warp::cosine_hemisphere_pdf_w(cos);
        (specular + diffuse(wi.z), specular + diffuse(wo.z))
    }

    #[inline]
    fn sample(&self, wo: Vec3, uc: f32, u2: Vec2, mode: Mode, lobes: Lobes) -> Option<BsdfSample> {
        let share = self.share(lobes)?;
        if wo.z <= 0.0 {
            return None;
        }
        let (wi, lobe) = if uc < share {
            // 1 - cos α = 1 - u^{1/(n+1)}, without cancellation.
            let one_minus_cos = -((1.0 - u2.x).ln() / (self.exponent + 1.0)).exp_m1();
            let r = safe_sqrt(one_minus_cos * (2.0 - one_minus_cos));
            let (s, c) = (2.0 * PI * u2.y).sin_cos();
            let local = Vec3::new(r * c, r * s, 1.0 - one_minus_cos);
            let mirror = Frame::from_normal(Vec3::new(-wo.x, -wo.y, wo.z));
            (mirror.to_world(local).normalize(), Lobes::GLOSSY_REFLECTION)
        } else {
            (warp::cosine_hemisphere(u2), Lobes::DIFFUSE_REFLECTION)
        };
        BsdfSample::reflection(self, (wo, wi), (mode, lobes), lobe)
    }

    /// The specular part within 0.05 ρ_s for n < 1, within 0.01 ρ_s from n = 10 on.
    fn albedo(&self, wo: Vec3) -> Spectrum {
        self.diffuse + self.specular * self.specular_albedo(wo.z.clamp(0.0, 1.0))
    }

    /// Of the sharper lobe: √(2/(n+2)), the roughness of the microfacet lobe as wide.
    #[inline]
    fn roughness(&self) -> f32 {
        if self.specular.is_black() { 1.0 } else { (2.0 / (self.exponent + 2.0)).sqrt() }
    }

    #[inline]
    fn lobes(&self) -> Lobes {
        classes(self.specular, self.diffuse)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Expect, check_model};
    use super::*;

    fn phong(diffuse: f32, specular: f32, exponent: f32) -> Phong {
        let d = Spectrum([diffuse, 0.5 * diffuse, 0.0, 0.0]);
        let s = Spectrum([specular, 0.7 * specular, 0.2 * specular, 0.0]);
        Phong { diffuse: d, specular: s, exponent }
    }

    #[test]
    fn holds_the_contract() {
        for exponent in [0.0, 1.0, 10.0, 200.0, 1e4] {
            for (d, s) in [(0.5, 0.5), (0.0, 1.0), (1.0, 0.0)] {
                let albedo_error = if exponent < 10.0 { 0.05 } else { 0.01 };
                let expect = Expect { albedo_error, ..Expect::default() };
                check_model(&format!("Phong {exponent} {d} {s}"), &phong(d, s, exponent), expect);
            }
        }
    }

    /// Maximum at the mirror direction, half of it at arccos(2^(-1/n)), however one looks.
    #[test]
    fn the_lobe_has_its_place_and_width() {
        let wo = Vec3::new(0.3, -0.4, 0.75f32.sqrt());
        let mirror = Vec3::new(-wo.x, -wo.y, wo.z);
        for n in [1.0, 5.0, 50.0, 1000.0] {
            let model = phong(0.0, 1.0, n);
            let f = |wi: Vec3| model.eval(wo, wi, Mode::Radiance, Lobes::ALL)[0] / wi.z;
            let peak = f(mirror);
            assert!((peak - (n + 2.0) * INV_TWO_PI).abs() < 1e-4 * peak);
            let half = 0.5f32.powf(1.0 / n).acos();
            let (s, t) = mirror.coordinate_system();
            for k in 0..8 {
                let (y, x) = (k as f32).sin_cos();
                let aside = |angle: f32| mirror * angle.cos() + (s * x + t * y) * angle.sin();
                if aside(half).z > 0.0 {
                    assert!((f(aside(half)) - 0.5 * peak).abs() < 1e-3 * peak, "{n}");
                }
                assert!(f(aside(0.1 * half)) < peak);
            }
        }
    }
}
