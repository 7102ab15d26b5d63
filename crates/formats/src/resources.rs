//! Loading what scene files name: meshes and images, in parallel and each once.

use crate::mesh::{MeshOptions, NormalPolicy, read_mesh};
use kaustika_film::files::read_bitmap;
use kaustika_scene::description::{Bitmap, TriMesh};
use rayon::prelude::*;
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
    load_each_once(requests, |r| {
        let options = MeshOptions {
            flip_v: r.flip_v,
            shape_index: r.sub_mesh as usize,
            normals: match r.normals {
                NormalMode::AsFile => NormalPolicy::AsStored,
                NormalMode::Faceted => NormalPolicy::Flat,
                NormalMode::SmoothIfMissing => NormalPolicy::SmoothIfMissing,
                NormalMode::SmoothBelow(degrees) => NormalPolicy::SmoothBelow(degrees),
            },
            ..MeshOptions::default()
        };
        read_mesh(&r.path, &options).map_err(|e| e.to_string())
    })
}

/// Reads all images; equal paths share one. An error is a one-line cause.
pub fn load_bitmaps(paths: &[PathBuf]) -> Vec<Result<Arc<Bitmap>, String>> {
    load_each_once(paths, |p| read_bitmap(p).map_err(|e| e.to_string()))
}

fn load_each_once<R: PartialEq + Sync, T: Send + Sync>(
    requests: &[R],
    load: impl Fn(&R) -> Result<T, String> + Sync,
) -> Vec<Result<Arc<T>, String>> {
    let mut unique: Vec<&R> = Vec::new();
    let which: Vec<usize> = requests
        .iter()
        .map(|r| match unique.iter().position(|u| *u == r) {
            Some(i) => i,
            None => {
                unique.push(r);
                unique.len() - 1
            }
        })
        .collect();
    let loaded: Vec<_> = unique.par_iter().map(|r| load(r).map(Arc::new)).collect();
    which.into_iter().map(|i| loaded[i].clone()).collect()
}
