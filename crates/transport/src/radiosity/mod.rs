//! Radiosity (Goral, Torrance, Greenberg & Battaile 1984): diffuse light in equilibrium between
//! patches, whatever the view.
//!
//! Surfaces become a [`mesh`] of patches; [`form_factor`]s say what each gets of each; a [`solve`]r or
//! a [`hierarchy`] finds the irradiance of all, before the first pass. Passes show it.

mod bake;
mod estimate;
pub mod form_factor;
pub mod glossy;
pub mod hierarchy;
mod light_map;
pub mod mesh;
mod params;
mod points;
mod polish;
pub mod shading;
mod solution;
pub mod solve;
pub mod sources;

pub use params::{DirectLight, Display, RadiosityParams, Solver, parameters};
pub use solution::Solution;

use self::estimate::Estimator;
use crate::frame::Frame;
use crate::lights;
use crate::method::{
    Bias, Commit, CommitKind, LightMap, Method, MethodInfo, RenderError, Schedule,
};
use crate::workers::Workers;
use kaustika_film::accumulate::PassImage;
use kaustika_scene::bsdf::Bsdf;
use kaustika_scene::description::TriMesh;
use kaustika_scene::{LightSelection, Scene};
use kaustika_spectra::ColorMode;

/// What radiosity is.
pub static INFO: MethodInfo = MethodInfo {
    name: "radiosity",
    summary: "radiosity: diffuse light between patches, solved before the first pass",
    path_class: "LD*E",
    misses: "everything glossy, mirrored or transmitted; curves and distance grids reflect direct light alone",
    bias: Bias::Biased,
    media: false,
    layers: false,
    schedule: Schedule::Stateless,
    one_spp: "one camera ray a pixel, and what it asks or gathers",
    source: "Goral et al. 1984; Cohen et al. 1988; Hanrahan et al. 1991; Smits et al. 1994",
};

/// Samples of a chunk.
const CHUNK: u32 = 4096;

/// The method.
#[derive(Debug)]
pub struct Radiosity {
    params: RadiosityParams,
    lights: Option<LightSelection>,
    solution: Option<Solution>,
}

impl Radiosity {
    /// With these parameters.
    ///
    /// # Errors
    /// If they do not go together.
    pub fn new(params: RadiosityParams) -> Result<Radiosity, String> {
        params.check()?;
        Ok(Radiosity { params, lights: None, solution: None })
    }
}

impl Method for Radiosity {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn mode(&self) -> Option<ColorMode> {
        Some(ColorMode::Rgb)
    }

    fn report(&self) -> Vec<(String, f64)> {
        let Some(s) = &self.solution else { return Vec::new() };
        let figures = [("patches", s.leaves.len()), ("links", s.links), ("shots", s.shots)];
        figures.map(|(name, n)| (name.into(), n as f64)).into()
    }

    fn remarks(&self) -> Vec<String> {
        self.solution.as_ref().and_then(Solution::coarseness).into_iter().collect()
    }

    fn bakes(&self) -> bool {
        true
    }

    fn baked(&self, _scene: &Scene) -> Option<TriMesh> {
        self.solution.as_ref().map(bake::bake)
    }

    fn light_map(&self, _scene: &Scene) -> Option<LightMap> {
        self.solution.as_ref().and_then(light_map::light_map)
    }

    fn prepare(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<(), RenderError> {
        self.solution = Some(Solution::new(scene, &self.params, workers)?);
        self.lights = lights::learn(scene, frame, 1, workers);
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
        let Some(solution) = &self.solution else {
            return Err(RenderError::Failed("nothing was prepared".into()));
        };
        let lights = self.lights.as_ref().unwrap_or(&scene.light_selection);
        let estimator = Estimator { scene, frame, lights, solution, params: &self.params };
        let stats = frame.sample_pixels(
            out,
            workers,
            CHUNK,
            Bsdf::default,
            |bsdf, pixel, features, stats| estimator.sample(pixel, index, features, bsdf, stats),
        )?;
        Ok(Commit { kind: CommitKind::Average, stats })
    }
}
