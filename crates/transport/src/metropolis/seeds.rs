//! Where chains start, and how bright the picture is.
//!
//! ```text
//! b_g = Σ_k (1/n_k) Σᵢ Wᵢ                     the film's brightness, of n_k candidates of kind k   (1)
//! P(start = xᵢ) = (Wᵢ / n_k) / b_g            no start-up bias, however short chains are          (2)
//! N_k = σ_k Σ_j σ_j / (ε b)²                  as many as make the error of b a share ε    (3)
//! ```
//!
//! Veach 1997, sec. 11.3.1: with b as the weight of every chain, b times the choice (2) is right on
//! average over candidates, whatever their number, and a Metropolis step leaves it right. Kinds
//! are lengths of paths where chains keep to theirs. Each group g of chains has candidates of its own, so
//! that groups are independent renders. (3) is Neyman's allocation (1934); σ comes from a trial with other
//! candidates, so that a lucky one does not end the search.

use super::Draws;
use crate::method::{PassStats, RenderError};
use crate::workers::Workers;
use rayon::prelude::*;

/// Candidates of a chunk.
const CHUNK: u64 = 256;
/// A trial has this part of the candidates that are wanted at least, and what it asks for is limited
/// to so many times them.
const TRIAL: u64 = 4;
const MOST: f64 = 16.0;

/// Candidates for the starts of chains, with their weights.
#[derive(Clone, Debug, Default)]
pub struct Seeds {
    /// Wᵢ, kind by kind.
    weights: Vec<f64>,
    kinds: Vec<Kind>,
    groups: usize,
}

/// Candidates of a kind.
#[derive(Clone, Copy, Debug, Default)]
struct Kind {
    /// The first one.
    first: usize,
    count: u64,
    mean: f64,
    /// σ².
    variance: f64,
}

/// How chains start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Startup {
    /// (2).
    #[default]
    Resample,
    /// At any candidate that carries light; the first steps are not recorded. Biased: less so the
    /// more steps are left out.
    Discard,
}

/// A start: which candidate of which kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Start {
    /// The kind.
    pub kind: usize,
    /// The candidate's number among those of its kind.
    pub number: u64,
}

/// Candidates of a trial before `fewest` of each kind.
pub fn of_trial(fewest: &[u64]) -> Vec<u64> {
    fewest.iter().map(|n| n.div_ceil(TRIAL)).collect()
}

impl Seeds {
    /// Weighs at least `counts[k]` candidates of each kind k, as many for each of `groups`; `weigh` finds
    /// Wᵢ of a candidate, in room of its thread.
    ///
    /// # Errors
    /// If cancelled.
    pub fn find<S: Send>(
        workers: &Workers,
        (counts, groups): (&[u64], usize),
        room: impl Fn() -> S + Sync,
        weigh: impl Fn(&mut S, Start, &mut PassStats) -> f64 + Sync,
        stats: &mut PassStats,
    ) -> Result<Seeds, RenderError> {
        let mut seeds = Seeds { groups, ..Seeds::default() };
        for (kind, count) in counts.iter().enumerate() {
            let count = count.next_multiple_of(groups as u64);
            let chunk = |room: &mut S, c: u64| {
                let mut stats = PassStats::default();
                let numbers = c * CHUNK..count.min((c + 1) * CHUNK);
                let mut one = |number| match weigh(room, Start { kind, number }, &mut stats) {
                    w if w.is_finite() => w,
                    _ => 0.0,
                };
                let weights: Vec<f64> = numbers.map(&mut one).collect();
                (!workers.cancelled()).then_some((weights, stats))
            };
            let found: Vec<Option<(Vec<f64>, PassStats)>> = workers.install(|| {
                (0..count.div_ceil(CHUNK)).into_par_iter().map_init(&room, chunk).collect()
            });
            let first = seeds.weights.len();
            let (mut sum, mut squares) = (0.0, 0.0);
            for chunk in found {
                let (weights, work) = chunk.ok_or(RenderError::Cancelled)?;
                *stats += work;
                sum += weights.iter().sum::<f64>();
                squares += weights.iter().map(|w| w * w).sum::<f64>();
                seeds.weights.extend(weights);
            }
            let n = count as f64;
            let mean = sum / n;
            let variance = (squares / n - mean * mean).max(0.0) * n / (n - 1.0).max(1.0);
            seeds.kinds.push(Kind { first, count, mean, variance });
        }
        Ok(seeds)
    }

    /// How many candidates there are.
    pub fn candidates(&self) -> u64 {
        self.weights.len() as u64
    }

    /// b over all groups.
    pub fn brightness(&self) -> f64 {
        self.kinds.iter().map(|k| k.mean).sum()
    }

    /// The standard error of b.
    pub fn error(&self) -> f64 {
        self.kinds.iter().map(|k| k.variance / k.count as f64).sum::<f64>().sqrt()
    }

    /// b of (1).
    pub fn brightness_of(&self, group: usize) -> f64 {
        self.of(group).map(|(_, w)| w).sum()
    }

    /// (3) for ε = `precision`, at least `fewest[k]` of kind k and not many times more in all.
    pub fn plan(&self, fewest: &[u64], precision: f64) -> Vec<u64> {
        let spread: f64 = self.kinds.iter().map(|k| k.variance.sqrt()).sum();
        let allowed = (precision * self.brightness()).powi(2);
        if allowed == 0.0 {
            return fewest.to_vec();
        }
        let wanted: Vec<f64> =
            self.kinds.iter().map(|k| k.variance.sqrt() * spread / allowed).collect();
        let limit = MOST * fewest.iter().sum::<u64>() as f64;
        let scale = (limit / wanted.iter().sum::<f64>()).min(1.0);
        wanted.iter().zip(fewest).map(|(w, f)| ((w * scale) as u64).max(*f)).collect()
    }

    /// Candidates of a group, with their parts of b.
    fn of(&self, group: usize) -> impl Iterator<Item = (Start, f64)> {
        let groups = self.groups as u64;
        self.kinds.iter().enumerate().flat_map(move |(kind, k)| {
            let scale = groups as f64 / k.count as f64;
            (group as u64..k.count).step_by(self.groups).map(move |number| {
                (Start { kind, number }, scale * self.weights[k.first + number as usize])
            })
        })
    }

    /// The starts of `chains` chains of a group; none if it has no light.
    pub fn choose(
        &self,
        group: usize,
        chains: usize,
        startup: Startup,
        draws: &mut Draws,
    ) -> Vec<Start> {
        match startup {
            Startup::Resample => self.resample(group, chains, draws),
            Startup::Discard => {
                let lit = self.of(group).filter(|(_, w)| *w > 0.0).map(|(start, _)| start);
                let lit: Vec<Start> = lit.collect();
                let chains = if lit.is_empty() { 0 } else { chains };
                (0..chains).map(|_| lit[draws.below(lit.len())]).collect()
            }
        }
    }

    /// (2), the choices stratified over the candidates in their order.
    fn resample(&self, group: usize, chains: usize, draws: &mut Draws) -> Vec<Start> {
        let total = self.brightness_of(group);
        let mut starts = Vec::with_capacity(chains);
        let step = total / chains as f64;
        let mut next = step * draws.f64();
        let mut below = 0.0;
        for (start, w) in self.of(group) {
            below += w;
            while next < below && starts.len() < chains {
                starts.push(start);
                next += step;
            }
        }
        // Rounding may leave the last one out.
        if let (Some(&last), true) = (starts.last(), total > 0.0) {
            starts.resize(chains, last);
        }
        starts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn starts_are_chosen_in_proportion_to_what_candidates_carry() {
        let workers = Workers::new(2, Arc::default()).unwrap();
        // Of kind 0 1000 candidates of weights 0, 1, 2, 3, 0, …; of kind 1 500 of weight 4.
        let weigh = |_: &mut (), s: Start, _: &mut PassStats| match s.kind {
            0 => (s.number % 4) as f64,
            _ => 4.0,
        };
        let mut stats = PassStats::default();
        let seeds = Seeds::find(&workers, (&[1000, 500], 1), || (), weigh, &mut stats).unwrap();
        assert!((seeds.brightness() - 5.5).abs() < 1e-12);
        let error = seeds.error();
        assert!((error - (1.25f64 / 999.0).sqrt()).abs() < 1e-9, "{error}");
        let starts = seeds.choose(0, 5500, Startup::Resample, &mut Draws::new(1, 2));
        let share = |kind, rest| {
            let of = |s: &&Start| s.kind == kind && (kind == 1 || s.number % 4 == rest);
            starts.iter().filter(of).count() as f64
        };
        assert_eq!(share(0, 0), 0.0);
        for (kind, rest, expected) in [(0, 1, 250.0), (0, 2, 500.0), (0, 3, 750.0), (1, 0, 4000.0)]
        {
            // Stratified: off by less than one for each stretch.
            assert!((share(kind, rest) - expected).abs() <= 250.0 * f64::from(kind == 0), "{kind}");
        }
        let anywhere = seeds.choose(0, 5500, Startup::Discard, &mut Draws::new(1, 2));
        assert!(anywhere.iter().all(|s| s.kind == 1 || s.number % 4 > 0));
    }

    #[test]
    fn groups_have_candidates_of_their_own() {
        let workers = Workers::new(2, Arc::default()).unwrap();
        let weigh = |_: &mut (), s: Start, _: &mut PassStats| (s.number % 4) as f64;
        let mut stats = PassStats::default();
        let seeds = Seeds::find(&workers, (&[1000], 4), || (), weigh, &mut stats).unwrap();
        for group in 0..4 {
            assert!((seeds.brightness_of(group) - group as f64).abs() < 1e-12);
            let starts = seeds.choose(group, 50, Startup::Resample, &mut Draws::new(1, 2));
            assert_eq!(starts.len(), if group == 0 { 0 } else { 50 });
            assert!(starts.iter().all(|s| s.number % 4 == group as u64));
        }
    }

    #[test]
    fn as_many_candidates_are_planned_as_the_error_asks_for() {
        let workers = Workers::new(2, Arc::default()).unwrap();
        // Σ over kinds of σ²/n = (ε b)², with σ 0.5 and 2, b = 0.5 + 2.
        let weigh = |_: &mut (), s: Start, _: &mut PassStats| match s.kind {
            0 => (s.number % 2) as f64,
            _ => 4.0 * (s.number % 2) as f64,
        };
        let mut stats = PassStats::default();
        let fewest = [10_000, 10_000];
        let trial = of_trial(&fewest);
        let seeds = Seeds::find(&workers, (&trial, 1), || (), weigh, &mut stats).unwrap();
        let plan = seeds.plan(&fewest, 0.004);
        let error = (0.25 / plan[0] as f64 + 4.0 / plan[1] as f64).sqrt() / 2.5;
        assert!((error - 0.004).abs() < 1e-5, "{plan:?}");
        assert!((plan[1] as f64 / plan[0] as f64 - 4.0).abs() < 0.01);
        assert_eq!(seeds.plan(&fewest, 1.0), fewest);
        assert!(seeds.plan(&fewest, 1e-9).iter().sum::<u64>() <= 16 * 20_000);
    }
}
