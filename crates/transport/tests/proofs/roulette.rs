//! Russian roulette changes cost and noise, never the mean.

use crate::scenes::*;
use crate::stats::same;
use kaustika_math::Vec3;
use kaustika_scene::description::*;
use serde_json::json;

#[test]
fn the_mean_does_not_depend_on_rule_or_start() {
    // A closed box, one wall coloured dark, a glass ball (whose radiance scaling the throughput
    // rule must not mistake for throughput) and a small lamp.
    let mut stage = Stage::new();
    let (white, dark) = (stage.diffuse(0.7), stage.diffuse(0.2));
    stage.shape(GeometryDesc::Cube, HERE, white).flip_normals = true;
    stage.shape(GeometryDesc::Rectangle, at(-0.99, 0.0, 0.0) * rotate(90.0, Vec3::Y), dark);
    let glass = stage.glass(1.5, 0.0);
    stage.shape(sphere(0.35), at(0.2, 0.2, -0.6), glass);
    stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, 0.98) * down() * scale(0.5, 0.5, 1.0), 3.0);
    stage.camera(pinhole(80.0), look(v(0.0, -0.95, 0.0), v(0.0, 1.0, -0.2)), [6, 6]);
    let picture = |rule: &str, rr_depth: u32, seed| {
        let p = json!({"roulette": rule, "rr_depth": rr_depth, "max_depth": 24});
        stage.render(p, 300, seed)
    };
    let reference = picture("none", 0, 50);
    let mut rays = Vec::new();
    for (rule, rr_depth, seed) in [
        ("throughput", 0, 1),
        ("throughput", 1, 2),
        ("throughput", 5, 3),
        ("albedo", 0, 4),
        ("albedo", 3, 5),
    ] {
        let other = picture(rule, rr_depth, seed);
        same(&format!("{rule} after {rr_depth}"), &other.mean(), &reference.mean());
        rays.push(other.rays);
    }
    // It does end paths, the more the earlier it starts.
    assert!(rays[0] < rays[1] && rays[1] < rays[2] && rays[2] < reference.rays);
}

#[test]
fn a_finite_depth_misses_the_tail_of_the_series() {
    let mut stage = Stage::new();
    let (m, e) = (stage.diffuse(0.5), stage.emission(1.0));
    let s = stage.shape(sphere(1.0), HERE, m);
    (s.flip_normals, s.emission) = (true, Some(e));
    for depth in [0, 1, 2, 7] {
        let p = json!({"max_depth": depth, "roulette": "none", "mis": "bsdf"});
        let seen = stage.probe(v(0.1, 0.2, 0.3), Vec3::X, p, 4);
        crate::stats::close("partial sum", seen.mean(), 2.0 - 0.5f64.powi(depth), 1e-5);
    }
}
