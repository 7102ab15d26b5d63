//! Paths between lights and lens, in the measure in which all ways to make them can be compared.
//!
//! A path is x₀ … xₖ, x₀ on a light and xₖ on the lens (Veach 1997, ch. 8). A *subpath* starts at
//! one of the ends ([`LightEnd`], [`CameraEnd`]) and scatters from surface to surface
//! ([`Subpath`]); where subpaths of both sides meet is the methods' business. Densities are per
//! area, written from the light's side and from the eye's:
//!
//! ```text
//! P→ᵢ = pσ→ᵢ₋₁ g→ᵢ,   g→ᵢ = |cos θᵢ| / |xᵢ - xᵢ₋₁|²,    P←ᵢ likewise from xᵢ₊₁        (1)
//! x₁ seen from parallel light (or a parallel camera):  P→₁ = p_disk |cos θ₁|          (2)
//! ```
//!
//! In a medium densities are per volume, and g→ is σₜ/d²; every segment has in its densities the
//! factor that nothing happened on it ([`Vertex::passing`]), which is the same from both sides. Of
//! media that vary it is left out: no method knows it, and weights may depend on anything that is
//! a function of the path alone.
//!
//! A light at infinity is its direction: the density of x₀ is then per solid angle. So is that of
//! xₖ of a parallel camera. Dirac lobes stand with their probability, in both directions alike.

mod camera_end;
mod chain;
mod classes;
mod connections;
mod direct;
mod guides;
mod light_end;
mod of_pass;
mod passage;
mod splats;
mod subpath;
mod through_media;
mod vertex;

pub use camera_end::{CameraEnd, needs_lens};
pub use chain::Chain;
pub use classes::{Closing, Kinds, Tracks, scattering, turning};
pub use connections::{Connection, Joined, LensConnection, join, to_lens};
pub use direct::Direct;
pub use guides::Guides;
pub use light_end::{LightEnd, emission_table};
pub use of_pass::OfPass;
pub use passage::{Passage, passage};
pub use splats::{Splat, add_splat, each_covered, leave, splat, splat_bands};
pub use subpath::{Departure, Escape, Glow, MAX_PASSAGES, Start, Subpath, Walker};
pub use vertex::{Inside, Vertex};

use kaustika_math::Vec3;

/// g of (1): what turns a density per solid angle at `from` into one per area at the point `p`
/// with normal `n`.
#[inline]
pub fn solid_angle_to_area(from: Vec3, p: Vec3, n: Vec3) -> f64 {
    let d = p - from;
    let d2 = f64::from(d.length_squared());
    if d2 == 0.0 { 0.0 } else { f64::from(n.dot(d).abs()) / (d2 * d2.sqrt()) }
}
