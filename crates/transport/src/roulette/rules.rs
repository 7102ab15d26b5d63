//! Rules that choose the survival probability q.
//!
//! ```text
//! q = min(1, β/τ)                                                               (2)
//! ```
//!
//! β is the path's throughput, τ a threshold: paths that carry more are let be, those that carry
//! less end, or go on with β = τ (Arvo & Kirk 1990).

use kaustika_math::lanes::Lanes;
use kaustika_spectra::Spectrum;
use serde::{Deserialize, Serialize};

/// How q is chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Survival {
    /// Paths end only by depth or absorption.
    None,
    /// The path's throughput over a threshold (2), freed of the scaling by refraction.
    #[default]
    Throughput,
    /// q = the albedo of the surface, here the weight of the last bounce (Jensen 2001).
    Albedo,
}

/// What a rule may look at.
#[derive(Clone, Copy, Debug)]
pub struct WalkState {
    /// Path throughput after the bounce.
    pub beta: Spectrum,
    /// Product of squared relative indices of refraction along the path.
    pub eta_scale: f32,
    /// Weight of the last bounce: BSDF times cosine over density.
    pub weight: Spectrum,
    /// Bounces so far, the last one included.
    pub depth: u32,
}

/// As [`WalkState`], of sixteen paths.
#[derive(Clone, Copy, Debug)]
pub struct WalkStates<'a> {
    /// Path throughputs after the bounce.
    pub beta: &'a [Lanes; 4],
    /// Products of squared relative indices of refraction.
    pub eta_scale: Lanes,
    /// Weights of the last bounce.
    pub weight: &'a [Lanes; 4],
    /// Bounces so far.
    pub depth: Lanes,
}

/// A rule with its limits.
#[derive(Clone, Copy, Debug)]
pub struct Roulette {
    /// How q is chosen.
    pub survival: Survival,
    /// No roulette before more than this many bounces.
    pub rr_depth: u32,
    /// Throughput below which the rule of that name plays, above 0.
    pub threshold: f32,
}

/// Bounces after which no path is sure to go on, so that closed mirror boxes end.
const LONG: u32 = 24;
/// Largest q from there on.
const Q_LONG: f32 = 0.95;

impl Roulette {
    /// Survival probability; 1 where the rule does not apply.
    #[inline]
    pub fn q(&self, s: &WalkState) -> f32 {
        if s.depth <= self.rr_depth {
            return 1.0;
        }
        let q = match self.survival {
            Survival::None => return 1.0,
            Survival::Throughput => s.beta.max_component() * s.eta_scale / self.threshold, // (2)
            Survival::Albedo => s.weight.max_component(),
        };
        q.min(if s.depth > LONG { Q_LONG } else { 1.0 })
    }

    /// As [`Roulette::q`], of sixteen paths.
    #[inline(always)]
    pub fn q_lanes(&self, s: &WalkStates) -> Lanes {
        let largest = |s: &[Lanes; 4]| s[0].fast_max(s[1]).fast_max(s[2].fast_max(s[3]));
        let one = Lanes::splat(1.0);
        let q = match self.survival {
            Survival::None => return one,
            Survival::Throughput => {
                largest(s.beta) * s.eta_scale / Lanes::splat(self.threshold) // (2)
            }
            Survival::Albedo => largest(s.weight),
        };
        let early = s.depth.simd_le(Lanes::splat(self.rr_depth as f32));
        let long = s.depth.simd_gt(Lanes::splat(LONG as f32));
        let most = long.select(Lanes::splat(Q_LONG), one);
        early.select(one, q.fast_min(most))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rule(survival: Survival) -> Roulette {
        Roulette { survival, rr_depth: 3, threshold: 0.5 }
    }

    #[test]
    fn rules_respect_their_limits() {
        let walk = |b: f32, depth| WalkState {
            beta: Spectrum::splat(b),
            eta_scale: 1.0,
            weight: Spectrum::splat(0.75),
            depth,
        };
        let throughput = rule(Survival::Throughput);
        assert_eq!(throughput.q(&walk(0.2, 3)), 1.0);
        assert_eq!(throughput.q(&walk(0.2, 4)), 0.4);
        assert_eq!(throughput.q(&walk(0.6, 9)), 1.0);
        assert_eq!(throughput.q(&walk(0.6, LONG + 1)), Q_LONG);
        assert_eq!(rule(Survival::Albedo).q(&walk(0.2, 4)), 0.75);
        assert_eq!(rule(Survival::None).q(&walk(0.0, 90)), 1.0);
    }

    #[test]
    fn sixteen_paths_have_the_probabilities_of_one() {
        let number = |i: usize, k: usize| ((i * 7 + k * 5) % 13) as f32 * 0.13;
        let depth = |i: usize| if i == 11 { LONG + 1 } else { i as u32 / 2 };
        for survival in [Survival::None, Survival::Throughput, Survival::Albedo] {
            let rule = rule(survival);
            let row = |f: &dyn Fn(usize) -> f32| Lanes::new(std::array::from_fn(f));
            let beta: [Lanes; 4] = std::array::from_fn(|k| row(&|i| number(i, k)));
            let weight: [Lanes; 4] = std::array::from_fn(|k| row(&|i| number(i + 3, k)));
            let eta_scale = row(&|i| if i % 3 == 0 { 2.25 } else { 1.0 });
            let depths = row(&|i| depth(i) as f32);
            let states = WalkStates { beta: &beta, eta_scale, weight: &weight, depth: depths };
            for (i, q) in rule.q_lanes(&states).to_array().into_iter().enumerate() {
                let alone = WalkState {
                    beta: Spectrum(std::array::from_fn(|k| number(i, k))),
                    eta_scale: if i % 3 == 0 { 2.25 } else { 1.0 },
                    weight: Spectrum(std::array::from_fn(|k| number(i + 3, k))),
                    depth: depth(i),
                };
                assert_eq!(q, rule.q(&alone), "{survival:?} {i}");
            }
        }
    }
}
