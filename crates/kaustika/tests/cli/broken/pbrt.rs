//! Broken scenes of pbrt-v4 and pbrt-v3.

use super::case::Case;

/// A world with something in it and light on it, for what is wrong elsewhere.
const BALL: &str = "LightSource \"infinite\"\nShape \"sphere\"";

pub fn cases() -> Vec<Case> {
    [files(), language(), values(), names(), shapes(), cameras()].into_iter().flatten().collect()
}

/// Not yet about what the scene says.
fn files() -> Vec<Case> {
    vec![
        Case::new("pbrt-missing-file", "render gone.pbrt -o a.exr"),
        Case::new("pbrt-missing-file-absolute", "render <dir>/gone.pbrt -o a.exr"),
        Case::pbrt_file("pbrt-empty-file", ""),
        Case::pbrt_file("pbrt-binary", (0..=255).rev().cycle().take(3000).collect::<Vec<u8>>()),
        Case::pbrt_file("pbrt-zeros", [0; 300]),
        Case::pbrt_file(
            "pbrt-utf16",
            "Camera".encode_utf16().fold(vec![255, 254], |mut v, c| {
                v.extend(c.to_le_bytes());
                v
            }),
        ),
        Case::new("pbrt-gz-is-no-gz", "render s.pbrt.gz -o a.exr")
            .file("s.pbrt.gz", "\u{1f}not gzip"),
        Case::new("pbrt-gz-cut", "render s.pbrt.gz -o a.exr")
            .file("s.pbrt.gz", [0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 3, 75]),
        Case::new("pbrt-is-a-folder", "render s.pbrt -o a.exr")
            .prepared(|p| std::fs::create_dir(p.path("s.pbrt")).unwrap()),
        Case::pbrt("pbrt-missing-include", "Include \"geometry.pbrt\""),
        Case::pbrt("pbrt-missing-import", "Import \"geometry.pbrt\""),
        Case::pbrt("pbrt-includes-itself", "Include \"s.pbrt\""),
        Case::pbrt("pbrt-includes-in-a-circle", "Include \"b.pbrt\"")
            .file("b.pbrt", "# the way back\n\nInclude \"s.pbrt\"\n"),
        Case::pbrt("pbrt-error-in-an-include", "Include \"b.pbrt\"").file(
            "b.pbrt",
            "AttributeBegin\n  Shape \"sphere\" \"float radius\" [ 1 2 ]\nAttributeEnd\n",
        ),
    ]
}

/// Words and their order.
fn language() -> Vec<Case> {
    vec![
        Case::pbrt("pbrt-unclosed-string", "Shape \"sphere\nShape \"disk\""),
        Case::pbrt(
            "pbrt-unclosed-bracket",
            "Shape \"sphere\" \"float radius\" [ 1\nShape \"disk\"",
        ),
        Case::pbrt("pbrt-unclosed-bracket-at-the-end", "Shape \"sphere\" \"float radius\" [ 1"),
        Case::pbrt("pbrt-unknown-directive", "Translat 1 2 3"),
        Case::pbrt("pbrt-attribute-end-alone", "AttributeEnd"),
        Case::pbrt("pbrt-attribute-never-closed", "AttributeBegin\nShape \"sphere\""),
        Case::pbrt_file("pbrt-no-world-begin", "Camera \"perspective\"\nShape \"sphere\"\n"),
        Case::pbrt("pbrt-two-worlds", "WorldBegin"),
        Case::pbrt("pbrt-late-camera", "Camera \"perspective\""),
        Case::pbrt("pbrt-many-errors", &"Shape \"sphere\" \"float radius\" [ 1 2 ]\n".repeat(60)),
    ]
}

/// Numbers and types.
fn values() -> Vec<Case> {
    let camera =
        |name, camera: &str| Case::pbrt_file(name, format!("{camera}\nWorldBegin\n{BALL}\n"));
    vec![
        camera("pbrt-string-fov", "Camera \"perspective\" \"string fov\" \"45\""),
        camera("pbrt-fov-of-words", "Camera \"perspective\" \"float fov\" \"wide\""),
        camera("pbrt-look-along-up", "LookAt 0 5 0  0 0 0  0 1 0\nCamera \"perspective\""),
        camera("pbrt-look-at-eye", "LookAt 1 2 3  1 2 3  0 1 0\nCamera \"perspective\""),
        Case::pbrt("pbrt-nan-transform", "Translate 0 nan 0\nShape \"sphere\""),
        Case::pbrt("pbrt-infinite-transform", "Translate 0 1e39 0\nShape \"sphere\""),
        Case::pbrt("pbrt-scale-by-zero", "Scale 1 0 1\nShape \"sphere\""),
        Case::pbrt("pbrt-singular-matrix", "Transform [ 1 0 0 0  1 0 0 0  0 0 1 0  0 0 0 1 ]"),
        Case::pbrt("pbrt-short-matrix", "Transform [ 1 0 0 0 ]"),
        Case::pbrt("pbrt-negative-colour", "LightSource \"point\" \"rgb I\" [ 1 -1 1 ]"),
        Case::pbrt("pbrt-two-of-three-numbers", "LightSource \"point\" \"rgb I\" [ 1 1 ]"),
        Case::pbrt("pbrt-cold-black-body", "LightSource \"point\" \"blackbody I\" -5"),
    ]
}

/// Kinds, and things called by name.
fn names() -> Vec<Case> {
    vec![
        Case::pbrt("pbrt-unknown-shape", "Shape \"spere\""),
        Case::pbrt("pbrt-unknown-material", "Material \"dielectirc\"\nShape \"sphere\""),
        Case::pbrt("pbrt-unknown-light", "LightSource \"infinit\""),
        Case::pbrt("pbrt-unknown-texture", "Texture \"t\" \"spectrum\" \"imgemap\""),
        Case::pbrt(
            "pbrt-unknown-shape-that-shines",
            "AreaLightSource \"diffuse\"\nShape \"pyramid\"",
        ),
        Case::pbrt(
            "pbrt-undefined-named-material",
            "MakeNamedMaterial \"gold\" \"string type\" \"conductor\"\nNamedMaterial \"glod\"\nShape \"sphere\"",
        ),
        Case::pbrt(
            "pbrt-named-material-of-no-type",
            "MakeNamedMaterial \"gold\"\nNamedMaterial \"gold\"\nShape \"sphere\"",
        ),
        Case::pbrt(
            "pbrt-undefined-texture",
            "Material \"diffuse\" \"texture reflectance\" \"wood\"\nShape \"sphere\"",
        ),
        Case::pbrt("pbrt-undefined-object", "ObjectInstance \"tree\""),
        Case::pbrt("pbrt-undefined-medium", "MediumInterface \"fog\" \"\"\nShape \"sphere\""),
        Case::pbrt(
            "pbrt-material-twice",
            "MakeNamedMaterial \"a\" \"string type\" \"diffuse\"\nMakeNamedMaterial \"a\" \"string type\" \"conductor\"",
        ),
        Case::pbrt(
            "pbrt-texture-of-itself",
            "Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"t\"\nMaterial \"diffuse\" \"texture reflectance\" \"t\"\nShape \"sphere\"",
        ),
        Case::pbrt(
            "pbrt-textures-in-a-circle",
            "Texture \"a\" \"float\" \"mix\" \"texture tex1\" \"b\"\nTexture \"b\" \"float\" \"mix\" \"texture tex1\" \"a\"",
        ),
        Case::pbrt(
            "pbrt-mix-of-itself",
            "MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [ \"m\" \"n\" ]\nMakeNamedMaterial \"n\" \"string type\" \"diffuse\"\nNamedMaterial \"m\"\nShape \"sphere\"",
        ),
        Case::pbrt(
            "pbrt-mixes-in-a-circle",
            "MakeNamedMaterial \"a\" \"string type\" \"diffuse\"\nMakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [ \"n\" \"a\" ]\nMakeNamedMaterial \"n\" \"string type\" \"mix\" \"string materials\" [ \"a\" \"m\" ]",
        ),
        Case::pbrt("pbrt-unknown-parameter", &format!("{BALL} \"float radios\" 2")).accepted(),
    ]
}

fn shapes() -> Vec<Case> {
    vec![
        Case::pbrt("pbrt-negative-radius", "Shape \"sphere\" \"float radius\" -1"),
        Case::pbrt("pbrt-nan-radius", "Shape \"sphere\" \"float radius\" nan"),
        Case::pbrt("pbrt-mesh-without-points", "Shape \"trianglemesh\" \"integer indices\" [ 0 1 2 ]"),
        Case::pbrt("pbrt-mesh-index-out-of-range", "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ]\n  \"integer indices\" [ 0 1 3 ]"),
        Case::pbrt("pbrt-mesh-negative-index", "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ]\n  \"integer indices\" [ 0 1 -1 ]"),
        Case::pbrt("pbrt-mesh-index-left-over", "LightSource \"infinite\"\nShape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ]\n  \"integer indices\" [ 0 1 2 0 ]").accepted(),
        Case::pbrt("pbrt-mesh-number-left-over", "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 ]"),
        Case::pbrt("pbrt-mesh-nan-point", "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 nan 0 ]"),
        Case::pbrt("pbrt-missing-mesh", "Shape \"plymesh\" \"string filename\" \"gone.ply\""),
        Case::pbrt("pbrt-mesh-file-not-named", "Shape \"plymesh\""),
    ]
}

fn cameras() -> Vec<Case> {
    let film = |name, film: &str| {
        Case::pbrt_file(
            name,
            format!("Camera \"perspective\"\nFilm \"rgb\" {film}\nWorldBegin\n{BALL}\n"),
        )
    };
    vec![
        Case::pbrt_file("pbrt-no-camera", format!("WorldBegin\n{BALL}\n"))
            .args("render s.pbrt --resolution 8x6 --spp 1 -o a.exr")
            .accepted(),
        film("pbrt-no-pixels", "\"integer xresolution\" 0 \"integer yresolution\" 0"),
        film("pbrt-negative-resolution", "\"integer xresolution\" -8"),
        film(
            "pbrt-absurd-resolution",
            "\"integer xresolution\" 1000000 \"integer yresolution\" 1000000",
        ),
        film("pbrt-crop-outside", "\"float cropwindow\" [ 2 3 2 3 ]"),
        film("pbrt-pixel-bounds-outside", "\"integer pixelbounds\" [ 5000 5010 0 10 ]"),
        film(
            "pbrt-unknown-filter",
            "\"integer xresolution\" 8 \"integer yresolution\" 6\nPixelFilter \"gausian\"",
        ),
        film(
            "pbrt-unknown-sampler",
            "\"integer xresolution\" 8 \"integer yresolution\" 6\nSampler \"haltn\"",
        ).accepted(),
        film(
            "pbrt-no-samples",
            "\"integer xresolution\" 8 \"integer yresolution\" 6\nSampler \"halton\" \"integer pixelsamples\" 0",
        ).accepted(),
        film(
            "pbrt-filter-of-no-width",
            "\"integer xresolution\" 8 \"integer yresolution\" 6\nPixelFilter \"box\" \"float xradius\" 0",
        ),
    ]
}
