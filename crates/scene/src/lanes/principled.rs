//! The frequent kind of the principled model: [`Principled`](crate::bsdf::Principled), whose
//! numbers the formulas have, opaque and isotropic, with nothing but its diffuse part and its main
//! lobe.

use crate::bsdf::principled_facets;
use crate::description::PrincipledDesc;
use crate::texture::Textures;
use kaustika_math::lanes::Lanes;

/// Burley's diffuse part under the main lobe, the same all over a shape but for the base colour.
#[derive(Clone, Debug)]
pub struct PrincipledLobes {
    pub(super) roughness: f32,
    pub(super) metallic: f32,
    pub(super) eta: f32,
    /// Of the facets.
    pub(super) alpha: f32,
}

impl PrincipledLobes {
    /// `None` for models that have more parts, or where more than the base colour varies.
    pub(super) fn of(desc: &PrincipledDesc, textures: &Textures) -> Option<PrincipledLobes> {
        let unit = |id| Some(textures.constant(id)?.clamp(0.0, 1.0));
        let others = [
            desc.anisotropic,
            desc.spec_trans,
            desc.spec_tint,
            desc.sheen,
            desc.flatness,
            desc.clearcoat,
        ];
        let absent = others.into_iter().all(|id| unit(id) == Some(0.0));
        // Schlick's approximation takes another angle if the lower side is the thinner one.
        if desc.thin || !absent || desc.eta <= 1.0 {
            return None;
        }
        let roughness = unit(desc.roughness)?;
        let alpha = principled_facets(roughness, 0.0).alpha();
        Some(PrincipledLobes { roughness, metallic: unit(desc.metallic)?, eta: desc.eta, alpha })
    }

    /// Probability (7) of the main lobe.
    pub(super) fn choice(&self) -> f32 {
        1.0 / (2.0 - self.metallic)
    }
}

/// Schlick's weight for `cos` up to 1: the twin of (1) of the model's parts.
#[inline(always)]
pub(super) fn schlick_weight(cos: Lanes) -> Lanes {
    let m = (Lanes::splat(1.0) - cos).fast_max(Lanes::splat(0.0));
    let m2 = m * m;
    m2 * m2 * m
}

/// π f of the diffuse part over the base colour: the twin of (2, 3) of the model's parts.
#[inline(always)]
pub(super) fn diffuse(cos_o: Lanes, cos_i: Lanes, cos_d: Lanes, roughness: Lanes) -> Lanes {
    let (half, one) = (Lanes::splat(0.5), Lanes::splat(1.0));
    let (so, si) = (schlick_weight(cos_o), schlick_weight(cos_i));
    let plain = half.mul_neg_add(so, one) * half.mul_neg_add(si, one); // (2)
    let r = (roughness + roughness) * cos_d * cos_d;
    r.mul_add((so * si).mul_add(r - one, so + si), plain) // (3)
}
