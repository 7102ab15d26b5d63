//! What shapes emit.

use crate::description::{
    EmissionDesc, SceneDescription, ShapeDesc, SourceFormat, TextureId, TextureNode,
};
use crate::light::{AreaLight, AreaShape, Light, NormalArea};

/// What a shape emits, and how much of it is there.
#[derive(Clone, Copy)]
pub(super) struct Emitter<'a> {
    pub(super) desc: &'a EmissionDesc,
    alpha: Option<TextureId>,
    unseen: bool,
}

impl<'a> Emitter<'a> {
    pub(super) fn of(description: &SceneDescription, shape: &'a ShapeDesc) -> Option<Emitter<'a>> {
        let desc = shape.emission.as_ref()?;
        let nowhere = |a: TextureId| match description.textures[a.0 as usize].node {
            TextureNode::Float(alpha) => alpha <= 0.0,
            _ => false,
        };
        let unseen = description.format == SourceFormat::Pbrt && shape.alpha.is_some_and(nowhere);
        Some(Emitter { desc, alpha: shape.alpha.filter(|_| !unseen), unseen })
    }

    /// The light of a part of the shape.
    pub(super) fn light(&self, shape: AreaShape) -> Light {
        let &EmissionDesc { radiance, scale, two_sided, .. } = self.desc;
        let (alpha, unseen) = (self.alpha, self.unseen);
        let two_sided = two_sided && !self.desc.along_normal;
        let area = AreaLight { shape, radiance, scale, two_sided, alpha, unseen };
        if self.desc.along_normal { Light::NormalArea(NormalArea(area)) } else { Light::Area(area) }
    }
}
