//! Subpaths: random walks from either end, over surfaces and through media.

use super::{Guides, Vertex, solid_angle_to_area};
use crate::guiding::{DirectionSample, MixedBsdf};
use crate::method::PassStats;
use crate::roulette::{Roulette, WalkState};
use kaustika_math::{Ray, Vec2, Vec3};
use kaustika_sampling::Sampler;
use kaustika_scene::bsdf::{Bsdf, BsdfSample, Lobes, Mode};
use kaustika_scene::description::MediumId;
use kaustika_scene::{Scene, Surface};
use kaustika_spectra::{Spectrum, Wavelengths};

/// Passages through interfaces between two vertices a walk may make before it is given up.
pub const MAX_PASSAGES: u32 = 1000;

/// How a subpath leaves its end: what gives the density of its first vertex.
#[derive(Clone, Copy, Debug)]
pub enum Departure {
    /// From a point, with this density per solid angle (1).
    Point {
        /// The end.
        p: Vec3,
        /// Per solid angle; a probability where the direction is a Dirac's.
        pdf_w: f64,
    },
    /// Along parallel rays, with this density per area across them (2).
    Parallel {
        /// The rays' direction.
        d: Vec3,
        /// Per area of a plane across the rays.
        pdf_a: f64,
    },
    /// Along one ray: x₁ is a Dirac's, here of density 1.
    Fixed,
}

impl Departure {
    /// Density of the first vertex being on a surface at `p` with normal `n`.
    #[inline]
    pub fn density_at(&self, p: Vec3, n: Vec3) -> f64 {
        match *self {
            Departure::Point { p: from, pdf_w } => pdf_w * solid_angle_to_area(from, p, n),
            Departure::Parallel { d, pdf_a } => pdf_a * f64::from(n.abs_dot(d)),
            Departure::Fixed => 1.0,
        }
    }

    /// Density of the first vertex being `v`, as far as its place decides.
    #[inline]
    pub fn density(&self, v: &Vertex) -> f64 {
        match *self {
            Departure::Point { p, pdf_w } => pdf_w * v.arriving_from(p),
            Departure::Parallel { d, pdf_a } => pdf_a * v.arriving_along(d),
            Departure::Fixed => 1.0,
        }
    }
}

/// The first step of a subpath.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// The ray from the end.
    pub ray: Ray,
    /// It meets nothing beyond.
    pub t_max: f32,
    /// What the ray carries, over the density of its choice.
    pub beta: Spectrum,
    /// The path's wavelengths.
    pub lambda: Wavelengths,
    /// How the density of the first vertex follows.
    pub departure: Departure,
    /// The medium that the ray begins in.
    pub medium: Option<MediumId>,
    /// Width of the beam at the end, for filtering textures.
    pub footprint: f32,
    /// Its growth with distance.
    pub spread: f32,
}

/// The light's or the eye's part of a path, without its end.
#[derive(Debug, Default)]
pub struct Subpath<'a> {
    /// What it met, and behind that what earlier subpaths met: a vertex is too large to be moved, so
    /// each is made in its place.
    places: Vec<Vertex<'a>>,
    /// How many of them it has met.
    len: usize,
    /// The light of the media that it went through.
    pub glows: Vec<Glow>,
}

/// Light that a medium added to a subpath.
#[derive(Clone, Copy, Debug)]
pub struct Glow {
    /// Vertices met before.
    pub depth: usize,
    /// Radiance, over the density of the subpath.
    pub value: Spectrum,
    /// Wavelengths.
    pub lambda: Wavelengths,
}

impl<'a> Subpath<'a> {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.len = 0;
        self.glows.clear();
    }

    /// The place of the next vertex, which has what was there before.
    #[inline]
    pub(super) fn next(&mut self) -> &mut Vertex<'a> {
        if self.places.len() == self.len {
            self.places.push(Vertex::default());
        }
        &mut self.places[self.len]
    }

    /// From now on the next vertex is the last.
    #[inline]
    pub(super) fn keep(&mut self) {
        self.len += 1;
    }
}

impl<'a> std::ops::Deref for Subpath<'a> {
    type Target = [Vertex<'a>];

    fn deref(&self) -> &[Vertex<'a>] {
        &self.places[..self.len]
    }
}

/// A ray that left the scene.
#[derive(Clone, Copy, Debug)]
pub struct Escape {
    /// Where it begins.
    pub o: Vec3,
    /// Its direction.
    pub d: Vec3,
    /// What it carries, over its density.
    pub beta: Spectrum,
    /// Wavelengths.
    pub lambda: Wavelengths,
    /// As [`Vertex::passing`].
    pub passing: f64,
}

/// Makes subpaths.
#[derive(Clone, Copy, Debug)]
pub struct Walker<'a> {
    /// Where.
    pub scene: &'a Scene,
    /// Where subpaths end. Its probabilities depend on a subpath's past, so they are part of
    /// `beta` alone, and of no density.
    pub roulette: Roulette,
    /// From the eye, or from a light.
    pub mode: Mode,
    /// True: the subpath ends where it would not go on by a Dirac lobe.
    pub until_smooth: bool,
    /// The classes by which surfaces scatter the subpath on: all, but for methods that find what
    /// the others do in another way.
    pub lobes: Lobes,
    /// Where the eye's subpaths look for caustics, if that is known.
    pub guides: Option<&'a Guides>,
}

impl<'a> Walker<'a> {
    /// That goes on by whatever surfaces do, unguided.
    pub fn new(scene: &'a Scene, roulette: Roulette, mode: Mode) -> Walker<'a> {
        Walker { scene, roulette, mode, until_smooth: false, lobes: Lobes::ALL, guides: None }
    }

    /// Follows a subpath for at most `most` vertices, into `path`. The ray that left the scene, if
    /// that ended the subpath.
    pub fn walk(
        &self,
        start: &Start,
        most: usize,
        sampler: &mut Sampler,
        path: &mut Subpath<'a>,
        stats: &mut PassStats,
    ) -> Option<Escape> {
        path.clear();
        if self.scene.has_media() {
            return self.walk_through_media(start, most, sampler, path, stats);
        }
        let mut trail = Trail::new(start);
        let mut passages = 0;
        while path.len() < most {
            stats.closest_rays += 1;
            let Some(hit) = self.scene.hit(&trail.ray, trail.t_max) else {
                return Some(trail.escape(1.0));
            };
            let mut surface = self.scene.geometry.surface(&hit, &trail.ray);
            trail.widen(surface.t);
            surface.footprint = trail.footprint;
            let wo = -trail.ray.d;
            let bsdf = &mut path.next().bsdf;
            if !self.scene.bsdf_into(&surface, wo, &mut trail.lambda, bsdf) {
                passages += 1;
                if passages > MAX_PASSAGES {
                    return None;
                }
                (trail.ray, trail.t_max) = (surface.spawn(trail.ray.d), f32::INFINITY);
                continue;
            }
            let u = sampler.get_vertex();
            let scattered = self.scatter(&surface, wo, bsdf, (u[5], Vec2::new(u[2], u[3])));
            trail.place(path, surface, wo, &u);
            path.keep();
            let (scattered, share) = scattered.unzip();
            trail.beta *= share.unwrap_or(1.0);
            self.leave(&mut trail, path, scattered.as_ref(), u[6])?;
            passages = 0;
        }
        None
    }

    /// A direction from a surface as if the BSDF had drawn it, and p_bsdf / p of (1) in [`guides`](Guides).
    pub(crate) fn scatter(
        &self,
        surface: &Surface,
        wo: Vec3,
        bsdf: &Bsdf,
        (uc, u2): (f32, Vec2),
    ) -> Option<(BsdfSample, f32)> {
        let Some(guide) = self.guides.and_then(|guides| guides.at(surface, bsdf, wo)) else {
            return Some((bsdf.sample(wo, uc, u2, self.mode, self.lobes)?, 1.0));
        };
        let mixed = MixedBsdf::new(bsdf, Some(&guide)).of(self.lobes);
        let DirectionSample { bsdf: s, pdf_bsdf } = mixed.sample(wo, uc, u2, self.mode)?;
        let share = pdf_bsdf / s.pdf;
        // What the BSDF never draws has no density here.
        (share > 0.0).then(|| (BsdfSample { weight: s.weight / share, pdf: pdf_bsdf, ..s }, share))
    }

    /// Goes on from the last vertex as `scattered` says, if the subpath survives.
    pub(super) fn leave(
        &self,
        trail: &mut Trail,
        path: &mut Subpath<'a>,
        scattered: Option<&BsdfSample>,
        u: f32,
    ) -> Option<()> {
        let depth = path.len() as u32;
        let v = path.places[..path.len].last_mut()?;
        let s = scattered?;
        (v.pdf, v.pdf_rev) = (f64::from(s.pdf) / v.share, f64::from(s.pdf_rev) / v.share);
        v.delta = s.lobe.has(Lobes::DELTA);
        v.straight = s.lobe.has(Lobes::NULL);
        if self.until_smooth && !v.delta {
            return None;
        }
        let next = v.spawn(s.wi);
        trail.beta *= s.weight;
        trail.throughput *= s.weight;
        trail.eta_scale *= match self.mode {
            Mode::Radiance => s.eta * s.eta,
            Mode::Importance => 1.0,
        };
        if trail.beta.is_black() {
            return None;
        }
        let (beta, eta_scale) = (trail.throughput, trail.eta_scale);
        let q = self.roulette.q(&WalkState { beta, eta_scale, weight: s.weight, depth });
        if q < 1.0 {
            if u >= q {
                return None;
            }
            trail.beta /= q;
            trail.throughput /= q;
        }
        v.onward = Some((next, trail.beta));
        (trail.ray, trail.t_max) = (next, f32::INFINITY);
        Some(())
    }
}

/// A subpath between two vertices.
pub(super) struct Trail {
    pub(super) ray: Ray,
    pub(super) t_max: f32,
    pub(super) beta: Spectrum,
    pub(super) lambda: Wavelengths,
    pub(super) departure: Departure,
    pub(super) footprint: f32,
    spread: f32,
    /// β without what the subpath began with.
    pub(super) throughput: Spectrum,
    eta_scale: f32,
}

impl Trail {
    pub(super) fn new(start: &Start) -> Trail {
        let Start { ray, t_max, beta, lambda, departure, footprint, spread, .. } = *start;
        let (throughput, eta_scale) = (Spectrum::ONE, 1.0);
        Trail { ray, t_max, beta, lambda, departure, footprint, spread, throughput, eta_scale }
    }

    /// After a distance.
    pub(super) fn widen(&mut self, t: f32) {
        self.footprint += self.spread * t;
    }

    pub(super) fn escape(&self, passing: f64) -> Escape {
        let Trail { ray, beta, lambda, .. } = *self;
        Escape { o: ray.o, d: ray.d, beta, lambda, passing }
    }

    /// Makes the subpath's next vertex, where the ray met something, before it scatters; its BSDF is
    /// there already. `u` are the vertex's numbers.
    pub(super) fn place<'p, 'a>(
        &self,
        path: &'p mut Subpath<'a>,
        surface: Surface,
        wo: Vec3,
        u: &[f32; 8],
    ) -> &'p mut Vertex<'a> {
        let last = path.last().map(|v| (v.surface.p, v.pdf));
        let v = path.next();
        v.surface = surface;
        v.wo = wo;
        (v.beta, v.lambda) = (self.beta, self.lambda);
        (v.inside, v.medium) = (None, None);
        v.u = [u[0], u[1], u[4]];
        (v.passing, v.share) = (1.0, 1.0);
        (v.pdf, v.pdf_rev) = (0.0, 0.0);
        (v.delta, v.straight) = (false, false);
        v.onward = None;
        v.arrival = self.arrival(last, v);
        v
    }

    /// Density of a vertex, as far as its place decides; `last` is the one before, and the density of
    /// the direction from there.
    pub(super) fn arrival(&self, last: Option<(Vec3, f64)>, v: &Vertex) -> f64 {
        match last {
            None => self.departure.density(v),
            Some((p, pdf)) => pdf * v.arriving_from(p),
        }
    }
}
