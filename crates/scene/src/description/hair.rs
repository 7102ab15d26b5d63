//! Hair, as files describe it.

use super::TextureId;

/// Parameters of [`super::MaterialModel::Hair`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HairDesc {
    /// How the fibre lies in its surface.
    pub layout: FibreLayout,
    /// What it absorbs.
    pub absorption: HairAbsorption,
    /// Index inside over that outside.
    pub eta: TextureId,
    /// Roughness along the fibre, in [0, 1].
    pub beta_m: TextureId,
    /// Roughness around it, in [0, 1].
    pub beta_n: TextureId,
    /// Tilt of the scales, degrees.
    pub alpha: TextureId,
}

/// How a fibre lies in the surface that stands for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FibreLayout {
    /// u grows from root to tip, v from 0 to 1 across (pbrt).
    RibbonAlongU,
    /// v grows from root to tip, the shading normal goes around (Mitsuba).
    TubeAlongV,
}

/// What a fibre absorbs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HairAbsorption {
    /// Absorption in inverse radii of the fibre, unbounded.
    Coefficient(TextureId),
    /// Such that a bundle has this colour.
    Color(TextureId),
    /// By its pigments.
    Melanin {
        /// Concentration of the brown one.
        eumelanin: TextureId,
        /// Of the red one.
        pheomelanin: TextureId,
    },
}
