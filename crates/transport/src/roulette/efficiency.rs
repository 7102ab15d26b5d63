//! Efficiency-aware roulette and splitting (Rath, Grittmann, Herholz, Weier & Slusallek 2022,
//! "EARS: Efficiency-Aware Russian Roulette and Splitting").
//!
//! ```text
//! q_S = T √(V/C) √(C̄/V̄)                                                               (1)
//! q_R = T √(M/C) √(C̄/V̄),   M = V + L²                                                   (2)
//! q = q_S if q_S ≥ 1,   q_R if q_R ≤ 1,   else 1                                        (3)
//! ```
//!
//! T is the path's weight over the pixel's value; L, V and C are mean, variance and cost of one
//! continuation from here; V̄ and C̄ the picture's mean relative variance and cost of a sample. (1)
//! and (2) are where the derivative of variance times cost by q is zero. They hold for the q of
//! all other vertices as they are: passes find them one after the other.

use crate::guiding::Expected;
use crate::saved::saved;

/// What (1) and (2) need of the whole picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Totals {
    /// V̄: variance of one sample over its pixel's value squared, mean over the pixels.
    pub variance: f32,
    /// C̄: cost of one sample.
    pub cost: f32,
}

saved!(Totals { variance, cost });

/// q by (3), for the share `t` = T.
#[inline]
pub fn factor(t: f32, of: &Expected, totals: &Totals) -> f32 {
    let k = (totals.cost / (totals.variance * of.cost)).sqrt();
    let (split, roulette) = (t * of.variance.sqrt() * k, t * of.moment.sqrt() * k);
    if split >= 1.0 {
        split
    } else if roulette <= 1.0 {
        roulette
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One vertex: n = ⌊q + ξ⌋ copies of a variable of mean L and variance V, each of cost C, after
    /// a first step of some cost and variance. Variance times cost is least at q of (3).
    #[test]
    fn the_factor_is_the_minimum_of_variance_times_cost() {
        let (first, before) = (3.0f64, 2.0f64);
        for (mean, variance, cost) in
            [(1.0f64, 40.0f64, 1.0f64), (1.0, 0.2, 6.0), (2.0, 900.0, 2.0)]
        {
            // Of ⌊q + ξ⌋/q copies: variance of the count, times L², and V/q.
            let product = |q: f64| {
                let part = q.fract();
                let count = part * (1.0 - part) / (q * q);
                (before + count * mean * mean + variance / q) * (first + q * cost)
            };
            let best = (1..3000)
                .map(|i| 0.01 * i as f64)
                .min_by(|a, b| product(*a).total_cmp(&product(*b)))
                .expect("some");
            // The fixed point of (1) to (3).
            let mut q = 1.0f64;
            for _ in 0..200 {
                let of = Expected {
                    mean: mean as f32,
                    moment: (variance + mean * mean) as f32,
                    variance: variance as f32,
                    cost: cost as f32,
                };
                let totals = Totals {
                    variance: (product(q) / (first + q * cost)) as f32,
                    cost: (first + q * cost) as f32,
                };
                q = 0.5 * (q + f64::from(factor(1.0, &of, &totals)));
            }
            assert!(
                product(q) < 1.05 * product(best),
                "{q} {best} {} {}",
                product(q),
                product(best)
            );
        }
    }
}
