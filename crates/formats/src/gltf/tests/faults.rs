//! Broken files and the messages about them.

use super::*;

/// Each text after the asset has exactly the one message beside it.
fn all_are(cases: &[(&str, &str)]) {
    let wrong: Vec<String> = cases
        .iter()
        .map(|(rest, expected)| {
            let text = format!(r#"{{"asset":{{"version":"2.0"}},{rest}}}"#);
            (rest, expected, messages(&parse(&text)))
        })
        .filter(|(_, expected, found)| found[..] != [expected.to_string()])
        .map(|(text, expected, found)| format!("{text}\n  expected {expected}\n  found {found:?}"))
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn files_that_are_no_scenes() {
    let of = |text: &str| messages(&parse(text)).join("; ");
    assert_eq!(of("{\"asset\": }"), "error malformed JSON: expected value");
    assert_eq!(of(""), "error malformed JSON: EOF while parsing a value");
    assert_eq!(of("{}"), "error `asset` is missing");
    assert_eq!(
        of(r#"{"asset":{"version":"1.1"}}"#),
        "error asset: expected glTF version 2.0, found `1.1` | write version 2.0; converters from \
         glTF 1.0 exist"
    );
    let glb = |bytes: &[u8]| messages(&parse_gltf(Path::new("a.glb"), bytes.to_vec())).join("; ");
    assert_eq!(glb(b"glTF"), "error a.glb: the file ends at byte 4, within a header");
    let mut file = triangle().binary(r#""nodes":[]"#);
    file.truncate(100);
    assert!(glb(&file).starts_with("error a.glb: byte 12: a chunk of "), "{}", glb(&file));
    assert_eq!(glb(b"\xff\xfe"), "error a.glb: not UTF-8 from byte 0");
}

#[test]
fn places_are_told() {
    let text = "{\n \"asset\": {\"version\": \"2.0\"},\n \"nodes\": [{}, {\"camera\": 3}]\n}";
    let d = parse(text);
    let entry = &d.diagnostics.entries[0];
    assert_eq!(
        entry.message,
        "nodes[1].camera: there is no camera 3: the file has 0, counted from 0"
    );
    assert_eq!(d.sources.line_column(entry.span.unwrap()), (3, 27));
    let text = "{\n \"asset\": {\"version\": \"2.0\"},\n \"nodes\": [}\n}";
    let d = parse(text);
    assert_eq!(d.sources.line_column(d.diagnostics.entries[0].span.unwrap()), (3, 12));
}

#[test]
fn values_of_the_wrong_kind() {
    all_are(&[
        (r#""nodes":{}"#, "error nodes: expected a list, found an object"),
        (
            r#""nodes":[{"translation":[1,2]}]"#,
            "error nodes[0].translation: expected a list of 3 numbers, found a list of 2",
        ),
        (
            r#""nodes":[{"scale":[1,"x",2]}]"#,
            "error nodes[0].scale[1]: expected a number, found \"x\"",
        ),
        (
            r#""nodes":[{"children":[1]},{"children":[0]}]"#,
            "error nodes: no node is at the top: each is another's child",
        ),
        (
            r#""scenes":[{"nodes":[0]}],"nodes":[{"children":[0]}]"#,
            "error nodes[0]: a node with two parents, or its own ancestor",
        ),
        (
            r#""cameras":[{"type":"fisheye"}],"nodes":[{"camera":0}]"#,
            "error cameras[0].type: expected `perspective` or `orthographic`",
        ),
        (
            r#""cameras":[{"type":"perspective","perspective":{"yfov":60,"znear":1}}],"nodes":[{"camera":0}]"#,
            "error cameras[0].perspective.yfov: a field of view of half a turn or more | `yfov` is in radians",
        ),
        (
            r#""buffers":[{"byteLength":4}],"bufferViews":[{"buffer":0,"byteLength":4}],
            "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":1}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}]"#,
            "error buffers[0]: neither `uri` nor the binary chunk of a .glb holds its bytes | a .gltf \
             file needs a `uri` for every buffer",
        ),
    ]);
}

#[test]
fn what_is_not_read_is_told() {
    all_are(&[
        (
            r#""extensionsRequired":["KHR_draco_mesh_compression"]"#,
            "error extensionsRequired[0]: `KHR_draco_mesh_compression` is not supported: the geometry \
             is compressed | write the scene without compression, for example with `gltf-transform copy`",
        ),
        (
            r#""extensionsRequired":["VENDOR_thing"]"#,
            "warning required extension `VENDOR_thing` is not supported | the picture may differ from \
             what the file asks for",
        ),
        (
            r#""animations":[{}]"#,
            "warning animations are not played: everything stands as its nodes say",
        ),
        (r#""skins":[{}]"#, "warning skins are not applied: meshes stand in their rest pose"),
    ]);
}

/// Numbers that lie outside of their buffers.
#[test]
fn ranges_are_checked() {
    let with = |accessor: &str, primitive: &str| {
        let mut file = triangle();
        file.accessors.push(accessor.into());
        let rest = format!(r#""meshes":[{{"primitives":[{primitive}]}}],"nodes":[{{"mesh":0}}]"#);
        messages(&file.read(&rest)).join("; ")
    };
    let position = r#"{"attributes":{"POSITION":2}}"#;
    let a = |count: &str, rest: &str| {
        format!(r#"{{"bufferView":0,"componentType":5126,"type":"VEC3","count":{count}{rest}}}"#)
    };
    assert_eq!(
        with(&a("4", ""), position),
        "error accessors[2]: 4 elements of 12 bytes, 12 apart, from byte 0 of a view of 36 bytes"
    );
    assert_eq!(
        with(&a("18446744073709551615", r#","byteOffset":12"#), position),
        "error accessors[2]: 18446744073709551615 elements of 12 bytes, 12 apart, from byte 12 of a \
         view of 36 bytes"
    );
    assert_eq!(
        with(r#"{"componentType":5126,"type":"VEC3","count":9000000000}"#, position),
        "error accessors[2]: 9000000000 elements without a buffer view"
    );
    let indices = r#"{"bufferView":0,"componentType":5125,"type":"SCALAR","count":6}"#;
    assert_eq!(
        with(indices, r#"{"attributes":{"POSITION":0},"indices":2}"#),
        "error accessors[2]: index 3 is 1065353216, but there are 3 vertices"
    );
    assert_eq!(
        with(&a("3", ""), r#"{"attributes":{"POSITION":0,"NORMAL":1}}"#),
        "error accessors[1]: 3 numbers an element expected, found 2"
    );
}

/// A broken image costs its file's picture; a kind that is not read, its texture.
#[test]
fn images_have_their_faults() {
    let with = |texture: &str| {
        let d = triangle().read(&format!(
            r#""materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],
            "images":[{{"uri":"data:image/png;base64,iVBORw0KGgo="}},{{"uri":"none.png"}}],
            "textures":[{texture}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"material":0}}]}}],
            "nodes":[{{"mesh":0}}]"#
        ));
        messages(&d).first().cloned().unwrap_or_default()
    };
    assert!(with(r#"{"source":0}"#).starts_with("error images[0]: can't read image: "));
    assert!(with(r#"{"source":1}"#).starts_with("error images[1]: can't read none.png: "));
    assert_eq!(
        with(r#"{"extensions":{"KHR_texture_basisu":{"source":0}}}"#),
        "warning textures[0]: its only image is one of `KHR_texture_basisu`, which is not supported | \
         the texture is left out"
    );
}
