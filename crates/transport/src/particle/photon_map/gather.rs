//! Final gathering: the light that other surfaces send (Jensen 1996).
//!
//! ```text
//! L_{i,d}:  L ≈ 1/n Σ_j f(ω_j, ωₒ) |cos θ_j| L_map(y_j) / p(ω_j),   p = ½ p_guide + ½ p_f       (5)
//! ```
//!
//! y_j is the first matte surface along the ray, behind whatever mirrors. Lights that a ray meets
//! count as nothing: they are the direct term's, and the caustic's if mirrors lie between. Where
//! the estimate at y would reach back to where the ray came from, in corners, y is evaluated
//! accurately: direct light by a shadow ray, caustics by their map, all else by going on.

use super::emission::next_surface;
use super::estimate::{Place, read_at};
use super::eye::{Eye, Room};
use super::guide::Guide;
use super::lobes::{Parts, parts};
use super::tracing::scatter;
use crate::method::PassStats;
use kaustika_math::{Ray, Vec2};
use kaustika_sampling::Sampler;
use kaustika_scene::bsdf::{Lobes, Mode};
use kaustika_spectra::{Spectrum, Wavelengths};

/// What a ray found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gathered {
    pub(super) radiance: Spectrum,
    /// Distance to the first surface.
    pub(super) distance: f32,
}

impl<'a> Eye<'a> {
    /// (5), at a surface that lies `depth` bounces from the eye.
    pub(super) fn multiple(
        &self,
        at: &Place,
        depth: u32,
        sampler: &mut Sampler,
        room: &mut Room<'a>,
        stats: &mut PassStats,
    ) -> Spectrum {
        let guide = match self.params.guide {
            true => Guide::new(&self.maps.global, at, self.global.radius, &mut room.found),
            false => None,
        };
        let mut sum = Spectrum::ZERO;
        for _ in 0..self.params.gather {
            let u = sampler.get_vertex();
            let (u2, uc) = (Vec2::new(u[2], u[3]), u[5]);
            let drawn = || at.bsdf.sample(at.wo, uc, u2, Mode::Radiance, at.lobes);
            let (wi, weight) = match &guide {
                None => {
                    let Some(s) = drawn() else { continue };
                    (s.wi, s.weight)
                }
                Some(guide) => {
                    let wi = match u[4] < 0.5 {
                        true => Some(guide.sample(2.0 * u[4], u2)),
                        false => drawn().map(|s| s.wi),
                    };
                    let Some(wi) = wi else { continue };
                    let (f, (pdf, _)) = at.bsdf.eval_pdf(at.wo, wi, Mode::Radiance, at.lobes);
                    (wi, f / (0.5 * (guide.pdf_w(wi) + pdf)))
                }
            };
            if weight.is_black() || !weight.is_finite() {
                continue;
            }
            let (ray, worth) = (at.surface.spawn(wi), at.worth / self.params.gather as f32);
            let gathered =
                self.gathered(ray, at.lambda, weight, worth, depth + 1, sampler, room, stats);
            sum += gathered.radiance;
        }
        sum / self.params.gather as f32
    }

    /// What one ray finds whose light is multiplied by `beta`, and then is worth `worth`.
    pub(super) fn gathered(
        &self,
        mut ray: Ray,
        from: &Wavelengths,
        mut beta: Spectrum,
        worth: Spectrum,
        mut depth: u32,
        sampler: &mut Sampler,
        room: &mut Room<'a>,
        stats: &mut PassStats,
    ) -> Gathered {
        let mut found = Gathered { radiance: Spectrum::ZERO, distance: f32::INFINITY };
        let (mut lambda, mut first, mut from_matte) = (*from, true, true);
        while depth < self.max_depth {
            let Room { found: near, behind: bsdf, .. } = room;
            let surface = next_surface(self.scene, ray, &mut lambda, bsdf, stats);
            let Some(surface) = surface else { break };
            if first {
                found.distance = surface.t;
            }
            let wo = -ray.d;
            let mut on = parts(bsdf, self.params.matte);
            let mut here = Spectrum::ZERO;
            let u = sampler.get_vertex();
            if !on.matte.is_empty() {
                let at = Place {
                    surface: &surface,
                    bsdf,
                    wo,
                    lobes: on.matte,
                    lambda: &lambda,
                    worth: beta * worth,
                };
                let map = self.global_map(&at, depth, near);
                if from_matte && surface.t < map.radius {
                    here = self.direct(&at, Lobes::NONE, depth, &u, stats)
                        + self.caustic(&at, depth, near);
                } else {
                    here = map.radiance;
                    on = Parts { matte: Lobes::NONE, ..on };
                }
            }
            found.radiance += read_at(beta * here, &lambda, from);
            let Some(s) = scatter(bsdf, &on, wo, beta, Mode::Radiance, sampler) else { break };
            (beta, from_matte, first) = (s.power, s.matte, false);
            ray = surface.spawn(s.sample.wi);
            depth += 1;
        }
        found
    }
}
