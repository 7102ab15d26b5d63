//! Many paths side by side.
//!
//! All paths of a wave trace their next ray, then each is taken on from what it met, then all
//! trace their shadow rays. Rays that are traced as a batch do not wait for memory one after the
//! other, and sixteen paths that met plain surfaces are taken on at once ([`super::plain`]);
//! others one by one ([`Integrator::vertex`]). A path that ends makes room for the next pixel's,
//! so that the wave stays full. Paths do not know of each other.

use super::integrate::Integrator;
use super::pack::{Pack, lanes_of};
use super::plain::{Onward, PlainHits};
use super::walk::Walk;
use crate::method::PassStats;
use arrayvec::ArrayVec;
use kaustika_film::accumulate::{PixelBand, PixelRecord};
use kaustika_math::lanes::LANES;
use kaustika_math::{Ray, Vec3};
use kaustika_sampling::Sampler;
use kaustika_scene::bsdf::Bsdf;
use kaustika_scene::{Hit, Primitive, RayBatch, Segment};
use kaustika_spectra::{Spectrum, Wavelengths};

/// Paths of a wave: enough rays for a batch, few enough for the cache.
const PATHS: usize = 4096;

/// Whose sample a path is.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// Pixel of the band, row by row.
    pixel: u32,
    /// Weight of the sample on the film.
    film_weight: f32,
}

/// Paths under way, and room to work in.
pub(super) struct Wave<'a> {
    packs: Vec<Pack>,
    segments: Vec<Segment>,
    lambdas: Vec<Wavelengths>,
    samplers: Vec<Sampler<'a>>,
    places: Vec<Place>,
    /// Features of each path's first surface, if they are wanted.
    records: Vec<PixelRecord>,
    batch: RayBatch,
    /// Paths that have ended, in rising order.
    ended: Vec<u32>,
    shadow_rays: Vec<Segment>,
    /// Whose the shadow rays are, and what they carry.
    lit: Vec<(u32, Spectrum)>,
    bsdf: Bsdf<'a>,
    plain: Box<PlainHits<'a>>,
    onward: Box<Onward>,
}

impl<'a> Wave<'a> {
    pub(super) fn new() -> Wave<'a> {
        Wave {
            packs: vec![Pack::default(); PATHS / LANES],
            segments: Vec::with_capacity(PATHS),
            lambdas: Vec::with_capacity(PATHS),
            samplers: Vec::with_capacity(PATHS),
            places: Vec::with_capacity(PATHS),
            records: Vec::new(),
            batch: RayBatch::default(),
            ended: Vec::new(),
            shadow_rays: Vec::new(),
            lit: Vec::new(),
            bsdf: Bsdf::default(),
            plain: Box::default(),
            onward: Box::default(),
        }
    }

    /// One sample of every pixel of a band.
    pub(super) fn trace(
        &mut self,
        integrator: &Integrator<'a>,
        index: u64,
        band: &mut PixelBand,
    ) -> PassStats {
        let mut stats = PassStats::default();
        let mut pixels = 0..band.width() * band.height();
        loop {
            self.fill(integrator, index, band, &mut pixels);
            if self.segments.is_empty() {
                return stats;
            }
            integrator.scene().hit_all(&self.segments, &mut self.batch);
            self.shadow_rays.clear();
            self.lit.clear();
            for first in (0..self.segments.len()).step_by(LANES) {
                self.shade(integrator, first, &mut stats);
            }
            integrator.scene().occluded_all(&self.shadow_rays, &mut self.batch);
            for (&(i, light), &occluded) in self.lit.iter().zip(&self.batch.occluded) {
                if !occluded {
                    self.packs[i as usize / LANES].add(i as usize % LANES, light);
                }
            }
            self.deliver(integrator, band, &mut stats);
        }
    }

    /// Starts paths of the pixels that have none yet, as far as there is room.
    fn fill(
        &mut self,
        integrator: &Integrator<'a>,
        index: u64,
        band: &PixelBand,
        pixels: &mut std::ops::Range<u32>,
    ) {
        let region = integrator.frame().region;
        let mut room = PATHS - self.segments.len();
        while room > 0 && pixels.start < pixels.end {
            let next = pixels.start..pixels.end.min(pixels.start + room.min(LANES) as u32);
            pixels.start = next.end;
            room -= next.len();
            let at = |pixel: u32| {
                [region[0] + pixel % band.width(), region[1] + band.y + pixel / band.width()]
            };
            let places: ArrayVec<[u32; 2], LANES> = next.clone().map(at).collect();
            let mut numbers = next.clone();
            integrator.start_all(&places, index, &mut self.samplers, |walk| {
                let i = self.segments.len();
                self.packs[i / LANES].set(i, walk);
                self.segments.push(walk.segment);
                self.lambdas.push(walk.lambda);
                let pixel = numbers.next().unwrap_or_default();
                self.places.push(Place { pixel, film_weight: walk.film_weight });
            });
            if band.wants_features() {
                self.records.resize(self.segments.len(), PixelRecord::default());
            }
        }
    }

    /// Takes the paths of a pack, which begins with path `first`, on from what their rays met.
    fn shade(&mut self, integrator: &Integrator<'a>, first: usize, stats: &mut PassStats) {
        let count = (self.segments.len() - first).min(LANES);
        let mut alive = 0;
        self.plain.lanes = 0;
        self.plain.glosses.clear();
        for lane in 0..count {
            let i = first + lane;
            let Some(hit) = self.batch.hit(i) else {
                self.escape(integrator, i, stats);
                continue;
            };
            if !self.is_plain(integrator, first, lane, &hit, stats) {
                alive |= u32::from(self.vertex(integrator, i, &hit, stats)) << lane;
            }
        }
        if self.plain.lanes != 0 {
            self.plain_vertices(integrator, first, count, stats);
            alive |= self.onward.alive;
        }
        let ended = (0..count).filter(|lane| alive >> lane & 1 == 0);
        self.ended.extend(ended.map(|lane| (first + lane) as u32));
    }

    /// Ends a path whose ray met nothing.
    #[inline(always)]
    fn escape(&mut self, integrator: &Integrator<'a>, i: usize, stats: &mut PassStats) {
        stats.closest_rays += 1;
        if integrator.scene().environments.is_empty() {
            return;
        }
        let pack = &mut self.packs[i / LANES];
        let walk = pack.get(i, self.segments[i], self.lambdas[i]);
        pack.add(i % LANES, integrator.outside(&walk));
    }

    /// Takes one path on; false if it ends.
    fn vertex(
        &mut self,
        integrator: &Integrator<'a>,
        i: usize,
        hit: &Hit,
        stats: &mut PassStats,
    ) -> bool {
        let pack = &mut self.packs[i / LANES];
        let mut walk = pack.get(i, self.segments[i], self.lambdas[i]);
        let (sampler, record) = (&mut self.samplers[i], self.records.get_mut(i));
        let vertex =
            integrator.vertex(&mut walk, sampler, Some(hit), &mut self.bsdf, record, stats);
        pack.set(i, &walk);
        self.segments[i] = walk.segment;
        self.lambdas[i] = walk.lambda;
        if let Some(light) = vertex.light {
            self.shadow_rays.push(light.segment);
            self.lit.push((i as u32, light.radiance));
        }
        vertex.goes_on
    }

    /// If a path met a plain surface, puts it among [`Wave::plain`] and adds what the
    /// surface emits.
    #[inline(always)]
    fn is_plain(
        &mut self,
        integrator: &Integrator<'a>,
        first: usize,
        lane: usize,
        hit: &Hit,
        stats: &mut PassStats,
    ) -> bool {
        let scene = integrator.scene();
        let store = &scene.geometry.triangles;
        // Computed with the others, if nothing has to be known of it before.
        let mut triangle = None;
        let (shape, emits) = match hit {
            Hit { primitive: Primitive::Triangle(i, b), instance: None, .. } => {
                triangle = Some((*i, *b));
                let mesh = store.mesh(*i);
                (mesh.shape, mesh.first_light.is_some())
            }
            _ => (hit.shape(&scene.geometry), true),
        };
        let Some(plain) = &scene.plains[shape as usize] else { return false };
        let i = first + lane;
        let mut rho = plain.constant.unwrap_or_default();
        if emits || plain.constant.is_none() || !self.records.is_empty() {
            let (pack, bsdf) = (&mut self.packs[first / LANES], &mut self.bsdf);
            let (ray, lambda) = (&self.segments[i].ray, &self.lambdas[i]);
            let record = self.records.get_mut(i);
            let surface;
            (surface, rho) =
                integrator.plain_extras(plain, hit, ray, lambda, pack, lane, bsdf, record);
            if triangle.is_none() {
                self.plain.surfaces.set_surface(lane, &surface);
            }
        }
        if let Some((i, b)) = triangle {
            self.plain.surfaces.set_triangle(lane, store, i, b);
        }
        self.plain.set_material(lane, plain, rho);
        self.plain.lanes |= 1 << lane;
        self.plain.t[lane] = hit.t;
        stats.closest_rays += 1;
        true
    }

    /// Takes on the paths that are among [`Wave::plain`].
    fn plain_vertices(
        &mut self,
        integrator: &Integrator<'a>,
        first: usize,
        count: usize,
        stats: &mut PassStats,
    ) {
        let all = first..first + count;
        Sampler::get_vertices(&mut self.samplers[all.clone()], self.plain.lanes, &mut self.plain.u);
        let (pack, out) = (&mut self.packs[first / LANES], &mut *self.onward);
        integrator.plain_vertices(&self.plain, &self.lambdas[all], pack, out);
        let column = |rows: &[[f32; LANES]; 3], lane: usize| {
            Vec3::new(rows[0][lane], rows[1][lane], rows[2][lane])
        };
        stats.shadow_rays += u64::from(out.lit.count_ones());
        stats.bad_samples += u64::from(out.bad.count_ones());
        for lane in lanes_of(out.lit) {
            let time = self.segments[first + lane].ray.time;
            let (o, d) = (column(&out.shadow_origin, lane), column(&out.shadow_d, lane));
            self.shadow_rays.push(Segment { ray: Ray { o, d, time }, t_max: 1.0 });
            let light = Spectrum(out.light.each_ref().map(|row| row[lane]));
            self.lit.push(((first + lane) as u32, light));
        }
        for lane in lanes_of(out.alive) {
            let segment = &mut self.segments[first + lane];
            let (o, d) = (column(&out.origin, lane), column(&pack.d, lane));
            *segment = Segment { ray: Ray { o, d, ..segment.ray }, t_max: f32::INFINITY };
        }
    }

    /// Gives the film the paths that have ended, and closes their gaps.
    fn deliver(
        &mut self,
        integrator: &Integrator<'a>,
        band: &mut PixelBand,
        stats: &mut PassStats,
    ) {
        // From the last on, so that none moves that is still to be delivered.
        while let Some(i) = self.ended.pop() {
            let i = i as usize;
            let last = self.segments.len() - 1;
            let radiance = self.packs[i / LANES].radiance(i);
            let lambda = self.lambdas.swap_remove(i);
            let place = self.places.swap_remove(i);
            let moved = self.segments[last];
            self.segments.swap_remove(i);
            self.samplers.swap_remove(i);
            let features = match self.records.is_empty() {
                true => PixelRecord::default(),
                false => self.records.swap_remove(i),
            };
            if i < last {
                let walk = self.packs[last / LANES].get(last, moved, lambda);
                self.packs[i / LANES].set(i, &walk);
            }
            let rgb = integrator.frame().rgb(radiance, &lambda, stats);
            let record = PixelRecord { rgb, weight: place.film_weight, ..features };
            let (x, y) = (place.pixel % band.width(), place.pixel / band.width());
            band.add(x, y, &record);
            integrator.frame().add_bands(band, [x, y], place.film_weight, radiance, &lambda);
        }
    }
}

/// The paths of a band one after the other: what [`Wave`] is held against.
pub(super) fn trace_alone(integrator: &Integrator, index: u64, band: &mut PixelBand) -> PassStats {
    let mut stats = PassStats::default();
    let mut bsdf = Bsdf::default();
    let region = integrator.frame().region;
    for pixel in 0..band.width() * band.height() {
        let (x, y) = (pixel % band.width(), pixel / band.width());
        let at = [region[0] + x, region[1] + band.y + y];
        let (mut walk, mut sampler): (Walk, _) = integrator.start(at, index);
        let mut record = PixelRecord::default();
        let features = band.wants_features().then_some(&mut record);
        integrator.finish(&mut walk, &mut sampler, &mut bsdf, features, &mut stats);
        let rgb = integrator.frame().rgb(walk.radiance, &walk.lambda, &mut stats);
        band.add(x, y, &PixelRecord { rgb, weight: walk.film_weight, ..record });
        let frame = integrator.frame();
        frame.add_bands(band, [x, y], walk.film_weight, walk.radiance, &walk.lambda);
    }
    stats
}
