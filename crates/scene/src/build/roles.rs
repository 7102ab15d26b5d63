//! What the colours of textures mean: albedos, light, or quantities without bound.

use crate::description::{
    ConductorColor, FilterModel, HairAbsorption, HairDesc, IorDesc, LightKind, MaterialModel,
    SceneDescription, TextureId, TextureNode,
};
use kaustika_spectra::SpectrumRole;
use std::collections::HashSet;

/// Which meaning the colours of each texture have.
pub(super) struct Roles {
    illuminants: HashSet<TextureId>,
    unbounded: HashSet<TextureId>,
}

impl Roles {
    /// Textures used for emission or for indices of refraction, and their children.
    pub(super) fn of(description: &SceneDescription) -> Roles {
        let mut roles = Roles { illuminants: HashSet::new(), unbounded: HashSet::new() };
        let shapes = description.shapes.iter();
        for shape in shapes.chain(description.groups.iter().flat_map(|g| &g.shapes)) {
            if let Some(e) = &shape.emission {
                mark(description, e.radiance, &mut roles.illuminants);
            }
        }
        for light in &description.lights {
            if let LightKind::Projector { texture, .. } = light.kind {
                mark(description, texture, &mut roles.illuminants);
            }
        }
        for material in &description.materials {
            let (color, ior) = match &material.model {
                MaterialModel::Conductor { color, .. } => (Some(color), None),
                MaterialModel::Dielectric { ior, .. }
                | MaterialModel::ThinDielectric { ior, .. } => (None, Some(ior)),
                MaterialModel::MetallicRoughness(desc) => (None, Some(&desc.ior)),
                MaterialModel::CoatedDiffuse { coat, .. } => (None, Some(&coat.ior)),
                MaterialModel::CoatedConductor { color, coat, .. } => {
                    (Some(color), Some(&coat.ior))
                }
                _ => (None, None),
            };
            if let MaterialModel::MetallicRoughness(desc) = &material.model {
                mark(description, desc.specular_color, &mut roles.unbounded);
            }
            if let MaterialModel::Hair(HairDesc {
                absorption: HairAbsorption::Coefficient(t),
                ..
            }) = &material.model
            {
                mark(description, *t, &mut roles.unbounded);
            }
            if let MaterialModel::Filter { element: FilterModel::Retarder { delta, .. }, .. } =
                material.model
            {
                mark(description, delta, &mut roles.unbounded);
            }
            if let Some(ConductorColor::EtaK { eta, k }) = color {
                mark(description, *eta, &mut roles.unbounded);
                mark(description, *k, &mut roles.unbounded);
            }
            if let Some(IorDesc::Spectrum(t)) = ior {
                mark(description, *t, &mut roles.unbounded);
            }
        }
        roles
    }

    /// What the colours of one texture mean.
    pub(super) fn of_texture(&self, id: TextureId) -> SpectrumRole {
        if self.illuminants.contains(&id) {
            SpectrumRole::Illuminant
        } else if self.unbounded.contains(&id) {
            SpectrumRole::Unbounded
        } else {
            SpectrumRole::Albedo
        }
    }
}

/// Adds a texture and what it is computed from.
fn mark(description: &SceneDescription, id: TextureId, set: &mut HashSet<TextureId>) {
    use TextureNode as N;
    if !set.insert(id) {
        return;
    }
    match &description.textures[id.0 as usize].node {
        N::Checkerboard { a, b, .. }
        | N::Checkerboard3d { a, b, .. }
        | N::Dots { inside: a, outside: b, .. }
        | N::DirectionMix { a, b, .. } => {
            mark(description, *a, set);
            mark(description, *b, set);
        }
        N::LineGrid { between, lines, .. } => {
            mark(description, *between, set);
            mark(description, *lines, set);
        }
        N::Mix { a, b, .. } => {
            mark(description, *a, set);
            mark(description, *b, set);
        }
        N::Scale { texture, .. } | N::WithUv { texture, .. } => mark(description, *texture, set),
        N::Bilerp { corners, .. } => corners.iter().for_each(|c| mark(description, *c, set)),
        N::Float(_)
        | N::Spectrum(_)
        | N::Bitmap(_)
        | N::Grid(_)
        | N::Noise { .. }
        | N::MeshAttribute { .. }
        | N::Step { .. } => {}
    }
}
