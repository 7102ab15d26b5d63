//! Image files: one file a format, told apart by their first bytes.
//!
//! Reading never panics and never allocates more than the file can justify: headers are checked
//! against the length of the file first. Writing is atomic: a reader of the path sees the old
//! file or the new one, never a part.

mod atomic;
mod bmp;
mod decode;
mod exr;
mod exr_dwa;
mod exr_meta;
mod hdr;
mod jpeg;
mod pfm;
mod png;
mod quantize;
#[cfg(test)]
mod tests;
mod tga;

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use kaustika_scene::description::{Bitmap, Encoding, Texels};

pub use atomic::replace;

use crate::{ImageError, Picture, srgb};

/// A curve from scene-linear RGB (after exposure) to display-linear RGB in [0, 1].
pub type ToneCurve<'a> = &'a dyn Fn([f32; 3]) -> [f32; 3];

/// How pictures become files.
#[derive(Clone, Copy)]
pub struct WriteOptions<'a> {
    /// EXR: store `Float32` channels as 16-bit floats.
    pub half: bool,
    /// PNG, JPEG: stops of exposure before the tone curve, value · 2^exposure.
    pub exposure: f32,
    /// PNG, JPEG: the tone curve; `None` clamps to [0, 1].
    pub tone: Option<ToneCurve<'a>>,
    /// PNG: 16 instead of 8 bits a channel.
    pub sixteen_bit: bool,
    /// JPEG: quality, 1..=100.
    pub jpeg_quality: u8,
}

impl Default for WriteOptions<'_> {
    fn default() -> Self {
        WriteOptions {
            half: false,
            exposure: 0.0,
            tone: None,
            sixteen_bit: false,
            jpeg_quality: 95,
        }
    }
}

/// The formats known here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Png,
    Jpeg,
    Tga,
    Bmp,
    Exr,
    Hdr,
    Pfm,
}

impl Format {
    /// By the first bytes; TGA, which has no magic number, by its footer or the extension.
    fn detect(path: &Path, bytes: &[u8]) -> Option<Format> {
        const TGA_FOOTER: &[u8] = b"TRUEVISION-XFILE.\0";
        let by_name = Format::from_extension(path);
        match bytes {
            [0x89, b'P', b'N', b'G', ..] => Some(Format::Png),
            [0xff, 0xd8, 0xff, ..] => Some(Format::Jpeg),
            [b'B', b'M', ..] => Some(Format::Bmp),
            [0x76, 0x2f, 0x31, 0x01, ..] => Some(Format::Exr),
            [b'#', b'?', ..] => Some(Format::Hdr),
            [b'P', b'F' | b'f', b, ..] if b.is_ascii_whitespace() => Some(Format::Pfm),
            _ if bytes.ends_with(TGA_FOOTER) => Some(Format::Tga),
            _ if by_name == Some(Format::Tga) => Some(Format::Tga),
            // Too short for its magic number: let the decoder of that name report it.
            _ if bytes.len() < 4 => by_name,
            _ => None,
        }
    }

    fn from_extension(path: &Path) -> Option<Format> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "png" => Some(Format::Png),
            "jpg" | "jpeg" => Some(Format::Jpeg),
            "tga" => Some(Format::Tga),
            "bmp" => Some(Format::Bmp),
            "exr" => Some(Format::Exr),
            "hdr" | "rgbe" | "pic" => Some(Format::Hdr),
            "pfm" => Some(Format::Pfm),
            _ => None,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Format::Png => "PNG",
            Format::Jpeg => "JPEG",
            Format::Tga => "TGA",
            Format::Bmp => "BMP",
            Format::Exr => "EXR",
            Format::Hdr => "HDR",
            Format::Pfm => "PFM",
        }
    }
}

/// Reads all channels of an image file as linear floats.
///
/// 8- and 16-bit files are decoded from the sRGB curve (alpha is taken as it is); their channels
/// are named `R G B A` or `Y A`. EXR files keep names, number formats and metadata.
pub fn read_picture(path: impl AsRef<Path>) -> Result<Picture, ImageError> {
    let path = path.as_ref();
    let (format, bytes) = load(path)?;
    shielded(path, format, || match format {
        Format::Exr => exr::read(path, &bytes),
        _ => decode_bitmap(path, format, &bytes).map(|bitmap| linear_picture(&bitmap)),
    })
}

/// Reads an image file as texels for textures and environment lights: 8-bit files stay 8-bit.
///
/// PNG, JPEG, TGA and BMP are taken to be sRGB-encoded, EXR, HDR and PFM to be linear. Of an EXR
/// file's channels the colour (as [`Picture::rgb`] finds it) and its alpha are taken.
pub fn read_bitmap(path: impl AsRef<Path>) -> Result<Bitmap, ImageError> {
    let path = path.as_ref();
    bitmap_from_bytes(path, &fs::read(path).map_err(|e| ImageError::io(path, e))?)
}

/// As [`read_bitmap`], of a file's contents; `name` is what errors call it.
pub fn bitmap_from_bytes(name: impl AsRef<Path>, bytes: &[u8]) -> Result<Bitmap, ImageError> {
    let name = name.as_ref();
    let format = Format::detect(name, bytes)
        .ok_or_else(|| ImageError::UnknownFormat { path: name.into() })?;
    shielded(name, format, || decode_bitmap(name, format, bytes))
}

/// Writes a picture in the format of the path's extension: `exr` (all channels and metadata),
/// `png`, `jpg` (display-encoded colour), `hdr` or `pfm` (linear colour).
///
/// The file appears under its name only when complete; on failure an older file stays as it was.
pub fn write_picture(
    path: impl AsRef<Path>,
    picture: &Picture,
    options: &WriteOptions,
) -> Result<(), ImageError> {
    let path = path.as_ref();
    if let Some(defect) = picture.defect() {
        return Err(ImageError::cannot_store(path, defect));
    }
    let bytes = match Format::from_extension(path) {
        Some(Format::Exr) => exr::write(path, picture, options),
        Some(Format::Png) => png::write(path, picture, options),
        Some(Format::Jpeg) => jpeg::write(path, picture, options),
        Some(Format::Hdr) => hdr::write(path, picture),
        Some(Format::Pfm) => pfm::write(path, picture),
        Some(Format::Tga | Format::Bmp) | None => Err(ImageError::cannot_store(
            path,
            "cannot write this extension (exr, png, jpg, hdr and pfm can be written)",
        )),
    }?;
    atomic::replace(path, &bytes).map_err(|e| ImageError::io(path, e))
}

fn load(path: &Path) -> Result<(Format, Vec<u8>), ImageError> {
    let bytes = fs::read(path).map_err(|e| ImageError::io(path, e))?;
    let format = Format::detect(path, &bytes)
        .ok_or_else(|| ImageError::UnknownFormat { path: path.into() })?;
    Ok((format, bytes))
}

fn decode_bitmap(path: &Path, format: Format, bytes: &[u8]) -> Result<Bitmap, ImageError> {
    match format {
        Format::Png => png::read(path, bytes),
        Format::Jpeg => jpeg::read(path, bytes),
        Format::Tga => tga::read(path, bytes),
        Format::Bmp => bmp::read(path, bytes),
        Format::Hdr => hdr::read(path, bytes),
        Format::Pfm => pfm::read(path, bytes),
        Format::Exr => exr::read_colour(path, bytes),
    }
}

/// Turns a panic of a foreign decoder into an error: a broken texture must not end the program.
fn shielded<T>(
    path: &Path,
    format: Format,
    decode: impl FnOnce() -> Result<T, ImageError>,
) -> Result<T, ImageError> {
    // Unwind safety: the closure only reads shared data and its result is dropped on a panic.
    catch_unwind(AssertUnwindSafe(decode)).unwrap_or_else(|_| {
        let cause = "the decoder gave up on it";
        Err(ImageError::malformed(path, format.name(), cause))
    })
}

/// Most pixels any image may have.
const MAX_PIXELS: u64 = 1 << 31;

/// Checks a header's size before anything is allocated: at most 2³¹ pixels, and at most
/// `pixels_per_byte` for each of the file's `file_len` bytes.
fn check_size(
    path: &Path,
    format: Format,
    (width, height): (u64, u64),
    file_len: usize,
    pixels_per_byte: f64,
) -> Result<(), ImageError> {
    let pixels = width as f64 * height as f64;
    let too_large = |cause| ImageError::TooLarge { path: path.into(), width, height, cause };
    if pixels == 0.0 {
        return Err(ImageError::malformed(path, format.name(), "no pixels"));
    }
    if pixels > MAX_PIXELS as f64 || width > u32::MAX as u64 || height > u32::MAX as u64 {
        return Err(too_large("more than the 2^31 allowed"));
    }
    if pixels > file_len as f64 * pixels_per_byte {
        return Err(too_large("more than a file of this length can hold"));
    }
    Ok(())
}

/// Channel names of a bitmap with `channels` channels.
fn bitmap_channel_names(channels: u32) -> &'static [&'static str] {
    match channels {
        1 => &["Y"],
        2 => &["Y", "A"],
        3 => &["R", "G", "B"],
        _ => &["R", "G", "B", "A"],
    }
}

/// The linear values of a bitmap.
fn linear_picture(bitmap: &Bitmap) -> Picture {
    let linear = |v: f32| match bitmap.encoding {
        Encoding::Linear => v,
        Encoding::Srgb => srgb::decode(v),
        Encoding::Gamma(g) => v.powf(g),
    };
    let channel = |c: usize, is_alpha: bool| -> Vec<f32> {
        let curve = |v: f32| if is_alpha { v } else { linear(v) };
        let n = bitmap.channels as usize;
        match &bitmap.texels {
            Texels::U8(t) => {
                let table: Vec<f32> = (0..256).map(|i| curve(i as f32 / 255.0)).collect();
                t.iter().skip(c).step_by(n).map(|&v| table[v as usize]).collect()
            }
            Texels::U16(t) => {
                t.iter().skip(c).step_by(n).map(|&v| curve(v as f32 / 65535.0)).collect()
            }
            Texels::F32(t) => t.iter().skip(c).step_by(n).map(|&v| curve(v)).collect(),
        }
    };
    let mut picture = Picture::new(bitmap.width, bitmap.height);
    for (c, name) in bitmap_channel_names(bitmap.channels).iter().enumerate() {
        picture.push(*name, channel(c, *name == "A"));
    }
    picture
}
