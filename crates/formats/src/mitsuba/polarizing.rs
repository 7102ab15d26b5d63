//! Materials: polarizers and retarders, Mitsuba 3's `polarizer`, `retarder` and `circular`.

use super::convert::Converter;
use super::document::{Object, SpectrumValue, Value};
use super::textures::Role;
use kaustika_scene::description::{FilterModel, MaterialModel, TextureId};

impl<'a> Converter<'a> {
    pub(super) fn polarizing_filter(&mut self, object: &'a Object) -> MaterialModel {
        let element = match object.plugin.as_str() {
            "retarder" => FilterModel::Retarder {
                theta: self.angle(object, "theta", 0.0, Role::Scalar),
                delta: self.angle(object, "delta", 90.0, Role::Unbounded),
            },
            "circular" => {
                FilterModel::Circular { left_handed: self.boolean(object, "left_handed", false) }
            }
            _ => {
                let theta = self.angle(object, "theta", 0.0, Role::Scalar);
                match self.boolean(object, "polarizing", true) {
                    true => FilterModel::Linear { theta },
                    false => FilterModel::Grey,
                }
            }
        };
        let transmittance = self.texture(object, "transmittance", 1.0, Role::Reflectance);
        MaterialModel::Filter { element, transmittance }
    }

    /// Degrees; `<spectrum value="90"/>` is a number, not a colour.
    fn angle(
        &mut self,
        object: &'a Object,
        name: &'static str,
        default: f32,
        role: Role,
    ) -> TextureId {
        match object.get(name).map(|p| &p.value) {
            Some(Value::Spectrum(SpectrumValue::Uniform(degrees))) => self.out.float(*degrees),
            _ => self.texture(object, name, default, role),
        }
    }
}
