//! What of a material a classical picture shows (z-buffer): one colour, cut-outs, and whether it is
//! there at all.

use super::Materials;
use crate::description::{MaterialId, MaterialModel, TextureId};

/// A material in terms of the classical lighting models.
#[derive(Clone, Debug, Default)]
pub struct Looks {
    /// What colours its diffuse part: the sum of these.
    pub colors: Vec<Tint>,
    /// Opacities that cut it out.
    pub opacity: Vec<TextureId>,
    /// The exponent of a cosine lobe, if it has one.
    pub exponent: Option<TextureId>,
    /// True if light goes through it without being scattered everywhere: glass, or nothing.
    pub clear: bool,
    /// True if it is clear, and more than nothing: who leaves it out shows another picture.
    pub glass: bool,
}

/// A colour that is a part of a mixture.
#[derive(Clone, Debug, PartialEq)]
pub struct Tint {
    /// Which.
    pub color: TextureId,
    /// Its part where that is the same everywhere.
    pub weight: f32,
    /// What it is multiplied by as well: a texture, or 1 less that where it says so.
    pub amounts: Vec<(TextureId, bool)>,
}

impl Materials {
    /// What a material looks like from its front; the highlight of mixtures is that of the greater part,
    /// by their constant amounts, or of the first.
    pub fn looks(&self, id: MaterialId) -> Looks {
        use MaterialModel as M;
        let colored = |color| {
            let tint = Tint { color, weight: 1.0, amounts: Vec::new() };
            Looks { colors: vec![tint], ..Looks::default() }
        };
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
            M::Mix { a, b, amount } => {
                let part = |id: &MaterialId, rest: bool| {
                    let mut looks = self.looks(*id);
                    looks.colors.iter_mut().for_each(|tint| tint.amounts.push((*amount, rest)));
                    looks
                };
                together(vec![part(a, true), part(b, false)])
            }
            M::Sum { parts } => {
                let mut parts: Vec<&(f32, MaterialId)> = parts.iter().collect();
                parts.sort_by(|a, b| b.0.total_cmp(&a.0));
                let part = |&(weight, id): &(f32, MaterialId)| {
                    let mut looks = self.looks(id);
                    looks.colors.iter_mut().for_each(|tint| tint.weight *= weight);
                    looks
                };
                together(parts.into_iter().map(part).collect())
            }
            M::Mask { material, opacity } => {
                let mut looks = self.looks(*material);
                looks.opacity.push(*opacity);
                looks
            }
            M::Dielectric { .. } | M::ThinDielectric { .. } => {
                Looks { clear: true, glass: true, ..Looks::default() }
            }
            M::Null { .. } => Looks { clear: true, ..Looks::default() },
            _ => Looks::default(),
        }
    }
}

/// Parts of a mixture: their colours together, and what else the first has. Only what is clear, or has
/// holes, in all of its parts is so.
fn together(parts: Vec<Looks>) -> Looks {
    let clear = parts.iter().all(|part| part.clear);
    let glass = clear && parts.iter().any(|part| part.glass);
    let has_holes = parts.iter().all(|part| !part.opacity.is_empty());
    let colors = parts.iter().flat_map(|part| part.colors.clone()).collect();
    let first = parts.into_iter().next().unwrap_or_default();
    let opacity = if has_holes { first.opacity } else { Vec::new() };
    Looks { colors, opacity, clear, glass, exponent: first.exponent }
}
