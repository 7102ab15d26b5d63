//! Cameras.

use super::Reader;
use super::json::{Fault, Json};
use super::matrix::Matrix;
use kaustika_math::Transform;
use kaustika_scene::description::{CameraDesc, CameraKind, FilmDesc, FilterChoice, FovAxis, Span};

/// Pixels along the longer side when nobody says how many.
const LONGER_SIDE: f32 = 1280.0;
/// Width over height where the file leaves it to the viewer.
pub(super) const ASPECT: f32 = 16.0 / 9.0;

/// A film of this shape.
pub(super) fn film(aspect: f32) -> FilmDesc {
    let aspect = aspect.clamp(1.0 / 16.0, 16.0);
    let (w, h) = if aspect >= 1.0 {
        (LONGER_SIDE, LONGER_SIDE / aspect)
    } else {
        (LONGER_SIDE * aspect, LONGER_SIDE)
    };
    let resolution = [w.round() as u32, h.round() as u32];
    FilmDesc::new(resolution, FilterChoice::Gaussian { radius: [1.5; 2], sigma: 0.5 })
}

/// A camera with everything but its kind and place left to the defaults.
pub(super) fn camera(
    name: &str,
    kind: CameraKind,
    aspect: f32,
    transform: Transform,
    span: Option<Span>,
) -> CameraDesc {
    CameraDesc { name: name.into(), span, ..CameraDesc::new(kind, transform, film(aspect)) }
}

fn positive(json: &Json, key: &str) -> Result<f32, Fault> {
    let at = json.require(key)?;
    match json.float(key, 0.0)? {
        v if v > 0.0 => Ok(v),
        v => Err(at.fault(format!("expected a number above 0, found {v}"))),
    }
}

impl Reader<'_> {
    /// The camera of a node.
    pub(super) fn camera(
        &mut self,
        json: &Json,
        node: &Json,
        to_world: &Matrix,
    ) -> Result<(), Fault> {
        let ty = json.require("type")?;
        let (kind, aspect) = match ty.text() {
            Some("perspective") => {
                let p = json.require("perspective")?;
                let yfov = positive(&p, "yfov")?;
                if yfov >= std::f32::consts::PI {
                    return Err(p
                        .require("yfov")?
                        .fault("a field of view of half a turn or more")
                        .hint("`yfov` is in radians"));
                }
                let aspect = match p.get("aspectRatio") {
                    Some(_) => positive(&p, "aspectRatio")?,
                    None => ASPECT,
                };
                let kind = CameraKind::Perspective {
                    fov: yfov.to_degrees(),
                    fov_axis: FovAxis::Y,
                    principal_point: [0.0; 2],
                    screen_window: None,
                    lens_radius: 0.0,
                    focus_distance: 1.0,
                    near_clip: p.float("znear", 0.0)?.max(1e-6),
                    far_clip: p.float("zfar", f32::INFINITY)?,
                };
                (kind, aspect)
            }
            Some("orthographic") => {
                let o = json.require("orthographic")?;
                let (x, y) = (o.float("xmag", 1.0)?.abs(), o.float("ymag", 1.0)?.abs());
                if x == 0.0 || y == 0.0 {
                    return Err(o.fault("`xmag` and `ymag` must not be 0"));
                }
                let kind = CameraKind::Orthographic {
                    screen_window: Some([-x, x, -y, y]),
                    unit_axis: FovAxis::Y,
                    lens_radius: 0.0,
                    focus_distance: 1.0,
                    near_clip: o.float("znear", 0.0)?,
                    far_clip: o.float("zfar", f32::INFINITY)?,
                };
                (kind, x / y)
            }
            _ => return Err(ty.fault("expected `perspective` or `orthographic`")),
        };
        let Some(transform) = to_world.observer() else {
            return Err(node.fault("the camera's node has no extent"));
        };
        let name = if node.name().is_empty() { json.name() } else { node.name() };
        let span = self.span(json);
        self.out.cameras.push(camera(name, kind, aspect, transform, span));
        Ok(())
    }
}
