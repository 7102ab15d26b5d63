//! Methods whose paths start at the lights.

mod light_tracing;
pub mod photon_map;
mod virtual_lights;

pub use light_tracing::{INFO as LIGHT_INFO, LightParams, LightTracer, parameters};
pub use virtual_lights::{INFO as VPL_INFO, Vpl, VplParams, parameters as vpl_parameters};
