//! Hair and fur: a dielectric fibre with absorbing inside and tilted scales.
//!
//! The fibre lies along +x. θ is the angle of a direction from the plane across the fibre, φ its
//! azimuth in that plane, from +y to +z. h in [-1, 1] says how far from the fibre's middle the
//! ray of `wo` meets it, γ the angle between `wo` and the fibre's normal in that plane.
//!
//! ```text
//! f |cos ωᵢ| = Σ_p A_p(ωₒ) M_p(θₒ, θᵢ) N_p(φᵢ - φₒ)                                        (1)
//! M_p = e^{-sin θᵢ sin θₒ/v} I₀(cos θᵢ cos θₒ/v) / (2v sinh 1/v)                            (2)
//! N_p = l(φ - Φ_p; s), a logistic density trimmed to [-π, π];  N₃ = 1/2π                    (3)
//! Φ_p = 2pγₜ - 2γₒ + pπ                                                                    (4)
//! A₀ = F,  A_p = (1-F)² Tᵖ Fᵖ⁻¹,  A₃ = Σ_{p≥3} A_p;  F at cos θₒ cos γₒ                     (5)
//! T = exp(-2 σ cos γₜ/cos θₜ),  sin θₜ = sin θₒ/η,  sin γₜ = h cos θₒ/√(η² - sin²θₒ)         (6)
//! v₀ = (0.726 β + 0.812 β² + 3.7 β²⁰)²,  v₁ = v₀/4,  v₂ = v₃ = 4v₀,  β lengthwise            (7)
//! s = √(π/8) (0.265 β + 1.194 β² + 5.372 β²²),  β around                                    (8)
//! scales: θₒ turns by -2α, α, 4α for p = 0, 1, 2                                            (9)
//! σ = (ln C / (5.969 - 0.215 β + 2.532 β² - 10.73 β³ + 5.574 β⁴ + 0.245 β⁵))²,  β around    (10)
//! ```
//!
//! Chiang, Bitterli, Tappan & Burley 2016, "A Practical and Controllable Hair and Fur Model for
//! Production Path Tracing", eq. 1-9; (2) and the lobes after d'Eon et al. 2011, "An
//! Energy-Conserving Hair Reflectance Model". pbrt-v4 and Mitsuba 3 evaluate the same. M and N
//! are normalised over the sphere, so that the albedo is Σ A_p, 1 without absorption.
//!
//! The light of one call has passed the whole fibre: a surface must not be met again from inside.

use super::fresnel::fresnel_dielectric;
use super::{BsdfSample, Lobes, Mode, Scatter};
use kaustika_math::special::ln_i0;
use kaustika_math::{Vec2, Vec3, safe_sqrt, sqr};
use kaustika_spectra::Spectrum;
use std::f32::consts::{FRAC_PI_8, PI};

/// Number of lobes with an azimuth of their own: reflected, passed through, reflected once inside.
const LOBES: usize = 3;

/// Absorption σ of eumelanin at concentration 1, linear sRGB, in inverse radii (d'Eon et al. 2011).
pub const EUMELANIN: [f32; 3] = [0.419, 0.697, 1.37];

/// The same of pheomelanin.
pub const PHEOMELANIN: [f32; 3] = [0.187, 0.4, 1.05];

/// Where across the fibre a ray meets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Across {
    /// This far from the middle towards +y, in [-1, 1]: for flat ribbons that face the viewer.
    Offset(f32),
    /// As the shading normal says: for round fibres.
    Normal,
}

/// Parameters of [`Hair`].
#[derive(Clone, Copy, Debug)]
pub struct HairParameters {
    /// Where the ray meets the fibre.
    pub across: Across,
    /// Index inside over that outside, > 0 and not 1.
    pub eta: f32,
    /// Absorption σ in inverse radii, >= 0.
    pub sigma_a: Spectrum,
    /// Roughness along the fibre, in [0.01, 1] (taken into it).
    pub beta_m: f32,
    /// Roughness around it, in [0.01, 1].
    pub beta_n: f32,
    /// Tilt of the scales, radians.
    pub alpha: f32,
}

/// A fibre; see the module.
#[derive(Clone, Copy, Debug)]
pub struct Hair {
    across: Across,
    eta: f32,
    sigma_a: Spectrum,
    /// v of each lobe: (7).
    v: [f32; LOBES + 1],
    /// Scale of the logistic: (8).
    s: f32,
    /// Sine and cosine of the turn of each lobe: (9).
    tilt: [(f32, f32); LOBES],
}

/// σ that gives fibres seen in a dense bundle the colour `c` in [0, 1]: (10).
pub fn absorption_of_color(c: Spectrum, beta_n: f32) -> Spectrum {
    let b = beta_n;
    let scale = 5.969 + b * (-0.215 + b * (2.532 + b * (-10.73 + b * (5.574 + b * 0.245))));
    c.map(|c| sqr(c.clamp(1e-6, 1.0).ln() / scale))
}

/// A direction by the angles of a fibre.
#[derive(Clone, Copy)]
struct Angles {
    sin_theta: f32,
    cos_theta: f32,
    phi: f32,
}

impl Angles {
    fn of(w: Vec3) -> Angles {
        let sin_theta = w.x.clamp(-1.0, 1.0);
        Angles { sin_theta, cos_theta: safe_sqrt(1.0 - sqr(sin_theta)), phi: w.z.atan2(w.y) }
    }

    /// θ turned by an angle of the given sine and cosine.
    fn turned(&self, (sin, cos): (f32, f32)) -> Angles {
        Angles {
            sin_theta: self.sin_theta * cos + self.cos_theta * sin,
            cos_theta: (self.cos_theta * cos - self.sin_theta * sin).abs(),
            phi: self.phi,
        }
    }
}

/// What is known once `wo` is: every lobe with its share.
struct Paths {
    /// The direction, as each lobe sees it.
    wo: [Angles; LOBES + 1],
    /// Azimuth of each lobe's middle: φₒ + Φ_p.
    middle: [f32; LOBES],
    /// A_p.
    attenuation: [Spectrum; LOBES + 1],
    /// Probability of drawing from each, proportional to the mean of A_p.
    probability: [f32; LOBES + 1],
}

impl Hair {
    /// A fibre with the given parameters.
    pub fn new(p: HairParameters) -> Hair {
        let (m, n) = (p.beta_m.clamp(0.01, 1.0), p.beta_n.clamp(0.01, 1.0));
        let v = sqr(0.726 * m + 0.812 * sqr(m) + 3.7 * m.powi(20)); // (7)
        let s = FRAC_PI_8.sqrt() * (0.265 * n + 1.194 * sqr(n) + 5.372 * n.powi(22)); // (8)
        Hair {
            across: p.across,
            eta: p.eta,
            sigma_a: p.sigma_a.clamp_zero(),
            v: [v, 0.25 * v, 4.0 * v, 4.0 * v],
            s,
            tilt: [-2.0, 1.0, 4.0].map(|k| (k * p.alpha).sin_cos()), // (9)
        }
    }

    /// h of a ray that comes along `wo`.
    fn h(&self, wo: Vec3) -> f32 {
        match self.across {
            Across::Offset(y) => y.clamp(-1.0, 1.0),
            Across::Normal => {
                let across = wo.y.hypot(wo.z);
                if across > 0.0 { -wo.y / across } else { 0.0 }
            }
        }
    }

    /// The lobes seen from `wo`. At a fixed place the light that goes on to the camera comes from
    /// the other side of `wo`: the lobes of the adjoint mode are mirrored.
    fn paths(&self, wo: Vec3, mode: Mode) -> Paths {
        let h = self.h(wo);
        let o = Angles::of(wo);
        let cos_t = safe_sqrt(1.0 - sqr(o.sin_theta / self.eta)); // (6)
        let across = safe_sqrt(sqr(self.eta) - sqr(o.sin_theta));
        let sin_gamma_t = if across > 0.0 { h * o.cos_theta / across } else { 0.0 };
        let sin_gamma_t = sin_gamma_t.clamp(-1.0, 1.0);
        let (gamma_o, gamma_t) = (h.asin(), sin_gamma_t.asin());
        let length = 2.0 * safe_sqrt(1.0 - sqr(sin_gamma_t)) / cos_t.max(1e-4);
        let t = (self.sigma_a * -length).exp();
        let f = fresnel_dielectric(o.cos_theta * safe_sqrt(1.0 - sqr(h)), self.eta).reflectance;
        let through = t * sqr(1.0 - f);
        let inside = t * f;
        let rest = (through * inside * inside).safe_div(Spectrum::ONE - inside);
        let attenuation = [Spectrum::splat(f), through, through * inside, rest]; // (5)
        let means = attenuation.map(|a| a.average());
        let sum: f32 = means.iter().sum();
        let mirrored = mode == Mode::Importance && matches!(self.across, Across::Offset(_));
        let sign = if mirrored { -1.0 } else { 1.0 };
        let turned = |p: f32| o.phi + sign * (2.0 * p * gamma_t - 2.0 * gamma_o + p * PI); // (4)
        let seen = self.tilt.map(|turn| o.turned(turn));
        Paths {
            wo: [seen[0], seen[1], seen[2], o],
            middle: [0.0, 1.0, 2.0].map(turned),
            attenuation,
            probability: means.map(|m| if sum > 0.0 { m / sum } else { 0.0 }),
        }
    }

    /// M_p N_p of every lobe towards `wi`.
    fn densities(&self, paths: &Paths, wi: Vec3) -> [f32; LOBES + 1] {
        let i = Angles::of(wi);
        std::array::from_fn(|p| {
            let around = match paths.middle.get(p) {
                Some(middle) => trimmed_logistic(wrapped(i.phi - middle), self.s),
                None => 0.5 / PI,
            };
            longitudinal(&paths.wo[p], &i, self.v[p]) * around
        })
    }

    /// (1), and the density of sampling `wi` given `wo`, when `wo` is the camera's direction or
    /// (`mode`) the light's.
    fn value_and_density(&self, wo: Vec3, wi: Vec3, mode: Mode) -> (Spectrum, f32) {
        let paths = self.paths(wo, mode);
        let densities = self.densities(&paths, wi);
        let (mut value, mut density) = (Spectrum::ZERO, 0.0);
        for (p, d) in densities.into_iter().enumerate() {
            value += paths.attenuation[p] * d;
            density += paths.probability[p] * d;
        }
        (value, density)
    }
}

/// M of (2) with the variance `v`.
fn longitudinal(o: &Angles, i: &Angles, v: f32) -> f32 {
    let a = i.cos_theta * o.cos_theta / v;
    let b = i.sin_theta * o.sin_theta / v;
    // 2 sinh x = eˣ (1 - e⁻²ˣ).
    let norm = v * (1.0 - (-2.0 / v).exp());
    (ln_i0(a) - b - 1.0 / v).exp() / norm
}

/// Draws θᵢ with the density (2): its sine and cosine (d'Eon et al. 2013).
fn sample_longitudinal(o: &Angles, v: f32, u: Vec2) -> (f32, f32) {
    let e = (-2.0 / v).exp();
    let cos = (1.0 + v * (u.x + (1.0 - u.x) * e).max(f32::MIN_POSITIVE).ln()).clamp(-1.0, 1.0);
    let sin = safe_sqrt(1.0 - sqr(cos));
    let turn = (2.0 * PI * u.y).cos();
    let sin_theta = (-cos * o.sin_theta + sin * turn * o.cos_theta).clamp(-1.0, 1.0);
    (sin_theta, safe_sqrt(1.0 - sqr(sin_theta)))
}

/// An angle's equal in [-π, π].
fn wrapped(phi: f32) -> f32 {
    phi - 2.0 * PI * (phi / (2.0 * PI)).round()
}

/// Mass of the logistic distribution below `x`.
fn logistic_below(x: f32, s: f32) -> f32 {
    1.0 / (1.0 + (-x / s).exp())
}

/// Density of the logistic distribution trimmed to [-π, π] at `x` in it.
fn trimmed_logistic(x: f32, s: f32) -> f32 {
    let e = (-x.abs() / s).exp();
    e / (s * sqr(1.0 + e) * (logistic_below(PI, s) - logistic_below(-PI, s)))
}

/// Draws from [`trimmed_logistic`].
fn sample_trimmed_logistic(u: f32, s: f32) -> f32 {
    let low = logistic_below(-PI, s);
    let y = low + u * (logistic_below(PI, s) - low);
    (-s * (1.0 / y - 1.0).ln()).clamp(-PI, PI)
}

/// The class of light between two directions.
fn class(wo: Vec3, wi: Vec3) -> Lobes {
    if wo.z * wi.z > 0.0 { Lobes::GLOSSY_REFLECTION } else { Lobes::GLOSSY_TRANSMISSION }
}

impl Scatter for Hair {
    fn eval(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> Spectrum {
        self.eval_pdf(wo, wi, mode, lobes).0
    }

    fn pdf(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> (f32, f32) {
        self.eval_pdf(wo, wi, mode, lobes).1
    }

    fn eval_pdf(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> (Spectrum, (f32, f32)) {
        if !lobes.has(class(wo, wi)) || wo.z == 0.0 || wi.z == 0.0 {
            return (Spectrum::ZERO, (0.0, 0.0));
        }
        let (there, forward) = self.value_and_density(wo, wi, mode);
        let (back, reverse) = self.value_and_density(wi, wo, mode.adjoint());
        let value = match mode {
            Mode::Radiance => there,
            // The adjoint: f(ωᵢ, ωₒ) |cos ωᵢ|.
            Mode::Importance => back * (wi.z / wo.z).abs(),
        };
        (value, (forward, reverse))
    }

    fn sample(&self, wo: Vec3, uc: f32, u2: Vec2, mode: Mode, lobes: Lobes) -> Option<BsdfSample> {
        let paths = self.paths(wo, mode);
        let (mut p, mut rest) = (0, uc);
        while p < LOBES && rest >= paths.probability[p] {
            rest -= paths.probability[p];
            p += 1;
        }
        let u = (rest / paths.probability[p]).clamp(0.0, 1.0);
        let (sin_theta, cos_theta) = sample_longitudinal(&paths.wo[p], self.v[p], u2);
        let phi = match paths.middle.get(p) {
            Some(middle) => middle + sample_trimmed_logistic(u, self.s),
            None => 2.0 * PI * u,
        };
        let wi = Vec3::new(sin_theta, cos_theta * phi.cos(), cos_theta * phi.sin());
        let (value, (pdf, pdf_rev)) = self.eval_pdf(wo, wi, mode, lobes);
        if !(pdf > 0.0 && pdf.is_finite() && pdf_rev.is_finite()) {
            return None;
        }
        let weight = value / pdf;
        Some(BsdfSample { wi, weight, pdf, pdf_rev, eta: 1.0, lobe: class(wo, wi) })
    }

    /// Σ A_p, exact in radiance mode.
    fn albedo(&self, wo: Vec3) -> Spectrum {
        self.paths(wo, Mode::Radiance).attenuation.into_iter().fold(Spectrum::ZERO, |a, b| a + b)
    }

    fn roughness(&self) -> f32 {
        self.v[0].sqrt().min(1.0)
    }

    fn lobes(&self) -> Lobes {
        Lobes::GLOSSY
    }
}

#[cfg(test)]
mod tests;
