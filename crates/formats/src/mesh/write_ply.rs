//! Meshes written as PLY, binary and little-endian.

use std::ffi::OsString;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use kaustika_scene::description::{MeshAttribute, TriMesh};

use super::error::{Fault, MeshCause, MeshError, Place};

/// Writes a mesh as a binary little-endian PLY file that [`read_mesh`](super::read_mesh) reads
/// back as it was (attributes perhaps in another order); pbrt and Mitsuba read it too. The file appears under its name only when it is
/// complete.
///
/// Attributes are named by the rules of [`ply`](super::ply): `vertex_color` becomes `r g b`,
/// `vertex_heat` becomes `heat_0` or `heat_x heat_y heat_z`, `face_indices` an `int`.
///
/// # Errors
///
/// The file cannot be written; an array is not as long as it must be or an index out of range; an
/// attribute has a name or a number of channels that PLY readers would not know.
pub fn write_ply(path: &Path, mesh: &TriMesh) -> Result<(), MeshError> {
    write(path, mesh).map_err(|cause| MeshError::new(path, Fault::new(Place::File, cause)))
}

fn write(path: &Path, mesh: &TriMesh) -> Result<(), MeshCause> {
    let columns = check(mesh)?;
    let temporary = beside(path);
    let written = File::create(&temporary).and_then(|file| {
        let mut out = BufWriter::with_capacity(1 << 16, file);
        write_mesh(&mut out, mesh, &columns)?;
        out.flush()?;
        std::fs::rename(&temporary, path)
    });
    written.map_err(|e| {
        // Best effort: the first error is the one that matters.
        let _ = std::fs::remove_file(&temporary);
        MeshCause::Io(e)
    })
}

/// A name in the same folder, hence on the same file system, that no other writer uses.
fn beside(path: &Path) -> PathBuf {
    static WRITES: AtomicU64 = AtomicU64::new(0);
    let number = WRITES.fetch_add(1, Ordering::Relaxed);
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}-{number}.tmp", std::process::id()));
    path.with_file_name(name)
}

/// An attribute and the PLY properties for its channels.
struct Columns<'a> {
    attribute: &'a MeshAttribute,
    properties: Vec<String>,
}

impl Columns<'_> {
    fn is_face_indices(&self) -> bool {
        self.attribute.name == "face_indices"
    }
}

/// Finds the properties' names and whether the mesh can be written at all.
fn check(mesh: &TriMesh) -> Result<Vec<Columns<'_>>, MeshCause> {
    let fail = MeshCause::Unwritable;
    let vertices = mesh.positions.len();
    if vertices > i32::MAX as usize {
        return Err(fail("more than 2^31 - 1 vertices".into()));
    }
    for (what, length) in [("normals", mesh.normals.len()), ("uvs", mesh.uvs.len())] {
        if length != 0 && length != vertices {
            return Err(fail(format!("{length} {what} for {vertices} vertices")));
        }
    }
    if let Some(bad) = mesh.indices.iter().flatten().find(|&&v| v as usize >= vertices) {
        return Err(fail(format!("vertex index {bad} of {vertices}")));
    }
    mesh.attributes
        .iter()
        .map(|attribute| {
            let elements = match attribute.per_face {
                true => mesh.indices.len(),
                false => vertices,
            };
            if attribute.values.len() != elements * attribute.channels as usize {
                return Err(fail(format!("attribute `{}` has a wrong length", attribute.name)));
            }
            match property_names(attribute) {
                Some(properties) => Ok(Columns { attribute, properties }),
                None => Err(fail(format!(
                    "no PLY properties stand for attribute `{}` of {} channels",
                    attribute.name, attribute.channels
                ))),
            }
        })
        .collect()
}

fn property_names(attribute: &MeshAttribute) -> Option<Vec<String>> {
    let prefix = if attribute.per_face { "face_" } else { "vertex_" };
    let stem = attribute.name.strip_prefix(prefix)?;
    // Space would end the name in the header.
    if stem.is_empty() || stem.contains(|c: char| c.is_whitespace() || c.is_control()) {
        return None;
    }
    let all = |stem: &str, endings: &[&str]| endings.iter().map(|e| format!("{stem}{e}")).collect();
    Some(match (stem, attribute.channels) {
        ("indices", 1) if attribute.per_face => all("face_indices", &[""]),
        ("color", 3) => all("", &["r", "g", "b"]),
        ("alpha", 1) => all("", &["a"]),
        (stem, channels @ (1 | 3)) => match (stem.strip_suffix("_color"), channels) {
            (Some(stem), 3) => all(stem, &["_r", "_g", "_b"]),
            (Some(stem), _) => all(stem, &["_r"]),
            (None, 3) => all(stem, &["_x", "_y", "_z"]),
            (None, _) => all(stem, &["_0"]),
        },
        _ => return None,
    })
}

fn write_mesh(out: &mut impl Write, mesh: &TriMesh, columns: &[Columns]) -> std::io::Result<()> {
    let (of_faces, of_vertices): (Vec<_>, Vec<_>) =
        columns.iter().partition(|c| c.attribute.per_face);
    let floats = |out: &mut dyn Write, names: &[&str]| {
        names.iter().try_for_each(|name| writeln!(out, "property float {name}"))
    };
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    writeln!(out, "element vertex {}", mesh.positions.len())?;
    floats(out, &["x", "y", "z"])?;
    if !mesh.normals.is_empty() {
        floats(out, &["nx", "ny", "nz"])?;
    }
    if !mesh.uvs.is_empty() {
        floats(out, &["u", "v"])?;
    }
    for name in of_vertices.iter().flat_map(|c| &c.properties) {
        floats(out, &[name])?;
    }
    writeln!(out, "element face {}", mesh.indices.len())?;
    writeln!(out, "property list uchar int vertex_indices")?;
    for c in &of_faces {
        let of = if c.is_face_indices() { "int" } else { "float" };
        for name in &c.properties {
            writeln!(out, "property {of} {name}")?;
        }
    }
    writeln!(out, "end_header")?;

    let mut record = Vec::new();
    for (v, p) in mesh.positions.iter().enumerate() {
        record.clear();
        let mut push = |value: f32| record.extend_from_slice(&value.to_le_bytes());
        [p.x, p.y, p.z].into_iter().for_each(&mut push);
        if let Some(n) = mesh.normals.get(v) {
            [n.x, n.y, n.z].into_iter().for_each(&mut push);
        }
        if let Some(uv) = mesh.uvs.get(v) {
            [uv.x, uv.y].into_iter().for_each(&mut push);
        }
        for c in &of_vertices {
            let n = c.properties.len();
            c.attribute.values[v * n..][..n].iter().copied().for_each(&mut push);
        }
        out.write_all(&record)?;
    }
    for (f, triangle) in mesh.indices.iter().enumerate() {
        record.clear();
        record.push(3);
        for v in triangle {
            record.extend_from_slice(&v.to_le_bytes());
        }
        for c in &of_faces {
            let n = c.properties.len();
            for value in &c.attribute.values[f * n..][..n] {
                match c.is_face_indices() {
                    true => record.extend_from_slice(&(value.round() as i32).to_le_bytes()),
                    false => record.extend_from_slice(&value.to_le_bytes()),
                }
            }
        }
        out.write_all(&record)?;
    }
    Ok(())
}
