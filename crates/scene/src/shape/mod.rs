//! Shapes: where rays meet them, what is there, and how to choose points on them.
//!
//! Triangles live in flat arrays and are met through [`kaustika_accel::TriangleBvh`]; the
//! analytic shapes are [`Quadric`]s, intersected in double precision in their own space, pieces of
//! curves ([`CurveStore`]), and cells of signed distance grids ([`SdfStore`]).

mod curve;
mod quadric;
mod sdf;
mod triangle;

pub use curve::{CurveHit, CurveStore, RaySpace};
pub use quadric::{Quadric, QuadricForm, QuadricHit};
pub use sdf::{SdfHit, SdfStore};
pub use triangle::{MeshRange, TriangleStore};

use kaustika_math::Vec3;

/// A point chosen on a shape.
#[derive(Clone, Copy, Debug)]
pub struct ShapeSample {
    /// The point.
    pub p: Vec3,
    /// Bound of its rounding error.
    pub p_error: Vec3,
    /// Geometric normal on the front side, unit.
    pub n: Vec3,
}

/// Density per area at distance² `d2`, seen under `cos` at the surface, as density per solid
/// angle: p_ω = p_A d² / |cos|; infinite at grazing angles becomes 0.
#[inline]
pub fn area_to_solid_angle(pdf_a: f32, d2: f32, cos: f32) -> f32 {
    let pdf_w = pdf_a * d2 / cos.abs();
    if pdf_w.is_finite() { pdf_w } else { 0.0 }
}
