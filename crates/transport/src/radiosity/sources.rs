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
use crate::workers::Workers;
use kaustika_math::{Ray, Vec2, mix_bits};
use kaustika_sampling::hash::{combine, halves, permute, unit};
use kaustika_scene::{Light, LightId, LightSample, RayBatch, Scene, Segment, ShapeSample};
use kaustika_spectra::{Spectrum, Wavelengths};
use rayon::prelude::*;
use std::f32::consts::PI;

/// Points of an element that ask for lights.
const POINTS: u32 = 8;
/// Patches that are asked for between two looks at whether to go on.
const BETWEEN: usize = 1 << 12;

/// Which lights are asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    All,
    /// Those that patches are, while rays find them too.
    Areas(Rivals),
    /// The others.
    Others,
}

/// Rays of an element, cosine-distributed, and points of it that ask for lights, where both find the same
/// light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rivals {
    /// How many rays.
    pub rays: u32,
    /// How many points.
    pub points: u32,
}

impl Rivals {
    /// The balance heuristic's weight of points that ask with density `pdf_w` for a direction with this cosine.
    pub fn of_points(self, pdf_w: f32, cos: f32) -> f32 {
        let asked = self.points as f32 * pdf_w;
        let met = self.rays as f32 * cos.max(0.0) / PI;
        asked / (asked + met).max(f32::MIN_POSITIVE)
    }
}

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
        let asked = if self.rays { Asked::All } else { Asked::Others };
        self.ask(mesh, elements, asked)
    }

    /// (2) of all patches, told of; `None` if cancelled.
    pub fn direct_of_all(
        &self,
        mesh: &Mesh,
        patches: &[u32],
        workers: &Workers,
    ) -> Option<Vec<Spectrum>> {
        let mut light = Vec::with_capacity(patches.len());
        for some in patches.chunks(BETWEEN) {
            if workers.cancelled() {
                return None;
            }
            light.extend(self.direct(mesh, some));
            workers
                .tell(|| format!("light of lamps on {} of {} patches", light.len(), patches.len()));
        }
        Some(light)
    }

    /// (2) of some elements by the lights that patches are, weighted against what rays find of them.
    pub fn of_areas(&self, mesh: &Mesh, elements: &[u32], rivals: Rivals) -> Vec<Spectrum> {
        self.ask(mesh, elements, Asked::Areas(rivals))
    }

    fn ask(&self, mesh: &Mesh, elements: &[u32], asked: Asked) -> Vec<Spectrum> {
        let room = RayBatch::default;
        let elements = elements.par_iter();
        elements.map_init(room, |batch, &e| self.ask_at(mesh, e, asked, batch)).collect()
    }

    fn ask_at(&self, mesh: &Mesh, e: u32, asked: Asked, batch: &mut RayBatch) -> Spectrum {
        if mesh.elements[e as usize].albedo.is_black() {
            return Spectrum::ZERO;
        }
        let scene = self.scene;
        let key = mix_bits(u64::from(e) ^ 0x6469_7265_6374);
        let lambda = Wavelengths::rgb();
        let points = if let Asked::Areas(rivals) = asked { rivals.points } else { POINTS };
        let (mut segments, mut terms) = (Vec::new(), Vec::new());
        for i in 0..points {
            let x = mesh.sample(scene, e, rotated(r2(i), combine(key, 1)));
            // Places on the element and on lights are one set of points each, paired by chance.
            let u2 = rotated(r2(permute(i, points, combine(key, 3))), combine(key, 2));
            let mut ask = |l: Option<LightSample>, p: f32| {
                let Some(l) = l else { return };
                let cos = x.n.dot(l.wi).max(0.0);
                let weight = match asked {
                    Asked::Areas(rivals) => rivals.of_points(p * l.pdf_w, cos),
                    _ => 1.0,
                };
                let k = weight * cos / (p * l.pdf_w * points as f32);
                if k > 0.0 && !l.le.is_black() {
                    segments.push(sight(scene, &x, &l));
                    terms.push(l.le * k);
                }
            };
            if asked == Asked::Others {
                for (k, id) in self.others.iter().enumerate() {
                    let shift = combine(key, 64 + k as u64);
                    let u2: Vec2 = rotated(u2, shift);
                    ask(scene.light(*id).sample_li_in(scene, x.p, None, u2, &lambda), 1.0);
                }
            } else {
                let u = unit(halves(combine(key, 8 + u64::from(i))).0);
                let Some(c) = scene.light_selection.sample(x.p, x.n, u, u2) else { continue };
                let light = scene.light(c.light);
                if asked == Asked::All || matches!(light, Light::Area(_)) {
                    ask(light.sample_li_in(scene, x.p, c.region, c.u, &lambda), c.p);
                }
            }
        }
        scene.occluded_all(&segments, batch);
        let seen = terms.iter().zip(&batch.occluded).filter(|(_, hidden)| !**hidden);
        seen.fold(Spectrum::ZERO, |sum, (t, _)| sum + *t) // (2)
    }
}

/// Radiance that arrives along a ray's way back from what surrounds the scene.
pub fn outside(scene: &Scene, ray: &Ray) -> Spectrum {
    let lambda = Wavelengths::rgb();
    let escaped = |&id: &LightId| scene.light(id).escaped(ray.o, ray.d, &lambda).le;
    scene.environments.iter().fold(Spectrum::ZERO, |sum, id| sum + escaped(id))
}

fn sight(scene: &Scene, x: &Point, l: &LightSample) -> Segment {
    scene.shadow_ray_from(&ShapeSample { p: x.p, p_error: x.p_error, n: x.n }, l)
}
