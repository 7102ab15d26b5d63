//! Methods whose paths start at the lights.

mod light_tracing;

pub use light_tracing::{INFO as LIGHT_INFO, LightParams, LightTracer, parameters};
