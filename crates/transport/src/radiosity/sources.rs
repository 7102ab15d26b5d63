//! What elements send by themselves.
//!
//! ```text
//! S = E + ρ H_d                                                                     (1)
//! H_d ≈ 1/n Σ Lₑ V cos θ / p                                                        (2)
//! ```
//!
//! H_d is the irradiance by light that no patch sends: that of points, spots, directions and the sky; or
//! of all lights, if direct light is left to rays. Then E is not sent, and what patches get is
//! indirect.

use super::mesh::{Mesh, Point};
use super::points::{r2, rotated};
use kaustika_math::{Vec2, mix_bits};
use kaustika_sampling::hash::{combine, halves, unit};
use kaustika_scene::{Light, LightId, LightSample, RayBatch, Scene, Segment, ShapeSample};
use kaustika_spectra::{Spectrum, Wavelengths};
use rayon::prelude::*;

/// Points of an element that ask for lights.
const POINTS: u32 = 8;

/// Who asks for which lights.
#[derive(Clone, Debug)]
pub struct Sources<'a> {
    scene: &'a Scene,
    /// True: every light is asked for by rays, and patches do not emit.
    rays: bool,
    /// The lights that are no patches.
    others: Vec<LightId>,
}

impl<'a> Sources<'a> {
    /// With direct light by rays, or from patches.
    pub fn new(scene: &'a Scene, rays: bool) -> Sources<'a> {
        let ids = (0..scene.lights.len()).map(|i| LightId(i as u32));
        let others = ids.filter(|id| !matches!(scene.light(*id), Light::Area(_))).collect();
        Sources { scene, rays, others }
    }

    /// True if patches emit.
    pub fn emit(&self) -> bool {
        !self.rays
    }

    /// (1) of some elements.
    pub fn of(&self, mesh: &Mesh, elements: &[u32]) -> Vec<Spectrum> {
        let direct = self.direct(mesh, elements);
        let source = |(e, h): (&u32, Spectrum)| {
            let element = &mesh.elements[*e as usize];
            let emission = if self.emit() { element.emission } else { Spectrum::ZERO };
            emission + element.albedo * h
        };
        elements.iter().zip(direct).map(source).collect()
    }

    /// (2) of some elements.
    pub fn direct(&self, mesh: &Mesh, elements: &[u32]) -> Vec<Spectrum> {
        if !self.rays && self.others.is_empty() {
            return vec![Spectrum::ZERO; elements.len()];
        }
        let room = RayBatch::default;
        elements.par_iter().map_init(room, |batch, &e| self.direct_at(mesh, e, batch)).collect()
    }

    fn direct_at(&self, mesh: &Mesh, e: u32, batch: &mut RayBatch) -> Spectrum {
        if mesh.elements[e as usize].albedo.is_black() {
            return Spectrum::ZERO;
        }
        let scene = self.scene;
        let key = mix_bits(u64::from(e) ^ 0x6469_7265_6374);
        let lambda = Wavelengths::rgb();
        let (mut segments, mut terms) = (Vec::new(), Vec::new());
        for i in 0..POINTS {
            let x = mesh.sample(scene, e, rotated(r2(i), combine(key, 1)));
            let u2 = rotated(r2(i), combine(key, 2));
            let mut ask = |l: Option<LightSample>, p: f32| {
                let Some(l) = l else { return };
                let k = x.n.dot(l.wi).max(0.0) / (p * l.pdf_w * POINTS as f32);
                if k > 0.0 && !l.le.is_black() {
                    segments.push(sight(scene, &x, &l));
                    terms.push(l.le * k);
                }
            };
            if self.rays {
                let u = unit(halves(combine(key, 8 + u64::from(i))).0);
                let Some(c) = scene.light_selection.sample(x.p, x.n, u, u2) else { continue };
                let light = scene.light(c.light);
                ask(light.sample_li_in(scene, x.p, c.region, c.u, &lambda), c.p);
            } else {
                for (k, id) in self.others.iter().enumerate() {
                    let shift = combine(key, 64 + k as u64);
                    let u2: Vec2 = rotated(u2, shift);
                    ask(scene.light(*id).sample_li_in(scene, x.p, None, u2, &lambda), 1.0);
                }
            }
        }
        scene.occluded_all(&segments, batch);
        let seen = terms.iter().zip(&batch.occluded).filter(|(_, hidden)| !**hidden);
        seen.fold(Spectrum::ZERO, |sum, (t, _)| sum + *t) // (2)
    }
}

fn sight(scene: &Scene, x: &Point, l: &LightSample) -> Segment {
    scene.shadow_ray_from(&ShapeSample { p: x.p, p_error: x.p_error, n: x.n }, l)
}
