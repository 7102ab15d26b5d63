//! Bidirectional path tracing (Lafortune & Willems 1993; Veach & Guibas 1994; Veach 1997, ch. 10).
//!
//! Every sample makes a subpath from a light and one from the eye, joins every vertex of the one
//! to every vertex of the other, and weighs each joint path against all ways to have made it.
//! Good at caustics on what is seen directly and at light that comes over a corner; bad at
//! reflections of caustics, which no strategy but chance finds, or [`Guides`].

mod merging;
mod params;

pub use merging::{
    HashGrid, INFO as VCM_INFO, PPM_INFO, Vcm, VcmParams, parameters as vcm_parameters,
    ppm_parameters,
};
pub use params::{BdptParams, parameters};

use crate::frame::Frame;
use crate::lights;
use crate::method::{
    Bias, Commit, CommitKind, Method, MethodInfo, PassStats, RenderError, Schedule,
};
use crate::path_space::{Guides, emission_table, needs_lens, splat_bands};
use crate::strategies::{DEEPEST, Pairs, Pyramid};
use crate::workers::Workers;
use kaustika_film::accumulate::PassImage;
use kaustika_scene::{LightSelection, Scene};

/// What bidirectional path tracing is.
pub static INFO: MethodInfo = MethodInfo {
    name: "bdpt",
    summary: "bidirectional path tracing with all strategies combined by multiple importance sampling",
    path_class: "L(D|S)*E",
    misses: "caustics of points, spots, directions and beams that are seen through mirrors or clear glass alone: L S_M+ D S_M+ E",
    bias: Bias::Unbiased,
    media: true,
    layers: true,
    schedule: Schedule::Stateless,
    one_spp: "one camera path and one light path a pixel, all connections",
    source: "Veach & Guibas 1994; Veach 1997, ch. 10",
};

/// Samples of a chunk.
const CHUNK: u32 = 2048;
/// Paths from lights in the first batch that guides learn from.
const LIGHT_PATHS: u32 = 1 << 16;

/// The method.
#[derive(Debug)]
pub struct Bdpt {
    params: BdptParams,
    /// How lights are chosen from surfaces, if that was learned.
    lights: Option<LightSelection>,
    /// How lights are chosen to emit.
    emission: LightSelection,
    guides: Option<Guides>,
}

impl Bdpt {
    /// With these parameters.
    pub fn new(params: BdptParams) -> Bdpt {
        Bdpt { params, lights: None, emission: LightSelection::default(), guides: None }
    }
}

impl Method for Bdpt {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn never_of_points(&self) -> Option<&'static str> {
        Some("C<.S>+<.D><.S>+[^CRTVOB]")
    }

    fn layers(&self) -> Vec<String> {
        match self.params.pyramid {
            true => Pyramid::names((self.params.max_bounces() as usize).min(DEEPEST)),
            false => Vec::new(),
        }
    }

    fn prepare(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<(), RenderError> {
        needs_lens(scene)?;
        if self.params.pyramid && self.params.max_bounces() as usize > DEEPEST {
            let message =
                format!("a pyramid has a limit of {DEEPEST} bounces: set `-p max_depth=5`, say");
            return Err(RenderError::Failed(message));
        }
        self.lights = lights::learn(scene, frame, self.params.max_bounces(), workers);
        self.emission = emission_table(scene);
        if self.params.guiding {
            let how = (self.params.max_bounces(), LIGHT_PATHS);
            self.guides = Guides::learn((scene, frame), &self.emission, how, workers)?;
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
        let rows = CHUNK.div_ceil(out.width()).max(1);
        let room = || {
            let settings = self.params.settings();
            let pairs = Pairs::new(scene, frame, settings, lights, &self.emission);
            let pairs = pairs.guided(self.guides.as_ref());
            if self.params.pyramid { pairs.with_pyramid() } else { pairs }
        };
        let bands = splat_bands(workers, frame, out, rows, room, |room, band, splats| {
            let mut stats = PassStats::default();
            for ([x, y], pixel) in frame.places(band) {
                let features = band.wants_features();
                let record = room.sample(pixel, index, features, splats, &mut stats);
                band.add(x, y, &record);
                let [by_path, strategies] = room.layers();
                band.add_paths(x, y, record.weight, 0, by_path);
                band.add_paths(x, y, record.weight, by_path.len(), strategies);
            }
            stats
        })?;
        let stats = bands.into_iter().sum();
        Ok(Commit { kind: CommitKind::Average, stats })
    }
}
