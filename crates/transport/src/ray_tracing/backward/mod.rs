//! Backward ray tracing (Arvo 1986), the first method that drew caustics: light is followed
//! through mirrors and glass and caught in illumination maps on the diffuse surfaces behind them;
//! then rays are traced from the eye, and find it there.

mod estimate;
mod maps;
mod params;

pub use maps::{Light, Maps};
pub use params::{BackwardParams, parameters};

use self::estimate::Estimator;
use crate::frame::Frame;
use crate::lights;
use crate::method::{
    Bias, Commit, CommitKind, Method, MethodInfo, PassStats, RenderError, Schedule,
};
use crate::path_space::{Subpath, emission_table, needs_lens};
use crate::workers::Workers;
use kaustika_film::accumulate::PassImage;
use kaustika_scene::{LightSelection, Scene};

/// What backward ray tracing is.
pub static INFO: MethodInfo = MethodInfo {
    name: "backward",
    summary: "backward ray tracing: illumination maps catch caustics, then rays from the eye",
    path_class: "LS*[D]S*E",
    misses: "light scattered by more than one matte surface: ... D ... D ...",
    bias: Bias::Biased,
    media: false,
    layers: false,
    schedule: Schedule::Stateless,
    one_spp: "one camera path and one light path a pixel",
    source: "Arvo 1986; Whitted 1980",
};

/// Samples of a chunk.
const CHUNK: u32 = 4096;

/// The method.
#[derive(Debug)]
pub struct Backward {
    params: BackwardParams,
    lights: Option<LightSelection>,
    emission: LightSelection,
}

impl Backward {
    /// With these parameters.
    pub fn new(params: BackwardParams) -> Backward {
        Backward { params, lights: None, emission: LightSelection::default() }
    }

    /// The illumination maps of a pass, after [`Method::prepare`]: to be measured.
    ///
    /// # Errors
    /// If cancelled.
    pub fn maps(
        &self,
        index: u64,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<Maps, RenderError> {
        self.estimator(index, scene, frame).maps(workers, &mut PassStats::default())
    }

    fn estimator<'a>(&'a self, index: u64, scene: &'a Scene, frame: &'a Frame) -> Estimator<'a> {
        let lights = self.lights.as_ref().unwrap_or(&scene.light_selection);
        Estimator::new(scene, frame, &self.params, (lights, &self.emission), index)
    }
}

impl Method for Backward {
    fn info(&self) -> &'static MethodInfo {
        &INFO
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
        let estimator = self.estimator(index, scene, frame);
        let mut stats = PassStats::default();
        let maps = estimator.maps(workers, &mut stats)?;
        stats += frame.sample_pixels(
            out,
            workers,
            CHUNK,
            Subpath::default,
            |eye, pixel, features, stats| estimator.sample(pixel, features, &maps, eye, stats),
        )?;
        Ok(Commit { kind: CommitKind::Average, stats })
    }
}
