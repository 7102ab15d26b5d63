//! Which materials need to know where u grows.

use crate::description::{MaterialDesc, MaterialId, MaterialModel, RoughnessDesc};
use crate::texture::Textures;

/// True if the material's scattering changes when its frame turns about the normal, so that the
/// first tangent has to lie along ∂p/∂u. A model not known here is taken to be such.
pub(super) fn is_oriented(all: &[MaterialDesc], id: MaterialId, textures: &Textures) -> bool {
    use MaterialModel as M;
    let part = |id: &MaterialId| is_oriented(all, *id, textures);
    let stretched = |r: &RoughnessDesc| {
        let same = match (textures.constant(r.alpha_u), textures.constant(r.alpha_v)) {
            (Some(u), Some(v)) => u == v,
            _ => r.alpha_u == r.alpha_v,
        };
        !same
    };
    match &all[id.0 as usize].model {
        M::Diffuse { .. }
        | M::DiffuseTransmission { .. }
        | M::OrenNayar { .. }
        | M::Phong { .. }
        | M::ThinDielectric { .. }
        | M::Null { .. } => false,
        M::Filter { element, .. } => element.is_oriented(),
        M::Conductor { roughness, .. } | M::Dielectric { roughness, .. } => stretched(roughness),
        M::Plastic { roughness, .. } => roughness.as_ref().is_some_and(stretched),
        M::Principled(desc) => textures.constant(desc.anisotropic) != Some(0.0),
        M::MetallicRoughness(desc) => {
            desc.anisotropy.is_some()
                || desc.clearcoat.as_ref().is_some_and(|c| c.normals.is_some())
        }
        M::Mix { a, b, .. } => part(a) || part(b),
        M::Sum { parts } => parts.iter().any(|(_, id)| part(id)),
        M::Mask { material, .. } => part(material),
        M::TwoSided { front, back } => part(front) || part(back),
        _ => true,
    }
}
