//! Trees of rays from the eye: Whitted's (1980), whose rays go on by mirrors and clear glass alone,
//! and those of distributed ray tracing (Cook, Porter & Carpenter 1984), which are distributed
//! over glossy scattering too.

mod estimate;
mod params;

pub use params::{
    DistributedParams, Secondary, TreeParams, WhittedParams, distributed_parameters,
    whitted_parameters,
};

use self::estimate::{Asked, Estimator, Room};
use crate::frame::Frame;
use crate::lights;
use crate::method::{Bias, Commit, CommitKind, Method, MethodInfo, RenderError, Schedule};
use crate::path_space::needs_lens;
use crate::workers::Workers;
use kaustika_film::accumulate::PassImage;
use kaustika_scene::{LightSelection, Scene};

/// What Whitted's ray tracing is.
pub static WHITTED_INFO: MethodInfo = MethodInfo {
    name: "whitted",
    summary: "Whitted's ray tracing: ideal reflection and refraction, then direct light",
    path_class: "L[D|S]S_M*E",
    misses: "light scattered by more than one surface that is no mirror or clear glass",
    bias: Bias::Unbiased,
    media: false,
    layers: false,
    schedule: Schedule::Stateless,
    one_spp: "one tree of rays a pixel",
    source: "Whitted 1980",
};

/// What distributed ray tracing is.
pub static DISTRIBUTED_INFO: MethodInfo = MethodInfo {
    name: "distributed",
    summary: "distributed ray tracing: gloss, blur and soft shadows, then direct light",
    path_class: "L[D]S*E",
    misses: "light that meets a diffuse surface and then another surface on its way from the light: \
             L (D|S)+ D S* E",
    bias: Bias::Unbiased,
    media: false,
    layers: false,
    schedule: Schedule::Stateless,
    one_spp: "one tree of rays a pixel",
    source: "Cook, Porter & Carpenter 1984",
};

/// Samples of a chunk.
const CHUNK: u32 = 4096;
/// Lights at most to which every hit sends a shadow ray.
const MOST_LIGHTS: usize = 16;

/// Either method.
#[derive(Debug)]
pub struct RayTree {
    info: &'static MethodInfo,
    params: TreeParams,
    /// How lights are chosen, if that was learned.
    lights: Option<LightSelection>,
}

impl RayTree {
    /// Whitted's.
    pub fn whitted(params: WhittedParams) -> RayTree {
        RayTree { info: &WHITTED_INFO, params: params.into(), lights: None }
    }

    /// Cook's.
    pub fn distributed(params: DistributedParams) -> RayTree {
        RayTree { info: &DISTRIBUTED_INFO, params: params.into(), lights: None }
    }

    /// Which lights a hit asks for.
    fn asked<'a>(&'a self, scene: &'a Scene) -> Asked<'a> {
        let lights = self.lights.as_ref().unwrap_or(&scene.light_selection);
        match self.params.shadow_rays {
            0 if scene.lights.len() <= MOST_LIGHTS => Asked::Each,
            0 => Asked::Chosen(lights, MOST_LIGHTS as u32),
            n => Asked::Chosen(lights, n),
        }
    }
}

impl Method for RayTree {
    fn info(&self) -> &'static MethodInfo {
        self.info
    }

    fn prepare(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<(), RenderError> {
        needs_lens(scene)?;
        if let Asked::Chosen(..) = self.asked(scene) {
            self.lights = lights::learn(scene, frame, self.params.max_depth, workers);
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
        let estimator = Estimator::new(scene, frame, &self.params, self.asked(scene));
        let stats = frame.sample_pixels(
            out,
            workers,
            CHUNK,
            Room::default,
            |room, pixel, features, stats| estimator.sample(pixel, index, features, room, stats),
        )?;
        Ok(Commit { kind: CommitKind::Average, stats })
    }
}
