//! Tests of the whole reader, on texts and on small files in temporary folders.

mod broken;
mod defaults;
mod files;
mod lights;
mod materials;
mod media;
mod old;
mod shapes;
mod state;
mod textures;

use super::read_pbrt_str;
use kaustika_math::{Transform, Vec3};
use kaustika_scene::description::{
    Diagnostic, GeometryDesc, MaterialModel, SceneDescription, Severity, ShapeDesc, TextureId,
    TextureNode,
};
use kaustika_spectra::SpectrumDesc;
use std::path::Path;

/// Reads a whole file's text.
fn read(text: &str) -> SceneDescription {
    read_pbrt_str(text, Path::new("scene.pbrt"))
}

/// Reads what stands behind `WorldBegin`; there must be no messages.
fn world(text: &str) -> SceneDescription {
    let scene = read(&format!("WorldBegin\n{text}"));
    assert_eq!(messages(&scene), "", "{text}");
    scene
}

/// All messages as text.
fn messages(scene: &SceneDescription) -> String {
    scene.diagnostics.entries.iter().map(|d| message(scene, d)).collect()
}

fn message(scene: &SceneDescription, d: &Diagnostic) -> String {
    let word = match d.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Note => "note",
    };
    let place = d.span.map_or("-".to_string(), |s| {
        let (line, column) = scene.sources.line_column(s);
        let text = &scene.sources.files[s.file as usize].text[s.start as usize..s.end as usize];
        format!("{line}:{column} <{text}>")
    });
    let label = if d.label.is_empty() { String::new() } else { format!(" ({})", d.label) };
    let hint = d.hint.as_ref().map_or(String::new(), |h| format!("; {h}"));
    format!("{word} {place} {}{label}{hint}\n", d.message)
}

/// The number a texture is everywhere.
fn number(scene: &SceneDescription, id: TextureId) -> f32 {
    match &scene.textures[id.0 as usize].node {
        TextureNode::Float(v) | TextureNode::Spectrum(SpectrumDesc::Constant(v)) => *v,
        other => panic!("no number: {other:?}"),
    }
}

/// The colour a texture is everywhere.
fn rgb(scene: &SceneDescription, id: TextureId) -> [f32; 3] {
    match &scene.textures[id.0 as usize].node {
        TextureNode::Spectrum(SpectrumDesc::Rgb { rgb, .. }) => *rgb,
        other => panic!("no colour: {other:?}"),
    }
}

/// The name of the spectrum a texture is everywhere.
fn spectrum_name(scene: &SceneDescription, id: TextureId) -> String {
    match &scene.textures[id.0 as usize].node {
        TextureNode::Spectrum(SpectrumDesc::Named(named)) => named.name().to_string(),
        other => panic!("no named spectrum: {other:?}"),
    }
}

/// The model of a shape's material.
fn model<'a>(scene: &'a SceneDescription, shape: &ShapeDesc) -> &'a MaterialModel {
    &scene.materials[shape.material.0 as usize].model
}

/// Reads a scene of one sphere with this material.
fn material(text: &str) -> (SceneDescription, MaterialModel) {
    let scene = world(&format!("{text}\nShape \"sphere\""));
    let model = model(&scene, &scene.shapes[0]).clone();
    (scene, model)
}

fn sphere_radius(shape: &ShapeDesc) -> f32 {
    match shape.geometry {
        GeometryDesc::Sphere { radius, .. } => radius,
        _ => panic!("no sphere"),
    }
}

#[track_caller]
fn assert_maps(t: &Transform, from: [f32; 3], to: [f32; 3]) {
    let p = t.point(Vec3::from(from));
    assert!((p - Vec3::from(to)).length() < 1e-4, "{from:?} -> {p:?}, expected {to:?}");
}
