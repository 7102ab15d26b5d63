//! Where chains start, and how bright the picture is.
//!
//! ```text
//! b = Σ_k (1/n_k) Σᵢ Wᵢ                       the film's brightness, of n_k candidates of kind k   (1)
//! P(start = xᵢ) = (Wᵢ / n_k) / b              no start-up bias, however short chains are          (2)
//! ```
//!
//! Veach 1997, sec. 11.3.1: with b as the weight of every chain, b times the choice (2) is right on
//! average over candidates, whatever their number, and a Metropolis step leaves it right. Kinds
//! are lengths of paths where chains keep to theirs.

use super::Draws;
use crate::method::{PassStats, RenderError};
use crate::workers::Workers;
use rayon::prelude::*;

/// Candidates of a chunk.
const CHUNK: u64 = 256;

/// Candidates for the starts of chains, with their weights.
#[derive(Clone, Debug, Default)]
pub struct Seeds {
    /// Wᵢ / n_k, kind by kind.
    weights: Vec<f64>,
    /// First candidate of each kind.
    firsts: Vec<usize>,
    /// b of (1).
    pub brightness: f64,
    /// Its standard error.
    pub error: f64,
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

impl Seeds {
    /// Weighs `counts[k]` candidates of each kind k; `weigh` finds Wᵢ of a candidate, in room of its
    /// thread.
    ///
    /// # Errors
    /// If cancelled.
    pub fn find<S: Send>(
        workers: &Workers,
        counts: &[u64],
        room: impl Fn() -> S + Sync,
        weigh: impl Fn(&mut S, Start, &mut PassStats) -> f64 + Sync,
        stats: &mut PassStats,
    ) -> Result<Seeds, RenderError> {
        let mut seeds = Seeds::default();
        let mut variance = 0.0;
        for (kind, &count) in counts.iter().enumerate() {
            seeds.firsts.push(seeds.weights.len());
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
            let n = count as f64;
            let (mut sum, mut squares) = (0.0, 0.0);
            for chunk in found {
                let (weights, work) = chunk.ok_or(RenderError::Cancelled)?;
                *stats += work;
                for w in weights {
                    sum += w;
                    squares += w * w;
                    seeds.weights.push(w / n);
                }
            }
            seeds.brightness += sum / n;
            variance += (squares / n - (sum / n).powi(2)).max(0.0) / (n - 1.0).max(1.0);
        }
        seeds.error = variance.sqrt();
        Ok(seeds)
    }

    /// The starts of `chains` chains; none if there is no light.
    pub fn choose(&self, chains: usize, startup: Startup, draws: &mut Draws) -> Vec<Start> {
        match startup {
            Startup::Resample => self.resample(chains, draws),
            Startup::Discard => {
                let lit = |i: &usize| self.weights[*i] > 0.0;
                let lit: Vec<usize> = (0..self.weights.len()).filter(lit).collect();
                let chains = if lit.is_empty() { 0 } else { chains };
                (0..chains).map(|_| self.start(lit[draws.below(lit.len())])).collect()
            }
        }
    }

    /// (2), the choices stratified over the candidates in their order.
    fn resample(&self, chains: usize, draws: &mut Draws) -> Vec<Start> {
        let total: f64 = self.weights.iter().sum();
        let mut starts = Vec::with_capacity(chains);
        let step = total / chains as f64;
        let mut next = step * draws.f64();
        let mut below = 0.0;
        for (i, w) in self.weights.iter().enumerate() {
            below += w;
            while next < below && starts.len() < chains {
                starts.push(self.start(i));
                next += step;
            }
        }
        // Rounding may leave the last one out.
        if let (Some(&last), true) = (starts.last(), total > 0.0) {
            starts.resize(chains, last);
        }
        starts
    }

    fn start(&self, i: usize) -> Start {
        let kind = self.firsts.partition_point(|&first| first <= i) - 1;
        Start { kind, number: (i - self.firsts[kind]) as u64 }
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
        let seeds = Seeds::find(&workers, &[1000, 500], || (), weigh, &mut stats).unwrap();
        assert!((seeds.brightness - 5.5).abs() < 1e-12);
        assert!((seeds.error - (1.25f64 / 999.0).sqrt()).abs() < 1e-9, "{}", seeds.error);
        let starts = seeds.choose(5500, Startup::Resample, &mut Draws::new(1, 2));
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
        let anywhere = seeds.choose(5500, Startup::Discard, &mut Draws::new(1, 2));
        assert!(anywhere.iter().all(|s| s.kind == 1 || s.number % 4 > 0));
    }
}
