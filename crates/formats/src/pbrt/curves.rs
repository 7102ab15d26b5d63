//! `curve` (pbrt-v4, shapes.cpp): Bézier and B-spline curves of degree 2 and 3.
//!
//! The width goes evenly from segment to segment and, in a segment, from end to end. Curves that
//! follow one another and share all else become one shape: a head of hair is one, not 100,000.

use super::build::Builder;
use super::entity::Entity;
use super::param::ParamType;
use kaustika_math::{Vec3, lerp};
use kaustika_scene::description::{CurveProfile, CurveSegment, Curves, GeometryDesc, ShapeDesc};
use std::sync::Arc;

const PROFILES: [(&str, CurveProfile); 3] = [
    ("flat", CurveProfile::Flat),
    ("cylinder", CurveProfile::Cylinder),
    ("ribbon", CurveProfile::Ribbon),
];
const BASES: [(&str, bool); 2] = [("bezier", false), ("bspline", true)];

impl Builder {
    /// The curve of a `Shape "curve"`.
    pub fn curve(&mut self, e: &mut Entity) -> Option<GeometryDesc> {
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        let width = p.float(diag, "width", 1.0);
        let widths = [p.float(diag, "width0", width), p.float(diag, "width1", width)];
        let degree = p.int(diag, "degree", 3);
        // How often pbrt cuts a segment to trace it faster.
        p.int(diag, "splitdepth", 3);
        let profile = self.word(e, "type", &PROFILES)?;
        let is_spline = self.word(e, "basis", &BASES)?;
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        if !(2..=3).contains(&degree) {
            let message = format!("a curve has degree 2 or 3, not {degree}");
            diag.error(p.place("degree"), message);
            return None;
        }
        if widths.iter().any(|w| *w < 0.0) {
            let message = "the width of a curve must not be negative";
            let name = if p.has("width0") { "width0" } else { "width" };
            diag.error(p.place(name), message);
            return None;
        }
        let degree = degree as usize;
        let normals = p.triples(diag, "N", ParamType::Normal);
        let Some(points) = p.triples(diag, "P", ParamType::Point3) else {
            if !p.has("P") {
                diag.error(e.kind.span, "shape `curve` needs \"point3 P\"");
            }
            p.ignore_rest();
            return None;
        };
        let (step, enough) = match is_spline {
            true => (1, points.len() > degree),
            false => (degree, points.len() > degree && (points.len() - 1).is_multiple_of(degree)),
        };
        if !enough {
            let expected = match is_spline {
                true => format!("at least {}", degree + 1),
                false => format!("{} and {degree} for each further segment", degree + 1),
            };
            let message = format!("{} points for a curve of degree {degree}", points.len());
            diag.error(p.place("P"), message).hint(format!("give {expected}"));
            return None;
        }
        let count = (points.len() - 1 - degree) / step + 1;
        let normals = self.ribbon_normals(e, profile, normals, count)?;
        let segments = (0..count).map(|i| {
            let radius = |k: usize| 0.5 * lerp(k as f32 / count as f32, widths[0], widths[1]);
            segment(&points[i * step..=i * step + degree], is_spline, [radius(i), radius(i + 1)])
        });
        let segments = segments.collect();
        Some(GeometryDesc::Curves(Arc::new(Curves { profile, segments, normals })))
    }

    /// A word out of a list, the first by default.
    fn word<T: Copy>(
        &mut self,
        e: &mut Entity,
        name: &'static str,
        words: &[(&str, T)],
    ) -> Option<T> {
        let diag = &mut self.desc.diagnostics;
        let Some(text) = e.params.string(diag, name) else {
            return (!e.params.has(name)).then_some(words[0].1);
        };
        let found = words.iter().find(|(word, _)| *word == text.text);
        if found.is_none() {
            let known: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
            let message = format!("unknown {name} `{}` of a curve", text.text);
            diag.error(text.span, message).nearest(&text.text, &known);
        }
        found.map(|(_, value)| *value)
    }

    /// Normals at the ends of each segment.
    fn ribbon_normals(
        &mut self,
        e: &Entity,
        profile: CurveProfile,
        normals: Option<Vec<Vec3>>,
        count: usize,
    ) -> Option<Vec<[Vec3; 2]>> {
        let diag = &mut self.desc.diagnostics;
        let place = e.params.place("N");
        match (profile, normals) {
            (CurveProfile::Ribbon, None) => {
                diag.error(place, "a ribbon needs \"normal N\" at the ends of its segments");
                None
            }
            (CurveProfile::Ribbon, Some(n)) if n.len() != count + 1 => {
                let message = format!(
                    "{} normals for a ribbon of {count} segments, not {}",
                    n.len(),
                    count + 1
                );
                diag.error(place, message);
                None
            }
            (CurveProfile::Ribbon, Some(n)) => {
                let unit: Option<Vec<Vec3>> = n.iter().map(|n| n.try_normalize()).collect();
                let Some(unit) = unit else {
                    diag.error(place, "a normal of the ribbon is zero");
                    return None;
                };
                Some(unit.windows(2).map(|w| [w[0], w[1]]).collect())
            }
            (_, Some(_)) => {
                diag.warning(place, "only ribbons have normals, `N` is ignored");
                Some(Vec::new())
            }
            (_, None) => Some(Vec::new()),
        }
    }
}

/// The cubic Bézier segment of `degree + 1` control points.
fn segment(p: &[Vec3], is_spline: bool, radii: [f32; 2]) -> CurveSegment {
    match (p, is_spline) {
        (&[a, b, c], false) => CurveSegment::from_quadratic([a, b, c], radii),
        // A quadratic B-spline is a Bézier curve between the middles of its legs.
        (&[a, b, c], true) => {
            CurveSegment::from_quadratic([a.lerp(b, 0.5), b, b.lerp(c, 0.5)], radii)
        }
        (p, is_spline) => {
            let p: [Vec3; 4] = std::array::from_fn(|i| p[i]);
            let points = match is_spline {
                true => CurveSegment::from_bspline(p, [0.0; 4]).points,
                false => p,
            };
            CurveSegment::from_cubic(points, radii)
        }
    }
}

/// Adds `shape` to the one before if both are curves that share all else; gives it back if not.
pub(super) fn join(before: Option<&mut ShapeDesc>, shape: ShapeDesc) -> Option<ShapeDesc> {
    let Some(before) = before else { return Some(shape) };
    let (GeometryDesc::Curves(all), GeometryDesc::Curves(curves)) =
        (&mut before.geometry, &shape.geometry)
    else {
        return Some(shape);
    };
    let alike = all.profile == curves.profile
        && before.transform == shape.transform
        && before.flip_normals == shape.flip_normals
        && before.material == shape.material
        && (before.alpha, before.interior, before.exterior)
            == (shape.alpha, shape.interior, shape.exterior);
    if !alike {
        return Some(shape);
    }
    let all = Arc::make_mut(all);
    all.segments.extend_from_slice(&curves.segments);
    all.normals.extend_from_slice(&curves.normals);
    None
}
