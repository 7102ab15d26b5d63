//! Makes the parts of paths: vertices by rays, ends by choice.

use super::path::{Dirac, Measure, Node, Sensed, Source, Turn, toward};
use crate::method::PassStats;
use crate::metropolis::Draws;
use crate::metropolis::film::Field;
use crate::path_space::{CameraEnd, Guides, LightEnd, MAX_PASSAGES, Tracks};
use kaustika_math::{ONE_MINUS_EPSILON, Ray, Vec2, Vec3};
use kaustika_scene::bsdf::{Bsdf, BsdfSample, Lobes, Mode};
use kaustika_scene::{LightId, LightSelection, Scene, Segment, Surface};
use kaustika_spectra::{Spectrum, Wavelengths};
use std::rc::Rc;

/// Where a ray ended.
pub(super) enum Met<'a> {
    Surface(Rc<Node<'a>>),
    /// It left the scene.
    Nothing(Ray),
}

/// A direction in which a path goes on from a vertex.
pub(super) struct Onward {
    pub(super) ray: Ray,
    pub(super) dirac: Option<Dirac>,
}

/// Tries of [`Tracer::dirac`] that are spread over a choice's numbers.
const TRIES: u32 = 64;

/// Makes parts of paths.
pub(super) struct Tracer<'a> {
    pub(super) scene: &'a Scene,
    pub(super) lights: &'a LightSelection,
    pub(super) emission: &'a LightSelection,
    pub(super) measure: Measure<'a>,
    pub(super) field: Field,
    /// Where candidates look for caustics, if that is known.
    pub(super) guides: Option<&'a Guides>,
    /// Sorts paths into layers, if there are any.
    pub(super) tracks: Option<Tracks<'a>>,
    pub(super) stats: PassStats,
}

impl<'a> Tracer<'a> {
    /// What a ray meets.
    pub(super) fn meet(&mut self, ray: Ray, t_max: f32, lambda: &Wavelengths) -> Option<Met<'a>> {
        let (mut ray, mut t_max) = (ray, t_max);
        for _ in 0..MAX_PASSAGES {
            self.stats.closest_rays += 1;
            let Some(hit) = self.scene.hit(&ray, t_max) else { return Some(Met::Nothing(ray)) };
            let surface = self.scene.geometry.surface(&hit, &ray);
            let mut after = *lambda;
            let mut bsdf = Bsdf::default();
            if self.scene.bsdf_into(&surface, -ray.d, &mut after, &mut bsdf) {
                let disperses = after.secondary_terminated() && !lambda.secondary_terminated();
                return Some(Met::Surface(Rc::new(Node { surface, bsdf, ray, t_max, disperses })));
            }
            (ray, t_max) = (surface.spawn(ray.d), f32::INFINITY);
        }
        None
    }

    /// The surface that a ray meets, if it meets one.
    pub(super) fn node(
        &mut self,
        ray: Ray,
        t_max: f32,
        lambda: &Wavelengths,
    ) -> Option<Rc<Node<'a>>> {
        match self.meet(ray, t_max, lambda)? {
            Met::Surface(node) => Some(node),
            Met::Nothing(_) => None,
        }
    }

    /// A direction in which a path that came from `wo` goes on.
    pub(super) fn scatter(
        &self,
        node: &Node,
        wo: Vec3,
        mode: Mode,
        draws: &mut Draws,
    ) -> Option<Onward> {
        let (uc, u2) = (draws.f32(), Vec2::new(draws.f32(), draws.f32()));
        let s = node.bsdf.sample(wo, uc, u2, mode, Lobes::ALL)?;
        let dirac = match s.lobe.has(Lobes::DELTA) {
            true => Some(self.dirac_of(node, wo, &s, mode)?),
            false => None,
        };
        Some(Onward { ray: node.surface.spawn(s.wi), dirac })
    }

    /// The direction in which a path that came from `wo` is turned by a Dirac lobe of a class.
    pub(super) fn turn(&self, node: &Node, wo: Vec3, lobe: Lobes, mode: Mode) -> Option<Onward> {
        let s = sample_dirac(node, wo, lobe, None, mode)?;
        let dirac = Some(self.dirac_of(node, wo, &s, mode)?);
        Some(Onward { ray: node.surface.spawn(s.wi), dirac })
    }

    /// What a sampled Dirac lobe is from both sides.
    fn dirac_of(&self, node: &Node, wo: Vec3, s: &BsdfSample, mode: Mode) -> Option<Dirac> {
        let other = sample_dirac(node, s.wi, s.lobe, Some(wo), mode.adjoint())?;
        let (from_light, from_eye) = match mode {
            Mode::Radiance => (&other, s),
            Mode::Importance => (s, &other),
        };
        let value = |s: &BsdfSample| s.weight * s.pdf;
        let (to_light, to_eye) = (from_eye.wi, from_light.wi);
        let ng = node.surface.ng;
        let (f, f_light) = (value(from_eye), value(from_light));
        let lanes = |f: Spectrum| f64::from(f.0.iter().sum::<f32>());
        let jacobian = f64::from(ng.abs_dot(to_eye)) * lanes(f)
            / (f64::from(ng.abs_dot(to_light)) * lanes(f_light));
        let p = [from_light.pdf, from_eye.pdf].map(f64::from);
        let (lobe, eta) = (s.lobe, from_eye.eta);
        jacobian.is_finite().then_some(Dirac { lobe, f, p, jacobian, eta })
    }

    /// A point of the film and the ray from there.
    pub(super) fn see(&self, film: Vec2, lens: Vec2, time: f32) -> (Sensed, f32) {
        let camera = self.scene.camera.sample_we(film, lens, time);
        let end = CameraEnd::new(self.scene, &camera.ray);
        (Sensed { film, lens, ray: camera.ray, end }, camera.t_max)
    }

    /// A vertex asks for the lens.
    pub(super) fn ask_lens(&mut self, node: &Node, lens: Vec2, time: f32) -> Option<Sensed> {
        let c = self.scene.camera.sample_wi(node.p(), lens, time)?;
        let ray = Ray { o: c.p_lens, d: -c.wi, time };
        let inside = self.field.has(c.film);
        (inside && self.open(&Segment { ray: node.surface.spawn_to(c.p_near), t_max: 1.0 }))
            .then(|| Sensed { film: c.film, lens, ray, end: CameraEnd::new(self.scene, &ray) })
    }

    /// A light, and the first vertex that it shines on.
    pub(super) fn emit(
        &mut self,
        lambda: &Wavelengths,
        time: f32,
        draws: &mut Draws,
    ) -> Option<(Source, Rc<Node<'a>>)> {
        let [u, u0, u1, v0, v1] = std::array::from_fn(|_| draws.f32());
        let c = self.emission.sample(Vec3::ZERO, Vec3::ZERO, u, Vec2::new(u0, u1))?;
        let light = self.scene.light(c.light);
        if !light.connects() {
            return None;
        }
        let mut e = light.sample_le(self.scene, c.u, Vec2::new(v0, v1), lambda)?;
        e.ray.time = time;
        if e.le.is_black() {
            return None;
        }
        let end = LightEnd::new(self.scene, self.emission, c.light, e.ray.o, e.n, e.ray.d);
        let node = self.node(e.ray, f32::INFINITY, lambda)?;
        // As a vertex that asks gets it: of a point intensity over d².
        let le = match light.is_dirac() && !end.infinite {
            true => e.le / (node.p() - e.ray.o).length_squared(),
            false => e.le,
        };
        Some((Source { end, le }, node))
    }

    /// A vertex asks for a light.
    pub(super) fn ask(
        &mut self,
        turn: &Turn,
        lambda: &Wavelengths,
        draws: &mut Draws,
    ) -> Option<Source> {
        let [u, u0, u1] = std::array::from_fn(|_| draws.f32());
        let s = &turn.node.surface;
        let normal = turn.node.light_normal();
        let c = self.lights.sample(s.p, normal, u, Vec2::new(u0, u1))?;
        let light = self.scene.light(c.light);
        let l = light.sample_li_in(self.scene, s.p, c.region, c.u, lambda)?;
        if l.le.is_black() || !self.open(&self.scene.shadow_ray(s, &l)) {
            return None;
        }
        let end = LightEnd::new(self.scene, self.emission, c.light, l.p, l.n, -l.wi);
        Some(Source { end, le: l.le })
    }

    /// The light that a vertex met with its ray from `wo`.
    pub(super) fn found(&self, node: &Node, lambda: &Wavelengths) -> Option<Source> {
        let (s, wo) = (&node.surface, -node.ray.d);
        let id = s.light?;
        let le = self.scene.light(id).le(self.scene, s, wo, lambda);
        self.source(id, le, s.p, s.ng, wo)
    }

    /// A light that a ray met which left the scene, the `nth` of them.
    pub(super) fn escaped(&self, ray: &Ray, nth: usize, lambda: &Wavelengths) -> Option<Source> {
        let id = *self.scene.environments.get(nth)?;
        let le = self.scene.light(id).escaped(ray.o, ray.d, lambda).le;
        self.source(id, le, Vec3::ZERO, Vec3::ZERO, -ray.d)
    }

    fn source(&self, id: LightId, le: Spectrum, p: Vec3, n: Vec3, w: Vec3) -> Option<Source> {
        let end = LightEnd::new(self.scene, self.emission, id, p, n, w);
        (!le.is_black()).then_some(Source { end, le })
    }

    /// The same point (or direction) of a light, seen from another vertex.
    pub(super) fn again(
        &mut self,
        end: &LightEnd,
        s: &Surface,
        lambda: &Wavelengths,
    ) -> Option<Source> {
        let light = self.scene.light(end.light);
        if light.is_dirac() {
            let l = light.sample_li_in(self.scene, s.p, None, Vec2::new(0.5, 0.5), lambda)?;
            if l.le.is_black() || !self.open(&self.scene.shadow_ray(s, &l)) {
                return None;
            }
            let end = LightEnd::new(self.scene, self.emission, end.light, l.p, l.n, -l.wi);
            return Some(Source { end, le: l.le });
        }
        if end.infinite {
            return match self.meet(s.spawn(-end.w), f32::INFINITY, lambda)? {
                Met::Nothing(ray) => {
                    let of_it = |id: &LightId| *id == end.light;
                    self.escaped(&ray, self.scene.environments.iter().position(of_it)?, lambda)
                }
                Met::Surface(_) => None,
            };
        }
        let node = self.node(s.spawn(toward(s.p, end.p)), f32::INFINITY, lambda)?;
        let far = (end.p - s.p).length();
        let off = (node.p() - end.p).length();
        if node.surface.light != Some(end.light) || off > 1e-3 * far {
            return None;
        }
        let w = toward(end.p, s.p);
        let le = light.le(self.scene, &node.surface, w, lambda);
        self.source(end.light, le, end.p, end.n, w)
    }

    /// True if nothing stands between two vertices.
    pub(super) fn sees(&mut self, y: &Node, z: &Node) -> bool {
        let target = y.surface.spawn(toward(y.p(), z.p())).o;
        self.open(&Segment { ray: z.surface.spawn_to(target), t_max: 1.0 })
    }

    fn open(&mut self, segment: &Segment) -> bool {
        self.stats.shadow_rays += 1;
        !self.scene.occluded(segment)
    }
}

/// A sample of a Dirac lobe of a class, toward `wi` if that is known.
fn sample_dirac(
    node: &Node,
    wo: Vec3,
    lobe: Lobes,
    wi: Option<Vec3>,
    mode: Mode,
) -> Option<BsdfSample> {
    let spread = (0..TRIES).map(|i| (i as f32 + 0.5) / TRIES as f32);
    let sample = |uc: f32| node.bsdf.sample(wo, uc, Vec2::new(0.5, 0.5), mode, Lobes::ALL);
    [0.0, ONE_MINUS_EPSILON]
        .into_iter()
        .chain(spread)
        .filter_map(sample)
        .find(|s| s.lobe == lobe && wi.is_none_or(|wi| s.wi.dot(wi) > 0.999))
}
