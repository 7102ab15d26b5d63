//! Virtual lights: unbiased with compensation, whatever the bound; darker without.

use crate::bidirectional::{SIZE, agree, means, room};
use crate::media::{Form, filled, hg, medium};
use crate::scenes::*;
use crate::stats::{agrees, same};
use kaustika_sampling::estimator::RunningMean;
use kaustika_scene::Scene;
use kaustika_scene::description::*;
use serde_json::json;

fn lamp(stage: &mut Stage) {
    stage.lamp(GeometryDesc::Rectangle, at(0.2, 0.1, 1.7) * down() * scale(0.3, 0.2, 1.0), 8.0);
}

/// A room with rough metal, glass, a varnished block and a lamp.
fn furnished() -> Scene {
    let mut stage = room();
    let glass = stage.glass(1.5, 0.0);
    stage.shape(sphere(0.25), at(0.45, -0.2, 0.26), glass);
    let varnish = stage.d.float(0.4);
    let one = stage.d.float(1.0);
    let varnished = stage.material(MaterialModel::Plastic {
        diffuse_reflectance: varnish,
        specular_reflectance: one,
        ior: 1.5,
        nonlinear: false,
        roughness: None,
    });
    stage.shape(GeometryDesc::Cube, at(0.1, 0.5, 0.2) * scale(0.2, 0.2, 0.2), varnished);
    lamp(&mut stage);
    stage.build()
}

#[test]
fn compensation_makes_any_bound_unbiased() {
    let scene = furnished();
    let path = means(&scene, "path", json!({"max_depth": 5}), 2500, 1100);
    for (i, p) in [
        json!({"max_depth": 5, "paths": 8}),
        json!({"max_depth": 5, "paths": 8, "clamp": 2.0}),
        json!({"max_depth": 5, "paths": 8, "clamp": 200.0, "roughness": 0.0}),
        json!({"max_depth": 5, "paths": 1, "roughness": 0.5}),
        json!({"max_depth": 5, "paths": 8, "roulette": "none"}),
    ]
    .into_iter()
    .enumerate()
    {
        let what = p.to_string();
        agree(&what, &means(&scene, "vpl", p, 500, 1110 + i as u64), &path);
    }
}

#[test]
fn each_number_of_bounces_agrees() {
    let scene = furnished();
    for depth in 1..=4 {
        let path = means(&scene, "path", json!({"only_depth": depth}), 1500, 1130 + depth);
        let p = json!({"only_depth": depth, "paths": 8, "clamp": 5.0});
        agree(&format!("{depth} bounces"), &means(&scene, "vpl", p, 400, 1140 + depth), &path);
    }
}

#[test]
fn without_compensation_light_is_lost() {
    let mut stage = room();
    lamp(&mut stage);
    let scene = stage.build();
    let path = &means(&scene, "path", json!({"max_depth": 3}), 3000, 1150)[4];
    let lossy = |clamp: f32| {
        let p = json!({"max_depth": 3, "paths": 8, "clamp": clamp, "compensate": false});
        means(&scene, "vpl", p, 3000, 1151).swap_remove(4)
    };
    let (some, more) = (lossy(2.0), lossy(0.4));
    let errors = |a: &RunningMean, b: &RunningMean| {
        (a.mean() - b.mean()) / a.standard_error().hypot(b.standard_error())
    };
    assert!(errors(path, &some) > 6.0, "{path:?} {some:?}");
    assert!(errors(&some, &more) > 6.0, "{some:?} {more:?}");
    // Direct light is not bounded.
    let direct = means(&scene, "path", json!({"max_depth": 1}), 800, 1152).swap_remove(4);
    let p = json!({"max_depth": 1, "clamp": 0.1, "compensate": false});
    same("direct light", &means(&scene, "vpl", p, 400, 1153)[4], &direct);
}

#[test]
fn the_integrating_sphere_is_exact() {
    // L = Σ ρᵏ over the bounces k that are wanted.
    let mut stage = Stage::new();
    let (m, e) = (stage.diffuse(0.5), stage.emission(1.0));
    let s = stage.shape(sphere(1.0), HERE, m);
    (s.flip_normals, s.emission) = (true, Some(e));
    stage.camera(pinhole(90.0), look(v(0.1, 0.2, 0.0), v(0.0, 1.0, 0.1)), SIZE);
    let scene = stage.build();
    let pixels = f64::from(SIZE[0] * SIZE[1]);
    for clamp in [0.3, 3.0] {
        let p = json!({"max_depth": 4, "paths": 4, "clamp": clamp});
        let picture = &means(&scene, "vpl", p, 300, 1160)[4];
        agrees(&format!("bound {clamp}"), picture, (2.0 - 0.5f64.powi(4)) * pixels);
    }
}

#[test]
fn fog_and_sky_agree() {
    let mut stage = room();
    lamp(&mut stage);
    stage.sky(0.3);
    filled(&mut stage, GeometryDesc::Cube, at(0.0, 0.0, 1.0) * scale(0.95, 0.95, 0.95), {
        medium(Form::Dense, 0.5, 0.8, hg(0.3))
    });
    let scene = stage.build();
    let path = means(&scene, "path", json!({"max_depth": 4}), 12_000, 1170);
    for clamp in [0.5, 20.0] {
        let p = json!({"max_depth": 4, "paths": 8, "clamp": clamp});
        agree(&format!("bound {clamp}"), &means(&scene, "vpl", p, 4000, 1171), &path);
    }
}
