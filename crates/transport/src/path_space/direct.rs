//! Direct light at the vertices of an eye path: what the path found by itself, and what its
//! vertices ask for, weighted against each other (Veach & Guibas 1995).
//!
//! ```text
//! w_b βᴱ Lₑ                              found                         (6)
//! βᴱ (f_o + w_l f_w) |cos| Lₑ V / p_D    asked for, as (3)             (7)
//! ```
//!
//! f_w is the part of f by which the path goes on, so that it can find the light too, and f_o the
//! others.

use super::{Escape, LightEnd, Vertex, passage};
use crate::method::PassStats;
use kaustika_math::Vec3;
use kaustika_sampling::MisHeuristic;
use kaustika_scene::bsdf::{Lobes, Mode};
use kaustika_scene::{LightId, LightSelection, Scene};
use kaustika_spectra::Spectrum;

/// Weighs direct light.
#[derive(Clone, Copy, Debug)]
pub struct Direct<'a> {
    /// Where.
    pub scene: &'a Scene,
    /// How vertices choose a light.
    pub lights: &'a LightSelection,
    /// How lights are chosen to emit.
    pub emission: &'a LightSelection,
    /// How the two ways are weighted.
    pub mis: MisHeuristic,
    /// The classes of scattering by which the path goes on.
    pub walked: Lobes,
}

impl Direct<'_> {
    /// (6): light that the surface of the path's vertex `i` emits.
    pub fn met(&self, eye: &[Vertex], i: usize) -> Option<(Spectrum, LightId)> {
        let (scene, z) = (self.scene, &eye[i]);
        let (s, id) = (&z.surface, z.surface.light?);
        let le = scene.light(id).le(scene, s, z.wo, &z.lambda);
        if le.is_black() {
            return None;
        }
        let w = self.found(&eye[..i], z.passing, (id, s.p, s.ng, z.wo));
        Some((z.beta * le * w, id))
    }

    /// (6): light from far away, where the path left the scene; `each` gets that of every light.
    pub fn escaped(
        &self,
        eye: &[Vertex],
        escape: &Escape,
        mut each: impl FnMut(Spectrum, LightId),
    ) {
        for &id in &self.scene.environments {
            let le = self.scene.light(id).escaped(escape.o, escape.d, &escape.lambda).le;
            if !le.is_black() {
                let far = (id, Vec3::ZERO, Vec3::ZERO, -escape.d);
                each(escape.beta * le * self.found(eye, escape.passing, far), id);
            }
        }
    }

    /// (7): a vertex asks for a light. What it gets, from which direction, from which light.
    pub fn asked(&self, z: &Vertex, stats: &mut PassStats) -> Option<(Spectrum, Vec3, LightId)> {
        let scene = self.scene;
        let e = z.next_event(scene, self.lights, self.emission)?;
        let (end, wi) = (&e.end, -e.end.w);
        if end.hittable && !self.mis.samples_lights() {
            return None;
        }
        let passage = passage(scene, z, &e.segment, end.infinite, &z.lambda, stats)?;
        let weight = |pdf: f64| {
            let chosen = end.next_event(scene, self.lights, z);
            let walked = pdf * end.area(z.surface.p) * passage.passing;
            self.mis.light(1.0, (walked / chosen) as f32)
        };
        let weight = match end.hittable {
            false => Spectrum::ONE,
            true if self.walked.contains(z.bsdf.lobes()) => Spectrum::splat(weight(e.pdf.0)),
            true => {
                let part = z.bsdf.eval(z.wo, wi, Mode::Radiance, self.walked);
                let all = z.bsdf.eval(z.wo, wi, Mode::Radiance, Lobes::ALL);
                let share = part.safe_div(all).clamp(0.0, 1.0);
                let pdf = z.bsdf.pdf(z.wo, wi, Mode::Radiance, self.walked).0;
                Spectrum::ONE - share * (1.0 - weight(f64::from(pdf) / z.share))
            }
        };
        Some((e.value * passage.value * weight, wi, end.light))
    }

    /// w_b of light found after the vertices `eye`.
    fn found(
        &self,
        eye: &[Vertex],
        passing: f64,
        (id, p, n, w): (LightId, Vec3, Vec3, Vec3),
    ) -> f32 {
        // What went straight through has not been asked for lights, nor have mirrors.
        let Some(last) = eye.last().filter(|v| !v.delta) else { return 1.0 };
        let end = LightEnd::new(self.scene, self.emission, id, p, n, w);
        let chosen = end.next_event(self.scene, self.lights, last);
        let walked = last.pdf * end.area(last.surface.p) * passing;
        self.mis.bsdf((chosen / walked) as f32, 1.0)
    }
}
