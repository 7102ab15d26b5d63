//! Instant radiosity (Keller 1997): the vertices of a few light paths light the whole picture, as
//! if they were lamps.
//!
//! A lamp too near to what it lights makes a spot. So what two vertices exchange is bounded, and
//! what the bound cuts off is found by going on from the eye, which is good at short ways (Kollig
//! & Keller 2004): nothing is lost.

mod estimate;
mod params;

pub use params::{VplParams, parameters};

use self::estimate::Estimator;
use crate::frame::Frame;
use crate::lights;
use crate::method::{
    Bias, CAUSTICS_OF_POINTS, Commit, CommitKind, Method, MethodInfo, PassStats, RenderError,
    Schedule,
};
use crate::path_space::{emission_table, needs_lens};
use crate::workers::Workers;
use kaustika_film::accumulate::PassImage;
use kaustika_scene::{LightSelection, Scene};

/// What rendering with virtual lights is.
pub static INFO: MethodInfo = MethodInfo {
    name: "vpl",
    summary: "instant radiosity: virtual lights shared by all pixels, their bound compensated",
    path_class: "L(D|S)*E",
    misses: "light of points, spots, directions and beams that mirrors or clear glass turn first: L S_M+ ...",
    bias: Bias::Unbiased,
    media: true,
    layers: true,
    schedule: Schedule::Stateless,
    one_spp: "one camera path a pixel, joined with all virtual lights of the pass",
    source: "Keller 1997; Kollig & Keller 2004",
};

/// Samples of a chunk.
const CHUNK: u32 = 512;

/// The method.
#[derive(Debug)]
pub struct Vpl {
    params: VplParams,
    lights: Option<LightSelection>,
    emission: LightSelection,
}

impl Vpl {
    /// With these parameters.
    pub fn new(params: VplParams) -> Vpl {
        Vpl { params, lights: None, emission: LightSelection::default() }
    }
}

impl Method for Vpl {
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
        let lights = self.lights.as_ref().unwrap_or(&scene.light_selection);
        let estimator = Estimator::new(scene, frame, &self.params, (lights, &self.emission), index);
        let mut stats = PassStats::default();
        let virtual_lights = estimator.virtual_lights(&mut stats);
        let rows = CHUNK.div_ceil(out.width()).max(1);
        let bands = workers.bands(
            out,
            rows,
            || estimator.room(),
            |room, band| {
                let mut stats = PassStats::default();
                for ([x, y], pixel) in frame.places(band) {
                    let features = band.wants_features();
                    let record =
                        estimator.sample(pixel, features, &virtual_lights, room, &mut stats);
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
