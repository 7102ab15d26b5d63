//! Meshes with colours as binary glTF (Khronos 2021, glTF 2.0, sec. 4 and 5), to be shown unlit
//! (KHR_materials_unlit).

use kaustika_film::files::replace;
use kaustika_scene::description::TriMesh;
use serde_json::{Value, json};
use std::io;
use std::path::Path;

/// Numbers of the format.
const ARRAY_BUFFER: u32 = 34_962;
const ELEMENT_ARRAY_BUFFER: u32 = 34_963;
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;

/// Writes a mesh as .glb: positions, indices and, if it has the attribute `vertex_color` of three
/// channels, linear colours. The file appears when it is complete.
///
/// # Errors
/// As the file system's, or if the mesh is empty or too large for the format.
pub fn write_glb(path: &Path, mesh: &TriMesh) -> io::Result<()> {
    let wrong = |text: &str| io::Error::new(io::ErrorKind::InvalidInput, text.to_string());
    if mesh.positions.is_empty() || mesh.indices.is_empty() {
        return Err(wrong("there is nothing in the mesh, and glTF knows no empty ones"));
    }
    let colors = mesh.attributes.iter().find(|a| a.name == "vertex_color" && a.channels == 3);
    let mut data = Vec::new();
    let mut views = Vec::new();
    let mut part = |bytes: &mut dyn Iterator<Item = [u8; 4]>, target: u32| {
        let start = data.len();
        bytes.for_each(|b| data.extend(b));
        views.push(json!({"buffer": 0, "byteOffset": start, "byteLength": data.len() - start,
            "target": target}));
    };
    let positions = mesh.positions.iter().flat_map(|p| [p.x, p.y, p.z]);
    part(&mut positions.map(f32::to_le_bytes), ARRAY_BUFFER);
    part(&mut mesh.indices.iter().flatten().map(|i| i.to_le_bytes()), ELEMENT_ARRAY_BUFFER);
    if let Some(colors) = colors {
        part(&mut colors.values.iter().map(|c| c.to_le_bytes()), ARRAY_BUFFER);
    }
    let (least, most) = mesh
        .positions
        .iter()
        .fold((mesh.positions[0], mesh.positions[0]), |(a, b), p| (a.min(*p), b.max(*p)));
    let vertices = mesh.positions.len();
    let mut attributes = json!({"POSITION": 0});
    let mut accessors = vec![
        json!({"bufferView": 0, "componentType": FLOAT, "count": vertices, "type": "VEC3",
            "min": [least.x, least.y, least.z], "max": [most.x, most.y, most.z]}),
        json!({"bufferView": 1, "componentType": UNSIGNED_INT, "count": 3 * mesh.indices.len(),
            "type": "SCALAR"}),
    ];
    if colors.is_some() {
        attributes["COLOR_0"] = Value::from(2);
        accessors.push(
            json!({"bufferView": 2, "componentType": FLOAT, "count": vertices, "type": "VEC3"}),
        );
    }
    let scene = json!({
        "asset": {"version": "2.0", "generator": "Kaustika"},
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": 1, "material": 0}]}],
        "materials": [{"extensions": {"KHR_materials_unlit": {}}}],
        "buffers": [{"byteLength": data.len()}], "bufferViews": views, "accessors": accessors,
    });
    let mut text = scene.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + text.len() + 8 + data.len();
    let length = u32::try_from(length).map_err(|_| wrong("a .glb holds at most 4 GiB"))?;
    let mut file = Vec::with_capacity(length as usize);
    let mut chunk = |kind: &[u8; 4], bytes: &[u8]| {
        file.extend((bytes.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(bytes);
    };
    chunk(b"JSON", &text);
    chunk(b"BIN\0", &data);
    let mut all = b"glTF".to_vec();
    all.extend(2u32.to_le_bytes());
    all.extend(length.to_le_bytes());
    all.extend(file);
    replace(path, &all).map_err(|e| io::Error::other(e.to_string()))
}
