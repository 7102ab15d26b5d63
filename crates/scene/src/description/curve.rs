//! Thin curves: hair, fur, grass, fibres.

use kaustika_math::Vec3;

/// Curves that share a profile, as cubic Bézier segments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curves {
    /// What is swept along them.
    pub profile: CurveProfile,
    /// The segments, in the order of the file.
    pub segments: Vec<CurveSegment>,
    /// Normals at both ends of each segment of a ribbon, unit; empty for other profiles.
    pub normals: Vec<[Vec3; 2]>,
}

/// What is swept along a curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CurveProfile {
    /// A strip that faces whoever looks at it (pbrt's `flat`).
    #[default]
    Flat,
    /// The same strip with the normals of a tube (pbrt's `cylinder`).
    Cylinder,
    /// A strip that faces along given normals (pbrt's `ribbon`).
    Ribbon,
    /// A circle at right angles to the curve, open at the ends (Mitsuba's `bsplinecurve`).
    Tube,
    /// A sphere: straight segments with round joints and ends (Mitsuba's `linearcurve`).
    Spheres,
}

/// A cubic Bézier segment with a radius along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveSegment {
    /// Control points.
    pub points: [Vec3; 4],
    /// Half of the width, in the same basis.
    pub radii: [f32; 4],
}

impl CurveSegment {
    /// A segment of a uniform cubic B-spline, from its four control points and radii (Farin 2001,
    /// "Curves and Surfaces for CAGD", sec. 8.1: knots inserted until the ends are interpolated).
    pub fn from_bspline(points: [Vec3; 4], radii: [f32; 4]) -> CurveSegment {
        let inner = |i: usize, t: f32| {
            (points[i].lerp(points[i + 1], t), kaustika_math::lerp(t, radii[i], radii[i + 1]))
        };
        let mid = |a: (Vec3, f32), b: (Vec3, f32)| (a.0.lerp(b.0, 0.5), 0.5 * (a.1 + b.1));
        let [before, p1, p2, after] =
            [inner(0, 2.0 / 3.0), inner(1, 1.0 / 3.0), inner(1, 2.0 / 3.0), inner(2, 1.0 / 3.0)];
        let (p0, p3) = (mid(before, p1), mid(p2, after));
        let all = [p0, p1, p2, p3];
        CurveSegment { points: all.map(|p| p.0), radii: all.map(|p| p.1) }
    }

    /// A segment of a quadratic Bézier curve; the radius goes evenly from end to end.
    pub fn from_quadratic(p: [Vec3; 3], radii: [f32; 2]) -> CurveSegment {
        let points = [p[0], p[0].lerp(p[1], 2.0 / 3.0), p[2].lerp(p[1], 2.0 / 3.0), p[2]];
        CurveSegment::from_cubic(points, radii)
    }

    /// A segment of a cubic Bézier curve; the radius goes evenly from end to end.
    pub fn from_cubic(points: [Vec3; 4], [r0, r1]: [f32; 2]) -> CurveSegment {
        let radius = |t: f32| kaustika_math::lerp(t, r0, r1);
        CurveSegment { points, radii: [r0, radius(1.0 / 3.0), radius(2.0 / 3.0), r1] }
    }

    /// A straight segment.
    pub fn straight([a, b]: [Vec3; 2], radii: [f32; 2]) -> CurveSegment {
        CurveSegment::from_cubic([a, a.lerp(b, 1.0 / 3.0), a.lerp(b, 2.0 / 3.0), b], radii)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bsplines_keep_their_values_and_slopes() {
        // Uniform cubic B-spline at its knots: (p0 + 4 p1 + p2)/6, slope (p2 - p0)/2.
        let p = [(0.0, 1.0, 2.0), (1.0, 3.0, 2.0), (2.0, -1.0, 5.0), (4.0, 0.0, 1.0)]
            .map(|(x, y, z)| Vec3::new(x, y, z));
        let s = CurveSegment::from_bspline(p, [1.0, 2.0, 3.0, 1.0]);
        assert!((s.points[0] - (p[0] + p[1] * 4.0 + p[2]) / 6.0).length() < 1e-5);
        assert!((s.points[3] - (p[1] + p[2] * 4.0 + p[3]) / 6.0).length() < 1e-5);
        assert!(((s.points[1] - s.points[0]) * 3.0 - (p[2] - p[0]) * 0.5).length() < 1e-5);
        assert!(((s.points[3] - s.points[2]) * 3.0 - (p[3] - p[1]) * 0.5).length() < 1e-5);
        assert!((s.radii[0] - 2.0).abs() < 1e-5 && (s.radii[3] - 2.5).abs() < 1e-5);
    }
}
