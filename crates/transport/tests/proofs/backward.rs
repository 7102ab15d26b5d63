//! Backward ray tracing: maps hold the flux that arrives, and caustics are those of path tracing.

use crate::bidirectional::{SIZE, means};
use crate::classes::layers;
use crate::scenes::*;
use crate::stats::{agrees, close, same};
use kaustika_film::FilterDesc;
use kaustika_math::Vec3;
use kaustika_sampling::estimator::RunningMean;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::Scene;
use kaustika_scene::description::*;
use kaustika_transport::ray_tracing::backward::{Backward, BackwardParams};
use kaustika_transport::{Frame, Method, Workers};
use serde_json::json;
use std::f64::consts::PI;
use std::sync::Arc;

/// What paths this method can find.
const FOUND: &str = "LS*[D]S*E";

fn frame(size: [u32; 2], seed: u64) -> Frame {
    let kind = SamplerKind::Independent;
    Frame::new(size, FilterDesc::BOX, SamplerConfig { kind, seed, spp: 1, resolution: size })
}

/// The flux in the maps of a pass.
fn flux(scene: &Scene, params: BackwardParams, seed: u64) -> f64 {
    let frame = frame(SIZE, seed);
    let workers = Workers::new(2, Arc::default()).expect("threads");
    let mut method = Backward::new(params);
    method.prepare(scene, &frame, &workers).expect("prepared");
    let maps = method.maps(0, scene, &frame, &workers).expect("maps");
    f64::from(maps.flux().0[0])
}

#[test]
fn all_light_that_leaves_a_glass_ball_is_in_the_maps() {
    // A lamp in a ball of glass, which loses nothing, in a closed room of many kinds of surfaces:
    // every photon ends in a map with the power that it was given.
    let mut stage = Stage::new();
    let (white, glass) = (stage.diffuse(0.3), stage.glass(1.5, 0.0));
    let two_sided = stage.two_sided(white);
    stage.shape(GeometryDesc::Cube, scale(2.0, 3.0, 2.0), two_sided);
    stage.shape(disk(0.7), at(0.3, 0.2, -1.5) * scale(1.0, 2.0, 1.0), two_sided);
    stage.shape(sphere(0.5), at(1.0, 0.4, 0.2) * scale(1.0, 0.5, 1.2), two_sided);
    stage.shape(sphere(0.3), HERE, glass);
    stage.point_light(v(0.05, 0.1, 0.0), 2.0);
    stage.camera(pinhole(60.0), look(v(-1.5, -2.5, 1.0), v(0.0, 0.0, 0.7)), SIZE);
    let params = || BackwardParams {
        photons: 5000,
        roulette: kaustika_transport::roulette::Survival::None,
        ..BackwardParams::default()
    };
    let truth = 4.0 * PI * 2.0;
    close("flux", flux(&stage.build(), params(), 1200), truth, 1e-4);
    // Beyond the surfaces there is nothing: without the room all is lost.
    stage.d.shapes.truncate(0);
    let glass = stage.glass(1.5, 0.0);
    stage.shape(sphere(0.3), HERE, glass);
    assert_eq!(flux(&stage.build(), params(), 1201), 0.0);
}

/// A floor and a mirror above: the mirror's image of the lamp is a second lamp.
#[test]
fn a_mirror_makes_an_image_of_the_light() {
    // Floors of triangles and of a disk, as they are and stretched by an instance.
    let place = |stage: &mut Stage, shape| {
        let (group, motion, span) = (GroupId(0), Vec::new(), None);
        stage.d.groups.push(GroupDesc { name: String::new(), shapes: vec![shape] });
        let transform = rotate(30.0, Vec3::Z) * scale(2.0, 3.0, 0.5);
        stage.d.instances.push(InstanceDesc { group, transform, motion, span });
    };
    let rectangle = || (GeometryDesc::Rectangle, scale(2.0, 2.0, 1.0));
    let ellipse = || (disk(2.0), scale(1.2, 1.8, 1.0));
    let floors = [
        ("rectangle", rectangle(), false),
        ("rectangle of an instance", rectangle(), true),
        ("ellipse", ellipse(), false),
        ("ellipse of an instance", ellipse(), true),
    ];
    for (i, (what, (geometry, transform), instance)) in floors.into_iter().enumerate() {
        let mut stage = Stage::new();
        let m = stage.diffuse(0.5);
        match instance {
            true => place(&mut stage, shape(geometry, transform, m)),
            false => drop(stage.shape(geometry, transform, m)),
        }
        let mirror = stage.metal(0.0);
        stage.shape(
            GeometryDesc::Rectangle,
            at(0.0, 0.0, 2.0) * down() * scale(3.0, 3.0, 1.0),
            mirror,
        );
        stage.point_light(v(0.3, 0.1, 1.0), 3.0);
        let view = look(v(0.0, 0.0, 1.9), v(0.0, 0.0, 0.0));
        stage.camera(parallel(1.0, 0.0, 1.0), view, [8, 8]);
        let scene = stage.build();
        // Of the window [-1, 1]²: ∫ cos/d² by the midpoint rule, for the lamp and its image.
        let n = 400;
        let mean: f64 = (0..n * n)
            .map(|k| {
                let x = ((k % n) as f64 + 0.5) / n as f64 * 2.0 - 1.0 - 0.3;
                let y = ((k / n) as f64 + 0.5) / n as f64 * 2.0 - 1.0 - 0.1;
                let e = |h: f64| 3.0 * h / (x * x + y * y + h * h).powf(1.5);
                e(1.0) + e(3.0)
            })
            .sum::<f64>()
            / f64::from(n * n);
        let truth = 0.5 / PI * mean;
        for texel in [0.002, 0.01] {
            let mut picture = RunningMean::new();
            let mut method = Backward::new(BackwardParams {
                photons: 20_000,
                texel,
                ..BackwardParams::default()
            });
            let frame = frame([8, 8], 1210 + i as u64);
            let workers = Workers::new(2, Arc::default()).expect("threads");
            method.prepare(&scene, &frame, &workers).expect("prepared");
            for index in 0..60 {
                let mut out = kaustika_film::accumulate::PassImage::new(8, 8, frame.layers.clone());
                method.pass(index, &scene, &frame, &mut out, &workers).expect("a pass");
                let stride = out.layers().stride();
                let sum: f64 = out.data().chunks(stride).map(|p| f64::from(p[0])).sum();
                picture.push(sum / 64.0);
            }
            agrees(&format!("{what}, texels of {texel}"), &picture, truth);
        }
    }
}

/// A ball of glass, one of frosted glass and a mirror over a floor, under a lamp.
fn balls() -> Stage {
    let mut stage = Stage::new();
    let (white, glass) = (stage.diffuse(0.5), stage.glass(1.5, 0.0));
    let two_sided = stage.two_sided(white);
    stage.shape(GeometryDesc::Rectangle, scale(3.0, 3.0, 1.0), two_sided);
    stage.shape(sphere(0.5), at(-0.6, 0.0, 0.6), glass);
    let frosted = stage.glass(1.4, 0.2);
    stage.shape(sphere(0.4), at(0.6, 0.4, 0.5), frosted);
    let mirror = stage.metal(0.0);
    let upright = at(0.0, 1.5, 0.5) * rotate(90.0, Vec3::X);
    stage.shape(GeometryDesc::Rectangle, upright * scale(1.5, 0.5, 1.0), mirror);
    stage.lamp(GeometryDesc::Rectangle, at(0.2, -0.3, 2.5) * down() * scale(0.4, 0.4, 1.0), 8.0);
    stage.camera(pinhole(70.0), look(v(0.1, -2.6, 1.8), v(0.0, 0.2, 0.2)), SIZE);
    stage
}

#[test]
fn caustics_are_those_of_path_tracing() {
    let scene = balls().build();
    let expressions = [FOUND, "LS+DS*E"];
    let path = layers(&scene, "path", json!({"max_depth": 8}), &expressions, 20_000, 1230);
    assert!(path[2].mean() > 0.05 * path[1].mean(), "little of a caustic");
    // Small texels, so that what they blur is nothing beside the noise.
    let p = json!({"texel": 0.001, "alpha": 1.0, "photons": 4000});
    let backward = means(&scene, "backward", p, 4000, 1231);
    same("all that backward ray tracing finds", &backward[4], &path[1]);
}

#[test]
fn a_clear_coat_is_seen_through() {
    // Diffuse scattering that is a product of functions of both directions: a varnished floor,
    // lit at grazing angles by way of a mirror.
    let mut stage = Stage::new();
    let (base, one) = (stage.d.float(0.6), stage.d.float(1.0));
    let varnished = stage.material(MaterialModel::Plastic {
        diffuse_reflectance: base,
        specular_reflectance: one,
        ior: 1.5,
        nonlinear: false,
        roughness: None,
    });
    stage.shape(GeometryDesc::Rectangle, scale(6.0, 6.0, 1.0), varnished);
    let mirror = stage.metal(0.0);
    stage.shape(GeometryDesc::Rectangle, at(0.0, 0.0, 0.8) * down() * scale(6.0, 6.0, 1.0), mirror);
    stage.lamp(GeometryDesc::Rectangle, at(-3.0, 0.0, 0.6) * scale(1.5, 1.5, 1.0), 8.0);
    stage.camera(parallel(1.0, 0.0, 1.0), look(v(1.5, 0.0, 0.7), v(1.5, 0.0, 0.0)), SIZE);
    let scene = stage.build();
    let path = layers(&scene, "path", json!({"max_depth": 4}), &[FOUND, "LS+DE"], 8000, 1240);
    assert!(path[2].mean() > 0.9 * path[1].mean(), "other light than by the mirror");
    // Nothing is fine here that wide texels could blur.
    let p = json!({"texel": 0.02, "alpha": 1.0, "photons": 10_000, "max_depth": 4});
    same("varnished floor", &means(&scene, "backward", p, 500, 1241)[4], &path[1]);
}

#[test]
fn crops_have_the_light_of_the_whole_picture() {
    let scene = balls().build();
    let workers = Workers::new(2, Arc::default()).expect("threads");
    let picture = |region: [u32; 4]| {
        let mut frame = frame(SIZE, 1250);
        frame.region = region;
        let mut method = Backward::new(BackwardParams::default());
        method.prepare(&scene, &frame, &workers).expect("prepared");
        let [w, h] = frame.size();
        let mut out = kaustika_film::accumulate::PassImage::new(w, h, frame.layers.clone());
        method.pass(3, &scene, &frame, &mut out, &workers).expect("a pass");
        out.data().to_vec()
    };
    let (whole, crop) = (picture([0, 0, SIZE[0], SIZE[1]]), picture([0, 5, SIZE[0], SIZE[1]]));
    assert_eq!(whole[whole.len() - crop.len()..], crop[..]);
}
