//! Path tracing (Kajiya 1986) with light and BSDF sampling combined by multiple importance
//! sampling (Veach 1997, ch. 9).
//!
//! Good at everything that a camera path can find or see directly; bad at caustics from small
//! lights, which it finds by chance or, from points and directions, not at all.

mod integrate;
mod params;
mod walk;
mod wave;

pub use integrate::{Integrator, PathSample};
pub use params::{PathParams, parameters};

use self::wave::Wave;
use crate::frame::Frame;
use crate::lights;
use crate::method::{
    Bias, Commit, CommitKind, Method, MethodInfo, PassStats, RenderError, Schedule,
};
use crate::workers::Workers;
use kaustika_film::accumulate::PassImage;
use kaustika_scene::{LightSelection, Scene};

/// What the path tracer is.
pub static INFO: MethodInfo = MethodInfo {
    name: "path",
    summary: "path tracing with next event estimation and multiple importance sampling",
    path_class: "L(D|S)*E",
    bias: Bias::Unbiased,
    schedule: Schedule::Stateless,
    one_spp: "one camera path a pixel",
    source: "Kajiya 1986; Veach 1997, ch. 9",
};

/// Rows of a chunk: small enough to share out, large enough to be worth it.
const ROWS: u32 = 4;

/// The path tracer.
#[derive(Debug)]
pub struct PathTracer {
    params: PathParams,
    side_by_side: Option<bool>,
    /// How lights are chosen, if that was learned.
    lights: Option<LightSelection>,
}

impl PathTracer {
    /// With these parameters.
    pub fn new(params: PathParams) -> PathTracer {
        PathTracer { params, side_by_side: None, lights: None }
    }

    /// Whether paths are traced side by side or one after the other, instead of what suits the
    /// size of the scene. Changes nothing but time.
    pub fn with_paths_side_by_side(self, side_by_side: bool) -> PathTracer {
        PathTracer { side_by_side: Some(side_by_side), ..self }
    }
}

impl Method for PathTracer {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn prepare(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<(), RenderError> {
        if self.params.mis.samples_lights() {
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
        let side_by_side = self.side_by_side.unwrap_or(scene.geometry.outgrows_caches());
        let bands = workers
            .bands(out, ROWS, |band| Wave::new(side_by_side).trace(&integrator, index, band))?;
        let mut stats = PassStats::default();
        bands.into_iter().for_each(|s| stats += s);
        Ok(Commit { kind: CommitKind::Average, stats })
    }
}
