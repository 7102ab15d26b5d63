//! Lights of KHR_lights_punctual. Candela and lux stand as they are for W/sr and W/m².

use super::Reader;
use super::json::{Fault, Json};
use super::matrix::Matrix;
use kaustika_scene::description::{LightDesc, LightKind, SpotFalloff};
use kaustika_spectra::{ColorSpace, SpectrumDesc};
use std::f32::consts::FRAC_PI_4;

impl Reader<'_> {
    /// The light of a node.
    pub(super) fn light(
        &mut self,
        json: &Json,
        node: &Json,
        to_world: &Matrix,
    ) -> Result<(), Fault> {
        let rgb = json.floats("color", [1.0; 3])?;
        let color = SpectrumDesc::Rgb { rgb, space: ColorSpace::Srgb };
        let scale = json.float("intensity", 1.0)?;
        if scale < 0.0 || rgb.iter().any(|v| *v < 0.0) {
            return Err(json.fault("a light of negative colour or intensity"));
        }
        let ty = json.require("type")?;
        let kind = match ty.text() {
            Some("point") => LightKind::Point { intensity: color, scale, power: None },
            Some("directional") => {
                LightKind::Directional { irradiance: color, scale, illuminance: None }
            }
            Some("spot") => {
                let spot = json.require("spot")?;
                let outer = spot.float("outerConeAngle", FRAC_PI_4)?;
                let inner = spot.float("innerConeAngle", 0.0)?;
                if !(0.0..outer).contains(&inner) || outer > std::f32::consts::FRAC_PI_2 + 1e-4 {
                    return Err(spot
                        .fault(format!("cone angles {inner} (inner) and {outer} (outer)"))
                        .hint("0 <= inner < outer <= π/2, in radians"));
                }
                LightKind::Spot {
                    intensity: color,
                    scale,
                    power: None,
                    cutoff: outer.to_degrees(),
                    beam_width: inner.to_degrees(),
                    falloff: SpotFalloff::SquaredLinearCosine,
                    texture: None,
                }
            }
            _ => return Err(ty.fault("expected `point`, `spot` or `directional`")),
        };
        let Some(transform) = to_world.observer() else {
            return Err(node.fault("the light's node has no extent"));
        };
        let name = if node.name().is_empty() { json.name() } else { node.name() };
        let span = self.span(json);
        self.out.lights.push(LightDesc { name: name.into(), kind, transform, medium: None, span });
        Ok(())
    }
}
