//! Broken scenes and the messages about them: place, wording and advice.

use super::*;

/// The messages about the lines after `<scene version="3.0.0">` and a camera, which is line 1.
fn faults(inner: &str) -> Vec<String> {
    read("3.0.0", inner).1
}

/// The messages about a whole file.
fn file_faults(text: &str) -> Vec<String> {
    let files = Files::new(&[("scene.xml", text)]);
    files.messages(&files.read("scene.xml", &[]))
}

/// Each text has exactly the one message beside it.
fn all_are(cases: &[(&str, &str)], messages: impl Fn(&str) -> Vec<String>) {
    let wrong: Vec<String> = cases
        .iter()
        .map(|(text, expected)| (text, expected, messages(text)))
        .filter(|(_, expected, found)| found[..] != [expected.to_string()])
        .map(|(text, expected, found)| format!("{text}\n  expected {expected}\n  found {found:?}"))
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn files_that_are_no_scenes() {
    all_are(
        &[
            (
                "<scene version=\"3.0.0\">\n  <shape>\n</scene>",
                "error 3:1 malformed XML: expected 'shape' tag, not 'scene' | `<shape>` is still open here: \
             add `</shape>`",
            ),
            ("", "error 1:1 malformed XML: the file is empty"),
            (
                "<scene>\n</scene>",
                "error 1:1 missing attribute `version` in `<scene>` | the version decides how the \
             file is read: add `version=\"3.0.0\"`",
            ),
            (
                "<scene version=\"three\"/>",
                "error 1:17 expected a version number, found `three` | versions look like `3.0.0` or \
             `0.6.0`",
            ),
            (
                "<shape type=\"cube\" version=\"3.0.0\"/>",
                "error 1:1 expected `<scene>`, found `<shape>`",
            ),
        ],
        file_faults,
    );
    let missing = read_mitsuba(std::path::Path::new("/no/such/scene.xml"), &[]);
    assert!(missing.diagnostics.has_errors());
    assert!(missing.diagnostics.entries[0].message.starts_with("can't read `/no/such/scene.xml`"));
}

#[test]
fn elements_and_attributes() {
    all_are(
        &[
            ("<shap type=\"cube\"/>", "error 2:1 unknown element `<shap>` | did you mean `shape`?"),
            ("<shape/>", "error 2:1 missing attribute `type` in `<shape>`"),
            (
                "<shape type=\"cube\" colour=\"red\"/>",
                "warning 2:20 `<shape>` has no attribute `colour` | known: type, id, name",
            ),
            (
                "<shape type=\"sphere\">\n <float name=\"radius\" value=\"wide\"/></shape>",
                "error 3:30 expected a number, found `wide`",
            ),
            (
                "<integrator type=\"path\"><integer name=\"max_depth\" value=\"2.5\"/></integrator>",
                "error 2:58 expected an integer, found `2.5`",
            ),
            (
                "<shape type=\"cube\"><boolean name=\"flip_normals\" value=\"yes\"/></shape>",
                "error 2:56 expected `true` or `false`, found `yes`",
            ),
            (
                "<shape type=\"sphere\"><point name=\"center\" x=\"1\" y=\"2\"/></shape>",
                "error 2:22 missing attribute `z`",
            ),
            (
                "<emitter type=\"point\"><rgb name=\"intensity\" value=\"1, 2\"/></emitter>",
                "error 2:52 expected one or three numbers, found 2",
            ),
            (
                "<emitter type=\"point\"><spectrum name=\"intensity\" value=\"500:1, 400:2\"/></emitter>",
                "error 2:57 wavelength of sample 1 is not greater than the one before",
            ),
            (
                "<emitter type=\"point\"><spectrum name=\"intensity\"/></emitter>",
                "error 2:23 a spectrum needs either `value` or `filename`",
            ),
            (
                "<translate x=\"1\"/>",
                "error 2:1 `<translate>` can only stand inside a `<transform>`",
            ),
        ],
        faults,
    );
}

#[test]
fn transforms() {
    let of = |steps: &str| {
        faults(&format!(
            "<shape type=\"cube\"><transform name=\"to_world\">\n{steps}</transform></shape>"
        ))
    };
    all_are(
        &[
            ("<rotate angle=\"90\"/>", "error 3:1 the rotation axis is zero"),
            ("<rotate x=\"1\"/>", "error 3:1 missing attribute `angle` in `<rotate>`"),
            ("<matrix value=\"1 2 3\"/>", "error 3:16 expected 16 or 9 numbers, found 3"),
            (
                "<lookat origin=\"0,0,0\" target=\"0,1,0\" up=\"0,1,0\"/>",
                "error 3:1 `origin`, `target` and `up` do not span a frame: `target` must differ from \
             `origin`, and `up` from the direction between them",
            ),
            (
                "<scale value=\"2\" x=\"1\"/>",
                "error 3:1 `value` and `x`, `y`, `z` exclude each other",
            ),
            (
                "<rotat x=\"1\"/>",
                "error 3:1 unknown element `<rotat>` in a transform | did you mean `rotate`?",
            ),
            (
                "<scale x=\"0\"/>",
                "error 2:20 the transform `to_world` has no inverse | no axis may be scaled by zero",
            ),
        ],
        of,
    );
}

#[test]
fn names() {
    all_are(
        &[
            (
                "<shape type=\"spere\"/>",
                "error 2:14 unknown shape `spere` | did you mean `sphere`?",
            ),
            (
                "<shape type=\"cube\"><bsdf type=\"difuse\"/></shape>",
                "error 2:32 unknown bsdf `difuse` | did you mean `diffuse`?",
            ),
            (
                "<emitter type=\"pointlight\"/>",
                "error 2:16 unknown emitter `pointlight` | known: area, point, spot, directional, \
             constant, envmap, projector, sunsky, sun, sky, timed_sunsky, collimated, \
             directionalarea",
            ),
            (
                "<integrator type=\"pathh\"/>",
                "warning 2:19 unknown integrator `pathh` | did you mean `path`?",
            ),
            (
                "<shape type=\"cube\"><ref id=\"wal\"/></shape><bsdf type=\"diffuse\" id=\"wall\"/>",
                "error 2:29 no object has the id `wal` | did you mean `wall`?",
            ),
            (
                "<bsdf type=\"diffuse\" id=\"a\"/>\n<bsdf type=\"plastic\" id=\"a\"/>",
                "error 3:26 the id `a` is given twice | previously defined at scene.xml:2:26",
            ),
            ("<alias id=\"a\" as=\"b\"/>", "error 2:12 no object with the id `a` stands above"),
            (
                "<shape type=\"sphere\"><float name=\"radus\" value=\"2\"/></shape>",
                "warning 2:22 unknown parameter `radus` of shape `sphere` | did you mean `radius`?",
            ),
            (
                "<bsdf type=\"roughdielectric\"><string name=\"int_ior\" value=\"watr\"/></bsdf>",
                "error 2:60 no index of refraction for `watr` | did you mean `water`?",
            ),
            (
                "<bsdf type=\"conductor\"><string name=\"material\" value=\"Alu\"/></bsdf>",
                "error 2:55 unknown metal `Alu` | did you mean `Al`?",
            ),
            (
                "<bsdf type=\"roughplastic\"><string name=\"distribution\" value=\"gxx\"/></bsdf>",
                "error 2:62 `distribution` can't be `gxx` | did you mean `ggx`?",
            ),
        ],
        faults,
    );
}

#[test]
fn values_of_the_wrong_kind() {
    all_are(
        &[
            (
                "<shape type=\"sphere\"><string name=\"radius\" value=\"2\"/></shape>",
                "error 2:22 `radius` of shape `sphere` must be a number, found a string",
            ),
            (
                "<bsdf type=\"diffuse\"><boolean name=\"reflectance\" value=\"true\"/></bsdf>",
                "error 2:22 `reflectance` of bsdf `diffuse` must be a number, colour, spectrum or \
             texture, found a boolean",
            ),
            (
                "<bsdf type=\"diffuse\"><bsdf type=\"null\" name=\"reflectance\"/></bsdf>",
                "error 2:22 `reflectance` of bsdf `diffuse` must be a number, colour, spectrum or \
             texture, found a bsdf",
            ),
            (
                "<emitter type=\"point\"><texture type=\"checkerboard\" name=\"intensity\"/></emitter>",
                "error 2:23 `intensity` of emitter `point` can't vary",
            ),
            (
                "<shape type=\"sphere\"><float name=\"radius\" value=\"-1\"/></shape>",
                "error 2:50 `radius` must be positive",
            ),
            (
                "<bsdf type=\"twosided\"><bsdf type=\"dielectric\"/></bsdf>",
                "error 2:1 bsdf `twosided` can't hold a material that transmits | use the inner \
             material as it is",
            ),
            ("<bsdf type=\"mask\"/>", "error 2:1 bsdf `mask` needs 1 bsdf inside, found 0"),
            (
                "<bsdf type=\"roughconductor\"><float name=\"alpha_u\" value=\"0.1\"/></bsdf>",
                "error 2:1 `alpha_u` and `alpha_v` belong together",
            ),
            (
                "<shape type=\"cube\"><bsdf type=\"diffuse\"/><bsdf type=\"plastic\"/></shape>",
                "error 2:42 shape `cube` takes one bsdf only",
            ),
            (
                "<shape type=\"cube\"><film type=\"hdrfilm\"/></shape>",
                "warning 2:20 shape `cube` has no use for this film",
            ),
            ("<shape type=\"instance\"/>", "error 2:1 an instance needs a `shapegroup`"),
            (
                "<shape type=\"obj\"><string name=\"filename\" value=\"no.obj\"/></shape>",
                "error 2:50 can't find the file `no.obj` | relative names start at the folder of the \
             scene file or at that of a `<path>` element",
            ),
            ("<shape type=\"ply\"/>", "error 2:1 shape `ply` needs `filename`"),
        ],
        faults,
    );
}

#[test]
fn circles() {
    assert_eq!(
        faults("<bsdf type=\"mask\" id=\"a\"><ref id=\"a\"/></bsdf>"),
        ["error 2:1 bsdf `a` refers to itself"]
    );
    let text = "<scene version=\"3.0.0\">\n<include filename=\"b.xml\"/></scene>";
    let other = "<scene version=\"3.0.0\"><include filename=\"a.xml\"/></scene>";
    let files = Files::new(&[("a.xml", text), ("b.xml", other)]);
    let d = files.read("a.xml", &[]);
    assert_eq!(
        files.messages(&d),
        ["error 1:43 `a.xml` includes itself | a file that is being read"]
    );
    let span = d.diagnostics.entries[0].span.expect("it has a place");
    assert!(d.sources.location(span).ends_with("b.xml:1:43"));
}

#[test]
fn parameters() {
    let text = "<scene version=\"3.0.0\">\n<default name=\"depth\" value=\"3\"/>\n\
        <integrator type=\"path\"><integer name=\"max_depth\" value=\"$dept\"/></integrator>\n\
        <sensor type=\"perspective\"/></scene>";
    let files = Files::new(&[("a.xml", text)]);
    let d = files.read("a.xml", &[("depht", "4")]);
    assert_eq!(
        files.messages(&d),
        [
            "error 3:58 undefined parameter `$dept` | did you mean `$depth`?",
            "warning - the parameter `depht` is defined but never used | known: depth",
        ]
    );
}

#[test]
fn files_that_cannot_be_read() {
    let text = "<scene version=\"3.0.0\"><sensor type=\"perspective\"/>\n\
        <shape type=\"obj\"><string name=\"filename\" value=\"bad.obj\"/></shape>\n\
        <emitter type=\"envmap\"><string name=\"filename\" value=\"bad.png\"/></emitter></scene>";
    let files =
        Files::new(&[("a.xml", text), ("bad.obj", "v 0 0\nf 1 2 3\n"), ("bad.png", "not a png")]);
    let d = files.read("a.xml", &[]);
    let places: Vec<_> = d
        .diagnostics
        .entries
        .iter()
        .map(|m| (m.severity, d.sources.line_column(m.span.expect("a place"))))
        .collect();
    assert_eq!(places, [(Severity::Error, (2, 50)), (Severity::Error, (3, 55))]);
}

#[test]
fn several_faults_in_one_run() {
    let messages = faults(
        "<shape type=\"sphere\"><float name=\"radius\" value=\"x\"/></shape>\n\
         <shape type=\"tube\"/>\n<ref id=\"gone\"/>\n<bsdf type=\"diffuse\"><rgb value=\"1\"/></bsdf>",
    );
    assert_eq!(
        messages,
        [
            "error 2:50 expected a number, found `x`",
            "error 5:22 missing attribute `name` in `<rgb>`",
            "error 4:10 no object has the id `gone`",
            "error 3:14 unknown shape `tube` | did you mean `cube`?",
        ]
    );
}

/// Names of 0.6 are shown as 0.6 spells them.
#[test]
fn spelling_of_mitsuba_06() {
    let (_, messages) =
        read("0.6.0", "<bsdf type=\"dielectric\"><float name=\"intIOT\" value=\"1.5\"/></bsdf>");
    assert_eq!(
        messages,
        ["warning 2:25 unknown parameter `intIOT` of bsdf `dielectric` | did you mean `intIOR`?"]
    );
}

/// Deep nesting and every cut of a good file are refused or read, without panic.
#[test]
fn nothing_panics() {
    let deep = "<bsdf type=\"mask\">".repeat(5000);
    let messages = faults(&format!("{deep}{}", "</bsdf>".repeat(5000)));
    assert!(messages.iter().any(|m| m.contains("elements nest deeper than 100")));
    let good = "<scene version=\"0.6.0\"><default name=\"a\" value=\"é\"/><bsdf type=\"phong\" \
        id=\"$a\"><srgb name=\"diffuseReflectance\" value=\"#102030\"/></bsdf><shape type=\"cube\">\
        <ref id=\"é\"/><transform name=\"toWorld\"><rotate x=\"1\" angle=\"3\"/></transform></shape>\
        </scene>";
    for (cut, _) in good.char_indices() {
        assert!(!file_faults(&good[..cut]).is_empty(), "{cut}");
    }
    assert_eq!(
        file_faults(good),
        ["warning 1:1 the scene has no camera | add `<sensor type=\"perspective\">`"]
    );
}
