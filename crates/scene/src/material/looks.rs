//! What of a material a classical picture shows (z-buffer): one colour, cut-outs, and whether it is
//! there at all.

use super::Materials;
use crate::description::{MaterialId, MaterialModel, TextureId};

/// A material in terms of the classical lighting models.
#[derive(Clone, Debug, Default)]
pub struct Looks {
    /// What colours its diffuse part.
    pub color: Option<TextureId>,
    /// Opacities that cut it out.
    pub opacity: Vec<TextureId>,
    /// The exponent of a cosine lobe, if it has one.
    pub exponent: Option<TextureId>,
    /// True if light goes through it without being scattered everywhere: glass, or nothing.
    pub clear: bool,
}

impl Materials {
    /// What a material looks like from its front; of mixtures the greater part, by their constant
    /// amounts.
    pub fn looks(&self, id: MaterialId) -> Looks {
        use MaterialModel as M;
        let colored = |color| Looks { color: Some(color), ..Looks::default() };
        match self.model(id) {
            M::Diffuse { reflectance }
            | M::DiffuseTransmission { reflectance, .. }
            | M::OrenNayar { reflectance, .. }
            | M::CoatedDiffuse { reflectance, .. } => colored(*reflectance),
            M::Plastic { diffuse_reflectance, .. }
            | M::PolarizedPlastic { diffuse_reflectance, .. }
            | M::Ward { diffuse_reflectance, .. } => colored(*diffuse_reflectance),
            M::Phong { diffuse_reflectance, exponent, .. } => {
                Looks { exponent: Some(*exponent), ..colored(*diffuse_reflectance) }
            }
            M::Principled(desc) => colored(desc.base_color),
            M::TwoSided { front, .. } => self.looks(*front),
            M::Bump { material, .. }
            | M::NormalMap { material, .. }
            | M::Coating { material, .. } => self.looks(*material),
            M::Mix { a, .. } => self.looks(*a),
            M::Sum { parts } => {
                let most = parts.iter().max_by(|a, b| a.0.total_cmp(&b.0));
                most.map_or(Looks::default(), |(_, id)| self.looks(*id))
            }
            M::Mask { material, opacity } => {
                let mut looks = self.looks(*material);
                looks.opacity.push(*opacity);
                looks
            }
            M::Dielectric { .. } | M::ThinDielectric { .. } | M::Null { .. } => {
                Looks { clear: true, ..Looks::default() }
            }
            _ => Looks::default(),
        }
    }
}
