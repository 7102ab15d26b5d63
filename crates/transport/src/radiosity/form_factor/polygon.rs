//! Lambert's formula (1760): the form factor from a point to a polygon that nothing hides.
//!
//! ```text
//! F = 1/2π Σₖ γₖ n·(vₖ × vₖ₊₁)/|vₖ × vₖ₊₁|                                          (1)
//! ```
//!
//! vₖ are the directions to the corners, γₖ the angles between them, n the normal at the point. What
//! lies below the horizon is cut off first.

use kaustika_math::Vec3;
use std::f64::consts::PI;

/// A triangle cut at a plane has at most four corners.
type Corners = arrayvec::ArrayVec<[f64; 3], 4>;

/// (1): from the point `p` with normal `n` to a triangle, seen from either side.
pub fn point_to_triangle(p: Vec3, n: Vec3, corners: &[Vec3; 3]) -> f64 {
    let n = wide(n);
    let polygon = above(corners.map(|c| wide(c - p)), n);
    let mut sum = 0.0;
    for (k, &v) in polygon.iter().enumerate() {
        let w = polygon[(k + 1) % polygon.len()];
        let cross = cross(v, w);
        let sine = dot(cross, cross).sqrt();
        if sine > 0.0 {
            sum += sine.atan2(dot(v, w)) * dot(n, cross) / sine;
        }
    }
    (sum / (2.0 * PI)).abs()
}

/// The part of a triangle on the side of `n`.
fn above(corners: [[f64; 3]; 3], n: [f64; 3]) -> Corners {
    let heights = corners.map(|c| dot(c, n));
    let mut polygon = Corners::new();
    for k in 0..3 {
        let next = (k + 1) % 3;
        let (a, b) = (heights[k], heights[next]);
        if a > 0.0 {
            polygon.push(corners[k]);
        }
        if (a > 0.0) != (b > 0.0) {
            let t = a / (a - b);
            polygon.push(std::array::from_fn(|i| {
                corners[k][i] + t * (corners[next][i] - corners[k][i])
            }));
        }
    }
    polygon
}

fn wide(v: Vec3) -> [f64; 3] {
    [v.x, v.y, v.z].map(f64::from)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square above a point: 2/π [ a/√(1+a²) asin(a/√(1+2a²))... ], by symmetry four times the
    /// corner's (Howell's catalogue, B-4): with A = B = half a side over the distance,
    /// F = 4/2π · 2 · A/√(1+A²) atan(A/√(1+A²)).
    #[test]
    fn a_square_above() {
        for half in [0.2f32, 1.0, 5.0] {
            let corner = |x: f32, y: f32| Vec3::new(x * half, y * half, 1.0);
            let [a, b, c, d] =
                [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            let f = |t: [Vec3; 3]| point_to_triangle(Vec3::ZERO, Vec3::Z, &t);
            let found = f([a, b, c]) + f([a, c, d]);
            let x = f64::from(half) / (1.0 + f64::from(half).powi(2)).sqrt();
            let truth = 4.0 / PI * x * x.atan();
            assert!((found - truth).abs() < 1e-6, "{half}: {found} {truth}");
        }
    }

    /// A wall that stands on the horizon: what is below does not count.
    #[test]
    fn what_is_below_the_horizon_is_cut() {
        let tall = |bottom: f32| {
            let corner = |x: f32, z: f32| Vec3::new(x, 1.0, z);
            let (a, b, c, d) =
                (corner(-1.0, bottom), corner(1.0, bottom), corner(1.0, 2.0), corner(-1.0, 2.0));
            let f = |t: [Vec3; 3]| point_to_triangle(Vec3::ZERO, Vec3::Z, &t);
            f([a, b, c]) + f([a, c, d])
        };
        assert!((tall(0.0) - tall(-3.0)).abs() < 1e-6, "{} {}", tall(0.0), tall(-3.0));
        let below =
            [Vec3::new(0.0, 1.0, -1.0), Vec3::new(1.0, 1.0, -1.0), Vec3::new(0.0, 2.0, -1.0)];
        assert_eq!(point_to_triangle(Vec3::ZERO, Vec3::Z, &below), 0.0);
    }
}
