//! Path tracing (Kajiya 1986) with light and BSDF sampling combined by multiple importance
//! sampling (Veach 1997, ch. 9).
//!
//! Good at everything that a camera path can find or see directly; bad at caustics from small
//! lights, which it finds by chance or, from points and directions, not at all.

mod classes;
pub mod guided;
mod integrate;
mod pack;
mod params;
mod plain;
mod polarized;
mod start;
mod volume;
mod walk;
mod wave;

pub use integrate::{Integrator, PathSample};
pub use params::{PathParams, parameters};

use self::classes::{ClassRoom, trace_classes};
use self::guided::Guided;
use self::polarized::trace_polarized;
use self::wave::{Wave, trace_alone};
use crate::frame::Frame;
use crate::lights;
use crate::method::{
    Bias, CAUSTICS_OF_POINTS, Commit, CommitKind, Method, MethodInfo, RenderError, Schedule,
};
use crate::path_space::{emission_table, needs_lens};
use crate::workers::Workers;
use kaustika_film::accumulate::PassImage;
use kaustika_scene::bsdf::Bsdf;
use kaustika_scene::{LightSelection, Scene};

/// What the path tracer is.
pub static INFO: MethodInfo = MethodInfo {
    name: "path",
    summary: "path tracing with next event estimation and multiple importance sampling",
    path_class: "L(D|S)*E",
    misses: "light of points, spots, directions and beams that mirrors or clear glass turn first: L S_M+ ...",
    bias: Bias::Unbiased,
    media: true,
    layers: true,
    schedule: Schedule::Stateless,
    one_spp: "one camera path a pixel",
    source: "Kajiya 1986; Veach 1997, ch. 9",
};

/// The path tracer with these parameters: with a rule that splits it grows trees.
pub fn make(params: PathParams) -> Result<Box<dyn Method>, String> {
    if params.roulette.survival().is_some() {
        return Ok(Box::new(PathTracer::new(params)));
    }
    if params.polarized {
        return Err("polarized paths know no rule that splits: leave out `polarized`".into());
    }
    Ok(Box::new(Guided::new(params.into())))
}

/// Samples of a chunk: several waves of paths.
const CHUNK: u32 = 8192;
/// Chunks of a pass at least, to be shared out.
const CHUNKS: u32 = 16;

/// Rows of a chunk. They depend on the picture alone.
fn rows([width, height]: [u32; 2]) -> u32 {
    CHUNK.div_ceil(width).min(height.div_ceil(CHUNKS)).max(1)
}

/// The path tracer.
#[derive(Debug)]
pub struct PathTracer {
    params: PathParams,
    alone: bool,
    /// How lights are chosen, if that was learned.
    lights: Option<LightSelection>,
    /// How lights are chosen to emit, if there are layers by path.
    emission: LightSelection,
}

impl PathTracer {
    /// With these parameters.
    pub fn new(params: PathParams) -> PathTracer {
        PathTracer { params, alone: false, lights: None, emission: LightSelection::default() }
    }

    /// Paths are traced one after the other instead of side by side: slow, and the same but for
    /// rounding. What the fast way is held against.
    pub fn alone(self) -> PathTracer {
        PathTracer { alone: true, ..self }
    }
}

impl Method for PathTracer {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn never_of_points(&self) -> Option<&'static str> {
        Some(CAUSTICS_OF_POINTS)
    }

    fn prepare(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<(), RenderError> {
        if self.params.polarized && frame.bands.is_some() {
            let message = "a spectral film keeps no polarization: leave out `-p polarized=true`";
            return Err(RenderError::Failed(message.into()));
        }
        if self.params.polarized && scene.has_media() {
            let message = "polarized light is not followed through participating media: leave \
                           out `-p polarized=true`";
            return Err(RenderError::Failed(message.into()));
        }
        if frame.paths.is_some() {
            if self.params.polarized {
                let message = "polarized light is not sorted by paths: leave out `--layer`";
                return Err(RenderError::Failed(message.into()));
            }
            if frame.bands.is_some() {
                let message = "a spectral film keeps no layers by path: leave out `--layer`";
                return Err(RenderError::Failed(message.into()));
            }
            needs_lens(scene)?;
            self.emission = emission_table(scene);
        }
        // What is learned of surfaces says nothing of points in media.
        if self.params.mis.samples_lights() && !scene.has_media() {
            self.lights = lights::learn(scene, frame, self.params.max_bounces(), workers);
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
        let integrator = Integrator::new(scene, frame, &self.params).with_lights(lights);
        let rows = rows(frame.size());
        // The vertices of paths through media have little in common: they go one by one.
        let alone = self.alone || scene.has_media();
        let bands = if let Some(classes) = &frame.paths {
            let room = || ClassRoom::new(&integrator, classes, &self.emission);
            workers
                .bands(out, rows, room, |room, band| trace_classes(&integrator, index, room, band))
        } else if self.params.polarized {
            workers.bands(out, rows, Bsdf::default, |bsdf, band| {
                trace_polarized(&integrator, index, bsdf, band)
            })
        } else {
            workers.bands(out, rows, Wave::new, |wave, band| match alone {
                true => trace_alone(&integrator, index, band),
                false => wave.trace(&integrator, index, band),
            })
        }?;
        Ok(Commit { kind: CommitKind::Average, stats: bands.into_iter().sum() })
    }
}
