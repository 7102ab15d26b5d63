//! Subpaths through participating media: [`crate::extinction`] from vertex to vertex.
//!
//! What goes straight through a surface (a boundary between media, a cut-out, a thin pane) is no
//! vertex here, as in `path` and for the beams of connections.

use super::subpath::{MAX_PASSAGES, Trail};
use super::vertex::in_space;
use super::{Escape, Glow, Inside, Start, Subpath, Walker};
use crate::extinction::{
    Shares, Stream, collide, lane_mean, optical_distance, optical_length, transmittance,
};
use crate::method::PassStats;
use kaustika_math::{Vec2, Vec3};
use kaustika_sampling::Sampler;
use kaustika_scene::bsdf::{BsdfSample, Lobes, Mode};
use kaustika_scene::description::{MediumId, SourceFormat};
use kaustika_scene::medium::{Coefficients, Medium, Phase};
use kaustika_spectra::Spectrum;

/// What a subpath through media keeps besides its [`Trail`].
struct Flight {
    shares: Shares,
    medium: Option<MediumId>,
    /// The number that the next distance is drawn with.
    u_distance: f32,
    stream: Stream,
    /// [`Vertex::passing`] so far.
    passing: f64,
}

impl<'a> Walker<'a> {
    /// [`Walker::walk`] where there are media.
    pub(super) fn walk_through_media(
        &self,
        start: &Start,
        most: usize,
        sampler: &mut Sampler,
        path: &mut Subpath<'a>,
        stats: &mut PassStats,
    ) -> Option<Escape> {
        let scene = self.scene;
        let u = sampler.get_vertex();
        let panes = scene.format != SourceFormat::Pbrt;
        let mut trail = Trail::new(start);
        let mut flight = Flight {
            shares: Shares::independent(&trail.lambda, u[0]),
            medium: start.medium,
            u_distance: u[7],
            stream: Stream::new(&u[1..7]),
            passing: 1.0,
        };
        let mut passages = 0;
        while path.len() < most {
            stats.closest_rays += 1;
            let hit = scene.hit(&trail.ray, trail.t_max);
            let end = hit.as_ref().map_or(f32::INFINITY, |h| h.t);
            if let Some((phase, u)) = self.travel(&mut trail, &mut flight, end, path, sampler) {
                let v = path.next();
                let (wi, pdf) = phase.sample(v.surface.p, v.wo, Vec2::new(u[2], u[3]));
                let (f, (_, back)) = v.eval_pdf(wi, self.mode);
                let weight = f / pdf;
                let (pdf_rev, eta, lobe) = (back as f32, 1.0, Lobes::DIFFUSE_REFLECTION);
                let s = BsdfSample { wi, weight, pdf, pdf_rev, eta, lobe };
                path.keep();
                self.leave(&mut trail, path, Some(&s), u[6])?;
                flight.turn(u[7]);
                passages = 0;
                continue;
            }
            if trail.beta.is_black() {
                return None;
            }
            let Some(hit) = hit else { return Some(trail.escape(flight.passing)) };
            let mut surface = scene.geometry.surface(&hit, &trail.ray);
            trail.widen(surface.t);
            surface.footprint = trail.footprint;
            let wo = -trail.ray.d;
            let bsdf = &mut path.next().bsdf;
            let mut straight = !scene.bsdf_into(&surface, wo, &mut trail.lambda, bsdf);
            if !straight {
                flight.shares.end_secondary(&trail.lambda);
                let u = sampler.get_vertex();
                let (value, p) = bsdf.straight(wo, panes);
                let s = bsdf.sample(wo, u[5], Vec2::new(u[2], u[3]), self.mode, self.lobes);
                straight = p > 0.0 && s.is_some_and(|s| goes_straight(&s, wo, panes));
                if straight {
                    trail.beta *= value / p;
                    trail.throughput *= value / p;
                    flight.passing *= f64::from(p);
                } else {
                    // Here with probability 1 - p: β is divided by it, the sample's density too.
                    let stays = 1.0 - p;
                    trail.beta /= stays;
                    trail.throughput /= stays;
                    let s = s.map(|s| BsdfSample { weight: s.weight * stays, ..s });
                    let v = trail.place(path, surface, wo, &u);
                    v.medium = flight.medium;
                    v.passing = flight.passing;
                    v.share = 1.0 - f64::from(v.bsdf.straight(wo, false).1);
                    v.arrival *= v.passing * v.share;
                    path.keep();
                    self.leave(&mut trail, path, s.as_ref(), u[6])?;
                    flight.turn(u[7]);
                    flight.medium = scene.medium_beyond(&surface, trail.ray.d, flight.medium);
                    passages = 0;
                }
            }
            if straight {
                passages += 1;
                if passages > MAX_PASSAGES {
                    return None;
                }
                let d = trail.ray.d;
                flight.medium = scene.medium_beyond(&surface, d, flight.medium);
                flight.u_distance = flight.stream.draw();
                (trail.ray, trail.t_max) = (surface.spawn(d), f32::INFINITY);
            }
        }
        None
    }

    /// Follows the ray as far as `end`. If it scatters before, the path's next vertex is made; what it
    /// scatters by, and its numbers.
    fn travel(
        &self,
        trail: &mut Trail,
        flight: &mut Flight,
        end: f32,
        path: &mut Subpath<'a>,
        sampler: &mut Sampler,
    ) -> Option<(&'a Phase, [f32; 8])> {
        let medium = self.scene.medium(flight.medium?);
        let range = medium.interval(&trail.ray, end)?;
        let depth = path.len();
        let lambda = trail.lambda;
        let before = trail.beta;
        let glows = &mut path.glows;
        let mut glow = |value: Spectrum| {
            if self.mode == Mode::Radiance {
                glows.push(Glow { depth, value, lambda });
            }
        };
        let found = match medium.uniform(trail.ray.d, &lambda) {
            Some(c) => travel_evenly(medium, &c, trail, flight, range, glow),
            None => {
                let Flight { u_distance, stream, shares, .. } = flight;
                let beta = &mut trail.beta;
                let glow = |value, _| glow(value);
                collide(medium, &trail.ray, range, &lambda, *u_distance, stream, shares, beta, glow)
                    .map(|c| (c.t, c.at))
            }
        };
        trail.throughput *= trail.beta.safe_div(before);
        let (t, c) = found?;
        if trail.beta.is_black() {
            return None;
        }
        trail.widen(t);
        let u = sampler.get_vertex();
        let surface = in_space(trail.ray.at(t), t, trail.ray.time);
        let last = path.last().map(|v| (v.surface.p, v.pdf));
        path.next().bsdf.reset(Vec3::ZERO);
        let v = trail.place(path, surface, -trail.ray.d, &u);
        let sigma_t = f64::from(lane_mean(c.sigma_t, lambda.mode));
        v.inside = Some(Inside { phase: &medium.phase, sigma_t });
        v.medium = flight.medium;
        v.passing = flight.passing;
        v.arrival = trail.arrival(last, v) * v.passing;
        Some((&medium.phase, u))
    }
}

impl Flight {
    /// After a vertex.
    fn turn(&mut self, u_distance: f32) {
        self.u_distance = u_distance;
        self.passing = 1.0;
    }
}

/// Through a homogeneous medium: (2) of [`crate::extinction`].
fn travel_evenly(
    medium: &Medium,
    c: &Coefficients,
    trail: &mut Trail,
    flight: &mut Flight,
    (t0, t1): (f32, f32),
    glow: impl FnOnce(Spectrum),
) -> Option<(f32, Coefficients)> {
    let (sigma_t, length) = (c.sigma_t, t1 - t0);
    if !c.glow.is_black() {
        // All of the way, wherever the path itself may end.
        glow(trail.beta * c.glow * optical_length(sigma_t, length));
    }
    let mode = trail.lambda.mode;
    let shares = &mut flight.shares;
    if !medium.scatters {
        let t = transmittance(sigma_t, length);
        shares.event(&mut trail.beta, t, Spectrum::ONE, Spectrum::ONE);
        return None;
    }
    let sigma = sigma_t[shares.hero];
    let distance = optical_distance(flight.u_distance) / sigma;
    if sigma > 0.0 && distance < length {
        let t = transmittance(sigma_t, distance);
        shares.event(&mut trail.beta, c.sigma_s * t, sigma_t * t, Spectrum::ZERO);
        flight.passing *= f64::from(lane_mean(t, mode));
        return Some((t0 + distance, *c));
    }
    let t = transmittance(sigma_t, length);
    shares.event(&mut trail.beta, t, t, Spectrum::ONE);
    flight.passing *= f64::from(lane_mean(t, mode));
    None
}

/// True if a sample is what [`Bsdf::straight`] tells of.
fn goes_straight(s: &BsdfSample, wo: Vec3, panes: bool) -> bool {
    let pane = panes && s.lobe == Lobes::DELTA_TRANSMISSION && s.wi.dot(wo) < -0.99999;
    s.lobe.has(Lobes::NULL) || pane
}
