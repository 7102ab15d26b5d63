//! Tests of the readers on files that are made here: what is right comes back as it was, what is
//! wrong is named, and nothing panics.

mod files;
mod fuzz;
mod obj;
mod ply;
mod ply_faults;
mod serialized;
mod written;

use super::*;
use files::{Order, ply_file};

/// A mesh with everything: normals, uvs, colours, attributes of vertices and faces. All numbers
/// are exact in single precision and in text.
fn sample() -> TriMesh {
    use kaustika_math::Vec2;
    use kaustika_scene::description::MeshAttribute;
    let attribute = |name: &str, channels, per_face, values: &[f32]| MeshAttribute {
        name: name.into(),
        channels,
        per_face,
        values: values.to_vec(),
    };
    TriMesh {
        positions: vec![
            Vec3::new(0.0, -0.5, 0.25),
            Vec3::new(1.5, 0.0, 0.0),
            Vec3::new(0.0, 2.25, -1e-3),
            Vec3::new(1.0, 1.0, 1e10),
        ],
        normals: vec![Vec3::X, Vec3::Y, Vec3::new(0.6, 0.0, 0.8), -Vec3::Z],
        uvs: vec![
            Vec2::new(0.0, 0.0),
            Vec2::new(1.0, 0.25),
            Vec2::new(0.5, 1.0),
            Vec2::new(-3.0, 7.5),
        ],
        indices: vec![[0, 1, 2], [3, 2, 1], [0, 3, 1]],
        attributes: vec![
            attribute(
                "vertex_color",
                3,
                false,
                &[0.0, 0.5, 1.0, 0.25, 0.125, 2.0, 3.0, 4.0, 5.0, 0.1, 0.2, 0.3],
            ),
            attribute("vertex_heat", 1, false, &[1.0, 2.0, 3.0, 4.0]),
            attribute("face_indices", 1, true, &[7.0, -1.0, 9.0]),
            attribute("face_tint_color", 3, true, &[0.5; 9]),
        ],
    }
}

fn parse_ply(bytes: &[u8]) -> Result<TriMesh, Fault> {
    parse_mesh(bytes, MeshFormat::Ply, &MeshOptions::default(), &mut Vec::new())
}

/// The message as a user sees it after the file's name.
fn message(fault: Result<TriMesh, Fault>) -> String {
    let error = MeshError::new(Path::new("m"), fault.expect_err("an error was expected"));
    error.to_string()
}

#[test]
fn the_extension_names_the_format() {
    let format = |name: &str| MeshFormat::from_path(Path::new(name));
    assert_eq!(format("a/b.ply"), Some(MeshFormat::Ply));
    assert_eq!(format("B.PLY.gz"), Some(MeshFormat::Ply));
    assert_eq!(format("c.Obj"), Some(MeshFormat::Obj));
    assert_eq!(format("d.serialized"), Some(MeshFormat::Serialized));
    assert_eq!(format("e.stl"), None);
    assert_eq!(format("ply"), None);
    assert_eq!(format("ply.gz"), None);
    let error = read_mesh(Path::new("x/e.stl"), &MeshOptions::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "x/e.stl: unknown mesh format `stl` (known: ply, obj, serialized, each also with .gz)"
    );
}

#[test]
fn a_missing_file_is_an_error_with_its_name() {
    let error = read_mesh(Path::new("/no/such/file.ply"), &MeshOptions::default()).unwrap_err();
    assert!(matches!(error.cause, MeshCause::Io(_)));
    assert!(error.to_string().starts_with("/no/such/file.ply: "), "{error}");
}

#[test]
fn gzip_is_known_by_its_magic_bytes() {
    let plain = ply_file(Order::Ascii, &files::of_mesh(&sample()));
    let zipped = files::gzip(&plain);
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.ply", "a.ply.gz"] {
        let path = folder.path().join(name);
        for bytes in [&plain, &zipped] {
            std::fs::write(&path, bytes).unwrap();
            let read = read_mesh(&path, &MeshOptions::default()).unwrap();
            assert_eq!(read, sample(), "{name}");
        }
        std::fs::write(&path, &zipped[..zipped.len() - 9]).unwrap();
        let error = read_mesh(&path, &MeshOptions::default()).unwrap_err();
        assert!(matches!(error.cause, MeshCause::Compression(_)), "{error}");
    }
}

#[test]
fn mitsubas_defaults() {
    assert!(MeshOptions::mitsuba(MeshFormat::Obj).flip_v);
    assert!(!MeshOptions::mitsuba(MeshFormat::Ply).flip_v);
    assert!(!MeshOptions::mitsuba(MeshFormat::Serialized).flip_v);
    // Normals are computed where a file has none.
    let bare = TriMesh { normals: Vec::new(), ..sample() };
    let bytes = ply_file(Order::Little, &files::of_mesh(&bare));
    let options = MeshOptions::mitsuba(MeshFormat::Ply);
    let mesh = parse_mesh(&bytes, MeshFormat::Ply, &options, &mut Vec::new()).unwrap();
    assert_eq!(mesh.normals.len(), 4);
    assert_eq!(parse_ply(&bytes).unwrap(), bare);
}

#[test]
fn stored_normals_become_unit_or_zero() {
    let mut dropped = 0;
    assert_eq!(unit_normal(Vec3::new(0.0, 3.0, 4.0), &mut dropped), Vec3::new(0.0, 0.6, 0.8));
    assert_eq!(unit_normal(Vec3::new(1e-30, 0.0, 0.0), &mut dropped), Vec3::X);
    assert_eq!(unit_normal(Vec3::new(0.0, 1e30, 0.0), &mut dropped), Vec3::Y);
    assert_eq!(unit_normal(Vec3::ZERO, &mut dropped), Vec3::ZERO);
    assert_eq!(dropped, 0);
    assert_eq!(unit_normal(Vec3::new(f32::NAN, 0.0, 1.0), &mut dropped), Vec3::ZERO);
    assert_eq!(unit_normal(Vec3::new(f32::INFINITY, 0.0, 1.0), &mut dropped), Vec3::ZERO);
    assert_eq!(dropped, 2);
}
