//! PLY files with something wrong, and what is said about it.

use super::files::{ORDERS, Order, el, faces, list, numbers, of_mesh, ply_file, square};
use super::*;

/// A sound text file, to be spoiled by replacements.
const SOUND: &str = "ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
3 0 1 2
";

fn spoiled(what: &str, with: &str) -> String {
    assert!(SOUND.contains(what));
    message(parse_ply(SOUND.replacen(what, with, 1).as_bytes()))
}

#[test]
fn the_sound_file_is_sound() {
    assert_eq!(parse_ply(SOUND.as_bytes()).unwrap().indices, [[0, 1, 2]]);
}

#[test]
fn header_faults_are_named_with_their_line() {
    let cases = [
        ("ply\n", "plyx\n", "m:1: not a PLY file: its first line is not `ply`"),
        ("ascii", "utf8", "m:2: unknown format `utf8`"),
        ("1.0", "2.0", "m:2: unknown version `2.0`, expected 1.0"),
        ("1.0", "", "m:2: `format` with 1 words after it"),
        ("format ascii 1.0\n", "", "m:8: the header has no `format`"),
        ("vertex 3", "vertex three", "m:3: `three` is not a count of elements"),
        ("vertex 3", "vertex -3", "m:3: `-3` is not a count of elements"),
        ("vertex 3\n", "vertex\n", "m:3: `element` with 1 words after it"),
        ("float y", "float32x y", "m:5: unknown type `float32x`"),
        ("float y", "float x", "m:5: `vertex` has property `x` a second time"),
        ("float z", "z", "m:6: expected `property TYPE NAME` or `property list TYPE TYPE NAME`"),
        ("element vertex 3\n", "", "m:3: `property` before the first `element`"),
        ("element face", "element vertex", "m:7: element `vertex` stands here a second time"),
        ("list uchar", "list float", "m:8: the count of a list must be an integer"),
        ("end_header", "end_haeder", "m:9: unknown header keyword `end_haeder`"),
        ("property float z\n", "", "m: element `vertex` lacks x, y or z"),
        ("element vertex", "element corner", "m: no element `vertex`"),
        ("element face", "element edge", "m: no element `face`: points alone make no surface"),
        ("vertex_indices", "indices", "m: element `face` lacks the list `vertex_indices`"),
    ];
    for (what, with, expected) in cases {
        assert_eq!(spoiled(what, with), expected, "{what} -> {with}");
    }
    assert_eq!(message(parse_ply(b"")), "m:1: not a PLY file: its first line is not `ply`");
    assert_eq!(message(parse_ply(b"ply\nformat ascii 1.0")), "m:2: the file ends too early");
}

#[test]
fn text_that_is_no_number_is_named_with_its_line() {
    let cases = [
        ("0 1 0", "0 1 o", "m:12: expected a number, found `o`"),
        ("3 0 1 2", "3 0 1 2.5", "m:13: expected an integer, found 2.5"),
        ("3 0 1 2", "3 0 one 2", "m:13: expected an integer, found `one`"),
        ("3 0 1 2", "-3 0 1 2", "m:13: a list of -3 entries"),
    ];
    for (what, with, expected) in cases {
        assert_eq!(spoiled(what, with), expected, "{what} -> {with}");
    }
}

#[test]
fn an_index_out_of_range_is_named_with_its_face() {
    for order in ORDERS {
        let bad = |index: f64| {
            let bytes = ply_file(order, &[square(), faces(&[&[0., 1., 2.], &[0., 1., index]])]);
            message(parse_ply(&bytes))
        };
        assert_eq!(bad(4.0), "m, face 1: vertex index 4 is out of range (there are 4)");
        assert_eq!(bad(-1.0), "m, face 1: vertex index -1 is out of range (there are 4)");
        let strip = el("tristrips", &["list int int vertex_indices"], vec![list(&[0., -2.])]);
        assert_eq!(
            message(parse_ply(&ply_file(order, &[square(), strip]))),
            "m, tristrips 0: vertex index -2 is out of range (there are 4)"
        );
        // Larger than any signed index.
        let huge = el("face", &["list uchar uint64 vertex_indices"], vec![list(&[0., 1., 1e19])]);
        let text = message(parse_ply(&ply_file(order, &[square(), huge])));
        assert!(text.contains("out of range") || text.contains("expected an integer"), "{text}");
    }
}

#[test]
fn a_negative_list_length_is_an_error() {
    let mut bytes = ply_file(
        Order::Big,
        &[square(), el("face", &["list char int vertex_indices"], vec![list(&[])])],
    );
    *bytes.last_mut().unwrap() = 0x80;
    assert_eq!(message(parse_ply(&bytes)), "m, face 0: a list of -128 entries");
}

#[test]
fn positions_that_are_not_finite_are_named_with_their_vertex() {
    for order in ORDERS {
        for bad in [f64::NAN, f64::INFINITY, -1e39] {
            for number in [0, 255, 256, 299] {
                let mut records = vec![numbers(&[0.0, 1.0, 2.0]); 300];
                records[number][number % 3] = super::files::Value::N(bad);
                let vertex = el("vertex", &["double x", "double y", "double z"], records);
                let text = message(parse_ply(&ply_file(order, &[vertex, faces(&[])])));
                assert_eq!(text, format!("m, vertex {number}: the position is not finite"));
            }
        }
    }
}

#[test]
fn normals_that_are_not_finite_are_dropped() {
    let mut mesh = sample();
    mesh.normals[2] = Vec3::new(0.0, f32::NAN, 1.0);
    let mut notes = Vec::new();
    let bytes = ply_file(Order::Little, &of_mesh(&mesh));
    let read = parse_mesh(&bytes, MeshFormat::Ply, &MeshOptions::default(), &mut notes).unwrap();
    assert_eq!(read.normals[2], Vec3::ZERO);
    assert_eq!(read.normals[3], sample().normals[3]);
    assert_eq!(notes, [MeshNote::NormalsDropped(1)]);
}

#[test]
fn a_count_beyond_the_file_is_refused_before_memory_is_taken() {
    for count in ["4000000000", "100"] {
        assert_eq!(
            spoiled("vertex 3", &format!("vertex {count}")),
            format!("m: {count} of `vertex` are announced, but only 26 bytes are left")
        );
    }
    let text = spoiled("face 1", "face 1000000000000");
    assert_eq!(text, "m: 1000000000000 of `face` are announced, but only 9 bytes are left");
    assert_eq!(spoiled("vertex 3", "vertex 5000000000"), "m: more than 2^32 - 1 vertices");
    assert_eq!(
        spoiled("vertex 3", "vertex 99999999999999999999999"),
        "m:3: `99999999999999999999999` is not a count of elements"
    );
    // An element without properties takes no bytes, however many there are.
    let empty =
        SOUND.replacen("element vertex", "element nothing 18446744073709551615\nelement vertex", 1);
    assert!(parse_ply(empty.as_bytes()).is_ok());
    // A list longer than the file.
    let long = el("face", &["list uint uchar vertex_indices"], vec![list(&[0., 1., 2.])]);
    let mut bytes = ply_file(Order::Little, &[square(), long]);
    let at = bytes.len() - 7;
    bytes[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_eq!(message(parse_ply(&bytes)), "m, face 0: the file ends too early");
}

#[test]
fn every_truncation_is_an_error() {
    for order in ORDERS {
        let bytes = ply_file(order, &of_mesh(&sample()));
        // A text file may do without its last line's end.
        let whole = bytes.len() - usize::from(order == Order::Ascii);
        for length in 0..whole {
            let cut = &bytes[..length];
            let result = parse_ply(cut);
            // Nor does a last number show that its last digit is missing: here "9" has one digit.
            assert!(result.is_err(), "{order:?}, {length} of {} bytes", bytes.len());
        }
        assert_eq!(parse_ply(&bytes).unwrap(), sample());
    }
}

#[test]
fn truncation_names_the_element() {
    // Lists of unknown length: the count alone does not show that the file is too short.
    let face = el("face", &["list uchar int vertex_indices"], vec![list(&[0., 1., 2.]); 3]);
    let bytes = ply_file(Order::Little, &[square(), face]);
    let text = message(parse_ply(&bytes[..bytes.len() - 5]));
    assert_eq!(text, "m, face 2: the file ends too early");
    let vertex = el(
        "vertex",
        &["float x", "float y", "float z", "list uchar float w"],
        vec![
            {
                let mut record = numbers(&[0., 0., 0.]);
                record.extend(list(&[1., 2., 3., 4.]));
                record
            };
            3
        ],
    );
    let bytes = ply_file(Order::Big, &[vertex, faces(&[])]);
    let text = message(parse_ply(&bytes[..bytes.len() - 1]));
    assert_eq!(text, "m, vertex 2: the file ends too early");
}
