//! The surface where a ray met a curve.
//!
//! ```text
//! strips: n ⊥ c' toward the ray's origin; turned by θ = π (v - ½) about c' for `cylinder`     (1)
//! tubes:  p = c + ρ,  |ρ| = r,  n ∝ (|c'|² - ρ·c'') ρ - r r' c'                               (2)
//! ```
//!
//! v grows along n x c', so that x = c', y, z = n are right-handed, and 2v - 1 is the offset h of
//! a fibre's cross section (Marschner et al. 2003). pbrt-v4 has v the other way around and its
//! `cylinder` bent inward, since its n points away from the ray's origin.

use super::bezier::{Point, cross, dot, jet, unit, xyz};
use super::ray_space::{Found, RaySpace};
use super::{CurveHit, CurvePiece, CurveSet, CurveStore};
use crate::description::CurveProfile;
use crate::surface::Surface;
use kaustika_math::{Ray, Vec2, Vec3, gamma};
use std::f64::consts::{PI, TAU};

impl CurvePiece {
    fn jet(&self, w: f32) -> [Point; 3] {
        jet(&self.points.map(|p| p.map(f64::from)), f64::from(w))
    }

    /// Turns about a tube at which it was met.
    pub(super) fn turns(&self, space: &RaySpace, hit: &Found) -> f64 {
        let [c, d, _] = self.jet(hit.w);
        turns(xyz(c), self.direction(d), space.at(hit.z))
    }
}

impl CurveSet {
    /// Normal of a ribbon at u, unit: at an even angle from end to end.
    pub(super) fn ribbon_normal(&self, segment: u32, u: f32) -> Vec3 {
        let [a, b] = self.normals[segment as usize];
        let angle = a.dot(b).clamp(-1.0, 1.0).acos();
        let sin = angle.sin();
        if sin < 1e-6 {
            return a;
        }
        a * (((1.0 - u) * angle).sin() / sin) + b * ((u * angle).sin() / sin)
    }
}

impl CurveStore {
    /// The surface where `ray`, in the curve's group, met piece `piece`; `number` is its own in
    /// the scene's list of analytic shapes.
    pub fn surface(&self, (piece, number): (u32, u32), hit: &CurveHit, ray: &Ray) -> Surface {
        let p = &self.pieces[piece as usize];
        let set = &self.sets[p.set as usize];
        let [c, d, dd] = p.jet(hit.w);
        let tangent = p.direction(d);
        let u = p.u_at(hit.w).clamp(0.0, 1.0);
        let along = (p.segment as f32 + u) / set.segments as f32;
        let (at, p_error, n, uv) = match set.profile {
            CurveProfile::Flat | CurveProfile::Cylinder | CurveProfile::Ribbon => {
                let toward = [-ray.d.x, -ray.d.y, -ray.d.z].map(f64::from);
                let mut n = perpendicular(toward, tangent);
                let mut v = hit.v;
                if set.profile == CurveProfile::Cylinder {
                    let across = cross(n, tangent);
                    let (s, c) = (PI * (f64::from(v) - 0.5)).sin_cos(); // (1)
                    n = std::array::from_fn(|i| n[i] * c + across[i] * s);
                } else if set.profile == CurveProfile::Ribbon {
                    let given = set.ribbon_normal(p.segment, u);
                    let given = perpendicular([given.x, given.y, given.z].map(f64::from), tangent);
                    // v grows along n x c' of the normal that is given.
                    v = if dot(given, n) < 0.0 { 1.0 - v } else { v };
                    n = given;
                }
                // The strip turns with whoever looks at it: rays start beyond its width.
                let width = Vec3::splat((2.0 * c[3]) as f32);
                (ray.at(hit.t), width, n, Vec2::new(u, v))
            }
            CurveProfile::Tube => {
                let outward = around(tangent, TAU * f64::from(hit.v));
                let rho = outward.map(|v| v * c[3]);
                let (stretch, slope) = (dot(xyz(d), xyz(d)) - dot(rho, xyz(dd)), c[3] * d[3]);
                let n = [0, 1, 2].map(|i| stretch * rho[i] - slope * d[i]); // (2)
                let at = vec3([0, 1, 2].map(|i| c[i] + rho[i]));
                (at, rounding(at, c[3]), unit(n).unwrap_or(outward), Vec2::new(hit.v, along))
            }
            CurveProfile::Spheres => {
                let o = [ray.o.x, ray.o.y, ray.o.z].map(f64::from);
                let dir = [ray.d.x, ray.d.y, ray.d.z].map(f64::from);
                let rho = [0, 1, 2].map(|i| o[i] + f64::from(hit.t) * dir[i] - c[i]);
                let n = unit(rho).unwrap_or(tangent);
                let at = vec3([0, 1, 2].map(|i| c[i] + n[i] * c[3]));
                let turns = turns(xyz(c), tangent, [0, 1, 2].map(|i| c[i] + n[i]));
                (at, rounding(at, c[3]), n, Vec2::new(turns as f32, along))
            }
        };
        let ng = vec3(n).normalize();
        let ng = if set.flip { -ng } else { ng };
        Surface {
            p: at,
            p_error,
            t: hit.t,
            ng,
            ns: ng,
            uv,
            footprint: 0.0,
            shape: set.shape,
            triangle: u32::MAX,
            analytic: number,
            instance: None,
            barycentrics: Vec2::ZERO,
            light: None,
            time: ray.time,
        }
    }

    /// ∂p/∂u and ∂p/∂v where the surface of a piece has these uv and this normal.
    pub fn tangents(&self, piece: u32, uv: Vec2, ns: Vec3) -> (Vec3, Vec3) {
        let p = &self.pieces[piece as usize];
        let set = &self.sets[p.set as usize];
        let n = if set.flip { -ns } else { ns };
        let is_strip = !matches!(set.profile, CurveProfile::Tube | CurveProfile::Spheres);
        let u = match is_strip {
            true => uv.x,
            false => uv.y * set.segments as f32 - p.segment as f32,
        };
        let [c, d, _] = p.jet((u - p.u[0]) / (p.u[1] - p.u[0]));
        let tangent = vec3(p.direction(d));
        let speed = vec3(xyz(d)).length().max(f32::MIN_POSITIVE) / (p.u[1] - p.u[0]);
        let (along, radius) = (tangent * speed, c[3] as f32);
        match is_strip {
            true => (along, n.cross(tangent) * (2.0 * radius)),
            false => {
                let around = tangent.cross(n) * (2.0 * std::f32::consts::PI * radius);
                let along = n.cross(tangent.cross(n)) * (speed * set.segments as f32);
                (around, along)
            }
        }
    }
}

/// Bound of the error of a point of a round curve, computed in double precision from control
/// points in single precision.
fn rounding(p: Vec3, radius: f64) -> Vec3 {
    (p.abs() + Vec3::splat(radius as f32)) * gamma(5)
}

/// The unit vector across `axis` nearest to `v`.
fn perpendicular(v: [f64; 3], axis: [f64; 3]) -> [f64; 3] {
    let along = dot(v, axis);
    let across: [f64; 3] = std::array::from_fn(|i| v[i] - along * axis[i]);
    unit(across).unwrap_or_else(|| {
        let (s, _) = vec3(axis).coordinate_system();
        [s.x, s.y, s.z].map(f64::from)
    })
}

/// The directions across a tube from which its turns are counted (Mitsuba 3, bsplinecurve.cpp).
fn frame(axis: [f64; 3]) -> [[f64; 3]; 2] {
    let up = [0.0, 0.0, 1.0];
    let across: [f64; 3] = std::array::from_fn(|i| up[i] - axis[2] * axis[i]);
    let quarter = unit(across).unwrap_or([0.0, 1.0, 0.0]);
    [cross(quarter, axis), quarter]
}

fn around(axis: [f64; 3], phi: f64) -> [f64; 3] {
    let [zero, quarter] = frame(axis);
    let (s, c) = phi.sin_cos();
    std::array::from_fn(|i| zero[i] * c + quarter[i] * s)
}

fn turns(c: [f64; 3], axis: [f64; 3], p: [f64; 3]) -> f64 {
    let [zero, quarter] = frame(axis);
    let rho: [f64; 3] = std::array::from_fn(|i| p[i] - c[i]);
    let turns = dot(quarter, rho).atan2(dot(zero, rho)) / TAU;
    if turns < 0.0 { turns + 1.0 } else { turns }
}

fn vec3(v: [f64; 3]) -> Vec3 {
    Vec3::new(v[0] as f32, v[1] as f32, v[2] as f32)
}
