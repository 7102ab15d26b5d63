//! Metropolis chains that start afresh now and then: right on average, and surer of the picture's brightness.

use crate::bidirectional::{agree, means, renders, room};
use crate::breaks::threads_and_breaks;
use crate::scenes::*;
use kaustika_film::FilterDesc;
use kaustika_film::accumulate::PassImage;
use kaustika_sampling::estimator::RunningMean;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::Scene;
use kaustika_scene::description::*;
use kaustika_transport::metropolis::paths::Mlt;
use kaustika_transport::metropolis::primary::PrimarySpace;
use kaustika_transport::{Frame, Workers, registry};
use serde_json::{Value, json};
use std::sync::Arc;

const CHAINS: [&str; 3] = ["pssmlt", "mmlt", "mlt"];

/// A room under a lamp.
fn plain() -> Stage {
    let mut stage = room();
    stage.lamp(GeometryDesc::Rectangle, at(0.2, 0.1, 1.7) * down() * scale(0.3, 0.2, 1.0), 8.0);
    stage
}

/// With a ball of glass.
fn scene() -> Scene {
    let mut stage = plain();
    let glass = stage.glass(1.5, 0.0);
    stage.shape(sphere(0.25), at(0.45, -0.2, 0.26), glass);
    stage.build()
}

/// Few candidates, so that some hundred passes are many generations.
fn few(renew: u32) -> Value {
    json!({"max_depth": 4, "bootstrap": 256, "brightness_error": 1.0, "chains": 32, "renew": renew})
}

#[test]
fn generations_agree_with_bdpt() {
    let scene = scene();
    let bdpt = means(&scene, "bdpt", json!({"max_depth": 4}), 3000, 7100);
    for (i, method) in CHAINS.into_iter().enumerate() {
        let chains = renders(&scene, method, few(1), 100, 7110 + i as u64);
        agree(method, &chains, &bdpt);
    }
    let mut lens = few(1);
    lens["mutations"] = "lens".into();
    agree("lens", &renders(&scene, "mlt", lens, 100, 7120), &bdpt);
}

#[test]
fn generations_tell_brightness() {
    // Chains of one generation all have the b that 256 candidates tell. F(11, 11) exceeds 20 with a probability of 10⁻⁵.
    let scene = plain().build();
    let spread = |method: &str, renew: u32| {
        let mut p = few(renew);
        p["direct"] = "together".into();
        let means = renders(&scene, method, p, 300, 7200);
        means[4].variance()
    };
    // Of `mlt`, whose candidates differ less, chains have most of what is left: it is left out.
    for method in ["pssmlt", "mmlt"] {
        let (one, many) = (spread(method, 0), spread(method, 1));
        assert!(one > 20.0 * many, "{method}: {one} {many}");
    }
}

#[test]
fn generations_depend_neither_on_threads_nor_on_breaks() {
    let scene = scene();
    let primary = || serde_json::from_value(few(1)).expect("sound");
    threads_and_breaks(&scene, || PrimarySpace::new(primary()), 5, &[1, 4]);
    threads_and_breaks(&scene, || PrimarySpace::multiplexed(primary()), 5, &[1, 4]);
    let path = || Mlt::new(serde_json::from_value(few(1)).expect("sound"));
    threads_and_breaks(&scene, path, 5, &[1, 4]);
}

/// What a method says after some passes.
fn remarks(scene: &Scene, method: &str, bootstrap: u64, passes: u64) -> Vec<String> {
    let size = [16, 16];
    let workers = Workers::new(2, Arc::default()).expect("threads");
    let kind = SamplerKind::Independent;
    let config = SamplerConfig { kind, seed: 7300, spp: passes, resolution: size };
    let frame = Frame::new(size, FilterDesc::BOX, config);
    let p = match method {
        "erpt" => json!({"max_depth": 4, "bootstrap": bootstrap, "guiding": false}),
        _ => {
            json!({"max_depth": 4, "bootstrap": bootstrap, "brightness_error": 1.0, "renew": 0})
        }
    };
    let Value::Object(p) = p else { panic!("an object") };
    let mut method = (registry::find(method).expect("known").make)(&p).expect("sound");
    method.prepare(scene, &frame, &workers).expect("prepared");
    for index in 0..passes {
        let mut image = PassImage::new(size[0], size[1], frame.layers.clone());
        method.pass(index, scene, &frame, &mut image, &workers).expect("a pass");
    }
    method.remarks()
}

#[test]
fn brightness_that_few_candidates_tell_is_warned_of() {
    let warned = |scene: &Scene, method: &str, bootstrap: u64, passes: u64| {
        let remarks = remarks(scene, method, bootstrap, passes);
        remarks.iter().any(|r| r.starts_with("warning: few of"))
    };
    let plain = plain().build();
    for method in CHAINS {
        assert!(warned(&plain, method, 64, 2), "{method}");
        assert!(!warned(&plain, method, 1 << 15, 2), "{method}");
    }
    // `erpt` has a candidate for each pixel and pass.
    assert!(!warned(&plain, "erpt", 64, 128));
    assert!(warned(&scene(), "erpt", 64, 1));
}

#[test]
fn generations_are_told() {
    let scene = scene();
    let entry = registry::find("mlt").expect("known");
    let Value::Object(p) = few(2) else { panic!("an object") };
    let mut method = (entry.make)(&p).expect("sound");
    let size = [32, 32];
    let workers = Workers::new(2, Arc::default()).expect("threads");
    let kind = SamplerKind::Independent;
    let config = SamplerConfig { kind, seed: 7400, spp: 8, resolution: size };
    let frame = Frame::new(size, FilterDesc::BOX, config);
    method.prepare(&scene, &frame, &workers).expect("prepared");
    let mut brightness = RunningMean::new();
    let value = |report: Vec<(String, f64)>, key: &str| {
        report.into_iter().find(|(k, _)| k == key).expect("reported").1
    };
    for index in 0..4 {
        let mut image = PassImage::new(size[0], size[1], frame.layers.clone());
        method.pass(index, &scene, &frame, &mut image, &workers).expect("a pass");
        let report = method.report();
        // 4 x 1024 steps a pass, of 256 candidates: every pass begins afresh.
        assert_eq!(value(report.clone(), "generations"), (index + 1) as f64);
        assert_eq!(value(report.clone(), "candidates"), 256.0 * (index + 1) as f64);
        brightness.push(value(report, "brightness"));
    }
    assert!(method.remarks()[0].contains("in 4 generations"), "{:?}", method.remarks());
}

/// Passes of chains with 1024 candidates, of 1024 steps each: before every pass, how many candidates tell the error, generations so
/// far, and the rays that steps and candidates took.
fn generations(method: &str, passes: u64) -> Vec<[f64; 4]> {
    let scene = scene();
    let mut p = few(4);
    (p["bootstrap"], p["steps"]) = (1024.into(), 1.into());
    let Value::Object(p) = p else { panic!("an object") };
    let mut method = (registry::find(method).expect("known").make)(&p).expect("sound");
    let size = [32, 32];
    let workers = Workers::new(2, Arc::default()).expect("threads");
    let kind = SamplerKind::Independent;
    let config = SamplerConfig { kind, seed: 7500, spp: passes, resolution: size };
    let frame = Frame::new(size, FilterDesc::BOX, config);
    method.prepare(&scene, &frame, &workers).expect("prepared");
    let mut told = Vec::new();
    for index in 0..passes {
        let report = method.report();
        told.push(
            ["candidates_that_tell_the_error", "generations", "steps.rays", "candidates.rays"]
                .map(|key| report.iter().find(|(k, _)| k == key).expect("reported").1),
        );
        let mut image = PassImage::new(size[0], size[1], frame.layers.clone());
        method.pass(index, &scene, &frame, &mut image, &workers).expect("a pass");
    }
    told
}

#[test]
fn generations_hurry_as_long_as_candidates_are_too_few() {
    // Generations last four passes; as long as fewer than 128 candidates tell the error, until their steps took as many rays
    // as their candidates.
    for (method, passes) in [("pssmlt", 60), ("mlt", 90)] {
        let told = generations(method, passes);
        let starts: Vec<usize> =
            (1..told.len()).filter(|&k| k == 1 || told[k][1] > told[k - 1][1]).collect();
        // `told[k]` is of after a generation's first pass, for each `k` of `starts`.
        let (mut hasty, mut calm) = (0, 0);
        for pair in starts.windows(2) {
            let [begun, next] = [pair[0], pair[1]].map(|k| &told[k - 1]);
            let lasted = pair[1] - pair[0];
            // Rays of this generation's steps and candidates.
            let steps = next[2] - begun[2];
            let candidates = told[pair[0]][3] - if pair[0] == 1 { 0.0 } else { begun[3] };
            match next[0] < 128.0 && lasted < 4 {
                true => {
                    hasty += 1;
                    assert!(steps >= candidates, "{method}: {steps} rays, {candidates}");
                    // No pass later than could be.
                    let last = next[2] - told[pair[1] - 2][2];
                    assert!(lasted == 1 || steps - last < candidates, "{method}: {pair:?}");
                }
                false => {
                    calm += 1;
                    assert_eq!(lasted, 4, "{method}: {pair:?}");
                }
            }
        }
        assert!(hasty > 1 && calm > 1, "{method}: {hasty} {calm}");
    }
}
