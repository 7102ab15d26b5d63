//! Cut-outs, masks, interfaces and the sides of surfaces.

use crate::scenes::*;
use crate::stats::{agrees, close};
use kaustika_math::Vec3;
use kaustika_scene::description::*;
use serde_json::json;
use std::f64::consts::PI;

/// A lamp above the floor behind a screen that the caller makes.
fn screened(make: impl FnOnce(&mut Stage) -> ShapeDesc) -> Stage {
    let mut stage = Stage::new();
    floor(&mut stage);
    stage.lamp(disk(0.5), at(0.0, 0.0, 1.5) * down(), 3.0);
    let screen = make(&mut stage);
    stage.d.shapes.push(screen);
    stage
}

const DISC: f64 = PI * 3.0 * 0.25 / (0.25 + 2.25);

#[test]
fn a_cut_out_passes_what_it_does_not_cover() {
    for alpha in [0.0, 0.3, 0.85, 1.0] {
        let stage = screened(|stage| {
            let (black, alpha) = (stage.diffuse(0.0), stage.d.float(alpha));
            let mut s = shape(GeometryDesc::Rectangle, at(0.0, 0.0, 0.7), black);
            s.alpha = Some(alpha);
            s
        });
        let truth = 1.0 - alpha as f64;
        for mis in ["power", "light", "bsdf"] {
            let p = json!({"mis": mis, "max_depth": 1});
            let e = irradiance(&stage.build(), 0.0, 0.0, p, 20_000);
            agrees(&format!("shadow of {alpha}, {mis}"), &e, truth * DISC);
        }
        // Seen through by the camera, without a bounce; each ray has its own luck.
        let mut stage = stage;
        stage.camera(pinhole(20.0), at(0.0, 0.0, 0.1), [4, 4]);
        let seen = stage.render(json!({"max_depth": 0}), 1000, 3).mean();
        agrees(&format!("sight through {alpha}"), &seen, truth * 3.0);
    }
}

#[test]
fn a_mask_passes_what_it_does_not_cover() {
    for opacity in [0.0, 0.4, 1.0] {
        let stage = screened(|stage| {
            let (black, opacity) = (stage.diffuse(0.0), stage.d.float(opacity));
            let m = stage.material(MaterialModel::Mask { material: black, opacity });
            shape(GeometryDesc::Rectangle, at(0.0, 0.0, 0.7), m)
        });
        let truth = 1.0 - opacity as f64;
        for mis in ["power", "light", "bsdf"] {
            let e = irradiance(&stage.build(), 0.0, 0.0, json!({"mis": mis}), 20_000);
            agrees(&format!("mask {opacity}, {mis}"), &e, truth * DISC);
        }
    }
}

#[test]
fn an_interface_is_not_there() {
    let stage = screened(|stage| {
        let null = stage.material(MaterialModel::Null { counts: false });
        shape(sphere(0.4), at(0.0, 0.0, 0.7), null)
    });
    for mis in ["power", "light", "bsdf"] {
        let p = json!({"mis": mis, "max_depth": 1});
        let e = irradiance(&stage.build(), 0.0, 0.0, p, 20_000);
        agrees(&format!("interface, {mis}"), &e, DISC);
    }
}

#[test]
fn a_painted_cut_out_has_its_picture_s_holes() {
    let stage = screened(|stage| {
        let black = stage.diffuse(0.0);
        let stripes = bitmap(8, 1, |x, _| [f32::from(((8.0 * x) as u32).is_multiple_of(2)); 3]);
        let alpha = texture(stage, stripes, BitmapFilter::Nearest);
        let mut s = shape(GeometryDesc::Rectangle, at(0.0, 0.0, 0.7), black);
        s.alpha = Some(alpha);
        s
    });
    let scene = stage.build();
    for i in 0..8 {
        let x = -0.875 + 0.25 * i as f32;
        let seen = probe(&scene, v(x, 0.0, 0.6), Vec3::Z, json!({"max_depth": 0}), 1).0;
        // Lamp of radius 0.5 behind the odd stripes.
        let lit = i % 2 == 1 && x.abs() < 0.5;
        assert_eq!(seen.mean(), if lit { 3.0 } else { 0.0 }, "stripe {i}");
    }
}

#[test]
fn lamps_emit_from_their_front() {
    for flip in [false, true] {
        for mirrored in [false, true] {
            for form in [GeometryDesc::Rectangle, disk(0.8)] {
                let mut stage = Stage::new();
                let mirror = if mirrored { -1.0 } else { 1.0 };
                let t = rotate(30.0, v(1.0, 2.0, 0.5)) * scale(mirror, 1.0, 1.0);
                stage.lamp(form, t, 2.0).flip_normals = flip;
                // A normal is carried along as a normal: mirroring x leaves +z in front.
                let n = t.normal(Vec3::Z).normalize() * if flip { -1.0 } else { 1.0 };
                for (side, seen) in [(1.0, 2.0), (-1.0, 0.0)] {
                    let p = stage.probe(n * side, n * -side, json!({}), 1);
                    assert_eq!(p.mean(), seen, "flip {flip}, mirrored {mirrored}, side {side}");
                }
            }
        }
    }
}

#[test]
fn one_sided_and_two_sided_reflection() {
    for two_sided in [false, true] {
        let mut stage = Stage::new();
        let mut m = stage.diffuse(0.5);
        if two_sided {
            m = stage.two_sided(m);
        }
        stage.shape(GeometryDesc::Rectangle, HERE, m);
        for side in [1.0, -1.0] {
            let mut stage = stage.clone();
            stage.point_light(v(0.0, 0.0, 2.0 * side), 8.0);
            let seen =
                stage.probe(v(0.0, 0.1, side), v(0.0, -0.1, -side), json!({"max_depth": 1}), 1);
            let lit = two_sided || side > 0.0;
            let truth = if lit { 0.5 / PI * 8.0 / 4.0 } else { 0.0 };
            close(&format!("side {side}, two-sided {two_sided}"), seen.mean(), truth, 1e-5);
        }
    }
}
