//! Incident radiance as learned from paths that went before, and directions drawn after it.
//!
//! ```text
//! p(ω) = α p_bsdf(ω) + (1 - α) p_guide(ω),     p_guide ∝ L̄ᵢ(ω)                          (1)
//! ```
//!
//! A [`Field`] divides space into cells ([`space`]); each holds a distribution of directions:
//! a quadtree over the sphere ([`quadtree`]; Müller, Gross & Novák 2017, "Practical Path Guiding
//! for Efficient Light-Transport Simulation") or a mixture of lobes. Estimates that use (1) divide
//! by all of it, whichever part drew the direction: a wrong field costs time, and never bias,
//! because α is never 0.
//!
//! Fields hold one number for all colours: the mean over the lanes of a [`Spectrum`]. What is
//! learned serves as an adjoint, too: radiance for camera paths, importance for light paths.
//!
//! [`Spectrum`]: kaustika_spectra::Spectrum

mod choice;
mod field;
mod kinds;
mod mixture;
pub mod octahedron;
mod pixels;
mod quadtree;
mod reflected;
mod space;
mod square;
#[cfg(test)]
mod tests;

pub use choice::{Choice, DirectionSample, Guide, MixedBsdf, is_matte};
pub use field::{Cell, Field, Nothing};
pub use kinds::{AnyCell, AnyField, AnyLocal, FieldKind};
pub use mixture::{LocalMixture, Mixture};
pub use pixels::Pixels;
pub use quadtree::Quadtree;
pub use reflected::{Expected, Reflected, ReflectedRecord};
pub use space::{Placed, SpaceTree};
pub use square::{Square, Tree};

use kaustika_math::{Vec2, Vec3};

/// What one direction drawn at one vertex was found to be worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightRecord {
    /// The vertex.
    pub p: Vec3,
    /// The direction, unit, away from the vertex.
    pub w: Vec3,
    /// Density with which it was drawn, per solid angle.
    pub pdf: f32,
    /// Estimate of the radiance (or importance) that arrives from there.
    pub radiance: f32,
    /// Distance to where it comes from; infinite for surroundings.
    pub distance: f32,
    /// Density with which the BSDF alone would have drawn it.
    pub pdf_bsdf: f32,
    /// f |cos θ| times `radiance`: what the estimate's numerator was.
    pub product: f32,
}

impl Placed for LightRecord {
    fn place(&self) -> Vec3 {
        self.p
    }
}

/// A distribution of directions that is learned; one for each cell of space.
pub trait Directions: Clone + Default + Send + Sync {
    /// What it is like at a point of its cell.
    type Local<'a>: LocalDirections
    where
        Self: 'a;

    /// As seen from `p`; `None` as long as nothing is known.
    fn at(&self, p: Vec3) -> Option<Self::Local<'_>>;

    /// As seen from `p`, for a matte surface with the unit normal `n`.
    #[inline]
    fn towards(&self, p: Vec3, n: Vec3) -> Option<Self::Local<'_>> {
        self.at(p).map(|local| local.towards(n))
    }

    /// Takes in records of its cell, in order. What [`Directions::at`] says stays as it is.
    fn learn(&mut self, records: &[LightRecord]);

    /// Takes over what was learned.
    fn refine(&mut self);

    /// Its cell is divided in two, and this is to be the distribution of either: what it counts
    /// was seen by both together.
    fn halve(&mut self) {}
}

/// Incident radiance at a point.
pub trait LocalDirections {
    /// A direction and its density per solid angle.
    fn sample(&self, u: Vec2) -> (Vec3, f32);

    /// Density per solid angle of [`LocalDirections::sample`].
    fn pdf(&self, w: Vec3) -> f32;

    /// Mean incident radiance from the unit direction `w`.
    fn radiance(&self, w: Vec3) -> f32;

    /// ∫ L̄ᵢ max(0, cos θ) dω over the hemisphere about the unit normal `n`.
    fn irradiance(&self, n: Vec3) -> f32;

    /// The same, but that directions are drawn for a diffuse surface with the unit normal `n`:
    /// by radiance times cosine, if the distribution knows how to; a rough product will do. Mean
    /// radiance and irradiance stay as they are.
    fn towards(self, n: Vec3) -> Self
    where
        Self: Sized,
    {
        let _ = n;
        self
    }
}
