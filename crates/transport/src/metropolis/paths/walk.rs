//! A chain through path space.

use super::bidirectional::{self, Lengths};
use super::candidates;
use super::kept::Kept;
use super::lens_subpath;
use super::manifold;
use super::mutation::Proposal;
use super::params::Mutation;
use super::path::{Measure, Path};
use super::perturbation::{EyeSide, eye_side, move_caustic, move_eye};
use super::tracer::Tracer;
use crate::method::PassStats;
use crate::metropolis::coverage::{Visitor, Visits};
use crate::metropolis::film::stream;
use crate::metropolis::seeds::Worth;
use crate::metropolis::tally::Tally;
use crate::metropolis::{Chain, Draws, Recording, acceptance};
use crate::path_space::{Splat, Tracks};
use crate::saved::saved;

/// A chain between passes.
#[derive(Clone, Debug)]
pub(super) struct Walk {
    path: Kept,
    draws: Draws,
    /// Steps since it moved last.
    still: u64,
    visits: Visits,
}
saved!(Walk { path, draws, still, visits });

impl Visitor for Walk {
    fn visits(&self) -> &Visits {
        &self.visits
    }
}

/// The candidate of this number for a start, and its weight.
pub(super) fn candidate<'a>(
    tracer: &mut Tracer<'a>,
    lengths: Lengths,
    seed: u64,
    number: u64,
) -> Option<(Path<'a>, f64)> {
    candidates::candidate(tracer, lengths, &mut stream(seed, 0x7061_7468, number))
}

/// What it is worth, and the rays it took.
pub(super) fn worth(tracer: &mut Tracer, lengths: Lengths, seed: u64, number: u64) -> (Worth, u64) {
    tracer.stats = PassStats::default();
    let found = candidate(tracer, lengths, seed, number);
    let worth = found.map_or((0.0, 0), |(path, weight)| (weight, path.len() as u8));
    (worth, tracer.stats.rays())
}

/// A mutation of a kind.
pub(super) fn propose<'a>(
    tracer: &mut Tracer<'a>,
    x: &Path<'a>,
    kind: Mutation,
    lengths: Lengths,
    draws: &mut Draws,
) -> Option<Proposal<'a>> {
    match kind {
        Mutation::Bidirectional => bidirectional::propose(tracer, x, lengths, draws),
        Mutation::Lens => move_eye(tracer, x, EyeSide::Lens, draws),
        Mutation::MultiChain => move_eye(tracer, x, EyeSide::MultiChain, draws),
        Mutation::Caustic => move_caustic(tracer, x, draws),
        Mutation::Manifold => manifold::propose(tracer, x, draws),
        Mutation::LensSubpath => lens_subpath::propose(tracer, x, lengths, draws),
    }
}

/// What a path leaves on the film, and on layers by path.
fn leave(x: &Path, weight: f64, measure: &Measure, tracks: Option<&Tracks>, out: &mut Vec<Splat>) {
    let k = weight / x.f;
    let mut splat = |layer, rgb: [f32; 3]| {
        let rgb = rgb.map(|v| (k * f64::from(v)) as f32);
        out.push(Splat { film: x.sensed.film, layer, rgb });
    };
    splat(None, x.rgb);
    if let Some(tracks) = tracks {
        let seen = (measure.scene, measure.sensor);
        x.each_layer(seen, tracks, |layer, rgb| splat(Some(layer), rgb));
    }
}

impl Walk {
    /// Chain number `chain`, which starts at a path.
    pub(super) fn new(path: &Path, seed: u64, chain: u64) -> Walk {
        Walk {
            path: Kept::new(path),
            draws: stream(seed, 0x6d6c_7477, chain),
            still: 0,
            visits: Visits::default(),
        }
    }

    /// Makes some steps, each a mutation of one of these kinds, which are equally likely; of the two that
    /// move the eye's end the one that the path's form allows, which neither changes.
    pub(super) fn advance(
        &mut self,
        tracer: &mut Tracer,
        count: u64,
        (kinds, lengths): (&[Mutation], Lengths),
        unit: f64,
        out: &mut Vec<Splat>,
    ) -> Tally {
        let mut tally = Tally::new(Mutation::ALL.len());
        tally.still = [self.still; 2];
        tracer.stats = Default::default();
        // A path that was found can be found again, but for rounding.
        let Some(path) = self.path.path(tracer) else { return tally };
        let (measure, tracks) = (tracer.measure, tracer.tracks.take());
        let mut record =
            |x: &Path, weight: f64| leave(x, weight * unit, &measure, tracks.as_ref(), out);
        let mut chain = Chain::new(path, Recording::Expected);
        let has = |kind| kinds.contains(&kind);
        let moves_eye_anyhow = has(Mutation::Lens) && has(Mutation::MultiChain);
        let other = |kind: &Mutation| !(moves_eye_anyhow && *kind == Mutation::MultiChain);
        let kinds: Vec<Mutation> = kinds.iter().copied().filter(other).collect();
        for _ in 0..count {
            let kind = match kinds[self.draws.below(kinds.len())] {
                Mutation::Lens if moves_eye_anyhow => eye_side(chain.state()).mutation(),
                kind => kind,
            };
            let proposal = propose(tracer, chain.state(), kind, lengths, &mut self.draws);
            let u = self.draws.f64();
            let a = proposal.as_ref().and_then(|p| acceptance(p.there, p.back));
            tally.bad += u64::from(proposal.is_some() && a.is_none());
            tally.proposed(kind as usize, a.filter(|&a| a > 0.0));
            let moved = match (proposal, a) {
                (Some(mut proposal), Some(a)) if a > 0.0 => {
                    chain.step(&mut proposal.path, a, u, &mut record)
                }
                _ => {
                    chain.stay();
                    false
                }
            };
            tally.moved(moved);
            let state = chain.state();
            self.visits.count(state.len());
            if let (true, Some(tile)) = (moved, tracer.field.tile(state.sensed.film)) {
                self.visits.see(tile);
            }
        }
        chain.record(&mut record);
        tracer.tracks = tracks;
        self.path = Kept::new(chain.state());
        self.still = tally.still[0];
        tally.stats = tracer.stats;
        tally
    }
}
