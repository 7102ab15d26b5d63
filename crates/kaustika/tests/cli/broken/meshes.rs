//! Broken mesh files, in scenes that are good otherwise.

use super::case::Case;

/// A pbrt scene with this file as its mesh.
fn ply(name: &'static str, bytes: impl AsRef<[u8]>) -> Case {
    Case::pbrt(name, "LightSource \"infinite\"\nShape \"plymesh\" \"string filename\" \"m.ply\"")
        .file("m.ply", bytes)
}

/// A Mitsuba scene with this file as its mesh.
fn obj(name: &'static str, text: &str) -> Case {
    Case::mitsuba(
        name,
        "<shape type=\"obj\">\n  <string name=\"filename\" value=\"m.obj\"/>\n</shape>",
    )
    .file("m.obj", text)
}

/// A scene of Mitsuba 0.6 with the mesh of this number in this file.
fn serialized(name: &'static str, number: u32, bytes: impl AsRef<[u8]>) -> Case {
    let shape = format!(
        "<shape type=\"serialized\">\n  <string name=\"filename\" value=\"m.serialized\"/>\n  \
         <integer name=\"shapeIndex\" value=\"{number}\"/>\n</shape>"
    );
    Case::mitsuba_06(name, &shape).file("m.serialized", bytes)
}

/// A serialized file of one mesh: these compressed bytes, and a directory that claims `meshes`.
fn one_mesh(compressed: &[u8], meshes: u32) -> Vec<u8> {
    let start = [0x1c, 0x04, 0x04, 0x00];
    [&start[..], compressed, &0u64.to_le_bytes(), &meshes.to_le_bytes()].concat()
}

/// A PLY header for this many vertices and triangles.
fn header(format: &str, vertices: u64, faces: u64) -> String {
    format!(
        "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
         property float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

/// One triangle with this corner and these indices.
fn triangle(corner: [f32; 3], indices: [i32; 3]) -> Vec<u8> {
    let mut bytes = header("binary_little_endian", 3, 1).into_bytes();
    for v in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], corner].concat() {
        bytes.extend(f32::to_le_bytes(v));
    }
    bytes.push(3);
    bytes.extend(indices.map(i32::to_le_bytes).concat());
    bytes
}

pub fn cases() -> Vec<Case> {
    let good = triangle([0.0, 1.0, 0.0], [0, 1, 2]);
    let text = |body: &str| header("ascii", 3, 1) + body;
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    vec![
        ply("ply-cut-in-the-vertices", &good[..good.len() - 30]),
        ply("ply-cut-in-the-faces", &good[..good.len() - 4]),
        ply("ply-cut-in-the-header", "ply\nformat ascii 1.0\nelement vertex 3\n"),
        ply("ply-index-out-of-range", triangle([0.0, 1.0, 0.0], [0, 1, 7])),
        ply("ply-negative-index", triangle([0.0, 1.0, 0.0], [0, 1, -1])),
        ply("ply-nan-vertex", triangle([0.0, f32::NAN, 0.0], [0, 1, 2])),
        ply("ply-infinite-vertex", triangle([f32::INFINITY, 1.0, 0.0], [0, 1, 2])),
        ply("ply-absurd-vertex-count", header("binary_little_endian", 1 << 60, 1)),
        ply("ply-absurd-face-count", header("ascii", 0, u64::MAX) + "3 0 1 2\n"),
        ply("ply-count-of-letters", "ply\nformat ascii 1.0\nelement vertex many\nend_header\n"),
        ply("ply-unknown-format", header("binary_middle_endian", 0, 0)),
        ply(
            "ply-unknown-type",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\nend_header\n",
        ),
        ply(
            "ply-without-z",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n0 0\n",
        ),
        ply("ply-text-garbage", text("0 0 0\n1 zero 0\n0 1 0\n3 0 1 2\n")),
        ply("ply-text-cut", text("0 0 0\n1 0 0\n")),
        ply("ply-is-something-else", "solid teapot\n"),
        ply("ply-empty", ""),
        obj("obj-index-out-of-range", &format!("{corners}f 1 2 4\n")),
        obj("obj-index-zero", &format!("{corners}f 0 1 2\n")),
        obj("obj-relative-index-out-of-range", &format!("{corners}f -1 -2 -9\n")),
        obj("obj-garbage-number", "v 0 0 0\nv 1 zero 0\nv 0 1 0\nf 1 2 3\n"),
        obj("obj-nan-vertex", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n"),
        obj("obj-missing-normal", &format!("{corners}f 1//1 2//1 3//1\n")),
        obj("obj-half-a-face", &format!("{corners}f 1/ 2/x 3\n")),
        serialized("serialized-empty", 0, []),
        serialized("serialized-is-something-else", 0, "ply\nformat ascii 1.0\n"),
        // An empty deflate stream; what is in it should be a mesh.
        serialized("serialized-cut", 0, one_mesh(&[0x78, 0x9c, 3, 0, 0, 0, 0, 1], 1)),
        serialized("serialized-garbage", 0, one_mesh(b"no deflate stream", 1)),
        serialized("serialized-no-such-mesh", 1, one_mesh(&[0x78, 0x9c, 3, 0, 0, 0, 0, 1], 1)),
        serialized("serialized-absurd-count", 0, one_mesh(&[0x78, 0x9c, 3], u32::MAX)),
    ]
}
