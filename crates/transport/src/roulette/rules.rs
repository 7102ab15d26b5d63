//! Rules that choose the survival probability q.

use kaustika_math::lanes::Lanes;
use kaustika_spectra::Spectrum;
use serde::{Deserialize, Serialize};

/// How q is chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Survival {
    /// Paths end only by depth or absorption.
    None,
    /// q = the path's throughput (Arvo & Kirk 1990), freed of the scaling by refraction.
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
    /// Largest q below 1, so that closed mirror boxes end.
    pub q_max: f32,
}

impl Roulette {
    /// Survival probability; 1 where the rule does not apply.
    #[inline]
    pub fn q(&self, s: &WalkState) -> f32 {
        if s.depth <= self.rr_depth {
            return 1.0;
        }
        let q = match self.survival {
            Survival::None => return 1.0,
            Survival::Throughput => s.beta.max_component() * s.eta_scale,
            Survival::Albedo => s.weight.max_component(),
        };
        q.min(self.q_max)
    }

    /// As [`Roulette::q`], of sixteen paths.
    #[inline(always)]
    pub fn q_lanes(&self, s: &WalkStates) -> Lanes {
        let largest = |s: &[Lanes; 4]| s[0].fast_max(s[1]).fast_max(s[2].fast_max(s[3]));
        let one = Lanes::splat(1.0);
        let q = match self.survival {
            Survival::None => return one,
            Survival::Throughput => largest(s.beta) * s.eta_scale,
            Survival::Albedo => largest(s.weight),
        };
        let early = s.depth.simd_le(Lanes::splat(self.rr_depth as f32));
        early.select(one, q.fast_min(Lanes::splat(self.q_max)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_respect_their_limits() {
        let walk = |b: f32, depth| WalkState {
            beta: Spectrum::splat(b),
            eta_scale: 1.0,
            weight: Spectrum::splat(0.5),
            depth,
        };
        let rule = |survival| Roulette { survival, rr_depth: 3, q_max: 0.95 };
        assert_eq!(rule(Survival::Throughput).q(&walk(0.2, 3)), 1.0);
        assert_eq!(rule(Survival::Throughput).q(&walk(0.2, 4)), 0.2);
        assert_eq!(rule(Survival::Throughput).q(&walk(3.0, 9)), 0.95);
        assert_eq!(rule(Survival::Albedo).q(&walk(0.2, 4)), 0.5);
        assert_eq!(rule(Survival::None).q(&walk(0.0, 9)), 1.0);
    }

    #[test]
    fn sixteen_paths_have_the_probabilities_of_one() {
        let number = |i: usize, k: usize| ((i * 7 + k * 5) % 13) as f32 * 0.13;
        for survival in [Survival::None, Survival::Throughput, Survival::Albedo] {
            let rule = Roulette { survival, rr_depth: 3, q_max: 0.95 };
            let row = |f: &dyn Fn(usize) -> f32| Lanes::new(std::array::from_fn(f));
            let beta: [Lanes; 4] = std::array::from_fn(|k| row(&|i| number(i, k)));
            let weight: [Lanes; 4] = std::array::from_fn(|k| row(&|i| number(i + 3, k)));
            let depth = row(&|i| i as f32 / 2.0);
            let eta_scale = row(&|i| if i % 3 == 0 { 2.25 } else { 1.0 });
            let depth = depth.floor();
            let q = rule
                .q_lanes(&WalkStates { beta: &beta, eta_scale, weight: &weight, depth })
                .to_array();
            for (i, q) in q.into_iter().enumerate() {
                let alone = WalkState {
                    beta: Spectrum(std::array::from_fn(|k| number(i, k))),
                    eta_scale: if i % 3 == 0 { 2.25 } else { 1.0 },
                    weight: Spectrum(std::array::from_fn(|k| number(i + 3, k))),
                    depth: i as u32 / 2,
                };
                assert_eq!(q, rule.q(&alone), "{survival:?} {i}");
            }
        }
    }
}
