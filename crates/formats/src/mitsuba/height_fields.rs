//! `heightfield`: what bumps look like from afar. Mitsuba has no such material; the name is ours.

use super::convert::Converter;
use super::document::Object;
use super::textures::Role;
use kaustika_scene::description::MaterialModel;

impl<'a> Converter<'a> {
    pub(super) fn height_field(&mut self, object: &'a Object) -> MaterialModel {
        MaterialModel::HeightField {
            heights: self.texture(object, "heights", 0.0, Role::Scalar),
            scale: self.number(object, "scale", 1.0),
            reflectance: self.texture(object, "reflectance", 1.0, Role::Reflectance),
        }
    }
}
