//! What sixteen paths ask of a scene at once, where it is frequent and simple: matte
//! surfaces, bare or under a glossy lobe, and a few lamps. Everything else is asked for path by path.
//!
//! Each answer has a scalar twin, which it equals up to rounding.

mod coat;
mod facets;
mod gloss;
mod hits;
mod lamps;
mod plain;
mod principled;

pub use coat::Coat;
pub use gloss::{Gloss, Glosses, SeenGlosses};
pub use hits::{SurfaceHits, Surfaces};
pub use lamps::{LampSamples, Lamps, shadow_end};
pub use plain::Plain;
pub use principled::PrincipledLobes;
