//! Metropolis light transport in primary sample space: over path tracing or bidirectional path
//! tracing (Kelemen et al. 2002), and multiplexed (Hachisuka et al. 2014).
//!
//! Chains walk through the numbers that paths are made of. Proposals are symmetric there, so that
//! acceptance is a ratio of brightness, and all that the sampler underneath does well stays.

mod estimator;
mod eye_paths;
mod params;
mod walk;

pub use params::{Direct, Over, PrimaryParams, common, multiplexed_parameters, parameters};

use self::estimator::{Estimator, Space};
use self::walk::{STRATEGIES, State, Steps, Walk, candidate};
use super::chains::Chains;
use super::film::{self, Schedule};
use super::seeds::{Seeds, Startup};
use super::separate;
use super::step_size::StepSize;
use super::tally::Tally;
use crate::frame::Frame;
use crate::lights;
use crate::method::{
    Bias, Commit, CommitKind, Method, MethodInfo, PassStats, RenderError, Schedule as Passes,
};
use crate::path_space::{emission_table, needs_lens};
use crate::workers::Workers;
use kaustika_film::accumulate::PassImage;
use kaustika_scene::{LightSelection, Scene};
use std::io::{self, Read, Write};

/// What Metropolis light transport in primary sample space is.
pub static INFO: MethodInfo = MethodInfo {
    name: "pssmlt",
    summary: "Metropolis light transport in primary sample space, over bidirectional path tracing or path tracing",
    path_class: "L(D|S)*E",
    misses: "what the sampler underneath misses: with over=path also caustics of lights without extent",
    bias: Bias::Unbiased,
    media: true,
    layers: true,
    schedule: Passes::Sequential,
    one_spp: "one mutation a pixel (rounded up to whole chains), and a sample of direct light",
    source: "Kelemen et al. 2002",
};

/// What multiplexed Metropolis light transport is.
pub static MULTIPLEXED_INFO: MethodInfo = MethodInfo {
    name: "mmlt",
    summary: "multiplexed Metropolis light transport: chains choose among the strategies of bidirectional path tracing",
    misses: "caustics of points, spots, directions and beams that are seen through mirrors or clear glass alone; paths of more than 64 bounces",
    source: "Hachisuka, Kaplanyan & Dachsbacher 2014",
    ..INFO
};

/// Bounces of the longest paths of `mmlt` without a limit.
const LONGEST: u32 = 64;
/// Acceptance that small steps learn: less, and chains stand still; more, and they hardly move.
const TARGET: f64 = 0.5;
/// Sizes of small steps that may be learned.
const SIZES: (f64, f64) = (1e-4, 0.25);
/// Chains that learn it, rounds, and steps of a round.
const LEARNERS: (usize, u32, u64) = (64, 24, 12);

/// The method.
#[derive(Debug)]
pub struct PrimarySpace {
    params: PrimaryParams,
    space: Space,
    lights: Option<LightSelection>,
    emission: LightSelection,
    small: f64,
    chains: Chains<Walk>,
}

impl PrimarySpace {
    /// Chains over all strategies at once, or over path tracing.
    pub fn new(params: PrimaryParams) -> PrimarySpace {
        PrimarySpace::with(params, Space::Whole)
    }

    /// Chains that choose a strategy.
    pub fn multiplexed(params: PrimaryParams) -> PrimarySpace {
        PrimarySpace::with(params, Space::Multiplexed)
    }

    fn with(params: PrimaryParams, space: Space) -> PrimarySpace {
        PrimarySpace {
            small: params.small_step,
            params,
            space,
            lights: None,
            emission: LightSelection::default(),
            chains: Chains::default(),
        }
    }

    /// The picture's brightness, summed over pixels, without what is rendered separately, and its standard error.
    pub fn brightness(&self) -> [f64; 2] {
        [self.chains.brightness, self.chains.error]
    }

    fn estimator<'a>(&'a self, scene: &'a Scene, frame: &'a Frame) -> Estimator<'a> {
        let lights = self.lights.as_ref().unwrap_or(&scene.light_selection);
        Estimator::new(scene, frame, &self.params, self.space, lights, &self.emission)
    }

    /// Depths that chains keep to; of chains over all lengths one that stands for all.
    fn depths(&self) -> Vec<u32> {
        let [fewest, most] = self.params.depths_of_chains();
        match self.space {
            Space::Whole => vec![0],
            Space::Multiplexed => (fewest..=most.min(LONGEST)).collect(),
        }
    }

    /// Candidates for the starts of chains, and the chains; `all` candidates in all, more of short
    /// paths, which carry more.
    fn start(
        &self,
        (scene, frame): (&Scene, &Frame),
        (candidates, seed): (u64, u64),
        (chains, all): (usize, u64),
        workers: &Workers,
        stats: &mut PassStats,
    ) -> Result<(Seeds, Vec<Walk>), RenderError> {
        let depths = self.depths();
        let share = |d: &u32| 1.0 / f64::from(d + 1);
        let shares: f64 = depths.iter().map(share).sum();
        let count = |d: &u32| ((all as f64 * share(d) / shares).ceil() as u64).max(2);
        let counts: Vec<u64> = depths.iter().map(count).collect();
        let room = || (State::default(), self.estimator(scene, frame));
        let seeds = Seeds::find(
            workers,
            &counts,
            room,
            |(state, estimator), start, stats| {
                candidate(state, estimator, candidates, (depths[start.kind], start.number), stats)
            },
            stats,
        )?;
        let mut draws = film::stream(seed, 0x7365_6564, 0);
        let starts = seeds.choose(chains, self.params.startup, &mut draws);
        let mut estimator = self.estimator(scene, frame);
        let walks = starts.iter().enumerate().map(|(i, start)| {
            let depth = depths[start.kind];
            Walk::new(&mut estimator, (candidates, seed), *start, depth, i as u64, stats)
        });
        let walks = walks.collect();
        Ok((seeds, walks))
    }

    /// Learns the size of small steps, of chains that nothing is recorded of.
    fn learn_step(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        seed: u64,
        workers: &Workers,
    ) -> Result<(), RenderError> {
        let (learners, rounds, count) = LEARNERS;
        let few = u64::from(self.params.bootstrap / 8).max(256);
        let mut stats = PassStats::default();
        let seeds = (!seed, !seed);
        let (_, mut walks) =
            self.start((scene, frame), seeds, (learners, few), workers, &mut stats)?;
        let mut size = StepSize::new(self.small, SIZES, TARGET);
        for _ in 0..rounds {
            let steps = Steps { large: 0.0, small: size.size() };
            let room = || self.estimator(scene, frame);
            let mut blank = PassImage::new(0, 0, frame.layers.clone());
            let (moved, tallies) =
                film::run(workers, frame, &mut blank, &walks, room, |estimator, walk, out| {
                    let tally = walk.advance(estimator, count, steps, 0.0, out);
                    out.clear();
                    tally
                })?;
            walks = moved;
            let accepted: f64 = tallies.iter().map(|t| t.counts[1].accepted).sum();
            size.learn(accepted / (count as f64 * tallies.len().max(1) as f64));
        }
        self.small = size.size();
        Ok(())
    }

    /// What chains leave in a pass.
    fn steps(
        &self,
        (scene, frame): (&Scene, &Frame),
        (count, unit): (u64, f64),
        out: &mut PassImage,
        workers: &Workers,
    ) -> Result<(Vec<Walk>, Tally), RenderError> {
        let steps = Steps { large: self.params.large_step, small: self.small };
        let room = || self.estimator(scene, frame);
        let (walks, tallies) =
            film::run(workers, frame, out, &self.chains.walks, room, |estimator, walk, out| {
                walk.advance(estimator, count, steps, unit, out)
            })?;
        let mut tally = Tally::new(STRATEGIES.len());
        tallies.iter().for_each(|t| tally.add(t));
        Ok((walks, tally))
    }
}

impl Method for PrimarySpace {
    fn info(&self) -> &'static MethodInfo {
        match self.space {
            Space::Whole => &INFO,
            Space::Multiplexed => &MULTIPLEXED_INFO,
        }
    }

    fn report(&self) -> Vec<(String, f64)> {
        let mut report = self.chains.report(&STRATEGIES);
        report.push(("small_step".into(), self.small));
        report
    }

    fn prepare(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<(), RenderError> {
        needs_lens(scene)?;
        let seed = frame.sampler.config().seed;
        let [_, most] = self.params.depths();
        self.lights = lights::learn(scene, frame, most, workers);
        self.emission = emission_table(scene);
        if self.params.adapt {
            self.learn_step(scene, frame, seed, workers)?;
        }
        let chains = Schedule::new(frame, self.params.chains).chains;
        let all = u64::from(self.params.bootstrap);
        let mut stats = PassStats::default();
        let (seeds, walks) =
            self.start((scene, frame), (seed, seed), (chains, all), workers, &mut stats)?;
        self.chains = Chains::new(&seeds, walks);
        if self.params.startup == Startup::Discard {
            let mut blank = PassImage::new(frame.size()[0], frame.size()[1], frame.layers.clone());
            let skipped = (u64::from(self.params.discard), 0.0);
            (self.chains.walks, _) = self.steps((scene, frame), skipped, &mut blank, workers)?;
        }
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
        let lights = self.lights.as_ref().unwrap_or(&scene.light_selection);
        let settings = self.params.depths_of_direct().map(|d| self.params.settings(d));
        let mut stats = separate::pass(
            index,
            (scene, frame),
            settings,
            (lights, &self.emission),
            out,
            workers,
        )?;
        let schedule = Schedule::new(frame, self.params.chains);
        let unit = schedule.unit(self.chains.brightness);
        let moved = self.steps((scene, frame), (schedule.steps, unit), out, workers)?;
        stats += moved.1.stats;
        self.chains.moved(moved);
        Ok(Commit { kind: CommitKind::Average, stats })
    }

    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        self.chains.save(out)
    }

    fn load(&mut self, from: &mut dyn Read) -> io::Result<()> {
        self.chains.load(from)
    }
}
