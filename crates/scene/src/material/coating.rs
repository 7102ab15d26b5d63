//! Coats over other materials.

use super::Hit;
use crate::bsdf::{
    Coating, CoatingLayer, Diffuse, Masking, Microfacet, Model, Part, RoughTransmittance,
};
use crate::description::MaterialModel;
use kaustika_math::sqr;
use kaustika_spectra::Spectrum;

impl Hit<'_, '_> {
    /// The coat of a [`MaterialModel::Coating`].
    pub(super) fn coating<'a>(
        &self,
        model: &MaterialModel,
        tables: Option<&'a RoughTransmittance>,
        masking: Masking,
    ) -> Option<CoatingLayer<'a>> {
        let MaterialModel::Coating {
            ior, sigma_a, thickness, specular_reflectance, roughness, ..
        } = model
        else {
            return None;
        };
        let surface = match roughness {
            Some(r) => self.microfacet(r, masking),
            None => Microfacet::smooth(),
        };
        Some(CoatingLayer {
            eta: *ior,
            surface,
            through: tables.map(|t| (t, t.index(surface.alpha()))),
            reflectance: self.spectrum(*specular_reflectance),
            depth: self.spectrum(*sigma_a).clamp_zero() * *thickness,
        })
    }
}

/// A model under a coat; as it is if it can't be coated.
pub(super) fn coated<'a>(part: Part<'a>, layer: CoatingLayer<'a>) -> Part<'a> {
    match Coating::new(layer, part.model) {
        Some(coating) => Part { model: Model::Coating(coating), ..part },
        None => part,
    }
}

/// [`MaterialModel::PolarizedPlastic`]: light is not spread over the larger solid angle outside.
pub(super) fn polarized_plastic<'a>(
    surface: Microfacet,
    diffuse: Spectrum,
    reflectance: Spectrum,
    eta: f32,
) -> Model<'a> {
    let base = Model::Diffuse(Diffuse { reflectance: diffuse * sqr(eta) });
    let depth = Spectrum::ZERO;
    let layer = CoatingLayer { eta, surface, through: None, reflectance, depth };
    Coating::new(layer, base).map_or(base, Model::Coating)
}
