//! Mitsuba's `.serialized`.

use super::files::{gzip, serialized_content, serialized_file};
use super::*;

fn read_with(bytes: &[u8], options: &MeshOptions) -> Result<TriMesh, Fault> {
    parse_mesh(bytes, MeshFormat::Serialized, options, &mut Vec::new())
}

fn read(bytes: &[u8]) -> Result<TriMesh, Fault> {
    read_with(bytes, &MeshOptions::default())
}

/// The sample, with only what this format can hold.
fn plain() -> TriMesh {
    let mut mesh = sample();
    mesh.attributes.truncate(1);
    mesh
}

#[test]
fn versions_and_precisions_round_trip() {
    for version in [3, 4] {
        for double in [false, true] {
            let file = |mesh: &TriMesh| {
                serialized_file(version, &[serialized_content(version, double, 0, mesh)])
            };
            assert_eq!(read(&file(&plain())).unwrap(), plain(), "{version} {double}");
            let bare = TriMesh {
                positions: plain().positions,
                indices: plain().indices,
                ..TriMesh::default()
            };
            assert_eq!(read(&file(&bare)).unwrap(), bare, "{version} {double}");
            let options = MeshOptions::mitsuba(MeshFormat::Serialized);
            assert_eq!(read_with(&file(&bare), &options).unwrap().normals.len(), 4);
        }
    }
}

#[test]
fn many_elements_cross_the_buffers_size() {
    let n = 10_000;
    let mesh = TriMesh {
        positions: (0..n).map(|i| Vec3::splat(i as f32)).collect(),
        indices: (0..n).map(|i| [i, (i + 1) % n, (i + 2) % n]).collect(),
        ..TriMesh::default()
    };
    let file = serialized_file(4, &[serialized_content(4, false, 0, &mesh)]);
    assert_eq!(read(&file).unwrap(), mesh);
}

#[test]
fn shape_index_picks_a_mesh() {
    let meshes: Vec<TriMesh> = (0..3)
        .map(|i| {
            let mut mesh = plain();
            mesh.positions[0].x = i as f32;
            mesh
        })
        .collect();
    for version in [3, 4] {
        let contents: Vec<_> =
            meshes.iter().map(|m| serialized_content(version, false, 0, m)).collect();
        let file = serialized_file(version, &contents);
        let folder = tempfile::tempdir().unwrap();
        let paths = ["a.serialized", "b.serialized"].map(|name| folder.path().join(name));
        std::fs::write(&paths[0], &file).unwrap();
        std::fs::write(&paths[1], gzip(&file)).unwrap();
        let at = |shape_index| MeshOptions { shape_index, ..MeshOptions::default() };
        for (i, mesh) in meshes.iter().enumerate() {
            assert_eq!(read_with(&file, &at(i)).unwrap(), *mesh);
            for path in &paths {
                assert_eq!(count_serialized(path).unwrap(), 3);
                assert_eq!(read_mesh(path, &at(i)).unwrap(), *mesh);
            }
        }
        let text = message(read_with(&file, &at(3)));
        assert_eq!(text, "m: shape index 3 is out of range (the file holds 3, counted from 0)");
        // Of several, a dictionary that points past the end.
        let mut bad = file.clone();
        let last_offset = file.len() - 5;
        bad[last_offset] = 0x7f;
        let text = message(read_with(&bad, &at(2)));
        assert!(text.contains("beyond the end"), "{text}");
    }
}

#[test]
fn the_first_mesh_needs_no_dictionary() {
    let file = serialized_file(4, &[serialized_content(4, false, 0, &plain())]);
    let alone = &file[..file.len() - 12];
    assert_eq!(read(alone).unwrap(), plain());
}

#[test]
fn face_normals_are_noted_and_uvs_can_be_flipped() {
    let file = serialized_file(4, &[serialized_content(4, false, 0x10, &plain())]);
    let options = MeshOptions { flip_v: true, ..MeshOptions::default() };
    let mut notes = Vec::new();
    let mesh = parse_mesh(&file, MeshFormat::Serialized, &options, &mut notes).unwrap();
    assert_eq!(notes, [MeshNote::FaceNormalsFlag]);
    assert_eq!(mesh.uvs[1].y, 0.75);
    assert_eq!(mesh.normals, plain().normals);
}

#[test]
fn faults() {
    let content = serialized_content(4, false, 0, &plain());
    let spoil = |at: usize, bytes: &[u8]| {
        let mut content = content.clone();
        content[at..at + bytes.len()].copy_from_slice(bytes);
        message(read(&serialized_file(4, &[content])))
    };
    // Counts stand after the flags and the name.
    let counts = 4 + 7;
    let text = spoil(counts, &u64::MAX.to_le_bytes());
    assert!(text.contains("of `vertex` are announced"), "{text}");
    let text = spoil(counts + 6, &[1]);
    assert!(text.contains("of `vertex` are announced"), "{text}");
    let text = spoil(counts + 8, &1_000_000_000u64.to_le_bytes());
    assert!(text.contains("of `triangle` are announced"), "{text}");
    let text = spoil(counts + 16 + 12, &f32::NAN.to_le_bytes());
    assert_eq!(text, "m, vertex 1: the position is not finite");
    let text = spoil(content.len() - 4, &4u32.to_le_bytes());
    assert_eq!(text, "m, triangle 2: vertex index 4 is out of range (there are 4)");

    let file = serialized_file(4, &[content]);
    let mut bad = file.clone();
    bad[0] = 0x1d;
    let text = message(read(&bad));
    assert_eq!(text, "m, byte 0: not a serialized mesh: it begins with 0x041d, not 0x041c");
    bad = file.clone();
    bad[2] = 5;
    assert_eq!(message(read(&bad)), "m, byte 0: version 5 is not supported (3 and 4 are)");
    bad = file;
    bad[4] = 0;
    assert!(message(read(&bad)).contains("compressed data is damaged"));
}

#[test]
fn every_truncation_is_an_error() {
    let file = serialized_file(4, &[serialized_content(4, true, 0, &plain())]);
    // Without the dictionary (12 bytes) the mesh is still there.
    for length in 0..file.len() - 12 {
        assert!(read(&file[..length]).is_err(), "{length} of {}", file.len());
    }
    // A stream cut short before compression.
    let content = serialized_content(3, false, 0, &plain());
    for length in 0..content.len() {
        let file = serialized_file(3, &[content[..length].to_vec()]);
        assert!(read(&file).is_err(), "{length} of {}", content.len());
    }
}
