//! What sixteen paths ask of a scene at once, where it is frequent and simple: triangles, matte
//! surfaces, bare or coated, a few lamps. Everything else is asked for path by path.
//!
//! Each answer has a scalar twin, which it equals up to rounding.

mod coat;
mod lamps;
mod plain;
mod triangles;

pub use coat::{Coat, Coats, SeenCoats};
pub use lamps::{LampSamples, Lamps};
pub use plain::Plain;
pub use triangles::{Surfaces, TriangleHits};
