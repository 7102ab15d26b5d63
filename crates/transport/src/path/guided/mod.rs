//! Guided path tracing: paths that learn from those before them where light comes from, where to
//! go on, and where to split.
//!
//! ```text
//! p(ω) = α p_bsdf(ω) + (1 - α) p_guide(ω)        directions, see [`crate::guiding`]
//! q = ν L/I and others                           roulette and splitting, see [`crate::roulette`]
//! ```
//!
//! Passes come in iterations of 1, 2, 4, 8, ... While one runs, what earlier ones learned is
//! frozen; at its end all it saw is taken over (Müller, Gross & Novák 2017). Every pass is an
//! unbiased picture whatever was learned before it. Passes are averaged by weights that are one
//! over the variance of the passes before.
//!
//! Trees cost more than plain paths side by side: if after some passes variance times cost is not
//! small enough beside that of the first pass, which knew nothing, plain paths go on.
//!
//! Good where light comes from few directions: doors that stand ajar, lamps in shades, windows.
//! What nobody has found yet, nobody can learn: caustics of small lamps want `bdpt` or `vcm`.

mod absorption;
mod params;
mod trace;
mod vertex;

pub use params::{GuidedParams, parameters};

use self::trace::{Forest, Growth, Harvest};
use super::integrate::Integrator;
use super::wave::Wave;
use super::{rows, trace_alone};
use crate::frame::Frame;
use crate::guiding::{AnyField, Pixels};
use crate::lights;
use crate::method::{
    Bias, Commit, CommitKind, Method, MethodInfo, PassStats, RenderError, Schedule,
};
use crate::path::PathParams;
use crate::roulette::efficiency::Totals;
use crate::roulette::{Rule, Splitting};
use crate::saved::Saved;
use crate::trees::Records;
use crate::workers::Workers;
use kaustika_film::accumulate::PassImage;
use kaustika_scene::{LightSelection, Scene};
use std::io::{self, Read, Write};

/// What the guided path tracer is.
pub static INFO: MethodInfo = MethodInfo {
    name: "guided",
    summary: "path tracing that learns where light comes from, where paths end and where they split",
    path_class: "L(D|S)*E",
    misses: "light of points, spots, directions and beams that mirrors or clear glass turn first: L S_M+ ...",
    bias: Bias::Unbiased,
    media: false,
    layers: false,
    schedule: Schedule::Sequential,
    one_spp: "one camera path, or tree of paths, a pixel",
    source: "Müller, Gross & Novák 2017; Vorba & Křivánek 2016; Rath et al. 2022",
};

/// As [`INFO`], of the path tracer without guide but with rules that split.
static SPLITTING_INFO: MethodInfo = MethodInfo {
    name: "path",
    summary: "path tracing with next event estimation, multiple importance sampling and splitting",
    ..INFO
};

/// Records after which a cell divides, times √ of the passes of the iteration.
const MOST_RECORDS: f64 = 1000.0;
/// Trees of a pass that are learned from, about: large pictures have more than enough.
const MOST_TREES: f64 = 131_072.0;
/// Weight of a pass at most, over the first's.
const MOST_WEIGHT: f32 = 1e3;
/// Time for a ray of a tree over that of a plain path's: measured, see docs/guided.md.
const DEARER: f32 = 2.0;
/// When plain and guided paths are compared: passes done.
const TRIALS: [u64; 3] = [15, 31, 127];
/// How many times dearer guided paths may be then, over the relative variance of a plain sample (at
/// least 1). The greater that is, the more can still be gained, and the more of it plain paths have
/// missed.
const PATIENCE: f32 = 0.25;

/// The method.
#[derive(Debug)]
pub struct Guided {
    params: GuidedParams,
    of_path: PathParams,
    field: AnyField,
    pixels: Pixels,
    totals: Option<Totals>,
    /// V̄ of the iteration before that.
    earlier: Option<f32>,
    /// Rays of this iteration, as costs.
    cost: f64,
    /// Weight of a pass, from the variance of those before.
    weight: f32,
    /// Cost of a sample of the first pass.
    plain_cost: f32,
    /// True once it showed that learning does not pay.
    plain: bool,
    lights: Option<LightSelection>,
    /// See [`Guided::misled`].
    misled: bool,
}

impl Guided {
    /// With these parameters.
    pub fn new(params: GuidedParams) -> Guided {
        Guided {
            of_path: params.of_path(),
            field: AnyField::new(params.field),
            params,
            pixels: Pixels::new(0, 0),
            totals: None,
            earlier: None,
            cost: 0.0,
            weight: 1.0,
            plain_cost: 0.0,
            plain: false,
            lights: None,
            misled: false,
        }
    }

    /// Learns nonsense: what it renders must stay right.
    pub fn misled(self) -> Guided {
        Guided { misled: true, ..self }
    }

    /// True if this pass is learned from.
    fn learns(&self, index: u64) -> bool {
        index < self.params.training
    }

    /// A pass of trees, guided by what is known so far.
    fn forests(
        &self,
        index: u64,
        integrator: &Integrator,
        out: &mut PassImage,
        workers: &Workers,
    ) -> Result<Vec<Harvest>, RenderError> {
        // A rule that asks what is still to come waits until directions are known: before, it would
        // end paths where light is yet to be found. The first pass is of plain paths.
        let rule = self.params.roulette;
        let waits = rule.learns() && !matches!(self.field, AnyField::None(_));
        let waits = waits && (1..self.params.warmup).contains(&index);
        let rule = if waits { Rule::None } else { rule };
        let growth = Growth {
            field: &self.field,
            keeps_albedo: self.params.roulette.survival().is_none(),
            splitting: Splitting {
                rule,
                splits: self.params.splitting,
                window: self.params.window,
                totals: self.totals,
            },
            roulette: PathParams { roulette: rule, ..self.of_path.clone() }.roulette(),
            measurements: self.pixels.measurements(),
        };
        let size = integrator.frame().size();
        let pixels: u32 = size.iter().product();
        let learned = match self.learns(index) {
            true => MOST_TREES / f64::from(pixels),
            false => 0.0,
        };
        let rows = rows(size);
        workers.bands(out, rows, Forest::default, |forest, band| {
            forest.trace(integrator, &growth, index, learned, band)
        })
    }

    /// Learns from a pass; at the end of an iteration takes over what it learned.
    fn learn(
        &mut self,
        index: u64,
        records: &Records,
        [values, plain]: [&[f32]; 2],
        stats: &PassStats,
    ) {
        let passes = 1u64 << (index + 1).ilog2();
        let ends = (index + 2).is_power_of_two() || index + 1 == self.params.training;
        let most = ends.then(|| MOST_RECORDS * (passes as f64).sqrt());
        self.field.learn(&records.light, &records.reflected, most);
        self.pixels.learn(values);
        self.pixels.learn_plain(plain);
        self.cost += stats.closest_rays as f64 + 0.5 * stats.shadow_rays as f64;
        if ends {
            let done = (index + 2 - passes) as f64;
            let cost = (self.cost / (done * values.len() as f64)) as f32;
            self.cost = 0.0;
            if index == 0 {
                self.plain_cost = cost;
            }
            let Some(variance) = self.pixels.end() else { return };
            let before = std::mem::replace(&mut self.earlier, self.totals.map(|t| t.variance));
            self.totals = Some(Totals { variance, cost });
            let plain = self.pixels.plain();
            self.weight = (plain / variance).clamp(1.0 / MOST_WEIGHT, MOST_WEIGHT);
            if self.params.fallback && !self.pays(index + 1, before, variance, cost) {
                self.plain = true;
                self.weight = 1.0;
            }
        }
    }
}

impl Guided {
    /// False if plain paths should go on after the iteration that ends at so many passes. Its samples
    /// had this variance and cost; `before` is the variance two iterations before.
    fn pays(&self, passes: u64, before: Option<f32>, variance: f32, cost: f32) -> bool {
        let plain = self.pixels.plain();
        if passes == 3 {
            // Even without variance trees would not be worth their time.
            return plain > DEARER;
        }
        if !TRIALS.contains(&passes) {
            return true;
        }
        let work = match passes <= self.params.warmup {
            // As if two more iterations brought what the last two brought, and then as many rays as
            // plain paths have: while no path ends many more are traced.
            true => {
                let before = before.unwrap_or(variance);
                variance * (variance / before) * self.plain_cost
            }
            false => variance * cost,
        };
        work * DEARER <= (PATIENCE * plain).max(1.0) * plain * self.plain_cost
    }
}

impl Method for Guided {
    fn info(&self) -> &'static MethodInfo {
        match self.field {
            AnyField::None(_) => &SPLITTING_INFO,
            AnyField::Quadtree(_) | AnyField::Mixture(_) => &INFO,
        }
    }

    fn report(&self) -> Vec<(String, f64)> {
        let Some(Totals { variance, cost }) = self.totals else { return Vec::new() };
        let figures = [
            ("variance", variance),
            ("rays", cost),
            ("variance_of_plain_paths", self.pixels.plain()),
            ("rays_of_plain_paths", self.plain_cost),
            ("goes_on_as_plain_paths", f32::from(u8::from(self.plain))),
        ];
        figures.map(|(name, value)| (name.into(), f64::from(value))).to_vec()
    }

    fn grows_trees(&self) -> bool {
        true
    }

    fn knows_media(&self, scene: &Scene) -> bool {
        absorption::only_absorbs(scene)
    }

    fn prepare(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<(), RenderError> {
        let [width, height] = frame.size().map(|n| n as usize);
        self.pixels = Pixels::new(width, height);
        if self.params.mis.samples_lights() && !scene.has_media() {
            self.lights = lights::learn(scene, frame, self.of_path.max_bounces(), workers);
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
        let integrator = Integrator::new(scene, frame, &self.of_path).with_lights(lights);
        let kind = CommitKind::Weighted(self.weight);
        if self.plain {
            let bands =
                workers.bands(out, rows(frame.size()), Wave::new, |wave, band| {
                    match scene.has_media() {
                        true => trace_alone(&integrator, index, band),
                        false => wave.trace(&integrator, index, band),
                    }
                })?;
            return Ok(Commit { kind, stats: bands.into_iter().sum() });
        }
        let harvests = self.forests(index, &integrator, out, workers)?;
        let mut stats = PassStats::default();
        let (mut records, mut values, mut plain) = (Records::default(), Vec::new(), Vec::new());
        for of_band in harvests {
            stats += of_band.stats;
            records.light.extend(of_band.records.light);
            records.reflected.extend(of_band.records.reflected);
            values.extend(of_band.values);
            plain.extend(of_band.plain);
        }
        if self.learns(index) {
            if self.misled {
                records.mislead(&mut values, index);
            }
            workers.install(|| self.learn(index, &records, [&values, &plain], &stats));
        }
        Ok(Commit { kind, stats })
    }

    fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        self.field.save(out)?;
        self.pixels.save(out)?;
        self.totals.save(out)?;
        self.earlier.save(out)?;
        (self.cost, self.weight).save(out)?;
        (self.plain_cost, self.plain).save(out)
    }

    fn load(&mut self, from: &mut dyn Read) -> io::Result<()> {
        self.field = Saved::load(from)?;
        self.pixels = Saved::load(from)?;
        self.totals = Saved::load(from)?;
        self.earlier = Saved::load(from)?;
        (self.cost, self.weight) = Saved::load(from)?;
        (self.plain_cost, self.plain) = Saved::load(from)?;
        Ok(())
    }
}
