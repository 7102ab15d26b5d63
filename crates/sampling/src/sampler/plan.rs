//! What all samples of a render share.

use super::halton::{Halton, HaltonTables};
use super::independent::Independent;
use super::pmj02::{Pmj02, Pmj02Tables};
use super::sobol::Sobol;
use super::stratified::{Strata, Stratified};
use super::zsobol::{Curve, ZSobol};
use super::{Sampler, SamplerKind, Source};
use crate::hash::combine;

/// What is to be sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SamplerConfig {
    /// Which point set.
    pub kind: SamplerKind,
    /// Different seeds give independent renders.
    pub seed: u64,
    /// Planned samples per pixel (0 counts as 1). A run may stop earlier or exceed it: all kinds
    /// stay unbiased and sound, but `Stratified`, `ZSobol` and `Pmj02` start a fresh,
    /// independent set when the planned one is used up.
    pub spp: u64,
    /// Width and height of the image; pixels outside are allowed. Only `ZSobol` reads it.
    pub resolution: [u32; 2],
}

/// The tables and keys of a render's sampler, built once and shared between threads.
#[derive(Clone, Debug)]
pub struct SamplerPlan {
    config: SamplerConfig,
    key: u64,
    tables: Tables,
}

#[derive(Clone, Debug)]
enum Tables {
    None,
    Stratified(Strata),
    Halton(HaltonTables),
    ZSobol(Curve),
    Pmj02(Pmj02Tables),
}

impl SamplerPlan {
    /// Builds the tables that `config` asks for (at most about 2 MB, a few milliseconds).
    pub fn new(config: SamplerConfig) -> Self {
        let key = combine(config.seed, config.kind as u64);
        let spp = config.spp.max(1);
        let tables = match config.kind {
            SamplerKind::Independent | SamplerKind::Sobol => Tables::None,
            SamplerKind::Stratified => Tables::Stratified(Strata::new(spp)),
            SamplerKind::Halton => Tables::Halton(HaltonTables::new(key)),
            SamplerKind::ZSobol => Tables::ZSobol(Curve::new(config.resolution, spp)),
            SamplerKind::Pmj02 => Tables::Pmj02(Pmj02Tables::new(spp, key)),
        };
        SamplerPlan { config, key, tables }
    }

    /// The configuration it was built from.
    pub fn config(&self) -> SamplerConfig {
        self.config
    }

    /// The numbers of sample `index` (the pass) of `pixel`. Cheap: no allocation, a few hashes.
    #[inline]
    pub fn start(&self, pixel: [u32; 2], index: u64) -> Sampler<'_> {
        let pixel_key = combine(self.key, u64::from(pixel[0]) << 32 | u64::from(pixel[1]));
        let source = match &self.tables {
            Tables::None if self.config.kind == SamplerKind::Independent => {
                Source::Independent(Independent::new(pixel_key, index))
            }
            Tables::None => Source::Sobol(Sobol::new(pixel_key, index)),
            Tables::Stratified(t) => Source::Stratified(Stratified::new(t, pixel_key, index)),
            Tables::Halton(t) => Source::Halton(Halton::new(t, pixel_key, index)),
            Tables::ZSobol(c) => Source::ZSobol(ZSobol::new(c, self.key, pixel, index)),
            Tables::Pmj02(t) => Source::Pmj02(Pmj02::new(t, pixel_key, index)),
        };
        Sampler { dimension: 0, source }
    }
}
