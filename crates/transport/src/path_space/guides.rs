//! Where the eye's subpaths look for caustics, as paths from lights tell.
//!
//! ```text
//! p = α p_bsdf + (1 - α) p_guide,     β ← β f |cos| / p                                     (1)
//! ```
//!
//! A small light behind clear glass or water is met once in a million by an eye's subpath, and no vertex can
//! ask for it. Paths from the light tell where its caustics lie, and from which directions they come (Jensen 1995,
//! "Importance Driven Path Tracing using the Photon Map"): a field of these guides the eye at matte surfaces.
//! Where there are no caustics there is no guide.
//!
//! Densities of vertices stay those of the BSDF alone, and with them the weights of strategies: any weights of
//! one sum are right, and what caustics need has one strategy only. Roulette goes by f |cos| / p_bsdf, too: by
//! (1) it would end the rare subpaths that are meant to go on.

use super::{LightEnd, Subpath, Vertex, Walker};
use crate::frame::Frame;
use crate::guiding::{Field, Guide, LightRecord, LocalMixture, Mixture, is_matte};
use crate::method::{PassStats, RenderError};
use crate::roulette::{Roulette, Survival};
use crate::trees::mean;
use crate::workers::Workers;
use kaustika_math::Vec3;
use kaustika_sampling::hash::combine;
use kaustika_sampling::{Sampler, SamplerConfig, SamplerKind, SamplerPlan};
use kaustika_scene::bsdf::{Bsdf, Mode};
use kaustika_scene::{LightSelection, Scene, Surface};
use kaustika_spectra::Wavelengths;
use rayon::prelude::*;

/// Batches of paths from lights; each has twice as many as the one before.
const BATCHES: u32 = 4;
/// Paths of a chunk.
const CHUNK: u64 = 1024;
/// Records above which a cell is divided.
const MOST_RECORDS: f64 = 250.0;
/// Density per steradian above which a lobe makes caustics: a matte surface meets what is behind it once in π times as many tries.
const NARROW: f64 = 10.0;
/// A caustic's records over all paths below which it is not worth looking for.
const FEWEST: f64 = 1e-3;

/// Directions toward caustics' lights.
#[derive(Clone, Debug, Default)]
pub struct Guides {
    field: Field<Mixture>,
}

/// How light's paths are followed.
struct Light<'a> {
    scene: &'a Scene,
    emission: &'a LightSelection,
    plan: SamplerPlan,
    walker: Walker<'a>,
    bounces: usize,
}

impl Guides {
    /// Of a scene's caustics that paths of at most so many bounces bring; none if it has hardly any. `emission`
    /// chooses the lights, `few` is the number of paths of the first batch.
    ///
    /// # Errors
    /// If cancelled.
    pub fn learn(
        (scene, frame): (&Scene, &Frame),
        emission: &LightSelection,
        (bounces, few): (u32, u32),
        workers: &Workers,
    ) -> Result<Option<Guides>, RenderError> {
        let kind = SamplerKind::Independent;
        let seed = combine(frame.sampler.config().seed, 0x0067_7569_6465);
        let plan = SamplerPlan::new(SamplerConfig { kind, seed, ..frame.sampler.config() });
        let roulette = Roulette { survival: Survival::Throughput, rr_depth: 1, threshold: 0.4 };
        let walker = Walker::new(scene, roulette, Mode::Importance);
        let light = Light { scene, emission, plan, walker, bounces: bounces as usize };
        let mut field = Field::default();
        let mut first = 0;
        for batch in 0..BATCHES {
            let count = u64::from(few) << batch;
            let chunk = |c: u64| {
                let numbers = first + c * CHUNK..first + count.min((c + 1) * CHUNK);
                if workers.cancelled() { Vec::new() } else { light.caustics(numbers) }
            };
            let chunks = 0..count.div_ceil(CHUNK);
            let found: Vec<Vec<LightRecord>> =
                workers.install(|| chunks.into_par_iter().map(chunk).collect());
            if workers.cancelled() {
                return Err(RenderError::Cancelled);
            }
            let records = found.concat();
            if (records.len() as f64) < FEWEST * count as f64 {
                return Ok(None);
            }
            workers.install(|| field.learn(&records, &[], Some(MOST_RECORDS)));
            first += count;
        }
        Ok(Some(Guides { field }))
    }

    /// What draws directions at a surface that is seen from `wo`, if anything but its BSDF does.
    #[inline]
    pub fn at(&self, surface: &Surface, bsdf: &Bsdf, wo: Vec3) -> Option<Guide<LocalMixture<'_>>> {
        if !is_matte(bsdf) {
            return None;
        }
        self.field.at(surface.p).guide(surface.p, Some(surface.facing(wo)))
    }
}

impl Light<'_> {
    /// What arrives by narrow lobes at matte surfaces, of paths of these numbers.
    fn caustics(&self, numbers: std::ops::Range<u64>) -> Vec<LightRecord> {
        let (mut path, mut records) = (Subpath::default(), Vec::new());
        for number in numbers {
            let mut sampler: Sampler = self.plan.start([0, 0], number);
            let u = sampler.get_2d();
            let lambda = Wavelengths::sample_for(self.scene.mode, u.x);
            let emitted = LightEnd::emit(self.scene, self.emission, &lambda, u.y, &mut sampler);
            let Some((end, start)) = emitted else { continue };
            let mut stats = PassStats::default();
            self.walker.walk(&start, self.bounces, &mut sampler, &mut path, &mut stats);
            // How far it came by narrow lobes alone.
            let (mut from, mut far) = (end.p, if end.infinite { f32::INFINITY } else { 0.0 });
            let mut bent = false;
            for v in path.iter() {
                far += (v.surface.p - from).length();
                if bent && is_matte(&v.bsdf) {
                    records.push(record(v, far));
                }
                bent = v.delta || (v.pdf > NARROW && !is_matte(&v.bsdf));
                (from, far) = (v.surface.p, if bent { far } else { 0.0 });
            }
        }
        records
    }
}

/// What arrived at a vertex, from where it seems to be: mirrors show a light as far behind them as it is before them,
/// clear glass and water nearly so, curved glass anywhere.
fn record(v: &Vertex, distance: f32) -> LightRecord {
    let flux = mean(v.beta, &v.lambda);
    let (p, w) = (v.surface.p, v.wo);
    LightRecord { p, w, pdf: 1.0, radiance: flux, distance, pdf_bsdf: 1.0, product: flux }
}
