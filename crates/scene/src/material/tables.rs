//! What is computed of materials before rendering.

use super::Tables;
use crate::bsdf::{MeasuredData, Microfacet, MuellerData, PlasticCoat, RoughTransmittance};
use crate::description::{MaterialDesc, MaterialModel, MeasuredBrdf};
use crate::texture::Textures;
use kaustika_spectra::ColorMode;
use std::sync::Arc;

/// The tables of each material that has some; equal measurements share theirs.
pub(super) fn of_all(
    materials: &[MaterialDesc],
    textures: &Textures,
    mode: ColorMode,
) -> Vec<Option<Tables>> {
    let mut known: Vec<(&Arc<MeasuredBrdf>, Arc<MeasuredData>)> = Vec::new();
    let mut all = Vec::new();
    for material in materials {
        if let MaterialModel::MeasuredPolarized(desc) = &material.model {
            all.push(Some(Tables::MeasuredPolarized(Arc::new(MuellerData::new(desc)))));
            continue;
        }
        let MaterialModel::Measured(brdf) = &material.model else {
            all.push(coat(&material.model, textures));
            continue;
        };
        let data = match known.iter().find(|(b, _)| Arc::ptr_eq(b, brdf)) {
            Some((_, data)) => data.clone(),
            None => Arc::new(MeasuredData::new(brdf, mode)),
        };
        known.push((brdf, data.clone()));
        all.push(Some(Tables::Measured(data)));
    }
    all
}

/// The tables of a plastic or a rough coat.
fn coat(model: &MaterialModel, textures: &Textures) -> Option<Tables> {
    let (ior, r) = match model {
        MaterialModel::Plastic { ior, roughness: Some(r), .. }
        | MaterialModel::Coating { ior, roughness: Some(r), .. } => (*ior, r),
        MaterialModel::Plastic { ior, .. } => return Some(Tables::Smooth(PlasticCoat::new(*ior))),
        _ => return None,
    };
    let alpha = |v: f32| if r.remap { v.max(0.0).sqrt() } else { v };
    let tables = match (textures.constant(r.alpha_u), textures.constant(r.alpha_v)) {
        (Some(u), Some(v)) => {
            let surface = Microfacet::new(r.distribution, alpha(u), alpha(v));
            RoughTransmittance::new(r.distribution, surface.alpha(), ior)
        }
        _ => RoughTransmittance::with_range(r.distribution, 1e-3, 1.0, ior),
    };
    Some(Tables::Rough(Arc::new(tables)))
}
