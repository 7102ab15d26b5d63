//! The facets of the metallic-roughness model: which one lies between two directions, and what it
//! reflects and lets through. The formulas' numbers are the model's.

use super::super::Mode;
use super::super::fresnel::fresnel_dielectric;
use super::{Boundary, MetallicRoughness};
use kaustika_math::{Vec3, sqr};
use kaustika_spectra::Spectrum;

/// S(r0, r90) at cos.
#[inline]
pub(super) fn schlick(r0: f32, r90: f32, cos: f32) -> f32 {
    let m = (1.0 - cos).clamp(0.0, 1.0);
    r0 + (r90 - r0) * (sqr(sqr(m)) * m)
}

/// `w` on the other side of the surface.
#[inline]
pub(super) fn mirrored(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, -w.z)
}

/// A pair of directions with the facet between them.
pub(super) struct Facet {
    /// Normal, on the side of z > 0.
    pub wm: Vec3,
    /// Cosines to it, positive.
    pub cos_o: f32,
    pub cos_i: f32,
    /// Index on the side of `wi` over that on the side of `wo`.
    pub eta: f32,
    /// Cosine on the thinner side; `None` under total reflection.
    pub cos: Option<f32>,
}

impl MetallicRoughness {
    /// The facet between two directions; `None` if one of them sees it from behind.
    #[inline]
    pub(super) fn facet(&self, wo: Vec3, wi: Vec3) -> Option<Facet> {
        let same_side = wo.z * wi.z > 0.0;
        if self.boundary == Boundary::Sheet || same_side {
            let wi = if same_side { wi } else { mirrored(wi) };
            let wm = (wo + wi).try_normalize()?.face_forward(Vec3::Z);
            let cos = wo.dot(wm).abs();
            let from_inside = wo.z < 0.0 && self.boundary == Boundary::Solid;
            let cos_thin = if from_inside { self.cos_outside(cos) } else { Some(cos) };
            return Some(Facet { wm, cos_o: cos, cos_i: cos, eta: 1.0, cos: cos_thin });
        }
        let eta = if wo.z > 0.0 { self.eta } else { 1.0 / self.eta };
        let wm = (wo + wi * eta).try_normalize()?.face_forward(Vec3::Z);
        let (cos_o, cos_i) = (wo.dot(wm) * wo.z.signum(), wi.dot(wm) * wi.z.signum());
        if cos_o <= 0.0 || cos_i <= 0.0 {
            return None;
        }
        let cos = Some(if wo.z > 0.0 { cos_o } else { cos_i });
        Some(Facet { wm, cos_o, cos_i, eta, cos })
    }

    /// Cosine outside of a ray at `cos` inside; `None` under total reflection.
    #[inline]
    pub(super) fn cos_outside(&self, cos: f32) -> Option<f32> {
        let i = fresnel_dielectric(-cos, self.eta);
        (i.cos_t > 0.0).then_some(i.cos_t)
    }

    /// What a facet reflects, by its cosine on the thinner side: (2), or the inside's.
    #[inline]
    pub(super) fn reflected(&self, outside: bool, cos: Option<f32>) -> Spectrum {
        match cos {
            Some(cos) if outside => {
                let plain = self.r0.map(|r| schlick(r, self.r90, cos));
                self.film.map_or(plain, |film| film.reflectance(cos, self.r0, plain))
            }
            Some(cos) => Spectrum::splat(self.through * self.dielectric_reflected(cos)),
            None => Spectrum::splat(self.through),
        }
    }

    /// The greatest component of F_d.
    #[inline]
    pub(super) fn dielectric_reflected(&self, cos: f32) -> f32 {
        let plain = schlick(self.dielectric.0, self.dielectric.1, cos);
        match self.film {
            Some(film) => film.reflectance_max(cos, self.dielectric.0, plain),
            None => plain,
        }
    }

    /// What a facet lets through, without the base colour: 1 - F_d.
    #[inline]
    pub(super) fn passed(&self, cos: Option<f32>) -> f32 {
        cos.map_or(0.0, |cos| 1.0 - self.dielectric_reflected(cos))
    }

    /// D G₂/|cos θₒ| for light that passes a facet of a solid, without (1-F): (5).
    #[inline]
    pub(super) fn bent(&self, wo: Vec3, wi: Vec3, f: &Facet, mode: Mode) -> f32 {
        let shape = self.surface.d(f.wm) * self.surface.g2(wo, wi) / wo.z.abs();
        let scale = if mode == Mode::Radiance { 1.0 / sqr(f.eta) } else { 1.0 };
        shape * f.cos_o * f.cos_i / sqr(f.cos_o / f.eta - f.cos_i) * scale
    }
}
