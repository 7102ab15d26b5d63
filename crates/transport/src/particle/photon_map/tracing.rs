//! Photons on their way through the scene.
//!
//! ```text
//! P_x = Σ_c Φ_c w_x,c / Σ_c Φ_c,   Φ_c ← Φ_c w_x,c / P_x                            (2)
//! ```
//!
//! A photon is scattered by the matte part of a surface with probability P_D, by the sharp part
//! with P_S, or absorbed; w_x are the weights of a direction drawn from either part. Its power,
//! summed over the channels, never changes (unless a weight exceeds 1); only its colour does.

use super::emission::{Emission, Emitted, next_surface};
use super::lobes::{Parts, parts};
use super::photon::{Arrival, MAX_DEPTH, Photon, PhotonMap};
use crate::method::{PassStats, RenderError};
use crate::nearest::Layout;
use crate::path_space::Chain;
use crate::workers::Workers;
use kaustika_math::{Vec2, Vec3};
use kaustika_sampling::hash::{combine, unit};
use kaustika_sampling::{Sampler, SamplerPlan};
use kaustika_scene::bsdf::{Bsdf, BsdfSample, Lobes, Mode};
use kaustika_scene::{Scene, Surface};
use kaustika_spectra::{Spectrum, Wavelengths};
use rayon::prelude::*;

/// Photons of a chunk.
const CHUNK: u64 = 4096;

/// Which photons are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Keep {
    /// All at matte surfaces, L(D|S)*D.
    All,
    /// Those at the first matte surface that have met others, L S⁺ D.
    Caustics,
}

/// What all photons of a map share.
#[derive(Clone, Copy)]
pub(super) struct Tracer<'a> {
    pub(super) scene: &'a Scene,
    pub(super) emission: &'a Emission,
    pub(super) plan: &'a SamplerPlan,
    pub(super) lambda: Wavelengths,
    pub(super) time: f32,
    pub(super) keep: Keep,
    /// Glossy surfaces from this roughness on are matte.
    pub(super) matte: f32,
    pub(super) max_depth: u32,
    /// What lies between two matte surfaces.
    pub(super) chain: Chain,
}

/// What a photon has met before it arrives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Past {
    /// Nothing, or what goes straight through: L.
    Straight,
    /// Sharp surfaces alone: L S⁺.
    Caustic,
    /// A matte one too: L(D|S)* D S*.
    Reflected,
}

/// Photons and their places.
type Kept = (Vec<Vec3>, Vec<Photon>);

impl<'a> Tracer<'a> {
    /// The map of `count` photons emitted, those with the numbers from `first` on.
    pub(super) fn map(
        &self,
        first: u64,
        count: u32,
        layout: Layout,
        workers: &Workers,
        stats: &mut PassStats,
    ) -> Result<PhotonMap, RenderError> {
        let keep = |kept: &mut Kept, s: &Surface, arrival: &Arrival, _, u: f32| {
            kept.0.push(s.p);
            kept.1.push(Photon::new(arrival, u));
        };
        let chunks = self.arrivals(first, count, workers, stats, keep)?;
        let (mut places, mut photons) = Kept::default();
        for (p, q) in chunks {
            places.extend(p);
            photons.extend(q);
        }
        Ok(workers.install(|| PhotonMap::new(layout, &places, &photons)))
    }

    /// The same photons, chunk by chunk: `keep` puts what arrived at a surface into a chunk's `K`; it
    /// also gets what the photon had met, and a number in [0, 1) to round by.
    pub(super) fn arrivals<K: Default + Send>(
        &self,
        first: u64,
        count: u32,
        workers: &Workers,
        stats: &mut PassStats,
        keep: impl Fn(&mut K, &Surface, &Arrival, Past, f32) + Sync,
    ) -> Result<Vec<K>, RenderError> {
        let (count, share) = (u64::from(count), 1.0 / count as f32);
        let chunk = |chunk: u64| {
            let (mut kept, mut stats) = (K::default(), PassStats::default());
            let mut bsdf = Bsdf::default();
            if !workers.cancelled() {
                for i in chunk * CHUNK..count.min((chunk + 1) * CHUNK) {
                    let mut keep =
                        |s: &Surface, a: &Arrival, past, u| keep(&mut kept, s, a, past, u);
                    self.trace(first + i, share, &mut bsdf, &mut keep, &mut stats);
                }
            }
            (kept, stats)
        };
        let chunks: Vec<(K, PassStats)> =
            workers.install(|| (0..count.div_ceil(CHUNK)).into_par_iter().map(chunk).collect());
        if workers.cancelled() {
            return Err(RenderError::Cancelled);
        }
        let counted = |(kept, s)| {
            *stats += s;
            kept
        };
        Ok(chunks.into_iter().map(counted).collect())
    }

    /// Follows the photon number `i`, whose power is multiplied by `share`.
    fn trace(
        &self,
        i: u64,
        share: f32,
        bsdf: &mut Bsdf<'a>,
        keep: &mut impl FnMut(&Surface, &Arrival, Past, f32),
        stats: &mut PassStats,
    ) {
        let mut sampler = self.plan.start([0, 0], i);
        let mut lambda = self.lambda;
        let Some(Emitted { mut ray, power }) =
            self.emission.emit(self.scene, &lambda, &mut sampler)
        else {
            return;
        };
        ray.time = self.time;
        let mut power = power * share;
        let (mut past, mut mirrors) = (Past::Straight, 0);
        for depth in 1..=self.max_depth.min(MAX_DEPTH) {
            let surface = next_surface(self.scene, ray, &mut lambda, bsdf, stats);
            let Some(surface) = surface else { return };
            let wo = -ray.d;
            let mut parts = parts(bsdf, self.matte);
            parts.sharp = parts.sharp & self.chain.after(mirrors);
            let wanted = self.keep == Keep::All || depth > 1;
            if !parts.matte.is_empty() && wanted {
                let dispersed = lambda.secondary_terminated();
                let indirect = past == Past::Reflected;
                let arrival = Arrival { wi: wo, power, depth, indirect, dispersed };
                let u = unit((combine(i, depth.into()) >> 32) as u32);
                keep(&surface, &arrival, past, u);
            }
            let Some(on) = scatter(bsdf, &parts, wo, power, Mode::Importance, &mut sampler) else {
                return;
            };
            if on.matte && self.keep == Keep::Caustics {
                return;
            }
            (past, mirrors) = match (on.matte, past) {
                (true, _) => (Past::Reflected, 0),
                (false, _) if on.sample.lobe.has(Lobes::NULL) => (past, mirrors),
                (false, Past::Straight) => (Past::Caustic, mirrors + 1),
                (false, _) => (past, mirrors + 1),
            };
            power = on.power;
            ray = surface.spawn(on.sample.wi);
        }
    }
}

/// How a photon goes on.
pub(super) struct Scattered {
    pub(super) sample: BsdfSample,
    pub(super) power: Spectrum,
    /// By which part.
    pub(super) matte: bool,
}

/// (2): chooses between the parts and absorption.
pub(super) fn scatter(
    bsdf: &Bsdf,
    parts: &Parts,
    wo: Vec3,
    power: Spectrum,
    mode: Mode,
    sampler: &mut Sampler,
) -> Option<Scattered> {
    let u = sampler.get_vertex();
    let draw = |lobes| bsdf.sample(wo, u[5], Vec2::new(u[2], u[3]), mode, lobes);
    let total = sum(power);
    // The same choice of a model for both: it has one of the parts more often than both.
    let outcome = |sample: Option<BsdfSample>| {
        let after = sample.map_or(Spectrum::ZERO, |s| power * s.weight);
        (sample, after, sum(after) / total)
    };
    let drawn = |lobes: Lobes| match lobes.is_empty() {
        true => None,
        false => draw(lobes),
    };
    let (matte, sharp) = (outcome(drawn(parts.matte)), outcome(drawn(parts.sharp)));
    // Weights above 1 leave nothing to absorb, and power grows.
    let all = (matte.2 + sharp.2).max(1.0);
    let at = u[6] * all;
    let (is_matte, (sample, after, p)) = match at < matte.2 {
        true => (true, matte),
        false if at < matte.2 + sharp.2 => (false, sharp),
        false => return None,
    };
    Some(Scattered { sample: sample?, power: after * (all / p), matte: is_matte })
}

/// Over the channels.
#[inline]
pub(super) fn sum(s: Spectrum) -> f32 {
    s.0[0] + s.0[1] + s.0[2] + s.0[3]
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::Frame;
    use kaustika_sampling::{SamplerConfig, SamplerKind};
    use kaustika_scene::bsdf::{Conductor, ConductorFresnel, Diffuse, Microfacet, Model, Part};
    use kaustika_scene::description::Distribution;

    #[test]
    fn power_stays_and_outcomes_are_as_frequent_as_reflectances() {
        // Matte by 0.7, a mirror by 0.3, both coloured.
        let (matte, shine) = ([0.6, 0.3, 0.1, 0.0], [0.9, 0.5, 0.2, 0.0]);
        let part = |weight, model| Part {
            frame: Frame::from_normal(Vec3::Z),
            guard: None,
            relief: 0.0,
            weight,
            model,
        };
        let mut bsdf = Bsdf::default();
        bsdf.reset(Vec3::Z);
        bsdf.push(part(0.7, Model::Diffuse(Diffuse { reflectance: Spectrum(matte) })));
        let mirror = Conductor {
            fresnel: ConductorFresnel::Mirror,
            tint: Spectrum(shine),
            surface: Microfacet::new(Distribution::Ggx, 0.0, 0.0),
        };
        bsdf.push(part(0.3, Model::Conductor(mirror)));
        let parts = parts(&bsdf, 0.4);
        let config =
            SamplerConfig { kind: SamplerKind::Independent, seed: 1, spp: 1, resolution: [1; 2] };
        let plan = SamplerPlan::new(config);
        let power = Spectrum([1.0, 2.0, 0.5, 0.0]);
        let n = 100_000;
        let (mut counts, mut colours) = ([0.0; 2], [Spectrum::ZERO; 2]);
        for i in 0..n {
            let mut sampler = plan.start([0, 0], i);
            let wo = Vec3::new(0.6, 0.0, 0.8);
            let on = scatter(&bsdf, &parts, wo, power, Mode::Importance, &mut sampler);
            let Some(on) = on else { continue };
            assert!((sum(on.power) - sum(power)).abs() < 1e-5);
            counts[usize::from(on.matte)] += 1.0;
            colours[usize::from(on.matte)] += on.power / n as f32;
        }
        for (i, (albedo, share)) in [(shine, 0.3), (matte, 0.7)].into_iter().enumerate() {
            let expected = power * Spectrum(albedo) * share;
            let p = sum(expected) / sum(power);
            // Five standard deviations of a count.
            let deviation = 5.0 * (p * (1.0 - p) / n as f32).sqrt();
            assert!((counts[i] / n as f32 - p).abs() < deviation, "{i}: {} {p}", counts[i]);
            let error = (colours[i] - expected).map(f32::abs).max_component();
            assert!(error < deviation * sum(power), "{i}: {:?} {expected:?}", colours[i]);
        }
    }
}
