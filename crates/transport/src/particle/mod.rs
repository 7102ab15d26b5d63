//! Methods whose paths start at the lights.

mod light_tracing;
pub mod photon_map;

pub use light_tracing::{INFO as LIGHT_INFO, LightParams, LightTracer, parameters};
