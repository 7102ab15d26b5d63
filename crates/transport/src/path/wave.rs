//! The paths of a band, side by side or one after the other.
//!
//! Side by side, all paths trace their next ray, then each shades what it met, then all trace
//! their shadow rays: rays that are traced as a batch do not wait for memory one after the other.
//! Where the whole scene is in the cache there is nothing to wait for, and a path that stays in
//! registers from ray to ray is faster. Paths do not know of each other, so the choice changes
//! nothing but time.

use super::integrate::Integrator;
use super::walk::Walk;
use crate::method::PassStats;
use kaustika_film::accumulate::{PixelBand, PixelRecord};
use kaustika_scene::bsdf::Bsdf;
use kaustika_scene::{RayBatch, Segment};
use kaustika_spectra::Spectrum;

/// Paths of a wave: enough rays for a batch, few enough for the cache.
const PATHS: usize = 512;

/// Buffers, reused from wave to wave.
#[derive(Default)]
pub(super) struct Wave<'a> {
    side_by_side: bool,
    walks: Vec<Walk<'a>>,
    records: Vec<PixelRecord>,
    /// The paths that go on.
    alive: Vec<u32>,
    rays: Vec<Segment>,
    batch: RayBatch,
    shadow_rays: Vec<Segment>,
    /// Whose the shadow rays are, and what they carry.
    lit: Vec<(u32, Spectrum)>,
    bsdf: Bsdf<'a>,
}

impl<'a> Wave<'a> {
    /// Side by side, or one after the other.
    pub(super) fn new(side_by_side: bool) -> Wave<'a> {
        Wave { side_by_side, ..Wave::default() }
    }

    /// One sample of every pixel of a band.
    pub(super) fn trace(
        &mut self,
        integrator: &Integrator<'a>,
        index: u64,
        band: &mut PixelBand,
    ) -> PassStats {
        let mut stats = PassStats::default();
        let (width, pixels) = (band.width(), band.width() * band.height());
        let region = integrator.frame().region;
        for first in (0..pixels).step_by(PATHS) {
            let end = pixels.min(first + PATHS as u32);
            self.walks.clear();
            self.walks.extend((first..end).map(|i| {
                let pixel = [region[0] + i % width, region[1] + band.y + i / width];
                integrator.start(pixel, index)
            }));
            self.records.clear();
            if band.wants_features() {
                self.records.resize(self.walks.len(), PixelRecord::default());
            }
            if self.side_by_side {
                self.finish_together(integrator, &mut stats);
            } else {
                for (i, walk) in self.walks.iter_mut().enumerate() {
                    let record = self.records.get_mut(i);
                    integrator.finish(walk, &mut self.bsdf, record, &mut stats);
                }
            }
            for (i, walk) in (first..end).zip(&self.walks) {
                let rgb = integrator.rgb(walk, &mut stats);
                let features = self.records.get((i - first) as usize);
                let record = PixelRecord {
                    rgb,
                    weight: walk.film_weight,
                    ..features.copied().unwrap_or_default()
                };
                band.add(i % width, i / width, &record);
            }
        }
        stats
    }

    /// Takes all paths to their ends.
    fn finish_together(&mut self, integrator: &Integrator<'a>, stats: &mut PassStats) {
        let scene = integrator.scene();
        self.alive.clear();
        self.alive.extend(0..self.walks.len() as u32);
        while !self.alive.is_empty() {
            self.rays.clear();
            self.rays.extend(self.alive.iter().map(|&i| self.walks[i as usize].segment));
            scene.hit_all(&self.rays, &mut self.batch);

            self.shadow_rays.clear();
            self.lit.clear();
            let mut hits = self.batch.hits.iter();
            self.alive.retain(|&i| {
                let walk = &mut self.walks[i as usize];
                let hit = hits.next().and_then(Option::as_ref);
                let record = self.records.get_mut(i as usize);
                let vertex = integrator.vertex(walk, hit, &mut self.bsdf, record, stats);
                if let Some(light) = vertex.light {
                    self.shadow_rays.push(light.segment);
                    self.lit.push((i, light.radiance));
                }
                vertex.goes_on
            });

            scene.occluded_all(&self.shadow_rays, &mut self.batch);
            for (&(i, radiance), &occluded) in self.lit.iter().zip(&self.batch.occluded) {
                if !occluded {
                    self.walks[i as usize].radiance += radiance;
                }
            }
        }
    }
}
