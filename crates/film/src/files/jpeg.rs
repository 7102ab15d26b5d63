//! JPEG (ITU-T T.81): grey and RGB; CMYK and YCCK are converted to RGB.

use std::io::Cursor;
use std::path::Path;

use image::codecs::jpeg::{JpegDecoder, JpegEncoder};
use image::{ExtendedColorType, ImageEncoder};
use kaustika_scene::description::Bitmap;

use super::decode::{decode, image_error};
use super::quantize::display_bytes;
use super::{Format, WriteOptions};
use crate::{ImageError, Picture};

/// A block of 64 pixels takes at least the bit of its DC code; doubled to be on the safe side.
const PIXELS_PER_BYTE: f64 = 2.0 * 64.0 * 8.0;

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Bitmap, ImageError> {
    // The decoder fills what is missing with grey; a half texture should be an error instead.
    if !has_end_of_image(bytes) {
        return Err(ImageError::truncated(path, Format::Jpeg.name()));
    }
    let decoder =
        JpegDecoder::new(Cursor::new(bytes)).map_err(|e| image_error(path, Format::Jpeg, e))?;
    decode(path, Format::Jpeg, decoder, bytes.len(), PIXELS_PER_BYTE)
}

/// Follows the markers (T.81 annex B) to the end-of-image marker of the image itself: a
/// thumbnail inside an application segment has one of its own.
fn has_end_of_image(bytes: &[u8]) -> bool {
    const END_OF_IMAGE: u8 = 0xd9;
    let mut i = 2;
    while let (Some(&marker_start), Some(&code)) = (bytes.get(i), bytes.get(i + 1)) {
        match (marker_start, code) {
            (0xff, END_OF_IMAGE) => return true,
            // Fill bytes may precede a marker; stuffed zeros, restarts and TEM have no length.
            (0xff, 0xff) => i += 1,
            (0xff, 0x00 | 0x01 | 0xd0..=0xd8) => i += 2,
            (0xff, _) => match (bytes.get(i + 2), bytes.get(i + 3)) {
                (Some(&high), Some(&low)) => i += 2 + u16::from_be_bytes([high, low]) as usize,
                _ => return false,
            },
            // Entropy-coded data.
            _ => i += 1,
        }
    }
    false
}

pub(super) fn write(
    path: &Path,
    picture: &Picture,
    options: &WriteOptions,
) -> Result<Vec<u8>, ImageError> {
    let data = display_bytes(path, picture, options)?;
    let mut out = Vec::new();
    JpegEncoder::new_with_quality(&mut out, options.jpeg_quality.clamp(1, 100))
        .write_image(&data, picture.width, picture.height, ExtendedColorType::Rgb8)
        .map_err(|e| ImageError::cannot_store(path, e))?;
    Ok(out)
}
