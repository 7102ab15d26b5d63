//! Tests of the reader on small scenes.

mod cameras;
mod daylight;
mod faults;
mod language;
mod lights;
mod materials;
mod media;
mod meters;
mod on_disk;
mod shapes;

use super::read_mitsuba;
use kaustika_scene::description::*;
use tempfile::TempDir;

/// Files in a folder of their own.
struct Files {
    folder: TempDir,
}

impl Files {
    fn new(files: &[(&str, &str)]) -> Files {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (name, text) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().expect("names have a folder"))
                .expect("folders can be made");
            std::fs::write(path, text).expect("files can be written");
        }
        Files { folder }
    }

    fn read(&self, name: &str, defines: &[(&str, &str)]) -> SceneDescription {
        let defines: Vec<(String, String)> =
            defines.iter().map(|(n, v)| (n.to_string(), v.to_string())).collect();
        read_mitsuba(&self.folder.path().join(name), &defines)
    }

    /// The messages as `severity line:column message | label | hint`, empty parts left out, the
    /// folder's name left out.
    fn messages(&self, d: &SceneDescription) -> Vec<String> {
        let prefix = format!("{}/", self.folder.path().display());
        d.diagnostics
            .entries
            .iter()
            .map(|m| {
                let at = m.span.map_or("-".to_string(), |s| {
                    let (line, column) = d.sources.line_column(s);
                    format!("{line}:{column}")
                });
                let severity = format!("{:?}", m.severity).to_lowercase();
                let mut text = format!("{severity} {at} {}", m.message);
                for part in [m.label.as_str(), m.hint.as_deref().unwrap_or_default()] {
                    if !part.is_empty() {
                        text.push_str(&format!(" | {part}"));
                    }
                }
                text.replace(&prefix, "")
            })
            .collect()
    }
}

/// A camera, so that its lack is not reported.
const CAMERA: &str = r#"<sensor type="perspective"/>"#;

/// Reads what stands inside a Mitsuba 3 scene, after a camera; there must be no message.
fn scene(inner: &str) -> SceneDescription {
    silent("3.0.0", inner)
}

/// The same in Mitsuba 0.6.
fn scene06(inner: &str) -> SceneDescription {
    silent("0.6.0", inner)
}

fn silent(version: &str, inner: &str) -> SceneDescription {
    let (d, messages) = read(version, inner);
    assert!(messages.is_empty(), "{messages:#?}");
    d
}

fn read(version: &str, inner: &str) -> (SceneDescription, Vec<String>) {
    let text = format!("<scene version=\"{version}\">{CAMERA}\n{inner}\n</scene>");
    let files = Files::new(&[("scene.xml", &text)]);
    let d = files.read("scene.xml", &[]);
    let messages = files.messages(&d);
    (d, messages)
}

/// The model of the only shape's material.
fn only_model(d: &SceneDescription) -> &MaterialModel {
    assert_eq!(d.shapes.len(), 1);
    &d.materials[d.shapes[0].material.0 as usize].model
}

fn node(d: &SceneDescription, id: TextureId) -> &TextureNode {
    &d.textures[id.0 as usize].node
}

/// The material of a sphere around this bsdf.
fn on_sphere(bsdf: &str) -> String {
    format!("<shape type=\"sphere\">{bsdf}</shape>")
}
