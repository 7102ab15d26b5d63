//! Distances: where a path scatters on its way to the next surface, (2) and (3).

use super::super::integrate::Integrator;
use super::super::walk::Walk;
use super::equiangular::Equiangular;
use super::found::add_alone;
use super::{Flight, Scattering};
use crate::extinction::{collide, optical_distance, optical_length, transmittance};
use kaustika_math::{Vec2, Vec3};
use kaustika_scene::medium::{Coefficients, Medium};
use kaustika_spectra::Spectrum;

/// Share of the places of scattering that a lamp's light decides; the rest follow (2) alone.
const BY_LAMP: f32 = 0.5;

/// What happened on the way.
pub(super) enum Travel {
    /// Nothing that stopped it.
    Passed,
    /// It scatters before the end.
    Scattered(Scattering),
    /// Nothing of it is left.
    Ended,
}

impl<'a> Integrator<'a> {
    /// Follows the walk's ray through the medium it is in, as far as `end`.
    pub(super) fn travel(&self, walk: &mut Walk, flight: &mut Flight<'a>, end: f32) -> Travel {
        let Some(id) = flight.medium else { return Travel::Passed };
        let medium = self.scene().medium(id);
        let Some(range) = medium.interval(&walk.segment.ray, end) else { return Travel::Passed };
        let scattered = match medium.uniform(walk.segment.ray.d, &walk.lambda) {
            Some(c) => self.travel_evenly(medium, &c, walk, flight, range),
            None => self.travel_by_collisions(medium, walk, flight, range),
        };
        match scattered {
            _ if walk.beta.is_black() => Travel::Ended,
            Some((t, albedo)) => Travel::Scattered(Scattering { medium: id, t, albedo }),
            None => Travel::Passed,
        }
    }

    /// Through a homogeneous medium; the place and albedo if it scatters.
    fn travel_evenly(
        &self,
        medium: &Medium,
        c: &Coefficients,
        walk: &mut Walk,
        flight: &mut Flight<'a>,
        (t0, t1): (f32, f32),
    ) -> Option<(f32, Spectrum)> {
        let (sigma_t, length) = (c.sigma_t, t1 - t0);
        if !c.glow.is_black() && self.counts(walk.depth) {
            // All of the way, wherever the path itself may end.
            let found = walk.beta * c.glow * optical_length(sigma_t, length);
            flight.add(walk, found);
        }
        let shares = &mut flight.shares;
        if !medium.scatters {
            let t = transmittance(sigma_t, length);
            shares.event(&mut walk.beta, t, Spectrum::ONE, Spectrum::ONE);
            return None;
        }
        let sigma = sigma_t[shares.hero];
        let mut distance = optical_distance(flight.u_distance) / sigma;
        if sigma > 0.0 && distance < length {
            let lamp = self.lamp_along(walk, flight, (t0, t1));
            let stream = &mut flight.stream;
            if let (Some(lamp), true) = (&lamp, stream.draw() < BY_LAMP) {
                distance = (lamp.sample(stream.draw()) - t0).clamp(0.0, length);
            }
            let t = transmittance(sigma_t, distance);
            let mut p = sigma_t * t; // (2)
            if let Some(lamp) = &lamp {
                let scatters = Spectrum::ONE - transmittance(sigma_t, length);
                p = p * (1.0 - BY_LAMP) + scatters * (BY_LAMP * lamp.pdf(t0 + distance)); // (6)
            }
            flight.shares.event(&mut walk.beta, c.sigma_s * t, p, Spectrum::ZERO);
            return Some((t0 + distance, c.sigma_s.safe_div(sigma_t)));
        }
        let t = transmittance(sigma_t, length);
        shares.event(&mut walk.beta, t, t, Spectrum::ONE);
        None
    }

    /// How a lamp lights the ray, if one near by is chosen.
    fn lamp_along(
        &self,
        walk: &Walk,
        flight: &mut Flight<'a>,
        (t0, t1): (f32, f32),
    ) -> Option<Equiangular> {
        if !self.mis.samples_lights() {
            return None;
        }
        let (ray, stream) = (&walk.segment.ray, &mut flight.stream);
        let mut u2 = || Vec2::new(stream.draw(), stream.draw());
        let (a, b) = (u2(), u2());
        let choice = self.lights.sample(ray.o, Vec3::ZERO, a.x, b)?;
        let light = self.scene().light(choice.light);
        if light.is_infinite() {
            return None;
        }
        let lambda = &walk.lambda;
        let l = light.sample_li_in(self.scene(), ray.o, choice.region, choice.u, lambda)?;
        Equiangular::new(ray, l.p, t0, t1)
    }

    /// Through a medium that varies.
    fn travel_by_collisions(
        &self,
        medium: &Medium,
        walk: &mut Walk,
        flight: &mut Flight<'a>,
        (t0, t1): (f32, f32),
    ) -> Option<(f32, Spectrum)> {
        let (ray, lambda) = (walk.segment.ray, walk.lambda);
        let shows = self.counts(walk.depth);
        let Flight { u_distance, stream, shares, alone, .. } = flight;
        let Walk { beta, radiance, .. } = walk;
        let glow = |found: Spectrum, shares: Spectrum| {
            if shows {
                add_alone(radiance, alone, found, shares);
            }
        };
        let range = (t0, t1);
        let c = collide(medium, &ray, range, &lambda, *u_distance, stream, shares, beta, glow)?;
        Some((c.t, c.at.sigma_s.safe_div(c.at.sigma_t)))
    }
}
