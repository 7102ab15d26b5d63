//! Mitsuba's XML scenes: the language of Mitsuba 2 and 3 and that of Mitsuba 0.4 to 0.6.
//!
//! The `version` attribute of a file's root decides: from 2.0 on it is read as Mitsuba 3 reads
//! it, below as Mitsuba 0.6. What the parameters are called, their defaults and meaning follow
//! the sources of both (mitsuba-renderer/mitsuba3, mitsuba-renderer/mitsuba). The way is:
//!
//! 1. `parse`: XML to a graph of objects with named parameters; `$variables`, `<include>`,
//!    `<path>`, `<alias>`; names of 0.6 are turned into those of Mitsuba 3.
//! 2. `convert` and its neighbours, one a kind of object: the graph to a description. Every
//!    parameter that is read is marked; what remains is reported with the nearest known name.
//! 3. `resources`: meshes and images are loaded together and put in their places.
//!
//! Differences between Mitsuba's conventions and the description's that are settled here:
//!
//! - Mitsuba's cameras have +x to the left: the camera's transform is `to_world` times a mirror.
//! - Mitsuba's texture coordinate v = 0 is the top row of an image: mappings end with 1 - v.
//! - Mitsuba's depths count emission as 1: they become one less.
//! - Numbers and colours as light are multiples of D65 white.

mod bsdfs;
mod convert;
mod curves;
mod daylight;
mod document;
mod emitters;
mod fibres;
mod fields;
mod find;
mod gratings;
mod height_fields;
mod integrators;
mod ior;
mod matrix;
mod measured;
mod media;
mod meters;
mod nested;
mod parse;
mod phases;
mod polarizing;
mod properties;
mod resources;
mod sensors;
mod shapes;
mod spectra;
mod steps;
mod sun_position;
mod textures;
mod timed_daylight;
mod upgrade;
mod values;
mod variables;
mod volumes;

#[cfg(test)]
mod tests;

use convert::Converter;
use document::Dialect;
use kaustika_scene::description::{SceneDescription, SourceFormat};
use std::path::Path;

/// Reads a Mitsuba scene and all files it names. `defines` are values for `$name` that override
/// the file's `<default>` elements.
///
/// Never fails as such: whatever is the matter is in the description's `diagnostics`, with places
/// in the files, and a description whose diagnostics have errors must not be rendered.
pub fn read_mitsuba(path: &Path, defines: &[(String, String)]) -> SceneDescription {
    let parsed = parse::parse(path, defines);
    let mut description = SceneDescription {
        format: SourceFormat::Mitsuba3,
        sources: parsed.sources,
        diagnostics: parsed.diagnostics,
        ..SceneDescription::default()
    };
    let Some((root, dialect)) = parsed.root else { return description };
    if dialect == Dialect::V06 {
        description.format = SourceFormat::Mitsuba06;
    }
    let mut converter = Converter::new(&parsed.document, description);
    converter.scene(root);
    converter.load();
    converter.out
}
