//! Broken scenes of Mitsuba 3 and 0.6.

use super::case::Case;

pub fn cases() -> Vec<Case> {
    [files(), language(), values(), names(), cameras()].into_iter().flatten().collect()
}

/// Not yet about what the scene says.
fn files() -> Vec<Case> {
    vec![
        Case::new("xml-missing-file", "render gone.xml -o a.exr"),
        Case::xml_file("xml-empty-file", ""),
        Case::xml_file("xml-binary", (0..=255).rev().cycle().take(3000).collect::<Vec<u8>>()),
        Case::new("xml-is-a-folder", "render s.xml -o a.exr")
            .prepared(|p| std::fs::create_dir(p.path("s.xml")).unwrap()),
        Case::xml_file(
            "xml-unclosed-tag",
            "<scene version=\"3.0.0\">\n  <shape type=\"sphere\">\n</scene>\n",
        ),
        Case::xml_file("xml-cut-short", "<scene version=\"3.0.0\">\n  <shape type=\"sph"),
        Case::xml_file("xml-wrong-root", "<world version=\"3.0.0\">\n</world>\n"),
        Case::xml_file("xml-no-version", "<scene>\n</scene>\n"),
        Case::xml_file("xml-future-version", "<scene version=\"99.0.0\">\n</scene>\n"),
        Case::mitsuba("xml-missing-include", "<include filename=\"parts.xml\"/>"),
        Case::mitsuba("xml-includes-itself", "<include filename=\"s.xml\"/>"),
        Case::mitsuba("xml-includes-in-a-circle", "<include filename=\"b.xml\"/>")
            .file("b.xml", "<scene version=\"3.0.0\">\n<include filename=\"s.xml\"/>\n</scene>\n"),
        Case::mitsuba("xml-error-in-an-include", "<include filename=\"b.xml\"/>")
            .file("b.xml", "<scene version=\"3.0.0\">\n<shape type=\"spere\"/>\n</scene>\n"),
    ]
}

fn language() -> Vec<Case> {
    vec![
        Case::mitsuba("xml-unknown-element", "<shap type=\"sphere\"/>"),
        Case::mitsuba("xml-no-type", "<shape/>"),
        Case::mitsuba("xml-no-name", "<shape type=\"sphere\"><float value=\"2\"/></shape>"),
        Case::mitsuba(
            "xml-unresolved-parameter",
            "<integrator type=\"path\">\n  <integer name=\"max_depth\" value=\"$depth\"/>\n</integrator>",
        ),
        Case::mitsuba(
            "xml-parameter-near-miss",
            "<default name=\"depth\" value=\"3\"/>\n<integrator type=\"path\">\n  <integer name=\"max_depth\" value=\"$depht\"/>\n</integrator>",
        ),
        Case::mitsuba(
            "xml-step-outside-a-transform",
            "<shape type=\"sphere\"><translate x=\"1\"/></shape>",
        ),
        Case::mitsuba(
            "xml-nested-too-deep",
            &format!("{}{}", "<bsdf type=\"mask\">".repeat(2000), "</bsdf>".repeat(2000)),
        ),
    ]
}

fn values() -> Vec<Case> {
    let placed = |name, step: &str| {
        Case::mitsuba(
            name,
            &format!(
                "<shape type=\"sphere\">\n  <transform name=\"to_world\">\n    {step}\n  </transform>\n</shape>"
            ),
        )
    };
    let sphere = |name, radius: &str| {
        Case::mitsuba(name, &format!("<shape type=\"sphere\">\n  {radius}\n</shape>"))
    };
    vec![
        sphere("xml-float-of-letters", "<float name=\"radius\" value=\"abc\"/>"),
        sphere("xml-float-nan", "<float name=\"radius\" value=\"nan\"/>"),
        sphere("xml-negative-radius", "<float name=\"radius\" value=\"-1\"/>"),
        sphere("xml-radius-of-a-string", "<string name=\"radius\" value=\"1\"/>"),
        sphere("xml-radius-of-a-bsdf", "<bsdf type=\"diffuse\" name=\"radius\"/>"),
        placed("xml-scale-by-zero", "<scale value=\"0\"/>"),
        placed("xml-nan-transform", "<translate x=\"nan\"/>"),
        placed("xml-nan-matrix", "<matrix value=\"1 0 0 0 0 1 0 0 0 0 nan 0 0 0 0 1\"/>"),
        placed("xml-short-matrix", "<matrix value=\"1 0 0\"/>"),
        placed("xml-rotation-about-nothing", "<rotate angle=\"90\"/>"),
        placed("xml-look-along-up", "<lookat origin=\"0,0,0\" target=\"0,4,0\" up=\"0,1,0\"/>"),
        Case::mitsuba(
            "xml-colour-of-two-numbers",
            "<emitter type=\"point\"><rgb name=\"intensity\" value=\"1, 2\"/></emitter>",
        ),
        Case::mitsuba(
            "xml-colour-of-bad-hex",
            "<emitter type=\"point\"><rgb name=\"intensity\" value=\"#12345\"/></emitter>",
        ),
        Case::mitsuba_06(
            "xml06-boolean-of-letters",
            "<shape type=\"cube\"><boolean name=\"flipNormals\" value=\"maybe\"/></shape>",
        ),
        Case::mitsuba_06(
            "xml06-spectrum-out-of-order",
            "<emitter type=\"point\"><spectrum name=\"intensity\" value=\"500:1, 400:2\"/></emitter>",
        ),
        Case::mitsuba_06(
            "xml06-scale-by-zero",
            "<shape type=\"cube\"><transform name=\"toWorld\"><scale x=\"1\" y=\"1\" z=\"0\"/></transform></shape>",
        ),
    ]
}

/// Kinds, and things called by id.
fn names() -> Vec<Case> {
    vec![
        Case::mitsuba("xml-unknown-shape", "<shape type=\"spere\"/>"),
        Case::mitsuba("xml-unknown-bsdf", "<shape type=\"cube\">\n  <bsdf type=\"roughconducter\"/>\n</shape>"),
        Case::mitsuba("xml-unknown-emitter", "<emitter type=\"envmp\"/>"),
        Case::mitsuba("xml-unknown-texture", "<bsdf type=\"diffuse\">\n  <texture name=\"reflectance\" type=\"bitmp\"/>\n</bsdf>"),
        Case::mitsuba("xml-unknown-sensor", "<sensor type=\"perspectiv\"/>"),
        Case::mitsuba("xml-unknown-metal", "<bsdf type=\"conductor\"><string name=\"material\" value=\"Agg\"/></bsdf>"),
        Case::mitsuba("xml-undefined-id", "<bsdf type=\"diffuse\" id=\"wall\"/>\n<shape type=\"cube\"><ref id=\"wal\"/></shape>"),
        Case::mitsuba("xml-id-twice", "<bsdf type=\"diffuse\" id=\"wall\"/>\n<bsdf type=\"conductor\" id=\"wall\"/>"),
        Case::mitsuba("xml-bsdf-of-itself", "<bsdf type=\"mask\" id=\"a\"><ref id=\"a\"/></bsdf>"),
        Case::mitsuba("xml-bsdfs-in-a-circle", "<bsdf type=\"blendbsdf\" id=\"a\"><float name=\"weight\" value=\"0.5\"/><ref id=\"b\"/><bsdf type=\"diffuse\"/></bsdf>\n<bsdf type=\"blendbsdf\" id=\"b\"><float name=\"weight\" value=\"0.5\"/><ref id=\"a\"/><bsdf type=\"diffuse\"/></bsdf>"),
        Case::mitsuba("xml-emitter-on-unknown-shape", "<shape type=\"pyramid\">\n  <emitter type=\"area\"/>\n</shape>"),
        Case::mitsuba("xml-area-light-without-a-shape", "<emitter type=\"area\"/>").args("render s.xml --spp 1 -o a.exr").accepted(),
        Case::mitsuba("xml-missing-mesh", "<shape type=\"obj\">\n  <string name=\"filename\" value=\"gone.obj\"/>\n</shape>"),
        Case::mitsuba("xml-mesh-file-not-named", "<shape type=\"ply\"/>"),
        Case::mitsuba_06("xml06-unknown-bsdf", "<shape type=\"cube\"><bsdf type=\"roughplstic\"/></shape>"),
        Case::mitsuba_06("xml06-unknown-emitter", "<emitter type=\"sunskyy\"/>"),
        Case::mitsuba_06("xml06-undefined-id", "<shape type=\"cube\"><ref id=\"wall\"/></shape>"),
        Case::mitsuba("xml-unknown-parameter", "<emitter type=\"constant\"/>\n<shape type=\"sphere\"><float name=\"radios\" value=\"2\"/></shape>").args("render s.xml --spp 1 -o a.exr").accepted(),
    ]
}

fn cameras() -> Vec<Case> {
    let film = |name, size: [i64; 2], more: &str| {
        let [w, h] = size;
        Case::xml_file(
            name,
            format!(
                "<scene version=\"3.0.0\">\n<sensor type=\"perspective\"><film type=\"hdrfilm\">\n\
             <integer name=\"width\" value=\"{w}\"/>\n<integer name=\"height\" value=\"{h}\"/>\n{more}\n\
             </film></sensor>\n<emitter type=\"constant\"/>\n</scene>\n"
            ),
        )
    };
    vec![
        Case::xml_file(
            "xml-no-camera",
            "<scene version=\"3.0.0\">\n<emitter type=\"constant\"/>\n</scene>\n",
        ),
        film("xml-no-pixels", [0, 0], ""),
        film("xml-negative-resolution", [-8, 6], ""),
        film("xml-absurd-resolution", [1_000_000, 1_000_000], ""),
        film(
            "xml-crop-outside",
            [8, 6],
            "<integer name=\"crop_offset_x\" value=\"20\"/><integer name=\"crop_offset_y\" value=\"0\"/><integer name=\"crop_width\" value=\"4\"/><integer name=\"crop_height\" value=\"4\"/>",
        ),
        film("xml-unknown-filter", [8, 6], "<rfilter type=\"gausian\"/>"),
        Case::xml_file(
            "xml-wide-fov",
            "<scene version=\"3.0.0\">\n<sensor type=\"perspective\"><float name=\"fov\" value=\"180\"/></sensor>\n<emitter type=\"constant\"/>\n</scene>\n",
        ),
        Case::xml_file(
            "xml-look-along-up-of-a-camera",
            "<scene version=\"3.0.0\">\n<sensor type=\"perspective\">\n<transform name=\"to_world\"><lookat origin=\"0,0,0\" target=\"0,4,0\" up=\"0,1,0\"/></transform>\n</sensor>\n</scene>\n",
        ),
    ]
}
