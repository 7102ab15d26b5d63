//! Where chains start, and how bright the picture is.
//!
//! ```text
//! b_g = (1/n) Σᵢ Wᵢ                           the film's brightness, of n candidates of group g   (1)
//! P(start = xᵢ) = Wᵢ / (n b_g)                no start-up bias, however short chains are          (2)
//! N = (σ / (ε b))²                            as many as make the error of b a share ε            (3)
//! τ = Σ W⁴ / (Σ W²)²                          one over how many candidates tell σ²                (4)
//! ```
//!
//! Veach 1997, sec. 11.3.1: with b as the weight of every chain, b times the choice (2) is right on
//! average over candidates, whatever their number, and a Metropolis step leaves it right. Each group g of
//! chains has candidates of its own, so that groups are independent renders. In (3) σ comes from a trial with
//! other candidates, so that a lucky one does not end the search. Where few of them have most of the
//! light, σ itself is mostly too small: the trial grows until (4) is small, and where it stays large as
//! many are taken as may be. Choices are stratified by the lengths of paths.

use super::Draws;
use crate::method::RenderError;
use crate::saved::saved;
use crate::workers::Workers;
use rayon::prelude::*;

/// Candidates of a chunk.
const CHUNK: u64 = 256;
/// A trial has this part of the candidates that are wanted at least, and no more than this part of those
/// that may be.
const TRIAL: u64 = 4;
/// Candidates are at most so many times those that are wanted at least.
const MOST: u64 = 16;
/// 1/τ of (4) below which σ is not known.
const FEW: f64 = 32.0;
/// 1/τ of (4) below which the light of few candidates makes more of the picture's error than chains do.
const ENOUGH: f64 = 128.0;

/// Relative error of b, as large as it may be, above which candidates that [rest on few](Moments::rests_on_few)
/// are warned of.
const KNOWN: f64 = 0.03;

/// What a candidate is worth: W, and the bounces of its path.
pub type Worth = (f64, u8);

/// Sums over candidates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    count: u64,
    /// Σ W, Σ W², Σ W⁴.
    sums: [f64; 3],
}
saved!(Moments { count, sums });

impl Moments {
    /// One more.
    pub fn push(&mut self, w: f64) {
        self.count += 1;
        let squared = w * w;
        let powers = [w, squared, squared * squared];
        self.sums.iter_mut().zip(powers).for_each(|(sum, p)| *sum += p);
    }

    /// Those of another, too.
    pub fn add(&mut self, o: &Moments) {
        self.count += o.count;
        self.sums.iter_mut().zip(o.sums).for_each(|(sum, o)| *sum += o);
    }

    /// How many.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// b.
    pub fn mean(&self) -> f64 {
        self.sums[0] / self.count.max(1) as f64
    }

    /// σ².
    fn variance(&self) -> f64 {
        let n = self.count as f64;
        let mean = self.mean();
        (self.sums[1] / n.max(1.0) - mean * mean).max(0.0) * n / (n - 1.0).max(1.0)
    }

    /// The standard error of b.
    pub fn error(&self) -> f64 {
        (self.variance() / self.count.max(1) as f64).sqrt()
    }

    /// 1/τ of (4).
    fn tell(&self) -> f64 {
        let [_, squares, fourths] = self.sums;
        if fourths > 0.0 { squares * squares / fourths } else { 0.0 }
    }

    /// True if so few candidates have most of the light that the error of b is not known.
    pub fn rests_on_few(&self) -> bool {
        self.tell() < FEW
    }

    /// True if more candidates are worth more than more steps.
    pub fn are_too_few(&self) -> bool {
        self.tell() < ENOUGH
    }

    /// What there is to warn of: the fewer tell the error, the more may be missing from it.
    pub fn warning(&self) -> Option<String> {
        let error = self.error() / self.mean();
        let perhaps = error * (FEW / self.tell().max(1.0)).sqrt();
        (self.rests_on_few() && perhaps > KNOWN).then(|| {
            format!(
                "warning: few of {} candidates have most of the light: the picture's brightness, known to {:.1} % or worse, and the errors of its pixels are not sure; more candidates are needed (bootstrap; of erpt passes)",
                self.count,
                100.0 * error,
            )
        })
    }

    /// See [`Method::report`](crate::Method::report).
    pub fn report(&self) -> Vec<(String, f64)> {
        vec![
            ("brightness".into(), self.mean()),
            ("brightness_error".into(), self.error()),
            ("candidates".into(), self.count as f64),
            ("candidates_that_tell_the_error".into(), self.tell()),
        ]
    }

    /// (3) for ε = `precision`, at least `fewest` and not many times more.
    fn plan(&self, fewest: u64, precision: f64) -> u64 {
        let most = MOST * fewest;
        let allowed = (precision * self.mean()).powi(2);
        match self.rests_on_few() {
            _ if allowed == 0.0 => fewest,
            true => most,
            _ => ((self.variance() / allowed) as u64).clamp(fewest, most),
        }
    }
}

/// Candidates for the starts of chains, with what they are worth.
#[derive(Clone, Debug, Default)]
pub struct Seeds {
    worth: Vec<Worth>,
    groups: usize,
    /// Rays that they took.
    pub rays: u64,
    /// Over all of them.
    pub moments: Moments,
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

/// How many candidates there shall be.
#[derive(Clone, Copy, Debug)]
pub enum Asked {
    /// At least so many, and as many as (3) asks for with this ε, of which 1 asks for no more.
    AtLeast(u64, f64),
    /// So many, or a few more to make groups equal.
    Exactly(u64),
}

impl Seeds {
    /// As many candidates as are asked for, as many for each of `groups`. `weigh` tells
    /// what a candidate is worth and the rays it took, in room of its thread; its other argument is true of those of the trial.
    ///
    /// # Errors
    /// If cancelled.
    pub fn find<S: Send>(
        workers: &Workers,
        (asked, groups): (Asked, usize),
        room: impl Fn() -> S + Sync,
        weigh: impl Fn(&mut S, u64, bool) -> (Worth, u64) + Sync,
    ) -> Result<Seeds, RenderError> {
        let count = match asked {
            Asked::Exactly(count) => count,
            Asked::AtLeast(fewest, precision) => {
                let of_trial = |room: &mut S, number| weigh(room, number, true);
                Seeds::plan(workers, (fewest, precision), &room, of_trial)?
            }
        };
        let mut seeds = Seeds { groups, ..Seeds::default() };
        let count = count.next_multiple_of(groups as u64);
        seeds.grow(workers, count, &room, |room, number| weigh(room, number, false))?;
        Ok(seeds)
    }

    /// How many (3) asks for, at least `fewest`, by a trial.
    fn plan<S: Send>(
        workers: &Workers,
        (fewest, precision): (u64, f64),
        room: impl Fn() -> S + Sync,
        weigh: impl Fn(&mut S, u64) -> (Worth, u64) + Sync,
    ) -> Result<u64, RenderError> {
        let mut trial = Seeds { groups: 1, ..Seeds::default() };
        let mut size = fewest.div_ceil(TRIAL);
        while precision < 1.0 && size <= MOST * fewest / TRIAL {
            trial.grow(workers, size, &room, &weigh)?;
            if !trial.moments.rests_on_few() {
                break;
            }
            size *= 2;
        }
        Ok(trial.moments.plan(fewest, precision))
    }

    /// Comes to have so many candidates.
    fn grow<S: Send>(
        &mut self,
        workers: &Workers,
        count: u64,
        room: impl Fn() -> S + Sync,
        weigh: impl Fn(&mut S, u64) -> (Worth, u64) + Sync,
    ) -> Result<(), RenderError> {
        let first = self.worth.len() as u64;
        let chunk = |room: &mut S, c: u64| {
            let numbers = first + c * CHUNK..count.min(first + (c + 1) * CHUNK);
            let mut rays = 0;
            let one = |number| {
                let (worth, taken) = weigh(room, number);
                rays += taken;
                if worth.0.is_finite() { worth } else { (0.0, 0) }
            };
            let worth: Vec<Worth> = numbers.map(one).collect();
            (!workers.cancelled()).then_some((worth, rays))
        };
        let chunks = count.saturating_sub(first).div_ceil(CHUNK);
        let found: Vec<Option<(Vec<Worth>, u64)>> =
            workers.install(|| (0..chunks).into_par_iter().map_init(&room, chunk).collect());
        for chunk in found {
            let (worth, rays) = chunk.ok_or(RenderError::Cancelled)?;
            self.rays += rays;
            worth.iter().for_each(|(w, _)| self.moments.push(*w));
            self.worth.extend(worth);
        }
        Ok(())
    }

    /// b of (1).
    pub fn brightness_of(&self, group: usize) -> f64 {
        self.of(group).map(|(_, w)| w).sum()
    }

    /// Candidates of a group, with their parts of b.
    fn of(&self, group: usize) -> impl Iterator<Item = (u64, f64)> {
        let numbers = (group..self.worth.len()).step_by(self.groups);
        let scale = self.groups as f64 / self.worth.len() as f64;
        numbers.map(move |number| (number as u64, scale * self.worth[number].0))
    }

    /// The starts of `chains` chains of a group; none if it has no light.
    pub fn choose(
        &self,
        group: usize,
        chains: usize,
        startup: Startup,
        draws: &mut Draws,
    ) -> Vec<u64> {
        match startup {
            Startup::Resample => self.resample(group, chains, draws),
            Startup::Discard => {
                let lit = self.of(group).filter(|(_, w)| *w > 0.0).map(|(start, _)| start);
                let lit: Vec<u64> = lit.collect();
                let chains = if lit.is_empty() { 0 } else { chains };
                (0..chains).map(|_| lit[draws.below(lit.len())]).collect()
            }
        }
    }

    /// (2), the choices stratified over the candidates by their lengths, then in their order.
    fn resample(&self, group: usize, chains: usize, draws: &mut Draws) -> Vec<u64> {
        let total = self.brightness_of(group);
        let mut starts = Vec::with_capacity(chains);
        let step = total / chains as f64;
        let mut next = step * draws.f64();
        let mut below = 0.0;
        let mut lit: Vec<(u64, f64)> = self.of(group).filter(|(_, w)| *w > 0.0).collect();
        lit.sort_by_key(|(number, _)| self.worth[*number as usize].1);
        for (start, w) in lit {
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

    /// So many candidates.
    fn seeds(count: u64, groups: usize, weigh: impl Fn(u64) -> Worth + Sync) -> Seeds {
        let workers = Workers::new(2, Arc::default()).unwrap();
        let mut seeds = Seeds { groups, ..Seeds::default() };
        seeds.grow(&workers, count, || (), |_, number| (weigh(number), 1)).unwrap();
        seeds
    }

    #[test]
    fn starts_are_chosen_in_proportion_to_what_candidates_carry() {
        // Weights 0, 1, 2, 3, 0, …
        let seeds = seeds(1000, 1, |number| ((number % 4) as f64, (number / 500) as u8));
        assert!((seeds.moments.mean() - 1.5).abs() < 1e-12);
        let error = seeds.moments.error();
        assert!((error - (1.25f64 / 999.0).sqrt()).abs() < 1e-9, "{error}");
        let starts = seeds.choose(0, 6000, Startup::Resample, &mut Draws::new(1, 2));
        let share = |rest: u64| starts.iter().filter(|s| *s % 4 == rest).count() as f64;
        for (rest, expected) in [(0, 0.0), (1, 1000.0), (2, 2000.0), (3, 3000.0)] {
            // Stratified: off by less than one for each stretch.
            assert!((share(rest) - expected).abs() <= 250.0, "{rest}");
        }
        let anywhere = seeds.choose(0, 6000, Startup::Discard, &mut Draws::new(1, 2));
        assert!(anywhere.iter().all(|s| s % 4 > 0));
    }

    #[test]
    fn starts_are_stratified_by_lengths() {
        // Half of the light in paths of either length, which come in any order.
        let seeds = seeds(1024, 4, |number| (1.0, (number / 4 * 7 % 2) as u8));
        for group in 0..4 {
            let starts = seeds.choose(group, 32, Startup::Resample, &mut Draws::new(3, 4));
            let long = starts.iter().filter(|s| **s / 4 * 7 % 2 == 1).count();
            assert_eq!(long, 16);
        }
    }

    #[test]
    fn groups_have_candidates_of_their_own() {
        let seeds = seeds(1000, 4, |number| ((number % 4) as f64, 0));
        for group in 0..4 {
            assert!((seeds.brightness_of(group) - group as f64).abs() < 1e-12);
            let starts = seeds.choose(group, 50, Startup::Resample, &mut Draws::new(1, 2));
            assert_eq!(starts.len(), if group == 0 { 0 } else { 50 });
            assert!(starts.iter().all(|s| s % 4 == group as u64));
        }
    }

    #[test]
    fn what_few_candidates_tell_is_doubted() {
        // Eight of a hundred thousand have a part of the light, and tell all of the error: it may be twice as large.
        let with_part = |part: f64| {
            let mut moments = Moments::default();
            (0..100_000).for_each(|_| moments.push(1.0));
            (0..8).for_each(|_| moments.push(part * 100_000.0 / 8.0));
            moments
        };
        for (part, error, warns) in [(0.03, 0.0103, false), (0.06, 0.02, true)] {
            let moments = with_part(part);
            let told = moments.error() / moments.mean();
            assert!((told - error).abs() < 1e-3, "{told}");
            assert!(moments.rests_on_few() && told < KNOWN);
            assert_eq!(moments.warning().is_some(), warns, "{part}");
        }
    }

    #[test]
    fn as_many_candidates_are_found_as_the_error_asks_for() {
        let workers = Workers::new(2, Arc::default()).unwrap();
        let find = |precision: f64, weigh: &(dyn Fn(u64) -> f64 + Sync)| {
            let worth = |_: &mut (), number, _| ((weigh(number), 0), 1);
            Seeds::find(&workers, (Asked::AtLeast(10_000, precision), 8), || (), worth).unwrap()
        };
        // σ = 2, b = 2.
        let even = |number| 4.0 * (number % 2) as f64;
        let found = find(0.004, &even);
        let error = found.moments.error() / found.moments.mean();
        assert!((error - 0.004).abs() < 1e-5, "{error}");
        assert_eq!(find(1.0, &even).moments.count, 10_000);
        assert_eq!(find(1.0, &even).rays, 10_000);
        assert_eq!(find(1e-9, &even).moments.count, 160_000);
        // One of 4000 has 20 times the light of all others: a trial of 2500 meets the first, one of 5000 two, and so on: ten of
        // 40,000 are too few.
        let rare = |number| if number % 4000 == 11 { 8e4 } else { 1.0 };
        let found = find(0.3, &rare);
        assert_eq!(found.moments.count, 160_000);
        assert!(!found.moments.rests_on_few(), "forty tell");
        assert!(seeds(10_000, 1, |number| (rare(number), 0)).moments.rests_on_few());
    }
}
