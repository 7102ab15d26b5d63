//! The inputs that fuzzing began with, and those that it made readers fail on: none fails now.

use kaustika::film::files::{read_bitmap, read_picture};
use kaustika::formats::mesh::{MeshFormat, MeshOptions, parse_mesh};
use std::path::{Path, PathBuf};

/// The files of a target's corpus.
fn inputs(target: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(target);
    let mut files: Vec<PathBuf> = std::fs::read_dir(&folder)
        .unwrap_or_else(|e| panic!("{}: {e}", folder.display()))
        .map(|entry| entry.expect("a file").path())
        .collect();
    files.sort();
    assert!(!files.is_empty(), "{target}");
    files
}

#[test]
fn scenes_of_the_corpora_are_read() {
    for target in ["pbrt", "mitsuba", "gltf"] {
        for path in inputs(target) {
            // Sound or not, it is read to its end or refused with a reason.
            let _ = kaustika::load::load(&path, &[]);
        }
    }
}

#[test]
fn meshes_of_the_corpora_are_read() {
    let formats = [
        ("ply", MeshFormat::Ply),
        ("obj", MeshFormat::Obj),
        ("serialized", MeshFormat::Serialized),
    ];
    for (target, format) in formats {
        let mut sound = 0;
        for path in inputs(target) {
            let bytes = std::fs::read(&path).expect("a file");
            let options = MeshOptions::mitsuba(format);
            sound += usize::from(parse_mesh(&bytes, format, &options, &mut Vec::new()).is_ok());
        }
        assert!(sound > 0, "{target}: some are sound");
    }
}

#[test]
fn images_of_the_corpus_are_read() {
    const EXTENSIONS: [&str; 7] = ["exr", "png", "jpg", "tga", "hdr", "pfm", "jpeg"];
    let place = tempfile::tempdir().expect("a folder");
    let mut sound = 0;
    for path in inputs("image") {
        let bytes = std::fs::read(&path).expect("a file");
        let Some((&kind, bytes)) = bytes.split_first() else { continue };
        let extension = EXTENSIONS[usize::from(kind) % EXTENSIONS.len()];
        let path = place.path().join("input").with_extension(extension);
        std::fs::write(&path, bytes).expect("a file");
        sound += usize::from(read_bitmap(&path).is_ok() && read_picture(&path).is_ok());
    }
    assert!(sound >= 6, "{sound}: one of each format is sound");
}

#[test]
fn volumes_of_the_corpus_are_read() {
    let place = tempfile::tempdir().expect("a folder");
    let scene = place.path().join("scene.pbrt");
    let mut sound = 0;
    for volume in inputs("nanovdb") {
        let text = format!(
            "WorldBegin\nMakeNamedMedium \"m\" \"string type\" \"nanovdb\" \"string filename\" \"{}\"",
            volume.display()
        );
        std::fs::write(&scene, text).expect("a file");
        let read = kaustika::load::load(&scene, &[]);
        sound += usize::from(!read.diagnostics.has_errors());
    }
    assert_eq!(sound, 2);
}
