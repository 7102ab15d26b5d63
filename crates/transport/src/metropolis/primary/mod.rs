//! Metropolis light transport in primary sample space: over path tracing or bidirectional path
//! tracing (Kelemen et al. 2002), and multiplexed (Hachisuka et al. 2014).
//!
//! Chains walk through the numbers that paths are made of. Proposals are symmetric there, so that
//! acceptance is a ratio of brightness, and all that the sampler underneath does well stays.

mod candidates;
mod estimator;
mod eye_paths;
mod params;
mod walk;

pub use params::{
    Direct, Over, PrimaryParams, common, multiplexed_parameters, parameters, probability,
};

use self::estimator::{Estimator, Space};
use self::walk::{STRATEGIES, State, Steps, Walk, worth};
use super::chains::{Chains, Generation};
use super::film::{self, Schedule, of_generation};
use super::seeds::{Asked, Seeds, Startup};
use super::separate;
use super::step_size::StepSize;
use crate::frame::Frame;
use crate::lights;
use crate::method::{
    Bias, Commit, CommitKind, Method, MethodInfo, RenderError, Schedule as Passes, Trust,
};
use crate::path_space::{Guides, Splat, emission_table, needs_lens};
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
    one_spp: "`steps` mutations a pixel (rounded up to whole chains), and a sample of direct light",
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
    guides: Option<Guides>,
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
            guides: None,
            chains: Chains::default(),
        }
    }

    /// The picture's brightness, summed over pixels, without what is rendered separately, and its standard error.
    pub fn brightness(&self) -> [f64; 2] {
        [self.chains.candidates.mean(), self.chains.candidates.error()]
    }

    fn estimator<'a>(&'a self, scene: &'a Scene, frame: &'a Frame) -> Estimator<'a> {
        let lights = self.lights.as_ref().unwrap_or(&scene.light_selection);
        let (lights, guides) = ((lights, &self.emission), self.guides.as_ref());
        Estimator::new(scene, frame, &self.params, self.space, lights, guides)
    }

    /// A generation of chains and their starts, from streams of these numbers, for the candidates, their trial and the rest.
    fn start(
        &self,
        (scene, frame): (&Scene, &Frame),
        [candidates, trial, seed]: [u64; 3],
        (schedule, asked): (Schedule, Asked),
        workers: &Workers,
    ) -> Result<Generation<Walk>, RenderError> {
        let room = || (State::default(), self.estimator(scene, frame));
        let weigh = |(state, estimator): &mut (State, Estimator), number, of_trial| {
            worth(state, estimator, if of_trial { trial } else { candidates }, number)
        };
        let seeds = Seeds::find(workers, (asked, schedule.groups), room, weigh)?;
        let mut estimator = self.estimator(scene, frame);
        let make = |start, chain| Some(Walk::new(&mut estimator, (candidates, seed), start, chain));
        let draws = film::stream(seed, 0x7365_6564, 0);
        Ok(Generation::start(schedule, &seeds, self.params.startup, draws, make))
    }

    /// The generation of this number.
    fn generation(
        &self,
        number: u64,
        asked: Asked,
        (scene, frame): (&Scene, &Frame),
        workers: &Workers,
    ) -> Result<Generation<Walk>, RenderError> {
        let seed = of_generation(frame.sampler.config().seed, number);
        let seeds = [seed, seed ^ 0x7472_6c31, seed];
        let asked = (self.schedule(frame), asked);
        let mut chains = self.start((scene, frame), seeds, asked, workers)?;
        if self.params.startup == Startup::Discard {
            let (count, how) = (u64::from(self.params.discard), self.how());
            let room = || self.estimator(scene, frame);
            chains.skip(workers, room, |estimator, walk, unit, out| {
                walk.advance(estimator, count, how, unit, out)
            })?;
        }
        Ok(chains)
    }

    fn schedule(&self, frame: &Frame) -> Schedule {
        Schedule::new(frame, self.params.chains, self.params.steps)
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
        let schedule = Schedule { groups: 1, chains: learners, steps: count };
        let seeds = [!seed, seed ^ 0x7472_6961, !seed];
        // What they start with need not be known well.
        let asked = (schedule, Asked::AtLeast(few, 1.0));
        let mut chains = self.start((scene, frame), seeds, asked, workers)?;
        let mut size = StepSize::new(self.small, SIZES, TARGET);
        for _ in 0..rounds {
            let steps = Steps { large: 0.0, small: size.size() };
            let room = || self.estimator(scene, frame);
            let tallies = chains.skip(workers, room, |estimator, walk, unit, out| {
                walk.advance(estimator, count, steps, unit, out)
            })?;
            let accepted: f64 = tallies.iter().map(|t| t.counts[1].accepted).sum();
            size.learn(accepted / (count as f64 * tallies.len().max(1) as f64));
        }
        self.small = size.size();
        Ok(())
    }

    fn how(&self) -> Steps {
        Steps { large: self.params.large_step, small: self.small }
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

    fn trust(&self) -> Option<Trust> {
        self.chains.trust()
    }

    fn remarks(&self) -> Vec<String> {
        self.chains.remarks("large steps that were accepted")
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
        if self.params.guiding {
            let how = (most, self.params.bootstrap);
            self.guides = Guides::learn((scene, frame), &self.emission, how, workers)?;
        }
        if self.params.adapt {
            self.learn_step(scene, frame, seed, workers)?;
        }
        let fewest = u64::from(self.params.bootstrap);
        let asked = Asked::AtLeast(fewest, self.params.brightness_error);
        let first = self.generation(0, asked, (scene, frame), workers)?;
        self.chains = Chains::new((frame, self.schedule(frame)), first);
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
        let schedule = self.schedule(frame);
        let renew = |(number, count)| {
            self.generation(number, Asked::Exactly(count), (scene, frame), workers)
        };
        let renewed = self.chains.due(schedule, self.params.renew).map(renew).transpose()?;
        let how = self.how();
        let room = || self.estimator(scene, frame);
        let step = |estimator: &mut Estimator, walk: &mut Walk, unit, out: &mut Vec<Splat>| {
            walk.advance(estimator, schedule.steps, how, unit, out)
        };
        let moved = self.chains.pass(renewed, workers, (frame, schedule), out, room, step)?;
        stats += moved.stats();
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
