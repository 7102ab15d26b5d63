//! Mitsuba's `.serialized` meshes, versions 3 and 4 (all of Mitsuba 0.6's, and what Mitsuba 3
//! read for most of its life).
//!
//! Layout, from the plugin's documentation and `TriMesh::loadCompressed`: little-endian; for each
//! mesh a header of two `u16` (0x041C, version) and a zlib stream of
//!
//! ```text
//! u32 flags   [v4: name, ended by a zero byte]   u64 vertices   u64 triangles
//! positions 3, normals 3 if flagged, texture coordinates 2 if flagged, colours 3 if flagged,
//!     each an array over the vertices, of f32 or f64 by flag
//! 3 u32 a triangle
//! ```
//!
//! At the end of the file stand the byte offsets of all meshes (`u64`; version 3: `u32`) and a
//! `u32` with their number. A file of one mesh may lack this dictionary.

use std::io::{BufRead, ErrorKind, Read, Seek, SeekFrom};

use flate2::bufread::ZlibDecoder;
use kaustika_math::{Vec2, Vec3};
use kaustika_scene::description::{MeshAttribute, TriMesh};

use super::error::{Fault, MeshCause, MeshNote, Place};
use super::{MeshOptions, unit_normal};

const MAGIC: u16 = 0x041C;

const HAS_NORMALS: u32 = 0x0001;
const HAS_TEXCOORDS: u32 = 0x0002;
const HAS_COLORS: u32 = 0x0008;
const FACE_NORMALS: u32 = 0x0010;
const DOUBLE_PRECISION: u32 = 0x2000;

/// Deflate cannot expand by more than this (zlib's manual: 1032 to 1).
const MAX_INFLATION: u64 = 1032;

/// Memory to ask for before the data that fills it has been seen, in elements.
const MAX_RESERVE: u64 = 1 << 16;

/// Reads mesh `options.shape_index` of a `.serialized` file, and no other part of the file.
/// Colours become the attribute `vertex_color`.
///
/// # Errors
///
/// Another format or version, no such mesh, damaged or missing data (with the triangle or vertex
/// at fault where there is one).
pub fn parse(
    file: &mut (impl BufRead + Seek),
    options: &MeshOptions,
    notes: &mut Vec<MeshNote>,
) -> Result<TriMesh, Fault> {
    let version = version_at(file, 0)?;
    let start = match options.shape_index {
        0 => 0,
        index => Dictionary::find(file, version)?.offset(file, index)?,
    };
    let version = version_at(file, start)?;
    let compressed = length(file)?.saturating_sub(start + 4);
    file.seek(SeekFrom::Start(start + 4)).map_err(io_fault)?;
    Stream {
        inflate: ZlibDecoder::new(file),
        position: 0,
        limit: compressed.saturating_mul(MAX_INFLATION),
    }
    .mesh(version, options, notes)
}

/// How many meshes the dictionary at the end of the file lists; 1 if there is none.
///
/// # Errors
///
/// Another format or version.
pub fn count(file: &mut (impl BufRead + Seek)) -> Result<usize, Fault> {
    let version = version_at(file, 0)?;
    Ok(Dictionary::find(file, version)?.count.max(1) as usize)
}

fn io_fault(error: std::io::Error) -> Fault {
    Fault::new(Place::File, MeshCause::Io(error))
}

fn length(file: &mut impl Seek) -> Result<u64, Fault> {
    file.seek(SeekFrom::End(0)).map_err(io_fault)
}

/// `N` bytes of the file.
fn bytes_at<const N: usize>(file: &mut (impl BufRead + Seek), at: u64) -> Result<[u8; N], Fault> {
    let mut bytes = [0; N];
    let read = file.seek(SeekFrom::Start(at)).and_then(|_| file.read_exact(&mut bytes));
    match read {
        Ok(()) => Ok(bytes),
        Err(e) if e.kind() == ErrorKind::UnexpectedEof => {
            Err(Fault::new(Place::Byte(at), MeshCause::Truncated))
        }
        Err(e) => Err(io_fault(e)),
    }
}

/// Checks the four bytes before a compressed mesh.
fn version_at(file: &mut (impl BufRead + Seek), at: u64) -> Result<u16, Fault> {
    let fail = |message| Err(Fault::new(Place::Byte(at), MeshCause::Header(message)));
    let [m0, m1, v0, v1] = bytes_at(file, at)?;
    let magic = u16::from_le_bytes([m0, m1]);
    if magic != MAGIC {
        return fail(format!("not a serialized mesh: it begins with {magic:#06x}, not 0x041c"));
    }
    match u16::from_le_bytes([v0, v1]) {
        version @ (3 | 4) => Ok(version),
        version => fail(format!("version {version} is not supported (3 and 4 are)")),
    }
}

/// The offsets at the end of the file.
struct Dictionary {
    /// Where they begin.
    start: u64,
    /// How many there are; 0 if the file has no room for as many as it says.
    count: u64,
    version: u16,
}

impl Dictionary {
    fn find(file: &mut (impl BufRead + Seek), version: u16) -> Result<Dictionary, Fault> {
        let end = length(file)?.saturating_sub(4);
        let count = u32::from_le_bytes(bytes_at(file, end)?) as u64;
        let entry = if version == 3 { 4 } else { 8 };
        let none = Dictionary { start: end, count: 0, version };
        // Every mesh has at least its header.
        Ok(match end.checked_sub(count * entry) {
            Some(start) if start >= 4 * count => Dictionary { start, count, version },
            _ => none,
        })
    }

    /// Where mesh `index` begins.
    fn offset(&self, file: &mut (impl BufRead + Seek), index: usize) -> Result<u64, Fault> {
        if index as u64 >= self.count {
            let meshes = self.count.max(1) as usize;
            let cause = MeshCause::ShapeIndex { asked: index, meshes };
            return Err(Fault::new(Place::File, cause));
        }
        let offset = match self.version {
            3 => u32::from_le_bytes(bytes_at(file, self.start + 4 * index as u64)?) as u64,
            _ => u64::from_le_bytes(bytes_at(file, self.start + 8 * index as u64)?),
        };
        if offset >= self.start {
            let message = format!("mesh {index} is said to begin at byte {offset}, beyond the end");
            return Err(Fault::new(Place::File, MeshCause::Header(message)));
        }
        Ok(offset)
    }
}

/// The inflated data of one mesh.
struct Stream<R> {
    inflate: ZlibDecoder<R>,
    /// Inflated bytes read.
    position: u64,
    /// Inflated bytes that there can be at most.
    limit: u64,
}

impl<R: BufRead> Stream<R> {
    fn mesh(
        mut self,
        version: u16,
        options: &MeshOptions,
        notes: &mut Vec<MeshNote>,
    ) -> Result<TriMesh, Fault> {
        let flags = u32::from_le_bytes(self.array()?);
        if version >= 4 {
            while self.array()? != [0] {}
        }
        let vertices = u64::from_le_bytes(self.array()?);
        let triangles = u64::from_le_bytes(self.array()?);
        if vertices > u32::MAX as u64 {
            return Err(self.too_many("vertex", vertices));
        }
        let has = |flag: u32| flags & flag != 0;
        let double = has(DOUBLE_PRECISION);
        if has(FACE_NORMALS) && options.normals.uses_stored() {
            notes.push(MeshNote::FaceNormalsFlag);
        }

        let mut mesh = TriMesh {
            positions: self.vectors(vertices, double, Vec3::from)?,
            ..TriMesh::default()
        };
        if let Some(bad) = mesh.positions.iter().position(|p| !p.is_finite()) {
            let place = Place::entry("vertex", bad as u64);
            return Err(Fault::new(place, MeshCause::NotFinite("position")));
        }
        if has(HAS_NORMALS) {
            let mut dropped = 0;
            let normals =
                self.vectors(vertices, double, |n: [f32; 3]| unit_normal(n.into(), &mut dropped))?;
            if options.normals.uses_stored() {
                mesh.normals = normals;
                if dropped > 0 {
                    notes.push(MeshNote::NormalsDropped(dropped));
                }
            }
        }
        if has(HAS_TEXCOORDS) {
            let flip = options.flip_v;
            mesh.uvs = self.vectors(vertices, double, |[u, v]: [f32; 2]| {
                Vec2::new(u, if flip { 1.0 - v } else { v })
            })?;
        }
        if has(HAS_COLORS) {
            let colors = self.vectors(vertices, double, |c: [f32; 3]| c)?;
            mesh.attributes.push(MeshAttribute {
                name: "vertex_color".into(),
                channels: 3,
                per_face: false,
                values: colors.into_flattened(),
            });
        }
        mesh.indices = self.elements("triangle", triangles, |t: &[u8; 12]| {
            [0, 1, 2]
                .map(|i| u32::from_le_bytes([t[4 * i], t[4 * i + 1], t[4 * i + 2], t[4 * i + 3]]))
        })?;
        check_indices(&mesh)?;
        let more = self.end()?;
        if more > 0 {
            notes.push(MeshNote::TrailingBytes(more));
        }
        Ok(mesh)
    }

    /// The next `N` bytes.
    fn array<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<(), Fault> {
        self.inflate.read_exact(bytes).map_err(|e| self.fault(&e))?;
        self.position += bytes.len() as u64;
        Ok(())
    }

    /// Reads to the end of the stream, where its checksum stands; how many bytes that were.
    fn end(&mut self) -> Result<u64, Fault> {
        std::io::copy(&mut self.inflate, &mut std::io::sink()).map_err(|e| self.fault(&e))
    }

    fn fault(&self, error: &std::io::Error) -> Fault {
        let cause = match error.kind() {
            ErrorKind::UnexpectedEof => MeshCause::Truncated,
            _ => MeshCause::Compression(error.to_string()),
        };
        Fault::new(Place::Byte(self.position), cause)
    }

    fn too_many(&self, list: &str, count: u64) -> Fault {
        let cause = MeshCause::CountTooLarge {
            list: list.to_owned(),
            count,
            left: self.limit.saturating_sub(self.position),
        };
        Fault::new(Place::Byte(self.position), cause)
    }

    /// The next `count` vectors over the vertices, of single or double precision.
    fn vectors<const N: usize, T>(
        &mut self,
        count: u64,
        double: bool,
        mut make: impl FnMut([f32; N]) -> T,
    ) -> Result<Vec<T>, Fault> {
        // N * 4 and N * 8 cannot be array lengths in stable Rust: the widest, and a part of it.
        let width = N * if double { 8 } else { 4 };
        self.chunks("vertex", count, width, |bytes| {
            let mut vector = [0.0; N];
            for (i, value) in vector.iter_mut().enumerate() {
                *value = if double {
                    read(&bytes[8 * i..]).map_or(0.0, f64::from_le_bytes) as f32
                } else {
                    read(&bytes[4 * i..]).map_or(0.0, f32::from_le_bytes)
                };
            }
            make(vector)
        })
    }

    fn elements<const N: usize, T>(
        &mut self,
        list: &str,
        count: u64,
        make: impl Fn(&[u8; N]) -> T,
    ) -> Result<Vec<T>, Fault> {
        self.chunks(list, count, N, |bytes| make(&read(bytes).unwrap_or([0; N])))
    }

    /// The next `count` elements of `width` bytes, inflated and converted piece by piece.
    fn chunks<T>(
        &mut self,
        list: &str,
        count: u64,
        width: usize,
        mut make: impl FnMut(&[u8]) -> T,
    ) -> Result<Vec<T>, Fault> {
        let left = self.limit.saturating_sub(self.position);
        if count.saturating_mul(width as u64) > left {
            return Err(self.too_many(list, count));
        }
        let mut out = Vec::with_capacity(count.min(MAX_RESERVE) as usize);
        let mut buffer = vec![0u8; width * count.min(4096) as usize];
        let mut done = 0;
        while done < count {
            let n = (count - done).min(4096) as usize;
            let bytes = &mut buffer[..n * width];
            self.fill(bytes)?;
            out.extend(bytes.chunks_exact(width).map(&mut make));
            done += n as u64;
        }
        Ok(out)
    }
}

fn read<const N: usize>(bytes: &[u8]) -> Option<[u8; N]> {
    bytes.first_chunk().copied()
}

fn check_indices(mesh: &TriMesh) -> Result<(), Fault> {
    let count = mesh.positions.len();
    let outside = |t: &[u32; 3]| t.iter().find(|&&v| v as usize >= count).copied();
    let bad = mesh.indices.iter().enumerate().find_map(|(i, t)| Some((i, outside(t)?)));
    match bad {
        None => Ok(()),
        Some((triangle, index)) => Err(Fault::new(
            Place::entry("triangle", triangle as u64),
            MeshCause::IndexOutOfRange { what: "vertex", index: index as i64, count },
        )),
    }
}
