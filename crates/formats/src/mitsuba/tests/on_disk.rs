//! Whole scenes, by hand.

use super::read_mitsuba;
use kaustika_scene::description::*;
use std::path::{Path, PathBuf};

/// Every scene below the folder in KAUSTIKA_SCENES is read without error.
#[test]
#[ignore = "needs KAUSTIKA_SCENES, a folder of scenes"]
fn scenes_on_disk_are_read() {
    let folder = std::env::var("KAUSTIKA_SCENES").expect("KAUSTIKA_SCENES names a folder");
    let mut files = Vec::new();
    xml_below(Path::new(&folder), &mut files);
    files.sort();
    let mut failed = 0;
    for file in &files {
        let d = read_mitsuba(file, &[]);
        let triangles: usize = d
            .shapes
            .iter()
            .map(|s| match &s.geometry {
                GeometryDesc::Mesh(mesh) => mesh.indices.len(),
                GeometryDesc::Rectangle => 2,
                GeometryDesc::Cube => 12,
                _ => 0,
            })
            .sum();
        println!(
            "{}: {triangles} triangles, {} shapes, {} materials, {} lights, {} emitters, {} \
             cameras, {} {:?}",
            file.display(),
            d.shapes.len(),
            d.materials.len(),
            d.lights.len(),
            d.shapes.iter().filter(|s| s.emission.is_some()).count(),
            d.cameras.len(),
            d.integrator.name,
            d.integrator.max_depth,
        );
        for m in &d.diagnostics.entries {
            let at = m.span.map_or(String::new(), |s| d.sources.location(s));
            let hint = m.hint.as_deref().unwrap_or_default();
            println!("  {:?}: {at}: {} [{}] ({hint})", m.severity, m.message, m.label);
        }
        failed += usize::from(d.diagnostics.has_errors());
    }
    assert_eq!(failed, 0, "of {} scenes", files.len());
}

fn xml_below(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let name = entry.file_name();
        // Parts that only make sense inside other files.
        let part = name == "fragments" || name == "include";
        if path.is_dir() && !part {
            xml_below(&path, out);
        } else if path.extension().is_some_and(|e| e == "xml") {
            out.push(path);
        }
    }
}
