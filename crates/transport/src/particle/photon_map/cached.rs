//! Light that matte surfaces send each other as a light field, for methods whose paths end in one: irradiance
//! caching over the photons of a pass (Ward, Rubinstein & Clear 1988).
//!
//! ```text
//! ∫f_D L_{i,d} = (ρ/π) E(x) from the cache, where it knows E; by gathering, where it does not    (13)
//! ```
//!
//! L_{i,d} is light of the paths L(D|S)*D S*, as in (6); D are the diffuse lobes and S all others, however rough.

use super::eye::{Eye, Room};
use super::field::NEVER;
use super::{Maps, PhotonMapParams, PhotonMapper};
use crate::frame::Frame;
use crate::method::{Method, PassStats, RenderError};
use crate::workers::Workers;
use kaustika_math::Vec3;
use kaustika_sampling::Sampler;
use kaustika_scene::bsdf::Bsdf;
use kaustika_scene::{Scene, Surface};
use kaustika_spectra::{Spectrum, Wavelengths};

/// Makes the cache of each pass.
#[derive(Debug)]
pub struct Caching {
    mapper: PhotonMapper,
    /// Of the last pass.
    maps: Option<Maps>,
}

/// The cache of a pass, and the photons that are gathered where it knows nothing.
#[derive(Clone, Copy)]
pub struct CachedField<'a>(Eye<'a>);

/// Room to gather in.
#[derive(Default)]
pub struct GatherRoom<'a>(Room<'a>);

impl Caching {
    /// Of a scene; `params.cache` is the allowed error, above 0.
    ///
    /// # Errors
    /// If cancelled.
    pub fn new(
        params: PhotonMapParams,
        scene: &Scene,
        frame: &Frame,
        workers: &Workers,
    ) -> Result<Caching, RenderError> {
        let params = PhotonMapParams { matte: NEVER, gather: 1, renew: 1, ..params };
        let mut mapper = PhotonMapper::new(params);
        mapper.prepare(scene, frame, workers)?;
        Ok(Caching { mapper, maps: None })
    }

    /// The cache of pass `index`, for what its pixels show.
    ///
    /// # Errors
    /// If cancelled.
    pub fn field<'a>(
        &'a mut self,
        index: u64,
        (scene, frame): (&'a Scene, &'a Frame),
        workers: &Workers,
        stats: &mut PassStats,
    ) -> Result<CachedField<'a>, RenderError> {
        let mapper = &self.mapper;
        let mut maps = mapper.trace(index, scene, frame, workers, stats)?;
        let error = mapper.params.cache * mapper.params.shrink(index);
        let eye = mapper.eye(index, scene, frame, &maps);
        maps.cache = Some(eye.overture(index, error, workers, stats)?);
        let maps = self.maps.insert(maps);
        Ok(CachedField(mapper.eye(index, scene, frame, maps)))
    }
}

impl<'a> CachedField<'a> {
    /// (13): radiance that the diffuse lobes send along `wo`.
    #[expect(clippy::too_many_arguments)]
    pub fn radiance(
        &self,
        surface: &Surface,
        bsdf: &Bsdf<'a>,
        wo: Vec3,
        lambda: &Wavelengths,
        sampler: &mut Sampler,
        room: &mut GatherRoom<'a>,
        stats: &mut PassStats,
    ) -> Spectrum {
        let at = self.0.place(surface, bsdf, wo, lambda);
        let gathered = || self.0.multiple(&at, 0, sampler, &mut room.0, stats);
        self.0.cached(&at, 0).unwrap_or_else(gathered)
    }

    /// The part of the shutter's interval that has passed.
    pub fn time(&self) -> f32 {
        self.0.time
    }
}
