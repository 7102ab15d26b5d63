//! Where textures are looked up on a surface.

use super::TexturePoint;
use crate::geometry::Geometry;
use crate::surface::Surface;

impl TexturePoint {
    /// The texture point of a surface.
    #[inline]
    pub fn of(geometry: &Geometry, s: &Surface) -> TexturePoint {
        let uv_width = if s.footprint > 0.0 {
            let (dpdu, dpdv) = geometry.tangents(s);
            let stretch = dpdu.cross(dpdv).length().sqrt();
            if stretch > 0.0 { s.footprint / stretch } else { 0.0 }
        } else {
            0.0
        };
        TexturePoint {
            p: s.p,
            n: s.ns,
            uv: s.uv,
            uv_width,
            triangle: s.triangle,
            barycentrics: s.barycentrics,
        }
    }
}
