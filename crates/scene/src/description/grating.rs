//! Diffraction gratings.

use super::TextureId;

/// Parameters of [`super::MaterialModel::Grating`]; the lines run across the direction in which u
/// grows.
#[derive(Clone, Debug, PartialEq)]
pub struct GratingDesc {
    /// Distance of the lines, nm, > 0.
    pub period: f32,
    /// How light is shared between the orders.
    pub profile: GratingProfileDesc,
    /// Multiplies all reflected orders.
    pub reflectance: TextureId,
    /// Multiplies all transmitted orders.
    pub transmittance: TextureId,
}

/// Profiles of gratings.
#[derive(Clone, Debug, PartialEq)]
pub enum GratingProfileDesc {
    /// A sinusoidal relief.
    Sinusoidal {
        /// From valley to peak, nm.
        depth: f32,
        /// Index of its matter over that outside.
        ior: f32,
    },
    /// Efficiencies of the orders 0, ±1, ±2, ...
    Efficiencies(Vec<f32>),
}
