//! Subpaths: random walks over surfaces from either end.

use super::solid_angle_to_area;
use crate::method::PassStats;
use crate::roulette::{Roulette, WalkState};
use kaustika_math::{Ray, Vec2, Vec3};
use kaustika_sampling::Sampler;
use kaustika_scene::bsdf::{Bsdf, Lobes, Mode};
use kaustika_scene::{Scene, Surface};
use kaustika_spectra::{Spectrum, Wavelengths};

/// Passages through interfaces between two vertices a walk may make before it is given up.
const MAX_PASSAGES: u32 = 1000;

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
    /// Density per area of the first vertex being `p` with normal `n`.
    #[inline]
    pub fn density(&self, p: Vec3, n: Vec3) -> f64 {
        match *self {
            Departure::Point { p: from, pdf_w } => pdf_w * solid_angle_to_area(from, p, n),
            Departure::Parallel { d, pdf_a } => pdf_a * f64::from(n.abs_dot(d)),
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
    /// Width of the beam at the end, for filtering textures.
    pub footprint: f32,
    /// Its growth with distance.
    pub spread: f32,
}

/// A surface that a subpath has met.
#[derive(Clone, Debug)]
pub struct Vertex<'a> {
    /// Where.
    pub surface: Surface,
    /// Unit direction to the vertex before.
    pub wo: Vec3,
    /// What arrives, over the density of the subpath.
    pub beta: Spectrum,
    /// Wavelengths, the secondary ones ended if the subpath was dispersed.
    pub lambda: Wavelengths,
    /// Scattering.
    pub bsdf: Bsdf<'a>,
    /// Numbers for a connection from here: two for a point, one for a choice.
    pub u: [f32; 3],
    /// Density per area, from the side of the subpath.
    pub arrival: f64,
    /// Density per solid angle of the direction in which the subpath went on; a Dirac lobe's
    /// probability; 0 if it ended.
    pub pdf: f64,
    /// That of the way back: of `wo` had the path come from there.
    pub pdf_rev: f64,
    /// True if it went on by a Dirac lobe.
    pub delta: bool,
    /// The ray on which it goes on and what that carries, if it does.
    pub onward: Option<(Ray, Spectrum)>,
}

impl Vertex<'_> {
    /// The normal that lights are chosen with: that of the side which the path is on, the same
    /// whether it came from the light or from the eye. None where light passes through.
    #[inline]
    pub fn light_normal(&self) -> Vec3 {
        if self.bsdf.lobes().has(Lobes::TRANSMISSION) {
            return Vec3::ZERO;
        }
        let s = &self.surface;
        if s.ns.dot(self.wo) < 0.0 { -s.ng } else { s.ng }
    }
}

/// The light's or the eye's part of a path, without its end.
pub type Subpath<'a> = Vec<Vertex<'a>>;

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
}

impl<'a> Walker<'a> {
    /// Follows a subpath for at most `most` vertices, into `path`. `each` is called at each
    /// vertex before it scatters. The ray that left the scene, if that ended the subpath.
    pub fn walk(
        &self,
        start: &Start,
        most: usize,
        sampler: &mut Sampler,
        path: &mut Subpath<'a>,
        stats: &mut PassStats,
    ) -> Option<Escape> {
        path.clear();
        let Start { mut ray, mut t_max, mut beta, mut lambda, departure, .. } = *start;
        let mut footprint = start.footprint;
        let (mut throughput, mut eta_scale) = (Spectrum::ONE, 1.0);
        let mut passages = 0;
        while path.len() < most {
            stats.closest_rays += 1;
            let Some(hit) = self.scene.hit(&ray, t_max) else {
                return Some(Escape { o: ray.o, d: ray.d, beta, lambda });
            };
            let mut surface = self.scene.geometry.surface(&hit, &ray);
            footprint += start.spread * surface.t;
            surface.footprint = footprint;
            let wo = -ray.d;
            let mut bsdf = Bsdf::default();
            if !self.scene.bsdf_into(&surface, wo, &mut lambda, &mut bsdf) {
                passages += 1;
                if passages > MAX_PASSAGES {
                    return None;
                }
                (ray, t_max) = (surface.spawn(ray.d), f32::INFINITY);
                continue;
            }
            let arrival = match path.last() {
                None => departure.density(surface.p, surface.ng),
                Some(v) => v.pdf * solid_angle_to_area(v.surface.p, surface.p, surface.ng),
            };
            let u = sampler.get_vertex();
            let scattered = bsdf.sample(wo, u[5], Vec2::new(u[2], u[3]), self.mode, Lobes::ALL);
            let (pdf, pdf_rev, delta) = scattered.map_or((0.0, 0.0, false), |s| {
                (s.pdf.into(), s.pdf_rev.into(), s.lobe.has(Lobes::DELTA))
            });
            let spawned = scattered.map(|s| (s, surface.spawn(s.wi)));
            let u_connect = [u[0], u[1], u[4]];
            path.push(Vertex {
                surface,
                wo,
                beta,
                lambda,
                bsdf,
                u: u_connect,
                arrival,
                pdf,
                pdf_rev,
                delta,
                onward: None,
            });
            let (s, next) = spawned.filter(|_| delta || !self.until_smooth)?;
            beta *= s.weight;
            throughput *= s.weight;
            eta_scale *= match self.mode {
                Mode::Radiance => s.eta * s.eta,
                Mode::Importance => 1.0,
            };
            if beta.is_black() {
                return None;
            }
            let depth = path.len() as u32;
            let state = WalkState { beta: throughput, eta_scale, weight: s.weight, depth };
            let q = self.roulette.q(&state);
            if q < 1.0 {
                if u[6] >= q {
                    return None;
                }
                beta /= q;
                throughput /= q;
            }
            if let Some(v) = path.last_mut() {
                v.onward = Some((next, beta));
            }
            (ray, t_max, passages) = (next, f32::INFINITY, 0);
        }
        None
    }
}
