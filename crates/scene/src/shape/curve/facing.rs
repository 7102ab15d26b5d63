//! Where a ray meets a strip that faces it (Nakamaru & Ohno 2002, "Ray tracing for curves
//! primitive").
//!
//! With z along the ray the strip is what lies within a radius of the curve's image on z = 0, and
//! within the lines across its ends:
//!
//! ```text
//! c(w)·c'(w) = 0 in the plane,   |c(w)| ≤ r(w),   z = c(w)_z                       (1)
//! ```
//!
//! Where the curve bends it is halved until it is straight for its width.

use super::bezier::{Point, halves, jet, sub, widest};
use super::ray_space::Found;

/// How far a piece reaches beyond the lines across its ends, in radii: neighbours overlap, so that
/// no ray slips between them by rounding.
const OVERLAP: f64 = 1e-3;

/// The nearest hit before `z_max`. `foreshortened(w)` multiplies radii.
pub(super) fn strip(
    points: &[Point; 4],
    depth: u32,
    z_max: f64,
    foreshortened: impl Fn(f64) -> f64,
) -> Option<Found> {
    let mut search = Search { z_max, found: None, foreshortened };
    search.within(points, [0.0, 1.0], depth);
    search.found
}

struct Search<F> {
    z_max: f64,
    found: Option<Found>,
    foreshortened: F,
}

impl<F: Fn(f64) -> f64> Search<F> {
    fn within(&mut self, points: &[Point; 4], [w0, w1]: [f64; 2], depth: u32) {
        if depth == 0 {
            self.straight(points, [w0, w1]);
            return;
        }
        let middle = 0.5 * (w0 + w1);
        let [first, second] = halves(points);
        for (half, range) in [(first, [w0, middle]), (second, [middle, w1])] {
            if self.may_meet(&half) {
                self.within(&half, range, depth - 1);
            }
        }
    }

    /// False if the ray surely passes the box of the control points by.
    fn may_meet(&self, points: &[Point; 4]) -> bool {
        let r = widest(points);
        let extent = |axis: usize| {
            let fold = |f: fn(f64, f64) -> f64| points.iter().map(|p| p[axis]).reduce(f);
            (fold(f64::min).unwrap_or(0.0), fold(f64::max).unwrap_or(0.0))
        };
        let beside = |axis| {
            let (lo, hi) = extent(axis);
            lo > r || hi < -r
        };
        let (near, far) = extent(2);
        !beside(0) && !beside(1) && far > 0.0 && near < self.z_max
    }

    /// A piece that is nearly straight.
    fn straight(&mut self, p: &[Point; 4], [w0, w1]: [f64; 2]) {
        let before = |end: Point, inward: Point| {
            let t = sub(inward, end);
            let along = -(t[0] * end[0] + t[1] * end[1]);
            along < -OVERLAP * end[3] * (t[0] * t[0] + t[1] * t[1]).sqrt()
        };
        if before(p[0], p[1]) || before(p[3], p[2]) {
            return;
        }
        let chord = sub(p[3], p[0]);
        let length2 = chord[0] * chord[0] + chord[1] * chord[1];
        if length2 == 0.0 {
            return;
        }
        // (1) along the chord, then by one step of Newton's.
        let w = (-(p[0][0] * chord[0] + p[0][1] * chord[1]) / length2).clamp(0.0, 1.0);
        let [c, d, dd] = jet(p, w);
        let slope = d[0] * d[0] + d[1] * d[1] + c[0] * dd[0] + c[1] * dd[1];
        let step = if slope > 0.0 { (c[0] * d[0] + c[1] * d[1]) / slope } else { 0.0 };
        let w = (w - step).clamp(0.0, 1.0);
        let [c, d, _] = jet(p, w);
        let distance2 = c[0] * c[0] + c[1] * c[1];
        let whole = w0 + (w1 - w0) * w;
        let r = c[3] * (self.foreshortened)(whole);
        if distance2 > r * r || !(c[2] > 0.0 && c[2] < self.z_max) {
            return;
        }
        // v grows to where n x c' points, n the normal toward the ray's origin.
        let side = c[1] * d[0] - c[0] * d[1];
        let across = if r > 0.0 { distance2.sqrt() / r } else { 0.0 };
        let v = 0.5 + 0.5 * across.copysign(side);
        self.z_max = c[2];
        self.found = Some(Found { z: c[2], w: whole as f32, v });
    }
}
