//! Light sampling through media: the light's term with transmittance,
//! w_l f(ωₒ,ω_l) Lₑ T / (p p_l).

use super::super::integrate::Integrator;
use super::super::walk::Walk;
use super::Flight;
use crate::extinction::Beam;
use crate::method::PassStats;
use kaustika_math::{Vec2, Vec3};
use kaustika_scene::description::MediumId;
use kaustika_scene::{LightSample, Segment};
use kaustika_spectra::Spectrum;

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
        let mut beam = Beam::new(shares);
        let medium = enter(l.wi, flight.medium);
        let Flight { panes, stream, passed, .. } = flight;
        let far = light.is_infinite();
        if !beam.shine(scene, &ray(&l), medium, far, &lambda, *panes, stream, passed) {
            return;
        }
        let pdf_l = choice.p * l.pdf_w;
        let w = match l.delta {
            true => 1.0,
            false => self.mis.light(pdf_l, pdf_b * beam.shares.mean(beam.shares.path)), // (5)
        };
        let found = walk.beta * f * l.le * beam.t * (w / pdf_l);
        flight.add_by(walk, found, beam.shares.other);
    }
}
