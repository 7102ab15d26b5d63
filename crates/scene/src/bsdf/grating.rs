//! A diffraction grating: lines along the second tangent that send each wavelength into orders.
//!
//! With the period d, order m and wavelength λ, for the components along the first tangent (x) and
//! along the lines (y):
//!
//! ```text
//! ωᵢ,x = -ωₒ,x + mλ/d,   ωᵢ,y = -ωₒ,y,   an order propagates while their squares sum below 1  (1)
//! sinusoidal phase: e_m = J_m²(a);  a = 2πh/λ reflected, πh(η-1)/λ transmitted                (2)
//! e₀' = Σ_m e_m - Σ_{m≠0, propagating} e_m                                                   (3)
//! ```
//!
//! (1) is the grating equation sin θ_m = sin θᵢ + mλ/d with the sign of a mirrored direction
//! (Born & Wolf 1999, sec. 8.6.1), (2) the thin phase grating of peak-to-peak depth h (Goodman
//! 2005, "Introduction to Fourier Optics", sec. 4.4.4), (3) keeps the energy of orders that can't
//! propagate in the mirror's. Efficiencies are the same for m and -m, so that light can be traced
//! both ways. Each wavelength goes elsewhere: a path keeps its hero; in RGB mode an order carries
//! one colour, at the dominant wavelength of its primary.

use super::{BsdfSample, Lobes, Mode, Scatter};
use kaustika_math::{Vec2, Vec3, sqr};
use kaustika_spectra::Spectrum;
use std::f32::consts::PI;

/// Highest order that is followed.
const HIGHEST: usize = 24;
/// Orders from -[`HIGHEST`] to [`HIGHEST`].
const ORDERS: usize = 2 * HIGHEST + 1;

/// Dominant wavelengths of the primaries of sRGB under D65, nm.
const PRIMARIES: [f32; 3] = [611.4, 549.1, 464.3];

/// How light is shared between the orders.
#[derive(Clone, Copy, Debug)]
pub enum GratingProfile<'a> {
    /// A sinusoidal relief of a peak-to-peak depth in nm; the index of its matter over that
    /// outside counts for transmission.
    Sinusoidal {
        /// Depth h, nm.
        depth: f32,
        /// Index η.
        eta: f32,
    },
    /// Efficiencies of the orders 0, ±1, ±2, ..., each >= 0; the first and twice the others sum to
    /// at most 1.
    Efficiencies(&'a [f32]),
}

/// Whose wavelengths are followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GratingLight {
    /// One wavelength, nm, for all lanes.
    Hero(f32),
    /// The lanes are red, green, blue.
    Rgb,
}

/// A grating; without transmission one-sided.
#[derive(Clone, Copy, Debug)]
pub struct Grating<'a> {
    /// Distance of the lines, nm, > 0.
    pub period: f32,
    /// Efficiencies.
    pub profile: GratingProfile<'a>,
    /// Multiplies all reflected orders, in [0, 1].
    pub reflectance: Spectrum,
    /// Multiplies all transmitted orders, in [0, 1]; with `reflectance` at most 1.
    pub transmittance: Spectrum,
    /// The path's colours.
    pub light: GratingLight,
}

/// J₀(x)² to J_N(x)² by the downward recurrence J_{n-1} = (2n/x) J_n - J_{n+1}, scaled so that
/// J₀ + 2 Σ J₂ₖ = 1 (Miller 1952).
fn squared_bessel(x: f32) -> [f32; HIGHEST + 1] {
    let mut out = [0.0; HIGHEST + 1];
    if x < 1e-3 {
        (out[0], out[1]) = (1.0 - 0.5 * sqr(x), 0.25 * sqr(x));
        return out;
    }
    let x = x as f64;
    let start = 2 * (HIGHEST.max(x as usize) / 2 + 12);
    let mut values = [0.0; HIGHEST + 1];
    let (mut above, mut here, mut sum) = (0.0f64, 1e-30f64, 0.0);
    for n in (0..=start).rev() {
        if n <= HIGHEST {
            values[n] = here;
        }
        if n % 2 == 0 {
            sum += if n == 0 { here } else { 2.0 * here };
        }
        (above, here) = (here, 2.0 * n as f64 / x * here - above);
        if here.abs() > 1e100 {
            (above, here, sum) = (above * 1e-100, here * 1e-100, sum * 1e-100);
            values.iter_mut().for_each(|v| *v *= 1e-100);
        }
    }
    (0..=HIGHEST).for_each(|n| out[n] = (values[n] / sum).powi(2) as f32);
    out
}

impl Grating<'_> {
    /// The wavelengths that lanes stand for.
    fn wavelengths(&self) -> &[f32] {
        match &self.light {
            GratingLight::Hero(lambda) => std::slice::from_ref(lambda),
            GratingLight::Rgb => &PRIMARIES,
        }
    }

    /// Direction of order `m` without its z; `None` if it does not propagate.
    fn order(&self, wo: Vec3, m: i32, lambda: f32) -> Option<Vec2> {
        let t = Vec2::new(-wo.x + m as f32 * lambda / self.period, -wo.y); // (1)
        (m == 0 || t.length_squared() < 1.0).then_some(t)
    }

    /// Efficiencies of orders from -[`HIGHEST`] on, with (3).
    fn efficiencies(&self, wo: Vec3, lambda: f32, transmits: bool) -> [f32; ORDERS] {
        let (given, total) = match self.profile {
            GratingProfile::Sinusoidal { depth, eta } => {
                let phase = if transmits { 0.5 * (eta - 1.0).abs() } else { 1.0 };
                (squared_bessel(2.0 * PI * depth * phase / lambda), 1.0) // (2)
            }
            GratingProfile::Efficiencies(list) => {
                let mut given = [0.0; HIGHEST + 1];
                given.iter_mut().zip(list).for_each(|(g, e)| *g = *e);
                (given, 2.0 * given.iter().sum::<f32>() - given[0])
            }
        };
        let mut out = [0.0; ORDERS];
        for (i, e) in out.iter_mut().enumerate() {
            let m = i as i32 - HIGHEST as i32;
            if m != 0 && self.order(wo, m, lambda).is_some() {
                *e = given[m.unsigned_abs() as usize];
            }
        }
        out[HIGHEST] = (total - out.iter().sum::<f32>()).max(0.0); // (3)
        out
    }

    /// Probability of reflection among `lobes`; `None` if nothing may be drawn.
    fn choice(&self, lobes: Lobes) -> Option<f32> {
        let on = |class, c: Spectrum| if lobes.has(class) { c.max_component() } else { 0.0 };
        let r = on(Lobes::DELTA_REFLECTION, self.reflectance);
        let t = on(Lobes::DELTA_TRANSMISSION, self.transmittance);
        (r + t > 0.0).then(|| r / (r + t))
    }

    fn is_one_sided(&self) -> bool {
        self.transmittance.is_black()
    }
}

impl Scatter for Grating<'_> {
    fn eval(&self, _: Vec3, _: Vec3, _: Mode, _: Lobes) -> Spectrum {
        Spectrum::ZERO
    }

    fn pdf(&self, _: Vec3, _: Vec3, _: Mode, _: Lobes) -> (f32, f32) {
        (0.0, 0.0)
    }

    fn sample(&self, wo: Vec3, uc: f32, u2: Vec2, _: Mode, lobes: Lobes) -> Option<BsdfSample> {
        if wo.z == 0.0 || self.is_one_sided() && wo.z < 0.0 {
            return None;
        }
        let pr = self.choice(lobes)?;
        let transmits = uc >= pr;
        let (side, tint, lobe) = match transmits {
            false => (pr, self.reflectance, Lobes::DELTA_REFLECTION),
            true => (1.0 - pr, self.transmittance, Lobes::DELTA_TRANSMISSION),
        };
        let lambdas = self.wavelengths();
        let n = lambdas.len();
        let color = ((u2.y * n as f32) as usize).min(n - 1);
        let all = self.efficiencies(wo, lambdas[color], transmits);
        let mut rest = u2.x;
        let drawn = all.iter().position(|e| {
            rest -= e;
            rest < 0.0 && *e > 0.0
        })?;
        let m = drawn as i32 - HIGHEST as i32;
        let t = self.order(wo, m, lambdas[color])?;
        let z = (1.0 - t.length_squared()).max(0.0).sqrt();
        let wi = Vec3::new(t.x, t.y, if transmits == (wo.z < 0.0) { z } else { -z });
        let (value, probability) = if m == 0 {
            // The mirror's order goes one way for all colours.
            let zero = |l: &f32| self.efficiencies(wo, *l, transmits)[HIGHEST];
            let mut value = Spectrum::splat(zero(&lambdas[0]));
            let mut mean = 0.0;
            for (lane, lambda) in lambdas.iter().enumerate() {
                let e = zero(lambda);
                mean += e / n as f32;
                if n > 1 {
                    value.0[lane] = e;
                }
            }
            (tint * value, mean)
        } else {
            let mut value = Spectrum::splat(if n > 1 { 0.0 } else { all[drawn] });
            value.0[color] = all[drawn];
            (tint * value, all[drawn] / n as f32)
        };
        let pdf = side * probability;
        (pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: value / pdf,
            pdf,
            pdf_rev: pdf,
            eta: 1.0,
            lobe,
        })
    }

    /// What all orders have together; exact.
    fn albedo(&self, wo: Vec3) -> Spectrum {
        if self.is_one_sided() && wo.z <= 0.0 {
            return Spectrum::ZERO;
        }
        let total = match self.profile {
            GratingProfile::Sinusoidal { .. } => 1.0,
            GratingProfile::Efficiencies(list) => {
                let orders = &list[..list.len().min(HIGHEST + 1)];
                2.0 * orders.iter().sum::<f32>() - orders.first().copied().unwrap_or(0.0)
            }
        };
        (self.reflectance + self.transmittance) * total
    }

    fn roughness(&self) -> f32 {
        0.0
    }

    fn lobes(&self) -> Lobes {
        let on = |class, c: Spectrum| if c.is_black() { Lobes::NONE } else { class };
        on(Lobes::DELTA_REFLECTION, self.reflectance)
            | on(Lobes::DELTA_TRANSMISSION, self.transmittance)
    }
}

#[cfg(test)]
mod tests;
