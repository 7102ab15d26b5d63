//! Photon mapping (Jensen 1995, 1996, 2001).
//!
//! Every pass, or every few, sends photons out anew and keeps them in two maps: all of them where
//! they met matte surfaces, and densely those that mirrors and glass have gathered. Rays from the
//! eye then take direct light from the lights, caustics from their map, mirrors' pictures by
//! going on, and all else by rays that read the map where they end. The error of a pass is smooth,
//! and no noise; radii shrink from pass to pass, so that pictures converge.

pub mod cached;
mod credits;
mod emission;
mod estimate;
mod eye;
pub mod field;
mod gather;
mod guide;
mod guided;
mod irradiance;
mod lobes;
mod params;
mod photon;
mod tracing;

pub use guided::GuidedPhotonMapper;
pub use params::{Filter, PhotonMapParams, parameters};
pub use photon::{Arrival, Photon, PhotonMap};
pub use tracing::Past;

use self::emission::Emission;
use self::estimate::Reading;
use self::eye::Eye;
use self::irradiance::Cache;
use self::tracing::{Keep, Tracer};
use crate::frame::{Frame, pass_number};
use crate::lights;
use crate::method::{
    Bias, Commit, CommitKind, Method, MethodInfo, PassStats, RenderError, Schedule,
};
use crate::path_space::Chain;
use crate::workers::Workers;
use kaustika_film::accumulate::PassImage;
use kaustika_sampling::hash::combine;
use kaustika_sampling::{SamplerConfig, SamplerKind, SamplerPlan};
use kaustika_scene::{LightSelection, Scene};
use kaustika_spectra::{ColorMode, Wavelengths};

/// What photon mapping is.
pub static INFO: MethodInfo = MethodInfo {
    name: "photonmap",
    summary: "photon mapping: global and caustic maps, final gathering, irradiance caching",
    path_class: "L(D|S)*E",
    misses: "media",
    bias: Bias::Consistent,
    media: false,
    layers: false,
    schedule: Schedule::Stateless,
    one_spp: "one camera path a pixel and its gather rays, and the photons of the maps",
    source: "Jensen 1996, 2001; Ward, Rubinstein & Clear 1988",
};

/// The method.
#[derive(Debug)]
pub struct PhotonMapper {
    params: PhotonMapParams,
    /// How lights are chosen from surfaces, if that was learned.
    lights: Option<LightSelection>,
    everywhere: Emission,
    toward_glossy: Emission,
    /// Maps of the passes that share them, and the number of their first.
    maps: Option<(u64, Maps)>,
}

/// What passes share.
#[derive(Debug)]
struct Maps {
    global: PhotonMap,
    caustics: PhotonMap,
    cache: Option<Cache>,
}

impl PhotonMapper {
    /// With these parameters.
    pub fn new(params: PhotonMapParams) -> PhotonMapper {
        PhotonMapper {
            params,
            lights: None,
            everywhere: Emission::default(),
            toward_glossy: Emission::default(),
            maps: None,
        }
    }

    /// The first of the passes that share maps with pass `index`.
    fn first_of(&self, index: u64, scene: &Scene) -> u64 {
        match scene.mode {
            ColorMode::Spectral => index,
            ColorMode::Rgb => index - index % u64::from(self.params.renew),
        }
    }

    /// What sees by the maps of the passes from `first` on.
    fn eye<'a>(
        &'a self,
        first: u64,
        scene: &'a Scene,
        frame: &'a Frame,
        maps: &'a Maps,
    ) -> Eye<'a> {
        let (params, shrink) = (&self.params, self.params.shrink(first));
        let reading = |nearest, radius: f32| Reading {
            nearest,
            radius: radius * scene.radius,
            shrink,
            filter: params.filter,
            checking: params.checking,
        };
        let (lambda, time) = shared(first, scene, frame);
        Eye {
            scene,
            frame,
            params,
            lights: self.lights.as_ref().unwrap_or(&scene.light_selection),
            maps,
            global: reading(params.nearest, params.radius),
            caustics: reading(params.caustic_nearest, params.caustic_radius),
            lambda,
            time,
            roulette: params.roulette(),
            max_depth: params.max_bounces(),
            only_depth: u32::try_from(params.only_depth).ok(),
            measurements: &[],
        }
    }

    /// The maps of the passes from `first` on.
    fn trace(
        &self,
        first: u64,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
        stats: &mut PassStats,
    ) -> Result<Maps, RenderError> {
        let params = &self.params;
        let (lambda, time) = shared(first, scene, frame);
        let mut map = |keep: Keep, emission: &Emission, count: u32| {
            let plan = &plan(frame, keep);
            let (matte, max_depth) = (params.matte, params.max_bounces());
            let chain = Chain::ANY;
            Tracer { scene, emission, plan, lambda, time, keep, matte, max_depth, chain }.map(
                first * u64::from(count),
                count,
                params.search,
                workers,
                stats,
            )
        };
        Ok(Maps {
            global: map(Keep::All, &self.everywhere, params.photons)?,
            caustics: map(Keep::Caustics, &self.toward_glossy, params.caustic_photons)?,
            cache: None,
        })
    }
}

/// The numbers of photons: one sequence over all of all passes, so that what leaves the lights is
/// stratified.
fn plan(frame: &Frame, keep: Keep) -> SamplerPlan {
    let config = frame.sampler.config();
    let kind = match config.kind {
        SamplerKind::Independent => SamplerKind::Independent,
        _ => SamplerKind::Sobol,
    };
    let seed = combine(config.seed, 0x7068_6f74_6f6e ^ keep as u64);
    SamplerPlan::new(SamplerConfig { kind, seed, spp: 1, resolution: [1, 1] })
}

/// Wavelengths and time of the passes that share maps from `first` on.
fn shared(first: u64, scene: &Scene, frame: &Frame) -> (Wavelengths, f32) {
    let seed = frame.sampler.config().seed;
    let lambda = Wavelengths::sample_for(scene.mode, pass_number(first, seed));
    (lambda, pass_number(first, combine(seed, 1)))
}

impl Method for PhotonMapper {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn prepare(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<(), RenderError> {
        self.lights = lights::learn(scene, frame, self.params.max_bounces(), workers);
        self.everywhere = Emission::new(scene);
        let seed = combine(frame.sampler.config().seed, 0x616d);
        self.toward_glossy = Emission::toward_glossy(scene, self.params.matte, seed);
        self.maps = None;
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
        let mut stats = PassStats::default();
        let first = self.first_of(index, scene);
        let mut maps = match self.maps.take().filter(|(of, _)| *of == first) {
            Some((_, maps)) => maps,
            None => self.trace(first, scene, frame, workers, &mut stats)?,
        };
        let params = &self.params;
        if params.cache > 0.0 && params.gather > 0 && maps.cache.is_none() {
            let error = params.cache * params.shrink(first);
            let eye = self.eye(first, scene, frame, &maps);
            maps.cache = Some(eye.overture(first, error, workers, &mut stats)?);
        }
        let eye = self.eye(first, scene, frame, &maps);
        stats += eye.look(index, out, workers)?;
        self.maps = Some((first, maps));
        Ok(Commit { kind: CommitKind::Average, stats })
    }
}

/// Photon mapping with these parameters: guided, or with a rule that splits, its photons grow trees.
///
/// # Errors
/// If what is asked for does not go together.
pub fn make(params: PhotonMapParams) -> Result<Box<dyn Method>, String> {
    if !params.guiding && params.roulette.survival().is_some() {
        return Ok(Box::new(PhotonMapper::new(params)));
    }
    let way_out = "or `guiding` at false and `roulette` at none, throughput or albedo";
    if params.renew > 1 {
        return Err(format!(
            "photons that are guided or split learn from every pass: leave `renew` at 1, {way_out}"
        ));
    }
    if params.cache > 0.0 {
        return Err(format!(
            "photons that are guided or split learn where pixels read them, and the irradiance \
             cache hides that: leave `cache` at 0, {way_out}"
        ));
    }
    Ok(Box::new(GuidedPhotonMapper::new(params)))
}
