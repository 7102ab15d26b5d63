//! Rough clear coats over matte bases: [`RoughPlastic`](crate::bsdf::RoughPlastic) with isotropic
//! facets of the GGX distribution.

use crate::bsdf::{AlphaIndex, Masking, RoughTransmittance};
use crate::description::{Distribution, MaterialId, MaterialModel};
use crate::material::Materials;
use crate::texture::Textures;
use kaustika_spectra::Spectrum;
use std::sync::Arc;

/// A coat that is the same all over its shape.
#[derive(Clone, Debug)]
pub struct Coat {
    pub(super) tables: Arc<RoughTransmittance>,
    pub(super) at: AlphaIndex,
    pub(super) alpha: f32,
    pub(super) specular: Spectrum,
    pub(super) nonlinear: bool,
    /// True if masking and shadowing are correlated.
    pub(super) correlated: bool,
}

impl Coat {
    pub(super) fn of(
        materials: &Materials,
        textures: &Textures,
        id: MaterialId,
        specular: Spectrum,
    ) -> Option<Coat> {
        let MaterialModel::Plastic { roughness: Some(r), nonlinear, .. } = materials.model(id)
        else {
            return None;
        };
        let alpha = textures.constant(r.alpha_u)?;
        let alpha = if r.remap { alpha.max(0.0).sqrt() } else { alpha };
        let alike = textures.constant(r.alpha_u) == textures.constant(r.alpha_v);
        if r.distribution != Distribution::Ggx || !alike || alpha <= 0.0 {
            return None;
        }
        let tables = materials.rough_coat(id)?;
        let alpha = alpha.max(crate::bsdf::Microfacet::ALPHA_MIN);
        let correlated = materials.masking() == Masking::HeightCorrelated;
        let at = tables.index(alpha);
        Some(Coat { tables, at, alpha, specular, nonlinear: *nonlinear, correlated })
    }

    /// T at the angle of this cosine.
    #[inline]
    pub(super) fn transmittance(&self, cos: f32) -> f32 {
        self.tables.transmittance(self.at, cos)
    }
}
