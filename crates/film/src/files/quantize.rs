//! From linear colour to display codes.

use std::path::Path;

use super::WriteOptions;
use crate::{ImageError, Picture, srgb};

/// RGB bytes, row after row: exposure, tone curve, clamp, sRGB curve, rounding.
pub(super) fn display_bytes(
    path: &Path,
    picture: &Picture,
    options: &WriteOptions,
) -> Result<Vec<u8>, ImageError> {
    quantized(path, picture, options, |v| (v * 255.0 + 0.5) as u8)
}

/// The same with 16 bits a channel.
pub(super) fn display_words(
    path: &Path,
    picture: &Picture,
    options: &WriteOptions,
) -> Result<Vec<u16>, ImageError> {
    quantized(path, picture, options, |v| (v * 65535.0 + 0.5) as u16)
}

fn quantized<T>(
    path: &Path,
    picture: &Picture,
    options: &WriteOptions,
    round: impl Fn(f32) -> T,
) -> Result<Vec<T>, ImageError> {
    let rgb = picture
        .rgb()
        .ok_or_else(|| ImageError::cannot_store(path, "the picture has no colour channels"))?;
    let scale = options.exposure.exp2();
    let display = |pixel: [f32; 3]| {
        let exposed = pixel.map(|v| v * scale);
        options.tone.map_or(exposed, |tone| tone(exposed))
    };
    let code = |v: f32| round(srgb::encode(finite_clamp(v, 1.0)));
    Ok(rgb.pixels().flat_map(|p| display(p).map(code)).collect())
}

/// The value in [0, `largest`]; NaN becomes 0.
pub(super) fn finite_clamp(v: f32, largest: f32) -> f32 {
    if v.is_nan() { 0.0 } else { v.clamp(0.0, largest) }
}
