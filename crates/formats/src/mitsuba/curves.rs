//! Curves with a radius.

use super::convert::Converter;
use super::document::Object;
use crate::curve_file::{ControlPoint, read_curves};
use kaustika_math::Vec3;
use kaustika_scene::description::{CurveProfile, CurveSegment, Curves};
use std::sync::Arc;

impl<'a> Converter<'a> {
    /// The curves of a file, in the space around.
    pub(super) fn curves(&mut self, object: &'a Object) -> Option<Arc<Curves>> {
        let to_world = self.transform(object, "to_world");
        let (path, span) = self.file(object, "filename")?;
        let is_spline = object.plugin == "bsplinecurve";
        let curves = match read_curves(&path, if is_spline { 4 } else { 2 }) {
            Ok(curves) => curves,
            Err(cause) => {
                self.out.diagnostics.error(span, format!("can't read curves {cause}"));
                return None;
            }
        };
        let point = |p: &ControlPoint| to_world.point(Vec3::new(p[0], p[1], p[2]));
        let splines = |c: &Vec<ControlPoint>| -> Vec<CurveSegment> {
            let of = |w: &[ControlPoint]| {
                let (p, r) = (|i: usize| point(&w[i]), |i: usize| w[i][3]);
                CurveSegment::from_bspline([0, 1, 2, 3].map(p), [0, 1, 2, 3].map(r))
            };
            c.windows(4).map(of).collect()
        };
        let lines = |c: &Vec<ControlPoint>| -> Vec<CurveSegment> {
            let of = |w: &[ControlPoint]| {
                CurveSegment::straight([point(&w[0]), point(&w[1])], [w[0][3], w[1][3]])
            };
            c.windows(2).map(of).collect()
        };
        let (profile, segments) = match is_spline {
            true => (CurveProfile::Tube, curves.iter().flat_map(splines).collect()),
            false => (CurveProfile::Spheres, curves.iter().flat_map(lines).collect()),
        };
        Some(Arc::new(Curves { profile, segments, normals: Vec::new() }))
    }
}
