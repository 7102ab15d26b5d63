//! The functions that the solid and the thin principled models are made of.
//!
//! ```text
//! weight     s(c) = (1 - c)⁵                                                          (1)
//! diffuse    f_d = (1 - s(cos θₒ)/2)(1 - s(cos θᵢ)/2)                                 (2)
//! retro      f_r = R (sₒ + sᵢ + sₒ sᵢ (R - 1)),  R = 2 roughness cos² θ_d              (3)
//! flattened  f_s = 1.25 (F_ss (1/(cos θₒ + cos θᵢ) - ½) + ½),
//!            F_ss = (1 - sₒ + sₒ R/2)(1 - sᵢ + sᵢ R/2)                                (4)
//! clear coat D(m) = (α² - 1) / (π ln α² (1 + (α² - 1) cos² θₘ))                       (5)
//! facets     αᵤ = roughness²/a,  αᵥ = roughness² a,  a = √(1 - 0.9 anisotropic)        (6)
//! ```
//!
//! Burley 2012, "Physically based shading at Disney" (1-3, 5: his GTR1, 6), and 2015,
//! "Extending the Disney BRDF to a BSDF with integrated subsurface scattering" (4), with the
//! constants of Mitsuba 3.

use super::super::fresnel::fresnel_dielectric;
use super::super::{Masking, Microfacet};
use crate::description::Distribution;
use kaustika_math::{Vec2, Vec3, lerp, safe_sqrt, sqr};
use kaustika_spectra::Spectrum;
use std::f32::consts::PI;

/// Least roughness α of the facets.
const ALPHA_LEAST: f32 = 1e-3;

/// Schlick's weight (1).
#[inline]
pub fn schlick_weight(cos: f32) -> f32 {
    let m = (1.0 - cos).clamp(0.0, 1.0);
    sqr(sqr(m)) * m
}

/// Schlick's weight for light from above on an interface of index `eta` below over above; in
/// the thinner medium's angle.
#[inline]
pub fn schlick_weight_from_above(cos: f32, eta: f32) -> f32 {
    schlick_weight(if eta > 1.0 { cos } else { fresnel_dielectric(cos, eta).cos_t })
}

/// Reflectance at normal incidence of an interface of index `eta`.
#[inline]
pub fn normal_reflectance(eta: f32) -> f32 {
    sqr((eta - 1.0) / (eta + 1.0))
}

/// `color` at luminance 1; white if it is black.
#[inline]
pub fn hue(color: Spectrum, luminance: f32) -> Spectrum {
    if luminance > 0.0 { color / luminance } else { Spectrum::ONE }
}

/// The main lobe's facets (6), masked as in Mitsuba.
#[inline]
pub fn facets(roughness: f32, anisotropic: f32) -> Microfacet {
    let square = sqr(roughness);
    let aspect = safe_sqrt(1.0 - 0.9 * anisotropic).max(1e-3);
    let (u, v) = ((square / aspect).max(ALPHA_LEAST), (square * aspect).max(ALPHA_LEAST));
    Microfacet::new(Distribution::Ggx, u, v).with_masking(Masking::Separable)
}

/// π f of the diffuse part over the base colour: (2-4), `cos_d` = ωᵢ·m.
#[inline]
pub fn diffuse(cos_o: f32, cos_i: f32, cos_d: f32, roughness: f32, flatness: f32) -> f32 {
    let (so, si) = (schlick_weight(cos_o), schlick_weight(cos_i));
    let plain = (1.0 - 0.5 * so) * (1.0 - 0.5 * si); // (2)
    let r = 2.0 * roughness * sqr(cos_d);
    let retro = r * (so + si + so * si * (r - 1.0)); // (3)
    if flatness == 0.0 {
        return plain + retro;
    }
    let fss = lerp(so, 1.0, 0.5 * r) * lerp(si, 1.0, 0.5 * r);
    let flat = 1.25 * (fss * (1.0 / (cos_o + cos_i) - 0.5) + 0.5); // (4)
    lerp(flatness, plain + retro, flat)
}

/// ∫ s(cos θ_d) cos θᵢ dωᵢ for a unit sheen: what it adds to the albedo. A fit within 0.004.
#[inline]
pub fn sheen_albedo(mu: f32) -> f32 {
    0.088 * (1.0 - mu).powf(2.5)
}

/// Normals of the clear coat.
#[derive(Clone, Copy, Debug)]
pub struct ClearCoat {
    alpha2: f32,
}

impl ClearCoat {
    /// α from 0.1 at no gloss to 0.001 at full.
    #[inline]
    pub fn new(gloss: f32) -> ClearCoat {
        ClearCoat { alpha2: sqr(lerp(gloss, 0.1, 0.001)) }
    }

    /// D(m): (5), ∫ D cos θ dω = 1.
    #[inline]
    pub fn d(self, m: Vec3) -> f32 {
        // 1 + (α² - 1) cos² θ = sin² θ + α² cos² θ, which keeps its digits.
        let t = sqr(m.x) + sqr(m.y) + self.alpha2 * sqr(m.z);
        (self.alpha2 - 1.0) / (PI * self.alpha2.ln() * t)
    }

    /// A normal with density D cos θ.
    #[inline]
    pub fn sample(self, u: Vec2) -> Vec3 {
        // α² + (1 - α²) sin² θ = α^{2(1-u)}.
        let t = (self.alpha2.ln() * (1.0 - u.y)).exp();
        let sin2 = ((t - self.alpha2) / (1.0 - self.alpha2)).clamp(0.0, 1.0);
        let (s, c) = (2.0 * PI * u.x).sin_cos();
        let sin = sin2.sqrt();
        Vec3::new(sin * c, sin * s, (1.0 - sin2).sqrt())
    }

    /// Masking and shadowing, Smith's for GGX of α = 0.25 whatever the gloss (Burley 2012).
    #[inline]
    pub fn g2(wo: Vec3, wi: Vec3) -> f32 {
        let g1 = |w: Vec3| {
            let tan2 = (sqr(w.x) + sqr(w.y)) / sqr(w.z);
            2.0 / (1.0 + (1.0 + 0.0625 * tan2).sqrt())
        };
        g1(wo) * g1(wi)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::testing::Random;
    use super::*;
    use kaustika_math::warp;

    /// The sheen's part of the albedo against a Monte-Carlo estimate.
    #[test]
    fn sheen_albedo_fits() {
        let mut random = Random::new(5);
        for k in 0..=10 {
            let mu = (k as f32 / 10.0).max(0.01);
            let wo = Vec3::new((1.0 - mu * mu).sqrt(), 0.0, mu);
            let n = 100_000;
            let mut sum = 0.0;
            for _ in 0..n {
                let wi = warp::cosine_hemisphere(random.next_2d());
                sum += (PI * schlick_weight(wi.dot((wo + wi).normalize()))) as f64;
            }
            let (exact, fit) = (sum / n as f64, sheen_albedo(mu) as f64);
            assert!((exact - fit).abs() < 0.004, "{mu}: {exact} {fit}");
        }
    }
}
