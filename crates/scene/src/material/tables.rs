//! What is computed of materials before rendering.

use super::Tables;
use crate::bsdf::{
    HeightFieldData, MeasuredData, Microfacet, MuellerData, PlasticCoat, RoughTransmittance,
};
use crate::description::{MaterialDesc, MaterialModel, MeasuredBrdf, TextureId};
use crate::texture::{TexturePoint, Textures};
use kaustika_math::{Vec2, Vec3};
use kaustika_spectra::ColorMode;
use std::sync::Arc;

/// Nodes of a height field along each side.
const HEIGHTS: usize = 512;

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
        if let MaterialModel::HeightField { heights, scale, .. } = material.model {
            let data = relief(textures, heights, scale);
            all.push(Some(Tables::HeightField(Arc::new(data))));
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

/// The tables of a texture's heights over the unit square of u and v.
fn relief(textures: &Textures, heights: TextureId, scale: f32) -> HeightFieldData {
    let at = |k: usize| (k as f32 + 0.5) / HEIGHTS as f32;
    let height = |k: usize| {
        let uv = Vec2::new(at(k % HEIGHTS), at(k / HEIGHTS));
        let point = TexturePoint {
            p: Vec3::new(uv.x, uv.y, 0.0),
            n: Vec3::Z,
            uv,
            uv_width: 0.0,
            triangle: u32::MAX,
            barycentrics: Vec2::ZERO,
        };
        scale * textures.float(heights, &point)
    };
    HeightFieldData::new(HEIGHTS, (0..HEIGHTS * HEIGHTS).map(height).collect())
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
