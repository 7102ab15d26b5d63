//! Measured reflectance, as its files have it.

use std::sync::Arc;

/// A BRDF in the adaptive parameterisation of Dupuy & Jakob 2018: unit squares of half vectors and
/// of samples for each direction seen from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasuredBrdf {
    /// Azimuths of the directions seen from, radians, increasing; at most two: isotropic.
    pub phi: Vec<f32>,
    /// Their angles from the normal, radians, increasing.
    pub theta: Vec<f32>,
    /// Distribution of normals over the half vector's square.
    pub ndf: SquareTable,
    /// Projected area of the facets over the square of directions.
    pub sigma: SquareTable,
    /// Density of visible normals over the half vector's square, a square for each φ and θ (θ
    /// runs faster).
    pub vndf: SquareTable,
    /// Density of samples, likewise.
    pub luminance: SquareTable,
    /// Reflectance over the square of samples, a square for each φ, θ and channel (channels run
    /// fastest).
    pub reflectance: SquareTable,
    /// What the channels are.
    pub channels: MeasuredChannels,
    /// True: values are relative to the density of half vectors, false: they are f |cos θᵢ|.
    pub jacobian: bool,
}

/// Values at the nodes of a regular grid over the unit square, one grid or several.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SquareTable {
    /// Nodes along x, at least 2.
    pub width: usize,
    /// Nodes along y, at least 2.
    pub height: usize,
    /// Rows of growing y, grid after grid.
    pub values: Vec<f32>,
}

/// Channels of a measurement.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum MeasuredChannels {
    /// Linear sRGB.
    #[default]
    Rgb,
    /// Values at these wavelengths, nm, increasing.
    Wavelengths(Vec<f32>),
}

impl MeasuredChannels {
    /// How many there are.
    pub fn count(&self) -> usize {
        match self {
            MeasuredChannels::Rgb => 3,
            MeasuredChannels::Wavelengths(l) => l.len(),
        }
    }
}

/// A pBRDF (Baek et al. 2020): Mueller matrices over Rusinkiewicz's angles and wavelengths.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasuredMueller {
    /// Azimuths of the difference vector, radians, increasing.
    pub phi_d: Vec<f32>,
    /// Its angles from the half vector, radians, increasing.
    pub theta_d: Vec<f32>,
    /// Angles of the half vector from the normal, radians, increasing.
    pub theta_h: Vec<f32>,
    /// nm, increasing.
    pub wavelengths: Vec<f32>,
    /// Matrices row by row, 1/sr, of φ_d, θ_d, θ_h and wavelength, which runs fastest; NaN where
    /// nothing was measured. Frames: x the normal of the plane of both directions.
    pub values: Vec<f32>,
}

/// A measured material that polarizes.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredPolarizedDesc {
    /// What was measured.
    pub table: Arc<MeasuredMueller>,
    /// Roughness of the GGX facets that directions are drawn by, > 0.
    pub alpha: f32,
    /// nm: the material is as there at every wavelength.
    pub wavelength: Option<f32>,
}
