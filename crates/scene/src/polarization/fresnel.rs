//! Fresnel's equations for polarized light, with the intensity left to [`crate::bsdf::fresnel`]:
//! matrices divided by their m₀₀. The frames' x axis is the normal of the plane of incidence (s).
//!
//! ```text
//! rₛ = (c - q)/(c + q),  r_p = (n²c - q)/(n²c + q),  q² = n² - s²,  Im q ≥ 0          (1)
//! ρ  = r_p/rₛ = (s² - q c)/(s² + q c)                                                (2)
//! reflection  b = (1 - |ρ|²)/(1 + |ρ|²) = 2 s² c Re q / N,
//!             c₂ = 2 Re ρ/(1 + |ρ|²)    = (s⁴ - c²|q|²)/N,
//!             d = 2 Im ρ/(1 + |ρ|²)     = -2 s² c Im q / N,   N = s⁴ + c²|q|²          (3)
//! refraction  t_p/tₛ = 1/κ,  κ = cos(θᵢ - θₜ):   b = (κ² - 1)/(κ² + 1),  c₂ = 2κ/(κ² + 1)  (4)
//! pane        R'ₛ = 2Rₛ/(1 + Rₛ),  T'ₛ = 1 - R'ₛ,  p alike,  x = rₛ r_p,
//!             C_R = x + (1 - Rₛ)(1 - R_p) x/(1 - x²),  C_T = (1 - Rₛ)(1 - R_p)/(1 - x²)    (5)
//! ```
//!
//! c and s are cosine and sine of the angle of incidence, n the index behind over that in front, real or η + ik
//! (for amplitudes E e^{-iωt}); b, c₂, d are the elements of a [diattenuating retarder](super::elements).
//! (1): Born & Wolf 1999, sec. 1.5 and 14.2, with r_p = -rₛ at normal incidence (the field's p axis is
//! turned with the ray). (2) follows from (1) and is real below and of modulus 1 under total reflection; (3)
//! needs no amplitude, no branch and no division but one. (5) adds the orders of reflection within the pane
//! without interference, as Stokes did for intensities: t t' = 1 - r².

use super::elements::diattenuating_retarder;
use super::{Mueller, Oriented, stokes_basis};
use kaustika_math::{Vec3, safe_sqrt, sqr};
use kaustika_spectra::Spectrum;

/// Normal of the plane of both directions; where there is none, any axis perpendicular to them.
#[inline]
pub fn plane_normal(wo: Vec3, wi: Vec3) -> Vec3 {
    let x = wi.cross(wo);
    if x.length_squared() < 1e-12 { stokes_basis(wo) } else { x.normalize() }
}

/// Squared cosine and sine of the angle of incidence on the facet that mirrors `wi` to `wo`,
/// without cancellation at either end.
#[inline]
fn incidence(wo: Vec3, wi: Vec3) -> (f32, f32) {
    let (c2, s2) = ((wo + wi).length_squared(), (wo - wi).length_squared());
    (c2 / (c2 + s2), s2 / (c2 + s2))
}

/// (Re q, |Im q|, |q|²) of (1) for n = `eta` + i `k`.
#[inline]
fn root(eta: f32, k: f32, s2: f32) -> (f32, f32, f32) {
    let re = eta * eta - k * k - s2;
    let norm = safe_sqrt(re * re + sqr(2.0 * eta * k));
    (safe_sqrt(0.5 * (norm + re)), safe_sqrt(0.5 * (norm - re)), norm)
}

/// Reflection (3) of light along -`wi` to `wo` at a smooth interface or facet with the complex
/// index `eta` + i `k`, lane by lane: under total reflection too.
#[inline]
pub fn reflection(wo: Vec3, wi: Vec3, eta: Spectrum, k: Spectrum) -> Oriented {
    let (c2, s2) = incidence(wo, wi);
    let c = c2.sqrt();
    let (mut b, mut c2d, mut d) = (Spectrum::ZERO, Spectrum::ZERO, Spectrum::ZERO);
    for lane in 0..4 {
        let (re, im, norm) = root(eta[lane], k[lane], s2);
        let n = sqr(s2) + c2 * norm;
        // An unused lane, η = k = 0, would be 0/0 at normal incidence.
        let inv = if n > 0.0 { 1.0 / n } else { 0.0 };
        b.0[lane] = 2.0 * s2 * c * re * inv;
        c2d.0[lane] = (sqr(s2) - c2 * norm) * inv;
        d.0[lane] = -2.0 * s2 * c * im * inv;
    }
    Oriented { mueller: diattenuating_retarder(b, c2d, d), x: plane_normal(wo, wi) }
}

/// Refraction (4) of light along -`wi` to `wo`, at whatever interface does that.
#[inline]
pub fn refraction(wo: Vec3, wi: Vec3) -> Oriented {
    let kappa = -wo.dot(wi);
    let inv = 1.0 / (sqr(kappa) + 1.0);
    Oriented { mueller: grey((sqr(kappa) - 1.0) * inv, 2.0 * kappa * inv), x: plane_normal(wo, wi) }
}

/// Rₛ, R_p and x of (5) at a real index `n`, short of total reflection.
#[inline]
fn amplitudes(c: f32, n: f32) -> [f32; 3] {
    let q = safe_sqrt(n * n - (1.0 - c * c));
    let (s, p) = ((c - q) / (c + q), (n * n * c - q) / (n * n * c + q)); // (1)
    [s * s, p * p, s * p]
}

/// (1 - Rₛ)(1 - R_p)/(1 - x²) of (5), from [`amplitudes`].
#[inline]
fn orders([s, p, x]: [f32; 3]) -> f32 {
    // Nothing enters at grazing incidence.
    if x < 1.0 { (1.0 - s) * (1.0 - p) / (1.0 - x * x) } else { 0.0 }
}

/// Reflection (5) of light along -`wi` to `wo` by a thin pane of index `eta` relative to both sides.
pub fn pane_reflection(wo: Vec3, wi: Vec3, eta: f32) -> Oriented {
    let (c2, s2) = incidence(wo, wi);
    if sqr(eta) <= s2 {
        return reflection(wo, wi, Spectrum::splat(eta), Spectrum::ZERO);
    }
    let [s, p, x] = amplitudes(c2.sqrt(), eta);
    let (rs, rp) = (2.0 * s / (1.0 + s), 2.0 * p / (1.0 + p));
    let cross = x * (1.0 + orders([s, p, x]));
    Oriented { mueller: normalised(rs, rp, cross), x: plane_normal(wo, wi) }
}

/// Transmission (5) to `wo` through a thin pane whose normal is `n`.
pub fn pane_transmission(wo: Vec3, n: Vec3, eta: f32) -> Oriented {
    let [s, p, x] = amplitudes(wo.dot(n).abs().min(1.0), eta);
    let (ts, tp) = ((1.0 - s) / (1.0 + s), (1.0 - p) / (1.0 + p));
    Oriented { mueller: normalised(ts, tp, orders([s, p, x])), x: plane_normal(wo, n) }
}

/// From the intensities of both components and c₂ times their mean.
#[inline]
fn normalised(s: f32, p: f32, cross: f32) -> Mueller {
    // Nothing passes at grazing incidence, nothing is reflected where the indices are equal.
    let inv = if s + p > 0.0 { 1.0 / (s + p) } else { 0.0 };
    grey((s - p) * inv, 2.0 * cross * inv)
}

#[inline]
fn grey(b: f32, c: f32) -> Mueller {
    diattenuating_retarder(Spectrum::splat(b), Spectrum::splat(c), Spectrum::ZERO)
}

#[cfg(test)]
mod tests;
