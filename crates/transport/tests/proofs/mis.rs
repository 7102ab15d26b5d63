//! Light and BSDF sampling, alone and combined by every heuristic: equal means.

use crate::scenes::*;
use crate::stats::{agrees, close, same};
use kaustika_math::Vec3;
use kaustika_sampling::MisHeuristic;
use kaustika_sampling::estimator::RunningMean;
use kaustika_scene::description::*;
use serde_json::json;

const MODES: [&str; 7] = ["balance", "power", "power:4", "power:0.5", "max", "light", "bsdf"];

/// Veach & Guibas 1995: plates of varying gloss below lights of varying size, under a sky.
fn plates() -> Stage {
    let mut stage = Stage::new();
    for (i, alpha) in [0.3, 0.15, 0.08].into_iter().enumerate() {
        let m = stage.metal(alpha);
        let k = i as f32;
        let t = at(0.0, 0.4 * k, 0.25 * k) * rotate(20.0 + 8.0 * k, Vec3::X);
        stage.shape(GeometryDesc::Rectangle, t * scale(1.0, 0.18, 1.0), m);
    }
    floor_below(&mut stage);
    stage.lamp(sphere(0.3), at(-0.6, 1.6, 1.6), 2.0);
    stage.lamp(sphere(0.1), at(0.0, 1.6, 1.7), 12.0);
    stage.lamp(disk(0.15), at(0.6, 1.5, 1.6) * rotate(110.0, Vec3::X), 8.0);
    stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.3, 2.5) * down() * scale(0.2, 0.1, 1.0), 10.0);
    stage.sky(0.05);
    stage.camera(pinhole(45.0), look(v(0.0, -2.5, 1.2), v(0.0, 0.4, 0.2)), [8, 8]);
    stage
}

fn floor_below(stage: &mut Stage) {
    let m = stage.diffuse(0.4);
    stage.shape(GeometryDesc::Rectangle, at(0.0, 0.0, -0.4) * scale(4.0, 4.0, 1.0), m);
}

#[test]
fn every_heuristic_has_the_same_mean() {
    let stage = plates();
    let picture = |mis: &str, seed| {
        stage.render(json!({"mis": mis, "max_depth": 3, "hide_emitters": true}), 250, seed)
    };
    let reference = picture("power", 1000);
    for (i, mis) in MODES.iter().enumerate() {
        let other = picture(mis, i as u64);
        same(mis, &other.mean(), &reference.mean());
        // Tiles of 2 x 2 pixels; the single techniques fail in places, and their errors' laws
        // have tails too heavy for small means.
        if *mis == "light" || *mis == "bsdf" {
            continue;
        }
        for y in 0..4 {
            for x in 0..4 {
                let tile = |p: &Picture| {
                    let mut sum = RunningMean::new();
                    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                        sum.merge(p.at(2 * x + dx, 2 * y + dy));
                    }
                    sum
                };
                same(&format!("{mis}, tile {x} {y}"), &tile(&other), &tile(&reference));
            }
        }
    }
}

#[test]
fn weights_sum_to_one() {
    let mut random = crate::stats::Random::new(3);
    for mode in MODES {
        let h: MisHeuristic = mode.parse().expect("a heuristic");
        for i in 0..1000 {
            // Ties, and the densities that Dirac lobes and delta lights leave at zero.
            let q = |u: f32, k: i32| if k == 0 { 0.0 } else { (20.0 * (u - 0.5)).exp() };
            let a = q(random.f(), i % 17);
            let b = if i % 5 == 0 { a } else { q(random.f(), i % 13) };
            if a > 0.0 || b > 0.0 {
                close(mode, (h.light(a, b) + h.bsdf(a, b)) as f64, 1.0, 1e-6);
            }
        }
    }
}

#[test]
fn the_light_technique_is_what_next_event_estimation_adds() {
    // Without directly visible sources, light samples alone give what both give together.
    let mut stage = Stage::new();
    floor(&mut stage);
    stage.lamp(disk(0.4), at(0.3, 0.0, 1.0) * down(), 4.0);
    let scene = stage.build();
    let truth = std::f64::consts::PI * 4.0 * 0.16;
    let mean =
        |mis: &str| irradiance(&scene, 0.0, 0.0, json!({"mis": mis, "max_depth": 1}), 30_000);
    let (light, bsdf) = (mean("light"), mean("bsdf"));
    same("s = 1 and s = 0", &light, &bsdf);
    assert!(light.mean() < truth);
    // The light fills a few percent of the hemisphere: sampling it is far less noisy.
    assert!(light.standard_error() < 0.2 * bsdf.standard_error());
}

#[test]
fn lights_are_seen_in_mirrors() {
    let mut stage = Stage::new();
    let mirror = stage.metal(0.0);
    stage.shape(GeometryDesc::Rectangle, scale(2.0, 2.0, 1.0), mirror);
    stage.lamp(disk(0.4), at(0.0, 0.0, 2.0) * down(), 4.0);
    for mis in MODES {
        // Straight down onto the mirror from under the lamp: the lamp.
        let seen = stage.probe(v(0.1, 0.0, 1.0), v(0.0, 0.0, -1.0), json!({"mis": mis}), 4);
        close(&format!("area light, {mis}"), seen.mean(), 4.0, 1e-6);
    }

    // A wall lit by a point light is seen in the mirror as it is directly.
    let mut stage = Stage::new();
    let (mirror, grey) = (stage.metal(0.0), stage.diffuse(0.5));
    stage.shape(GeometryDesc::Rectangle, scale(2.0, 2.0, 1.0), mirror);
    stage.shape(GeometryDesc::Rectangle, at(0.0, 0.0, 3.0) * down() * scale(2.0, 2.0, 1.0), grey);
    stage.point_light(v(0.0, 0.5, 1.0), 6.0);
    let truth = 0.5 / std::f64::consts::PI * 6.0 * 2.0 / (4.0f64 + 0.25).powf(1.5);
    // By way of the mirror the wall gets the light's image too: bounce 1 of it alone.
    for mis in MODES {
        let p = json!({"mis": mis, "only_depth": 2, "max_depth": 2});
        let seen = stage.probe(v(0.0, 0.0, 0.5), v(0.0, 0.0, -1.0), p, 4);
        close(&format!("point light, {mis}"), seen.mean(), truth, 1e-5);
    }
}

#[test]
fn emission_is_counted_once() {
    // A lamp that reflects: seen directly it shows its own light, once, and the sky's.
    let mut stage = Stage::new();
    let (m, e) = (stage.diffuse(0.5), stage.emission(2.0));
    let s = stage.shape(GeometryDesc::Rectangle, scale(3.0, 3.0, 1.0), m);
    s.emission = Some(e);
    stage.sky(0.8);
    for mis in MODES {
        let p = json!({"mis": mis});
        let seen = stage.probe(v(0.0, 0.0, 1.0), v(0.0, 0.3, -1.0), p, 5000);
        agrees(mis, &seen, 2.0 + 0.5 * 0.8);
    }
}
