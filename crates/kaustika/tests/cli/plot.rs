//! `kaustika plot`.

use crate::kit::Place;
use serde_json::Value;
use std::process::Command;

/// What is drawn of a material of a scene, and its values.
#[test]
fn lobes_of_a_material_are_drawn() {
    let p = Place::new();
    let named = r#"
WorldBegin
MakeNamedMaterial "paint" "string type" "diffuse" "rgb reflectance" [0.5 0.5 0.5]
MakeNamedMaterial "steel" "string type" "conductor" "float roughness" 0.2
MakeNamedMaterial "pane" "string type" "dielectric"
NamedMaterial "paint"
Shape "disk"
"#;
    p.write("named.pbrt", named);
    p.ok("plot brdf paint steel pane --scene named.pbrt --log -o lobes.svg");
    let svg = std::fs::read_to_string(p.path("lobes.svg")).unwrap();
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    // A panel for each material and angle: lines of light for all, lobes and mirror directions where they are.
    assert_eq!(svg.matches("<g ").count(), 12);
    assert_eq!(svg.matches("stroke-dasharray").count(), 12);
    assert_eq!(svg.matches("#3b75af").count(), 4);
    assert_eq!(svg.matches("#ef8636").count(), 4);
    assert_eq!(svg.matches("#c0392b").count(), 8);
    let json = p.ok("plot brdf paint --scene named.pbrt --angle 35 --step 30 --json");
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json[0]["angles"].as_array().unwrap().len(), 12);
    let middle = json[0]["diffuse"][5][0].as_f64().unwrap();
    assert!((middle - 0.5 / std::f64::consts::PI).abs() < 1e-4, "{middle}");
}

/// Without a scene, as pbrt writes materials; and what does not exist.
#[test]
fn materials_are_found_or_told() {
    let p = Place::new();
    let plot = |words: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_kaustika")).args(["plot", "brdf"]).args(words).output()
    };
    let out = plot(&["\"conductor\" \"float roughness\" 0.2", "--angle", "45"]).unwrap();
    assert!(out.status.success());
    assert!(String::from_utf8(out.stdout).unwrap().contains(">conductor float roughness 0.2<"));
    let wrong = plot(&["\"conductor\" \"float rough\" 0.2"]).unwrap();
    let told = String::from_utf8(wrong.stderr).unwrap();
    assert!(told.contains("rough"), "{told}");
    let told = p.fails(2, "plot brdf plastic");
    assert!(told.contains("--scene FILE"), "{told}");
    let told = p.fails(2, "plot brdf plastic --scene ball.pbrt");
    assert!(told.contains("no material `plastic`; materials here have no names: say #0"), "{told}");
    let told = p.fails(2, "plot brdf #0 --scene ball.pbrt --angle 90");
    assert!(told.contains("from 0 to less than 90"), "{told}");
    let told = p.fails(2, "plot brdf #0 --scene ball.pbrt --angle -5");
    assert!(told.contains("from 0 to less than 90"), "{told}");
    let told = p.fails(2, "plot brdf #0 --scene ball.pbrt -o lobes.png");
    assert!(told.contains("lobes.png: drawings are written as .svg"), "{told}");
    let told = p.fails(1, "plot brdf #0 --scene ball.pbrt -o nowhere/lobes.svg");
    assert!(told.contains("there is no folder nowhere"), "{told}");
    p.ok("plot brdf #0 --scene ball.pbrt --json -o lobes.json");
    let json: Value =
        serde_json::from_slice(&std::fs::read(p.path("lobes.json")).unwrap()).unwrap();
    assert_eq!(json.as_array().map(Vec::len), Some(4));
}
