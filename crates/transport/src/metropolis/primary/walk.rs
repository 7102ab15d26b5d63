//! A chain through primary sample space.

use super::estimator::{Estimator, Sources};
use crate::method::PassStats;
use crate::metropolis::coordinates::{Coordinates, Moment, Stepping};
use crate::metropolis::coverage::{Visitor, Visits};
use crate::metropolis::film::{brightest, deposit, stream};
use crate::metropolis::seeds::Start;
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
    /// Its f anew, each coordinate being moved to the present.
    fn find(
        &mut self,
        estimator: &mut Estimator,
        depth: u32,
        draws: &mut [Draws; 3],
        small: f64,
        stats: &mut PassStats,
    ) {
        let at = self.at;
        let [a, b, c] = &mut self.coordinates;
        let [x, y, z] = draws;
        let sources: Sources = [
            &mut Stepping::new(a, x, at, small),
            &mut Stepping::new(b, y, at, small),
            &mut Stepping::new(c, z, at, small),
        ];
        self.f = estimator.light(depth as usize, sources, &mut self.splats, stats);
    }

    /// Becomes a copy of another's coordinates, one step later.
    fn step_from(&mut self, other: &State, large: bool) {
        let now = other.at.now + 1;
        self.at = Moment { now, large: if large { now } else { other.at.large } };
        let pairs = self.coordinates.iter_mut().zip(&other.coordinates);
        pairs.for_each(|(mine, its)| mine.copy_from(its));
    }
}

/// The candidate of this number for a start; `depth` as [`Walk`]'s.
pub(super) fn candidate(
    state: &mut State,
    estimator: &mut Estimator,
    seed: u64,
    (depth, number): (u32, u64),
    stats: &mut PassStats,
) -> f64 {
    *state = State { splats: std::mem::take(&mut state.splats), ..State::default() };
    let mut draws =
        [0, 1, 2].map(|k| stream(seed, 0x6361_6e64 + (u64::from(depth) << 8) + k, number));
    state.find(estimator, depth, &mut draws, 0.0, stats);
    state.f
}

impl Walk {
    /// Chain number `chain`, which starts at a candidate.
    pub(super) fn new(
        estimator: &mut Estimator,
        (candidates, seed): (u64, u64),
        start: Start,
        depth: u32,
        chain: u64,
    ) -> Walk {
        let mut state = State::default();
        let stats = &mut PassStats::default();
        candidate(&mut state, estimator, candidates, (depth, start.number), stats);
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
        let mut chain = Chain::new(std::mem::take(&mut self.state), Recording::Expected);
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
