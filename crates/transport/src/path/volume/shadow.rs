//! Light sampling through media: the light's term with transmittance.
//!
//! ```text
//! w_l f(ωₒ,ω_l) Lₑ T / (p p_l),   T by (1) in homogeneous media, else by ratio tracking:
//! T ← T (σ̄ - σₜ)/σ̄ at each collision                     (Novák, Selle & Jarosz 2014)
//! ```

use super::super::integrate::{Integrator, MAX_PASSAGES};
use super::super::walk::Walk;
use super::Flight;
use super::shares::Shares;
use super::tracking::transmittance;
use crate::method::PassStats;
use kaustika_math::{Ray, Vec2, Vec3};
use kaustika_scene::description::MediumId;
use kaustika_scene::medium::Medium;
use kaustika_scene::{LightSample, Segment};
use kaustika_spectra::{Spectrum, Wavelengths};

/// Light on its way from a lamp to the path.
struct Beam {
    /// T.
    t: Spectrum,
    /// Shares of the lanes in its density, ⟨light⟩ = 1, and, as `camera`, the density with which
    /// the path itself could have gone the same way, over the same mean.
    shares: Shares,
}

impl Beam {
    /// An event of density `q`, which the path would have with density `p`.
    fn event(&mut self, f: Spectrum, q: Spectrum, p: Spectrum) {
        let mean = self.shares.mean(self.shares.light * q);
        let k = if mean > 0.0 { 1.0 / mean } else { 0.0 };
        self.t *= f * k;
        self.shares.light *= q * k;
        self.shares.camera *= p * k;
    }
}

/// Below this transmittance a beam survives a collision with probability [`SURVIVAL`].
const FAINT: f32 = 0.05;
const SURVIVAL: f32 = 0.25;

impl<'a> Integrator<'a> {
    /// Adds a light sample at a vertex: `place` and its normal, `f` its value and density for a
    /// direction, `ray` the way to the light, `enter` the medium in which it begins.
    #[expect(clippy::too_many_arguments)]
    pub(super) fn light_up(
        &self,
        walk: &mut Walk,
        flight: &mut Flight<'a>,
        (p, n): (Vec3, Vec3),
        (u, u2): (f32, Vec2),
        f: impl FnOnce(Vec3) -> (Spectrum, f32),
        ray: impl FnOnce(&LightSample) -> Segment,
        enter: impl FnOnce(Vec3, Option<MediumId>) -> Option<MediumId>,
        stats: &mut PassStats,
    ) {
        let scene = self.scene();
        let Some(choice) = self.lights.sample(p, n, u, u2) else { return };
        let light = scene.light(choice.light);
        if !light.is_delta() && !self.mis.samples_lights() {
            return;
        }
        let lambda = walk.lambda;
        let sample = light.sample_li_in(scene, p, choice.region, choice.u, &lambda);
        let Some(l) = sample else { return };
        let (f, pdf_b) = f(l.wi);
        if f.is_black() || l.le.is_black() {
            return;
        }
        stats.shadow_rays += 1;
        let mut shares = flight.shares;
        shares.turn();
        let mut beam = Beam { t: Spectrum::ONE, shares };
        let medium = enter(l.wi, flight.medium);
        if !self.shine(&mut beam, flight, ray(&l), medium, light.is_infinite(), &lambda) {
            return;
        }
        let pdf_l = choice.p * l.pdf_w;
        let w = match l.delta {
            true => 1.0,
            false => self.mis.light(pdf_l, pdf_b * beam.shares.mean(beam.shares.camera)), // (5)
        };
        let found = walk.beta * f * l.le * beam.t * (w / pdf_l);
        flight.shares.add_by(walk, found, beam.shares.light);
    }

    /// Sends a beam through all that lets it pass; false if it is stopped.
    fn shine(
        &self,
        beam: &mut Beam,
        flight: &mut Flight<'a>,
        segment: Segment,
        mut medium: Option<MediumId>,
        from_infinity: bool,
        lambda: &Wavelengths,
    ) -> bool {
        let scene = self.scene();
        let Segment { mut ray, t_max } = segment;
        let target = ray.at(1.0);
        let wi = ray.d.normalize();
        for _ in 0..MAX_PASSAGES {
            let hit = scene.hit(&ray, t_max);
            if let Some(id) = medium {
                let length = ray.d.length();
                let end = match &hit {
                    Some(hit) => hit.t * length,
                    None if from_infinity => f32::INFINITY,
                    None => t_max * length,
                };
                let unit = Ray { d: wi, ..ray };
                self.fade(beam, flight, scene.medium(id), &unit, end, lambda);
                if beam.t.is_black() {
                    return false;
                }
            }
            let Some(hit) = hit else { return true };
            let surface = scene.geometry.surface(&hit, &ray);
            let mut lambda = *lambda;
            if scene.bsdf_into(&surface, -wi, &mut lambda, &mut flight.passed) {
                let (value, p) = flight.passed.straight(-wi, flight.panes);
                if value.is_black() {
                    return false;
                }
                let p = Spectrum::splat(p);
                beam.event(value, Spectrum::ONE, p);
            }
            medium = scene.medium_beyond(&surface, wi, medium);
            ray = surface.spawn_to(target);
        }
        false
    }

    /// Weakens a beam by a medium, as far as `end` along the ray.
    fn fade(
        &self,
        beam: &mut Beam,
        flight: &mut Flight<'a>,
        medium: &Medium,
        ray: &Ray,
        end: f32,
        lambda: &Wavelengths,
    ) {
        let Some((t0, t1)) = medium.interval(ray, end) else { return };
        if let Some(c) = medium.uniform(ray.d, lambda) {
            let t = transmittance(c.sigma_t, t1 - t0);
            let p = if medium.scatters { t } else { Spectrum::ONE };
            return beam.event(t, Spectrum::ONE, p);
        }
        let hero = beam.shares.hero;
        let mut rest = flight.stream.distance();
        let mut t_bar = Spectrum::ONE;
        for stretch in medium.stretches(ray, t0, t1, lambda) {
            let bar = stretch.majorant;
            let mut t = stretch.t0;
            while bar[hero] > 0.0 && rest < bar[hero] * (stretch.t1 - t) {
                let step = rest / bar[hero];
                t += step;
                t_bar *= transmittance(bar, step);
                let c = medium.at(ray.at(t), ray.d, lambda);
                let null = (bar - c.sigma_t).clamp_zero() * t_bar;
                let q = t_bar * bar;
                beam.event(null, q, if medium.scatters { null } else { q });
                if beam.t.max_component() < FAINT {
                    if flight.stream.next() >= SURVIVAL {
                        beam.t = Spectrum::ZERO;
                    }
                    beam.t *= 1.0 / SURVIVAL;
                }
                if beam.t.is_black() {
                    return;
                }
                t_bar = Spectrum::ONE;
                rest = flight.stream.distance();
            }
            let length = stretch.t1 - t;
            if bar[hero] > 0.0 {
                rest -= bar[hero] * length;
            }
            t_bar *= transmittance(bar, length);
        }
        beam.event(t_bar, t_bar, t_bar);
    }
}
