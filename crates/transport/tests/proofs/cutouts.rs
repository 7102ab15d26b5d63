//! Lights that are cut out in part: what is sampled of them and what rays find agree.
//!
//! ```text
//! L = ρ α R² / (R² + h²)                                                     (1)
//! ```
//!
//! is the radiance of matte ground at a distance h below the middle of a disk of radius R and radiance 1, of
//! which the share α is there.

use crate::bidirectional::{agree, means, room};
use crate::scenes::*;
use crate::stats::agrees;
use kaustika_math::Vec3;
use kaustika_scene::description::*;
use serde_json::json;

const RADIUS: f32 = 1.0;
const HEIGHT: f32 = 2.0;

/// White ground under a disk that shines down on it.
fn ground(alpha: impl FnOnce(&mut Stage) -> TextureId) -> Stage {
    let mut stage = Stage::new();
    stage.d.format = SourceFormat::Pbrt;
    let (white, alpha) = (stage.diffuse(1.0), alpha(&mut stage));
    stage.lamp(disk(RADIUS), at(0.0, 0.0, HEIGHT) * down(), 1.0).alpha = Some(alpha);
    stage.shape(GeometryDesc::Rectangle, scale(50.0, 50.0, 1.0), white);
    stage
}

/// (1) for a whole disk of this radius.
fn below(radius: f32) -> f64 {
    let (r2, h2) = (f64::from(radius * radius), f64::from(HEIGHT * HEIGHT));
    r2 / (r2 + h2)
}

/// Compares the ground below the middle with `truth` however it is sampled.
fn check(what: &str, stage: &Stage, truth: f64) {
    for mis in ["power", "balance", "light", "bsdf"] {
        let p = json!({"max_depth": 1, "mis": mis});
        let found = stage.probe(v(2.0, -3.0, 1.0), v(-2.0, 3.0, -1.0), p, 40_000);
        agrees(&format!("{what}, {mis}"), &found, truth);
    }
}

#[test]
fn a_light_that_is_half_there_shines_half() {
    check("half", &ground(|s| s.d.float(0.5)), 0.5 * below(RADIUS));
}

#[test]
fn a_light_with_a_hole_shines_as_its_rest() {
    // v runs from the rim inward: it is below 1/2 outside of R/2.
    let outside = |s: &mut Stage| {
        let (full, none) = (s.d.float(1.0), s.d.float(0.0));
        let mapping = TextureMapping::default();
        let corners = [full, none, full, none];
        let ramp = s.d.add_texture(TextureNode::Bilerp { corners, mapping }, None);
        s.d.add_texture(TextureNode::Step { texture: ramp, threshold: 0.5 }, None)
    };
    check("ring", &ground(outside), below(RADIUS) - below(0.5 * RADIUS));
}

#[test]
fn a_light_that_is_nowhere_shines_unseen_in_scenes_of_pbrt() {
    let mut stage = ground(|s| s.d.float(0.0));
    check("unseen", &stage, below(RADIUS));
    let seen = stage.probe(v(0.0, 0.0, 1.0), Vec3::Z, json!({}), 64);
    assert_eq!(seen.mean(), 0.0);
    // Elsewhere what is not there does not shine.
    stage.d.format = SourceFormat::Gltf;
    check("nothing", &stage, 0.0);
}

#[test]
fn methods_that_start_at_lights_agree() {
    for (what, alpha, seed) in [("partly there", 0.6, 300), ("unseen", 0.0, 400)] {
        let mut stage = room();
        stage.d.format = SourceFormat::Pbrt;
        let alpha = stage.d.float(alpha);
        stage.lamp(disk(0.25), at(0.3, 0.2, 1.2) * down(), 8.0).alpha = Some(alpha);
        let scene = stage.build();
        for (depth, seed) in [(1, seed), (2, seed + 50)] {
            let p = json!({"only_depth": depth});
            let path = means(&scene, "path", p.clone(), 1000, seed);
            for (method, passes) in [("bdpt", 250), ("light", 600)] {
                let other = means(&scene, method, p.clone(), passes, seed + 1);
                agree(&format!("{what}, {method}, {depth}"), &other, &path);
            }
        }
    }
}
