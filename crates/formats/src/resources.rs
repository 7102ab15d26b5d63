//! Loading what scene files name: meshes and images, in parallel and each once.

use kaustika_scene::description::{Bitmap, TriMesh};
use std::path::PathBuf;
use std::sync::Arc;

/// A mesh file that a scene names, and how to read it.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshRequest {
    /// Where it lies.
    pub path: PathBuf,
    /// True: texture coordinate v becomes 1 - v.
    pub flip_v: bool,
    /// Number of the mesh in a `.serialized` file.
    pub sub_mesh: u32,
    /// What to do about shading normals.
    pub normals: NormalMode,
}

/// Shading normals of a mesh that is read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum NormalMode {
    /// As the file has them, none if it has none (pbrt).
    #[default]
    AsFile,
    /// None: facets.
    Faceted,
    /// As the file has them, else computed from the faces (Mitsuba).
    SmoothIfMissing,
    /// Recomputed, edges sharper than this angle (degrees) kept (Mitsuba 0.6 maxSmoothAngle).
    SmoothBelow(f32),
}

/// Reads all requested meshes; equal requests share one mesh. An error is a one-line cause.
pub fn load_meshes(requests: &[MeshRequest]) -> Vec<Result<Arc<TriMesh>, String>> {
    requests.iter().map(|r| Err(format!("can't read {} yet", r.path.display()))).collect()
}

/// Reads all images; equal paths share one. An error is a one-line cause.
pub fn load_bitmaps(paths: &[PathBuf]) -> Vec<Result<Arc<Bitmap>, String>> {
    paths.iter().map(|p| Err(format!("can't read {} yet", p.display()))).collect()
}
