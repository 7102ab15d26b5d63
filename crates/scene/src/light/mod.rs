//! Lights: the three events of light transport, each with the densities that MIS needs.
//!
//! * [`Light::sample_li`]: from a point of the scene, a direction to the light.
//! * [`Light::sample_le`]: a ray that leaves the light.
//! * [`Light::le`] and [`Light::escaped`]: a ray found the light by itself.
//!
//! Which light is the question of [`LightSelection`]; which of its points is the light's own.

mod area;
mod beam;
mod bounds;
mod build;
mod bvh;
mod cone;
mod daylight;
mod environment;
mod learned;
mod pack;
mod pair;
mod point;
mod portal;
mod projector;
mod selection;
mod sky;
mod sun;
mod texels;

pub use area::{AreaLight, AreaShape};
pub use beam::{Beam, NormalArea};
pub use environment::Environment;
pub use learned::{LearnedLights, ShadingPoint};
pub use point::{Directional, Goniometric, Point, Projection, Spot};
pub use projector::Projector;
pub(crate) use selection::FEW_LIGHTS;
pub use selection::{LightChoice, LightSelection, LightSelectionKind, mean_power};

use crate::Scene;
use crate::surface::Surface;
use bvh::LightBvh;
use kaustika_math::{Ray, Vec2, Vec3};
use kaustika_spectra::{Spectrum, Wavelengths};

/// A direction from a scene point to a light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit direction to the light.
    pub wi: Vec3,
    /// The point on the light; for lights at infinity a point outside the scene.
    pub p: Vec3,
    /// Bound of its rounding error; zero for lights without surface.
    pub p_error: Vec3,
    /// Normal of the light there; zero for lights without surface.
    pub n: Vec3,
    /// Density of `wi` per solid angle; 1 for delta lights.
    pub pdf_w: f32,
    /// Radiance arriving along `wi` if nothing is in between; for delta lights intensity/d² or
    /// irradiance.
    pub le: Spectrum,
    /// True if BSDF sampling can never find it.
    pub delta: bool,
}

/// What a ray that left the scene finds of a light.
#[derive(Clone, Copy, Debug)]
pub struct Escaped {
    /// Radiance arriving along the ray.
    pub le: Spectrum,
    /// Density per solid angle of [`Light::sample_li`] choosing its direction.
    pub pdf_li: f32,
    /// The region of the environment that the direction lies in.
    pub region: u32,
}

/// A ray leaving a light.
#[derive(Clone, Copy, Debug)]
pub struct EmittedRay {
    /// The ray.
    pub ray: Ray,
    /// Emitted radiance (or intensity, irradiance) along it.
    pub le: Spectrum,
    /// Normal at the origin; the ray's direction for lights without surface.
    pub n: Vec3,
    /// Density of the origin per area (1 where it is a point).
    pub pdf_a: f32,
    /// Density of the direction per solid angle (1 where it is fixed).
    pub pdf_w: f32,
    /// |cos| between `n` and the ray: flux = le · cos / (pdf_a pdf_w).
    pub cos: f32,
}

/// The closed set of lights.
#[derive(Debug)]
pub enum Light {
    /// An emitting surface.
    Area(AreaLight),
    /// A point.
    Point(Point),
    /// A cone.
    Spot(Spot),
    /// Parallel rays.
    Directional(Directional),
    /// Everything around the scene.
    Environment(Environment),
    /// A projected picture.
    Projection(Projection),
    /// A point with a measured or painted distribution.
    Goniometric(Goniometric),
    /// A projected texture.
    Projector(Projector),
    /// A ray.
    Beam(Beam),
    /// A surface that shines along its normals alone.
    NormalArea(NormalArea),
}

macro_rules! each_light {
    ($self:ident, $l:ident => $e:expr) => {
        match $self {
            Light::Area($l) => $e,
            Light::Point($l) => $e,
            Light::Spot($l) => $e,
            Light::Directional($l) => $e,
            Light::Environment($l) => $e,
            Light::Projection($l) => $e,
            Light::Goniometric($l) => $e,
            Light::Projector($l) => $e,
            Light::Beam($l) => $e,
            Light::NormalArea($l) => $e,
        }
    };
}

impl Light {
    /// A direction from `from` to the light.
    #[inline]
    pub fn sample_li(
        &self,
        scene: &Scene,
        from: Vec3,
        u: Vec2,
        lambda: &Wavelengths,
    ) -> Option<LightSample> {
        self.sample_li_in(scene, from, None, u, lambda)
    }

    /// As [`Light::sample_li`], of an environment's region if one is given; the density is then
    /// that within the region.
    #[inline]
    pub fn sample_li_in(
        &self,
        scene: &Scene,
        from: Vec3,
        region: Option<u32>,
        u: Vec2,
        lambda: &Wavelengths,
    ) -> Option<LightSample> {
        match self {
            Light::Area(l) => l.sample_li(scene, from, u, lambda),
            Light::Point(l) => l.sample_li(scene, from, u, lambda),
            Light::Spot(l) => l.sample_li(scene, from, u, lambda),
            Light::Directional(l) => l.sample_li(scene, from, u, lambda),
            Light::Environment(l) => l.sample_li(scene, from, region, u, lambda),
            Light::Projection(l) => l.sample_li(scene, from, u, lambda),
            Light::Goniometric(l) => l.sample_li(scene, from, u, lambda),
            Light::Projector(l) => l.sample_li(scene, from, u, lambda),
            Light::Beam(_) | Light::NormalArea(_) => None,
        }
    }

    /// A ray that leaves the light.
    pub fn sample_le(
        &self,
        scene: &Scene,
        u: Vec2,
        v: Vec2,
        lambda: &Wavelengths,
    ) -> Option<EmittedRay> {
        each_light!(self, l => l.sample_le(scene, u, v, lambda))
    }

    /// Densities (per area, per solid angle) of [`Light::sample_le`] choosing the ray that
    /// leaves the point `p` with normal `n` along `w`; zero where it is a Dirac's.
    pub fn pdf_le(&self, scene: &Scene, p: Vec3, n: Vec3, w: Vec3) -> (f32, f32) {
        each_light!(self, l => l.pdf_le(scene, p, n, w))
    }

    /// Emitted flux, W, summed over the lanes of the given wavelengths (an estimate for
    /// choosing lights; lights at infinity count what crosses the scene's disk).
    pub fn power(&self, scene: &Scene, lambda: &Wavelengths) -> Spectrum {
        each_light!(self, l => l.power(scene, lambda))
    }

    /// True if a path from the camera can't find it by itself.
    pub fn is_delta(&self) -> bool {
        match self {
            Light::Area(l) => l.unseen,
            _ => self.is_dirac(),
        }
    }

    /// True if its points or its directions are Dirac's.
    pub fn is_dirac(&self) -> bool {
        !matches!(self, Light::Area(_) | Light::Environment(_))
    }

    /// True if a point of the scene can be joined to it: false where a point of the light shines
    /// in one direction, which is the point's with probability 0.
    pub fn connects(&self) -> bool {
        !matches!(self, Light::Beam(_) | Light::NormalArea(_))
    }

    /// True if it is at infinity.
    pub fn is_infinite(&self) -> bool {
        matches!(self, Light::Environment(_) | Light::Directional(_))
    }

    /// Radiance leaving the surface `s` of this light along `w`.
    #[inline]
    pub fn le(&self, scene: &Scene, s: &Surface, w: Vec3, lambda: &Wavelengths) -> Spectrum {
        match self {
            Light::Area(l) => l.le(scene, s, w, lambda),
            _ => Spectrum::ZERO,
        }
    }

    /// What a ray from `from` along `wi` that left the scene finds of this light.
    #[inline]
    pub fn escaped(&self, from: Vec3, wi: Vec3, lambda: &Wavelengths) -> Escaped {
        match self {
            Light::Environment(l) => l.escaped(from, wi, lambda),
            _ => Escaped { le: Spectrum::ZERO, pdf_li: 0.0, region: 0 },
        }
    }

    /// Density per solid angle of [`Light::sample_li`] from `from` choosing the direction `wi`
    /// in which `s` was met.
    #[inline]
    pub fn pdf_li(&self, scene: &Scene, from: Vec3, s: &Surface, wi: Vec3) -> f32 {
        self.pdf_li_at(scene, from, s.p, s.ng, wi)
    }

    /// As [`Light::pdf_li`], of the point `p` with normal `ng`.
    #[inline]
    pub fn pdf_li_at(&self, scene: &Scene, from: Vec3, p: Vec3, ng: Vec3, wi: Vec3) -> f32 {
        match self {
            Light::Area(l) => l.pdf_li(scene, from, p, ng, wi),
            _ => 0.0,
        }
    }
}
