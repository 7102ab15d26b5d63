//! What chains leave to samples of pixels: glass that the eye meets first shows both what it mirrors and what lies behind it.

use crate::bidirectional::{SIZE, agree, means};
use crate::scenes::*;
use kaustika_scene::Scene;
use kaustika_scene::description::*;
use serde_json::json;

/// A pane of glass that glows a little and mirrors a lamp of this radius and power, before a wall that glows as well.
fn pane(camera: CameraKind, radius: f32, power: f32) -> Scene {
    let mut stage = Stage::new();
    let (white, glass) = (stage.diffuse(0.6), stage.glass(1.5, 0.0));
    let upright = rotate(90.0, v(1.0, 0.0, 0.0));
    for (y, size, material, radiance) in [(0.0, 1.0, glass, 0.05), (1.0, 3.0, white, 0.2)] {
        let emission = stage.emission(radiance);
        let place = at(0.0, y, 0.0) * upright * scale(size, size, 1.0);
        stage.shape(GeometryDesc::Rectangle, place, material).emission = Some(emission);
    }
    stage.lamp(sphere(radius), at(0.3, -1.2, 0.4), power / (radius * radius));
    stage.camera(camera, look(v(0.0, -2.5, 0.0), v(0.0, 0.0, 0.0)), SIZE);
    stage.build()
}

#[test]
fn samples_of_both_sides_agree_with_bdpt() {
    // Light meets a wide lens itself: that is another way to make the lamp's image.
    let cases = [
        (pane(pinhole(60.0), 0.3, 0.1), json!({"max_depth": 1})),
        (pane(thin_lens(60.0, 0.3, 2.0), 0.15, 2.0), json!({"max_depth": 1, "only_depth": 1})),
    ];
    for (i, (scene, p)) in cases.into_iter().enumerate() {
        let seed = 40 * i as u64;
        let by = |method, passes, seed| means(&scene, method, p.clone(), passes, seed);
        let bdpt = by("bdpt", 16_000, 8200 + seed);
        let error = bdpt[4].standard_error() / bdpt[4].mean();
        assert!(error < 2e-2, "{error}");
        agree("mlt", &by("mlt", 4000, 8210 + seed), &bdpt);
        agree("pssmlt", &by("pssmlt", 4000, 8220 + seed), &bdpt);
    }
}

#[test]
fn a_small_lamp_is_found_in_glass_as_if_it_were_a_mirror() {
    // Glass mirrors one ray of twenty-five by chance, so that there are some hundred hits of the lamp's image by chance: their
    // variance is known to a fifth, and 8 of 25 is asked.
    let scene = pane(pinhole(60.0), 0.02, 0.1);
    let spread = |method| {
        means(&scene, method, json!({"max_depth": 1, "only_depth": 1}), 4000, 8300)[4].variance()
    };
    let (by_chance, both) = (spread("bdpt"), spread("mlt"));
    assert!(by_chance > 8.0 * both, "{by_chance} {both}");
}
