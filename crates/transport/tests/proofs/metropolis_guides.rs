//! Chains find the light of a small lamp under water: where they start looks for it where paths from the lamp say it comes from.

use crate::bidirectional::{SIZE, agree, means, renders};
use crate::scenes::*;
use kaustika_scene::Scene;
use kaustika_scene::description::*;
use serde_json::{Value, json};

/// Water over a matte bottom before a varnished wall, under a lamp of this radius; lamp and camera are above the water,
/// so that only rays from the bottom which happen to meet the lamp bring its light.
fn tank(radius: f32) -> Scene {
    let mut stage = Stage::new();
    let white = stage.diffuse(0.7);
    let (diffuse_reflectance, specular_reflectance) = (stage.d.float(0.4), stage.d.float(1.0));
    let (ior, nonlinear, roughness) = (1.5, false, None);
    let varnished = MaterialModel::Plastic {
        diffuse_reflectance,
        specular_reflectance,
        ior,
        nonlinear,
        roughness,
    };
    let varnished = stage.material(varnished);
    let both = |stage: &mut Stage, t, m| {
        let m = stage.two_sided(m);
        stage.shape(GeometryDesc::Rectangle, t, m);
    };
    both(&mut stage, at(0.0, 0.0, 0.0), white);
    both(&mut stage, at(0.0, 1.0, 0.0) * rotate(90.0, v(1.0, 0.0, 0.0)), varnished);
    let water = stage.glass(1.33, 0.0);
    stage.shape(GeometryDesc::Rectangle, at(0.0, 0.0, 0.5) * scale(3.0, 3.0, 1.0), water);
    stage.lamp(sphere(radius), at(0.4, 0.2, 1.6), 0.2 / (radius * radius));
    stage.camera(pinhole(50.0), look(v(0.0, -1.6, 1.9), v(0.0, 0.1, 0.2)), SIZE);
    stage.build()
}

/// With or without guides; of `candidates`.
fn with(guiding: bool, candidates: u32, more: Value) -> Value {
    let mut p = json!({"max_depth": 6, "guiding": guiding, "bootstrap": candidates});
    let Value::Object(more) = more else { panic!("an object") };
    p.as_object_mut().expect("an object").extend(more);
    p
}

/// Those of methods whose chains go on.
fn chains(guiding: bool, candidates: u32) -> Value {
    with(guiding, candidates, json!({"brightness_error": 1.0, "chains": 32, "renew": 0}))
}

#[test]
fn guided_starts_agree_with_the_path_tracer() {
    let scene = tank(0.2);
    let path = means(&scene, "path", json!({"max_depth": 6}), 20_000, 8000);
    // The test can see a fault of a few per cent.
    let error = path[4].standard_error() / path[4].mean();
    assert!(error < 1e-2, "{error}");
    for (i, method) in ["pssmlt", "mmlt", "mlt"].into_iter().enumerate() {
        let guided = renders(&scene, method, chains(true, 8192), 100, 8010 + i as u64);
        let error = guided[4].standard_error() / guided[4].mean();
        assert!(error < 2e-2, "{method}: {error}");
        agree(method, &guided, &path);
    }
    let bdpt = json!({"max_depth": 6, "guiding": true});
    agree("bdpt", &means(&scene, "bdpt", bdpt, 1000, 8019), &path);
    let over = with(true, 8192, json!({"brightness_error": 1.0, "chains": 32, "over": "path"}));
    agree("over=path", &renders(&scene, "pssmlt", over, 100, 8020), &path);
    agree("erpt", &means(&scene, "erpt", with(true, 8192, json!({})), 1000, 8021), &path);
}

#[test]
fn guides_find_what_chance_does_not() {
    // By chance one ray in some thousand from the bottom meets the lamp. F(11, 11) exceeds 20 with a probability of 10⁻⁵.
    let scene = tank(0.03);
    for method in ["pssmlt", "mmlt", "mlt"] {
        let spread = |guiding| {
            let mut p = chains(guiding, 4096);
            p["only_depth"] = 3.into();
            renders(&scene, method, p, 1, 8100)[4].variance()
        };
        let (plain, guided) = (spread(false), spread(true));
        assert!(plain > 20.0 * guided, "{method}: {plain} {guided}");
    }
}
