//! Distances: where a path scatters on its way to the next surface, (2) and (3).

use super::super::integrate::Integrator;
use super::super::walk::Walk;
use super::shares::optical_distance;
use super::{Flight, Scattering};
use kaustika_scene::medium::{Coefficients, Medium};
use kaustika_spectra::Spectrum;

/// What happened on the way.
pub(super) enum Travel {
    /// Nothing that stopped it.
    Passed,
    /// It scatters before the end.
    Scattered(Scattering),
    /// Nothing of it is left.
    Ended,
}

/// T of (1) over `length` of constant extinction, also infinite.
#[inline]
pub(super) fn transmittance(sigma_t: Spectrum, length: f32) -> Spectrum {
    sigma_t.map(|s| if s > 0.0 { (-s * length).exp() } else { 1.0 })
}

/// ∫₀ᵈ T(t) dt of constant extinction.
#[inline]
fn optical_length(sigma_t: Spectrum, d: f32) -> Spectrum {
    sigma_t.map(|s| {
        let x = s * d;
        if s > 0.0 && x > 1e-4 { -(-x).exp_m1() / s } else { d * (1.0 - 0.5 * x) }
    })
}

impl<'a> Integrator<'a> {
    /// Follows the walk's ray through the medium it is in, as far as `end`.
    pub(super) fn travel(&self, walk: &mut Walk, flight: &mut Flight<'a>, end: f32) -> Travel {
        let Some(id) = flight.medium else { return Travel::Passed };
        let medium = self.scene().medium(id);
        let Some(range) = medium.interval(&walk.segment.ray, end) else { return Travel::Passed };
        let scattered = match medium.uniform(&walk.lambda) {
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
            flight.shares.add(walk, found);
        }
        let shares = &mut flight.shares;
        if !medium.scatters {
            let t = transmittance(sigma_t, length);
            shares.event(&mut walk.beta, t, Spectrum::ONE, Spectrum::ONE);
            return None;
        }
        let sigma = sigma_t[shares.hero];
        let distance = optical_distance(flight.u_distance) / sigma;
        if sigma > 0.0 && distance < length {
            let t = transmittance(sigma_t, distance);
            shares.event(&mut walk.beta, c.sigma_s * t, sigma_t * t, Spectrum::ZERO); // (2)
            return Some((t0 + distance, c.sigma_s.safe_div(sigma_t)));
        }
        let t = transmittance(sigma_t, length);
        shares.event(&mut walk.beta, t, t, Spectrum::ONE);
        None
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
        let hero = flight.shares.hero;
        let mut rest = optical_distance(flight.u_distance);
        // T̄ since the last collision.
        let mut t_bar = Spectrum::ONE;
        for stretch in medium.stretches(&ray, t0, t1, &lambda) {
            let bar = stretch.majorant;
            let mut t = stretch.t0;
            while bar[hero] > 0.0 && rest < bar[hero] * (stretch.t1 - t) {
                let step = rest / bar[hero];
                t += step;
                t_bar *= transmittance(bar, step);
                let c = medium.at(ray.at(t), &lambda);
                let p = t_bar * bar;
                if shows && !c.glow.is_black() {
                    let mean = flight.shares.mean(flight.shares.camera * p);
                    let found = walk.beta * t_bar * c.glow / mean;
                    // The lanes' shares once they have collided.
                    let shares = flight.shares.camera * p / mean;
                    flight.shares.add_by(walk, found, shares);
                }
                let shares = &mut flight.shares;
                if medium.scatters && flight.stream.next() * bar[hero] < c.sigma_t[hero] {
                    let (f, p) = (c.sigma_s * t_bar, c.sigma_t * t_bar);
                    shares.event(&mut walk.beta, f, p, Spectrum::ZERO); // (3)
                    return Some((t, c.sigma_s.safe_div(c.sigma_t)));
                }
                let null = (bar - c.sigma_t).clamp_zero() * t_bar;
                // What does not scatter needs no choice: the collision weakens the path.
                let chosen = if medium.scatters { null } else { p };
                shares.event(&mut walk.beta, null, chosen, p);
                if walk.beta.is_black() {
                    return None;
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
        flight.shares.event(&mut walk.beta, t_bar, t_bar, t_bar);
        None
    }
}
