//! Several files: includes, imports, gzip, spectra, images, meshes.

use super::{assert_maps, messages, sphere_radius};
use crate::pbrt::read_pbrt;
use flate2::write::{GzEncoder, ZlibEncoder};
use flate2::{Compression, Crc};
use kaustika_scene::description::{
    Encoding, GeometryDesc, MaterialModel, SceneDescription, TextureNode,
};
use kaustika_spectra::SpectrumDesc;
use std::io::Write;
use std::path::Path;
use tempfile::TempDir;

fn folder(files: &[(&str, &[u8])]) -> TempDir {
    let dir = TempDir::new().unwrap();
    for (name, content) in files {
        let path = dir.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
    }
    dir
}

fn read(dir: &TempDir) -> SceneDescription {
    read_pbrt(&dir.path().join("main.pbrt"))
}

fn gzip(text: &str) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(text.as_bytes()).unwrap();
    encoder.finish().unwrap()
}

/// Messages without the name of the temporary folder.
fn told(scene: &SceneDescription, dir: &TempDir) -> String {
    messages(scene).replace(&format!("{}/", dir.path().display()), "")
}

#[test]
fn includes_act_on_the_state_and_imports_do_not() {
    let dir = folder(&[
        (
            "main.pbrt",
            b"WorldBegin Include \"parts/a.pbrt\" Shape \"sphere\" Import \"parts/b.pbrt\"
              Shape \"sphere\"",
        ),
        // Names are relative to the main file, or else to the file that has them.
        ("parts/a.pbrt", b"Translate 1 0 0 Include \"c.pbrt\" Include \"parts/c.pbrt\""),
        ("parts/b.pbrt", b"Translate 0 9 0 Shape \"disk\""),
        ("parts/c.pbrt", b"Translate 1 0 0"),
    ]);
    let s = read(&dir);
    assert_eq!(messages(&s), "");
    assert_eq!(s.shapes.len(), 3);
    assert_maps(&s.shapes[0].transform, [0.0; 3], [3.0, 0.0, 0.0]);
    assert_maps(&s.shapes[1].transform, [0.0; 3], [3.0, 9.0, 0.0]);
    assert_maps(&s.shapes[2].transform, [0.0; 3], [3.0, 0.0, 0.0]);
    let names: Vec<_> = s.sources.files.iter().map(|f| f.path.file_name().unwrap()).collect();
    assert_eq!(names, ["main.pbrt", "a.pbrt", "c.pbrt", "c.pbrt", "b.pbrt"]);
}

#[test]
fn gzipped_files_are_known_by_their_first_bytes() {
    let main = gzip("WorldBegin\nInclude \"part.pbrt\"\nShape \"nothing\"");
    let part = gzip("Shape \"sphere\" \"float radius\" 2.5");
    let dir = folder(&[("main.pbrt", &main), ("part.pbrt", &part)]);
    let s = read(&dir);
    assert_eq!(sphere_radius(&s.shapes[0]), 2.5);
    // Places are those of the text inside.
    assert!(messages(&s).starts_with("error 3:7 <\"nothing\"> unknown shape `nothing`"));
    let dir = folder(&[("main.pbrt", &main[..20])]);
    assert!(
        told(&read(&dir), &dir).starts_with("error - can't read `main.pbrt`: broken gzip file")
    );
}

#[test]
fn cyclic_includes_are_errors() {
    let dir = folder(&[
        ("main.pbrt", b"WorldBegin\nInclude \"a.pbrt\"\nShape \"sphere\""),
        ("a.pbrt", b"Include \"main.pbrt\""),
    ]);
    let s = read(&dir);
    assert_eq!(told(&s, &dir), "error 1:9 <\"main.pbrt\"> `main.pbrt` includes itself\n");
    assert_eq!(
        s.sources.location(s.diagnostics.entries[0].span.unwrap()).split('/').next_back(),
        Some("a.pbrt:1:9")
    );
    assert_eq!(s.shapes.len(), 1);
}

#[test]
fn missing_files_are_named_with_the_nearest() {
    let dir = folder(&[
        (
            "main.pbrt",
            b"WorldBegin
Include \"geometry/partt.pbrt\"
Shape \"plymesh\" \"string filename\" \"geometry/ball.plx\"
Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"wood.png\"
LightSource \"infinite\" \"string filename\" \"sky.exr\"
Material \"conductor\" \"spectrum eta\" \"metal-Cu-etta\" \"spectrum k\" \"my.spd\"",
        ),
        ("geometry/part.pbrt", b""),
        ("geometry/ball.ply", b"ply"),
    ]);
    let s = read(&dir);
    assert_eq!(
        told(&s, &dir),
        "error 2:9 <\"geometry/partt.pbrt\"> no file `geometry/partt.pbrt`; did you mean \
         `geometry/part.pbrt`?\n\
         error 4:53 <\"wood.png\"> no image file `wood.png`; relative names start at the folder of \
         the main scene file or of the file that names it\n\
         error 6:37 <\"metal-Cu-etta\"> no spectrum and no file is called `metal-Cu-etta`; did you \
         mean `metal-Cu-eta`?\n\
         error 6:66 <\"my.spd\"> no spectrum and no file is called `my.spd`\n\
         error 5:42 <\"sky.exr\"> no image file `sky.exr`; relative names start at the folder of \
         the main scene file or of the file that names it\n\
         error 3:35 <\"geometry/ball.plx\"> no mesh file `geometry/ball.plx`; did you mean \
         `geometry/ball.ply`?\n"
    );
}

#[test]
fn a_missing_main_file_is_an_error() {
    let s = read_pbrt(Path::new("/no/such/file.pbrt"));
    let text = messages(&s);
    assert!(text.starts_with("error - can't read `/no/such/file.pbrt`: "), "{text}");
    assert!(s.diagnostics.has_errors());
}

#[test]
fn other_encodings() {
    let dir = folder(&[("main.pbrt", b"\xff\xfeW\0")]);
    let text = told(&read(&dir), &dir);
    assert_eq!(text, "error - can't read `main.pbrt`: the file is UTF-16, expected UTF-8\n");
    let dir = folder(&[("main.pbrt", b"# gr\xfcn\nWorldBegin Shape \"sphere\"")]);
    assert_eq!(messages(&read(&dir)), "");
}

#[test]
fn spectra_from_files() {
    let dir = folder(&[
        (
            "main.pbrt",
            b"WorldBegin Material \"conductor\" \"spectrum eta\" \"spds/a.spd\"
              \"spectrum k\" [ 400 1 700 2 ] Shape \"sphere\"",
        ),
        ("spds/a.spd", b"# comment\n400 1.5\n700 0.5\n"),
    ]);
    let s = read(&dir);
    assert_eq!(messages(&s), "");
    let MaterialModel::Conductor { color, .. } = &s.materials[0].model else { panic!() };
    let kaustika_scene::description::ConductorColor::EtaK { eta, k } = color else { panic!() };
    let sampled = |values| SpectrumDesc::sampled(&[400.0, 700.0], values).unwrap();
    let node = |id: &kaustika_scene::description::TextureId| s.textures[id.0 as usize].node.clone();
    assert_eq!(node(eta), TextureNode::Spectrum(sampled(&[1.5, 0.5])));
    assert_eq!(node(k), TextureNode::Spectrum(sampled(&[1.0, 2.0])));
}

/// A PFM file of one grey value.
pub(super) fn pfm(width: usize, height: usize, value: f32) -> Vec<u8> {
    let mut bytes = format!("PF\n{width} {height}\n-1.0\n").into_bytes();
    for _ in 0..3 * width * height {
        bytes.extend(value.to_le_bytes());
    }
    bytes
}

const PLY: &[u8] = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y
property float z\nproperty float nx\nproperty float ny\nproperty float nz\nelement face 1
property list uchar int vertex_indices\nend_header
0 0 0 0 0 -1\n1 0 0 0 0 -1\n0 1 0 0 0 -1\n3 0 1 2\n";

#[test]
fn meshes_are_loaded_once_and_face_their_normals() {
    let dir = folder(&[
        (
            "main.pbrt",
            b"WorldBegin Shape \"plymesh\" \"string filename\" \"m.ply\"
              ObjectBegin \"o\" Shape \"sphere\" Shape \"plymesh\" \"string filename\" \"m.ply\" ObjectEnd
              Shape \"plymesh\" \"string filename\" \"broken.ply\"
              Shape \"plymesh\" \"string filename\" \"broken.ply\"",
        ),
        ("m.ply", PLY),
        ("broken.ply", b"ply\nnothing"),
    ]);
    let s = read(&dir);
    let mesh = |g: &GeometryDesc| match g {
        GeometryDesc::Mesh(m) => m.clone(),
        _ => panic!(),
    };
    let first = mesh(&s.shapes[0].geometry);
    assert_eq!(first.indices, [[0, 2, 1]]);
    assert!(std::sync::Arc::ptr_eq(&first, &mesh(&s.groups[0].shapes[1].geometry)));
    assert_eq!(s.shapes.len(), 1);
    let text = told(&s, &dir);
    assert!(text.starts_with("error 3:49 <\"broken.ply\"> can't read mesh "), "{text}");
    assert_eq!(text.lines().count(), 1);
}

#[test]
fn meshes_are_displaced_by_textures() {
    let mesh = "Shape \"plymesh\" \"string filename\" \"m.ply\" \"texture displacement\" \"h\"";
    let text = format!(
        "Option \"displacement-edge-scale\" 0.5\nWorldBegin
        Texture \"h\" \"float\" \"constant\" \"float value\" 2
        {mesh} \"float edgelength\" .3
        {mesh}
        {mesh} \"float edgelength\" 0"
    );
    let dir = folder(&[("main.pbrt", text.as_bytes()), ("m.ply", PLY)]);
    let s = read(&dir);
    let lengths = s.shapes.iter().map(|shape| match &shape.geometry {
        GeometryDesc::Displaced(d) => {
            assert_eq!((super::number(&s, d.height), d.mesh.indices.len()), (2.0, 1));
            d.edge_length
        }
        _ => 0.0,
    });
    assert_eq!(lengths.collect::<Vec<_>>(), [0.15, 0.5, 0.0]);
    let expected =
        "error 6:78 <\"float edgelength\"> edges of a displaced mesh must be above 0, not 0\n";
    assert_eq!(told(&s, &dir), expected);
}

/// A PNG file of one pixel.
fn png(rgb: [u8; 3]) -> Vec<u8> {
    let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |kind: &[u8; 4], data: &[u8]| {
        bytes.extend((data.len() as u32).to_be_bytes());
        let mut crc = Crc::new();
        crc.update(kind);
        crc.update(data);
        bytes.extend(kind);
        bytes.extend(data);
        bytes.extend(crc.sum().to_be_bytes());
    };
    chunk(b"IHDR", &[0, 0, 0, 1, 0, 0, 0, 1, 8, 2, 0, 0, 0]);
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(&[0, rgb[0], rgb[1], rgb[2]]).unwrap();
    chunk(b"IDAT", &encoder.finish().unwrap());
    chunk(b"IEND", &[]);
    bytes
}

#[test]
fn images_keep_the_curve_of_their_format() {
    let png = png([128, 64, 32]);
    let dir = folder(&[
        (
            "main.pbrt",
            b"WorldBegin
Texture \"a\" \"spectrum\" \"imagemap\" \"string filename\" \"i.png\"
Texture \"b\" \"spectrum\" \"imagemap\" \"string filename\" \"i.png\" \"string encoding\" \"linear\"
Texture \"c\" \"spectrum\" \"imagemap\" \"string filename\" \"i.png\" \"string encoding\" \"gamma 1.8\"
Texture \"d\" \"spectrum\" \"imagemap\" \"string filename\" \"i.pfm\" \"string encoding\" \"sRGB\"",
        ),
        ("i.png", &png),
        ("i.pfm", &pfm(1, 1, 2.0)),
    ]);
    let s = read(&dir);
    assert_eq!(messages(&s), "");
    let encodings: Vec<Encoding> = s
        .textures
        .iter()
        .map(|t| match &t.node {
            TextureNode::Bitmap(b) => b.bitmap.encoding,
            _ => panic!(),
        })
        .collect();
    let expected = [Encoding::Srgb, Encoding::Linear, Encoding::Gamma(1.8), Encoding::Linear];
    assert_eq!(encodings, expected);
}
