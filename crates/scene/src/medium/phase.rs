//! Phase functions: into which directions a medium scatters.
//!
//! ```text
//! ∫ p(ωₒ, ωᵢ) dωᵢ = 1,   p depends on cos θ = -ωₒ·ωᵢ alone, but for microflakes        (1)
//! isotropic  1/4π
//! HG         (1 - g²) / (4π (1 + g² - 2g cos θ)^(3/2))                               (2)
//! Rayleigh   3 (1 + cos²θ) / 16π                                                     (3)
//! ```
//!
//! Henyey & Greenstein 1941, "Diffuse radiation in the galaxy"; Rayleigh 1871; sampled by
//! inversion, (3) after Frisvad 2011, "Importance sampling the Rayleigh phase function". ωₒ and ωᵢ
//! point away from the point of scattering; θ is the angle between the directions of flight.

use super::Sggx;
use crate::description::PhaseDesc;
use kaustika_math::{Frame, ONE_MINUS_EPSILON, Vec2, Vec3, safe_sqrt};
use kaustika_sampling::distribution::PiecewiseLinear1D;
use std::f32::consts::PI;

/// A phase function: its value is the density of its samples.
#[derive(Debug)]
pub enum Phase {
    /// Alike in all directions.
    Isotropic,
    /// Henyey and Greenstein's, of this mean cosine.
    HenyeyGreenstein(f32),
    /// Rayleigh's.
    Rayleigh,
    /// The first with the rest of this share, the second with it.
    Blend(f32, Box<Phase>, Box<Phase>),
    /// Linear between values at even steps of cos θ.
    Tabulated(PiecewiseLinear1D),
    /// Of microflakes, which also scale the extinction.
    Sggx(Sggx),
}

impl Phase {
    /// Prepares a description.
    pub fn new(desc: &PhaseDesc) -> Phase {
        match desc {
            PhaseDesc::Isotropic => Phase::Isotropic,
            // At ±1 all light goes one way: a Dirac distribution.
            PhaseDesc::HenyeyGreenstein { g } => Phase::HenyeyGreenstein(g.clamp(-0.999, 0.999)),
            PhaseDesc::Rayleigh => Phase::Rayleigh,
            PhaseDesc::Blend { weight, a, b } => {
                let (a, b) = (Box::new(Phase::new(a)), Box::new(Phase::new(b)));
                Phase::Blend(weight.clamp(0.0, 1.0), a, b)
            }
            PhaseDesc::Tabulated { values } => {
                PiecewiseLinear1D::new(values).map_or(Phase::Isotropic, Phase::Tabulated)
            }
            PhaseDesc::Sggx(desc) => Phase::Sggx(Sggx::new(desc)),
        }
    }

    /// p(wo, wi) at the point `p` of the world, 1/sr.
    #[inline]
    pub fn eval(&self, p: Vec3, wo: Vec3, wi: Vec3) -> f32 {
        self.value((p, wo, wi), (-wo.dot(wi)).clamp(-1.0, 1.0))
    }

    /// Its value, the direction of flight turning by the angle of this cosine.
    fn value(&self, at: (Vec3, Vec3, Vec3), cos: f32) -> f32 {
        match self {
            Phase::Isotropic => 0.25 / PI,
            Phase::HenyeyGreenstein(g) => {
                // 1 + g² - 2g cos θ, without its cancellation where g and the cosine are near 1.
                let d = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos);
                0.25 / PI * (1.0 - g * g) / (d * d.sqrt()) // (2)
            }
            Phase::Rayleigh => 3.0 / (16.0 * PI) * (1.0 + cos * cos), // (3)
            Phase::Blend(weight, a, b) => {
                (1.0 - weight) * a.value(at, cos) + weight * b.value(at, cos)
            }
            // A density over (cos θ + 1)/2 and the azimuth.
            Phase::Tabulated(table) => table.pdf(0.5 * (cos + 1.0)) / (4.0 * PI),
            Phase::Sggx(sggx) => {
                let (p, wo, wi) = at;
                sggx.at(p).eval(wo, wi)
            }
        }
    }

    /// At the point `p` of the world, a direction with density p(wo, ·), and that density.
    pub fn sample(&self, p: Vec3, wo: Vec3, u: Vec2) -> (Vec3, f32) {
        let (part, ux) = self.part(u.x);
        if let Phase::Sggx(sggx) = part {
            let wi = sggx.at(p).sample(wo, Vec2::new(ux, u.y));
            return (wi, self.eval(p, wo, wi));
        }
        let cos = part.sample_cosine(ux).clamp(-1.0, 1.0);
        let sin = safe_sqrt(1.0 - cos * cos);
        let (s, c) = (2.0 * PI * u.y).sin_cos();
        let wi = Frame::from_normal(-wo).to_world(Vec3::new(sin * c, sin * s, cos));
        (wi, self.value((p, wo, wi), cos))
    }

    /// The part of a sum that `u` chooses, and what is left of `u`.
    fn part(&self, u: f32) -> (&Phase, f32) {
        match self {
            Phase::Blend(weight, _, b) if u < *weight => {
                b.part((u / weight).min(ONE_MINUS_EPSILON))
            }
            Phase::Blend(weight, a, _) => {
                a.part(((u - weight) / (1.0 - weight)).min(ONE_MINUS_EPSILON))
            }
            _ => (self, u),
        }
    }

    fn sample_cosine(&self, u: f32) -> f32 {
        match self {
            // What has parts or no cosine is drawn in `sample`.
            Phase::Isotropic | Phase::Blend(..) | Phase::Sggx(_) => 2.0 * u - 1.0,
            Phase::HenyeyGreenstein(g) => {
                // ((1 + g²) - ((1 - g²)/(1 + gc))²)/2g, multiplied out: exact about g = 0 too.
                let (g, c) = (*g, 2.0 * u - 1.0);
                let c2 = c * c;
                let top = 2.0 * c * (1.0 + g * g) + g * (c2 + 3.0) + g * g * g * (c2 - 1.0);
                top / (2.0 * (1.0 + g * c) * (1.0 + g * c))
            }
            Phase::Rayleigh => {
                let q = 4.0 * u - 2.0;
                let a = (q + (1.0 + q * q).sqrt()).cbrt();
                a - 1.0 / a
            }
            Phase::Tabulated(table) => 2.0 * table.sample(u).0 - 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::special::gamma_q;

    fn hg(g: f32) -> PhaseDesc {
        PhaseDesc::HenyeyGreenstein { g }
    }

    /// Phase functions and their mean cosines.
    fn all() -> Vec<(&'static str, PhaseDesc, f64)> {
        let blend = |weight, a, b| PhaseDesc::Blend { weight, a: Box::new(a), b: Box::new(b) };
        // Linear, p = (1 + cos θ)/4π: its mean cosine is 1/3.
        let table = PhaseDesc::Tabulated { values: vec![0.0, 2.0, 4.0] };
        vec![
            ("isotropic", PhaseDesc::Isotropic, 0.0),
            ("hg 0", hg(0.0), 0.0),
            ("hg 1e-4", hg(1e-4), 1e-4),
            ("hg 0.6", hg(0.6), 0.6),
            ("hg -0.3", hg(-0.3), -0.3),
            ("hg 0.95", hg(0.95), 0.95),
            ("rayleigh", PhaseDesc::Rayleigh, 0.0),
            ("blend", blend(0.25, hg(0.8), hg(-0.4)), 0.75 * 0.8 - 0.25 * 0.4),
            ("blend of blend", blend(0.5, blend(1.0, hg(0.9), hg(0.2)), PhaseDesc::Rayleigh), 0.1),
            ("table", table, 1.0 / 3.0),
        ]
    }

    /// ∫ f(cos θ) p dω by Gauss and Legendre's rule of two points over cells that shrink toward
    /// both poles.
    fn integral(phase: &Phase, from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
        const N: usize = 4000;
        // cos = -cos(π s): cells as the square of the step at the poles.
        let s = |c: f64| (-c).acos() / std::f64::consts::PI;
        let (a, b) = (s(from), s(to));
        let mut sum = 0.0;
        for i in 0..N {
            for node in [0.211_324_865_405_187_1, 0.788_675_134_594_812_9] {
                let at = std::f64::consts::PI * (a + (b - a) * (i as f64 + node) / N as f64);
                let cos = -at.cos();
                let p = phase.value((Vec3::ZERO, Vec3::Z, Vec3::Z), cos as f32) as f64;
                sum += f(cos) * p * at.sin() * 0.5 * (b - a) / N as f64;
            }
        }
        sum * 2.0 * std::f64::consts::PI * std::f64::consts::PI
    }

    #[test]
    fn integrals_and_mean_cosines() {
        for (name, desc, g) in all() {
            let phase = Phase::new(&desc);
            let one = integral(&phase, -1.0, 1.0, |_| 1.0);
            assert!((one - 1.0).abs() < 1e-4, "{name}: {one}");
            let mean = integral(&phase, -1.0, 1.0, |c| c);
            assert!((mean - g).abs() < 1e-4, "{name}: {mean}, expected {g}");
        }
    }

    /// χ² of the cosine over 64 cells and of the azimuth over 16, at a family-wise level of 1 %.
    #[test]
    fn samples_follow_the_value() {
        const N: usize = 40_000;
        let (cells, turns) = (64, 16);
        let level = 0.01 / (2 * all().len()) as f64;
        for (k, (name, desc, _)) in all().into_iter().enumerate() {
            let phase = Phase::new(&desc);
            let wo = Vec3::new(0.3, -0.5, 0.7).normalize();
            let frame = Frame::from_normal(-wo);
            let (mut cosines, mut azimuths) = (vec![0.0; cells], vec![0.0; turns]);
            for i in 0..N {
                let h = kaustika_math::mix_bits((k * N + i) as u64 + 1);
                let unit = |bits: u64| (bits & 0xff_ffff) as f32 / (1 << 24) as f32;
                let (wi, pdf) = phase.sample(Vec3::ZERO, wo, Vec2::new(unit(h), unit(h >> 32)));
                assert!((wi.length() - 1.0).abs() < 1e-5, "{name}");
                let value = phase.eval(Vec3::ZERO, wo, wi);
                assert!((value - pdf).abs() <= 2e-3 * pdf, "{name}: {value} {pdf}");
                assert_eq!(value, phase.eval(Vec3::ZERO, wi, wo), "{name}: not reciprocal");
                let w = frame.to_local(wi);
                // Cells of equal angle.
                let angle = (-w.z).clamp(-1.0, 1.0).acos() / PI;
                cosines[((angle * cells as f32) as usize).min(cells - 1)] += 1.0;
                let turn = w.y.atan2(w.x) / (2.0 * PI) + 0.5;
                azimuths[((turn * turns as f32) as usize).min(turns - 1)] += 1.0;
            }
            let expected: Vec<f64> = (0..cells)
                .map(|i| {
                    let edge = |i: usize| -(std::f64::consts::PI * i as f64 / cells as f64).cos();
                    N as f64 * integral(&phase, edge(i), edge(i + 1), |_| 1.0)
                })
                .collect();
            let (mut chi2, mut count, mut rest) = (0.0, 0, (0.0, 0.0));
            for (o, e) in cosines.iter().zip(&expected) {
                if *e < 5.0 {
                    rest = (rest.0 + o, rest.1 + e);
                } else {
                    chi2 += (o - e) * (o - e) / e;
                    count += 1;
                }
            }
            if rest.1 >= 5.0 {
                chi2 += (rest.0 - rest.1) * (rest.0 - rest.1) / rest.1;
                count += 1;
            }
            let p = gamma_q(0.5 * (count - 1) as f64, 0.5 * chi2);
            assert!(p > level, "{name}: chi² = {chi2:.1} over {count} cells of the angle");
            let e = N as f64 / turns as f64;
            let chi2: f64 = azimuths.iter().map(|o| (o - e) * (o - e) / e).sum();
            let p = gamma_q(0.5 * (turns - 1) as f64, 0.5 * chi2);
            assert!(p > level, "{name}: chi² = {chi2:.1} of the azimuth");
        }
    }

    #[test]
    fn values_of_the_books() {
        // Forward and backward by (2): (1 + g)/(4π (1 - g)²), (1 - g)/(4π (1 + g)²).
        let phase = Phase::new(&hg(0.5));
        assert!((phase.eval(Vec3::ZERO, -Vec3::Z, Vec3::Z) - 6.0 / (4.0 * PI)).abs() < 1e-5);
        assert!((phase.eval(Vec3::ZERO, Vec3::Z, Vec3::Z) - 0.5 / 2.25 / (4.0 * PI)).abs() < 1e-6);
        let rayleigh = Phase::new(&PhaseDesc::Rayleigh);
        assert!((rayleigh.eval(Vec3::ZERO, Vec3::Z, Vec3::X) - 3.0 / (16.0 * PI)).abs() < 1e-7);
    }
}
