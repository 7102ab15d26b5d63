//! Triangle meshes: PLY, Wavefront OBJ and Mitsuba's `.serialized`.
//!
//! Every reader checks what a file announces against what it holds before it allocates, and
//! reports the line, byte or entry at fault. What is odd but readable becomes a [`MeshNote`].
//!
//! Conventions that differ between renderers are [`MeshOptions`]. Mitsuba's defaults, from the
//! sources of its plugins `ply`, `obj` and `serialized` (0.6 and 3.x agree):
//!
//! | format | `flip_v` | normals when the file has none | normals with `face_normals` |
//! |---|---|---|---|
//! | PLY | no (0.6: no such switch) | computed, weighted by angle | dropped |
//! | OBJ | **yes** | computed, weighted by angle | dropped |
//! | serialized | no (no such switch) | computed, weighted by angle | dropped |
//!
//! pbrt reads PLY only and takes everything as stored; [`MeshOptions::default`] does the same.

mod error;
pub mod normals;
pub mod obj;
pub mod ply;
pub mod serialized;
mod subdivide;
#[cfg(test)]
mod tests;
mod write_ply;

use std::ffi::OsStr;
use std::fs::File;
use std::io::{BufReader, Cursor, Read};
use std::path::Path;

use kaustika_math::Vec3;
use kaustika_scene::description::TriMesh;

pub use error::{Fault, MeshCause, MeshError, MeshNote, Place};
pub use normals::NormalPolicy;
pub use subdivide::subdivide;
pub use write_ply::write_ply;

/// How to read a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshOptions {
    /// Replaces texture coordinate v by 1 - v.
    pub flip_v: bool,
    /// What becomes of vertex normals.
    pub normals: NormalPolicy,
    /// Which mesh of a `.serialized` file, counted from 0.
    pub shape_index: usize,
    /// Floating-point colours in PLY files are sRGB-encoded and are decoded. Mitsuba 0.6 assumes
    /// this (its parameter `srgb`, true unless set); Mitsuba 3 takes them as linear. Integer
    /// colours are sRGB to both, and always decoded here.
    pub srgb_float_colors: bool,
}

impl Default for MeshOptions {
    /// Everything as the file has it, the first mesh: what pbrt does.
    fn default() -> Self {
        MeshOptions {
            flip_v: false,
            normals: NormalPolicy::AsStored,
            shape_index: 0,
            srgb_float_colors: false,
        }
    }
}

impl MeshOptions {
    /// What Mitsuba 3 does when the scene says nothing; 0.6 differs in `srgb_float_colors` only.
    pub fn mitsuba(format: MeshFormat) -> MeshOptions {
        MeshOptions {
            flip_v: format == MeshFormat::Obj,
            normals: NormalPolicy::SmoothIfMissing,
            ..MeshOptions::default()
        }
    }
}

/// A mesh file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Stanford PLY.
    Ply,
    /// Wavefront OBJ.
    Obj,
    /// Mitsuba's compressed meshes.
    Serialized,
}

impl MeshFormat {
    /// The format that the file name's extension stands for; a final `.gz` is looked through.
    pub fn from_path(path: &Path) -> Option<MeshFormat> {
        let extension = path.extension()?;
        let inner;
        let extension = if extension.eq_ignore_ascii_case("gz") {
            inner = path.file_stem()?;
            Path::new(inner).extension()?
        } else {
            extension
        };
        let is = |name: &str| extension.eq_ignore_ascii_case(name);
        if is("ply") {
            Some(MeshFormat::Ply)
        } else if is("obj") {
            Some(MeshFormat::Obj)
        } else if is("serialized") {
            Some(MeshFormat::Serialized)
        } else {
            None
        }
    }
}

/// Reads the mesh in `path`, whose extension names the format, and forgets the notes.
///
/// # Errors
///
/// The file cannot be read, is of no known format, or is damaged.
pub fn read_mesh(path: &Path, options: &MeshOptions) -> Result<TriMesh, MeshError> {
    read_mesh_noting(path, options, &mut Vec::new())
}

/// Like [`read_mesh`]; what was odd but readable is added to `notes`.
///
/// # Errors
///
/// As [`read_mesh`].
pub fn read_mesh_noting(
    path: &Path,
    options: &MeshOptions,
    notes: &mut Vec<MeshNote>,
) -> Result<TriMesh, MeshError> {
    let place = |fault| MeshError::new(path, fault);
    let format = MeshFormat::from_path(path).ok_or_else(|| {
        let extension = path.extension().unwrap_or(OsStr::new(""));
        let name = extension.to_string_lossy().into_owned();
        place(Fault::new(Place::File, MeshCause::UnknownFormat(name)))
    })?;
    if format == MeshFormat::Serialized && !is_gzip(path).map_err(place)? {
        // One of perhaps hundreds of meshes in a file: the others need not be read.
        let mut file = BufReader::with_capacity(1 << 16, open(path).map_err(place)?);
        let mut mesh = serialized::parse(&mut file, options, notes).map_err(place)?;
        normals::apply(&mut mesh, options.normals, notes);
        return Ok(mesh);
    }
    let bytes = read_file(path).map_err(place)?;
    parse_mesh(&bytes, format, options, notes).map_err(place)
}

/// Reads an OBJ file in parts, see [`obj::parse_parts`].
///
/// # Errors
///
/// The file cannot be read or is damaged.
pub fn read_obj_parts(
    path: &Path,
    options: &MeshOptions,
    notes: &mut Vec<MeshNote>,
) -> Result<Vec<obj::ObjPart>, MeshError> {
    let parts = read_file(path).and_then(|bytes| obj::parse_parts(&bytes, options, notes));
    parts.map_err(|fault| MeshError::new(path, fault))
}

/// How many meshes a `.serialized` file holds: one more than the largest
/// [`MeshOptions::shape_index`].
///
/// # Errors
///
/// The file cannot be read or is of another format.
pub fn count_serialized(path: &Path) -> Result<usize, MeshError> {
    let count = is_gzip(path).and_then(|gzip| match gzip {
        true => serialized::count(&mut Cursor::new(read_file(path)?)),
        false => serialized::count(&mut BufReader::new(open(path)?)),
    });
    count.map_err(|fault| MeshError::new(path, fault))
}

/// Reads a mesh from the bytes of an uncompressed file.
///
/// # Errors
///
/// The bytes are not a sound file of this format.
pub fn parse_mesh(
    bytes: &[u8],
    format: MeshFormat,
    options: &MeshOptions,
    notes: &mut Vec<MeshNote>,
) -> Result<TriMesh, Fault> {
    let mut mesh = match format {
        MeshFormat::Ply => ply::parse(bytes, options, notes)?,
        MeshFormat::Obj => obj::parse(bytes, options, notes)?,
        MeshFormat::Serialized => serialized::parse(&mut Cursor::new(bytes), options, notes)?,
    };
    normals::apply(&mut mesh, options.normals, notes);
    Ok(mesh)
}

fn io_fault(error: std::io::Error) -> Fault {
    Fault::new(Place::File, MeshCause::Io(error))
}

fn open(path: &Path) -> Result<File, Fault> {
    File::open(path).map_err(io_fault)
}

/// gzip's magic number (RFC 1952).
const GZIP: [u8; 2] = [0x1f, 0x8b];

fn is_gzip(path: &Path) -> Result<bool, Fault> {
    let mut start = Vec::new();
    open(path)?.take(2).read_to_end(&mut start).map_err(io_fault)?;
    Ok(start == GZIP)
}

/// The bytes of a file, inflated if it is gzipped.
fn read_file(path: &Path) -> Result<Vec<u8>, Fault> {
    let bytes = std::fs::read(path).map_err(io_fault)?;
    if !bytes.starts_with(&GZIP) {
        return Ok(bytes);
    }
    let mut inflated = Vec::new();
    flate2::read::MultiGzDecoder::new(bytes.as_slice()).read_to_end(&mut inflated).map_err(
        |e| {
            let place = Place::Byte(inflated.len() as u64);
            Fault::new(place, MeshCause::Compression(e.to_string()))
        },
    )?;
    Ok(inflated)
}

/// A stored normal made unit; zero, which stands for "none", if it has no direction.
/// `dropped` counts those that are not even finite.
#[inline]
fn unit_normal(n: Vec3, dropped: &mut u64) -> Vec3 {
    // In double precision: squares of tiny but honest normals would underflow.
    let [x, y, z] = [n.x as f64, n.y as f64, n.z as f64];
    let length = (x * x + y * y + z * z).sqrt();
    if !length.is_finite() {
        *dropped += 1;
        return Vec3::ZERO;
    }
    if length == 0.0 {
        return Vec3::ZERO;
    }
    // Unit already, as far as f32 can say: scaling would only move the last bits.
    if (length - 1.0).abs() < 1e-6 {
        return n;
    }
    let scale = 1.0 / length;
    Vec3::new((x * scale) as f32, (y * scale) as f32, (z * scale) as f32)
}
