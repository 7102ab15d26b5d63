//! The clear coat of the metallic-roughness model, about a normal of its own.
//!
//! Towards the camera its value is that of a reflecting surface in its own frame,
//!
//! ```text
//! f |cos θᵢ| = w F_c D G₂ / (4 |ωₒ·n_c|)                                                  (1)
//! ```
//!
//! towards the lights that of the reversed path, as the contract wants it.

use super::super::albedo::microfacet_albedo_terms;
use super::super::fresnel::reflect;
use super::super::{Microfacet, Mode};
use super::{ALPHA_LEAST, schlick};
use crate::description::Distribution;
use kaustika_math::{Frame, Vec2, Vec3, sqr};

/// Reflectance at normal incidence, of index 1.5.
const R0: f32 = 0.04;

/// A clear coat at a point.
#[derive(Clone, Copy, Debug)]
pub struct Clearcoat {
    /// Strength w in [0,1].
    pub factor: f32,
    surface: Microfacet,
    normal: Vec3,
}

impl Clearcoat {
    /// A coat of this strength and perceptual roughness about `normal`, unit, in the frame of
    /// what lies below.
    pub fn new(factor: f32, roughness: f32, normal: Vec3) -> Clearcoat {
        let alpha = sqr(roughness).clamp(ALPHA_LEAST, 1.0);
        Clearcoat { factor, surface: Microfacet::new(Distribution::Ggx, alpha, alpha), normal }
    }

    /// What passes of light at `w`: 1 - w F_c.
    #[inline]
    pub(super) fn passed(&self, w: Vec3) -> f32 {
        1.0 - self.factor * schlick(R0, 1.0, w.dot(self.normal).abs())
    }

    /// Its directional albedo, by tables.
    pub(super) fn albedo(&self, w: Vec3) -> f32 {
        let local = Frame::from_normal(self.normal).to_local(w);
        let [a, b] = microfacet_albedo_terms(&self.surface, local);
        self.factor * (R0 * a + b)
    }

    /// The directions in the coat's frame, if both see its front.
    #[inline]
    fn local(&self, wo: Vec3, wi: Vec3) -> Option<(Vec3, Vec3, Vec3)> {
        let frame = Frame::from_normal(self.normal);
        let (o, i) = (frame.to_local(wo), frame.to_local(wi));
        if o.z <= 0.0 || i.z <= 0.0 {
            return None;
        }
        Some((o, i, (o + i).try_normalize()?))
    }

    /// (1), for directions above the surface.
    pub(super) fn value(&self, wo: Vec3, wi: Vec3, mode: Mode) -> f32 {
        let Some((o, i, m)) = self.local(wo, wi) else { return 0.0 };
        let f = self.factor * schlick(R0, 1.0, o.dot(m));
        let f = f * self.surface.d(m) * self.surface.g2(o, i) * 0.25;
        match mode {
            Mode::Radiance => f / o.z,
            Mode::Importance => f * wi.z / (i.z * wo.z),
        }
    }

    /// Density of `wi`.
    #[inline]
    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.local(wo, wi).map_or(0.0, |(o, i, m)| self.surface.pdf_reflection(o, i, m).0)
    }

    /// A reflection of `wo`, if the coat's front is seen.
    #[inline]
    pub(super) fn sample(&self, wo: Vec3, u: Vec2) -> Option<Vec3> {
        let frame = Frame::from_normal(self.normal);
        let o = frame.to_local(wo);
        if o.z <= 0.0 {
            return None;
        }
        let i = reflect(o, self.surface.sample_visible(o, u));
        (i.z > 0.0).then(|| frame.to_world(i))
    }
}
