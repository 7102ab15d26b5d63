//! Guided light tracing: light paths that learn from those before them from where, whereto and how
//! often they should go to show in the picture. The dual of guided path tracing (Vorba et al. 2014;
//! Vorba & Křivánek 2016, sec. 5).
//!
//! ```text
//! p(ω) = α p_bsdf(ω) + (1 - α) p_guide(ω)     directions, p_guide by importance, see [`crate::guiding`]
//! q = ν W/I and others                        roulette and splitting, see [`crate::roulette`]
//! p(l, u, v)                                  lights, places and directions of emission
//! W = Σ Φ/I_px                                importance: what a unit of flux brings to the pixels,
//!                                             each over its expected value I_px
//! I = E[ν₀ W]                                 what a path contributes on average
//! ```
//!
//! Over I_px, so that all pixels come to the same relative error. Passes come in iterations of
//! 1, 2, 4, 8, ...; while one runs, what earlier ones learned is frozen. The first learns I_px alone.
//! Every pass is an unbiased picture whatever was learned before it.

mod lens;

use self::lens::{Lens, View, Waiting};
use super::LightParams;
use super::light_trees::{EmissionRecord, Forest, Grower, Importance, PATHS, mislead};
use crate::features::first_seen;
use crate::frame::Frame;
use crate::guiding::Pixels;
use crate::method::{
    Bias, Commit, CommitKind, Method, MethodInfo, PassStats, RenderError, Schedule,
};
use crate::path_space::{emission_table, needs_lens, splat_bands};
use crate::roulette::efficiency::Totals;
use crate::roulette::{Rule, Splitting};
use crate::saved::Saved;
use crate::trees::Records;
use crate::workers::Workers;
use kaustika_film::accumulate::{PassImage, PixelRecord};
use kaustika_math::Vec3;
use kaustika_scene::{LightSelection, Scene};
use kaustika_spectra::Wavelengths;
use std::io::{self, Read, Write};

/// What guided light tracing is.
static INFO: MethodInfo = MethodInfo {
    name: "light",
    summary: "light tracing that learns from where, whereto and how often light should go",
    path_class: "L(D|S)*(D|S_G)E",
    misses: "lights seen directly, and all that mirrors or clear glass show last: L ... S_M E",
    bias: Bias::Unbiased,
    media: false,
    layers: false,
    schedule: Schedule::Sequential,
    one_spp: "one light path, or tree of paths, for each pixel",
    source: "Vorba et al. 2014; Vorba & Křivánek 2016; Rath et al. 2022",
};

/// Samples of a chunk.
const CHUNK: u32 = 4096;
/// Records after which a cell divides, times √ of the passes of the iteration.
const MOST_RECORDS: f64 = 250.0;
/// Weight of a pass at most, over the first's.
const MOST_WEIGHT: f32 = 1e3;

/// What a thread works with.
type Room<'a> = (Forest<'a>, Waiting);

/// What a band of paths gives besides its splats.
#[derive(Default)]
struct Harvest {
    stats: PassStats,
    records: Records,
    emitted: Vec<EmissionRecord>,
}

/// The method.
#[derive(Debug)]
pub struct GuidedLight {
    params: LightParams,
    /// Lights by power.
    table: LightSelection,
    importance: Importance,
    pixels: Pixels,
    totals: Option<Totals>,
    /// Rays of this iteration, as costs.
    cost: f64,
    /// Weight of a pass, from the variance of those before.
    weight: f32,
    /// See [`GuidedLight::misled`].
    misled: bool,
}

impl GuidedLight {
    /// With these parameters.
    pub fn new(params: LightParams) -> GuidedLight {
        let importance = Importance::new(params.guiding);
        GuidedLight {
            params,
            table: LightSelection::default(),
            importance,
            pixels: Pixels::new(0, 0),
            totals: None,
            cost: 0.0,
            weight: 1.0,
            misled: false,
        }
    }

    /// Learns nonsense: what it renders must stay right.
    pub fn misled(self) -> GuidedLight {
        GuidedLight { misled: true, ..self }
    }

    /// Where the paths of pass `index` would be scattered by surfaces that are not mirrors or clear
    /// glass, the copies of a path counted as often as they arrive; to be looked at.
    ///
    /// # Errors
    /// As [`Method::pass`].
    pub fn vertices(
        &self,
        index: u64,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<Vec<Vec3>, RenderError> {
        let [width, height] = frame.size();
        let mut image = PassImage::new(width, height, frame.layers.clone());
        let harvest = self.trace((index, true), scene, frame, &mut image, workers)?;
        Ok(harvest.records.reflected.iter().map(|r| r.p).collect())
    }

    /// Traces the paths of a pass; whether it learns beside its number.
    fn trace(
        &self,
        (index, learns): (u64, bool),
        scene: &Scene,
        frame: &Frame,
        out: &mut PassImage,
        workers: &Workers,
    ) -> Result<Harvest, RenderError> {
        let [width, height] = frame.size();
        let rule = self.params.roulette;
        let measurement = self.importance.measurement;
        let grower = Grower {
            scene,
            unguided: &self.table,
            emission: &self.importance.emission,
            field: &self.importance.field,
            splitting: Splitting {
                rule,
                splits: self.params.splitting,
                window: self.params.window,
                totals: self.totals,
            },
            roulette: self.params.roulette(),
            measurement: match rule {
                // Go with the winners asks for nothing; variances are of pixels over I_px, too.
                Rule::Efficiency => measurement / self.pixels.lit(),
                _ => measurement,
            },
            max_depth: self.params.max_bounces(),
        };
        let view = View {
            scene,
            frame,
            pixels: self.pixels.measurements(),
            only_depth: self.params.only_bounces(),
            scale: 1.0 / (width as f32 * height as f32),
        };
        let rows = CHUNK.div_ceil(out.width()).max(1);
        let region = frame.region;
        let bands = splat_bands(workers, frame, out, rows, Room::default, |room, band, splats| {
            let mut harvest = Harvest::default();
            let (width, pixels) = (band.width(), band.width() * band.height());
            let at = |i: u32| [i % width, i / width];
            let first = band.y;
            let pixel = |i: u32| [region[0] + at(i)[0], region[1] + first + at(i)[1]];
            for first in (0..pixels).step_by(PATHS as usize) {
                let beginnings = (first..pixels.min(first + PATHS)).map(|i| {
                    let mut sampler = frame.sampler.start(pixel(i), index);
                    let u = sampler.get_2d();
                    (sampler, Wavelengths::sample_for(scene.mode, u.x), u.y)
                });
                let (forest, waiting) = room;
                let mut lens = Lens { view, waiting, splats };
                forest.trace(&grower, beginnings, &mut lens, &mut harvest.stats);
                if learns {
                    let Harvest { records, emitted, .. } = &mut harvest;
                    forest.grove.harvest(scene.mode, records, emitted);
                }
            }
            for i in 0..pixels {
                let record = match band.wants_features() {
                    true => first_seen(scene, frame, pixel(i), index),
                    false => PixelRecord::default(),
                };
                band.add(at(i)[0], at(i)[1], &PixelRecord { weight: 1.0, ..record });
            }
            harvest
        })?;
        let mut whole = Harvest::default();
        for band in bands {
            whole.stats += band.stats;
            whole.records.light.extend(band.records.light);
            whole.records.reflected.extend(band.records.reflected);
            whole.emitted.extend(band.emitted);
        }
        Ok(whole)
    }

    /// Learns from a pass; at the end of an iteration takes over what it learned.
    fn learn(
        &mut self,
        index: u64,
        records: &Records,
        emitted: &[EmissionRecord],
        values: &[f32],
        stats: &PassStats,
    ) {
        let passes = 1u64 << (index + 1).ilog2();
        let ends = (index + 2).is_power_of_two() || index + 1 == self.params.training;
        let paths = values.len() as f64;
        if index > 0 {
            let most = ends.then(|| MOST_RECORDS * (passes as f64).sqrt());
            self.importance.learn(paths, records, emitted, most);
        }
        self.pixels.learn(values);
        self.cost += stats.closest_rays as f64 + 0.5 * stats.shadow_rays as f64;
        if !ends {
            return;
        }
        let cost = (self.cost / ((index + 2 - passes) as f64 * paths)) as f32;
        self.cost = 0.0;
        self.importance.refine();
        if let Some(variance) = self.pixels.end() {
            self.totals = Some(Totals { variance, cost });
            let plain = self.pixels.plain();
            self.weight = (plain / variance).clamp(1.0 / MOST_WEIGHT, MOST_WEIGHT);
        }
    }
}

impl Method for GuidedLight {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn prepare(&mut self, scene: &Scene, frame: &Frame, _: &Workers) -> Result<(), RenderError> {
        needs_lens(scene)?;
        let [width, height] = frame.size().map(|n| n as usize);
        self.pixels = Pixels::new(width, height);
        self.table = emission_table(scene);
        self.importance.begin(scene.lights.len());
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
        let learns = index < self.params.training;
        // The first pass does not know what the pixels are worth.
        let mut harvest = self.trace((index, learns && index > 0), scene, frame, out, workers)?;
        let (kind, stats) = (CommitKind::Weighted(self.weight), harvest.stats);
        if learns {
            let pixels = out.data().chunks(out.layers().stride());
            let mut values: Vec<f32> = pixels.map(|p| (p[0] + p[1] + p[2]) / 3.0).collect();
            if self.misled {
                harvest.records.mislead(&mut values, index);
                mislead(&mut harvest.emitted, index);
            }
            workers.install(|| {
                self.learn(index, &harvest.records, &harvest.emitted, &values, &stats);
            });
        }
        Ok(Commit { kind, stats })
    }

    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        self.importance.save(out)?;
        self.pixels.save(out)?;
        self.totals.save(out)?;
        (self.cost, self.weight).save(out)
    }

    fn load(&mut self, from: &mut dyn Read) -> io::Result<()> {
        self.importance.load(from)?;
        self.pixels = Saved::load(from)?;
        self.totals = Saved::load(from)?;
        (self.cost, self.weight) = Saved::load(from)?;
        Ok(())
    }
}
