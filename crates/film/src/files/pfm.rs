//! Portable float map: `PF` (RGB) or `Pf` (grey), rows from the bottom up; the sign of the scale
//! tells the byte order, its magnitude multiplies the values (as pbrt reads it).

use std::path::Path;
use std::str;

use kaustika_scene::description::{Bitmap, Encoding, Texels};

use super::{Format, check_size};
use crate::{ImageError, Picture};

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Bitmap, ImageError> {
    let malformed = |cause: &str| ImageError::malformed(path, Format::Pfm.name(), cause);
    let truncated = || ImageError::truncated(path, Format::Pfm.name());
    let mut rest = bytes;
    let channels: usize = match word(&mut rest).ok_or_else(truncated)? {
        "PF" => 3,
        "Pf" => 1,
        _ => return Err(malformed("it starts neither with PF nor with Pf")),
    };
    let mut number = |what: &str| -> Result<f64, ImageError> {
        let word = word(&mut rest).ok_or_else(truncated)?;
        let bad = || malformed(&format!("{what} '{}' is not a number", word.escape_debug()));
        word.parse().map_err(|_| bad())
    };
    let (width, height, scale) = (number("width")?, number("height")?, number("scale")?);
    if !(width >= 0.0 && height >= 0.0 && width.fract() == 0.0 && height.fract() == 0.0) {
        return Err(malformed("the size is not made of whole numbers"));
    }
    if scale == 0.0 || !scale.is_finite() {
        return Err(malformed("the scale is zero or not finite"));
    }
    // A float cast saturates, so that any absurd size is caught here.
    let size = (width as u64, height as u64);
    check_size(path, Format::Pfm, size, usize::MAX, 1.0)?;
    let row = width as usize * channels;
    let data = rest.as_chunks::<4>().0;
    let data = data.get(..row * height as usize).ok_or_else(truncated)?;

    let from_bytes = if scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes };
    let factor = scale.abs() as f32;
    let rows_from_top = data.chunks_exact(row).rev();
    let texels = rows_from_top.flatten().map(|&b| from_bytes(b) * factor).collect();
    Ok(Bitmap {
        width: width as u32,
        height: height as u32,
        channels: channels as u32,
        texels: Texels::F32(texels),
        encoding: Encoding::Linear,
    })
}

/// The next word of the header and the one white-space character behind it.
fn word<'a>(rest: &mut &'a [u8]) -> Option<&'a str> {
    /// Longer "words" are pixel data of a broken file.
    const LONGEST: usize = 32;
    let start = rest.iter().position(|b| !b.is_ascii_whitespace())?;
    let text = &rest[start..];
    let end = text.iter().take(LONGEST).position(u8::is_ascii_whitespace)?;
    *rest = &text[end + 1..];
    str::from_utf8(&text[..end]).ok()
}

/// Little endian; one channel if the picture has only one, RGB otherwise.
pub(super) fn write(path: &Path, picture: &Picture) -> Result<Vec<u8>, ImageError> {
    let rgb = picture
        .rgb()
        .ok_or_else(|| ImageError::cannot_store(path, "the picture has no colour channels"))?;
    let (magic, planes) = match picture.channels.len() {
        1 => ("Pf", &rgb.channels[..1]),
        _ => ("PF", &rgb.channels[..]),
    };
    let mut out = format!("{magic}\n{} {}\n-1.0\n", rgb.width, rgb.height).into_bytes();
    for y in (0..rgb.height).rev() {
        for i in y * rgb.width..(y + 1) * rgb.width {
            out.extend(planes.iter().flat_map(|plane| plane[i].to_le_bytes()));
        }
    }
    Ok(out)
}
