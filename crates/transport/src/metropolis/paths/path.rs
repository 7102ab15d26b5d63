//! Whole paths x₀ … xₖ from a light to the lens, however they were made: a point of path space, its
//! measured contribution, and the density of every way to make it (Veach 1997, ch. 8 and 10).
//!
//! ```text
//! F(x) = Lₑ g₀ · Π_{0<i<k} f_i · Π_{0<i<k-1} g←ᵢ            of film and lens numbers and areas    (1)
//! q_s  = Π_{i<s} P→ᵢ · Π_{s≤i<k-1} P←ᵢ / A,   s ≤ k - 1       C_s = F / q_s                  (2)
//! q_k  = Π_{i<k} P→ᵢ / (n P←ₖ₋₁)                              the lens is asked for           (3)
//! P→ᵢ₊₁ = pσ→ᵢ g→ᵢ₊₁ J_i,   J = |cos θₑ| f̂_R / (|cos θₗ| f̂_I)     behind a Dirac lobe        (4)
//! ```
//!
//! f_i is f |cos θₗ| of radiance, or what a Dirac lobe turns; A the film's area in pixels, n its pixels;
//! P and g those of [`crate::path_space`]. At s = 1 P→₀ is the density with which x₁ asks for x₀. The
//! g of what Dirac lobes lead to are the same in (1) and (2), so that they only ever cancel; J
//! is what they do not have alike from both sides, where f̂ in importance and radiance differ.

use crate::metropolis::film::modulus;
use crate::path_space::{CameraEnd, LightEnd, Tracks, scattering, solid_angle_to_area, turning};
use kaustika_math::{Ray, Vec2, Vec3};
use kaustika_scene::bsdf::{Bsdf, Lobes, Mode};
use kaustika_scene::{LightSelection, Scene, Surface};
use kaustika_spectra::{Sensor, Spectrum, Wavelengths};
use std::rc::Rc;

/// An inner vertex of paths.
#[derive(Debug)]
pub(super) struct Node<'a> {
    pub(super) surface: Surface,
    pub(super) bsdf: Bsdf<'a>,
    /// The ray that found it, and how far that goes: with these it can be found again.
    pub(super) ray: Ray,
    pub(super) t_max: f32,
    /// True if it sends wavelengths different ways.
    pub(super) disperses: bool,
}

impl Node<'_> {
    pub(super) fn p(&self) -> Vec3 {
        self.surface.p
    }

    /// True if not all it does is turn light by Dirac lobes.
    pub(super) fn connects(&self) -> bool {
        self.bsdf.lobes().has(Lobes::SMOOTH)
    }

    /// See [`crate::path_space::Vertex::light_normal`].
    pub(super) fn light_normal(&self) -> Vec3 {
        if self.bsdf.lobes().has(Lobes::TRANSMISSION) {
            return Vec3::ZERO;
        }
        let s = &self.surface;
        if s.ns.dot(self.ray.d) > 0.0 { -s.ng } else { s.ng }
    }

    /// g: what turns a density per solid angle at `from` into one of this vertex.
    pub(super) fn g(&self, from: Vec3) -> f64 {
        solid_angle_to_area(from, self.p(), self.surface.ng)
    }
}

/// How a path goes through a Dirac lobe.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dirac {
    /// Which lobe.
    pub(super) lobe: Lobes,
    /// What it turns of radiance.
    pub(super) f: Spectrum,
    /// The probability of its choice from the light's side, and from the eye's.
    pub(super) p: [f64; 2],
    /// J of (4).
    pub(super) jacobian: f64,
    /// Index of refraction on the light's side over that on the eye's.
    pub(super) eta: f32,
}

/// A vertex of a path, and how the path goes through it: by a Dirac lobe, or anyhow.
#[derive(Clone, Debug)]
pub(super) struct Turn<'a> {
    pub(super) node: Rc<Node<'a>>,
    pub(super) dirac: Option<Dirac>,
}

/// x₀, and what it emits toward x₁.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source {
    pub(super) end: LightEnd,
    pub(super) le: Spectrum,
}

impl Source {
    /// Lₑ g₀.
    fn arriving(&self, scene: &Scene, x1: Vec3) -> Spectrum {
        match scene.light(self.end.light).is_dirac() {
            // Intensity over d², or irradiance.
            true => self.le,
            false => self.le * self.end.area(x1) as f32,
        }
    }
}

/// xₖ, and where it shows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sensed {
    pub(super) film: Vec2,
    /// The numbers that chose the point of the lens.
    pub(super) lens: Vec2,
    /// From the lens to xₖ₋₁.
    pub(super) ray: Ray,
    pub(super) end: CameraEnd,
}

/// A path.
#[derive(Clone, Debug)]
pub(super) struct Path<'a> {
    /// The number that chose its wavelengths.
    pub(super) u_lambda: f32,
    pub(super) time: f32,
    pub(super) source: Source,
    /// x₁ … xₖ₋₁.
    pub(super) turns: Vec<Turn<'a>>,
    pub(super) sensed: Sensed,
    /// F of (1), but for the factors g that follow.
    pub(super) value: Spectrum,
    /// Π g←ᵢ of (1).
    pub(super) scale: f64,
    /// F, as the sensor sees it.
    pub(super) rgb: [f32; 3],
    /// The scalar of F that chains follow.
    pub(super) f: f64,
    /// q_s of (2) and (3), s = 0 … k; 0 of what can't make the path.
    pub(super) q: Vec<f64>,
}

/// What measures paths.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measure<'a> {
    pub(super) scene: &'a Scene,
    pub(super) lights: &'a LightSelection,
    pub(super) sensor: &'a Sensor,
    /// A of (2).
    pub(super) area: f64,
    /// n of (3).
    pub(super) pixels: f64,
}

impl<'a> Path<'a> {
    /// The path through these vertices, measured; `None` if it carries no light. `NaN` is possible.
    pub(super) fn new(
        measure: &Measure<'a>,
        (u_lambda, time): (f32, f32),
        source: Source,
        turns: Vec<Turn<'a>>,
        sensed: Sensed,
    ) -> Option<Path<'a>> {
        let (value, scale) = (Spectrum::ZERO, 1.0);
        let (rgb, q) = ([0.0; 3], Vec::new());
        let mut path = Path { u_lambda, time, source, turns, sensed, value, scale, rgb, f: 0.0, q };
        path.measure(measure).then_some(path)
    }

    /// Number of inner vertices: its bounces.
    pub(super) fn len(&self) -> usize {
        self.turns.len()
    }

    /// The wavelengths it was begun with.
    pub(super) fn lambda_of_all(&self, scene: &Scene) -> Wavelengths {
        Wavelengths::sample_for(scene.mode, self.u_lambda)
    }

    /// Its wavelengths, the secondary ones ended if it disperses.
    pub(super) fn lambda(&self, scene: &Scene) -> Wavelengths {
        let mut lambda = self.lambda_of_all(scene);
        if self.turns.iter().any(|t| t.node.disperses) {
            lambda.terminate_secondary();
        }
        lambda
    }

    /// From inner vertex `i` (from 0) to the one before it on the light's side, unit.
    pub(super) fn to_light(&self, i: usize) -> Vec3 {
        let p = self.turns[i].node.p();
        match i {
            0 if self.source.end.infinite => -self.source.end.w,
            0 => toward(p, self.source.end.p),
            _ => toward(p, self.turns[i - 1].node.p()),
        }
    }

    /// From inner vertex `i` to the next on the eye's side, unit.
    pub(super) fn to_eye(&self, i: usize) -> Vec3 {
        match self.turns.get(i + 1) {
            Some(next) => toward(self.turns[i].node.p(), next.node.p()),
            None => -self.sensed.ray.d,
        }
    }

    /// (1) to (4); false if the path carries nothing.
    fn measure(&mut self, m: &Measure<'a>) -> bool {
        let n = self.len();
        let Some(x1) = self.turns.first() else { return false };
        let mut f = self.source.arriving(m.scene, x1.node.p());
        let mut scale = 1.0;
        // P→ and P←, of inner vertices and the light.
        let light = &self.source.end;
        let mut forth = Vec::with_capacity(n + 1);
        let mut back = vec![0.0; n + 1];
        forth.push(light.emission);
        forth.push(light.departure.density_at(x1.node.p(), x1.node.surface.ng));
        for i in 0..n {
            let turn = &self.turns[i];
            let node = &turn.node;
            let (value, [p_light, p_eye], j) = match &turn.dirac {
                Some(d) => (d.f, d.p, d.jacobian),
                None => {
                    let (to_eye, to_light) = (self.to_eye(i), self.to_light(i));
                    let (value, (eye, light)) =
                        node.bsdf.eval_pdf(to_eye, to_light, Mode::Radiance, Lobes::ALL);
                    (value, [f64::from(light), f64::from(eye)], 1.0)
                }
            };
            f *= value;
            if f.is_black() {
                return false;
            }
            // Vertex i of `turns` is x of number i + 1.
            let from = node.p();
            if let Some(next) = self.turns.get(i + 1) {
                forth.push(p_light * next.node.g(from) * j);
            }
            back[i] = p_eye
                * match i {
                    0 => light.area(from) * self.share_of_light(m.scene),
                    _ => {
                        let g = self.turns[i - 1].node.g(from);
                        scale *= g;
                        g
                    }
                };
        }
        let last = &self.turns[n - 1].node;
        let seen = self.sensed.end.departure.density_at(last.p(), last.surface.ng);
        (self.value, self.scale) = (f, scale);
        self.rgb = self.seen_as(m.scene, m.sensor, Spectrum::ONE);
        self.f = modulus(self.rgb);
        self.count_ways(m, (&forth, &back), seen);
        self.f != 0.0
    }

    /// A part of F, as the sensor sees it.
    fn seen_as(&self, scene: &Scene, sensor: &Sensor, part: Spectrum) -> [f32; 3] {
        let rgb = sensor.rgb(self.value * part, &self.lambda(scene));
        rgb.map(|v| (f64::from(v) * self.scale) as f32)
    }

    /// The part of F, as the sensor sees it, that belongs to each layer by path.
    pub(super) fn each_layer(
        &self,
        (scene, sensor): (&Scene, &Sensor),
        tracks: &Tracks,
        mut each: impl FnMut(usize, [f32; 3]),
    ) {
        let kinds = |i: usize| {
            let Turn { node, dirac } = &self.turns[i];
            let (ng, ways) = (node.surface.ng, (self.to_eye(i), self.to_light(i)));
            match dirac {
                // As if there were nothing.
                Some(d) if d.lobe.has(Lobes::NULL) => None,
                Some(_) => Some(turning(ng, ways)),
                None => Some(scattering(&node.bsdf, ng, ways, Mode::Radiance)),
            }
        };
        let from_eye = (0..self.len()).rev().filter_map(kinds);
        tracks.each_of_path(self.source.end.light, from_eye, |layer, part| {
            each(layer, self.seen_as(scene, sensor, part));
        });
    }

    /// The probability of this light among those that a ray which left the scene may have met.
    fn share_of_light(&self, scene: &Scene) -> f64 {
        match self.source.end.infinite {
            true => 1.0 / scene.environments.len().max(1) as f64,
            false => 1.0,
        }
    }

    /// (2) and (3).
    fn count_ways(&mut self, m: &Measure, (forth, back): (&[f64], &[f64]), seen: f64) {
        let n = self.len();
        let light = &self.source.end;
        let connects = |i: usize| self.turns[i].dirac.is_none();
        // Products of P← from the end of the eye's subpath on: of vertices i … n - 1.
        let mut eye = vec![1.0; n + 1];
        for i in (0..n).rev() {
            eye[i] = eye[i + 1] * back[i];
        }
        self.q.clear();
        let mut light_side = 1.0;
        for s in 0..=n + 1 {
            // x_{s-1} is the last of the light's, x_s the first of the eye's.
            let joins = (s < 2 || connects(s - 2)) && (s == 0 || s > n || connects(s - 1));
            let q = match s {
                0 if light.hittable => eye[0] / m.area,
                0 => 0.0,
                _ if !joins => 0.0,
                1 if n > 0 => {
                    let x1 = &self.turns[0].node;
                    let asked = light.asked_from(m.scene, m.lights, x1.p(), x1.light_normal());
                    asked * eye[1] / m.area
                }
                s if s <= n => light_side * eye[s] / m.area,
                _ if self.sensed.end.seen && seen > 0.0 => light_side / (seen * m.pixels),
                _ => 0.0,
            };
            self.q.push(q);
            if s <= n {
                light_side *= forth[s];
            }
        }
    }
}

/// The unit vector from `p` to `q`; anything where they are one.
pub(super) fn toward(p: Vec3, q: Vec3) -> Vec3 {
    (q - p).try_normalize().unwrap_or(Vec3::Z)
}
