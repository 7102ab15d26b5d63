//! A look at the chunks of DWA-compressed EXR files before they are unpacked: each starts with
//! sizes of what it holds, which the decoder would allocate unseen.

use std::io::Cursor;
use std::path::Path;

use exr::block::chunk::CompressedBlock;
use exr::meta::attribute::Compression;
use exr::meta::header::Header;

use super::Format;
use crate::ImageError;

/// Refuses chunks whose sizes exceed what their rectangle of pixels can need.
pub(super) fn check_chunks(
    path: &Path,
    headers: &[Header],
    bytes: &[u8],
) -> Result<(), ImageError> {
    let is_dwa = |h: &Header| matches!(h.compression, Compression::DWAA(_) | Compression::DWAB(_));
    if !headers.iter().any(is_dwa) {
        return Ok(());
    }
    match chunks_are_plausible(headers, bytes, is_dwa) {
        Ok(true) => Ok(()),
        Ok(false) => {
            let cause = "a chunk claims more data than its pixels can need";
            Err(ImageError::malformed(path, Format::Exr.name(), cause))
        }
        Err(e) => Err(super::exr::exr_error(path, e)),
    }
}

fn chunks_are_plausible(
    headers: &[Header],
    bytes: &[u8],
    is_dwa: impl Fn(&Header) -> bool,
) -> exr::error::Result<bool> {
    for chunk in exr::block::read(Cursor::new(bytes), false)?.all_chunks(false)? {
        let chunk = chunk?;
        let Some(header) = headers.get(chunk.layer_index).filter(|h| is_dwa(h)) else {
            continue;
        };
        let data = match &chunk.compressed_block {
            CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
            CompressedBlock::Tile(block) => &block.compressed_pixels_le,
            CompressedBlock::DeepScanLine(_) | CompressedBlock::DeepTile(_) => continue,
        };
        let index = header.get_block_data_indices(&chunk.compressed_block)?;
        let size = header.get_absolute_block_pixel_coordinates(index)?.size;
        let is_stored_raw = data.len() == size.area() * header.channels.bytes_per_pixel;
        if !is_stored_raw && !sizes_are_plausible(data, size.0, size.1, header) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The eleven counters at the head of a chunk (OpenEXR's `DataSizesSingle`); those at 1, 6 and 7
/// are bytes after unpacking, those at 8 and 9 numbers of cosine coefficients.
fn sizes_are_plausible(data: &[u8], width: usize, height: usize, header: &Header) -> bool {
    let counters = data.as_chunks::<8>().0;
    // Blocks of 8 x 8 reach over the edge; 4 bytes a value, doubled by the worst run lengths.
    let values = (width + 7) * (height + 7) * header.channels.list.len();
    let limit = 8 * values as u64;
    let unpacked = [1, 6, 7, 8, 9].into_iter().filter_map(|i| counters.get(i));
    unpacked.map(|&b| u64::from_le_bytes(b)).all(|n| n <= limit)
}
