//! glTF 2.0's material with the extensions ratified by Khronos.

use super::{IorDesc, TextureId};

/// Parameters of [`super::MaterialModel::MetallicRoughness`], glTF's names. What an extension of
/// glTF adds is `None` where a file does not use it.
#[derive(Clone, Debug, PartialEq)]
pub struct MetallicRoughnessDesc {
    /// Colour of the matte part, of metal, and of what is transmitted.
    pub base_color: TextureId,
    /// Metal or dielectric.
    pub metallic: TextureId,
    /// Perceptual roughness: α is its square.
    pub roughness: TextureId,
    /// Index of refraction of the dielectric; 0 stands for a reflectance of 1 from everywhere.
    pub ior: IorDesc,
    /// Strength of the dielectric's reflection (KHR_materials_specular).
    pub specular: TextureId,
    /// Tint of the dielectric's reflection at normal incidence; may exceed 1.
    pub specular_color: TextureId,
    /// KHR_materials_anisotropy.
    pub anisotropy: Option<AnisotropyDesc>,
    /// KHR_materials_sheen.
    pub sheen: Option<SheenDesc>,
    /// KHR_materials_clearcoat.
    pub clearcoat: Option<ClearcoatDesc>,
    /// KHR_materials_transmission: how much of the dielectric is transparent instead of matte.
    pub transmission: Option<TextureId>,
    /// KHR_materials_diffuse_transmission.
    pub diffuse_transmission: Option<DiffuseTransmissionDesc>,
    /// KHR_materials_volume; without it surfaces are thin sheets, which do not refract.
    pub volume: Option<VolumeDesc>,
    /// KHR_materials_iridescence.
    pub iridescence: Option<IridescenceDesc>,
}

/// Roughness that grows along one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct AnisotropyDesc {
    /// Strength in [0,1].
    pub strength: TextureId,
    /// Angle from the first tangent, anticlockwise, radians.
    pub rotation: f32,
    /// Direction before the rotation, its x and y in [0,1]² for [-1,1]² (raw texture).
    pub direction: Option<TextureId>,
}

/// Fibres over the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SheenDesc {
    /// Colour.
    pub color: TextureId,
    /// Perceptual roughness.
    pub roughness: TextureId,
}

/// A clear coat of index 1.5.
#[derive(Clone, Debug, PartialEq)]
pub struct ClearcoatDesc {
    /// Strength in [0,1].
    pub factor: TextureId,
    /// Perceptual roughness.
    pub roughness: TextureId,
    /// Its own normal map; `None`: the mesh's shading normal.
    pub normals: Option<(TextureId, TangentSpace)>,
}

/// Matte light on the other side.
#[derive(Clone, Debug, PartialEq)]
pub struct DiffuseTransmissionDesc {
    /// Part of the matte light that goes through, in [0,1].
    pub factor: TextureId,
    /// Its colour.
    pub color: TextureId,
}

/// What a closed surface is filled with.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeDesc {
    /// What is left of white light after `attenuation_distance`.
    pub attenuation_color: TextureId,
    /// In world units; infinite for clear matter.
    pub attenuation_distance: f32,
}

/// A thin film on the dielectric and the metal.
#[derive(Clone, Debug, PartialEq)]
pub struct IridescenceDesc {
    /// Strength in [0,1].
    pub factor: TextureId,
    /// Index of refraction of the film.
    pub ior: f32,
    /// Thickness of the film, nm.
    pub thickness: TextureId,
}

/// How the numbers of a normal map become a normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentSpace {
    /// Multiplies x and y before the normal is normalised.
    pub scale: f32,
    /// True: y runs along ∂p/∂v, also where u and v are mirrored (glTF); false: y is the normal
    /// times x.
    pub follows_v: bool,
}

impl Default for TangentSpace {
    fn default() -> Self {
        TangentSpace { scale: 1.0, follows_v: false }
    }
}
