//! PLY files that are as they should be.

use super::files::{El, ORDERS, Order, Value, el, faces, list, numbers, of_mesh, ply_file, square};
use super::*;
use kaustika_math::Vec2;

/// Reads the same elements in all three encodings, which must agree.
fn read_all(elements: &[El], options: &MeshOptions) -> (TriMesh, Vec<MeshNote>) {
    let [a, b, c] = ORDERS.map(|order| {
        let mut notes = Vec::new();
        let bytes = ply_file(order, elements);
        let mesh = parse_mesh(&bytes, MeshFormat::Ply, options, &mut notes);
        (mesh.unwrap_or_else(|e| panic!("{order:?}: {e:?}")), notes)
    });
    assert_eq!(a, b);
    assert_eq!(b, c);
    a
}

fn read(elements: &[El]) -> (TriMesh, Vec<MeshNote>) {
    read_all(elements, &MeshOptions::default())
}

#[test]
fn all_encodings_give_the_same_mesh() {
    let (mesh, notes) = read(&of_mesh(&sample()));
    assert_eq!(mesh, sample());
    assert_eq!(notes, []);
}

#[test]
fn many_vertices_cross_the_block_size() {
    let n = 1000;
    let vertices = (0..n).map(|i| numbers(&[i as f64, -(i as f64), 0.5])).collect();
    let vertex = el("vertex", &["double x", "int y", "float z"], vertices);
    let triangles: Vec<[f64; 3]> =
        (0..n - 2).map(|i| [i as f64, i as f64 + 1., i as f64 + 2.]).collect();
    let lists: Vec<&[f64]> = triangles.iter().map(|t| t.as_slice()).collect();
    let (mesh, _) = read(&[vertex, faces(&lists)]);
    assert_eq!(mesh.positions.len(), n);
    assert!((0..n).all(|i| mesh.positions[i] == Vec3::new(i as f32, -(i as f32), 0.5)));
    assert!((0..n - 2).all(|i| mesh.indices[i] == [i as u32, i as u32 + 1, i as u32 + 2]));
}

#[test]
fn quads_are_cut_from_0_to_2_and_polygons_into_fans() {
    let polygon: &[f64] = &[3., 0., 1., 2., 1.];
    let (mesh, notes) = read(&[square(), faces(&[&[0., 1., 2., 3.], &[1., 2., 3.], polygon])]);
    let expected = [[0, 1, 2], [0, 2, 3], [1, 2, 3], [3, 0, 1], [3, 1, 2], [3, 2, 1]];
    assert_eq!(mesh.indices, expected);
    assert_eq!(notes, [MeshNote::PolygonsFanned { count: 1, largest: 5 }]);
}

#[test]
fn thin_faces_are_skipped_with_a_note() {
    let (mesh, notes) = read(&[square(), faces(&[&[0., 1.], &[], &[2., 1., 0.]])]);
    assert_eq!(mesh.indices, [[2, 1, 0]]);
    assert_eq!(notes, [MeshNote::ThinFacesSkipped(2)]);
}

#[test]
fn face_attributes_are_repeated_for_all_triangles_of_a_face() {
    let face = |corners: &[f64], tint: f64| {
        let mut record = vec![Value::N(tint)];
        record.extend(list(corners));
        record.push(Value::N(tint + 100.0));
        record
    };
    let element = el(
        "face",
        // Before and after the list.
        &["double mark_0", "list uchar int vertex_indices", "int face_indices"],
        vec![face(&[0., 1., 2., 3.], 5.0), face(&[0., 1.], 6.0), face(&[0., 1., 2.], 7.0)],
    );
    let (mesh, _) = read(&[square(), element]);
    let values = |name: &str| {
        let found = mesh.attributes.iter().find(|a| a.name == name).unwrap();
        assert!(found.per_face && found.channels == 1);
        found.values.clone()
    };
    assert_eq!(values("face_mark"), [5.0, 5.0, 7.0]);
    assert_eq!(values("face_indices"), [105.0, 105.0, 107.0]);
}

#[test]
fn all_integer_types_count_and_index() {
    for count in ["char", "uchar", "short", "ushort", "int", "uint", "int64", "uint64"] {
        for item in
            ["char", "uchar", "short", "ushort", "int32", "uint", "int64", "uint64", "float"]
        {
            let property = format!("list {count} {item} vertex_index");
            let element =
                el("face", &[&property], vec![list(&[3., 2., 1.]), list(&[0., 1., 2., 3.])]);
            let (mesh, _) = read(&[square(), element]);
            assert_eq!(mesh.indices, [[3, 2, 1], [0, 1, 2], [0, 2, 3]], "{property}");
        }
    }
}

#[test]
fn texture_coordinates_go_by_four_pairs_of_names() {
    for (u, v) in [("u", "v"), ("s", "t"), ("texture_u", "texture_v"), ("texture_s", "texture_t")] {
        let [u, v] = [u, v].map(|name| format!("float {name}"));
        let vertex = el(
            "vertex",
            // Out of order, too.
            &[&v, "float z", "float y", "float x", &u],
            (0..3).map(|i| numbers(&[0.25, 1.0, 2.0, i as f64, 0.75])).collect(),
        );
        let elements = [vertex, faces(&[&[0., 1., 2.]])];
        let (mesh, notes) = read(&elements);
        assert_eq!(mesh.uvs, [Vec2::new(0.75, 0.25); 3], "{u}");
        assert_eq!(mesh.positions[1], Vec3::new(1.0, 2.0, 1.0));
        assert_eq!(notes, []);
        let flipped = MeshOptions { flip_v: true, ..MeshOptions::default() };
        assert_eq!(read_all(&elements, &flipped).0.uvs, [Vec2::new(0.75, 0.75); 3]);
    }
}

#[test]
fn normals_are_dropped_for_flat_faces() {
    let options = MeshOptions { normals: NormalPolicy::Flat, ..MeshOptions::default() };
    let (mesh, notes) = read_all(&of_mesh(&sample()), &options);
    assert_eq!(mesh.normals, []);
    assert_eq!(mesh.attributes, sample().attributes);
    assert_eq!(notes, []);
}

#[test]
fn integer_colors_are_srgb() {
    let properties =
        ["float x", "float y", "float z", "uchar red", "uchar green", "uchar blue", "uchar alpha"];
    let record = |r, g, b, a| numbers(&[0., 0., 0., r, g, b, a]);
    let vertex = el(
        "vertex",
        &properties,
        vec![record(0., 255., 188., 51.), record(255., 0., 10., 0.), record(1., 2., 3., 255.)],
    );
    let (mesh, notes) = read(&[vertex, faces(&[&[0., 1., 2.]])]);
    assert_eq!(notes, []);
    let [color, alpha] = mesh.attributes.as_slice() else { panic!("{:?}", mesh.attributes) };
    assert_eq!((color.name.as_str(), color.channels), ("vertex_color", 3));
    assert_eq!((alpha.name.as_str(), alpha.channels), ("vertex_alpha", 1));
    // IEC 61966-2-1: 188/255 decodes to 0.5029, 10/255 to 0.003035.
    for (value, expected) in color.values.iter().zip([0.0, 1.0, 0.5029, 1.0, 0.0, 0.003035]) {
        assert!((value - expected).abs() < 1e-4, "{value} {expected}");
    }
    assert!((alpha.values[0] - 0.2).abs() < 1e-6);
}

#[test]
fn float_colors_are_linear_unless_asked() {
    let options = MeshOptions { srgb_float_colors: true, ..MeshOptions::default() };
    let elements = of_mesh(&sample());
    let linear = read(&elements).0.attributes;
    let decoded = read_all(&elements, &options).0.attributes;
    assert_eq!(linear[0].values[1], 0.5);
    assert!((decoded[0].values[1] - 0.21404).abs() < 1e-4);
    // Not a colour.
    assert_eq!(linear[1], decoded[1]);
}

#[test]
fn attributes_are_grouped_by_their_endings() {
    let names = [
        "float x",
        "float y",
        "float z", // positions
        "float wind_x",
        "float wind_y",
        "float wind_z", // three channels
        "float glow_r",
        "float glow_g",
        "float glow_b", // a colour
        "float a_0",
        "float b_1", // one channel each
        "float mat_1",
        "float mat_2",
        "float mat_3", // counted from one
        "float pair_0",
        "float pair_1", // two: no
        "float four_x",
        "float four_y",
        "float four_z",
        "float four_w", // four: no
        "float late_z", // does not begin with a first ending
        "float plain",  // no ending
    ];
    let records = (0..3)
        .map(|v| numbers(&(0..names.len()).map(|i| (100 * v + i) as f64).collect::<Vec<_>>()));
    let (mesh, notes) = read(&[el("vertex", &names, records.collect()), faces(&[&[0., 1., 2.]])]);
    let found: Vec<_> = mesh
        .attributes
        .iter()
        .map(|a| (a.name.as_str(), a.channels, a.values[a.channels as usize]))
        .collect();
    let expected = [
        ("vertex_wind", 3, 103.0),
        ("vertex_glow_color", 3, 106.0),
        ("vertex_a", 1, 109.0),
        ("vertex_b", 1, 110.0),
        ("vertex_mat", 3, 111.0),
    ];
    assert_eq!(found, expected);
    let skipped: Vec<_> = notes
        .iter()
        .map(|n| match n {
            MeshNote::Skipped { name, .. } => name.as_str(),
            other => panic!("{other}"),
        })
        .collect();
    assert_eq!(skipped, ["vertex pair", "vertex four", "vertex late_z", "vertex plain"]);
}

#[test]
fn unknown_elements_and_lists_are_passed_over() {
    let extra = el(
        "edge",
        &["int a", "list uchar float weights", "double b"],
        (0..300)
            .map(|i| vec![Value::N(i as f64), Value::L(vec![0.5; i % 4]), Value::N(1.0)])
            .collect(),
    );
    let fixed = el("material", &["uchar r"], vec![numbers(&[3.0]); 5]);
    let empty = el("nothing", &[], Vec::new());
    let vertex = el(
        "vertex",
        &["float x", "list uchar uchar tags", "float y", "float z"],
        (0..3)
            .map(|i| vec![Value::N(i as f64), Value::L(vec![1.0; i]), Value::N(5.0), Value::N(6.0)])
            .collect(),
    );
    let face = el(
        "face",
        &["list uchar float texcoord", "list uchar int vertex_indices"],
        vec![vec![Value::L(vec![0.5; 6]), Value::L(vec![0., 1., 2.])]],
    );
    // Faces may stand before the vertices that they use.
    let (mesh, notes) = read(&[extra, fixed, face, vertex, empty]);
    assert_eq!(mesh.indices, [[0, 1, 2]]);
    assert_eq!(mesh.positions[2], Vec3::new(2.0, 5.0, 6.0));
    assert_eq!(notes.len(), 5, "{notes:?}");
}

#[test]
fn strips_turn_every_other_triangle() {
    let strip = el(
        "tristrips",
        &["list int int vertex_indices"],
        vec![list(&[0., 1., 2., 3., -1., 3., 2., 1., -1., 0., 1.])],
    );
    let (mesh, _) = read(&[square(), strip]);
    assert_eq!(mesh.indices, [[0, 1, 2], [2, 1, 3], [3, 2, 1]]);
}

#[test]
fn header_lines_may_end_in_crlf() {
    let text = "ply\r\nformat ascii 1.0\r\ncomment x\r\nobj_info y\r\nelement vertex 3\r\nproperty float x\r\nproperty float y\r\nproperty float z\r\nelement face 1\r\nproperty list uchar int vertex_indices\r\nend_header\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n3 0 1 2\r\n";
    assert_eq!(parse_ply(text.as_bytes()).unwrap().indices, [[0, 1, 2]]);
    // Without the last line's end, and with numbers across lines.
    let text = text.trim_end().replace("1 0 0", "1\n0\n0").replace("3 0", "3.0 0");
    assert_eq!(parse_ply(text.as_bytes()).unwrap().indices, [[0, 1, 2]]);
}

#[test]
fn no_faces_at_all_is_an_empty_mesh() {
    let (mesh, _) = read(&[el("vertex", &["float x", "float y", "float z"], vec![]), faces(&[])]);
    assert_eq!(mesh, TriMesh::default());
}

#[test]
fn bytes_after_the_last_element_are_noted() {
    let mut bytes = ply_file(Order::Little, &of_mesh(&sample()));
    bytes.extend_from_slice(b"more");
    let mut notes = Vec::new();
    parse_mesh(&bytes, MeshFormat::Ply, &MeshOptions::default(), &mut notes).unwrap();
    assert_eq!(notes, [MeshNote::TrailingBytes(4)]);
}
