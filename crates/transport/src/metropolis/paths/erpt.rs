//! Energy redistribution path tracing (Cline, Talbot & Egbert 2005): each path that was found is the start of
//! short chains, as many as it carries light, which spread that over the film.
//!
//! ```text
//! q = b̂ / K                                the light of a chain, K of them a pass on average      (1)
//! n(x) = ⌊W(x) / (M q) + ξ⌋                 chains from a candidate, of M                        (2)
//! E[Σ n q] = E[W] = b                      whatever b̂ is                                       (3)
//! ```
//!
//! W is a candidate's weight. A chain that starts where the light is stays where it is, however short it
//! is: that needs no ergodic mutations, and perturbations alone do. Each pass has candidates of its own, so
//! that passes are independent.

use super::Mlt;
use super::params::{Erpt as Params, Mutation};
use super::tracer::Tracer;
use super::walk::{Walk, candidate, worth};
use crate::frame::Frame;
use crate::method::{
    Bias, Commit, CommitKind, Method, MethodInfo, PassStats, RenderError, Schedule,
};
use crate::metropolis::film::{run, stream};
use crate::metropolis::seeds::{Asked, Moments, Seeds};
use crate::metropolis::tally::Tally;
use crate::path_space::{Splat, add_splat};
use crate::workers::Workers;
use kaustika_film::accumulate::PassImage;
use kaustika_sampling::hash::combine;
use kaustika_scene::Scene;

/// What energy redistribution is.
pub static ERPT_INFO: MethodInfo = MethodInfo {
    name: "erpt",
    summary: "energy redistribution: short chains of perturbations from every path that was found",
    schedule: Schedule::Stateless,
    bias: Bias::Unbiased,
    one_spp: "a candidate and on average one mutation a pixel, and a sample of direct light",
    source: "Cline, Talbot & Egbert 2005",
    ..super::INFO
};

/// Candidates of a chunk.
const CHUNK: u64 = 256;

/// The method.
#[derive(Debug)]
pub struct Erpt {
    params: Params,
    /// What makes and moves paths.
    paths: Mlt,
    /// b̂ of (1).
    brightness: f64,
    tally: Tally,
    /// What candidates tell of b.
    candidates: Moments,
}

impl Erpt {
    /// With these parameters.
    pub fn new(params: Params) -> Erpt {
        let paths = Mlt::new(params.paths());
        let tally = Tally::new(Mutation::ALL.len());
        Erpt { params, paths, brightness: 0.0, tally, candidates: Moments::default() }
    }
}

impl Method for Erpt {
    fn info(&self) -> &'static MethodInfo {
        &ERPT_INFO
    }

    fn report(&self) -> Vec<(String, f64)> {
        let mut report = vec![("brightness_at_first".into(), self.brightness)];
        report.extend(self.candidates.report());
        report.extend(self.tally.report(&Mutation::ALL.map(Mutation::name)));
        report
    }

    fn remarks(&self) -> Vec<String> {
        self.candidates.warning().into_iter().collect()
    }

    fn prepare(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<(), RenderError> {
        self.paths.learn(scene, frame, workers)?;
        let Some(lengths) = self.paths.params.lengths() else { return Ok(()) };
        let seed = !frame.sampler.config().seed;
        let weigh = |tracer: &mut Tracer, number: u64, _| worth(tracer, lengths, seed, number);
        // The error of b̂ is none of the picture's.
        let asked = (Asked::AtLeast(u64::from(self.params.bootstrap), 1.0), 1);
        let seeds = Seeds::find(workers, asked, || self.paths.tracer(scene, frame), weigh)?;
        self.brightness = seeds.moments.mean();
        Ok(())
    }

    fn pass(
        &mut self,
        index: u64,
        scene: &Scene,
        frame: &Frame,
        out: &mut PassImage,
        workers: &Workers,
    ) -> Result<Commit, RenderError> {
        let mut stats = self.paths.separate(index, (scene, frame), out, workers)?;
        let lengths = self.paths.params.lengths().filter(|_| self.brightness > 0.0);
        if let Some(lengths) = lengths {
            let seed = frame.sampler.config().seed;
            let of_walks = combine(seed, 0x7761_6c6b);
            let [w, h] = frame.size().map(u64::from);
            let candidates = (w * h).max(1);
            let steps = u64::from(self.params.chain_length);
            let quantum = self.brightness * steps as f64 / candidates as f64; // (1)
            let chunks: Vec<u64> = (0..candidates.div_ceil(CHUNK)).collect();
            let how = (&self.paths.params.mutations[..], lengths);
            let one = |tracer: &mut Tracer, _, chunk: &mut u64, out: &mut Vec<Splat>| {
                let mut tally = Tally::new(Mutation::ALL.len());
                let mut moments = Moments::default();
                for i in *chunk * CHUNK..candidates.min((*chunk + 1) * CHUNK) {
                    let number = index * candidates + i;
                    tracer.stats = PassStats::default();
                    let found = candidate(tracer, lengths, seed, number);
                    tally.stats += tracer.stats;
                    moments.push(found.as_ref().map_or(0.0, |(_, weight)| *weight));
                    let Some((path, weight)) = found else { continue };
                    let xi = stream(seed, 0x6572_7074, number).f64();
                    let chains = weight / (candidates as f64 * quantum) + xi; // (2)
                    let chains = if chains.is_finite() { chains as u64 } else { 0 };
                    for chain in 0..chains {
                        let mut walk = Walk::new(&path, combine(of_walks, number), chain);
                        tally.add(&walk.advance(tracer, steps, how, quantum / steps as f64, out));
                    }
                }
                (tally, moments)
            };
            let room = || self.paths.tracer(scene, frame);
            let (_, tallies) = run(workers, &chunks, room, one, |_, splats| {
                splats.iter().for_each(|s| add_splat(frame, out, s));
            })?;
            for (tally, moments) in &tallies {
                stats += tally.stats;
                self.tally.add(tally);
                self.candidates.add(moments);
            }
        }
        Ok(Commit { kind: CommitKind::Average, stats })
    }
}
