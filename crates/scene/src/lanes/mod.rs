//! What sixteen paths ask of a scene at once, where it is frequent and simple: triangles, matte
//! surfaces, a few lamps. Everything else is asked for path by path.
//!
//! Each answer has a scalar twin, which it equals up to rounding.

mod lamps;
mod matte;
mod triangles;

pub use lamps::{LampSamples, Lamps};
pub use matte::Matte;
pub use triangles::{Surfaces, TriangleHits};
