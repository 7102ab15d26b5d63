//! Walks from the camera that end in a light field at their N-th diffuse surface.
//!
//! ```text
//! I ≈ Σ β ∫ f_D(ωₒ,ωᵢ) L_P(x_N,ωᵢ) |cos θᵢ| dωᵢ   over all x_N of the walk                (1)
//! β ← β f_c |cos| / (p_c P_c),   c = D or W, P_c in proportion to what they send on       (2)
//! ```
//!
//! Before its N-th diffuse surface a walk goes on by the diffuse part of a surface or by what W is of
//! the rest, one of the two by chance (2); at the N-th by W alone, so that it may find another one
//! behind a coat or in a mirror. Light that it meets on its way is none of its classes.

use super::fields::{LightField, PatchField, Plan};
use crate::features::describe;
use crate::frame::Frame;
use crate::method::{PassStats, RenderError};
use crate::nearest::Nearest;
use crate::particle::photon_map::cached::GatherRoom;
use crate::path_space::MAX_PASSAGES;
use crate::roulette::{Roulette, Survival, WalkState};
use crate::workers::Workers;
use kaustika_film::accumulate::{PassImage, PixelRecord};
use kaustika_math::{Frame as Axes, Vec2, Vec3, warp};
use kaustika_scene::bsdf::{Bsdf, BsdfSample, Lobes, Mode};
use kaustika_scene::{Scene, Surface};
use kaustika_spectra::{Spectrum, Wavelengths};

/// Samples of a chunk.
const CHUNK: u32 = 2048;
/// How walks end before they have found all of their surfaces.
const ROULETTE: Roulette = Roulette { survival: Survival::Throughput, rr_depth: 3, threshold: 0.4 };

/// Walks through a scene to a field.
pub(super) struct Walk<'a> {
    pub(super) scene: &'a Scene,
    pub(super) frame: &'a Frame,
    pub(super) plan: &'a Plan,
    pub(super) light: &'a LightField<'a>,
}

/// Room for one walk.
#[derive(Default)]
struct Room<'a> {
    bsdf: Bsdf<'a>,
    found: Nearest,
    gather: GatherRoom<'a>,
}

impl<'a> Walk<'a> {
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
    fn sample(
        &self,
        pixel: [u32; 2],
        index: u64,
        features: bool,
        room: &mut Room<'a>,
        stats: &mut PassStats,
    ) -> PixelRecord {
        let (scene, frame, plan) = (self.scene, self.frame, self.plan);
        let mut sampler = frame.sampler.start(pixel, index);
        let u = sampler.get_vertex();
        let film = frame.film_sample(pixel, Vec2::new(u[0], u[1]));
        let time = match self.light {
            LightField::Photons(photons) => photons.time,
            LightField::Cache(cache) => cache.time(),
            LightField::Patches(_) => u[4],
        };
        let camera = scene.camera.sample_we(film.film, Vec2::new(u[2], u[3]), time);
        let (mut ray, mut t_max) = (camera.ray, camera.t_max);
        let mut footprint = camera.width * scene.footprint_scale;
        let spread = camera.spread * scene.footprint_scale;
        let mut lambda = Wavelengths::rgb();
        let (mut beta, mut radiance) = (Spectrum::ONE, Spectrum::ZERO);
        let (mut depth, mut eta_scale, mut passages) = (0, 1.0, 0);
        // Diffuse surfaces before this one.
        let mut diffuse = 0;
        let mut record = PixelRecord { weight: film.weight, ..PixelRecord::default() };
        let Room { bsdf, found, gather } = room;
        loop {
            stats.closest_rays += 1;
            let Some(mut s) = scene.intersect(&ray, t_max) else { break };
            footprint += spread * s.t;
            s.footprint = footprint;
            let wo = -ray.d;
            if !scene.bsdf_into(&s, wo, &mut lambda, bsdf) {
                passages += 1;
                if passages > MAX_PASSAGES {
                    break;
                }
                (ray, t_max) = (s.spawn(ray.d), f32::INFINITY);
                continue;
            }
            if features && depth == 0 {
                describe(scene, &s, bsdf, wo, &lambda, &mut record);
            }
            let u = sampler.get_vertex();
            let is_last = diffuse + 1 == plan.at;
            if is_last && bsdf.lobes().has(Lobes::DIFFUSE) {
                let received = match self.light {
                    LightField::Photons(photons) => photons.radiance(&s, bsdf, wo, &lambda, found),
                    LightField::Cache(cache) => {
                        cache.radiance(&s, bsdf, wo, &lambda, &mut sampler, gather, stats)
                    }
                    LightField::Patches(patches) => {
                        self.received(patches, &s, bsdf, wo, Vec2::new(u[0], u[1]))
                    }
                };
                radiance += beta * received; // (1)
            }
            // (2)
            let draw = |lobes: Lobes| match bsdf.lobes().has(lobes) {
                true => bsdf.sample(wo, u[5], Vec2::new(u[2], u[3]), Mode::Radiance, lobes),
                false => None,
            };
            let onward = draw(plan.walked);
            let scattered = if is_last { None } else { draw(Lobes::DIFFUSE) };
            let Some((sample, p)) = choose(onward, scattered, u[7]) else { break };
            beta *= sample.weight / p;
            eta_scale *= sample.eta * sample.eta;
            depth += 1;
            diffuse += usize::from(sample.lobe.has(Lobes::DIFFUSE));
            let q = ROULETTE.q(&WalkState { beta, eta_scale, weight: sample.weight, depth });
            if u[6] >= q || beta.is_black() {
                break;
            }
            beta /= q;
            (ray, t_max) = (s.spawn(sample.wi), f32::INFINITY);
        }
        record.rgb = frame.rgb(radiance * camera.weight, &lambda, stats);
        record
    }

    /// The integral of (1), of patches.
    fn received(
        &self,
        patches: &PatchField,
        s: &Surface,
        bsdf: &Bsdf,
        wo: Vec3,
        u: Vec2,
    ) -> Spectrum {
        let h = patches.irradiance(self.scene, s, wo, &self.plan.pasts);
        if h.is_black() {
            return h;
        }
        // H is even over directions: f_D of one by its cosine, the same for all of Lambert's.
        let up = Axes::from_normal(bsdf.shading_normal().face_forward(s.facing(wo)));
        let wi = up.to_world(warp::cosine_hemisphere(u));
        let f = bsdf.eval(wo, wi, Mode::Radiance, Lobes::DIFFUSE_REFLECTION);
        f * h / up.n.abs_dot(wi).max(1e-4)
    }
}

/// One of two ways on, and its probability.
fn choose(a: Option<BsdfSample>, b: Option<BsdfSample>, u: f32) -> Option<(BsdfSample, f32)> {
    let (Some(one), Some(other)) = (a, b) else { return a.or(b).map(|sample| (sample, 1.0)) };
    let size = |s: &BsdfSample| s.weight.max_component();
    let all = size(&one) + size(&other);
    let p = size(&one) / all;
    (all > 0.0).then_some(if u < p { (one, p) } else { (other, 1.0 - p) })
}
