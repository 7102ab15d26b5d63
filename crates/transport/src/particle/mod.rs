//! Methods whose paths start at the lights.

mod guided_light;
mod light_params;
mod light_tracing;
mod light_trees;
pub mod photon_map;
mod virtual_lights;

pub use guided_light::GuidedLight;
pub use light_params::{LightParams, parameters};
pub use light_tracing::{INFO as LIGHT_INFO, LightTracer};
pub use virtual_lights::{INFO as VPL_INFO, Vpl, VplParams, parameters as vpl_parameters};

use crate::method::Method;

/// The light tracer with these parameters: guided, or with a rule that splits, it grows trees.
///
/// # Errors
/// If what is asked for does not go together.
pub fn make_light(params: LightParams) -> Result<Box<dyn Method>, String> {
    if !params.guiding && params.roulette.survival().is_some() {
        return Ok(Box::new(LightTracer::new(params)));
    }
    if !params.nee {
        return Err(
            "paths that are guided or split are always connected to the lens: leave `nee` \
                    at true, or `guiding` at false and `roulette` at none, throughput or albedo"
                .into(),
        );
    }
    Ok(Box::new(GuidedLight::new(params)))
}
