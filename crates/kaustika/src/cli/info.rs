//! `kaustika info`.

use super::args::InfoArgs;
use super::failure::Failure;
use super::{diagnostics, stdout};
use kaustika::load;
use kaustika::scene::description::{
    CameraDesc, GeometryDesc, SceneDescription, Severity, ShapeDesc, SourceFormat,
};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// Says what a scene file holds.
///
/// # Errors
/// If the scene has errors; they and what could be read are shown all the same.
pub fn run(args: &InfoArgs) -> Result<(), Failure> {
    let description = load(&args.scene, &args.define);
    let mut summary = summarise(&description);
    if args.json {
        summary.push(("messages", messages(&description)));
        let map: Map<String, Value> =
            summary.into_iter().map(|(k, v)| (k.to_string(), v)).collect();
        stdout::write_json(&Value::Object(map))?;
    } else {
        diagnostics::show(&description.sources, &description.diagnostics, false);
        let lines = summary.iter().map(|(key, value)| format!("{key:24} {}\n", plain(value)));
        stdout::write(&lines.collect::<String>())?;
    }
    match description.diagnostics.has_errors() {
        true => Err(Failure::Told),
        false => Ok(()),
    }
}

/// What there is to say, in order.
fn summarise(d: &SceneDescription) -> Vec<(&'static str, Value)> {
    let in_groups = d.groups.iter().flat_map(|g| &g.shapes);
    let shapes: Vec<&ShapeDesc> = d.shapes.iter().chain(in_groups).collect();
    let is_mesh = |s: &&&ShapeDesc| matches!(s.geometry, GeometryDesc::Mesh(_));
    let meshes = shapes.iter().filter(is_mesh).count();
    let stored =
        triangles(&d.shapes) + d.groups.iter().map(|g| triangles(&g.shapes)).sum::<usize>();
    let instanced = d.instances.iter().filter_map(|i| d.groups.get(i.group.0 as usize));
    let placed = triangles(&d.shapes) + instanced.map(|g| triangles(&g.shapes)).sum::<usize>();
    let integrator = json!({
        "name": d.integrator.name,
        "max_depth": d.integrator.max_depth,
        "rr_depth": d.integrator.rr_depth,
    });
    vec![
        ("scene", d.sources.files.first().map(|f| f.path.display().to_string()).into()),
        ("format", format_name(d.format).into()),
        ("files", d.sources.files.len().into()),
        ("shapes", shapes.len().into()),
        ("shape_kinds", count(shapes.iter().map(|s| variant(&s.geometry)))),
        ("analytic_shapes", (shapes.len() - meshes).into()),
        ("triangles", stored.into()),
        ("groups", d.groups.len().into()),
        ("instances", d.instances.len().into()),
        ("triangles_with_instances", placed.into()),
        ("emitting_shapes", shapes.iter().filter(|s| s.emission.is_some()).count().into()),
        ("lights", d.lights.len().into()),
        ("light_kinds", count(d.lights.iter().map(|l| variant(&l.kind)))),
        ("materials", d.materials.len().into()),
        ("material_kinds", count(d.materials.iter().map(|m| variant(&m.model)))),
        ("textures", d.textures.len().into()),
        ("texture_kinds", count(d.textures.iter().map(|t| variant(&t.node)))),
        ("media", count(d.media.iter().map(|m| m.kind.clone()))),
        ("cameras", d.cameras.iter().map(camera).collect()),
        ("integrator", integrator),
        ("errors", d.diagnostics.count(Severity::Error).into()),
        ("warnings", d.diagnostics.count(Severity::Warning).into()),
    ]
}

fn triangles(shapes: &[ShapeDesc]) -> usize {
    let of_shape = |s: &ShapeDesc| match &s.geometry {
        GeometryDesc::Mesh(mesh) => mesh.indices.len(),
        GeometryDesc::Displaced(of) => of.mesh.indices.len(),
        _ => 0,
    };
    shapes.iter().map(of_shape).sum()
}

fn camera(c: &CameraDesc) -> Value {
    let film = &c.film;
    json!({
        "name": c.name,
        "kind": variant(&c.kind),
        "resolution": film.resolution,
        "crop": film.crop,
        "filter": variant(&film.filter),
        "film": film.filename,
        "sampler": c.sampler,
        "spp": c.spp,
        "medium": c.medium.is_some(),
    })
}

fn messages(d: &SceneDescription) -> Value {
    let severity = |s| match s {
        Severity::Note => "note",
        Severity::Warning => "warning",
        Severity::Error => "error",
    };
    let one = |m: &kaustika::scene::description::Diagnostic| {
        json!({
            "severity": severity(m.severity),
            "message": m.message,
            "place": m.span.map(|s| d.sources.location(s)),
            "hint": m.hint,
        })
    };
    d.diagnostics.entries.iter().map(one).collect()
}

fn format_name(f: SourceFormat) -> &'static str {
    match f {
        SourceFormat::BuiltIn => "built-in",
        SourceFormat::Pbrt => "pbrt",
        SourceFormat::Mitsuba3 => "mitsuba",
        SourceFormat::Mitsuba06 => "mitsuba 0.6",
        SourceFormat::Gltf => "glTF",
    }
}

/// The name of an enum's variant in lower case, as `Debug` begins.
fn variant(value: &impl std::fmt::Debug) -> String {
    use std::fmt::Write;
    /// Takes the first word and refuses the rest, so that no mesh is ever printed.
    struct FirstWord(String);
    impl Write for FirstWord {
        fn write_str(&mut self, s: &str) -> std::fmt::Result {
            let word = s.split(|c: char| !c.is_alphanumeric()).next().unwrap_or("");
            self.0.push_str(word);
            if word.len() == s.len() { Ok(()) } else { Err(std::fmt::Error) }
        }
    }
    let mut first = FirstWord(String::new());
    // The error is how it ends early.
    let _ = write!(first, "{value:?}");
    snake_case(&first.0)
}

fn snake_case(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars() {
        if c.is_uppercase() && !out.is_empty() {
            out.push('_');
        }
        out.extend(c.to_lowercase());
    }
    out
}

fn count(kinds: impl Iterator<Item = String>) -> Value {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for kind in kinds {
        *counts.entry(kind).or_default() += 1;
    }
    counts.into_iter().map(|(k, n)| (k, Value::from(n))).collect::<Map<_, _>>().into()
}

/// A value in one line, without JSON's marks where they can be spared.
fn plain(value: &Value) -> String {
    match value {
        Value::String(s) => s.clone(),
        Value::Null => "-".into(),
        Value::Object(map) if map.is_empty() => "-".into(),
        Value::Object(map) => {
            let shown = map.iter().filter(|(_, v)| !v.is_null());
            let pairs: Vec<String> = shown.map(|(k, v)| format!("{k} {}", plain(v))).collect();
            pairs.join(", ")
        }
        Value::Array(items) if items.iter().all(Value::is_number) => {
            items.iter().map(plain).collect::<Vec<_>>().join(" x ")
        }
        Value::Array(items) => items.iter().map(plain).collect::<Vec<_>>().join("; "),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variants_are_named_without_their_contents() {
        assert_eq!(variant(&GeometryDesc::Rectangle), "rectangle");
        assert_eq!(variant(&SourceFormat::BuiltIn), "built_in");
        let sphere = GeometryDesc::Sphere { radius: 1.0, z_min: -1.0, z_max: 1.0, phi_max: 360.0 };
        assert_eq!(variant(&sphere), "sphere");
        assert_eq!(variant(&Some(vec![1, 2])), "some");
    }
}
