//! Containers, accessors, primitives and nodes.

use super::*;

fn one_primitive(file: &File, primitive: &str) -> SceneDescription {
    let rest = format!(r#""meshes":[{{"primitives":[{primitive}]}}],"nodes":[{{"mesh":0}}]"#);
    sound(file.read(&rest))
}

#[test]
fn triangles_are_read_from_text_container_and_files() {
    let rest = r#""meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],
        "materials":[{"pbrMetallicRoughness":{"metallicFactor":0.5}}],
        "nodes":[{"mesh":0,"name":"thing"}]"#;
    let file = triangle();
    let text = sound(file.read(rest));
    assert_eq!(mesh(&text, 0).positions[1], Vec3::X);
    assert_eq!(mesh(&text, 0).indices, [[0, 1, 2]]);
    assert!(mesh(&text, 0).normals.is_empty(), "no normals: facets");
    assert_eq!(text.shapes[0].name, "thing");
    let glb = sound(parse_gltf(Path::new("a.glb"), file.binary(rest)));
    assert_eq!(mesh(&glb, 0), mesh(&text, 0));
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("a b.bin"), &file.bytes).expect("it can be written");
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, file.json(Some("a%20b.bin".into()), rest)).expect("it can be written");
    assert_eq!(mesh(&sound(read_gltf(&path)), 0), mesh(&text, 0));
}

#[test]
fn texture_coordinates_turn_over() {
    let map = r#"{"normalTexture":{"index":0},"extensions":{"KHR_materials_unlit":{}}}"#;
    let d = triangle().read(&format!(
        r#""materials":[{map}],"textures":[{{}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"material":0}}]}}],
        "nodes":[{{"mesh":0}}]"#
    ));
    assert_eq!(mesh(&d, 0).uvs[0], Vec2::new(0.0, 0.75));
}

#[test]
fn indices_of_every_width_and_all_modes() {
    for (component, bytes) in [
        (5121, vec![0u8, 1, 2, 3]),
        (5123, [0u16, 1, 2, 3].iter().flat_map(|v| v.to_le_bytes()).collect()),
        (5125, [0u32, 1, 2, 3].iter().flat_map(|v| v.to_le_bytes()).collect()),
    ] {
        for (mode, expected) in [(5, vec![[0, 1, 2], [1, 3, 2]]), (6, vec![[1, 2, 0], [2, 3, 0]])] {
            let mut file = File::default();
            file.add(&floats(&[0.0; 12]), 5126, "VEC3", 4, "");
            file.add(&bytes, component, "SCALAR", 4, "");
            let p = format!(r#"{{"attributes":{{"POSITION":0}},"indices":1,"mode":{mode}}}"#);
            assert_eq!(mesh(&one_primitive(&file, &p), 0).indices, expected, "{component} {mode}");
        }
    }
}

/// KHR_mesh_quantization: integers as they are or normalised, with a stride.
#[test]
fn integers_are_positions() {
    let mut file = File::default();
    let shorts = |v: &[i16]| -> Vec<u8> { v.iter().flat_map(|v| v.to_le_bytes()).collect() };
    // Three shorts and two unused bytes an element.
    file.view(&shorts(&[1, 2, 3, 0, -4, 5, 6, 0, 7, 8, -32768, 0]));
    file.views[0] = file.views[0].replace('}', r#","byteStride":8}"#);
    let accessor = |rest: &str| {
        format!(r#"{{"bufferView":0,"componentType":5122,"type":"VEC3","count":3{rest}}}"#)
    };
    let p = r#"{"attributes":{"POSITION":0}}"#;
    file.accessors.push(accessor(""));
    let d = one_primitive(&file, p);
    assert_eq!(mesh(&d, 0).positions[1], Vec3::new(-4.0, 5.0, 6.0));
    file.accessors[0] = accessor(r#","normalized":true"#);
    let d = one_primitive(&file, p);
    assert_eq!(mesh(&d, 0).positions[2], Vec3::new(7.0 / 32767.0, 8.0 / 32767.0, -1.0));
}

#[test]
fn sparse_accessors_replace_elements() {
    let mut file = triangle();
    let places = file.view(&[2]);
    let values = file.view(&floats(&[5.0, 6.0, 7.0]));
    let sparse = format!(
        r#""sparse":{{"count":1,"indices":{{"bufferView":{places},"componentType":5121}},"values":{{"bufferView":{values}}}}}"#
    );
    let p = r#"{"attributes":{"POSITION":2}}"#;
    let of = |file: &mut File, view: &str| {
        file.accessors.truncate(2);
        file.accessors
            .push(format!(r#"{{{view}"componentType":5126,"type":"VEC3","count":3,{sparse}}}"#));
        mesh(&one_primitive(file, p), 0).positions.clone()
    };
    let replaced = Vec3::new(5.0, 6.0, 7.0);
    assert_eq!(of(&mut file, r#""bufferView":0,"#), [Vec3::ZERO, Vec3::X, replaced]);
    assert_eq!(of(&mut file, ""), [Vec3::ZERO, Vec3::ZERO, replaced]);
}

#[test]
fn colours_of_vertices_are_factors() {
    let mut file = triangle();
    let bytes = [255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 51];
    file.add(&bytes, 5121, "VEC4", 3, r#","normalized":true"#);
    let d = sound(file.read(
        r#""materials":[{"alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[0.5,1,1,0.5]}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":2},"material":0},
                                 {"attributes":{"POSITION":0},"material":0}]}],
        "nodes":[{"mesh":0}]"#,
    ));
    let names: Vec<_> = mesh(&d, 0).attributes.iter().map(|a| a.name.clone()).collect();
    assert_eq!(names, ["vertex_color", "vertex_alpha"]);
    assert_eq!(mesh(&d, 0).attributes[1].values[2], 0.2);
    let TextureNode::Scale { texture, scale } = node(&d, metallic_roughness(&d).base_color) else {
        panic!()
    };
    assert_eq!(rgb(&d, *texture), [0.5, 1.0, 1.0]);
    assert!(matches!(node(&d, *scale), TextureNode::MeshAttribute { .. }));
    assert!(matches!(node(&d, d.shapes[0].alpha.unwrap()), TextureNode::Scale { .. }));
    // The same material on a mesh without colours.
    assert_eq!(float(&d, d.shapes[1].alpha.unwrap()), 0.5);
}

#[test]
fn nodes_move_turn_and_scale_their_children() {
    let d = sound(triangle().read(
        r#""meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "scenes":[{"nodes":[1]},{"nodes":[0]}],"scene":1,
        "nodes":[{"translation":[1,2,3],"rotation":[0,0,0.70710678,0.70710678],"scale":[2,2,2],
                  "children":[1,2]},
                 {"mesh":0,"matrix":[1,0,0,0, 0,1,0,0, 0,0,-1,0, 0,0,5,1]},
                 {"mesh":0,"scale":[0,0,0]}]"#,
    ));
    // The node of scale 0 is not there.
    assert_eq!(d.shapes.len(), 1);
    let p = d.shapes[0].transform.point(Vec3::new(1.0, 0.0, 1.0));
    // (1, 0, 5 - 1) twice as large, a quarter turn about z, moved.
    assert!((p - Vec3::new(1.0, 4.0, 11.0)).length() < 1e-5, "{p:?}");
    assert!(d.shapes[0].transform.swaps_handedness());
}

#[test]
fn instances_have_their_places() {
    let mut file = triangle();
    file.add(&floats(&[0.0, 0.0, 0.0, 7.0, 0.0, 0.0]), 5126, "VEC3", 2, "");
    let d = sound(file.read(
        r#""meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "extensionsUsed":["EXT_mesh_gpu_instancing"],"extensionsRequired":["EXT_mesh_gpu_instancing"],
        "nodes":[{"mesh":0,"translation":[0,1,0],
                  "extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":2}}}}]"#,
    ));
    let at: Vec<_> = d.shapes.iter().map(|s| s.transform.point(Vec3::ZERO)).collect();
    assert_eq!(at, [Vec3::Y, Vec3::new(7.0, 1.0, 0.0)]);
}

/// A large mesh in many places is stored once; one that emits is not, for each place has lights.
#[test]
fn large_meshes_are_shared() {
    let read = |material: &str| {
        let mut file = File::default();
        file.add(&floats(&[0.0; 9]), 5126, "VEC3", 3, "");
        let indices: Vec<u8> = (0..30_003u32).map(|i| (i % 3) as u8).collect();
        file.add(&indices, 5121, "SCALAR", indices.len(), "");
        sound(file.read(&format!(
            r#""materials":[{material}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"material":0}}]}}],
            "nodes":[{{"mesh":0}},{{"mesh":0}},{{"mesh":0}}]"#
        )))
    };
    let d = read("{}");
    assert_eq!((d.shapes.len(), d.groups.len(), d.instances.len()), (0, 1, 3));
    let d = read(r#"{"emissiveFactor":[1,1,1]}"#);
    assert_eq!((d.shapes.len(), d.groups.len(), d.instances.len()), (3, 0, 0));
}
