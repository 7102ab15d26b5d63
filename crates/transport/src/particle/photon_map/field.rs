//! Photons as a light field on matte surfaces, for methods whose paths end in one.
//!
//! ```text
//! L(x,ωₒ) ≈ Σ_p f_D(ω_p, ωₒ) Φ_p w / (c π r²)   over photons of the pasts that are asked for    (7)
//! H(A) = Σ_p Φ_p / A   over those that fell on a patch A                                      (8)
//! ```
//!
//! D are the diffuse lobes and S all others, as layers by path have it, not as rough as a parameter
//! says; so fields of different pasts part the light among them exactly.

use super::emission::Emission;
use super::estimate::{Place, Reading};
use super::photon::{Arrival, Photon, PhotonMap};
use super::tracing::{Keep, Past, Tracer};
use super::{PhotonMapParams, plan, shared};
use crate::frame::Frame;
use crate::method::{PassStats, RenderError};
use crate::nearest::Nearest;
use crate::path_space::Chain;
use crate::workers::Workers;
use kaustika_math::Vec3;
use kaustika_sampling::hash::combine;
use kaustika_scene::bsdf::{Bsdf, Lobes};
use kaustika_scene::{Scene, Surface};
use kaustika_spectra::{Spectrum, Wavelengths};

/// Roughness from which on glossy surfaces are matte: none is.
pub(super) const NEVER: f32 = f32::INFINITY;

/// How photons leave the lights of a scene.
#[derive(Debug)]
pub struct Lamps {
    everywhere: Emission,
    toward_glossy: Emission,
}

/// Which photons are wanted.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'w> {
    /// What they have met.
    pub pasts: &'w [Past],
    /// By what they go on from matte surface to matte surface.
    pub chain: Chain,
    /// How many are sent out.
    pub count: u32,
}

/// A map of the photons of a pass.
#[derive(Debug)]
pub struct PhotonField {
    map: PhotonMap,
    reading: Reading,
    /// The part of the shutter's interval that has passed.
    pub time: f32,
}

impl Lamps {
    /// Of a scene.
    pub fn new(scene: &Scene, frame: &Frame) -> Lamps {
        let seed = combine(frame.sampler.config().seed, 0x616d);
        let toward_glossy = Emission::toward_glossy(scene, NEVER, seed);
        Lamps { everywhere: Emission::new(scene), toward_glossy }
    }

    /// (7): the photons of pass `index`. `params` say how they are read: `nearest` of them within
    /// `radius`, which shrinks from pass to pass.
    ///
    /// # Errors
    /// If cancelled.
    pub fn field(
        &self,
        index: u64,
        (scene, frame): (&Scene, &Frame),
        wanted: &Wanted,
        params: &PhotonMapParams,
        workers: &Workers,
        stats: &mut PassStats,
    ) -> Result<PhotonField, RenderError> {
        let put = |kept: &mut (Vec<Vec3>, Vec<Photon>), s: &Surface, a: &Arrival, past, u: f32| {
            if wanted.pasts.contains(&past) {
                kept.0.push(s.p);
                kept.1.push(Photon::new(a, u));
            }
        };
        let chunks = self.arrivals(index, (scene, frame), wanted, workers, stats, put)?;
        let (mut places, mut photons) = (Vec::new(), Vec::new());
        for (p, q) in chunks {
            places.extend(p);
            photons.extend(q);
        }
        let reading = Reading {
            nearest: params.nearest,
            radius: params.radius * scene.radius,
            shrink: params.shrink(index),
            filter: params.filter,
            checking: params.checking,
        };
        let map = workers.install(|| PhotonMap::new(params.search, &places, &photons));
        Ok(PhotonField { map, reading, time: shared(index, scene, frame).1 })
    }

    /// (8) times A: the power of photons on patches, by the patch's number. `patch` says which one is
    /// at a surface on the side of a direction.
    ///
    /// # Errors
    /// If cancelled.
    pub fn deposited(
        &self,
        (scene, frame): (&Scene, &Frame),
        wanted: &Wanted,
        patch: impl Fn(&Surface, Vec3) -> Option<u32> + Sync,
        workers: &Workers,
        stats: &mut PassStats,
    ) -> Result<Vec<(u32, Spectrum)>, RenderError> {
        let put = |kept: &mut Vec<(u32, Spectrum)>, s: &Surface, a: &Arrival, past, _: f32| {
            // Straight light is asked for by rays, but for what came through an open surface.
            let unseen = past != Past::Straight || a.depth > 1;
            if let (true, true, Some(i)) = (unseen, wanted.pasts.contains(&past), patch(s, a.wi)) {
                kept.push((i, a.power));
            }
        };
        let chunks = self.arrivals(0, (scene, frame), wanted, workers, stats, put)?;
        Ok(chunks.into_iter().flatten().collect())
    }

    fn arrivals<K: Default + Send>(
        &self,
        index: u64,
        (scene, frame): (&Scene, &Frame),
        wanted: &Wanted,
        workers: &Workers,
        stats: &mut PassStats,
        put: impl Fn(&mut K, &Surface, &Arrival, Past, f32) + Sync,
    ) -> Result<Vec<K>, RenderError> {
        let caustics = wanted.pasts.iter().all(|past| *past == Past::Caustic);
        let (emission, keep) = match caustics {
            true => (&self.toward_glossy, Keep::Caustics),
            false => (&self.everywhere, Keep::All),
        };
        let plan = &plan(frame, keep);
        let (lambda, time) = shared(index, scene, frame);
        let Wanted { chain, count, .. } = *wanted;
        let (matte, max_depth) = (NEVER, u32::MAX);
        Tracer { scene, emission, plan, lambda, time, keep, matte, max_depth, chain }.arrivals(
            index * u64::from(count),
            count,
            workers,
            stats,
            put,
        )
    }
}

impl PhotonField {
    /// (7): radiance that the diffuse lobes send along `wo`.
    pub fn radiance(
        &self,
        surface: &Surface,
        bsdf: &Bsdf,
        wo: Vec3,
        lambda: &Wavelengths,
        found: &mut Nearest,
    ) -> Spectrum {
        if self.map.is_empty() {
            return Spectrum::ZERO;
        }
        let lobes = Lobes::DIFFUSE;
        let at = Place { surface, bsdf, wo, lobes, lambda, worth: Spectrum::ZERO };
        self.reading.radiance(&self.map, &at, |_| true, found).radiance
    }
}
