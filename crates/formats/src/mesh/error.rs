//! What can be wrong with a mesh file, and where.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// A mesh file that could not be read or written: which file, where in it, why.
#[derive(Debug, thiserror::Error)]
#[error("{}{place}: {cause}", .path.display())]
pub struct MeshError {
    /// The file.
    pub path: PathBuf,
    /// Where in it.
    pub place: Place,
    /// What is wrong there.
    pub cause: MeshCause,
}

impl MeshError {
    /// A fault, now that the file is known.
    pub fn new(path: &Path, fault: Fault) -> MeshError {
        MeshError { path: path.to_owned(), place: fault.place, cause: fault.cause }
    }
}

/// A position in a mesh file, as exact as the format allows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line of text, counted from 1.
    Line(usize),
    /// A byte, counted from 0.
    Byte(u64),
    /// An entry of a list, such as vertex 17, counted from 0.
    Entry {
        /// What the list holds: `vertex`, `face`, `triangle`, ...
        list: String,
        /// Its number.
        number: u64,
    },
}

impl Place {
    pub(super) fn entry(list: &str, number: u64) -> Place {
        Place::Entry { list: list.to_owned(), number }
    }
}

impl fmt::Display for Place {
    /// Reads well after a file name: `:12`, `, byte 12` or `, vertex 12`; empty for the file.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::File => Ok(()),
            Place::Line(line) => write!(f, ":{line}"),
            Place::Byte(byte) => write!(f, ", byte {byte}"),
            Place::Entry { list, number } => write!(f, ", {list} {number}"),
        }
    }
}

/// What is wrong with a mesh file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshCause {
    /// The operating system refused.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The file name ends in none of the known extensions.
    #[error("unknown mesh format `{0}` (known: ply, obj, serialized, each also with .gz)")]
    UnknownFormat(String),
    /// The header contradicts the format or itself.
    #[error("{0}")]
    Header(String),
    /// The file ends before the entry does.
    #[error("the file ends too early")]
    Truncated,
    /// Text or a number that cannot stand here.
    #[error("{0}")]
    Syntax(String),
    /// A count that the rest of the file cannot hold.
    #[error("{count} of `{list}` are announced, but only {left} bytes are left")]
    CountTooLarge {
        /// What is counted.
        list: String,
        /// The announced count.
        count: u64,
        /// Bytes (of the decompressed file) that are left for it, at most.
        left: u64,
    },
    /// A vertex (normal, texture coordinate) number beyond what there is.
    #[error("{what} index {index} is out of range (there are {count})")]
    IndexOutOfRange {
        /// `vertex`, `normal` or `texture coordinate`.
        what: &'static str,
        /// The number as the file has it.
        index: i64,
        /// How many there are at this place.
        count: usize,
    },
    /// NaN or infinity where a place in space is expected.
    #[error("the {0} is not finite")]
    NotFinite(&'static str),
    /// `shape_index` beyond the meshes in the file.
    #[error("shape index {asked} is out of range (the file holds {meshes}, counted from 0)")]
    ShapeIndex {
        /// The index asked for.
        asked: usize,
        /// Meshes in the file.
        meshes: usize,
    },
    /// Deflated data that cannot be inflated.
    #[error("the compressed data is damaged: {0}")]
    Compression(String),
    /// A mesh that the format cannot express, in writing.
    #[error("the mesh cannot be written: {0}")]
    Unwritable(String),
}

/// A cause and its place, before the file's name is known; then a [`MeshError`].
#[derive(Debug)]
pub struct Fault {
    /// Where.
    pub place: Place,
    /// Why.
    pub cause: MeshCause,
}

impl Fault {
    pub(super) fn new(place: Place, cause: MeshCause) -> Fault {
        Fault { place, cause }
    }

    pub(super) fn line(line: usize, message: impl Into<String>) -> Fault {
        Fault::new(Place::Line(line), MeshCause::Syntax(message.into()))
    }
}

/// Something odd in a mesh file that did not stop it from being read.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshNote {
    /// Polygons of more than four corners were cut into fans about their first corner, which is
    /// right for convex ones only.
    PolygonsFanned {
        /// How many.
        count: u64,
        /// Corners of the largest.
        largest: u64,
    },
    /// Faces of fewer than three corners were left out.
    ThinFacesSkipped(u64),
    /// A property or element that is not read, and why.
    Skipped {
        /// Its name.
        name: String,
        /// Why it is not read.
        why: &'static str,
    },
    /// Normals that were NaN or infinite became zero: the geometric normal holds there.
    NormalsDropped(u64),
    /// Faces without area gave nothing to the computed vertex normals.
    DegenerateFaces(u64),
    /// Vertices for which no normal could be computed: the geometric normal holds there.
    VerticesWithoutNormal(u64),
    /// Bytes after the last element.
    TrailingBytes(u64),
    /// A `.serialized` mesh asks for face normals. Mitsuba ignores that flag in favour of the
    /// scene's `face_normals`, and so does Kaustika.
    FaceNormalsFlag,
}

impl fmt::Display for MeshNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MeshNote::PolygonsFanned { count, largest } => write!(
                f,
                "{count} polygons of up to {largest} corners were cut into fans, as if convex"
            ),
            MeshNote::ThinFacesSkipped(n) => {
                write!(f, "{n} faces of fewer than three corners were skipped")
            }
            MeshNote::Skipped { name, why } => write!(f, "`{name}` is not read: {why}"),
            MeshNote::NormalsDropped(n) => write!(f, "{n} normals are not finite and were dropped"),
            MeshNote::DegenerateFaces(n) => write!(f, "{n} faces have no area"),
            MeshNote::VerticesWithoutNormal(n) => {
                write!(f, "no normal could be computed for {n} vertices")
            }
            MeshNote::TrailingBytes(n) => write!(f, "{n} bytes follow the last element"),
            MeshNote::FaceNormalsFlag => {
                write!(f, "the mesh asks for face normals; the scene's setting holds")
            }
        }
    }
}
