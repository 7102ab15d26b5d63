//! `grating`: diffraction by parallel lines. Mitsuba has no such plugin; the name is ours.

use super::convert::Converter;
use super::document::Object;
use super::textures::Role;
use super::values;
use kaustika_scene::description::{GratingDesc, GratingProfileDesc, MaterialModel};

impl<'a> Converter<'a> {
    pub(super) fn grating(&mut self, object: &'a Object) -> MaterialModel {
        let period = self.positive(object, "period", 1000.0);
        MaterialModel::Grating(GratingDesc {
            period,
            profile: self.grating_profile(object),
            reflectance: self.texture(object, "reflectance", 1.0, Role::Reflectance),
            transmittance: self.texture(object, "transmittance", 0.0, Role::Reflectance),
        })
    }

    /// Orders by their `efficiencies`, or a sinusoid of a `depth`.
    fn grating_profile(&mut self, object: &'a Object) -> GratingProfileDesc {
        if let Some((text, span)) = self.string(object, "efficiencies") {
            let read: Result<Vec<f32>, String> = values::tokens(text)
                .into_iter()
                .map(|t| values::number(t).map(|v| v as f32))
                .collect();
            let fault = match &read {
                Err(message) => Some(message.clone()),
                Ok(list) if list.is_empty() || list.iter().any(|e| *e < 0.0) => {
                    Some("efficiencies are one or more numbers, none below 0".into())
                }
                Ok(list) if 2.0 * list.iter().sum::<f32>() - list[0] > 1.0 + 1e-5 => {
                    Some("the efficiencies of all orders, ±m counted twice, exceed 1".into())
                }
                Ok(_) => None,
            };
            match fault {
                Some(message) => {
                    self.out.diagnostics.error(span, message);
                }
                None => return GratingProfileDesc::Efficiencies(read.unwrap_or_default()),
            }
        }
        GratingProfileDesc::Sinusoidal {
            depth: self.positive(object, "depth", 150.0),
            ior: self.relative_ior(object, "bk7"),
        }
    }
}
