//! From a surface point to texture coordinates.

use super::TexturePoint;
use crate::description::TextureMapping;
use kaustika_math::{INV_PI, INV_TWO_PI, Vec2, Vec3, safe_acos};
use std::f32::consts::PI;

/// Texture coordinates and the width of the region around them to average over.
#[derive(Clone, Copy, Debug)]
pub struct Mapped {
    /// The coordinates.
    pub st: Vec2,
    /// Width of the region, in texture coordinates.
    pub width: f32,
}

/// Applies a mapping. Only the uv mapping knows the filter width; the others point-sample.
#[inline]
pub fn apply(mapping: &TextureMapping, at: &TexturePoint) -> Mapped {
    match mapping {
        TextureMapping::Uv(m) => {
            let stretch = m.m.iter().flat_map(|r| &r[..2]).fold(0f32, |a, v| a.max(v.abs()));
            Mapped { st: m.point(at.uv), width: at.uv_width * stretch }
        }
        TextureMapping::Spherical(to_texture) => {
            let d = to_texture.point(at.p).try_normalize().unwrap_or(Vec3::Z);
            let phi = d.y.atan2(d.x);
            let phi = if phi < 0.0 { phi + 2.0 * PI } else { phi };
            Mapped { st: Vec2::new(safe_acos(d.z) * INV_PI, phi * INV_TWO_PI), width: 0.0 }
        }
        TextureMapping::Cylindrical(to_texture) => {
            let q = to_texture.point(at.p);
            Mapped { st: Vec2::new((PI + q.y.atan2(q.x)) * INV_TWO_PI, q.z), width: 0.0 }
        }
        TextureMapping::Planar { to_texture, vs, vt, ds, dt } => {
            let q = to_texture.point(at.p);
            let st = Vec2::new(q.dot(Vec3::from(*vs)) + ds, q.dot(Vec3::from(*vt)) + dt);
            Mapped { st, width: 0.0 }
        }
    }
}
