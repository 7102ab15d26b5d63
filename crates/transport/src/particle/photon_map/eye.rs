//! Paths from the eye (Jensen 1996; 2001, ch. 9).
//!
//! ```text
//! Lₒ = Lₑ + ∫f L_{i,l} + ∫f_S (L_{i,c} + L_{i,d}) + ∫f_D L_{i,c} + ∫f_D L_{i,d}          (6)
//! ```
//!
//! direct light by a shadow ray, weighted against the sharp part's own rays; what the sharp part
//! f_S sees by following a ray; caustics on the matte part f_D from their map; all else by final
//! gathering, or from the irradiance cache. Where a path carries little, matte surfaces are read
//! from the global map, which holds all three terms of theirs at once.

use super::Maps;
use super::estimate::{Estimate, Place, Reading, read_at};
use super::lobes::parts;
use super::params::PhotonMapParams;
use crate::features::describe;
use crate::frame::Frame;
use crate::method::{PassStats, RenderError};
use crate::nearest::Nearest;
use crate::roulette::{Roulette, WalkState};
use crate::workers::Workers;
use kaustika_film::accumulate::{PassImage, PixelRecord};
use kaustika_math::{Ray, Vec2, Vec3};
use kaustika_sampling::MisHeuristic;
use kaustika_sampling::sampler::VERTEX_NUMBERS;
use kaustika_scene::bsdf::{Bsdf, Lobes, Mode};
use kaustika_scene::{Escaped, LightId, LightSelection, Scene, Surface};
use kaustika_spectra::{ColorMode, Spectrum, Wavelengths};

/// Samples of a chunk.
const CHUNK: u32 = 1024;
/// Passages through interfaces before a path is given up.
const MAX_PASSAGES: u32 = 1000;

/// Estimates pixels from frozen maps.
#[derive(Clone, Copy)]
pub(super) struct Eye<'a> {
    pub(super) scene: &'a Scene,
    pub(super) frame: &'a Frame,
    pub(super) params: &'a PhotonMapParams,
    pub(super) lights: &'a LightSelection,
    pub(super) maps: &'a Maps,
    /// How the maps are read.
    pub(super) global: Reading,
    pub(super) caustics: Reading,
    pub(super) lambda: Wavelengths,
    pub(super) time: f32,
    pub(super) roulette: Roulette,
    pub(super) max_depth: u32,
    pub(super) only_depth: Option<u32>,
    /// I of every pixel, for those who learn what photons are worth; else empty.
    pub(super) measurements: &'a [f32],
}

/// Room for one path.
#[derive(Default)]
pub(super) struct Room<'a> {
    pub(super) found: Nearest,
    /// Of what is seen.
    pub(super) bsdf: Bsdf<'a>,
    /// Of what a gather meets.
    pub(super) behind: Bsdf<'a>,
}

/// Where a ray came from, for the weight of the light it may meet.
struct Previous {
    p: Vec3,
    n: Vec3,
    pdf_w: f32,
    delta: bool,
}

impl<'a> Eye<'a> {
    /// A sample of every pixel.
    pub(super) fn look(
        &self,
        index: u64,
        out: &mut PassImage,
        workers: &Workers,
    ) -> Result<PassStats, RenderError> {
        self.frame.sample_pixels(
            out,
            workers,
            CHUNK,
            Room::default,
            |room, pixel, features, stats| self.sample(pixel, index, features, room, stats),
        )
    }

    /// One sample of one pixel.
    pub(super) fn sample(
        &self,
        pixel: [u32; 2],
        index: u64,
        features: bool,
        room: &mut Room<'a>,
        stats: &mut PassStats,
    ) -> PixelRecord {
        let (scene, frame) = (self.scene, self.frame);
        let mut sampler = frame.sampler.start(pixel, index);
        let u = sampler.get_vertex();
        let film = frame.film_sample(pixel, Vec2::new(u[0], u[1]));
        let camera = scene.camera.sample_we(film.film, Vec2::new(u[2], u[3]), self.time);
        let (mut ray, mut t_max) = (camera.ray, camera.t_max);
        let mut footprint = camera.width * scene.footprint_scale;
        let spread = camera.spread * scene.footprint_scale;
        let mut lambda = self.lambda;
        let mut beta = Spectrum::splat(camera.weight);
        let (mut depth, mut eta_scale, mut passages) = (0, 1.0, 0);
        let mut previous = Previous { p: ray.o, n: Vec3::ZERO, pdf_w: 0.0, delta: true };
        let mut radiance = Spectrum::ZERO;
        let mut record = PixelRecord::default();
        let mut bsdf = std::mem::take(&mut room.bsdf);
        let share = self.share(pixel);
        loop {
            // Lₑ of (6).
            let shown = self.counts(depth) && !(depth == 0 && self.params.hide_emitters);
            stats.closest_rays += 1;
            let Some(mut surface) = scene.intersect(&ray, t_max) else {
                if shown {
                    let l = beta * self.escaped(&ray, &previous, &lambda);
                    radiance += read_at(l, &lambda, &self.lambda);
                }
                break;
            };
            if let (true, Some(id)) = (shown, surface.light) {
                let l = beta * self.emitted(id, &surface, &ray, &previous, &lambda);
                radiance += read_at(l, &lambda, &self.lambda);
            }
            footprint += spread * surface.t;
            surface.footprint = footprint;
            let wo = -ray.d;
            if !scene.bsdf_into(&surface, wo, &mut lambda, &mut bsdf) {
                passages += 1;
                (ray, t_max) = (surface.spawn(ray.d), f32::INFINITY);
                if passages > MAX_PASSAGES {
                    break;
                }
                continue;
            }
            if features && depth == 0 {
                describe(scene, &surface, &bsdf, wo, &lambda, &mut record);
            }
            if depth >= self.max_depth {
                break;
            }

            // The other terms of (6) that end here.
            let u = sampler.get_vertex();
            let parts = parts(&bsdf, self.params.matte);
            let at = Place { worth: beta * share, ..self.place(&surface, &bsdf, wo, &lambda) };
            let accurate = beta.max_component() * eta_scale >= self.params.weak;
            let mut here = match (parts.matte.is_empty(), accurate && self.params.gather > 0) {
                (true, _) => self.direct(&at, parts.sharp, depth, &u, stats),
                (false, true) => {
                    self.direct(&at, parts.sharp, depth, &u, stats)
                        + self.caustic(&at, depth, &mut room.found)
                }
                (false, false) => {
                    let sharp = Place { lobes: Lobes::NONE, ..at };
                    self.direct(&sharp, parts.sharp, depth, &u, stats)
                        + self.global_map(&at, depth, &mut room.found).radiance
                }
            };
            if accurate && self.params.gather > 0 && !parts.matte.is_empty() {
                here += match self.cached(&at, depth) {
                    Some(l) => l,
                    None => self.multiple(&at, depth, &mut sampler, room, stats),
                };
            }
            radiance += read_at(beta * here, &lambda, &self.lambda);

            // What the sharp part sees.
            if parts.sharp.is_empty() {
                break;
            }
            let (uc, u2) = (u[5], Vec2::new(u[2], u[3]));
            let Some(s) = bsdf.sample(wo, uc, u2, Mode::Radiance, parts.sharp) else { break };
            beta *= s.weight;
            eta_scale *= s.eta * s.eta;
            depth += 1;
            let state = WalkState { beta, eta_scale, weight: s.weight, depth };
            let q = self.roulette.q(&state);
            if u[6] >= q || beta.is_black() {
                break;
            }
            beta /= q;
            let delta = s.lobe.has(Lobes::DELTA);
            match s.lobe.has(Lobes::NULL) {
                true => previous.delta = true,
                false => {
                    let n = surface.facing(wo);
                    previous = Previous { p: surface.p, n, pdf_w: s.pdf, delta };
                }
            }
            (ray, t_max) = (surface.spawn(s.wi), f32::INFINITY);
        }
        room.bsdf = bsdf;
        let rgb = frame.rgb(radiance, &self.lambda, stats);
        PixelRecord { rgb, weight: film.weight, ..record }
    }

    /// One over I of a pixel, and over the lanes; 0 if nobody learns.
    fn share(&self, [x, y]: [u32; 2]) -> f32 {
        let [x0, y0, x1, _] = self.frame.region;
        let lanes = match self.scene.mode {
            ColorMode::Rgb => 3.0,
            ColorMode::Spectral => 4.0,
        };
        let of_pixel = self.measurements.get(((y - y0) * (x1 - x0) + x - x0) as usize);
        of_pixel.map_or(0.0, |i| 1.0 / (lanes * i))
    }

    /// True if paths of this many bounces are wanted.
    pub(super) fn counts(&self, depth: u32) -> bool {
        depth <= self.max_depth && self.only_depth.is_none_or(|d| d == depth)
    }

    /// The matte part of a surface.
    pub(super) fn place<'s, 'b>(
        &self,
        surface: &'s Surface,
        bsdf: &'s Bsdf<'b>,
        wo: Vec3,
        lambda: &'s Wavelengths,
    ) -> Place<'s, 'b> {
        let lobes = parts(bsdf, self.params.matte).matte;
        Place { surface, bsdf, wo, lobes, lambda, worth: Spectrum::ZERO }
    }

    /// The multiple diffuse term from the irradiance cache, if that knows it.
    pub(super) fn cached(&self, at: &Place, depth: u32) -> Option<Spectrum> {
        let cache = self.maps.cache.as_ref()?;
        // Records count bounces from what is seen directly.
        if depth > 0 && (self.max_depth < u32::MAX || self.only_depth.is_some()) {
            return None;
        }
        let (f, n) = at.matte()?;
        Some(f * cache.irradiance(at.surface.p, n)?)
    }

    /// The matte part as the global map has it.
    pub(super) fn global_map(&self, at: &Place, depth: u32, found: &mut Nearest) -> Estimate {
        self.global.radiance(&self.maps.global, at, |d| self.counts(depth + d), found)
    }

    /// The caustics on the matte part.
    pub(super) fn caustic(&self, at: &Place, depth: u32, found: &mut Nearest) -> Spectrum {
        if self.maps.caustics.is_empty() {
            return Spectrum::ZERO;
        }
        let counts = |d| self.counts(depth + d);
        self.caustics.radiance(&self.maps.caustics, at, counts, found).radiance
    }

    /// The direct term of the place's lobes and of `sharp`, whose own rays may meet the light too.
    pub(super) fn direct(
        &self,
        at: &Place,
        sharp: Lobes,
        depth: u32,
        u: &[f32; VERTEX_NUMBERS],
        stats: &mut PassStats,
    ) -> Spectrum {
        if !self.counts(depth + 1) || !(at.lobes | sharp).has(Lobes::SMOOTH) {
            return Spectrum::ZERO;
        }
        self.sampled_light(at, sharp, u, stats).unwrap_or(Spectrum::ZERO)
    }

    fn sampled_light(
        &self,
        at: &Place,
        sharp: Lobes,
        u: &[f32; VERTEX_NUMBERS],
        stats: &mut PassStats,
    ) -> Option<Spectrum> {
        let (scene, s, bsdf) = (self.scene, at.surface, at.bsdf);
        let choice = self.lights.sample(s.p, s.facing(at.wo), u[4], Vec2::new(u[0], u[1]))?;
        let light = scene.light(choice.light);
        let l = light.sample_li_in(scene, s.p, choice.region, choice.u, at.lambda)?;
        let mut f = match at.lobes.has(Lobes::SMOOTH) {
            true => bsdf.eval(at.wo, l.wi, Mode::Radiance, at.lobes),
            false => Spectrum::ZERO,
        };
        if sharp.has(Lobes::SMOOTH) {
            let (glossy, (pdf, _)) = bsdf.eval_pdf(at.wo, l.wi, Mode::Radiance, sharp);
            let mis = MisHeuristic::default();
            f += glossy * if l.delta { 1.0 } else { mis.light(choice.p * l.pdf_w, pdf) };
        }
        if f.is_black() || l.le.is_black() {
            return None;
        }
        stats.shadow_rays += 1;
        let open = !scene.occluded(&scene.shadow_ray(s, &l));
        open.then(|| f * l.le / (choice.p * l.pdf_w))
    }

    /// Weight of a light that was met.
    fn weight(&self, previous: &Previous, pmf: impl FnOnce() -> f32, pdf_li: f32) -> f32 {
        match previous.delta {
            true => 1.0,
            false => MisHeuristic::default().bsdf(pmf() * pdf_li, previous.pdf_w),
        }
    }

    /// Weighted Lₑ of the light that the ray met.
    fn emitted(
        &self,
        id: LightId,
        s: &Surface,
        ray: &Ray,
        previous: &Previous,
        lambda: &Wavelengths,
    ) -> Spectrum {
        let light = self.scene.light(id);
        let le = light.le(self.scene, s, -ray.d, lambda);
        if le.is_black() {
            return le;
        }
        let pdf_li = light.pdf_li(self.scene, previous.p, s, ray.d);
        le * self.weight(previous, || self.lights.pmf(previous.p, previous.n, id), pdf_li)
    }

    /// Weighted Lₑ of what surrounds the scene.
    fn escaped(&self, ray: &Ray, previous: &Previous, lambda: &Wavelengths) -> Spectrum {
        self.scene.environments.iter().fold(Spectrum::ZERO, |sum, &id| {
            let Escaped { le, pdf_li, region } =
                self.scene.light(id).escaped(previous.p, ray.d, lambda);
            let pmf = || self.lights.pmf_escaped(previous.p, previous.n, id, region);
            sum + le * self.weight(previous, pmf, pdf_li)
        })
    }
}
