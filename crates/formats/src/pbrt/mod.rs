//! Reader of pbrt-v4 scenes (pbrt.org/fileformat-v4), and of pbrt-v3 scenes by upgrading them in
//! memory.
//!
//! The work is done in two steps. First the files are read and their directives run on the
//! graphics state; what they make is kept as `entity::Entities` with a place for every value.
//! Then the entities are turned into a [`SceneDescription`]: names are looked up, images and
//! meshes are loaded in parallel, defaults are filled in. As in pbrt-v4 a material may name a
//! texture that is defined behind it.
//!
//! Nothing here panics on a scene and no error ends the reading: all are collected, each with its
//! place. Facts of format and defaults are pbrt-v4's (mmp/pbrt-v4, `parser.cpp`, `paramdict.cpp`,
//! `scene.cpp` and the `Create` functions).

mod blocks;
mod build;
mod curves;
mod directive;
mod emission;
mod entity;
mod fibres;
mod files;
mod images;
mod infinite;
mod lens;
mod lexer;
mod lights;
mod materials;
mod media;
mod meshes;
mod nanovdb;
mod notes;
mod number;
mod options;
mod param;
mod reader;
mod shapes;
mod spectrum;
mod subsurface;
#[cfg(test)]
mod tests;
mod textures;
mod transforms;
mod upgrade;
mod upgrade_material;
mod values;

use kaustika_scene::description::{SceneDescription, nearest_name};
use reader::Reader;
use std::path::Path;

/// Reads the scene in a file; `.gz` files are unpacked. Errors, warnings and notes are in
/// [`SceneDescription::diagnostics`]; with an error among them the rest is a fragment.
pub fn read_pbrt(path: &Path) -> SceneDescription {
    let mut reader = Reader::new(folder(path));
    reader.read_file(path, None);
    build::build(reader)
}

/// Reads the scene in a text. `path` stands for it in messages, and file names in the text are
/// relative to its folder.
pub fn read_pbrt_str(text: &str, path: &Path) -> SceneDescription {
    let mut reader = Reader::new(folder(path));
    reader.read_text(text.to_string(), path);
    build::build(reader)
}

fn folder(path: &Path) -> std::path::PathBuf {
    path.parent().unwrap_or(Path::new("")).to_path_buf()
}
