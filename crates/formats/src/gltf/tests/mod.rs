//! Tests of the reader on small files.

mod faults;
mod fuzz;
mod geometry;
mod lights;
mod materials;

use super::{parse_gltf, read_gltf};
use base64::Engine;
use kaustika_math::{Vec2, Vec3};
use kaustika_scene::description::*;
use std::path::Path;
use std::sync::Arc;

/// Bytes of a list of numbers, and the `data:` URI of such.
fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn uri(bytes: &[u8]) -> String {
    let text = base64::engine::general_purpose::STANDARD.encode(bytes);
    format!("data:application/octet-stream;base64,{text}")
}

/// A file under construction: buffer, views and accessors of its own.
#[derive(Default)]
struct File {
    bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl File {
    /// Adds an accessor; `rest` is what stands in it besides view, count and types.
    fn add(&mut self, bytes: &[u8], component: u32, ty: &str, count: usize, rest: &str) -> usize {
        self.view(bytes);
        let view = self.views.len() - 1;
        self.accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":{component},"type":"{ty}","count":{count}{rest}}}"#
        ));
        self.accessors.len() - 1
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        while !self.bytes.len().is_multiple_of(4) {
            self.bytes.push(0);
        }
        let (offset, length) = (self.bytes.len(), bytes.len());
        self.bytes.extend_from_slice(bytes);
        self.views.push(format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length}}}"#));
        self.views.len() - 1
    }

    /// The JSON with `rest` after the lists; `uri` as its buffer's member.
    fn json(&self, uri: Option<String>, rest: &str) -> String {
        let uri = uri.map_or(String::new(), |u| format!(r#""uri":"{u}","#));
        format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{{uri}"byteLength":{}}}],"bufferViews":[{}],"accessors":[{}],{rest}}}"#,
            self.bytes.len(),
            self.views.join(","),
            self.accessors.join(",")
        )
    }

    fn read(&self, rest: &str) -> SceneDescription {
        parse(&self.json(Some(uri(&self.bytes)), rest))
    }

    /// The same as a `.glb`.
    fn binary(&self, rest: &str) -> Vec<u8> {
        let mut json = self.json(None, rest).into_bytes();
        while !json.len().is_multiple_of(4) {
            json.push(b' ');
        }
        let mut out = b"glTF".to_vec();
        let length = 12 + 8 + json.len() + 8 + self.bytes.len();
        for v in [2, length as u32, json.len() as u32] {
            out.extend(v.to_le_bytes());
        }
        out.extend(b"JSON");
        out.extend(json);
        out.extend((self.bytes.len() as u32).to_le_bytes());
        out.extend(b"BIN\0");
        out.extend(&self.bytes);
        out
    }
}

/// A unit triangle in the plane z = 0 as accessor 0, its texture coordinates as accessor 1.
fn triangle() -> File {
    let mut file = File::default();
    file.add(&floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]), 5126, "VEC3", 3, "");
    file.add(&floats(&[0.0, 0.25, 1.0, 0.25, 0.0, 1.0]), 5126, "VEC2", 3, "");
    file
}

fn parse(text: &str) -> SceneDescription {
    parse_gltf(Path::new("a.gltf"), text.as_bytes().to_vec())
}

/// The messages as `severity message | hint`, notes left out.
fn messages(d: &SceneDescription) -> Vec<String> {
    let entries = d.diagnostics.entries.iter().filter(|m| m.severity > Severity::Note);
    entries
        .map(|m| {
            let severity = format!("{:?}", m.severity).to_lowercase();
            let hint = m.hint.as_ref().map_or(String::new(), |h| format!(" | {h}"));
            format!("{severity} {}{hint}", m.message)
        })
        .collect()
}

/// The description, in which nothing may be wrong.
fn sound(d: SceneDescription) -> SceneDescription {
    let messages = messages(&d);
    assert!(messages.is_empty(), "{messages:#?}");
    d
}

/// The triangle with a material, and with `rest` after it.
fn with_material(material: &str, rest: &str) -> SceneDescription {
    sound(triangle().read(&format!(
        r#""materials":[{material}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"material":0}}]}}],
        "nodes":[{{"mesh":0}}]{rest}"#
    )))
}

fn mesh(d: &SceneDescription, shape: usize) -> Arc<TriMesh> {
    let GeometryDesc::Mesh(mesh) = &d.shapes[shape].geometry else { panic!() };
    mesh.clone()
}

fn model(d: &SceneDescription, id: MaterialId) -> &MaterialModel {
    &d.materials[id.0 as usize].model
}

fn node(d: &SceneDescription, id: TextureId) -> &TextureNode {
    &d.textures[id.0 as usize].node
}

/// The metallic-roughness model of the only shape, whatever lies around it.
fn metallic_roughness(d: &SceneDescription) -> &MetallicRoughnessDesc {
    let mut id = d.shapes[0].material;
    loop {
        match model(d, id) {
            MaterialModel::TwoSided { front, .. } => id = *front,
            MaterialModel::NormalMap { material, .. } => id = *material,
            MaterialModel::MetallicRoughness(desc) => return desc,
            other => panic!("{other:?}"),
        }
    }
}

fn float(d: &SceneDescription, id: TextureId) -> f32 {
    let TextureNode::Float(v) = node(d, id) else { panic!("{:?}", node(d, id)) };
    *v
}

fn rgb(d: &SceneDescription, id: TextureId) -> [f32; 3] {
    match node(d, id) {
        TextureNode::Float(v) => [*v; 3],
        TextureNode::Spectrum(kaustika_spectra::SpectrumDesc::Rgb { rgb, .. }) => *rgb,
        other => panic!("{other:?}"),
    }
}
