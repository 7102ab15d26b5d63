//! Shapes of plain materials: Lambert's diffuse reflection, bare or under a rough clear coat, and
//! the frequent kind of the principled model.

use super::coat::Coat;
use super::gloss::Gloss;
use super::principled::PrincipledLobes;
use crate::description::{MaterialId, MaterialModel, TextureId};
use crate::material::Materials;
use crate::scene::ShapeInfo;
use crate::texture::Textures;
use kaustika_spectra::{ColorMode, Spectrum, Wavelengths};

/// A shape that reflects as [`Diffuse`](crate::bsdf::Diffuse),
/// [`RoughPlastic`](crate::bsdf::RoughPlastic) or [`Principled`](crate::bsdf::Principled), on both
/// sides alike if on the back at all.
#[derive(Clone, Debug)]
pub struct Plain {
    /// Albedo of the matte base, or the principled model's base colour.
    pub reflectance: TextureId,
    /// The albedo, where it is the same everywhere and for all paths.
    pub constant: Option<Spectrum>,
    /// True if the back reflects too.
    pub two_sided: bool,
    /// What lies over the base.
    pub gloss: Option<Gloss>,
}

impl Plain {
    /// `None` for shapes of any other material.
    pub(crate) fn of(
        shape: &ShapeInfo,
        materials: &Materials,
        textures: &Textures,
        mode: ColorMode,
    ) -> Option<Plain> {
        let (leaf, two_sided) = materials.leaf(shape.material)?;
        let uniform = |id| match mode {
            ColorMode::Rgb => textures.uniform(id, &Wavelengths::rgb()),
            ColorMode::Spectral => None,
        };
        let plain = |reflectance, gloss| {
            Some(Plain { reflectance, constant: uniform(reflectance), two_sided, gloss })
        };
        match materials.model(leaf) {
            MaterialModel::Diffuse { reflectance } => plain(*reflectance, None),
            MaterialModel::Plastic { diffuse_reflectance, specular_reflectance, .. } => {
                let specular = uniform(*specular_reflectance)?;
                let coat = Coat::of(materials, textures, leaf, specular)?;
                plain(*diffuse_reflectance, Some(Gloss::Coat(coat)))
            }
            MaterialModel::Principled(desc) => {
                let lobes = PrincipledLobes::of(desc, textures)?;
                plain(desc.base_color, Some(Gloss::Principled(lobes)))
            }
            _ => None,
        }
    }
}

impl Materials {
    /// The one material that a material is, seen from either side, and whether it reflects on
    /// its back. `None` where the sides differ.
    fn leaf(&self, id: MaterialId) -> Option<(MaterialId, bool)> {
        match self.model(id) {
            MaterialModel::TwoSided { front, back } if front == back => {
                let (leaf, _) = self.leaf(*front)?;
                Some((leaf, true))
            }
            MaterialModel::TwoSided { .. } => None,
            _ => Some((id, self.is_two_sided(id))),
        }
    }
}
