//! The estimator of one camera path through participating media: [`super::integrate`] with events
//! between surfaces. Only scenes that have media come here.
//!
//! ```text
//! w_b = h(⟨ℓ⟩ p p_l, p_b),   w_l = 1 - w_b                                         (5)
//! homogeneous, beside a lamp: p(t) = (1 - α) σₜ T(t) + α (1 - T(end)) p_lamp(t)      (6)
//! ```
//!
//! (1) to (4), the distances and how the lanes of a spectrum share them, are those of
//! [`crate::extinction`]. ℓ is the density with which light sampling would have made the way since
//! the last vertex: shadow rays never scatter, so they pass homogeneous media with certainty and
//! others by ratio tracking, q = σ̄ T̄ a collision (Novák et al. 2014). A vertex sets ℓ = s.
//!
//! Of the paths that scatter in a homogeneous medium a share α does so where a lamp's light is
//! strong ([`equiangular`]); how many scatter stays as (2) has it, so that ℓ need not know.
//!
//! What goes straight through a surface (a boundary between media, a cut-out, a thin pane) is no
//! bounce, and shadow rays pass it too, as in Mitsuba's `volpath`. pbrt's panes stop shadow rays.

mod equiangular;
mod found;
mod shadow;
mod tracking;

use self::tracking::Travel;
use super::integrate::{Integrator, MAX_PASSAGES};
use super::walk::{Previous, Walk};
use crate::extinction::{Shares, Stream};
use crate::features::{describe, describe_matter};
use crate::method::PassStats;
use crate::roulette::WalkState;
use kaustika_film::accumulate::PixelRecord;
use kaustika_math::{Ray, Vec2, Vec3};
use kaustika_sampling::Sampler;
use kaustika_scene::bsdf::{Bsdf, BsdfSample, Lobes, Mode};
use kaustika_scene::description::{MediumId, SourceFormat};
use kaustika_scene::{Hit, Segment, Surface};
use kaustika_spectra::Spectrum;

/// What a path through media keeps besides its [`Walk`].
struct Flight<'a> {
    /// s and ℓ.
    shares: Shares,
    /// What lane 0 has found, had it been alone from the start.
    alone: f32,
    /// Where it is.
    medium: Option<MediumId>,
    /// The number that the next distance is drawn with.
    u_distance: f32,
    /// Numbers for null collisions, of which nobody knows how many there will be.
    stream: Stream,
    /// True if thin panes let light straight through.
    panes: bool,
    /// Room to work in, for surfaces that shadow rays pass.
    passed: Bsdf<'a>,
}

/// A point in a medium where light scatters.
struct Scattering {
    medium: MediumId,
    /// Along the ray.
    t: f32,
    /// σₛ/σₜ.
    albedo: Spectrum,
}

impl<'a> Integrator<'a> {
    /// [`Integrator::finish`] where there are media.
    pub(super) fn finish_in_media(
        &self,
        walk: &mut Walk,
        sampler: &mut Sampler<'a>,
        bsdf: &mut Bsdf<'a>,
        mut record: Option<&mut PixelRecord>,
        stats: &mut PassStats,
    ) {
        let scene = self.scene();
        let u = sampler.get_vertex();
        let mut flight = Flight {
            shares: Shares::new(&walk.lambda, u[0]),
            alone: 0.0,
            medium: scene.camera_medium,
            u_distance: u[7],
            stream: Stream::new(&u[1..7]),
            panes: scene.format != SourceFormat::Pbrt,
            passed: Bsdf::default(),
        };
        loop {
            let hit = scene.hit(&walk.segment.ray, walk.segment.t_max);
            stats.closest_rays += 1;
            let end = hit.as_ref().map_or(f32::INFINITY, |h| h.t);
            let record = record.as_deref_mut();
            let goes_on = match self.travel(walk, &mut flight, end) {
                Travel::Ended => false,
                Travel::Scattered(s) => self.scatter(walk, &mut flight, &s, sampler, record, stats),
                Travel::Passed => match &hit {
                    None => {
                        if self.shows(walk.depth) {
                            let previous = flight.seen_from(&walk.previous);
                            let ray = &walk.segment.ray;
                            let le = walk.beta * self.escaped(ray, &previous, &walk.lambda);
                            flight.add(walk, le);
                        }
                        false
                    }
                    Some(hit) => self.meet(walk, &mut flight, hit, sampler, bsdf, record, stats),
                },
            };
            if !goes_on {
                break;
            }
        }
        flight.settle(walk);
    }

    /// Takes a path on from a surface; false if it ends.
    #[expect(clippy::too_many_arguments)]
    fn meet(
        &self,
        walk: &mut Walk,
        flight: &mut Flight<'a>,
        hit: &Hit,
        sampler: &mut Sampler<'a>,
        bsdf: &mut Bsdf<'a>,
        record: Option<&mut PixelRecord>,
        stats: &mut PassStats,
    ) -> bool {
        let scene = self.scene();
        let ray = walk.segment.ray;
        let wo = -ray.d;
        let mut surface = scene.geometry.surface(hit, &ray);
        if let (true, Some(id)) = (self.shows(walk.depth), surface.light) {
            let previous = flight.seen_from(&walk.previous);
            let le = walk.beta * self.emitted(id, &surface, &ray, &previous, &walk.lambda);
            flight.add(walk, le);
        }
        walk.footprint += walk.spread * surface.t;
        surface.footprint = walk.footprint;
        if !scene.bsdf_into(&surface, wo, &mut walk.lambda, bsdf) {
            return pass(self, walk, flight, &surface);
        }
        flight.follow(walk);
        if let (Some(record), 0) = (record, walk.depth) {
            describe(scene, &surface, bsdf, wo, &walk.lambda, record);
        }
        let straight = bsdf.straight(wo, flight.panes);
        let last = walk.depth >= self.max_depth;
        if last && straight.1 <= 0.0 {
            return false;
        }

        let u = sampler.get_vertex();
        let (u2_light, u2) = (Vec2::new(u[0], u[1]), Vec2::new(u[2], u[3]));
        let [u_light, uc, u_survive] = [u[4], u[5], u[6]];
        flight.u_distance = u[7];
        if self.counts(walk.depth + 1) && bsdf.lobes().has(Lobes::SMOOTH) {
            let n = surface.facing(wo);
            let f = |wi| {
                let (f, (pdf, _)) = bsdf.eval_pdf(wo, wi, Mode::Radiance, Lobes::ALL);
                (f, pdf)
            };
            let ray = |l: &_| scene.shadow_ray(&surface, l);
            let enter = |d, medium| scene.medium_beyond(&surface, d, medium);
            self.light_up(walk, flight, (surface.p, n), (u_light, u2_light), f, ray, enter, stats);
        }

        let Some(s) = bsdf.sample(wo, uc, u2, Mode::Radiance, Lobes::ALL) else { return false };
        if goes_straight(&s, wo, flight.panes) && straight.1 > 0.0 {
            let (value, p) = straight;
            walk.beta *= value / p;
            flight.pass_with(p);
            return pass(self, walk, flight, &surface);
        }
        walk.beta *= s.weight;
        walk.eta_scale *= s.eta * s.eta;
        if last || walk.beta.is_black() {
            return false;
        }
        walk.depth += 1;
        let delta = s.lobe.has(Lobes::DELTA);
        let n = surface.facing(wo);
        walk.previous = Previous { p: surface.p, n, pdf_w: s.pdf, delta };
        flight.shares.turn();
        flight.medium = scene.medium_beyond(&surface, s.wi, flight.medium);
        walk.segment = Segment { ray: surface.spawn(s.wi), t_max: f32::INFINITY };
        self.survives(walk, s.weight, u_survive)
    }

    /// Takes a path on from a point in a medium; false if it ends.
    fn scatter(
        &self,
        walk: &mut Walk,
        flight: &mut Flight<'a>,
        at: &Scattering,
        sampler: &mut Sampler<'a>,
        record: Option<&mut PixelRecord>,
        stats: &mut PassStats,
    ) -> bool {
        let scene = self.scene();
        let ray = walk.segment.ray;
        let (p, wo) = (ray.at(at.t), -ray.d);
        let phase = &scene.medium(at.medium).phase;
        walk.footprint += walk.spread * at.t;
        if let (Some(record), 0) = (record, walk.depth) {
            describe_matter(at.albedo, &walk.lambda, (p, at.t), record);
        }
        if walk.depth >= self.max_depth {
            return false;
        }
        let u = sampler.get_vertex();
        let (u2_light, u2) = (Vec2::new(u[0], u[1]), Vec2::new(u[2], u[3]));
        flight.u_distance = u[7];
        if self.counts(walk.depth + 1) {
            let f = |wi| {
                let value = phase.eval(p, wo, wi);
                (Spectrum::splat(value), value)
            };
            let shadow = |l: &_| scene.shadow_ray_in_space(p, ray.time, l);
            let stay = |_, medium| medium;
            self.light_up(walk, flight, (p, Vec3::ZERO), (u[4], u2_light), f, shadow, stay, stats);
        }
        let (wi, pdf_w) = phase.sample(p, wo, u2);
        walk.depth += 1;
        walk.previous = Previous { p, n: Vec3::ZERO, pdf_w, delta: false };
        flight.shares.turn();
        walk.segment = Segment { ray: Ray { o: p, d: wi, time: ray.time }, t_max: f32::INFINITY };
        self.survives(walk, at.albedo, u[6])
    }

    /// Russian roulette.
    fn survives(&self, walk: &mut Walk, weight: Spectrum, u: f32) -> bool {
        let (beta, eta_scale, depth) = (walk.beta, walk.eta_scale, walk.depth);
        let q = self.roulette.q(&WalkState { beta, eta_scale, weight, depth });
        if q < 1.0 {
            if u >= q {
                return false;
            }
            walk.beta /= q;
        }
        true
    }
}

/// Goes straight on beyond a surface; false if the path has passed too many.
fn pass(integrator: &Integrator, walk: &mut Walk, flight: &mut Flight, surface: &Surface) -> bool {
    let d = walk.segment.ray.d;
    walk.passages += 1;
    flight.medium = integrator.scene().medium_beyond(surface, d, flight.medium);
    flight.u_distance = flight.stream.draw();
    walk.segment = Segment { ray: surface.spawn(d), t_max: f32::INFINITY };
    walk.passages <= MAX_PASSAGES
}

/// True if a sample is what [`Bsdf::straight`] tells of.
fn goes_straight(s: &BsdfSample, wo: Vec3, panes: bool) -> bool {
    let pane = panes && s.lobe == Lobes::DELTA_TRANSMISSION && s.wi.dot(wo) < -0.99999;
    s.lobe.has(Lobes::NULL) || pane
}
