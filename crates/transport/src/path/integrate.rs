//! The estimator of one camera path.
//!
//! ```text
//! L ≈ Σₖ βₖ [ w_b Lₑ(xₖ→xₖ₋₁)  +  w_l f(ωₒ,ω_l)|cos θ_l| Lₑ(y→xₖ) V / (p p_l) ]     (1)
//! βₖ₊₁ = βₖ f(ωₒ,ω_b)|cos θ_b| / p_b                                                (2)
//! w_l = h(p p_l, p_b),  w_b = 1 - w_l                                               (3)
//! β ← β / q  with survival probability q                                            (4)
//! ```
//!
//! p is the probability of the light, p_l and p_b are densities per solid angle at the vertex
//! that chose the direction. A weight is 1 where the other technique cannot sample: camera
//! rays, Dirac lobes, delta lights.

use super::params::PathParams;
use crate::frame::Frame;
use crate::method::PassStats;
use crate::roulette::{Roulette, WalkState};
use kaustika_film::accumulate::PixelRecord;
use kaustika_math::{Ray, Vec2, Vec3};
use kaustika_sampling::{MisHeuristic, Sampler};
use kaustika_scene::bsdf::{Bsdf, Lobes, Mode};
use kaustika_scene::{CameraRay, LightId, Scene, Surface};
use kaustika_spectra::{ColorMode, Spectrum, Wavelengths};

/// Passages through interfaces a path may make before it is given up.
const MAX_PASSAGES: u32 = 1000;

/// Estimates radiance along camera rays of one picture.
#[derive(Debug)]
pub struct Integrator<'a> {
    scene: &'a Scene,
    frame: &'a Frame,
    max_depth: u32,
    only_depth: Option<u32>,
    roulette: Roulette,
    mis: MisHeuristic,
    hide_emitters: bool,
}

/// What one path found.
#[derive(Clone, Copy, Debug)]
pub struct PathSample {
    /// Radiance estimate at the path's wavelengths.
    pub radiance: Spectrum,
    /// The wavelengths, the secondary ones ended if the path was dispersed.
    pub lambda: Wavelengths,
}

/// The previous vertex, as the next emitter hit needs it for its weight.
struct Previous {
    p: Vec3,
    n: Vec3,
    /// Density per solid angle of the direction taken.
    pdf_w: f32,
    /// True if only BSDF sampling could have taken it.
    delta: bool,
}

impl<'a> Integrator<'a> {
    /// For one scene and picture.
    pub fn new(scene: &'a Scene, frame: &'a Frame, params: &PathParams) -> Integrator<'a> {
        let max_depth = u32::try_from(params.max_depth).unwrap_or(u32::MAX);
        let only_depth = u32::try_from(params.only_depth).ok();
        Integrator {
            scene,
            frame,
            // Nothing longer than the one length that is wanted.
            max_depth: only_depth.map_or(max_depth, |only| only.min(max_depth)),
            only_depth,
            roulette: params.roulette(),
            mis: params.mis,
            hide_emitters: params.hide_emitters,
        }
    }

    /// One sample of one pixel.
    pub fn pixel(
        &self,
        pixel: [u32; 2],
        index: u64,
        features: bool,
        stats: &mut PassStats,
    ) -> PixelRecord {
        let mut sampler = self.frame.sampler.start(pixel, index);
        let film = self.frame.film_sample(pixel, &mut sampler);
        let lens = sampler.get_2d();
        let time = sampler.get_1d();
        let u_lambda = sampler.get_1d();
        let lambda = match self.scene.mode {
            ColorMode::Rgb => Wavelengths::rgb(),
            ColorMode::Spectral => Wavelengths::sample(u_lambda),
        };
        let ray = self.scene.camera.sample_we(film.film, lens, time);
        let mut record = PixelRecord { weight: film.weight, ..PixelRecord::default() };
        let wanted = features.then_some(&mut record);
        let sample = self.li(&ray, lambda, &mut sampler, wanted, stats);
        let rgb = self.frame.sensor.rgb(sample.radiance, &sample.lambda);
        if rgb.iter().all(|v| v.is_finite()) {
            record.rgb = self.frame.clamp(rgb);
        } else {
            stats.bad_samples += 1;
        }
        record
    }

    /// Radiance along a camera ray; fills `record` with the features of the first surface.
    pub fn li(
        &self,
        camera: &CameraRay,
        mut lambda: Wavelengths,
        sampler: &mut Sampler,
        mut record: Option<&mut PixelRecord>,
        stats: &mut PassStats,
    ) -> PathSample {
        let scene = self.scene;
        let mut ray = camera.ray;
        let mut t_max = camera.t_max;
        let mut radiance = Spectrum::ZERO;
        let mut beta = Spectrum::ONE;
        let mut eta_scale = 1.0;
        let mut depth = 0;
        let mut passages = 0;
        let mut footprint = camera.width * scene.footprint_scale;
        let mut bsdf = Bsdf::default();
        let mut previous = Previous { p: ray.o, n: Vec3::ZERO, pdf_w: 1.0, delta: true };

        loop {
            // Find the next path vertex.
            stats.closest_rays += 1;
            let hit = scene.hit(&ray, t_max);
            t_max = f32::INFINITY;
            let wo = -ray.d;

            // Add what it emits toward the path: the BSDF's term of (1).
            let shown = self.counts(depth) && !(depth == 0 && self.hide_emitters);
            let Some(hit) = &hit else {
                if shown {
                    radiance += beta * self.escaped(&ray, &previous, &lambda);
                }
                break;
            };
            let mut surface = scene.geometry.surface(hit, &ray);
            if let (true, Some(id)) = (shown, surface.light) {
                radiance += beta * self.emitted(id, &surface, &ray, &previous, &lambda);
            }
            footprint += camera.spread * scene.footprint_scale * surface.t;
            surface.footprint = footprint;

            // What is there?
            if !scene.bsdf_into(&surface, wo, &mut lambda, &mut bsdf) {
                passages += 1;
                if passages > MAX_PASSAGES {
                    break;
                }
                ray = surface.spawn(ray.d);
                continue;
            }
            if let Some(record) = record.take() {
                describe(scene, &surface, &bsdf, wo, &lambda, record);
            }
            if depth >= self.max_depth {
                break;
            }

            // Every vertex draws as many numbers, so that those of one kind stay together.
            let u = sampler.get_vertex();
            let (u2_light, u2) = (Vec2::new(u[0], u[1]), Vec2::new(u[2], u[3]));
            let [u_light, uc, u_survive] = [u[4], u[5], u[6]];

            // Sample a light: its term of (1).
            if self.counts(depth + 1) && bsdf.lobes().has(Lobes::SMOOTH) {
                let direct = self.direct(&surface, &bsdf, wo, u_light, u2_light, &lambda, stats);
                radiance += beta * direct;
            }

            // Sample the BSDF for the next direction.
            let Some(s) = bsdf.sample(wo, uc, u2, Mode::Radiance, Lobes::ALL) else { break };
            beta *= s.weight; // (2)
            eta_scale *= s.eta * s.eta;
            depth += 1;
            if beta.is_black() {
                break;
            }
            let delta = s.lobe.has(Lobes::DELTA);
            if !s.lobe.has(Lobes::NULL) {
                previous = Previous { p: surface.p, n: surface.ng, pdf_w: s.pdf, delta };
            } else {
                // Nothing was there: the light could not be sampled through it either.
                previous.delta = true;
            }
            ray = surface.spawn(s.wi);

            // Russian roulette.
            let state = WalkState { beta, eta_scale, weight: s.weight, depth };
            let q = self.roulette.q(&state);
            if q < 1.0 {
                if u_survive >= q {
                    break;
                }
                beta /= q; // (4)
            }
        }
        PathSample { radiance, lambda }
    }

    /// True if paths of this many bounces are wanted.
    #[inline]
    fn counts(&self, depth: u32) -> bool {
        depth <= self.max_depth && self.only_depth.is_none_or(|d| d == depth)
    }

    /// w_b of a light that was met.
    #[inline]
    fn weight(&self, previous: &Previous, light: LightId, pdf_li: f32) -> f32 {
        if previous.delta {
            return 1.0;
        }
        let p = self.scene.light_selection.pmf(previous.p, previous.n, light);
        self.mis.bsdf(p * pdf_li, previous.pdf_w) // (3)
    }

    /// w_b Lₑ of the light that the ray met.
    #[inline(never)]
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
        le * self.weight(previous, id, pdf_li)
    }

    /// w_b Lₑ of what surrounds the scene.
    #[inline(never)]
    fn escaped(&self, ray: &Ray, previous: &Previous, lambda: &Wavelengths) -> Spectrum {
        self.scene.environments.iter().fold(Spectrum::ZERO, |sum, &id| {
            let light = self.scene.light(id);
            let le = light.le_escaped(ray.d, lambda);
            sum + le * self.weight(previous, id, light.pdf_li_escaped(ray.d))
        })
    }

    /// The light's term of (1) at a surface.
    #[inline]
    fn direct(
        &self,
        surface: &Surface,
        bsdf: &Bsdf,
        wo: Vec3,
        u: f32,
        u2: Vec2,
        lambda: &Wavelengths,
        stats: &mut PassStats,
    ) -> Spectrum {
        let scene = self.scene;
        let selection = &scene.light_selection;
        let Some((id, p, u2)) = selection.sample(surface.p, surface.ng, u, u2) else {
            return Spectrum::ZERO;
        };
        let light = scene.light(id);
        if !light.is_delta() && !self.mis.samples_lights() {
            return Spectrum::ZERO;
        }
        // By reference: what was written in pieces is slow to be moved at once.
        let sample = light.sample_li(scene, surface.p, u2, lambda);
        let Some(l) = &sample else { return Spectrum::ZERO };
        let (f, (pdf_b, _)) = bsdf.eval_pdf(wo, l.wi, Mode::Radiance, Lobes::ALL);
        if f.is_black() || l.le.is_black() {
            return Spectrum::ZERO;
        }
        let w = if l.delta { 1.0 } else { self.mis.light(p * l.pdf_w, pdf_b) }; // (3)
        if w == 0.0 {
            return Spectrum::ZERO;
        }
        stats.shadow_rays += 1;
        if !scene.unoccluded(surface, l) {
            return Spectrum::ZERO;
        }
        f * l.le * (w / (p * l.pdf_w))
    }
}

/// Features of the first surface.
fn describe(
    scene: &Scene,
    s: &Surface,
    bsdf: &Bsdf,
    wo: Vec3,
    lambda: &Wavelengths,
    record: &mut PixelRecord,
) {
    record.albedo = match s.light {
        Some(_) => [1.0; 3],
        None => kaustika_spectra::Sensor::default()
            .rgb(bsdf.albedo(wo), lambda)
            .map(|v| v.clamp(0.0, 1.0)),
    };
    record.normal = s.ng.into();
    record.shading_normal = bsdf.shading_normal().into();
    record.depth = s.t;
    record.position = s.p.into();
    record.uv = [s.uv.x, s.uv.y];
    record.shape = s.shape + 1;
    record.material = scene.material_of(s).0 + 1;
}
