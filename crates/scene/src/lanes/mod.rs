//! What sixteen paths ask of a scene at once, where it is frequent and simple: matte
//! surfaces, bare or coated, and a few lamps. Everything else is asked for path by path.
//!
//! Each answer has a scalar twin, which it equals up to rounding.

mod coat;
mod hits;
mod lamps;
mod plain;

pub use coat::{Coat, Coats, SeenCoats};
pub use hits::{SurfaceHits, Surfaces};
pub use lamps::{LampSamples, Lamps, shadow_end};
pub use plain::Plain;
