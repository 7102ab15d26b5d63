//! Writers of small mesh files, independent of the readers.

use std::fmt::Write as _;
use std::io::Write as _;

use kaustika_scene::description::TriMesh;

/// Encoding of a PLY file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    Ascii,
    Little,
    Big,
}

pub const ORDERS: [Order; 3] = [Order::Ascii, Order::Little, Order::Big];

/// A stored value: a number or a list.
#[derive(Clone, Debug)]
pub enum Value {
    N(f64),
    L(Vec<f64>),
}

/// A PLY element: name, lines `TYPE NAME` or `list COUNT ITEM NAME`, and records.
#[derive(Clone, Debug)]
pub struct El {
    pub name: String,
    pub properties: Vec<String>,
    pub records: Vec<Vec<Value>>,
}

pub fn el(name: &str, properties: &[&str], records: Vec<Vec<Value>>) -> El {
    El {
        name: name.into(),
        properties: properties.iter().map(|p| p.to_string()).collect(),
        records,
    }
}

/// A record of numbers.
pub fn numbers(values: &[f64]) -> Vec<Value> {
    values.iter().map(|&v| Value::N(v)).collect()
}

/// A record of one list.
pub fn list(values: &[f64]) -> Vec<Value> {
    vec![Value::L(values.to_vec())]
}

/// Four vertices in a unit square.
pub fn square() -> El {
    let at = |x, y| numbers(&[x, y, 0.0]);
    el(
        "vertex",
        &["float x", "float y", "float z"],
        vec![at(0., 0.), at(1., 0.), at(1., 1.), at(0., 1.)],
    )
}

pub fn faces(lists: &[&[f64]]) -> El {
    let records = lists.iter().map(|l| list(l)).collect();
    el("face", &["list uchar int vertex_indices"], records)
}

fn put(out: &mut Vec<u8>, order: Order, of: &str, value: f64) {
    let mut bytes = match of {
        "char" => (value as i8).to_le_bytes().to_vec(),
        "uchar" | "uint8" => (value as u8).to_le_bytes().to_vec(),
        "short" => (value as i16).to_le_bytes().to_vec(),
        "ushort" => (value as u16).to_le_bytes().to_vec(),
        "int" | "int32" => (value as i32).to_le_bytes().to_vec(),
        "uint" => (value as u32).to_le_bytes().to_vec(),
        "int64" => (value as i64).to_le_bytes().to_vec(),
        "uint64" => (value as u64).to_le_bytes().to_vec(),
        "float" => (value as f32).to_le_bytes().to_vec(),
        "double" => value.to_le_bytes().to_vec(),
        other => panic!("the writer does not know type {other}"),
    };
    match order {
        Order::Ascii => {
            let mut text = String::new();
            match of {
                "float" => write!(text, "{} ", value as f32).unwrap(),
                _ => write!(text, "{value} ").unwrap(),
            }
            out.extend_from_slice(text.as_bytes());
        }
        Order::Little => out.append(&mut bytes),
        Order::Big => out.extend(bytes.iter().rev()),
    }
}

pub fn ply_file(order: Order, elements: &[El]) -> Vec<u8> {
    let format = match order {
        Order::Ascii => "ascii",
        Order::Little => "binary_little_endian",
        Order::Big => "binary_big_endian",
    };
    let mut header = format!("ply\nformat {format} 1.0\ncomment made by a test\n");
    for e in elements {
        writeln!(header, "element {} {}", e.name, e.records.len()).unwrap();
        for p in &e.properties {
            writeln!(header, "property {p}").unwrap();
        }
    }
    header.push_str("end_header\n");
    let mut out = header.into_bytes();
    for e in elements {
        for record in &e.records {
            for (property, value) in e.properties.iter().zip(record) {
                let words: Vec<&str> = property.split(' ').collect();
                match value {
                    Value::N(value) => put(&mut out, order, words[0], *value),
                    Value::L(values) => {
                        put(&mut out, order, words[1], values.len() as f64);
                        for value in values {
                            put(&mut out, order, words[2], *value);
                        }
                    }
                }
            }
            if order == Order::Ascii {
                out.pop();
                out.push(b'\n');
            }
        }
    }
    out
}

/// The elements for `super::sample()` or a mesh with the same attributes.
pub fn of_mesh(mesh: &TriMesh) -> Vec<El> {
    let mut vertex = vec!["float x", "float y", "float z"];
    if !mesh.normals.is_empty() {
        vertex.extend(["float nx", "float ny", "float nz"]);
    }
    vertex.extend(["float u", "float v", "float r", "float g", "float b", "float heat_0"]);
    let [color, heat, index, tint] = [0, 1, 2, 3].map(|i| &mesh.attributes[i].values);
    let vertices = (0..mesh.positions.len())
        .map(|v| {
            let p = mesh.positions[v];
            let mut all = vec![p.x, p.y, p.z];
            if let Some(n) = mesh.normals.get(v) {
                all.extend([n.x, n.y, n.z]);
            }
            all.extend([mesh.uvs[v].x, mesh.uvs[v].y]);
            all.extend_from_slice(&color[3 * v..][..3]);
            all.push(heat[v]);
            all.iter().map(|&x| Value::N(x as f64)).collect()
        })
        .collect();
    let face = [
        "list uchar int vertex_indices",
        "float tint_r",
        "float tint_g",
        "float tint_b",
        "int face_indices",
    ];
    let triangles = (0..mesh.indices.len())
        .map(|f| {
            let mut record = list(&mesh.indices[f].map(f64::from));
            record.extend(tint[3 * f..][..3].iter().map(|&x| Value::N(x as f64)));
            record.push(Value::N(index[f] as f64));
            record
        })
        .collect();
    vec![el("vertex", &vertex, vertices), el("face", &face, triangles)]
}

pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut out = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    out.write_all(bytes).unwrap();
    out.finish().unwrap()
}

pub fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut out = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    out.write_all(bytes).unwrap();
    out.finish().unwrap()
}

/// The inflated content of a `.serialized` mesh.
pub fn serialized_content(version: u16, double: bool, extra_flags: u32, mesh: &TriMesh) -> Vec<u8> {
    let color = mesh.attributes.iter().find(|a| a.name == "vertex_color");
    let flag = |bit: u32, on: bool| if on { bit } else { 0 };
    let flags = flag(1, !mesh.normals.is_empty())
        | flag(2, !mesh.uvs.is_empty())
        | flag(8, color.is_some())
        | if double { 0x2000 } else { 0x1000 }
        | extra_flags;
    let mut out = flags.to_le_bytes().to_vec();
    if version == 4 {
        out.extend_from_slice(b"a name\0");
    }
    out.extend_from_slice(&(mesh.positions.len() as u64).to_le_bytes());
    out.extend_from_slice(&(mesh.indices.len() as u64).to_le_bytes());
    let mut values: Vec<f32> = Vec::new();
    values.extend(mesh.positions.iter().flat_map(|p| [p.x, p.y, p.z]));
    values.extend(mesh.normals.iter().flat_map(|n| [n.x, n.y, n.z]));
    values.extend(mesh.uvs.iter().flat_map(|t| [t.x, t.y]));
    values.extend(color.iter().flat_map(|a| &a.values));
    for value in values {
        match double {
            true => out.extend_from_slice(&(value as f64).to_le_bytes()),
            false => out.extend_from_slice(&value.to_le_bytes()),
        }
    }
    for index in mesh.indices.as_flattened() {
        out.extend_from_slice(&index.to_le_bytes());
    }
    out
}

/// A `.serialized` file of the given contents.
pub fn serialized_file(version: u16, contents: &[Vec<u8>]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut offsets = Vec::new();
    for content in contents {
        offsets.push(out.len());
        out.extend_from_slice(&0x041Cu16.to_le_bytes());
        out.extend_from_slice(&version.to_le_bytes());
        out.extend(zlib(content));
    }
    for offset in offsets {
        match version {
            3 => out.extend_from_slice(&(offset as u32).to_le_bytes()),
            _ => out.extend_from_slice(&(offset as u64).to_le_bytes()),
        }
    }
    out.extend_from_slice(&(contents.len() as u32).to_le_bytes());
    out
}
