//! Metropolis light transport in path space (Veach & Guibas 1997; Veach 1997, ch. 11).
//!
//! A state is a whole path, whoever made it; mutations change a part of it, and their densities are
//! known exactly. What is found once is explored: small moves of either end keep to a caustic
//! or to the light through a gap.

mod bidirectional;
mod candidates;
mod erpt;
mod guided;
mod kept;
mod lens_subpath;
mod manifold;
mod mutation;
mod params;
mod path;
mod perturbation;
mod specular;
#[cfg(test)]
mod tests;
mod tracer;
mod walk;

pub use erpt::{ERPT_INFO, Erpt};
pub use params::{Erpt as ErptParams, Mutation, PathParams, erpt_parameters, parameters};

use self::bidirectional::Lengths;
use self::path::Measure;
use self::tracer::Tracer;
use self::walk::{Walk, candidate, worth};
use super::chains::{Chains, Generation};
use super::film::{self, Field, Schedule, of_generation};
use super::seeds::{Asked, Seeds, Startup};
use super::separate;
use crate::frame::Frame;
use crate::lights;
use crate::method::{
    Bias, Commit, CommitKind, Method, MethodInfo, PassStats, RenderError, Schedule as Passes, Trust,
};
use crate::path_space::{Guides, Splat, Tracks, emission_table, needs_lens};
use crate::workers::Workers;
use kaustika_film::accumulate::PassImage;
use kaustika_scene::{LightSelection, Scene};
use std::io::{self, Read, Write};

/// What Metropolis light transport in path space is.
pub static INFO: MethodInfo = MethodInfo {
    name: "mlt",
    summary: "Metropolis light transport: mutations of whole paths: bidirectional, lens, caustic, multi-chain, lens subpath and manifold",
    path_class: "L(D|S)*E",
    misses: "caustics of lights without extent that are seen through mirrors or clear glass alone; light of beams; paths of more than 64 bounces",
    bias: Bias::Unbiased,
    media: false,
    layers: true,
    schedule: Passes::Sequential,
    one_spp: "`steps` mutations a pixel (rounded up to whole chains), and a sample of direct light",
    source: "Veach & Guibas 1997; Veach 1997, ch. 11",
};

/// The method.
#[derive(Debug)]
pub struct Mlt {
    params: PathParams,
    lights: Option<LightSelection>,
    emission: LightSelection,
    guides: Option<Guides>,
    chains: Chains<Walk>,
}

impl Mlt {
    /// With these parameters.
    pub fn new(params: PathParams) -> Mlt {
        let (emission, chains) = (LightSelection::default(), Chains::default());
        Mlt { params, lights: None, emission, guides: None, chains }
    }

    /// The picture's brightness, summed over pixels, without what is rendered separately, and its
    /// standard error.
    pub fn brightness(&self) -> [f64; 2] {
        [self.chains.candidates.mean(), self.chains.candidates.error()]
    }

    /// What paths need to be made.
    fn learn(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<(), RenderError> {
        needs_lens(scene)?;
        self.lights = lights::learn(scene, frame, self.params.max_bounces(), workers);
        self.emission = emission_table(scene);
        if self.params.guiding {
            let how = (self.params.max_bounces(), self.params.bootstrap);
            self.guides = Guides::learn((scene, frame), &self.emission, how, workers)?;
        }
        Ok(())
    }

    /// What chains leave out of a pass.
    fn separate(
        &self,
        index: u64,
        (scene, frame): (&Scene, &Frame),
        out: &mut PassImage,
        workers: &Workers,
    ) -> Result<PassStats, RenderError> {
        let lights = self.lights.as_ref().unwrap_or(&scene.light_selection);
        let settings = self.params.settings_of_direct();
        separate::pass(index, (scene, frame), settings, (lights, &self.emission), out, workers)
    }

    fn schedule(&self, frame: &Frame) -> Schedule {
        Schedule::new(frame, self.params.chains, self.params.steps)
    }

    /// The generation of chains of this number.
    fn generation(
        &self,
        number: u64,
        asked: Asked,
        lengths: Lengths,
        (scene, frame): (&Scene, &Frame),
        workers: &Workers,
    ) -> Result<Generation<Walk>, RenderError> {
        let seed = of_generation(frame.sampler.config().seed, number);
        let schedule = self.schedule(frame);
        let weigh = |tracer: &mut Tracer, number: u64, trial: bool| {
            worth(tracer, lengths, if trial { !seed } else { seed }, number)
        };
        let room = || self.tracer(scene, frame);
        let seeds = Seeds::find(workers, (asked, schedule.groups), room, weigh)?;
        let mut tracer = self.tracer(scene, frame);
        let make = |start: u64, chain: u64| {
            let (path, _) = candidate(&mut tracer, lengths, seed, start)?;
            Some(Walk::new(&path, seed, chain))
        };
        let draws = film::stream(seed, 0x7365_6564, 0);
        let startup = self.params.startup;
        let mut chains = Generation::start(schedule, &seeds, startup, draws, make);
        if startup == Startup::Discard {
            let (count, how) = (u64::from(self.params.discard), &self.params.mutations[..]);
            chains.skip(workers, room, |tracer, walk: &mut Walk, unit, out| {
                walk.advance(tracer, count, (how, lengths), unit, out)
            })?;
        }
        Ok(chains)
    }

    fn tracer<'a>(&'a self, scene: &'a Scene, frame: &'a Frame) -> Tracer<'a> {
        let lights = self.lights.as_ref().unwrap_or(&scene.light_selection);
        let field = Field::new(frame);
        let [w, h] = frame.resolution.map(f64::from);
        let measure =
            Measure { scene, lights, sensor: &frame.sensor, area: field.area(), pixels: w * h };
        let (emission, guides) = (&self.emission, self.guides.as_ref());
        let tracks = frame.paths.as_ref().map(|classes| Tracks::new(classes, scene));
        let stats = PassStats::default();
        Tracer { scene, lights, emission, measure, field, guides, tracks, stats }
    }
}

impl Method for Mlt {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn report(&self) -> Vec<(String, f64)> {
        self.chains.report(&Mutation::ALL.map(Mutation::name))
    }

    fn trust(&self) -> Option<Trust> {
        self.chains.trust()
    }

    fn remarks(&self) -> Vec<String> {
        self.chains.remarks("bidirectional mutations that were accepted")
    }

    fn prepare(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<(), RenderError> {
        self.learn(scene, frame, workers)?;
        let Some(lengths) = self.params.lengths() else { return Ok(()) };
        let fewest = u64::from(self.params.bootstrap);
        let asked = Asked::AtLeast(fewest, self.params.brightness_error);
        let first = self.generation(0, asked, lengths, (scene, frame), workers)?;
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
        let mut stats = self.separate(index, (scene, frame), out, workers)?;
        if let Some(lengths) = self.params.lengths() {
            let schedule = self.schedule(frame);
            let renew = |(number, count)| {
                let asked = Asked::Exactly(count);
                self.generation(number, asked, lengths, (scene, frame), workers)
            };
            let renewed = self.chains.due(schedule, self.params.renew).map(renew).transpose()?;
            let room = || self.tracer(scene, frame);
            let how = (&self.params.mutations[..], lengths);
            let step = |tracer: &mut Tracer, walk: &mut Walk, unit, out: &mut Vec<Splat>| {
                walk.advance(tracer, schedule.steps, how, unit, out)
            };
            let moved = self.chains.pass(renewed, workers, (frame, schedule), out, room, step)?;
            stats += moved.stats();
            self.chains.moved(moved);
        }
        Ok(Commit { kind: CommitKind::Average, stats })
    }

    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        self.chains.save(out)
    }

    fn load(&mut self, from: &mut dyn Read) -> io::Result<()> {
        self.chains.load(from)
    }
}
