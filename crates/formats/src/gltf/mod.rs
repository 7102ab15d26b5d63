//! glTF 2.0: `.gltf` and `.glb`.
//!
//! What is read and how it maps stands in `docs/gltf.md`; the rules are those of the
//! specification (Khronos Group 2021) and of the README of each extension. The way is:
//!
//! 1. [`container`]: the file to JSON text and the binary chunk; [`json`]: values that know their
//!    path, whose place in the text [`place`] finds when there is something to say.
//! 2. [`buffers`], [`accessors`]: bytes to numbers, every range checked before it is read.
//! 3. [`images`], [`textures`], [`materials`], [`models`], [`meshes`], [`lights`], [`cameras`]: one a kind of
//!    thing; [`nodes`] walks the scene and places them.
//! 4. [`defaults`]: a camera and a sky for files that have none.
//!
//! A fault costs the thing it is in: the rest is read, and the fault is an error with its place.
//! Differences between glTF's conventions and the description's that are settled here: v of
//! texture coordinates runs down, cameras and spots look along -z.

mod accessors;
mod buffers;
mod cameras;
mod container;
mod defaults;
mod images;
mod json;
mod lights;
mod materials;
mod matrix;
mod meshes;
mod models;
mod nodes;
mod place;
mod textures;
mod write;

#[cfg(test)]
mod tests;

pub use write::write_glb;

use buffers::Buffers;
use images::Images;
use json::{Fault, Json};
use kaustika_scene::description::{
    MaterialId, SceneDescription, Severity, SourceFile, SourceFormat, Span, TextureId,
};
use materials::Materials;
use meshes::Meshes;
use std::path::Path;

/// Extensions that are read, or whose absence changes nothing that is seen.
const KNOWN: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
];

/// Reads a glTF scene and all files it names.
///
/// Never fails as such: whatever is the matter is in the description's `diagnostics`, with places
/// in the file, and a description whose diagnostics have errors must not be rendered.
pub fn read_gltf(path: &Path) -> SceneDescription {
    match std::fs::read(path) {
        Ok(bytes) => parse_gltf(path, bytes),
        Err(e) => {
            let mut out = SceneDescription { format: SourceFormat::Gltf, ..Default::default() };
            out.diagnostics.error(None, format!("{}: {e}", path.display()));
            out
        }
    }
}

/// Reads the contents of a file that lies at `path`.
fn parse_gltf(path: &Path, bytes: Vec<u8>) -> SceneDescription {
    let mut out = SceneDescription { format: SourceFormat::Gltf, ..Default::default() };
    let (text, chunk) = match container::open(bytes) {
        Ok(parts) => parts,
        Err(e) => {
            out.sources.files.push(SourceFile { path: path.into(), text: String::new() });
            out.diagnostics.error(None, format!("{}: {}", path.display(), e.message)).hint = e.hint;
            return out;
        }
    };
    out.sources.files.push(SourceFile { path: path.into(), text });
    let text = out.sources.files[0].text.clone();
    let root = match serde_json::from_str(&text) {
        Ok(root) => root,
        Err(e) => {
            let at = place::of_line_column(&text, e.line(), e.column());
            let message = e.to_string();
            let cause = message.split(" at line ").next().unwrap_or_default();
            out.diagnostics.error(
                Span { file: 0, start: at, end: at + 1 },
                format!("malformed JSON: {cause}"),
            );
            return out;
        }
    };
    let mut reader = Reader { text: &text, out, white: None, unlit: Vec::new() };
    if let Err(fault) = reader.scene(&Json::root(&root), path, chunk) {
        reader.report(fault);
    }
    reader.out
}

/// The description as it grows.
struct Reader<'a> {
    text: &'a str,
    out: SceneDescription,
    /// The texture that is 1 everywhere.
    white: Option<TextureId>,
    /// Materials that are shown as they are, whatever the light.
    unlit: Vec<MaterialId>,
}

impl Reader<'_> {
    fn scene(&mut self, root: &Json, path: &Path, chunk: Option<Vec<u8>>) -> Result<(), Fault> {
        let asset = root.require("asset")?;
        let version = asset.string("version")?.unwrap_or("");
        if version.split('.').next() != Some("2") {
            let found = if version.is_empty() { "none".into() } else { format!("`{version}`") };
            return Err(asset
                .fault(format!("expected glTF version 2.0, found {found}"))
                .hint("write version 2.0; converters from glTF 1.0 exist"));
        }
        self.extensions(root)?;
        let buffers = Buffers::new(root, path, chunk)?;
        let images = Images::new(root, &buffers)?;
        let mut materials = Materials::new(root, images)?;
        let mut meshes = Meshes::new(root)?;
        self.nodes(root, &buffers, &mut materials, &mut meshes)?;
        self.rest_pose(root);
        if !self.out.diagnostics.has_errors() {
            self.defaults();
        }
        Ok(())
    }

    /// What the file uses that is not read.
    fn extensions(&mut self, root: &Json) -> Result<(), Fault> {
        for (key, grave) in [("extensionsRequired", true), ("extensionsUsed", false)] {
            for e in root.list(key)? {
                let Some(name) = e.text() else {
                    return Err(e.fault("expected the name of an extension"));
                };
                if KNOWN.contains(&name) || images::KNOWN.contains(&name) {
                    continue;
                }
                if buffers::COMPRESSIONS.contains(&name) {
                    if grave {
                        return Err(e
                            .fault(format!("`{name}` is not supported: the geometry is compressed"))
                            .hint("write the scene without compression, for example with `gltf-transform copy`"));
                    }
                    continue;
                }
                let span = self.span(&e);
                let out = &mut self.out.diagnostics;
                if grave {
                    out.warning(span, format!("required extension `{name}` is not supported"))
                        .hint("the picture may differ from what the file asks for");
                } else if !root.list("extensionsRequired")?.iter().any(|r| r.text() == Some(name)) {
                    out.note(
                        span,
                        format!("extension `{name}` is not read; the file says it can be left out"),
                    );
                }
            }
        }
        Ok(())
    }

    /// Animations are not played; skins and morph targets are left as they are modelled.
    fn rest_pose(&mut self, root: &Json) {
        if root.get("animations").is_some_and(|a| a.len() > 0) {
            self.warn(
                root,
                "animations",
                "animations are not played: everything stands as its nodes say",
            );
        }
        if root.get("skins").is_some_and(|a| a.len() > 0) {
            self.warn(root, "skins", "skins are not applied: meshes stand in their rest pose");
        }
    }

    fn warn(&mut self, parent: &Json, key: &str, message: &str) {
        let span = parent.get(key).and_then(|v| self.span(&v));
        self.out.diagnostics.warning(span, message);
    }

    /// Where a value stands.
    fn span(&self, value: &Json) -> Option<Span> {
        self.span_of(&value.path)
    }

    fn span_of(&self, path: &str) -> Option<Span> {
        let (start, end) = place::find(self.text, path)?;
        Some(Span { file: 0, start: start as u32, end: end as u32 })
    }

    /// Makes a fault a message of the scene.
    fn report(&mut self, fault: Fault) {
        let span = self.span_of(&fault.path);
        let message = match fault.path.as_str() {
            "" => fault.message,
            path => format!("{path}: {}", fault.message),
        };
        let out = &mut self.out.diagnostics;
        let d = match fault.severity {
            Severity::Error => out.error(span, message),
            _ => out.warning(span, message),
        };
        d.hint = fault.hint;
    }

    /// The texture that is 1 everywhere.
    fn white(&mut self) -> TextureId {
        match self.white {
            Some(id) => id,
            None => *self.white.insert(self.out.float(1.0)),
        }
    }
}
