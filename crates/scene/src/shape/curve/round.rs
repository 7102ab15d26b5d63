//! Where a ray enters a round curve. Inner sides are not met: what starts inside leaves freely.
//!
//! **Tubes**: a circle of radius r at right angles to c'. In coordinates whose z runs along the
//! ray, the cone about the tangent at w is met at z = c_z + s where, with D = c', C = c, in the
//! plane xy and |D|² of all three components,
//!
//! ```text
//! (D²-D_z²) s² + 2 D_z (C·D - r r') s + |D|² (C² - r²) - (C·D)² + 2 r r' C·D = 0     (1)
//! w ← w + (s D_z - C·D) / |D|²                                                      (2)
//! ```
//!
//! is repeated until the hit lies on the circle of w (Reshetov & Luebke 2018, "Phantom
//! Ray-Hair Intersector").
//!
//! **Spheres**: swept along a straight line from c₀, r₀ to c₁, r₁; a cone between two of them,
//! with b = c₁ - c₀, ρ = r₀ - r₁, touches the sphere whose centre is c₀ + b y/(b² - ρ²) at y in
//! (0, b² - ρ²)                                                                       (3)

use super::bezier::{Point, dot, jet, sub, xyz};
use super::ray_space::Found;

/// How far a tube's piece reaches beyond its ends, in its parameter: neighbours overlap.
pub(super) const OVERLAP: f64 = 1e-4;
/// Steps of (2) after which it is given up.
const MAX_STEPS: usize = 32;
/// A step of (2) below this ends it.
const LEAST_STEP: f64 = 1e-7;

/// What (2) comes to.
enum Course {
    /// On a circle: z and w.
    Hit(f64, f64),
    Miss,
    /// No end in sight.
    Lost,
}

/// Where the ray enters a tube before `z_max`.
pub(super) fn tube(points: &[Point; 4], z_max: f64) -> Option<Found> {
    let near = if points[0][2] <= points[3][2] { 0.0 } else { 1.0 };
    let course = match follow(points, near) {
        Course::Lost => follow(points, 1.0 - near),
        course => course,
    };
    match course {
        Course::Hit(z, w) if z > 0.0 && z < z_max => Some(Found { z, w: w as f32, v: 0.0 }),
        _ => None,
    }
}

/// Repeats (2) from `w` on.
fn follow(points: &[Point; 4], mut w: f64) -> Course {
    let mut outside = 0;
    for _ in 0..MAX_STEPS {
        let [c, d, _] = jet(points, w);
        let flat = d[0] * d[0] + d[1] * d[1];
        let all = flat + d[2] * d[2];
        let cd = c[0] * d[0] + c[1] * d[1];
        let slope = c[3] * d[3];
        let half_b = d[2] * (cd - slope);
        let k = all * (c[0] * c[0] + c[1] * c[1] - c[3] * c[3]) - cd * cd + 2.0 * slope * cd;
        let discriminant = half_b * half_b - flat * k;
        // The nearer root of (1), without cancellation, or where the ray is nearest to the cone.
        let root = discriminant.max(0.0).sqrt();
        let s = match half_b < 0.0 && discriminant >= 0.0 {
            true => k / (root - half_b),
            false => -(half_b + root) / flat,
        };
        let step = (s * d[2] - cd) / all; // (2)
        if !step.is_finite() {
            return Course::Miss;
        }
        if step.abs() < LEAST_STEP {
            let inside = (-OVERLAP..=1.0 + OVERLAP).contains(&w);
            return if discriminant >= 0.0 && inside {
                Course::Hit(c[2] + s, w)
            } else {
                Course::Miss
            };
        }
        w += step.clamp(-0.5, 0.5);
        // Twice beyond the same end: it will not come back.
        outside = if (-0.25..=1.25).contains(&w) { 0 } else { outside + 1 };
        if outside == 2 {
            return Course::Miss;
        }
        w = w.clamp(-0.5, 1.5);
    }
    Course::Lost
}

/// Where the ray enters spheres swept along a straight piece, before `z_max`.
pub(super) fn spheres(points: &[Point; 4], z_max: f64) -> Option<Found> {
    let (p0, p1) = (points[0], points[3]);
    let b = xyz(sub(p1, p0));
    let (r0, r1) = (p0[3], p1[3]);
    let difference = r0 - r1;
    let b2 = dot(b, b);
    let cone = b2 - difference * difference;
    let mut found: Option<Found> = None;
    let mut meet = |z: f64, w: f64| {
        if z > 0.0 && z < found.as_ref().map_or(z_max, |f| f.z) {
            found = Some(Found { z, w: w as f32, v: 0.0 });
        }
    };
    if cone > 0.0 {
        // The ray's point less c₀, at z = 0.
        let o = [-p0[0], -p0[1], -p0[2]];
        let (m1, m2, m3) = (dot(b, o), b[2], o[2]);
        let k2 = cone - m2 * m2;
        let k1 = cone * m3 - m1 * m2 + m2 * difference * r0;
        let k0 = cone * dot(o, o) - m1 * m1 + 2.0 * m1 * difference * r0 - b2 * r0 * r0;
        let h = k1 * k1 - k0 * k2;
        if h >= 0.0 && k2 != 0.0 {
            let z = -(k1 + h.sqrt()) / k2;
            let y = m1 - r0 * difference + z * m2;
            if y > 0.0 && y < cone {
                meet(z, y / cone); // (3)
            }
        }
    }
    for (p, w) in [(p0, 0.0), (p1, 1.0)] {
        let h = p[3] * p[3] - p[0] * p[0] - p[1] * p[1];
        if h >= 0.0 {
            meet(p[2] - h.sqrt(), w);
        }
    }
    found
}
