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
use super::walk::{Previous, Walk};
use crate::features::describe;
use crate::frame::Frame;
use crate::method::PassStats;
use crate::roulette::{Roulette, WalkState};
use kaustika_film::accumulate::PixelRecord;
use kaustika_math::{Ray, Vec2, Vec3};
use kaustika_sampling::{MisHeuristic, Sampler};
use kaustika_scene::bsdf::{Bsdf, Lobes, Mode};
use kaustika_scene::lanes::Lamps;
use kaustika_scene::{CameraRay, Escaped, Hit, LightId, LightSelection, Scene, Segment, Surface};
use kaustika_spectra::{Spectrum, Wavelengths};

/// Passages through interfaces a path may make before it is given up.
pub(super) const MAX_PASSAGES: u32 = 1000;

/// Estimates radiance along camera rays of one picture.
#[derive(Debug)]
pub struct Integrator<'a> {
    scene: &'a Scene,
    frame: &'a Frame,
    pub(super) lights: &'a LightSelection,
    /// All lights, if they are a few lamps and chosen as the scene does by itself.
    pub(super) lamps: Option<&'a Lamps>,
    pub(super) max_depth: u32,
    pub(super) only_depth: Option<u32>,
    pub(super) roulette: Roulette,
    pub(super) mis: MisHeuristic,
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

/// A ray to a point of a light, and what the point adds to the path if nothing is in the way.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightRay {
    pub(super) segment: Segment,
    pub(super) radiance: Spectrum,
    /// True if the light is infinitely far.
    pub(super) far: bool,
}

/// What a path found at one of its vertices.
pub(super) struct Vertex {
    /// The light's term of (1), if it is not seen yet to be nothing.
    pub(super) light: Option<LightRay>,
    /// False if the path ends here.
    pub(super) goes_on: bool,
}

impl Vertex {
    const END: Vertex = Vertex { light: None, goes_on: false };
}

impl<'a> Integrator<'a> {
    /// For one scene and picture.
    pub fn new(scene: &'a Scene, frame: &'a Frame, params: &PathParams) -> Integrator<'a> {
        Integrator {
            scene,
            frame,
            lights: &scene.light_selection,
            lamps: scene.lamps.as_ref(),
            max_depth: params.max_bounces(),
            only_depth: u32::try_from(params.only_depth).ok(),
            roulette: params.roulette(),
            mis: params.mis,
            hide_emitters: params.hide_emitters,
        }
    }

    /// Chooses lights otherwise than the scene does by itself.
    pub fn with_lights(self, lights: &'a LightSelection) -> Integrator<'a> {
        let lamps = self.lamps.filter(|_| std::ptr::eq(lights, &self.scene.light_selection));
        Integrator { lights, lamps, ..self }
    }

    /// What is rendered.
    pub(super) fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// Into what.
    pub(super) fn frame(&self) -> &'a Frame {
        self.frame
    }

    /// One sample of one pixel, without features.
    pub fn pixel(&self, pixel: [u32; 2], index: u64, stats: &mut PassStats) -> PixelRecord {
        let (mut walk, mut sampler) = self.start(pixel, index);
        self.finish(&mut walk, &mut sampler, &mut Bsdf::default(), None, stats);
        let rgb = self.frame.rgb(walk.radiance, &walk.lambda, stats);
        PixelRecord { rgb, weight: walk.film_weight, ..PixelRecord::default() }
    }

    /// Radiance along a camera ray.
    pub fn li(
        &self,
        camera: &CameraRay,
        lambda: Wavelengths,
        mut sampler: Sampler<'a>,
        stats: &mut PassStats,
    ) -> PathSample {
        let mut walk = self.begin(camera, lambda);
        self.finish(&mut walk, &mut sampler, &mut Bsdf::default(), None, stats);
        PathSample { radiance: walk.radiance, lambda: walk.lambda }
    }

    /// Takes one path to its end. `record` gets the features of the first surface.
    pub(super) fn finish(
        &self,
        walk: &mut Walk,
        sampler: &mut Sampler<'a>,
        bsdf: &mut Bsdf<'a>,
        mut record: Option<&mut PixelRecord>,
        stats: &mut PassStats,
    ) {
        if self.scene.has_media() {
            return self.finish_in_media(walk, sampler, bsdf, record, stats);
        }
        loop {
            let hit = self.scene.hit(&walk.segment.ray, walk.segment.t_max);
            let vertex =
                self.vertex(walk, sampler, hit.as_ref(), bsdf, record.as_deref_mut(), stats);
            if let Some(light) = vertex.light
                && !self.scene.occluded(&light.segment)
            {
                walk.radiance += light.radiance;
            }
            if !vertex.goes_on {
                break;
            }
        }
    }

    /// Takes a path on from what its ray met to its next ray. `bsdf` is room to work in;
    /// `record` gets the features of the first surface.
    #[inline(always)]
    pub(super) fn vertex(
        &self,
        walk: &mut Walk,
        sampler: &mut Sampler<'a>,
        hit: Option<&Hit>,
        bsdf: &mut Bsdf<'a>,
        record: Option<&mut PixelRecord>,
        stats: &mut PassStats,
    ) -> Vertex {
        let scene = self.scene;
        let ray = walk.segment.ray;
        let wo = -ray.d;
        stats.closest_rays += 1;

        // Add what it emits toward the path: the BSDF's term of (1).
        let shown = self.shows(walk.depth);
        let Some(hit) = hit else {
            walk.radiance += self.outside(walk);
            return Vertex::END;
        };
        let mut surface = scene.geometry.surface(hit, &ray);
        if let (true, Some(id)) = (shown, surface.light) {
            walk.radiance +=
                walk.beta * self.emitted(id, &surface, &ray, &walk.previous, &walk.lambda);
        }
        walk.footprint += walk.spread * surface.t;
        surface.footprint = walk.footprint;

        // What is there?
        if !scene.bsdf_into(&surface, wo, &mut walk.lambda, bsdf) {
            walk.passages += 1;
            walk.segment = Segment { ray: surface.spawn(ray.d), t_max: f32::INFINITY };
            return Vertex { light: None, goes_on: walk.passages <= MAX_PASSAGES };
        }
        if let (Some(record), 0) = (record, walk.depth) {
            describe(scene, &surface, bsdf, wo, &walk.lambda, record);
        }
        if walk.depth >= self.max_depth {
            return Vertex::END;
        }

        // Every vertex draws as many numbers, so that those of one kind stay together.
        let u = sampler.get_vertex();
        let (u2_light, u2) = (Vec2::new(u[0], u[1]), Vec2::new(u[2], u[3]));
        let [u_light, uc, u_survive] = [u[4], u[5], u[6]];

        // Sample a light: its term of (1).
        let mut light = None;
        if self.counts(walk.depth + 1) && bsdf.lobes().has(Lobes::SMOOTH) {
            light =
                self.direct(&surface, bsdf, wo, (u_light, u2_light), &walk.lambda, |_, pdf_b| {
                    pdf_b
                });
            if let Some(l) = &mut light {
                l.radiance *= walk.beta;
                stats.shadow_rays += 1;
            }
        }

        // Sample the BSDF for the next direction.
        let end = Vertex { light, goes_on: false };
        let Some(s) = bsdf.sample(wo, uc, u2, Mode::Radiance, Lobes::ALL) else { return end };
        walk.beta *= s.weight; // (2)
        walk.eta_scale *= s.eta * s.eta;
        walk.depth += 1;
        if walk.beta.is_black() {
            return end;
        }
        let delta = s.lobe.has(Lobes::DELTA);
        if !s.lobe.has(Lobes::NULL) {
            let n = surface.facing(wo);
            walk.previous = Previous { p: surface.p, n, pdf_w: s.pdf, delta };
        } else {
            // Nothing was there: the light could not be sampled through it either.
            walk.previous.delta = true;
        }
        walk.segment = Segment { ray: surface.spawn(s.wi), t_max: f32::INFINITY };

        // Russian roulette.
        let (beta, eta_scale, depth) = (walk.beta, walk.eta_scale, walk.depth);
        let q = self.roulette.q(&WalkState { beta, eta_scale, weight: s.weight, depth });
        if q < 1.0 {
            if u_survive >= q {
                return end;
            }
            walk.beta /= q; // (4)
        }
        Vertex { light, goes_on: true }
    }

    /// What a path finds whose ray met nothing: the BSDF's term of (1).
    #[inline]
    pub(super) fn outside(&self, walk: &Walk) -> Spectrum {
        if !self.shows(walk.depth) {
            return Spectrum::ZERO;
        }
        walk.beta * self.escaped(&walk.segment.ray, &walk.previous, &walk.lambda)
    }

    /// True if the light that a path of this many bounces meets is wanted.
    #[inline]
    pub(super) fn shows(&self, depth: u32) -> bool {
        self.counts(depth) && !(depth == 0 && self.hide_emitters)
    }

    /// True if paths of this many bounces are wanted.
    #[inline]
    pub(super) fn counts(&self, depth: u32) -> bool {
        depth <= self.max_depth && self.only_depth.is_none_or(|d| d == depth)
    }

    /// w_b of a light that was met.
    #[inline]
    fn weight(&self, previous: &Previous, pmf: impl FnOnce() -> f32, pdf_li: f32) -> f32 {
        if previous.delta {
            return 1.0;
        }
        self.mis.bsdf(pmf() * pdf_li, previous.pdf_w) // (3)
    }

    /// w_b Lₑ of the light that the ray met.
    #[inline(never)]
    pub(super) fn emitted(
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
        let pmf = || self.lights.pmf(previous.p, previous.n, id);
        le * self.weight(previous, pmf, pdf_li)
    }

    /// w_b Lₑ of what surrounds the scene.
    #[inline(never)]
    pub(super) fn escaped(&self, ray: &Ray, previous: &Previous, lambda: &Wavelengths) -> Spectrum {
        self.scene.environments.iter().fold(Spectrum::ZERO, |sum, &id| {
            let light = self.scene.light(id);
            let Escaped { le, pdf_li, region } = light.escaped(previous.p, ray.d, lambda);
            let pmf = || self.lights.pmf_escaped(previous.p, previous.n, id, region);
            sum + le * self.weight(previous, pmf, pdf_li)
        })
    }

    /// The light's term of (1) at a surface, without β and V; `None` if it is zero. `density` is
    /// that of the direction of the light, given the BSDF's.
    #[inline]
    pub(super) fn direct(
        &self,
        surface: &Surface,
        bsdf: &Bsdf,
        wo: Vec3,
        (u, u2): (f32, Vec2),
        lambda: &Wavelengths,
        density: impl Fn(Vec3, f32) -> f32,
    ) -> Option<LightRay> {
        let scene = self.scene;
        let choice = self.lights.sample(surface.p, surface.facing(wo), u, u2)?;
        let (light, p) = (scene.light(choice.light), choice.p);
        if !light.is_delta() && !self.mis.samples_lights() {
            return None;
        }
        // By reference: what was written in pieces is slow to be moved at once.
        let sample = light.sample_li_in(scene, surface.p, choice.region, choice.u, lambda);
        let l = sample.as_ref()?;
        let (f, (pdf_b, _)) = bsdf.eval_pdf(wo, l.wi, Mode::Radiance, Lobes::ALL);
        if f.is_black() || l.le.is_black() {
            return None;
        }
        let w = if l.delta { 1.0 } else { self.mis.light(p * l.pdf_w, density(l.wi, pdf_b)) }; // (3)
        let segment = scene.shadow_ray(surface, l);
        let radiance = f * l.le * (w / (p * l.pdf_w));
        (w > 0.0).then(|| LightRay { segment, radiance, far: light.is_infinite() })
    }
}
