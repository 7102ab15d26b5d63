//! Wavefront OBJ.

use super::*;
use crate::mesh::obj::parse_parts;
use kaustika_math::Vec2;

fn read_with(text: &str, options: &MeshOptions) -> (TriMesh, Vec<MeshNote>) {
    let mut notes = Vec::new();
    let mesh = parse_mesh(text.as_bytes(), MeshFormat::Obj, options, &mut notes);
    (mesh.unwrap_or_else(|e| panic!("{e:?}")), notes)
}

fn read(text: &str) -> TriMesh {
    read_with(text, &MeshOptions::default()).0
}

fn fault(text: &str) -> String {
    let options = MeshOptions::default();
    message(parse_mesh(text.as_bytes(), MeshFormat::Obj, &options, &mut Vec::new()))
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn corners_that_agree_in_all_indices_become_one_vertex() {
    let text = format!(
        "{SQUARE}vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\nvn 0 0 2\nvn 1 0 0\n\
         f 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/4/1\nf 1/2/1 3/3/3 2/2/1\n"
    );
    let mesh = read(&text);
    // Corner 1/2/1 differs in uv and 3/3/3 in normal; 2/2/1 is known.
    assert_eq!(mesh.indices, [[0, 1, 2], [0, 2, 3], [4, 5, 1]]);
    assert_eq!(mesh.positions[4], mesh.positions[0]);
    assert_eq!(mesh.uvs[4], Vec2::new(1.0, 0.0));
    assert_eq!(mesh.normals[5], Vec3::X);
    assert_eq!(mesh.normals[0], Vec3::Z);
    assert_eq!((mesh.uvs.len(), mesh.normals.len()), (6, 6));
}

#[test]
fn all_forms_of_corners() {
    let base = format!("{SQUARE}vt 0.5 0.25\nvn 0 0 1\n");
    let mesh = read(&format!("{base}f 1 2 3\n"));
    assert!(mesh.uvs.is_empty() && mesh.normals.is_empty());
    let mesh = read(&format!("{base}f 1/1 2/1 3/1\n"));
    assert!(mesh.uvs == [Vec2::new(0.5, 0.25); 3] && mesh.normals.is_empty());
    let mesh = read(&format!("{base}f 1//1 2//1 3//1\n"));
    assert!(mesh.uvs.is_empty() && mesh.normals == [Vec3::Z; 3]);
    let mesh = read(&format!("{base}f -4/-1/-1 -3/-1/-1 +3/1/1\n"));
    assert_eq!(mesh.indices, [[0, 1, 2]]);
    assert_eq!(mesh.positions[2], Vec3::new(1.0, 1.0, 0.0));
    // Partly missing: zero, before and after.
    let mesh = read(&format!("{base}f 1 2/1 3//1\nf 1 3 4\n"));
    assert_eq!(mesh.uvs[..3], [Vec2::ZERO, Vec2::new(0.5, 0.25), Vec2::ZERO]);
    assert_eq!(mesh.normals[..3], [Vec3::ZERO, Vec3::ZERO, Vec3::Z]);
    assert_eq!((mesh.uvs.len(), mesh.normals.len(), mesh.positions.len()), (5, 5, 5));
}

#[test]
fn negative_indices_count_from_the_last_read_so_far() {
    let mesh =
        read("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf -3 -2 -1\n");
    assert_eq!(mesh.positions.len(), 6);
    assert_eq!(mesh.positions[3].x, 5.0);
}

#[test]
fn polygons_become_fans() {
    let (mesh, notes) = read_with(
        &format!("{SQUARE}v 0 2 0\nf 1 2 3 4\nf 1 2 3 4 5\nf 1 2\nf\n"),
        &MeshOptions::default(),
    );
    assert_eq!(mesh.indices, [[0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    let fanned = MeshNote::PolygonsFanned { count: 1, largest: 5 };
    assert_eq!(notes, [MeshNote::ThinFacesSkipped(2), fanned]);
}

#[test]
fn comments_unknown_lines_continuations_and_odd_spaces() {
    let text = "# a comment\r\nmtllib x.mtl\r\n\r\n  v\t0 0 0 # first\r\nv 1 0 \\\r\n 0\r\nv 0 1 0 1.0\r\n\
                s off\r\nl 1 2\r\no thing\r\nf 1 2 \\\n3\r\n\u{fffd}";
    let mesh = read(text);
    assert_eq!(mesh.indices, [[0, 1, 2]]);
    assert_eq!(mesh.positions[1], Vec3::X);
    // Without an end of the last line.
    assert_eq!(read(&format!("{SQUARE}f 1 2 3")).indices, [[0, 1, 2]]);
    assert_eq!(read("").indices.len(), 0);
}

#[test]
fn unused_vertices_vanish() {
    let mesh = read(&format!("v 9 9 9\n{SQUARE}f 2 3 4\n"));
    assert_eq!(mesh.positions.len(), 3);
}

#[test]
fn options() {
    let text = format!("{SQUARE}vt 0 0.25\nvt 1\nvn 1 0 0\nf 1/1/1 2/2/1 3/1/1\n");
    let mitsuba = MeshOptions::mitsuba(MeshFormat::Obj);
    let (mesh, _) = read_with(&text, &mitsuba);
    assert_eq!(mesh.uvs, [Vec2::new(0.0, 0.75), Vec2::new(1.0, 1.0), Vec2::new(0.0, 0.75)]);
    assert_eq!(mesh.normals, [Vec3::X; 3]);
    let flat = MeshOptions { normals: NormalPolicy::Flat, ..mitsuba.clone() };
    assert!(read_with(&text, &flat).0.normals.is_empty());
    let (mesh, _) = read_with(&format!("{SQUARE}f 1 2 3\n"), &mitsuba);
    assert_eq!(mesh.normals, [Vec3::Z; 3]);
}

#[test]
fn parts_split_by_name_and_material() {
    let text = format!(
        "{SQUARE}o first thing\nusemtl red\nf 1 2 3\nusemtl blue\\path # why\nf 1 3 4\ng empty\n\
         g second\nf 4 3 1\n"
    );
    let parts = parse_parts(text.as_bytes(), &MeshOptions::default(), &mut Vec::new()).unwrap();
    let names: Vec<_> = parts.iter().map(|p| (p.name.as_str(), p.material.as_deref())).collect();
    assert_eq!(
        names,
        [
            ("first thing", Some("red")),
            ("first thing", Some("blue\\path")),
            ("second", Some("blue\\path"))
        ]
    );
    for part in &parts {
        assert_eq!(part.mesh.indices, [[0, 1, 2]]);
        assert_eq!(part.mesh.positions.len(), 3);
    }
    assert_eq!(parts[2].mesh.positions[0], Vec3::Y);
    assert_eq!(read(&text).indices.len(), 3);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    std::fs::write(&path, &text).unwrap();
    let again = read_obj_parts(&path, &MeshOptions::default(), &mut Vec::new()).unwrap();
    assert_eq!(again, parts);
}

#[test]
fn faults_are_named_with_their_line() {
    let cases = [
        ("f 1 2 5", "m:5: vertex index 5 is out of range (there are 4)"),
        ("f 1 2 -5", "m:5: vertex index -5 is out of range (there are 4)"),
        ("f 1 2 0", "m:5: vertex index 0 is out of range (they count from 1)"),
        ("f 1/1 2 3", "m:5: texture coordinate index 1 is out of range (there are 0)"),
        ("f 1//1 2 3", "m:5: normal index 1 is out of range (there are 0)"),
        ("f 1 2 x", "m:5: expected a vertex index, found `x`"),
        ("f 1 2 3/", ""),
        ("f 1 2 //", "m:5: expected v, v/vt, v//vn or v/vt/vn, found `//`"),
        ("f 1 2 3///1", "m:5: expected v, v/vt, v//vn or v/vt/vn, found `3///1`"),
        (
            "f 1 2 99999999999999999999",
            "m:5: expected a vertex index, found `99999999999999999999`",
        ),
        ("v 1 2", "m:5: expected a number, found the line's end"),
        ("v 1 2 z", "m:5: expected a number, found `z`"),
        ("v 1 nan 2", "m:5: the position is not finite"),
        ("v 1 1e39 2", "m:5: the position is not finite"),
        ("vt", "m:5: expected a number, found the line's end"),
        ("vn 0 0", "m:5: expected a number, found the line's end"),
    ];
    for (line, expected) in cases {
        let text = format!("{SQUARE}{line}\nf 1 2 3\n");
        match expected {
            "" => assert!(!read(&text).indices.is_empty(), "{line}"),
            _ => assert_eq!(fault(&text), expected, "{line}"),
        }
    }
}

#[test]
fn normals_that_are_not_finite_are_dropped() {
    let text = format!("{SQUARE}vn nan 0 1\nvn 0 0 9\nf 1//1 2//2 3//2\n");
    let (mesh, notes) = read_with(&text, &MeshOptions::default());
    assert_eq!(mesh.normals, [Vec3::ZERO, Vec3::Z, Vec3::Z]);
    assert_eq!(notes, [MeshNote::NormalsDropped(1)]);
}
