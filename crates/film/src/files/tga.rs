//! Truevision TGA 2.0: grey, palette and true colour, plain or run-length encoded. Read only.

use std::io::Cursor;
use std::path::Path;

use image::codecs::tga::TgaDecoder;
use kaustika_scene::description::Bitmap;

use super::Format;
use super::decode::{decode, image_error};
use crate::ImageError;

/// A run of 128 pixels takes at least two bytes.
const PIXELS_PER_BYTE: f64 = 64.0;

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Bitmap, ImageError> {
    const HEADER: usize = 18;
    if bytes.len() < HEADER {
        return Err(ImageError::truncated(path, Format::Tga.name()));
    }
    let decoder =
        TgaDecoder::new(Cursor::new(bytes)).map_err(|e| image_error(path, Format::Tga, e))?;
    decode(path, Format::Tga, decoder, bytes.len(), PIXELS_PER_BYTE)
}
