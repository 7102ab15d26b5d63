//! Lights that shine along one direction a point: closed forms, and the methods that find them.

use crate::bidirectional::{Light, agree, means, room};
use crate::scenes::*;
use crate::stats::{agrees, close};
use kaustika_math::{Transform, Vec3};
use kaustika_scene::description::*;
use serde_json::json;
use std::f64::consts::PI;

fn beam(stage: &mut Stage, transform: Transform, power: f32) {
    stage.light(LightKind::Beam { power: grey(power), scale: 1.0 }, transform);
}

/// A shape that shines along its normals with `b` watts per square metre.
fn along_normals(stage: &mut Stage, g: GeometryDesc, t: Transform, b: f32) {
    stage.lamp(g, t, b).emission.as_mut().expect("a lamp").along_normal = true;
}

#[test]
fn a_spot_of_light_reflects_what_the_beam_brings() {
    // A camera that sees 4 x 4 of the floor: ∫ L dA = ρ Φ/π, wherever the beam falls.
    let mut stage = Stage::new();
    let white = stage.diffuse(0.6);
    stage.shape(disk(5.0), HERE, white);
    stage.camera(parallel(2.0, 0.0, 1.0), at(0.0, 0.0, 3.0) * down(), [12, 8]);
    // In the middle: merging blurs the spot, and all of it must be seen.
    beam(&mut stage, at(-0.8, 0.2, 1.0) * rotate(140.0, Vec3::Y), 5.0);
    let scene = stage.build();
    for (method, p) in [
        ("light", json!({})),
        ("bdpt", json!({"max_depth": 1})),
        ("vcm", json!({"max_depth": 1})),
        ("backward", json!({"texel": 0.05})),
    ] {
        let mean = scaled(&means(&scene, method, p, 50, 1)[4], 16.0 / 96.0);
        match method {
            // Which eye paths end near the spot is chance.
            "vcm" | "backward" => agrees(method, &mean, 0.6 * 5.0 / PI),
            _ => close(method, mean.mean(), 0.6 * 5.0 / PI, 1e-3),
        }
    }
    assert_eq!(means(&scene, "path", json!({}), 2, 1)[4].mean(), 0.0);
}

#[test]
fn a_disk_that_shines_along_its_normal_lights_its_shadow() {
    // B on the floor below it, nothing beside.
    let mut stage = Stage::new();
    floor(&mut stage);
    along_normals(&mut stage, disk(1.0), at(0.0, 0.0, 2.0) * down(), 3.0);
    for (x, y) in [(0.0, 0.0), (0.3, 0.2), (1.5, 0.0)] {
        stage.d.cameras.clear();
        let size = 0.3;
        stage.camera(parallel(size, 0.0, 1.0), at(x, y, 1.0) * down(), [12, 8]);
        let scene = stage.build();
        let e = if x < 1.0 { 3.0 } else { 0.0 };
        for method in ["light", "bdpt"] {
            let sum = means(&scene, method, json!({"max_depth": 1}), 200, 7);
            let mean = scaled(&sum[4], 1.0 / 96.0);
            match e {
                0.0 => assert_eq!(mean.mean(), 0.0),
                _ => agrees(&format!("{method} {x} {y}"), &mean, e * 0.5 / PI),
            }
        }
    }
}

#[test]
fn a_sphere_that_shines_along_its_normals_is_a_point_light() {
    // I = B R².
    let picture = |point: bool| {
        let mut stage = room();
        match point {
            true => stage.point_light(v(0.3, -0.1, 1.4), 4.0 * 0.05 * 0.05),
            false => along_normals(&mut stage, sphere(0.05), at(0.3, -0.1, 1.4), 4.0),
        }
        // The sphere itself is in the way of what comes back.
        means(&stage.build(), "light", json!({"only_depth": 1}), 400, 3 + u64::from(point))
    };
    agree("sphere", &picture(true), &picture(false));
}

#[test]
fn methods_agree_on_beams_in_a_room() {
    let kinds: Vec<(&str, Light)> = vec![
        ("beam", Box::new(|s| beam(s, at(0.4, -0.3, 1.5) * rotate(200.0, v(0.3, 1.0, 0.0)), 4.0))),
        ("sphere", Box::new(|s| along_normals(s, sphere(0.2), at(0.3, -0.1, 1.4), 6.0))),
        (
            "beside a lamp",
            Box::new(|s| {
                beam(s, at(0.4, -0.3, 1.5) * rotate(200.0, v(0.3, 1.0, 0.0)), 4.0);
                s.point_light(v(0.4, -0.2, 1.3), 0.5);
            }),
        ),
    ];
    for (name, light) in kinds {
        let mut stage = room();
        light(&mut stage);
        let scene = stage.build();
        let p = json!({"max_depth": 4, "roulette": "none"});
        let reference = means(&scene, "light", p.clone(), 300, 11);
        let bdpt = means(&scene, "bdpt", p, 300, 12);
        agree(&format!("bdpt, {name}"), &reference, &bdpt);
        let vcm = means(&scene, "vcm", json!({"max_depth": 4, "mode": "bpt"}), 300, 13);
        agree(&format!("vcm, {name}"), &reference, &vcm);
    }
}
