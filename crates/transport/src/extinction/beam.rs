//! A connection through media: transmittance.
//!
//! ```text
//! T by (1) in homogeneous media, else by ratio tracking:
//! T ← T (σ̄ - σₜ)/σ̄ at each collision                     (Novák, Selle & Jarosz 2014)
//! ```

use super::{Shares, Stream, lane_mean, transmittance};
use kaustika_math::Ray;
use kaustika_scene::bsdf::Bsdf;
use kaustika_scene::description::MediumId;
use kaustika_scene::medium::Medium;
use kaustika_scene::{Scene, Segment};
use kaustika_spectra::{Spectrum, Wavelengths};

/// Passages through surfaces a beam may make before it is given up.
const MAX_PASSAGES: u32 = 1000;

/// Below this transmittance a beam survives a collision with probability [`SURVIVAL`].
const FAINT: f32 = 0.05;
const SURVIVAL: f32 = 0.25;

/// Light on its way between two points.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    /// T.
    pub t: Spectrum,
    /// Shares of the lanes in its density, ⟨other⟩ = 1, and, as `path`, the density with which a
    /// walk could have gone the same way, over the same mean.
    pub shares: Shares,
    /// What of a walk's density is the same for all walks along this way: the transmittance of
    /// homogeneous media, the lanes' mean, and the chances of going straight through surfaces.
    pub passing: f32,
}

impl Beam {
    /// A beam whose lanes have these shares.
    pub fn new(shares: Shares) -> Beam {
        Beam { t: Spectrum::ONE, shares, passing: 1.0 }
    }

    /// An event of density `q`, which a walk would have with density `p`.
    fn event(&mut self, f: Spectrum, q: Spectrum, p: Spectrum) {
        let mean = self.shares.mean(self.shares.other * q);
        let k = if mean > 0.0 { 1.0 / mean } else { 0.0 };
        self.t *= f * k;
        self.shares.other *= q * k;
        self.shares.path *= p * k;
    }

    /// Sends the beam along a segment, from where `medium` is, through all that lets it pass;
    /// false if it is stopped. `panes` says whether thin panes let light straight through, `room`
    /// is room to work in.
    #[expect(clippy::too_many_arguments)]
    pub fn shine<'a>(
        &mut self,
        scene: &'a Scene,
        segment: &Segment,
        mut medium: Option<MediumId>,
        from_infinity: bool,
        lambda: &Wavelengths,
        panes: bool,
        stream: &mut Stream,
        room: &mut Bsdf<'a>,
    ) -> bool {
        let Segment { mut ray, mut t_max } = *segment;
        let target = ray.at(t_max);
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
                self.fade(scene.medium(id), &unit, end, lambda, stream);
                if self.t.is_black() {
                    return false;
                }
            }
            let Some(hit) = hit else { return true };
            let surface = scene.geometry.surface(&hit, &ray);
            let mut lambda = *lambda;
            if scene.bsdf_into(&surface, -wi, &mut lambda, room) {
                let (value, p) = room.straight(-wi, panes);
                if value.is_black() {
                    return false;
                }
                self.event(value, Spectrum::ONE, Spectrum::splat(p));
                self.passing *= p;
            }
            medium = scene.medium_beyond(&surface, wi, medium);
            (ray, t_max) = (surface.spawn_to(target), 1.0);
        }
        false
    }

    /// Weakens the beam by a medium, as far as `end` along the ray.
    fn fade(
        &mut self,
        medium: &Medium,
        ray: &Ray,
        end: f32,
        lambda: &Wavelengths,
        stream: &mut Stream,
    ) {
        let Some((t0, t1)) = medium.interval(ray, end) else { return };
        if let Some(c) = medium.uniform(ray.d, lambda) {
            let t = transmittance(c.sigma_t, t1 - t0);
            let p = if medium.scatters { t } else { Spectrum::ONE };
            self.passing *= lane_mean(p, lambda.mode);
            return self.event(t, Spectrum::ONE, p);
        }
        let hero = self.shares.hero;
        let mut rest = stream.distance();
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
                self.event(null, q, if medium.scatters { null } else { q });
                if self.t.max_component() < FAINT {
                    if stream.draw() >= SURVIVAL {
                        self.t = Spectrum::ZERO;
                    }
                    self.t *= 1.0 / SURVIVAL;
                }
                if self.t.is_black() {
                    return;
                }
                t_bar = Spectrum::ONE;
                rest = stream.distance();
            }
            let length = stretch.t1 - t;
            if bar[hero] > 0.0 {
                rest -= bar[hero] * length;
            }
            t_bar *= transmittance(bar, length);
        }
        self.event(t_bar, t_bar, t_bar);
    }
}
