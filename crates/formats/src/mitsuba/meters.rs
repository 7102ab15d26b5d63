//! Sensors that measure: `radiancemeter`, `irradiancemeter` on a shape, `distant`; `batch`, several
//! sensors on one film. `fluxmeter`, which Mitsuba has not, stands on a shape and gives the flux that
//! it receives: its irradiance times its area.

use super::convert::{Converter, vec3};
use super::document::{Kind, Object, Value};
use super::shapes::{along, at};
use kaustika_math::Transform;
use kaustika_scene::description::{CameraKind, MeterTarget};

/// What a sensor measures, and its place; `None` if it has a fault.
type Made = Option<(CameraKind, Transform)>;

impl<'a> Converter<'a> {
    /// `None` if it is no meter.
    pub(super) fn meter(&mut self, object: &'a Object, shape: Option<usize>) -> Option<Made> {
        let plugin = object.plugin.as_str();
        Some(match (plugin, shape) {
            ("irradiancemeter" | "fluxmeter", Some(shape)) => {
                if object.get("to_world").is_some() {
                    let message = format!("a `{plugin}` stands where its shape stands");
                    self.out.diagnostics.error(object.span, message).hint("remove `to_world`");
                }
                let kind = CameraKind::Irradiance { shape, flux: plugin == "fluxmeter" };
                Some((kind, Transform::IDENTITY))
            }
            ("irradiancemeter" | "fluxmeter", None) => {
                let message = format!("sensor `{plugin}` measures on a shape");
                self.out.diagnostics.error(object.span, message).hint("put it into a `<shape>`");
                None
            }
            (_, Some(_)) => {
                let message = format!("sensor `{plugin}` can't stand on a shape");
                self.out.diagnostics.error(object.type_span, message);
                None
            }
            ("radiancemeter", None) => self.aim(object, true).map(|t| (CameraKind::Radiance, t)),
            ("distant", None) => {
                let target = self.target_of(object);
                let kind = target.map(|target| CameraKind::Distant { target });
                kind.and_then(|kind| Some((kind, self.aim(object, false)?)))
            }
            ("batch", None) => {
                let children = self.children(object, Kind::Sensor);
                let made: Vec<_> = children
                    .iter()
                    .map(|(_, id)| self.guarded(*id, |c| c.camera(*id, None)))
                    .collect();
                let cameras: Vec<_> = made.into_iter().flatten().flatten().collect();
                if cameras.is_empty() {
                    self.out.diagnostics.error(object.span, "a batch without sensors");
                }
                (!cameras.is_empty())
                    .then_some((CameraKind::Batch { cameras }, Transform::IDENTITY))
            }
            _ => return None,
        })
    }

    /// Where a meter stands and whereto it looks: `to_world`, or `direction`, with `origin`.
    fn aim(&mut self, object: &'a Object, with_origin: bool) -> Option<Transform> {
        if object.has("to_world") {
            if !with_origin && object.has("direction") {
                let message = "`direction` and `to_world` exclude each other";
                self.out.diagnostics.error(object.span, message);
            }
            object.ignore(&["direction", "origin"]);
            return Some(self.transform(object, "to_world"));
        }
        if with_origin && object.has("direction") != object.has("origin") {
            let message = "a `radiancemeter` needs both `origin` and `direction`";
            self.out.diagnostics.error(object.span, message);
            object.ignore(&["direction", "origin"]);
            return None;
        }
        let Some(p) = object.get("direction") else { return Some(Transform::IDENTITY) };
        let direction = self.vector(object, "direction")?;
        let Some(frame) = along(direction) else {
            self.out.diagnostics.error(p.value_span, "the direction is zero");
            return None;
        };
        let origin = if with_origin { self.vector(object, "origin")? } else { [0.0; 3] };
        Some(at(origin) * frame)
    }

    fn target_of(&mut self, object: &'a Object) -> Option<MeterTarget> {
        let Some(p) = object.get("target") else { return Some(MeterTarget::Scene) };
        if let Value::Vector(point) = p.value {
            return Some(MeterTarget::Point(vec3(point)));
        }
        let shape = self.target(p).map(|id| (id, self.object(id)));
        match shape {
            Some((id, shape)) if shape.plugin == "rectangle" => {
                let transform = self.transform(shape, "to_world");
                shape.ignore(&["flip_normals"]);
                self.finish(id);
                Some(MeterTarget::Rectangle(transform))
            }
            _ => {
                self.wrong_type(object, p, "a point or a rectangle");
                None
            }
        }
    }
}
