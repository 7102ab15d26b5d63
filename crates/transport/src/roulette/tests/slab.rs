//! Deep penetration of a slab in one dimension, the problem that weight windows were made for
//! (neutron transport; row 179 of the lecture's systems).
//!
//! ```text
//! a = Σ(1 - c/2),  b = Σ c/2,  κ = Σ√(1-c),  D = κ cosh κX + a sinh κX                       (1)
//! T = κ/D                                                 transmission                       (2)
//! J⁺(x) = (κ cosh κx + a sinh κx)/D,   J⁻(x) = b sinh κx/D    the adjoint: the probability to be
//!                                                          transmitted from x, going right, left
//! ```

use super::super::{Collision, Decision, Rule, Splitting, window};
use super::{Numbers, Statistics};
use crate::guiding::Expected;

/// Total cross-section 1, scattering ratio c, length X; scattered half forward, half back.
struct Slab {
    c: f64,
    length: f64,
}

impl Slab {
    fn kappa(&self) -> f64 {
        (1.0 - self.c).sqrt()
    }

    fn d(&self) -> f64 {
        let (a, k) = (1.0 - 0.5 * self.c, self.kappa());
        k * (k * self.length).cosh() + a * (k * self.length).sinh()
    }

    fn transmission(&self) -> f64 {
        self.kappa() / self.d()
    }

    /// Expected transmission of a collision at x: what the adjoint rule asks.
    fn reflected(&self, x: f64) -> f64 {
        let (a, b, k) = (1.0 - 0.5 * self.c, 0.5 * self.c, self.kappa());
        let right = (k * (k * x).cosh() + a * (k * x).sinh()) / self.d();
        let left = b * (k * x).sinh() / self.d();
        self.c * 0.5 * (right + left)
    }

    /// One history's estimate of T, and its flights.
    fn history(&self, splitting: Option<&Splitting>, numbers: &mut Numbers) -> (f64, f64) {
        let (mut sum, mut flights) = (0.0, 0.0);
        let mut open = vec![(0.0f64, 1.0f64, 1.0f64, 0u32)];
        while let Some((x, direction, weight, collisions)) = open.pop() {
            flights += 1.0;
            let x = x - direction * (1.0 - numbers.next()).ln();
            if x >= self.length {
                sum += weight;
            }
            if !(0.0..self.length).contains(&x) {
                continue;
            }
            let q = match splitting {
                // Analogue: absorbed with probability 1 - c.
                None => {
                    if numbers.next() < self.c {
                        let direction = if numbers.next() < 0.5 { 1.0 } else { -1.0 };
                        open.push((x, direction, weight, collisions + 1));
                    }
                    continue;
                }
                Some(s) => {
                    let mean = self.reflected(x) as f32;
                    let expected =
                        Some(Expected { mean, moment: mean * mean, variance: 0.0, cost: 1.0 });
                    let collision = Collision {
                        weight: weight as f32,
                        measurement: self.transmission() as f32,
                        expected,
                        albedo: self.c as f32,
                        roughness: 1.0,
                        scattered: collisions + 1,
                    };
                    match s.decide(&collision) {
                        Decision::Copies(q) => f64::from(q),
                        Decision::Unknown => 1.0,
                    }
                }
            };
            for _ in 0..(q + numbers.next()) as u32 {
                let direction = if numbers.next() < 0.5 { 1.0 } else { -1.0 };
                open.push((x, direction, weight * self.c / q, collisions + 1));
            }
        }
        (sum, flights)
    }

    fn run(&self, splitting: Option<&Splitting>, histories: usize) -> (Statistics, f64) {
        let mut numbers = Numbers(11);
        let mut flights = 0.0;
        let estimates: Vec<f64> = (0..histories)
            .map(|_| {
                let (x, n) = self.history(splitting, &mut numbers);
                flights += n;
                x
            })
            .collect();
        (Statistics::of(&estimates), flights / histories as f64)
    }
}

#[test]
fn windows_let_particles_through_a_thick_slab() {
    let adjoint =
        Splitting { rule: Rule::Adjoint, splits: true, window: window::SIZE, totals: None };
    let thin = Slab { c: 0.7, length: 6.0 };
    assert!((thin.transmission() - 0.034_202).abs() < 1e-6, "{}", thin.transmission());
    let mut gains = Vec::new();
    for length in [2.0, 6.0, 15.0] {
        let slab = Slab { c: 0.7, length };
        let t = slab.transmission();
        let (window, flights) = slab.run(Some(&adjoint), 40_000);
        assert!((window.mean - t).abs() < 4.0 * window.error, "{length}: {window:?} {t}");
        // Of the analogue run the variance is known: each history scores 0 or 1.
        let (analogue, analogue_flights) = slab.run(None, 40_000);
        assert!((analogue.mean - t).abs() < 4.0 * (t * (1.0 - t) / 40_000.0).sqrt());
        let gain = t * (1.0 - t) * analogue_flights / (window.variance * flights);
        gains.push(gain);
    }
    // The figure of merit, 1/(variance x cost), grows with the thickness.
    assert!(gains[1] > 1.2 * gains[0] && gains[2] > 10.0 * gains[1], "{gains:?}");
}
