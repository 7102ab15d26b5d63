//! Photon mapping whose photons learn from those before them from where, whereto and how often
//! they should go to be read (Vorba et al. 2014; Vorba & Křivánek 2016, sec. 5).
//!
//! ```text
//! p(ω) = α p_bsdf(ω) + (1 - α) p_guide(ω)     directions, p_guide by importance, see [`crate::guiding`]
//! q = window of ν W/I and others              roulette and splitting, see [`crate::roulette`]
//! p(l, u, v)                                  lights, places and directions of emission
//! x = X_p/(N Φ_p)                             importance of a photon's place: what the reads made of it    (1)
//! I = E[ν₀ W]                                 what a photon contributes on average, with all that follows
//! ```
//!
//! Photons become trees, whose vertices stay in the maps with the power that they have. The eye's
//! reads credit them (see [`super::credits`]), and when the picture of a pass is done its trees are swept from
//! their leaves to their roots: each vertex then knows what came of it. Both maps learn on their own: caustic photons
//! need other places than those that matte surfaces scatter.
//!
//! Powers vary now. Where W is high the window splits photons before they arrive, so that those of one place come to be alike.
//! Passes come in iterations of 1, 2, 4, ...; while one runs, what earlier ones learned is frozen.

mod deposit;

use self::deposit::{Deposits, Floor, Origin};
use super::params::PhotonMapParams;
use super::photon::{MAX_DEPTH, PhotonMap};
use super::tracing::Keep;
use super::{Maps, PhotonMapper, shared};
use crate::frame::Frame;
use crate::guiding::Pixels;
use crate::method::{
    Bias, Commit, CommitKind, Method, MethodInfo, PassStats, RenderError, Schedule,
};
use crate::particle::light_trees::{
    EmissionRecord, Forest, Grove, Grower, Importance, PATHS, mislead,
};
use crate::roulette::Splitting;
use crate::saved::Saved;
use crate::trees::Records;
use crate::workers::Workers;
use kaustika_film::accumulate::PassImage;
use kaustika_math::Vec3;
use kaustika_scene::Scene;
use kaustika_spectra::Spectrum;
use rayon::prelude::*;
use std::io::{self, Read, Write};

/// What it is.
static INFO: MethodInfo = MethodInfo {
    name: "photonmap",
    summary: "photon mapping whose photons learn from where, whereto and how often to go",
    path_class: "L(D|S)*E",
    misses: "media",
    bias: Bias::Consistent,
    media: false,
    layers: false,
    schedule: Schedule::Sequential,
    one_spp: "one camera path a pixel and its gather rays, and the trees of photons of the maps",
    source: "Jensen 1996, 2001; Vorba et al. 2014; Vorba & Křivánek 2016",
};

/// Records after which a cell divides, times √ of the passes of the iteration.
const MOST_RECORDS: f64 = 1000.0;
/// Weight of a pass at most, over the first's.
const MOST_WEIGHT: f32 = 1e3;

/// The method.
#[derive(Debug)]
pub struct GuidedPhotonMapper {
    plain: PhotonMapper,
    global: Importance,
    caustics: Importance,
    pixels: Pixels,
    /// Weight of a pass, from the variance of those before.
    weight: f32,
    /// See [`GuidedPhotonMapper::misled`].
    misled: bool,
}

/// A map, and the trees that it came from.
struct Planted {
    map: PhotonMap,
    /// Where the photons came from, in the map's order: group and node.
    origins: Vec<(u32, Origin)>,
    groves: Vec<Grove>,
}

impl Planted {
    /// What is to be learned from it, now that it has been read.
    fn harvest(mut self, scene: &Scene) -> (Records, Vec<EmissionRecord>) {
        if let Some(credits) = self.map.credits() {
            for (x, (group, of)) in credits.iter().zip(&self.origins) {
                if of.flux > 0.0 {
                    let node = &mut self.groves[*group as usize].nodes[of.node as usize];
                    node.found = Spectrum::splat(x / of.flux); // (1)
                }
            }
        }
        let harvest = |grove: &mut Grove| {
            let (mut records, mut emitted) = (Records::default(), Vec::new());
            grove.harvest(scene.mode, &mut records, &mut emitted);
            (records, emitted)
        };
        let of_groups: Vec<_> = self.groves.par_iter_mut().map(harvest).collect();
        let (mut records, mut emitted) = (Records::default(), Vec::new());
        for (r, e) in of_groups {
            records.light.extend(r.light);
            records.reflected.extend(r.reflected);
            emitted.extend(e);
        }
        (records, emitted)
    }
}

impl GuidedPhotonMapper {
    /// With these parameters.
    pub fn new(params: PhotonMapParams) -> GuidedPhotonMapper {
        let importance = || Importance::new(params.guiding);
        GuidedPhotonMapper {
            global: importance(),
            caustics: importance(),
            pixels: Pixels::new(0, 0),
            weight: 1.0,
            misled: false,
            plain: PhotonMapper::new(params),
        }
    }

    /// Learns nonsense: what it renders must stay right.
    pub fn misled(self) -> GuidedPhotonMapper {
        GuidedPhotonMapper { misled: true, ..self }
    }

    /// Photons of the global map of pass `index` and their fluxes, W, the mean over the lanes; to be
    /// looked at.
    ///
    /// # Errors
    /// As [`Method::pass`].
    pub fn photons(
        &self,
        index: u64,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<Vec<(Vec3, f32)>, RenderError> {
        let stats = &mut PassStats::default();
        let map = self.plant((index, true), Keep::All, scene, frame, workers, stats)?;
        let share = 1.0 / self.plain.params.photons as f32;
        let photon =
            |(i, (_, of)): (usize, &(u32, Origin))| (map.map.at(i as u32), of.flux * share);
        Ok(map.origins.iter().enumerate().map(photon).collect())
    }

    /// The map of pass `index`, and its trees if something is to be learned of them.
    fn plant(
        &self,
        (index, learns): (u64, bool),
        keep: Keep,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
        stats: &mut PassStats,
    ) -> Result<Planted, RenderError> {
        let params = &self.plain.params;
        let (importance, unguided, count) = match keep {
            Keep::All => (&self.global, &self.plain.everywhere, params.photons),
            Keep::Caustics => (&self.caustics, &self.plain.toward_glossy, params.caustic_photons),
        };
        let grower = Grower {
            scene,
            unguided,
            emission: &importance.emission,
            field: &importance.field,
            splitting: Splitting {
                rule: params.roulette,
                splits: params.splitting,
                window: params.window,
                totals: importance.totals,
            },
            roulette: params.roulette(),
            measurement: importance.measurement,
            max_depth: params.max_bounces().min(MAX_DEPTH) as usize,
        };
        let (plan, (lambda, time)) = (super::plan(frame, keep), shared(index, scene, frame));
        let share = 1.0 / count as f32;
        let (first, count) = (index * u64::from(count), u64::from(count));
        let group = |group: u64| {
            let (mut forest, mut deposits) = (Forest::default(), Deposits::default());
            let mut stats = PassStats::default();
            if !workers.cancelled() {
                let from = group * u64::from(PATHS);
                let numbers = from..count.min(from + u64::from(PATHS));
                let beginnings = numbers.map(|i| (plan.start([0, 0], first + i), lambda, time));
                let (deposits, matte, seed) = (&mut deposits, params.matte, first + from);
                let mut floor = Floor { deposits, keep, share, matte, seed };
                forest.trace(&grower, beginnings, &mut floor, &mut stats);
            }
            (deposits, learns.then_some(forest.grove), stats)
        };
        workers.install(|| {
            let groups = count.div_ceil(u64::from(PATHS));
            let groups: Vec<_> = (0..groups).into_par_iter().map(group).collect();
            if workers.cancelled() {
                return Err(RenderError::Cancelled);
            }
            let (mut places, mut photons, mut groves) = (Vec::new(), Vec::new(), Vec::new());
            let mut origins = Vec::new();
            for (number, (deposits, grove, s)) in (0..).zip(groups) {
                places.extend(deposits.places);
                photons.extend(deposits.photons);
                if learns {
                    origins.extend(deposits.origins.into_iter().map(|of| (number, of)));
                }
                groves.extend(grove);
                *stats += s;
            }
            let (mut map, order) = PhotonMap::ordered(params.search, &places, &photons);
            if learns {
                map.ask();
                origins = order.iter().map(|&i| origins[i as usize]).collect();
            }
            Ok(Planted { map, origins, groves })
        })
    }

    /// Learns from a pass; at the end of an iteration takes over what it learned.
    fn learn(&mut self, index: u64, planted: [Planted; 2], values: &mut [f32], scene: &Scene) {
        let passes = 1u64 << (index + 1).ilog2();
        let ends = (index + 2).is_power_of_two() || index + 1 == self.plain.params.training;
        let most = ends.then(|| MOST_RECORDS * (passes as f64).sqrt());
        let params = &self.plain.params;
        let counts = [params.photons, params.caustic_photons].map(f64::from);
        let maps = [&mut self.global, &mut self.caustics];
        for ((importance, planted), paths) in maps.into_iter().zip(planted).zip(counts) {
            let (mut records, mut emitted) = planted.harvest(scene);
            if self.misled {
                records.mislead(values, index);
                mislead(&mut emitted, index);
            }
            importance.learn(paths, &records, &emitted, most);
            if ends {
                importance.refine();
            }
        }
        self.pixels.learn(values);
        if let (true, Some(variance)) = (ends, self.pixels.end()) {
            self.weight = (self.pixels.plain() / variance).clamp(1.0 / MOST_WEIGHT, MOST_WEIGHT);
        }
    }
}

/// Grey values of a picture.
fn grey(image: &PassImage) -> Vec<f32> {
    let pixels = image.data().chunks(image.layers().stride());
    pixels.map(|p| (p[0] + p[1] + p[2]) / 3.0).collect()
}

impl Method for GuidedPhotonMapper {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn prepare(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<(), RenderError> {
        self.plain.prepare(scene, frame, workers)?;
        let [width, height] = frame.size().map(|n| n as usize);
        self.pixels = Pixels::new(width, height);
        self.global.begin(scene.lights.len());
        self.caustics.begin(scene.lights.len());
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
        let learns = index < self.plain.params.training;
        let mut plant = |keep| self.plant((index, learns), keep, scene, frame, workers, &mut stats);
        let [mut global, mut caustics] = [plant(Keep::All)?, plant(Keep::Caustics)?];
        let maps = Maps { global: global.map, caustics: caustics.map, cache: None };
        let mut look = |maps: &Maps, measurements: &[f32], out: &mut PassImage| {
            let mut eye = self.plain.eye(index, scene, frame, maps);
            eye.measurements = measurements;
            stats += eye.look(index, out, workers)?;
            Ok::<(), RenderError>(())
        };
        let kind = CommitKind::Weighted(self.weight);
        if !learns {
            look(&maps, &[], out)?;
            return Ok(Commit { kind, stats });
        }
        let mut values;
        if self.pixels.measurements().is_empty() {
            // Nobody knows yet what the pixels are worth: the first picture is taken twice.
            look(&maps, &[], out)?;
            values = grey(out);
            let mut pixels = self.pixels.clone();
            pixels.learn(&values);
            let [width, height] = frame.size();
            let mut again = PassImage::new(width, height, frame.layers.clone());
            look(&maps, pixels.measurements(), &mut again)?;
        } else {
            look(&maps, self.pixels.measurements(), out)?;
            values = grey(out);
        }
        (global.map, caustics.map) = (maps.global, maps.caustics);
        workers.install(|| self.learn(index, [global, caustics], &mut values, scene));
        Ok(Commit { kind, stats })
    }

    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        self.global.save(out)?;
        self.caustics.save(out)?;
        self.pixels.save(out)?;
        self.weight.save(out)
    }

    fn load(&mut self, from: &mut dyn Read) -> io::Result<()> {
        self.global.load(from)?;
        self.caustics.load(from)?;
        self.pixels = Saved::load(from)?;
        self.weight = Saved::load(from)?;
        Ok(())
    }
}
