//! NanoVDB files: sparse grids of numbers (Museth 2021, "NanoVDB: a GPU-friendly and portable VDB
//! data structure for real-time rendering and simulation").
//!
//! ```text
//! file    = segment ...
//! segment = header (16 bytes)  (metadata (176 bytes)  name) ...  grid ...
//! header  = u64 "NanoVDB0" or "NanoVDB2"  u32 version  u16 grids  u16 codec
//! ```
//!
//! Little-endian; the layout is that of `FileHeader` and `FileMetaData` in NanoVDB.h of version
//! 32. Read are grids of `float`, as they are or deflated (codec 1); pbrt-v4 reads no others.

mod tree;

#[cfg(test)]
mod tests;

use std::io::Read;
use std::path::Path;

pub(crate) use tree::DenseGrid;

const HEADER: usize = 16;
const METADATA: usize = 176;
/// The type `float` of a grid.
const FLOAT: u32 = 1;
/// Classes that describe an amount of something: unknown and fog.
const AMOUNTS: [u32; 2] = [0, 2];

/// One grid of a file, still packed.
struct Packed<'a> {
    name: String,
    kind: u32,
    class: u32,
    codec: u16,
    /// Bytes when unpacked.
    size: u64,
    bytes: &'a [u8],
}

/// A file's grids.
pub(crate) struct NanoVdbFile {
    bytes: Vec<u8>,
}

impl NanoVdbFile {
    /// Reads a file. An error is a one-line cause.
    pub(crate) fn read(path: &Path) -> Result<NanoVdbFile, String> {
        let bytes = std::fs::read(path).map_err(|e| e.to_string())?;
        let file = NanoVdbFile { bytes };
        file.grids()?;
        Ok(file)
    }

    /// The samples of the grid with this name; `None` if there is none.
    pub(crate) fn grid(&self, name: &str) -> Result<Option<DenseGrid>, String> {
        let grids = self.grids()?;
        let Some(packed) = grids.iter().find(|g| g.name == name) else { return Ok(None) };
        let dense = packed.unpack().and_then(|bytes| tree::dense(&bytes));
        dense.map(Some).map_err(|cause| format!("grid `{name}`: {cause}"))
    }

    /// The names of all grids.
    pub(crate) fn names(&self) -> Vec<String> {
        self.grids().unwrap_or_default().into_iter().map(|g| g.name).collect()
    }

    fn grids(&self) -> Result<Vec<Packed<'_>>, String> {
        let mut rest = self.bytes.as_slice();
        let mut grids = Vec::new();
        while !rest.is_empty() {
            let header = take(&mut rest, HEADER)?;
            if !header.starts_with(b"NanoVDB") || !matches!(header[7], b'0' | b'2') {
                return Err("not a NanoVDB file: a segment does not begin with `NanoVDB`".into());
            }
            let version = u32_at(header, 8) >> 21;
            if version != 32 {
                return Err(format!("version {version} of the format is not known, only 32"));
            }
            let mut packed = Vec::new();
            for _ in 0..u16_at(header, 12) {
                let meta = take(&mut rest, METADATA)?;
                let name = take(&mut rest, u32_at(meta, 136) as usize)?;
                let name = name.split(|b| *b == 0).next().unwrap_or_default();
                packed.push((meta, String::from_utf8_lossy(name).into_owned()));
            }
            for (meta, name) in packed {
                let on_disk = usize::try_from(u64_at(meta, 8)).unwrap_or(usize::MAX);
                let bytes = take(&mut rest, on_disk)?;
                grids.push(Packed {
                    name,
                    kind: u32_at(meta, 32),
                    class: u32_at(meta, 36),
                    codec: u16_at(meta, 168),
                    size: u64_at(meta, 0),
                    bytes,
                });
            }
        }
        Ok(grids)
    }
}

impl Packed<'_> {
    fn unpack(&self) -> Result<Vec<u8>, String> {
        if self.kind != FLOAT {
            return Err(format!("its values are of type {}, expected 1 (float)", self.kind));
        }
        if !AMOUNTS.contains(&self.class) {
            return Err(format!("it is of class {}, expected 2 (fog volume)", self.class));
        }
        match self.codec {
            0 => Ok(self.bytes.to_vec()),
            1 => {
                // The size of what is deflated, then that.
                let mut rest = self.bytes;
                take(&mut rest, 8)?;
                let mut unpacked = Vec::new();
                let inflated = flate2::read::ZlibDecoder::new(rest)
                    .take(self.size.saturating_add(1))
                    .read_to_end(&mut unpacked);
                inflated.map_err(|e| format!("the compressed data is damaged: {e}"))?;
                match unpacked.len() as u64 == self.size {
                    true => Ok(unpacked),
                    false => Err("its compressed data is of another size than announced".into()),
                }
            }
            codec => Err(format!(
                "codec {codec} is not supported, only 0 (none) and 1 (zip): write it again with one"
            )),
        }
    }
}

/// The next `n` bytes.
fn take<'a>(rest: &mut &'a [u8], n: usize) -> Result<&'a [u8], String> {
    let (taken, left) = rest.split_at_checked(n).ok_or("the file ends too early")?;
    *rest = left;
    Ok(taken)
}

fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(std::array::from_fn(|i| bytes[at + i]))
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(std::array::from_fn(|i| bytes[at + i]))
}
