//! Lights that stand in the scene.

use super::convert::Converter;
use super::document::{Kind, Object, ObjectId};
use super::resources::{BitmapPlace, no_bitmap};
use super::shapes::{along, at};
use super::textures::Role;
use kaustika_math::Transform;
use kaustika_scene::description::{EnvironmentLayout, LightDesc, LightKind, MediumId, SpotFalloff};
use kaustika_spectra::ColorSpace;

/// Emitters that Mitsuba knows.
const KNOWN: &[&str] = &[
    "area",
    "point",
    "spot",
    "directional",
    "constant",
    "envmap",
    "projector",
    "sunsky",
    "sun",
    "sky",
    "timed_sunsky",
    "collimated",
    "directionalarea",
];

impl<'a> Converter<'a> {
    pub(super) fn emitter(&mut self, id: ObjectId) {
        let object = self.object(id);
        object.ignore(&["sampling_weight"]);
        let made: Vec<(LightKind, Transform)> = match object.plugin.as_str() {
            // Stands in the scene to be referred to by shapes.
            "area" | "directionalarea" => {
                if object.id.is_empty() {
                    let message = format!("emitter `{}` lights nothing here", object.plugin);
                    self.out
                        .diagnostics
                        .warning(object.span, message)
                        .hint("put it into the `<shape>` that shines");
                }
                return;
            }
            "point" => self.point(object).into_iter().collect(),
            "spot" => self.spot(object).into_iter().collect(),
            "directional" => self.directional(object).into_iter().collect(),
            "constant" => {
                let (radiance, scale) = self.light_spectrum(object, "radiance", 1.0);
                // A constant has no place, but Mitsuba accepts a transform.
                object.ignore(&["to_world"]);
                let kind = LightKind::Constant { radiance, scale, illuminance: None };
                vec![(kind, Transform::IDENTITY)]
            }
            "envmap" => self.envmap(object).into_iter().collect(),
            "projector" => vec![self.projector(object)],
            "sunsky" | "timed_sunsky" | "sun" | "sky" => self.daylight(object),
            "collimated" => {
                self.note_unconnected(object);
                let (power, scale) = self.light_spectrum(object, "power", 1.0);
                vec![(LightKind::Beam { power, scale }, self.transform(object, "to_world"))]
            }
            _ => {
                self.unknown_plugin(object, KNOWN);
                return;
            }
        };
        let medium = self.medium_around(object);
        for (kind, transform) in made {
            let (name, span) = (object.id.clone(), Some(object.span));
            self.out.lights.push(LightDesc { name, kind, transform, medium, span });
        }
        self.finish(id);
    }

    pub(super) fn medium_around(&mut self, object: &'a Object) -> Option<MediumId> {
        self.child(object, Kind::Medium).map(|(_, id)| self.medium(id))
    }

    /// Says which methods find a light that no point can be joined to.
    pub(super) fn note_unconnected(&mut self, object: &Object) {
        let message =
            format!("the light of `{}` can't be found from the camera's side", object.plugin);
        self.out
            .diagnostics
            .note(object.type_span, message)
            .hint("render with `-m light`, `bdpt`, `vcm` or `sppm`; `path` leaves it out");
    }

    /// Either of two ways to place a light.
    fn exclusive(&mut self, object: &'a Object, name: &'static str) -> bool {
        if object.has(name) && object.has("to_world") {
            let message = format!("`{name}` and `to_world` exclude each other");
            self.out.diagnostics.error(object.span, message);
            object.ignore(&["to_world"]);
        }
        object.has(name)
    }

    fn point(&mut self, object: &'a Object) -> Option<(LightKind, Transform)> {
        let (intensity, scale) = self.light_spectrum(object, "intensity", 1.0);
        let transform = match self.exclusive(object, "position") {
            true => at(self.vector(object, "position").unwrap_or([0.0; 3])),
            false => self.transform(object, "to_world"),
        };
        Some((LightKind::Point { intensity, scale, power: None }, transform))
    }

    fn spot(&mut self, object: &'a Object) -> Option<(LightKind, Transform)> {
        let (intensity, scale) = self.light_spectrum(object, "intensity", 1.0);
        let cutoff = self.number(object, "cutoff_angle", 20.0);
        let beam_width = self.number(object, "beam_width", cutoff * 0.75);
        if !(cutoff > 0.0 && cutoff < 180.0 && beam_width <= cutoff) {
            self.out.diagnostics.error(
                object.span,
                format!("the beam ({beam_width}°) must lie in the cone ({cutoff}°)"),
            );
        }
        let texture = object.get("texture").map(|p| self.texture_of(object, p, Role::Reflectance));
        let kind = LightKind::Spot {
            intensity,
            scale,
            power: None,
            cutoff,
            beam_width,
            falloff: SpotFalloff::LinearAngle,
            texture,
        };
        Some((kind, self.transform(object, "to_world")))
    }

    fn directional(&mut self, object: &'a Object) -> Option<(LightKind, Transform)> {
        let (irradiance, scale) = self.light_spectrum(object, "irradiance", 1.0);
        let transform = if self.exclusive(object, "direction") {
            let direction = self.vector(object, "direction")?;
            match along(direction) {
                Some(transform) => transform,
                None => {
                    let span = object.get("direction").map(|p| p.value_span);
                    self.out.diagnostics.error(span, "the direction is zero");
                    return None;
                }
            }
        } else {
            self.transform(object, "to_world")
        };
        Some((LightKind::Directional { irradiance, scale, illuminance: None }, transform))
    }

    fn envmap(&mut self, object: &'a Object) -> Option<(LightKind, Transform)> {
        object.ignore(&["mis_compensation", "cache"]);
        let scale = self.number(object, "scale", 1.0);
        let encoding = self.gamma(object);
        let transform = self.transform(object, "to_world");
        let (path, span) = self.file(object, "filename")?;
        let place = BitmapPlace::Light(self.out.lights.len());
        self.pending.bitmap(path, span, place, encoding);
        let kind = LightKind::Image {
            bitmap: no_bitmap(),
            space: ColorSpace::Srgb,
            layout: EnvironmentLayout::LatLong,
            scale,
            illuminance: None,
        };
        Some((kind, transform))
    }

    fn projector(&mut self, object: &'a Object) -> (LightKind, Transform) {
        let scale = self.number(object, "scale", 1.0);
        let (fov, fov_axis) = self.field_of_view(object);
        let texture = self.texture(object, "irradiance", 1.0, Role::Illuminant);
        let kind = LightKind::Projector { texture, scale, fov, fov_axis };
        (kind, self.transform(object, "to_world"))
    }
}
