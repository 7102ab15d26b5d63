//! A chain through primary sample space.

use super::candidates::Kept;
use super::estimator::{Estimator, Sources};
use crate::method::PassStats;
use crate::metropolis::coordinates::{Coordinates, Moment, Stepping};
use crate::metropolis::coverage::{Visitor, Visits};
use crate::metropolis::film::{brightest, deposit, stream};
use crate::metropolis::seeds::Worth;
use crate::metropolis::tally::Tally;
use crate::metropolis::{Chain, Draws, Recording, acceptance};
use crate::path_space::Splat;
use crate::saved::saved;

/// Strategies of a chain, as its tally numbers them.
pub(super) const STRATEGIES: [&str; 2] = ["large", "small"];

/// A point of primary sample space, and the light of its path.
#[derive(Clone, Debug, Default)]
pub(super) struct State {
    at: Moment,
    /// Of the eye's subpath, of the light's, and of the strategy's choice.
    coordinates: [Coordinates; 3],
    splats: Vec<Splat>,
    f: f64,
}
saved!(State { at, coordinates, splats, f });

/// A chain between passes.
#[derive(Clone, Debug)]
pub(super) struct Walk {
    state: State,
    /// Decisions, then a stream for each kind of coordinate.
    draws: [Draws; 4],
    /// Bounces of its paths, where they are multiplexed.
    depth: u32,
    /// Steps since it moved last.
    still: u64,
    visits: Visits,
}
saved!(Walk { state, draws, depth, still, visits });

impl Visitor for Walk {
    fn visits(&self) -> &Visits {
        &self.visits
    }
}

/// How a chain steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Steps {
    /// Probability of a large one.
    pub(super) large: f64,
    /// Size of the small ones.
    pub(super) small: f64,
}

impl State {
    /// Hands out its coordinates, each moved to the present.
    fn stepping<'s>(&'s mut self, draws: &'s mut [Draws; 3], small: f64) -> [Stepping<'s>; 3] {
        let at = self.at;
        let [a, b, c] = &mut self.coordinates;
        let [x, y, z] = draws;
        [(a, x), (b, y), (c, z)].map(|(of, draws)| Stepping::new(of, draws, at, small))
    }

    /// Its f anew.
    fn find(
        &mut self,
        estimator: &mut Estimator,
        depth: u32,
        draws: &mut [Draws; 3],
        small: f64,
        stats: &mut PassStats,
    ) {
        let mut splats = std::mem::take(&mut self.splats);
        let [a, b, c] = &mut self.stepping(draws, small);
        let sources: Sources = [a, b, c];
        let f = estimator.light(depth as usize, sources, &mut splats, stats);
        (self.f, self.splats) = (f, splats);
    }

    /// Becomes a copy of another's coordinates, one step later.
    fn step_from(&mut self, other: &State, large: bool) {
        let now = other.at.now + 1;
        self.at = Moment { now, large: if large { now } else { other.at.large } };
        let pairs = self.coordinates.iter_mut().zip(&other.coordinates);
        pairs.for_each(|(mine, its)| mine.copy_from(its));
    }
}

/// Streams of a candidate's numbers, one for each kind of coordinate.
fn numbers(seed: u64, number: u64) -> [Draws; 3] {
    [0, 1, 2].map(|k| stream(seed, 0x6361_6e64 + k, number))
}

/// The candidate of this number for a start: its worth, and of multiplexed chains what is kept.
fn candidate(
    state: &mut State,
    estimator: &mut Estimator,
    seed: u64,
    number: u64,
    stats: &mut PassStats,
) -> (f64, Option<Kept>) {
    *state = State { splats: std::mem::take(&mut state.splats), ..State::default() };
    let draws = &mut numbers(seed, number);
    let mut decisions = stream(seed, 0x6361_6e64 + 3, number);
    let [a, b, c] = &mut state.stepping(draws, 0.0);
    if let Some(found) = estimator.candidate([a, b, c], &mut decisions, stats) {
        return found;
    }
    state.find(estimator, 0, &mut numbers(seed, number), 0.0, stats);
    (state.f, None)
}

/// What the candidate of this number is worth, and the rays it took.
pub(super) fn worth(
    state: &mut State,
    estimator: &mut Estimator,
    seed: u64,
    number: u64,
) -> (Worth, u64) {
    let mut stats = PassStats::default();
    let (w, kept) = candidate(state, estimator, seed, number, &mut stats);
    ((w, kept.map_or(0, |k| k.depth as u8)), stats.rays())
}

impl Walk {
    /// Chain number `chain`, which starts at a candidate.
    pub(super) fn new(
        estimator: &mut Estimator,
        (candidates, seed): (u64, u64),
        start: u64,
        chain: u64,
    ) -> Walk {
        let mut state = State::default();
        let (mut depth, mut stats) = (0, PassStats::default());
        let found = candidate(&mut state, estimator, candidates, start, &mut stats);
        if let (_, Some(kept)) = found {
            // The strategy that is kept, by the same numbers.
            state = State::default();
            state.coordinates[2] = Coordinates::of(kept.v);
            depth = kept.depth as u32;
            state.find(estimator, depth, &mut numbers(candidates, start), 0.0, &mut stats);
        }
        let draws = [0, 1, 2, 3].map(|k| stream(seed, 0x7761_6c6b + k, chain));
        Walk { state, draws, depth, still: 0, visits: Visits::default() }
    }

    /// Makes some steps; a state of weight one leaves f · `unit` on the film, in all.
    pub(super) fn advance(
        &mut self,
        estimator: &mut Estimator,
        count: u64,
        steps: Steps,
        unit: f64,
        out: &mut Vec<Splat>,
    ) -> Tally {
        let mut tally = Tally::new(STRATEGIES.len());
        tally.still = [self.still; 2];
        let mut record = |x: &State, weight: f64| deposit(&x.splats, weight * unit / x.f, out);
        let mut state = std::mem::take(&mut self.state);
        if !state.f.is_finite() {
            // A strategy of a candidate may be too bright for numbers where all together were not. It is left for any light.
            tally.bad += 1;
            (state.f, state.splats) = (0.0, Vec::new());
        }
        let mut chain = Chain::new(state, Recording::Expected);
        let mut proposal = State::default();
        let [decisions, draws @ ..] = &mut self.draws;
        for _ in 0..count {
            let large = decisions.f64() < steps.large;
            proposal.step_from(chain.state(), large);
            proposal.find(estimator, self.depth, draws, steps.small, &mut tally.stats);
            let u = decisions.f64();
            let a = acceptance(chain.state().f, proposal.f);
            tally.bad += u64::from(a.is_none());
            tally.proposed(usize::from(!large), a.filter(|&a| a > 0.0));
            let moved = match a {
                Some(a) if a > 0.0 => chain.step(&mut proposal, a, u, &mut record),
                _ => {
                    chain.stay();
                    false
                }
            };
            tally.moved(moved);
            if moved {
                // Light paths show in many places: a state is where most of its light is.
                let brightest = brightest(&chain.state().splats);
                if let Some(tile) = brightest.and_then(|s| estimator.tile(s.film)) {
                    self.visits.see(tile);
                }
            }
        }
        chain.record(&mut record);
        self.state = chain.into_state();
        self.still = tally.still[0];
        tally
    }
}
