//! Metropolis light transport agrees with bidirectional path tracing.
//!
//! Passes of a chain depend on each other; whole renders with seeds of their own do not. Each
//! comparison is between means of independent renders and independent passes.

use crate::bidirectional::{Light, SIZE, agree, means, renders, room};
use crate::scenes::*;
use crate::stats::level;
use kaustika_film::FilterDesc;
use kaustika_film::accumulate::PassImage;
use kaustika_math::special::p_two_sided;
use kaustika_sampling::estimator::RunningMean;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::Scene;
use kaustika_scene::description::*;
use kaustika_transport::{Frame, Workers, registry};
use serde_json::{Value, json};
use std::sync::Arc;

/// Parameters for small pictures, whose chains are of one generation.
fn with(p: Value) -> Value {
    let mut all = json!({"bootstrap": 4096, "brightness_error": 1.0, "chains": 32, "renew": 0});
    let Value::Object(more) = p else { panic!("an object") };
    all.as_object_mut().expect("an object").extend(more);
    all
}

/// A room with a lamp, a glossy block and a ball of glass, seen through a lens.
fn glass_room() -> Scene {
    let mut stage = room();
    let glass = stage.glass(1.5, 0.0);
    stage.shape(sphere(0.25), at(0.45, -0.2, 0.26), glass);
    stage.lamp(GeometryDesc::Rectangle, at(0.2, 0.1, 1.7) * down() * scale(0.8, 0.8, 1.0), 2.0);
    stage.camera(thin_lens(60.0, 0.1, 2.5), look(v(0.1, -2.6, 1.0), v(0.0, 0.0, 0.7)), SIZE);
    stage.build()
}

#[test]
fn primary_sample_space_agrees_with_bdpt() {
    let scene = glass_room();
    let bdpt = means(&scene, "bdpt", json!({"max_depth": 5}), 3000, 4000);
    // The test can see a fault of a few per cent.
    let error = bdpt[4].standard_error() / bdpt[4].mean();
    assert!(error < 1e-2, "{error}");
    let cases = [
        ("pssmlt", json!({"max_depth": 5})),
        ("pssmlt", json!({"max_depth": 5, "direct": "together"})),
        ("pssmlt", json!({"max_depth": 5, "over": "path"})),
        ("pssmlt", json!({"max_depth": 5, "large_step": 1.0, "adapt": false})),
        ("mmlt", json!({"max_depth": 5})),
        ("mmlt", json!({"max_depth": 5, "direct": "together", "large_step": 0.5})),
    ];
    for (i, (method, p)) in cases.into_iter().enumerate() {
        let what = format!("{method} {p}");
        let chains = renders(&scene, method, with(p), 150, 4010 + i as u64);
        agree(&what, &chains, &bdpt);
    }
}

#[test]
fn primary_sample_space_agrees_with_bdpt_under_other_lights() {
    let lights: [(&str, Light); 3] = [
        ("point", Box::new(|s| s.point_light(v(0.4, -0.2, 1.3), 2.0))),
        ("sky", Box::new(|s| s.sky(0.7))),
        (
            "parallel",
            Box::new(|s| {
                let irradiance = grey(2.0);
                let kind = LightKind::Directional { irradiance, scale: 1.0, illuminance: None };
                s.light(kind, rotate(150.0, v(1.0, 0.3, 0.1)));
            }),
        ),
    ];
    for (i, (what, light)) in lights.into_iter().enumerate() {
        let mut stage = room();
        light(&mut stage);
        let scene = stage.build();
        let seed = 4100 + 10 * i as u64;
        let bdpt = means(&scene, "bdpt", json!({"max_depth": 4}), 800, seed);
        for (j, method) in ["pssmlt", "mmlt", "mlt"].into_iter().enumerate() {
            let p = with(json!({"max_depth": 4}));
            agree(what, &renders(&scene, method, p, 100, seed + 1 + j as u64), &bdpt);
        }
    }
}

/// The mean of a picture, as the sum of those of its quarters.
fn parts(image: &PassImage, size: [u32; 2]) -> [f64; 5] {
    let mut sums = [0.0; 5];
    for (i, pixel) in image.data().chunks(image.layers().stride()).enumerate() {
        let (x, y) = (i as u32 % size[0], i as u32 / size[0]);
        let quarter = 2 * usize::from(2 * y >= size[1]) + usize::from(2 * x >= size[0]);
        let grey = f64::from(pixel[0] + pixel[1] + pixel[2]) / f64::from(size[0] * size[1]);
        sums[quarter] += grey;
        sums[4] += grey;
    }
    sums
}

/// The means of the picture and its quarters, of independent renders of one pass with 20,000 chains
/// of one step each.
fn short_chains(scene: &Scene, p: &Value, size: [u32; 2], seed: u64) -> Vec<RunningMean> {
    let mut means = vec![RunningMean::new(); 5];
    let workers = Workers::new(2, Arc::default()).expect("threads");
    for k in 0..12 {
        let seed = 100 * seed + k;
        let kind = SamplerKind::Independent;
        let config = SamplerConfig { kind, seed, spp: 1, resolution: size };
        let frame = Frame::new(size, FilterDesc::BOX, config);
        let Value::Object(p) = p else { panic!("an object") };
        let mut method = (registry::find("pssmlt").expect("known").make)(p).expect("sound");
        method.prepare(scene, &frame, &workers).expect("prepared");
        let mut image = PassImage::new(size[0], size[1], frame.layers.clone());
        method.pass(0, scene, &frame, &mut image, &workers).expect("a pass");
        let sums = parts(&image, size);
        means.iter_mut().zip(sums).for_each(|(m, s)| m.push(s));
    }
    means
}

#[test]
fn many_short_chains_are_right_if_their_starts_are_resampled() {
    let size = [160, 125];
    let mut stage = room();
    stage.lamp(GeometryDesc::Rectangle, at(0.2, 0.1, 1.7) * down() * scale(0.3, 0.2, 1.0), 8.0);
    stage.camera(pinhole(60.0), look(v(0.1, -2.6, 1.0), v(0.0, 0.0, 0.7)), size);
    let scene = stage.build();
    let p = |startup: &str, discard: u32| {
        json!({
            "max_depth": 3, "chains": 20_000, "bootstrap": 8192, "brightness_error": 1.0, "direct": "together",
            "startup": startup, "discard": discard, "adapt": false, "large_step": 0.05,
        })
    };
    let mut reference = vec![RunningMean::new(); 5];
    let workers = Workers::new(2, Arc::default()).expect("threads");
    let kind = SamplerKind::Independent;
    let config = SamplerConfig { kind, seed: 4299, spp: 12, resolution: size };
    let frame = Frame::new(size, FilterDesc::BOX, config);
    let Value::Object(q) = json!({"max_depth": 3}) else { panic!("an object") };
    let mut bdpt = (registry::find("bdpt").expect("known").make)(&q).expect("sound");
    bdpt.prepare(&scene, &frame, &workers).expect("prepared");
    for index in 0..12 {
        let mut image = PassImage::new(size[0], size[1], frame.layers.clone());
        bdpt.pass(index, &scene, &frame, &mut image, &workers).expect("a pass");
        let sums = parts(&image, size);
        reference.iter_mut().zip(sums).for_each(|(m, s)| m.push(s));
    }
    let resampled = short_chains(&scene, &p("resample", 0), size, 42);
    agree("resampled", &resampled, &reference);
    // Started anywhere the picture's parts are wrong, less so the more steps are left out.
    let off = |discard: u32| {
        let means = short_chains(&scene, &p("discard", discard), size, 43);
        let score = |(a, b): (&RunningMean, &RunningMean)| {
            (a.mean() - b.mean()).abs() / a.standard_error().hypot(b.standard_error())
        };
        let worst = means.iter().zip(&reference).map(score).fold(0.0, f64::max);
        let relative = (means[1].mean() / reference[1].mean() - 1.0).abs();
        (p_two_sided(worst), relative)
    };
    let (p_0, bias_0) = off(0);
    let (_, bias_8) = off(8);
    assert!(p_0 < level(), "{p_0}");
    assert!(bias_8 < bias_0, "{bias_8} {bias_0}");
}

#[test]
fn energy_redistribution_agrees_with_bdpt() {
    let scene = glass_room();
    let bdpt = means(&scene, "bdpt", json!({"max_depth": 4}), 3000, 4500);
    let cases = [
        json!({"max_depth": 4, "chain_length": 20}),
        json!({"max_depth": 4, "chain_length": 3, "direct": "together"}),
        json!({"max_depth": 4, "chain_length": 50, "mutations": "all"}),
        // Light is neither lost nor made if b is not known well.
        json!({"max_depth": 4, "chain_length": 20, "bootstrap": 50}),
    ];
    for (i, p) in cases.into_iter().enumerate() {
        // Passes are independent.
        agree(&format!("erpt {p}"), &means(&scene, "erpt", p, 3000, 4510 + i as u64), &bdpt);
    }
}

#[test]
fn path_space_agrees_with_bdpt() {
    let scene = glass_room();
    let bdpt = means(&scene, "bdpt", json!({"max_depth": 4}), 3000, 4300);
    let cases = [
        json!({"max_depth": 4}),
        json!({"max_depth": 4, "direct": "together"}),
        json!({"max_depth": 4, "mutations": "bidirectional"}),
        // Whatever a chain can't reach, its start was right on average, and stays so.
        json!({"max_depth": 4, "mutations": "lens"}),
        json!({"max_depth": 4, "mutations": "caustic", "direct": "together"}),
        json!({"max_depth": 4, "mutations": "multichain"}),
        json!({"max_depth": 4, "mutations": "subpath"}),
        json!({"max_depth": 4, "mutations": "manifold"}),
        json!({"max_depth": 4, "mutations": "lens+caustic+multichain", "direct": "together"}),
    ];
    for (i, p) in cases.into_iter().enumerate() {
        let mut p = with(p);
        p["chains"] = 96.into();
        p["bootstrap"] = 20_000.into();
        let chains = renders(&scene, "mlt", p.clone(), 300, 4310 + i as u64);
        agree(&format!("mlt {p}"), &chains, &bdpt);
    }
}
