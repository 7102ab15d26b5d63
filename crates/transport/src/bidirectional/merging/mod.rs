//! Vertex connection and merging (Georgiev, Křivánek, Davidovič & Slusallek 2012; as a path
//! sampling framework Hachisuka, Pantaleoni & Jensen 2012), and its parts: bidirectional path
//! tracing, bidirectional photon mapping, progressive photon mapping.
//!
//! To the strategies of bidirectional path tracing it adds another: the end of an eye path is
//! *merged* with the ends of all light paths of the pass that lie near. That finds what no
//! connection can, caustics seen in mirrors and through water, at the price of a blur that
//! shrinks from pass to pass (Knaus & Zwicker 2011).

mod estimate;
mod grid;
mod params;
mod photons;
mod recursion;

pub use grid::HashGrid;
pub use params::{Mode, VcmParams, parameters, ppm_parameters};

use self::estimate::Estimator;
use crate::frame::Frame;
use crate::lights;
use crate::method::{
    Bias, Commit, CommitKind, Method, MethodInfo, PassStats, RenderError, Schedule,
};
use crate::path_space::{emission_table, needs_lens, splat_bands};
use crate::workers::Workers;
use kaustika_film::accumulate::PassImage;
use kaustika_scene::{LightSelection, Scene};

/// What vertex connection and merging is.
pub static INFO: MethodInfo = MethodInfo {
    name: "vcm",
    summary: "vertex connection and merging: bidirectional path tracing with progressive photon mapping",
    path_class: "L(D|S)*E",
    misses: "nothing but light that meets the lens by itself; refuses meters",
    bias: Bias::Consistent,
    media: true,
    layers: true,
    schedule: Schedule::Stateless,
    one_spp: "one camera path and one light path a pixel, all connections and merges",
    source: "Georgiev, Křivánek, Davidovič & Slusallek 2012",
};

/// What progressive photon mapping is.
pub static PPM_INFO: MethodInfo = MethodInfo {
    name: "sppm",
    summary: "stochastic progressive photon mapping: photons near the first surface that is no mirror",
    path_class: "L(D|S)*DS*E",
    misses: "media; light that glossy surfaces alone have scattered before the eye is found by chance; refuses meters",
    bias: Bias::Consistent,
    media: false,
    layers: true,
    schedule: Schedule::Stateless,
    one_spp: "one camera path and one light path a pixel",
    source: "Hachisuka & Jensen 2009; Knaus & Zwicker 2011",
};

/// Samples of a chunk.
const CHUNK: u32 = 2048;

/// The method.
#[derive(Debug)]
pub struct Vcm {
    info: &'static MethodInfo,
    params: VcmParams,
    lights: Option<LightSelection>,
    emission: LightSelection,
}

impl Vcm {
    /// With these parameters.
    pub fn new(params: VcmParams) -> Vcm {
        Vcm { info: &INFO, params, lights: None, emission: LightSelection::default() }
    }

    /// Progressive photon mapping, whatever `params.mode` says.
    pub fn ppm(params: VcmParams) -> Vcm {
        let params = VcmParams { mode: Mode::Ppm, ..params };
        Vcm { info: &PPM_INFO, ..Vcm::new(params) }
    }
}

impl Method for Vcm {
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
        if scene.has_media() && !self.params.mode.connects() {
            let message = "light in participating media is connected, not merged: use the mode \
                           `vcm` or `bpt`";
            return Err(RenderError::Failed(message.into()));
        }
        if self.params.mode.connects() {
            self.lights = lights::learn(scene, frame, self.params.max_bounces(), workers);
        }
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
        let lights = self.lights.as_ref().unwrap_or(&scene.light_selection);
        let estimator = Estimator::new(scene, frame, &self.params, (lights, &self.emission), index);
        let mut stats = PassStats::default();
        let photons = estimator.photons(workers, &mut stats)?;
        let rows = CHUNK.div_ceil(out.width()).max(1);
        let bands = splat_bands(
            workers,
            frame,
            out,
            rows,
            || estimator.room(),
            |room, band, splats| {
                let mut stats = PassStats::default();
                for ([x, y], pixel) in frame.places(band) {
                    let features = band.wants_features();
                    let record =
                        estimator.sample(pixel, features, &photons, room, splats, &mut stats);
                    band.add(x, y, &record);
                    band.add_paths(x, y, record.weight, 0, room.layers());
                }
                stats
            },
        )?;
        stats += bands.into_iter().sum();
        Ok(Commit { kind: CommitKind::Average, stats })
    }
}
