//! What Metropolis methods say of their errors is true.

use crate::bidirectional::room;
use crate::scenes::*;
use kaustika_film::FilterDesc;
use kaustika_film::accumulate::{PassImage, PassTree};
use kaustika_sampling::estimator::RunningMean;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::Scene;
use kaustika_scene::description::*;
use kaustika_transport::{Frame, Method, Workers, registry};
use serde_json::{Value, json};
use std::sync::Arc;

const SIZE: [u32; 2] = [48, 32];
/// Tiles of 16 x 16 pixels.
const TILES: usize = 6;

/// Under a lamp of this radiance.
fn lamp_room(radiance: f32) -> Scene {
    let mut stage = room();
    let glass = stage.glass(1.5, 0.0);
    stage.shape(sphere(0.25), at(0.45, -0.2, 0.26), glass);
    stage.lamp(
        GeometryDesc::Rectangle,
        at(0.2, 0.1, 1.7) * down() * scale(0.3, 0.2, 1.0),
        radiance,
    );
    stage.camera(pinhole(60.0), look(v(0.1, -2.6, 1.0), v(0.0, 0.0, 0.7)), SIZE);
    stage.build()
}

fn render(
    scene: &Scene,
    method: &str,
    p: &Value,
    passes: u64,
    seed: u64,
) -> (Box<dyn Method>, PassTree) {
    let Value::Object(p) = p else { panic!("an object") };
    let workers = Workers::new(2, Arc::default()).expect("threads");
    let config =
        SamplerConfig { kind: SamplerKind::Independent, seed, spp: passes, resolution: SIZE };
    let frame = Frame::new(SIZE, FilterDesc::BOX, config);
    let mut method = (registry::find(method).expect("known").make)(p).expect("sound");
    method.prepare(scene, &frame, &workers).expect("prepared");
    let mut tree = PassTree::new(SIZE[0], SIZE[1], frame.layers.clone());
    for index in 0..passes {
        let mut image = PassImage::new(SIZE[0], SIZE[1], frame.layers.clone());
        method.pass(index, scene, &frame, &mut image, &workers).expect("a pass");
        tree.push(index, image).expect("fits");
    }
    (method, tree)
}

/// Of each tile the mean of green, its reported error, and the one that passes would tell.
fn tiles((method, tree): (Box<dyn Method>, PassTree)) -> [[f64; 3]; TILES] {
    let total = tree.total().expect("passes");
    let trust = method.trust().expect("groups of chains");
    let (_, layer) = trust.layers.iter().find(|(name, _)| name == "TileError.G").expect("a layer");
    let mut tiles = [[0.0; 3]; TILES];
    for i in 0..(SIZE[0] * SIZE[1]) as usize {
        let (x, y) = (i % 48 / 16, i / 48 / 16);
        let [mean, error, passes] = &mut tiles[3 * y + x];
        *mean += f64::from(total.rgb(i)[1]) / 256.0;
        *error = f64::from(layer[i]);
        *passes += f64::from(total.variance(i)[1]) / total.passes as f64 / 65536.0;
    }
    tiles.map(|[mean, error, passes]| [mean, error, passes.sqrt()])
}

/// χ² a degree of freedom of independent renders' tiles, against their reported errors and against
/// those that passes would tell.
fn chi_squares(scene: &Scene, method: &str, p: &Value, seed: u64) -> [f64; 2] {
    let renders = 48;
    let all: Vec<_> =
        (0..renders).map(|k| tiles(render(scene, method, p, 40, 100 * seed + k))).collect();
    let mut chi = [0.0; 2];
    for t in 0..TILES {
        let mut mean = RunningMean::new();
        all.iter().for_each(|tiles| mean.push(tiles[t][0]));
        for tiles in &all {
            let [x, error, passes] = tiles[t];
            chi[0] += ((x - mean.mean()) / error).powi(2);
            chi[1] += ((x - mean.mean()) / passes).powi(2);
        }
    }
    chi.map(|c| c / ((renders - 1) as f64 * TILES as f64))
}

#[test]
fn reported_errors_are_those_of_independent_renders() {
    // With 16 groups χ² is 15/13 on average; over 282 degrees of freedom it strays from that by a tenth.
    let scene = lamp_room(8.0);
    for (i, method) in ["pssmlt", "mmlt", "mlt"].into_iter().enumerate() {
        let p = json!({"max_depth": 5, "steps": 1, "chains": 128, "bootstrap": 16384, "brightness_error": 1.0});
        let [groups, passes] = chi_squares(&scene, method, &p, 700 + i as u64);
        assert!((0.7..1.4).contains(&groups), "{method}: {groups}");
        // Had passes been taken as independent, the errors would be too small.
        assert!(passes > 1.8, "{method}: {passes}");
    }
}

#[test]
fn chains_that_keep_to_parts_are_told() {
    let scene = lamp_room(8.0);
    let warns = |method: &str, renew: u32, p: Value| {
        let mut all =
            json!({"max_depth": 5, "steps": 1, "chains": 32, "bootstrap": 4096, "renew": renew});
        let Value::Object(more) = p else { panic!("an object") };
        all.as_object_mut().expect("an object").extend(more);
        let (method, _) = render(&scene, method, &all, 40, 730);
        let remarks = method.remarks();
        assert!(
            remarks.len() <= 5 && remarks[0].contains("32 chains of 1920 steps"),
            "{remarks:?}"
        );
        remarks.iter().any(|r| r.starts_with("warning: chains keep"))
    };
    // Of one generation, and of some twenty or five short ones.
    let warned = |method: &str, p: Value| {
        let all = [0, 1, 3].map(|renew| warns(method, renew, p.clone()));
        assert!(all == [all[0]; 3], "{method}: {all:?}");
        all[0]
    };
    for method in ["pssmlt", "mmlt", "mlt"] {
        assert!(!warned(method, json!({})), "{method}");
    }
    assert!(warned("mlt", json!({"mutations": "lens+caustic+multichain"})));
    let small = json!({"large_step": 1e-6, "small_step": 1e-3, "adapt": false});
    let mut over_path = small.clone();
    over_path["over"] = "path".into();
    assert!(warned("mmlt", small.clone()));
    assert!(warned("pssmlt", small));
    assert!(warned("pssmlt", over_path));
}

#[test]
fn light_that_is_no_number_is_refused_and_counted() {
    // Products of such a lamp's radiance are often too large for a number; those of the second are for the film, too.
    for (method, radiance) in [("pssmlt", 1e37), ("mmlt", 1e37), ("mlt", 3e38), ("erpt", 3e38)] {
        let p = json!({"max_depth": 3, "direct": "together", "bootstrap": 4096});
        let (made, tree) = render(&lamp_room(radiance), method, &p, 4, 750);
        let report = made.report();
        let refused = report.iter().find(|(k, _)| k == "not_numbers").expect("reported").1;
        assert!(refused > 0.0, "{method}");
        let total = tree.total().expect("passes");
        let pixels = (0..(SIZE[0] * SIZE[1]) as usize).map(|i| total.rgb(i));
        let sum: f64 = pixels.flatten().map(f64::from).sum();
        assert!(sum > 0.0 && (sum.is_finite() || radiance > 1e38), "{method}: {sum}");
    }
}
