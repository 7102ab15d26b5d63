//! Hybrids: final passes that may stand for each other where the scene is glossy.

use crate::hybrid::{mean, pictures, small_room};
use crate::scenes::*;
use crate::stats::same;
use kaustika_math::Vec3;
use kaustika_transport::registry;
use serde_json::{Value, json};

const SMALL: [u32; 2] = [12, 12];
/// Chen's A and C.
const CLASSES: [&str; 2] = ["L[D]S*E", "L(D|S)*DS*DS*E"];

/// The room with a wall of rough metal in place of its mirror.
fn glossy_room() -> Stage {
    let mut stage = small_room();
    stage.d.cameras[0].film.resolution = SMALL;
    let gloss = stage.metal(0.25);
    let mirror = stage.d.shapes.iter_mut().find(|s| s.transform.point(Vec3::ZERO).x < -0.9);
    let mirror = mirror.expect("the mirror");
    mirror.material = gloss;
    mirror.transform = at(-0.98, 0.0, 0.0) * rotate(90.0, Vec3::Y) * scale(0.95, 0.95, 1.0);
    stage
}

fn parted(method: &str) -> Value {
    let [a, c] = CLASSES;
    let terms = format!("{method}:{a}; radiosity@2:{c}");
    json!({"of": format!("{a}|{c}"), "terms": terms, "patches": 100, "form_rays": 256, "photons": 5000})
}

/// What is glossy is seen by path tracing or by distributed ray tracing, the same, and is that of bidirectional path
/// tracing; Whitted's rays, which know ideal mirrors alone, are refused.
#[test]
fn glossy_final_passes_are_interchangeable() {
    let scene = glossy_room().build();
    let truth = pictures(&scene, ("bdpt", json!({})), &CLASSES, (SMALL, 20, 20, 20));
    let by = |method: &str, seed| {
        pictures(&scene, ("hybrid", parted(method)), &[], (SMALL, 40, 10, seed))
    };
    let (paths, rays) = (by("path", 21), by("distributed", 22));
    same("the picture", &mean(&rays[0]), &mean(&paths[0]));
    for found in [&paths, &rays] {
        same("the final pass", &mean(&found[1]), &mean(&truth[1]));
        assert!(mean(&found[2]).mean() > 0.0);
    }
    // It is not the light of ideal mirrors.
    let ideal = pictures(&scene, ("path", json!({})), &["L[D]S_M*E"], (SMALL, 20, 20, 23));
    let glossy = [mean(&ideal[1]).mean(), mean(&truth[1]).mean()];
    assert!(glossy[0] < 0.99 * glossy[1], "{glossy:?}");
    let Value::Object(p) = parted("whitted") else { panic!("an object") };
    let refused = (registry::find("hybrid").expect("known").make)(&p).map(|_| ());
    let message = refused.expect_err("gloss").to_string();
    assert!(message.contains("`whitted` makes L[D|S]S_M*E, and never `LDSE`"), "{message}");
}
