//! Metropolis light transport in path space (Veach & Guibas 1997; Veach 1997, ch. 11).
//!
//! A state is a whole path, whoever made it; mutations change a part of it, and their densities are
//! known exactly. What is found once is explored: small moves of either end keep to a caustic
//! or to the light through a gap.

mod bidirectional;
mod kept;
mod lens_subpath;
mod mutation;
mod params;
mod path;
mod perturbation;
#[cfg(test)]
mod tests;
mod tracer;
mod walk;

pub use params::{Mutation, PathParams, parameters};

use self::path::Measure;
use self::tracer::Tracer;
use self::walk::{Walk, candidate};
use super::chains::Chains;
use super::film::{self, Field, Schedule};
use super::seeds::{Seeds, Startup};
use super::separate;
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

/// What Metropolis light transport in path space is.
pub static INFO: MethodInfo = MethodInfo {
    name: "mlt",
    summary: "Metropolis light transport: mutations of whole paths, bidirectional, lens, caustic and multi-chain",
    path_class: "L(D|S)*E",
    misses: "caustics of lights without extent that are seen through mirrors or clear glass alone; light of beams; paths of more than 64 bounces",
    bias: Bias::Unbiased,
    media: false,
    layers: false,
    schedule: Passes::Sequential,
    one_spp: "one mutation a pixel (rounded up to whole chains), and a sample of direct light",
    source: "Veach & Guibas 1997; Veach 1997, ch. 11",
};

/// The method.
#[derive(Debug)]
pub struct Mlt {
    params: PathParams,
    lights: Option<LightSelection>,
    emission: LightSelection,
    chains: Chains<Walk>,
}

impl Mlt {
    /// With these parameters.
    pub fn new(params: PathParams) -> Mlt {
        Mlt { params, lights: None, emission: LightSelection::default(), chains: Chains::default() }
    }

    /// The picture's brightness, summed over pixels, without what is rendered separately, and its
    /// standard error.
    pub fn brightness(&self) -> [f64; 2] {
        [self.chains.brightness, self.chains.error]
    }

    fn tracer<'a>(&'a self, scene: &'a Scene, frame: &'a Frame) -> Tracer<'a> {
        let lights = self.lights.as_ref().unwrap_or(&scene.light_selection);
        let field = Field::new(frame);
        let [w, h] = frame.resolution.map(f64::from);
        let measure =
            Measure { scene, lights, sensor: &frame.sensor, area: field.area(), pixels: w * h };
        let (emission, stats) = (&self.emission, PassStats::default());
        Tracer { scene, lights, emission, measure, field, stats }
    }

    fn steps(
        &self,
        (scene, frame): (&Scene, &Frame),
        (count, unit): (u64, f64),
        out: &mut PassImage,
        workers: &Workers,
    ) -> Result<(Vec<Walk>, Tally), RenderError> {
        let mut tally = Tally::new(Mutation::ALL.len());
        let Some(lengths) = self.params.lengths() else { return Ok((Vec::new(), tally)) };
        let room = || self.tracer(scene, frame);
        let how = (&self.params.mutations[..], lengths);
        let (walks, tallies) =
            film::run(workers, frame, out, &self.chains.walks, room, |tracer, walk, out| {
                walk.advance(tracer, count, how, unit, out)
            })?;
        tallies.iter().for_each(|t| tally.add(t));
        Ok((walks, tally))
    }
}

impl Method for Mlt {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn report(&self) -> Vec<(String, f64)> {
        self.chains.report(&Mutation::ALL.map(Mutation::name))
    }

    fn prepare(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<(), RenderError> {
        needs_lens(scene)?;
        self.lights = lights::learn(scene, frame, self.params.max_bounces(), workers);
        self.emission = emission_table(scene);
        let Some(lengths) = self.params.lengths() else { return Ok(()) };
        let seed = frame.sampler.config().seed;
        let room = || self.tracer(scene, frame);
        let mut stats = PassStats::default();
        let seeds = Seeds::find(
            workers,
            &[u64::from(self.params.bootstrap)],
            room,
            |tracer, start, _| {
                candidate(tracer, lengths, seed, start.number).map_or(0.0, |(_, weight)| weight)
            },
            &mut stats,
        )?;
        let chains = Schedule::new(frame, self.params.chains).chains;
        let starts =
            seeds.choose(chains, self.params.startup, &mut film::stream(seed, 0x7365_6564, 0));
        let mut tracer = self.tracer(scene, frame);
        let walks = starts.iter().enumerate().filter_map(|(i, start)| {
            let (path, _) = candidate(&mut tracer, lengths, seed, start.number)?;
            Some(Walk::new(&path, seed, i as u64))
        });
        let walks: Vec<Walk> = walks.collect();
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
        let settings = self.params.settings_of_direct();
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
