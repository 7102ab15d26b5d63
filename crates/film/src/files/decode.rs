//! From the `image` crate's decoders to bitmaps.

use std::error::Error;
use std::io;
use std::path::Path;

use image::{ColorType, ImageDecoder};
use kaustika_scene::description::{Bitmap, Encoding, Texels};

use super::{Format, check_size};
use crate::ImageError;

/// Decodes all texels, after checking the size (see [`check_size`] for `pixels_per_byte`).
pub(super) fn decode(
    path: &Path,
    format: Format,
    decoder: impl ImageDecoder,
    file_len: usize,
    pixels_per_byte: f64,
) -> Result<Bitmap, ImageError> {
    let (width, height) = decoder.dimensions();
    let size = (width as u64, height as u64);
    check_size(path, format, size, file_len, pixels_per_byte)?;
    let color = decoder.color_type();
    let mut bytes = vec![0; decoder.total_bytes() as usize];
    decoder.read_image(&mut bytes).map_err(|e| image_error(path, format, e))?;
    let texels = match color {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => Texels::U8(bytes),
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            let pairs = bytes.as_chunks::<2>().0;
            Texels::U16(pairs.iter().map(|&b| u16::from_ne_bytes(b)).collect())
        }
        ColorType::Rgb32F | ColorType::Rgba32F => {
            let quads = bytes.as_chunks::<4>().0;
            Texels::F32(quads.iter().map(|&b| f32::from_ne_bytes(b)).collect())
        }
        other => {
            let cause = format!("texels of type {other:?} are not handled");
            return Err(ImageError::unsupported(path, format.name(), cause));
        }
    };
    Ok(Bitmap {
        width,
        height,
        channels: color.channel_count() as u32,
        encoding: match texels {
            Texels::F32(_) => Encoding::Linear,
            Texels::U8(_) | Texels::U16(_) => Encoding::Srgb,
        },
        texels,
    })
}

/// Our error for one of the `image` crate.
pub(super) fn image_error(path: &Path, format: Format, error: image::ImageError) -> ImageError {
    let mut cause: Option<&(dyn Error + 'static)> = Some(&error);
    while let Some(e) = cause {
        let io = e.downcast_ref::<io::Error>();
        if io.is_some_and(|io| io.kind() == io::ErrorKind::UnexpectedEof) {
            return ImageError::truncated(path, format.name());
        }
        cause = e.source();
    }
    match error {
        image::ImageError::Unsupported(e) => ImageError::unsupported(path, format.name(), e),
        e => ImageError::malformed(path, format.name(), e),
    }
}
