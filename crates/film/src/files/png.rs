//! PNG (ISO/IEC 15948): grey, grey-alpha, RGB and RGBA of 8 and 16 bits; palettes and lower
//! depths are expanded to 8 bits, transparent colours to an alpha channel.

use std::io::Cursor;
use std::path::Path;

use image::codecs::png::{PngDecoder, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use kaustika_scene::description::Bitmap;

use super::decode::{decode, image_error};
use super::quantize::{display_bytes, display_words};
use super::{Format, WriteOptions};
use crate::{ImageError, Picture};

/// Deflate expands at most 1032-fold, to eight 1-bit pixels a byte.
const PIXELS_PER_BYTE: f64 = 1032.0 * 8.0;

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Bitmap, ImageError> {
    let decoder =
        PngDecoder::new(Cursor::new(bytes)).map_err(|e| image_error(path, Format::Png, e))?;
    decode(path, Format::Png, decoder, bytes.len(), PIXELS_PER_BYTE)
}

pub(super) fn write(
    path: &Path,
    picture: &Picture,
    options: &WriteOptions,
) -> Result<Vec<u8>, ImageError> {
    let (data, color) = if options.sixteen_bit {
        let words = display_words(path, picture, options)?;
        let bytes = words.into_iter().flat_map(u16::to_ne_bytes).collect();
        (bytes, ExtendedColorType::Rgb16)
    } else {
        let bytes = display_bytes(path, picture, options)?;
        (bytes, ExtendedColorType::Rgb8)
    };
    let mut out = Vec::new();
    PngEncoder::new(&mut out)
        .write_image(&data, picture.width, picture.height, color)
        .map_err(|e| ImageError::cannot_store(path, e))?;
    Ok(out)
}
