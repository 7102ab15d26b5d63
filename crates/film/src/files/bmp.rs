//! Windows bitmaps: palette and true colour, plain or run-length encoded. Read only.

use std::io::Cursor;
use std::path::Path;

use image::codecs::bmp::BmpDecoder;
use kaustika_scene::description::Bitmap;

use super::Format;
use super::decode::{decode, image_error};
use crate::ImageError;

/// A run of 255 pixels takes two bytes.
const PIXELS_PER_BYTE: f64 = 128.0;

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Bitmap, ImageError> {
    // Of the oldest kind.
    const HEADER: usize = 26;
    if bytes.len() < HEADER {
        return Err(ImageError::truncated(path, Format::Bmp.name()));
    }
    let decoder =
        BmpDecoder::new(Cursor::new(bytes)).map_err(|e| image_error(path, Format::Bmp, e))?;
    decode(path, Format::Bmp, decoder, bytes.len(), PIXELS_PER_BYTE)
}
