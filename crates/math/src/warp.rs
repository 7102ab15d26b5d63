//! Maps from the unit square to other domains, with their densities.
//!
//! `u` is uniform in [0,1)². A `pdf` takes what the map returns and is per solid angle or per
//! area as its name says.

use crate::special::{sin_cos_eighth, sin_cos_turn};
use crate::{INV_PI, INV_TWO_PI, Vec2, Vec3, safe_sqrt, sqr};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Uniform in the unit disk, concentric (Shirley & Chiu 1997); density 1/π per area.
#[inline]
pub fn disk(u: Vec2) -> Vec2 {
    let o = u * 2.0 - Vec2::splat(1.0);
    // The larger coordinate is the radius, their ratio the angle from its axis in units of π/4.
    let along_x = o.x.abs() > o.y.abs();
    let (r, other) = if along_x { (o.x, o.y) } else { (o.y, o.x) };
    let (sin, cos) = sin_cos_eighth(if r == 0.0 { 0.0 } else { other / r });
    let (near, far) = (r * cos, r * sin);
    if along_x { Vec2::new(near, far) } else { Vec2::new(far, near) }
}

/// The inverse of [`disk`].
pub fn disk_inverse(p: Vec2) -> Vec2 {
    let r = p.length();
    let mut phi = p.y.atan2(p.x);
    if phi < -FRAC_PI_4 {
        phi += 2.0 * PI;
    }
    let (a, b) = if phi < FRAC_PI_4 {
        (r, phi * r / FRAC_PI_4)
    } else if phi < 3.0 * FRAC_PI_4 {
        (-(phi - FRAC_PI_2) * r / FRAC_PI_4, r)
    } else if phi < 5.0 * FRAC_PI_4 {
        (-r, -(phi - PI) * r / FRAC_PI_4)
    } else {
        ((phi - 3.0 * FRAC_PI_2) * r / FRAC_PI_4, -r)
    };
    Vec2::new(0.5 * (a + 1.0), 0.5 * (b + 1.0))
}

/// Cosine-distributed about +z (Malley's method); density [`cosine_hemisphere_pdf_w`].
#[inline]
pub fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let d = disk(u);
    Vec3::new(d.x, d.y, safe_sqrt(1.0 - d.x * d.x - d.y * d.y))
}

/// cosθ/π, for cosθ ≥ 0.
#[inline]
pub fn cosine_hemisphere_pdf_w(cos_theta: f32) -> f32 {
    cos_theta.max(0.0) * INV_PI
}

/// Uniform on the hemisphere about +z; density 1/(2π).
#[inline]
pub fn uniform_hemisphere(u: Vec2) -> Vec3 {
    let z = u.x;
    let r = safe_sqrt(1.0 - z * z);
    let (s, c) = sin_cos_turn(u.y);
    Vec3::new(r * c, r * s, z)
}

/// 1/(2π).
pub const UNIFORM_HEMISPHERE_PDF_W: f32 = INV_TWO_PI;

/// Uniform on the unit sphere; density 1/(4π).
#[inline]
pub fn uniform_sphere(u: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * u.x;
    let r = safe_sqrt(1.0 - z * z);
    let (s, c) = sin_cos_turn(u.y);
    Vec3::new(r * c, r * s, z)
}

/// 1/(4π).
pub const UNIFORM_SPHERE_PDF_W: f32 = 0.5 * INV_TWO_PI;

/// Uniform in the cone about +z of angles whose `1 - cos` is at most `one_minus_cos_max`;
/// passing that difference, rather than the cosine, keeps thin cones exact.
#[inline]
pub fn uniform_cone(u: Vec2, one_minus_cos_max: f32) -> Vec3 {
    let h = u.x * one_minus_cos_max;
    let z = 1.0 - h;
    let r = safe_sqrt(h * (2.0 - h));
    let (s, c) = sin_cos_turn(u.y);
    Vec3::new(r * c, r * s, z)
}

/// 1/(2π(1 - cosθ_max)).
#[inline]
pub fn uniform_cone_pdf_w(one_minus_cos_max: f32) -> f32 {
    INV_TWO_PI / one_minus_cos_max
}

/// Barycentric weights of a uniform point of a triangle, low distortion (Heitz 2019).
#[inline]
pub fn triangle(u: Vec2) -> [f32; 3] {
    let (b0, b1) = if u.x < u.y {
        let b0 = u.x * 0.5;
        (b0, u.y - b0)
    } else {
        let b1 = u.y * 0.5;
        (u.x - b1, b1)
    };
    [b0, b1, 1.0 - b0 - b1]
}

/// Tent of radius `r` about zero: density (r - |x|)/r².
#[inline]
pub fn tent(u: f32, r: f32) -> f32 {
    if u < 0.5 { r * ((2.0 * u).sqrt() - 1.0) } else { r * (1.0 - (2.0 * (1.0 - u)).sqrt()) }
}

/// Equal-area octahedral map of the unit square to the sphere (Clarberg 2008), as pbrt-v4
/// stores its environment maps.
pub fn equal_area_square_to_sphere(p: Vec2) -> Vec3 {
    let (u, v) = (2.0 * p.x - 1.0, 2.0 * p.y - 1.0);
    let (up, vp) = (u.abs(), v.abs());
    let signed_distance = 1.0 - (up + vp);
    let d = signed_distance.abs();
    let r = 1.0 - d;
    let phi = if r == 0.0 { 1.0 } else { (vp - up) / r + 1.0 } * FRAC_PI_4;
    let z = (1.0 - sqr(r)).copysign(signed_distance);
    let (s, c) = phi.sin_cos();
    let rad = r * safe_sqrt(2.0 - sqr(r));
    Vec3::new(c.copysign(u) * rad, s.copysign(v) * rad, z)
}

/// The inverse of [`equal_area_square_to_sphere`], for a unit direction.
pub fn equal_area_sphere_to_square(d: Vec3) -> Vec2 {
    let (x, y, z) = (d.x.abs(), d.y.abs(), d.z.abs());
    let r = safe_sqrt(1.0 - z);
    let phi = y.atan2(x) * 2.0 * INV_PI;
    let mut v = phi * r;
    let mut u = r - v;
    if d.z < 0.0 {
        (u, v) = (1.0 - v, 1.0 - u);
    }
    Vec2::new((u.copysign(d.x) + 1.0) * 0.5, (v.copysign(d.y) + 1.0) * 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n: usize) -> impl Iterator<Item = Vec2> {
        (0..n * n)
            .map(move |i| Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) * (1.0 / n as f32))
    }

    #[test]
    fn disk_and_octahedron_round_trip() {
        for u in grid(64) {
            assert!((disk_inverse(disk(u)) - u).length() < 1e-5, "{u:?}");
            let d = equal_area_square_to_sphere(u);
            assert!((d.length() - 1.0).abs() < 1e-5);
            assert!((equal_area_sphere_to_square(d) - u).length() < 1e-4, "{u:?} {d:?}");
        }
    }

    #[test]
    fn sphere_maps_have_equal_area() {
        // The mean of each coordinate is 0 and of its square 1/3.
        for map in [uniform_sphere, equal_area_square_to_sphere] {
            let n = 256;
            let mut mean = Vec3::ZERO;
            let mut square = Vec3::ZERO;
            for u in grid(n) {
                let d = map(u);
                mean += d;
                square += d * d;
            }
            let k = 1.0 / (n * n) as f32;
            for axis in 0..3 {
                assert!((mean[axis] * k).abs() < 1e-3);
                assert!((square[axis] * k - 1.0 / 3.0).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn moments_match_densities() {
        let n = 256;
        let k = 1.0 / (n * n) as f32;
        let cos: f32 = grid(n).map(|u| cosine_hemisphere(u).z).sum::<f32>() * k;
        assert!((cos - 2.0 / 3.0).abs() < 1e-3);
        let cone: f32 = grid(n).map(|u| uniform_cone(u, 0.3).z).sum::<f32>() * k;
        assert!((cone - 0.85).abs() < 1e-3);
        let tent2: f32 = grid(n).map(|u| sqr(tent(u.x, 1.5))).sum::<f32>() * k;
        assert!((tent2 - 1.5 * 1.5 / 6.0).abs() < 1e-3);
        let mut b = [0f32; 3];
        grid(n).for_each(|u| {
            let t = triangle(u);
            (0..3).for_each(|i| b[i] += t[i] * k);
        });
        assert!(b.iter().all(|&v| (v - 1.0 / 3.0).abs() < 1e-3), "{b:?}");
    }
}
