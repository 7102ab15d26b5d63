//! Colour: the four-lane [`Spectrum`], the wavelengths a path carries, and everything that turns
//! what a scene file says about colour into values that transport code multiplies.
//!
//! The way of data: a reader makes a [`SpectrumDesc`]; the scene builder compiles it for a
//! [`SpectrumRole`] and a [`ColorMode`] into a [`CompiledSpectrum`]; a path evaluates that at its
//! [`Wavelengths`]; a [`Sensor`] turns what arrives into tristimulus values; a [`Tonemap`] and the
//! sRGB curve make a picture of them.
//!
//! Conventions, the same in both modes. Tristimulus values are XYZ = ∫ L(λ) (x̄, ȳ, z̄)(λ) dλ / ∫ ȳ dλ
//! (CIE 1931, 2° observer, 360 to 830 nm), so a flat spectrum of 1 has Y = 1 and illuminants are
//! normalised to Y = 1. RGB without a colour space named is linear sRGB.

pub mod cie;
mod color_space;
mod compiled;
mod dense;
mod desc;
mod illuminant;
mod matrix;
mod named;
mod photometry;
mod planck;
mod rgb_fit;
mod rgb_table;
mod sensor;
mod sigmoid;
mod sky;
mod spd;
mod spectrum;
#[cfg(test)]
mod testing;
mod tonemap;
mod transfer;
mod wavelengths;

pub use color_space::ColorSpace;
pub use compiled::{CompiledSpectrum, SpectrumRole};
pub use dense::DenseSpectrum;
pub use desc::{SampledError, SpectrumDesc};
pub use illuminant::{daylight, daylight_chromaticity, illuminant_a};
pub use matrix::Matrix3;
pub use named::{
    NamedSpectrum, conductor, conductor_names, ior_by_name, ior_names, named, names, suggest,
};
pub use photometry::{luminance_of, photometric_integral, rec709_luminance, xyz_of};
pub use planck::{blackbody, wien_peak};
pub use rgb_table::{RgbToSpectrum, eval_rgb_albedo, eval_rgb_illuminant, eval_rgb_unbounded};
pub use sensor::{Sensor, bradford_adaptation};
pub use sigmoid::SigmoidPolynomial;
pub use sky::{HosekSky, hosek_sun, preetham_sun};
pub use spd::{SpdError, SpdErrorKind, parse_spd};
pub use spectrum::Spectrum;
pub use tonemap::Tonemap;
pub use transfer::{linear_to_srgb, linear_to_srgb8, srgb_to_linear, srgb8_to_linear};
pub use wavelengths::{ColorMode, Wavelengths};
