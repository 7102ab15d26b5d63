//! Small scenes of our own beside pictures of them by Mitsuba 3.9.1; how those were made is told in
//! `tests/references/README.md`.

use crate::kit::Place;
use serde_json::Value;
use std::path::Path;

/// Samples of each pixel, ours and the reference's.
const SPP: u32 = 2048;
const REF_SPP: u32 = 65_536;

/// Scene, variant, and what asks for the variant.
const CASES: [(&str, &str, &str); 6] = [
    ("surfaces", "rgb", "--rgb"),
    ("surfaces", "spectral", "--spectral"),
    ("surfaces", "spectral_polarized", "--spectral -p polarized=true"),
    ("fog", "rgb", "--rgb"),
    ("fog", "spectral", "--spectral"),
    ("sky", "rgb", "--rgb"),
];

/// Whether a render passes the tests per pixel, of tiles, and of the mean, each at 1 % for itself
/// (stricter than 1 % for all of them); and what `compare` wrote.
fn accepts((scene, variant, args): (&str, &str, &str)) -> ([bool; 3], String) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/references");
    let place = Place::new();
    for name in [format!("{scene}.xml"), "sky.exr".into()] {
        std::fs::copy(folder.join(&name), place.path(&name)).unwrap();
    }
    for (end, name) in [("", "reference.exr"), ("_var", "variance.exr")] {
        std::fs::copy(folder.join(format!("{scene}_{variant}{end}.exr")), place.path(name))
            .unwrap();
    }
    place.ok(&format!("render {scene}.xml -q -o a.exr --sampler independent --spp {SPP} {args}"));
    let text = place.ok(&format!(
        "compare a.exr reference.exr --variance variance.exr --space rgb --spp {SPP} \
         --ref-spp {REF_SPP} --tile 8 --json"
    ));
    let report: Value = serde_json::from_str(&text).unwrap();
    let outcome = ["pixels", "tiles", "mean"].map(|test| report[test]["accept"].as_bool().unwrap());
    (outcome, text)
}

#[test]
fn pictures_are_those_of_another_renderer() {
    for case in CASES {
        let (outcome, text) = accepts(case);
        assert_eq!(outcome, [true; 3], "{case:?}: {text}");
    }
}

/// What a test can't find it does not hold: a lamp 1 % redder, a metal of roughness 0.28 in place
/// of 0.25, fog 3 % denser, a sky turned by 1°, polarization left out. Each with the tests (per
/// pixel, tiles, mean) that must find it.
#[test]
fn small_faults_are_found() {
    for (case, by) in [
        (("surfaces", "rgb", "--rgb -D lamp=3.03"), [false, false, true]),
        (("surfaces", "rgb", "--rgb -D metal=0.28"), [true, true, false]),
        (("fog", "rgb", "--rgb -D density=1.55"), [false, false, true]),
        (("sky", "rgb", "--rgb -D turn=41"), [true; 3]),
        (("surfaces", "spectral_polarized", "--spectral"), [true; 3]),
    ] {
        let (outcome, text) = accepts(case);
        assert!((0..3).all(|k| !(by[k] && outcome[k])), "{case:?}: {text}");
    }
}
