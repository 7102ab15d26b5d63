//! OpenEXR, scan lines or tiles, any compression of the `exr` crate. Deep and sub-sampled images
//! are not handled; of mip maps the finest level is read.
//!
//! A file of several parts is read as one picture: the first part's channels keep their names,
//! those of further parts with the same data window get the part's name as a layer. Parts with
//! another data window are left out.

use std::io::Cursor;
use std::path::Path;

use exr::image::{
    AnyChannel, AnyChannels, Blocks, Encoding as ExrEncoding, FlatSamples, Image, Layer,
};
use exr::meta::MetaData;
use exr::meta::attribute::{Compression, IntegerBounds, LineOrder, Text};
use exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use exr::prelude::{
    ReadChannels, ReadLayers, SmallVec, Vec2, WritableImage, f16, read as exr_read,
};
use kaustika_scene::description::{Bitmap, Encoding, Texels};

use super::exr_dwa::check_chunks;
use super::exr_meta::{read_metadata, store_metadata};
use super::{Format, WriteOptions, check_size};
use crate::{Channel, ChannelKind, ImageError, Picture};

/// Reads all channels and the metadata.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Picture, ImageError> {
    let fail = |e| exr_error(path, e);
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(fail)?;
    for header in &meta.headers {
        check_header(path, header, bytes.len())?;
    }
    check_chunks(path, &meta.headers, bytes)?;
    let image = exr_read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(fail)?;

    let empty = || ImageError::malformed(path, Format::Exr.name(), "no parts");
    let header = meta.headers.first().ok_or_else(empty)?;
    let window = header.data_window();
    let mut picture = Picture::new(window.size.0 as u32, window.size.1 as u32);
    picture.data_origin = [window.position.0, window.position.1];
    let display = header.shared_attributes.display_window;
    picture.display_window = (display != window).then(|| corners(display));
    picture.metadata = read_metadata(header);
    let parts = image.layer_data.into_iter().zip(&meta.headers).enumerate();
    for (i, (part, header)) in parts {
        if header.data_window() != window {
            continue;
        }
        let layer = match &header.own_attributes.layer_name {
            Some(name) if i > 0 => format!("{}.", String::from_utf8_lossy(name.as_slice())),
            _ => String::new(),
        };
        for channel in part.channel_data.list {
            add_channel(&mut picture, &layer, channel);
        }
    }
    match picture.defect() {
        None => Ok(picture),
        Some(defect) => Err(ImageError::malformed(path, Format::Exr.name(), defect)),
    }
}

/// Appends a channel; a layer prefix that the name has already is not repeated.
fn add_channel(picture: &mut Picture, layer: &str, channel: AnyChannel<FlatSamples>) {
    let own = String::from_utf8_lossy(channel.name.as_slice());
    let name = if own.starts_with(layer) { own.into_owned() } else { format!("{layer}{own}") };
    let (data, kind) = match channel.sample_data {
        FlatSamples::F32(v) => (v, ChannelKind::Float32),
        FlatSamples::F16(v) => (v.iter().map(|h| h.to_f32()).collect(), ChannelKind::Half),
        FlatSamples::U32(v) => (v.iter().map(|&u| u as f32).collect(), ChannelKind::Uint),
    };
    picture.channels.push(Channel { name, data, kind });
}

/// Refuses what is not handled, and sizes that the file's length cannot justify.
fn check_header(path: &Path, header: &Header, file_len: usize) -> Result<(), ImageError> {
    let unsupported = |cause| Err(ImageError::unsupported(path, Format::Exr.name(), cause));
    if header.deep {
        return unsupported("deep images are not handled");
    }
    if header.channels.list.iter().any(|c| c.sampling != Vec2(1, 1)) {
        return unsupported("sub-sampled channels are not handled");
    }
    // Most bytes that one byte of a chunk can unfold to. Deflate: 1032 (PXR24 leaves out one
    // byte of four before). Runs: 128 values in two bytes. The others: a generous guess.
    let expansion = match header.compression {
        Compression::Uncompressed => 1.0,
        Compression::RLE => 64.0,
        Compression::ZIP1 | Compression::ZIP16 => 1032.0,
        Compression::PXR24 => 1376.0,
        _ => 65536.0,
    };
    let size = (header.layer_size.0 as u64, header.layer_size.1 as u64);
    let pixels_per_byte = expansion / header.channels.bytes_per_pixel.max(1) as f64;
    check_size(path, Format::Exr, size, file_len, pixels_per_byte)?;
    // Each chunk has an entry of 8 bytes in the offset table, and at least a position and a size.
    if header.chunk_count as u64 > file_len as u64 / 16 {
        return Err(ImageError::truncated(path, Format::Exr.name()));
    }
    Ok(())
}

/// The colour (and alpha, if there is one) as texels.
pub(super) fn read_colour(path: &Path, bytes: &[u8]) -> Result<Bitmap, ImageError> {
    let picture = read(path, bytes)?;
    let Some(rgb) = picture.rgb() else {
        let names: Vec<&str> = picture.channels.iter().map(|c| c.name.as_str()).collect();
        let cause = format!("no colour among the channels ({})", names.join(" "));
        return Err(ImageError::unsupported(path, Format::Exr.name(), cause));
    };
    let [r, g, b] = rgb.channels;
    let is_grey = std::ptr::eq(r, g);
    let mut planes = if is_grey { vec![r] } else { vec![r, g, b] };
    let is_plain = ["R", "Y"].iter().any(|name| picture.channel(name).is_some());
    planes.extend(picture.channel("A").filter(|_| is_plain));
    let texels = (0..rgb.len()).flat_map(|i| planes.iter().map(move |plane| plane[i]));
    Ok(Bitmap {
        width: picture.width,
        height: picture.height,
        channels: planes.len() as u32,
        texels: Texels::F32(texels.collect()),
        encoding: Encoding::Linear,
    })
}

/// One part, scan lines, ZIP in blocks of 16 rows. The format sorts channels by name.
pub(super) fn write(
    path: &Path,
    picture: &Picture,
    options: &WriteOptions,
) -> Result<Vec<u8>, ImageError> {
    let mut list = SmallVec::new();
    for channel in &picture.channels {
        if channel.name.is_empty() || channel.name.len() > 255 || channel.name.contains('\0') {
            let cause = format!("'{}' is no EXR channel name", channel.name.escape_debug());
            return Err(ImageError::cannot_store(path, cause));
        }
        let name = Text::from_slice_unchecked(channel.name.as_bytes());
        list.push(AnyChannel::new(name, samples(channel, options.half)));
    }
    let size = Vec2(picture.width as usize, picture.height as usize);
    let [x, y] = picture.data_origin;
    let window = IntegerBounds::new((x, y), size);
    let display = match picture.display_window {
        None => window,
        Some([x0, y0, x1, y1]) => {
            let extent = |a: i32, b: i32| usize::try_from(b as i64 - a as i64).unwrap_or(0);
            IntegerBounds::new((x0, y0), (extent(x0, x1), extent(y0, y1)))
        }
    };
    let mut of_image = ImageAttributes::new(display);
    let mut of_layer = LayerAttributes::default().with_position(window.position);
    store_metadata(path, &picture.metadata, &mut of_image, &mut of_layer)?;
    let encoding = ExrEncoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new(size, of_layer, encoding, AnyChannels::sort(list));
    let image = Image::empty(of_image).with_layer(layer);
    let mut out = Cursor::new(Vec::new());
    image.write().to_buffered(&mut out).map_err(|e| ImageError::cannot_store(path, e))?;
    Ok(out.into_inner())
}

fn samples(channel: &Channel, half: bool) -> FlatSamples {
    let data = &channel.data;
    match channel.kind {
        ChannelKind::Float32 if !half => FlatSamples::F32(data.clone()),
        ChannelKind::Float32 | ChannelKind::Half => {
            FlatSamples::F16(data.iter().map(|&v| f16::from_f32(v)).collect())
        }
        ChannelKind::Uint => FlatSamples::U32(data.iter().map(|&v| v as u32).collect()),
    }
}

fn corners(window: IntegerBounds) -> [i32; 4] {
    let (start, end) = (window.position, window.end());
    [start.0, start.1, end.0, end.1]
}

pub(super) fn exr_error(path: &Path, error: exr::error::Error) -> ImageError {
    use exr::error::Error;
    match error {
        Error::NotSupported(cause) => ImageError::unsupported(path, Format::Exr.name(), cause),
        // The crate's words for an unexpected end of the file.
        Error::Invalid(cause) if cause == "reference to missing bytes" => {
            ImageError::truncated(path, Format::Exr.name())
        }
        Error::Invalid(cause) => ImageError::malformed(path, Format::Exr.name(), cause),
        Error::Io(e) => ImageError::malformed(path, Format::Exr.name(), e),
        Error::Aborted => ImageError::malformed(path, Format::Exr.name(), "cancelled"),
    }
}
