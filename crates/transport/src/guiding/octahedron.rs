//! The sphere unfolded onto the unit square, as an octahedron is (Praun & Hoppe 2003).

use kaustika_math::{Vec2, Vec3};

/// The place of a unit direction.
#[inline]
pub fn to_square(w: Vec3) -> Vec2 {
    let inv = 1.0 / (w.x.abs() + w.y.abs() + w.z.abs());
    let (x, y) = (w.x * inv, w.y * inv);
    let (x, y) = match w.z < 0.0 {
        true => ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y)),
        false => (x, y),
    };
    Vec2::new(0.5 * x + 0.5, 0.5 * y + 0.5)
}

/// The unit direction at a place.
#[inline]
pub fn from_square(p: Vec2) -> Vec3 {
    let (x, y) = (2.0 * p.x - 1.0, 2.0 * p.y - 1.0);
    let z = 1.0 - x.abs() - y.abs();
    let (x, y) = match z < 0.0 {
        true => ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y)),
        false => (x, y),
    };
    Vec3::new(x, y, z).normalize()
}

/// Density per solid angle at `w` of what is uniform on the square.
#[inline]
pub fn density(w: Vec3) -> f32 {
    // An area of the octahedron's face at distance 1/s, seen under the angle of cosine s/√3.
    let s = w.x.abs() + w.y.abs() + w.z.abs();
    1.0 / (4.0 * s * s * s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::warp;

    #[test]
    fn places_and_directions_are_each_others() {
        let mut whole = 0.0f64;
        let n = 400;
        for i in 0..n * n {
            let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            let w = warp::uniform_sphere(u);
            let p = to_square(w);
            assert!((0.0..=1.0).contains(&p.x) && (0.0..=1.0).contains(&p.y));
            assert!((from_square(p) - w).length() < 1e-5, "{w:?}");
            whole += f64::from(density(w)) * 4.0 * std::f64::consts::PI / (n * n) as f64;
        }
        // As exact as midpoints are.
        assert!((whole - 1.0).abs() < 1e-3, "{whole}");
    }

    #[test]
    fn density_is_the_areas_ratio() {
        // Small cells of the square against the solid angle of their corners' triangle pairs.
        for (x, y) in [(0.31, 0.42), (0.9, 0.85), (0.05, 0.5), (0.49, 0.12)] {
            let e = 1e-3;
            let at = |dx: f32, dy: f32| from_square(Vec2::new(x + dx * e, y + dy * e));
            let (a, b) = (at(1.0, 0.0) - at(-1.0, 0.0), at(0.0, 1.0) - at(0.0, -1.0));
            let ratio = a.cross(b).length() / (4.0 * e * e);
            assert!((ratio * density(at(0.0, 0.0)) - 1.0).abs() < 2e-2, "{x} {y}");
        }
    }
}
