//! The cache is filled before the picture is taken.
//!
//! Pixels are looked through from coarse to fine; where no record is near enough, one is made.
//! Records are made in batches of fixed size, each from the cache as the last one left it: any
//! number of threads fills the same cache, and what is rendered finds no borders between what was
//! known early and late.

use super::super::eye::{Eye, Room};
use super::cache::Cache;
use super::record::{Record, strata};
use crate::method::{PassStats, RenderError};
use crate::workers::Workers;
use kaustika_math::{Frame, Vec2, Vec3};
use kaustika_scene::Surface;
use kaustika_scene::bsdf::Bsdf;
use kaustika_spectra::Spectrum;
use rayon::prelude::*;

/// Pixels between those of the first round; each round halves it.
const FIRST_STEP: u32 = 16;
/// Records that are made at the same time.
const BATCH: usize = 64;
/// Radii of records, in pixels (Křivánek & Gautron 2009).
const PIXELS: [f32; 2] = [3.0, 150.0];

/// A place that is seen.
struct Seen {
    pixel: [u32; 2],
    surface: Surface,
    wo: Vec3,
    n: Vec3,
    /// Width of a pixel there.
    width: f32,
}

impl<'a> Eye<'a> {
    /// The cache for what the pixels show in pass `index`, with the allowed error `error`.
    pub(in super::super) fn overture(
        &self,
        index: u64,
        error: f32,
        workers: &Workers,
        stats: &mut PassStats,
    ) -> Result<Cache, RenderError> {
        let mut cache = Cache::new(self.scene.center, self.scene.radius, error);
        let [x0, y0, x1, y1] = self.frame.region;
        let mut step = FIRST_STEP;
        while step > 0 {
            let round = |x: &u32, y: &u32| {
                step == FIRST_STEP || !(x.is_multiple_of(2 * step) && y.is_multiple_of(2 * step))
            };
            let on_grid =
                |from: u32, to: u32| (from.next_multiple_of(step)..to).step_by(step as usize);
            let pixels: Vec<[u32; 2]> = on_grid(y0, y1)
                .flat_map(|y| on_grid(x0, x1).map(move |x| [x, y]))
                .filter(|[x, y]| round(x, y))
                .collect();
            stats.closest_rays += pixels.len() as u64;
            let seen: Vec<Seen> = workers.install(|| {
                pixels.par_iter().filter_map(|&pixel| self.seen(pixel, index)).collect()
            });
            let mut left = seen.iter();
            loop {
                let unknown =
                    left.by_ref().filter(|s| cache.irradiance(s.surface.p, s.n).is_none());
                let batch: Vec<&Seen> = unknown.take(BATCH).collect();
                if batch.is_empty() {
                    break;
                }
                if workers.cancelled() {
                    return Err(RenderError::Cancelled);
                }
                let make = |room: &mut Room<'a>, seen: &&Seen| self.record(seen, index, room);
                let made: Vec<(Record, PassStats)> =
                    workers.install(|| batch.par_iter().map_init(Room::default, make).collect());
                for (record, s) in made {
                    cache.insert(record);
                    *stats += s;
                }
            }
            step /= 2;
        }
        Ok(cache)
    }

    /// What a pixel shows, if that is a place for a record.
    fn seen(&self, pixel: [u32; 2], index: u64) -> Option<Seen> {
        let mut sampler = self.frame.sampler.start(pixel, index);
        let u = sampler.get_vertex();
        let film = self.frame.film_sample(pixel, Vec2::new(u[0], u[1])).film;
        let camera = self.scene.camera.sample_we(film, Vec2::new(u[2], u[3]), self.time);
        let surface = self.scene.intersect(&camera.ray, camera.t_max)?;
        let (wo, mut bsdf, mut lambda) = (-camera.ray.d, Bsdf::default(), self.lambda);
        if !self.scene.bsdf_into(&surface, wo, &mut lambda, &mut bsdf) {
            return None;
        }
        let (_, n) = self.place(&surface, &bsdf, wo, &lambda).matte()?;
        let width = camera.width + camera.spread * surface.t;
        Some(Seen { pixel, surface, wo, n, width })
    }

    fn record(&self, seen: &Seen, index: u64, room: &mut Room<'a>) -> (Record, PassStats) {
        let mut sampler = self.frame.sampler.start(seen.pixel, index);
        let mut sampler = sampler.fork(0x0063_6163_6865);
        let mut stats = PassStats::default();
        let (surface, outside) = (&seen.surface, seen.surface.facing(seen.wo));
        let numbers: Vec<[f32; 2]> = {
            let [m, n] = strata(self.params.cache_rays);
            (0..m * n).map(|_| sampler.get_2d()).map(|u| [u.x, u.y]).collect()
        };
        let mut numbers = numbers.into_iter();
        let frame = Frame::from_normal(seen.n);
        let trace = |wi: Vec3| {
            if outside.dot(wi) <= 0.0 {
                return (Spectrum::ZERO, f32::INFINITY);
            }
            let ray = surface.spawn(wi);
            let (one, nothing) = (Spectrum::ONE, Spectrum::ZERO);
            let (lambda, sampler, stats) = (&self.lambda, &mut sampler, &mut stats);
            let g = self.gathered(ray, lambda, one, nothing, 1, sampler, room, stats);
            (g.radiance, g.distance)
        };
        let random = || numbers.next().unwrap_or([0.5; 2]);
        let mut record =
            Record::new(surface.p, &frame, strata(self.params.cache_rays), random, trace);
        // Meters have no pixels: there only the scene's size bounds.
        let width = if seen.width > 0.0 { seen.width } else { 1e-3 * self.scene.radius };
        record.bound(PIXELS.map(|pixels| pixels * width));
        (record, stats)
    }
}
