//! Paths side by side and one after the other: the same picture, bit for bit.

use crate::placing::stages;
use crate::scenes::*;
use kaustika_film::FilterDesc;
use kaustika_film::accumulate::{Feature, Layers, PassImage};
use kaustika_math::Vec3;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::Scene;
use kaustika_scene::description::{MaterialModel, ShapeDesc};
use kaustika_transport::path::PathTracer;
use kaustika_transport::{Frame, Method, PassStats, Workers};
use serde_json::json;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A pass of a picture wider than a wave has paths in a row, and the rays it took.
fn pass(scene: &Scene, features: &[Feature], side_by_side: bool) -> (PassImage, PassStats) {
    let resolution = [150, 9];
    let kind = SamplerKind::Sobol;
    let config = SamplerConfig { kind, seed: 5, spp: 4, resolution };
    let mut frame = Frame::new(resolution, FilterDesc::BOX, config);
    frame.layers = Layers::new(features);
    let workers = Workers::new(2, Arc::new(AtomicBool::new(false))).expect("threads");
    let mut image = PassImage::new(resolution[0], resolution[1], frame.layers.clone());
    let mut method =
        PathTracer::new(params(json!({ "max_depth": 12 }))).with_paths_side_by_side(side_by_side);
    let commit = method.pass(3, scene, &frame, &mut image, &workers).expect("a pass");
    (image, commit.stats)
}

fn camera(stage: &mut Stage) {
    stage.camera(pinhole(50.0), look(v(0.0, -3.5, 1.8), v(0.0, 0.2, 0.2)), [150, 9]);
}

fn check(scene: &Scene) {
    for features in [&[][..], &[Feature::Normal, Feature::Depth, Feature::ShapeId]] {
        let (together, s) = pass(scene, features, true);
        let (alone, t) = pass(scene, features, false);
        assert!(s.closest_rays > 2 * 150 * 9 && s.shadow_rays > 500, "{s:?}");
        assert_eq!((s.closest_rays, s.shadow_rays), (t.closest_rays, t.shadow_rays));
        assert!(together == alone, "the pictures differ");
    }
}

#[test]
fn with_cut_outs_and_instances() {
    let (flat, instanced) = stages();
    for mut stage in [flat, instanced] {
        camera(&mut stage);
        check(&stage.build());
    }
}

#[test]
fn through_interfaces_and_a_fine_mesh() {
    let mut stage = Stage::new();
    floor(&mut stage);
    stage.sky(0.3);
    stage.lamp(disk(0.5), at(0.0, 0.0, 2.5) * down(), 6.0);
    let veil = stage.material(MaterialModel::Null { counts: false });
    stage.d.shapes.push(shape(sphere(0.6), at(0.4, 0.0, 0.6), veil));
    // A bumpy square of 80 000 triangles.
    let n = 200;
    let point = |i: u32| {
        let (x, y) = ((i % (n + 1)) as f32 / n as f32, (i / (n + 1)) as f32 / n as f32);
        v(2.0 * x - 1.0, 2.0 * y - 1.0, 0.2 + 0.1 * (20.0 * x).sin() * (17.0 * y).cos())
    };
    let points: Vec<Vec3> = (0..(n + 1) * (n + 1)).map(point).collect();
    let triangles: Vec<[u32; 3]> = (0..n * n)
        .flat_map(|i| {
            let a = i / n * (n + 1) + i % n;
            [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
        })
        .collect();
    let grey = stage.diffuse(0.6);
    let ground: ShapeDesc = shape(mesh(&points, &triangles), HERE, grey);
    stage.d.shapes.push(ground);
    camera(&mut stage);
    let scene = stage.build();
    assert!(scene.geometry.outgrows_caches());
    check(&scene);
}
