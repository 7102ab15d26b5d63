//! Radiance RGBE (Ward 1991, "Real Pixels"): shared-exponent RGB, top-left orientation.
//!
//! The `EXPOSURE` header is not applied, as in pbrt and Mitsuba.

use std::io::Cursor;
use std::path::Path;

use image::Rgb;
use image::codecs::hdr::{HdrDecoder, HdrEncoder};
use kaustika_scene::description::Bitmap;

use super::Format;
use super::decode::{decode, image_error};
use super::quantize::finite_clamp;
use crate::{ImageError, Picture};

/// Two chained run markers of the old scheme (8 bytes) stand for up to 2¹⁶ pixels.
const PIXELS_PER_BYTE: f64 = 8192.0;

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Bitmap, ImageError> {
    let decoder =
        HdrDecoder::new(Cursor::new(bytes)).map_err(|e| image_error(path, Format::Hdr, e))?;
    decode(path, Format::Hdr, decoder, bytes.len(), PIXELS_PER_BYTE)
}

/// Negative values and NaN, which RGBE cannot hold, become zero; infinities the largest value.
pub(super) fn write(path: &Path, picture: &Picture) -> Result<Vec<u8>, ImageError> {
    /// The largest mantissa at the largest exponent.
    const LARGEST: f32 = 1.69e38;
    let rgb = picture
        .rgb()
        .ok_or_else(|| ImageError::cannot_store(path, "the picture has no colour channels"))?;
    let texels: Vec<Rgb<f32>> =
        rgb.pixels().map(|p| Rgb(p.map(|v| finite_clamp(v, LARGEST)))).collect();
    let mut out = Vec::new();
    HdrEncoder::new(&mut out)
        .encode(&texels, rgb.width, rgb.height)
        .map_err(|e| ImageError::cannot_store(path, e))?;
    Ok(out)
}
