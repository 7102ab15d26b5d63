//! Shapes that are nothing but Lambert's diffuse reflection.

use crate::description::TextureId;
use crate::material::Materials;
use crate::scene::ShapeInfo;
use crate::texture::Textures;
use kaustika_spectra::{ColorMode, Spectrum, Wavelengths};

/// A shape whose surface reflects as [`Diffuse`](crate::bsdf::Diffuse), on both sides alike if on
/// the back at all.
#[derive(Clone, Copy, Debug)]
pub struct Matte {
    /// Its albedo.
    pub reflectance: TextureId,
    /// The albedo, where it is the same everywhere and for all paths.
    pub constant: Option<Spectrum>,
    /// True if the back reflects too.
    pub two_sided: bool,
}

impl Matte {
    /// `None` for shapes of any other material.
    pub(crate) fn of(
        shape: &ShapeInfo,
        materials: &Materials,
        textures: &Textures,
        mode: ColorMode,
    ) -> Option<Matte> {
        let (reflectance, two_sided) = materials.matte(shape.material)?;
        let constant = match mode {
            ColorMode::Rgb => textures.uniform(reflectance, &Wavelengths::rgb()),
            ColorMode::Spectral => None,
        };
        Some(Matte { reflectance, constant, two_sided })
    }
}
