//! Hybrids: terms that part the paths add up to the picture, and each is its class.

use crate::bidirectional::room;
use crate::breaks::threads_and_breaks;
use crate::classes::all_kinds;
use crate::scenes::*;
use crate::stats::{close, same};
use kaustika_film::FilterDesc;
use kaustika_film::accumulate::PassImage;
use kaustika_film::path_expression::{PathClasses, PathLayer};
use kaustika_math::Vec3;
use kaustika_sampling::estimator::RunningMean;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::Scene;
use kaustika_scene::description::GeometryDesc;
use kaustika_transport::hybrid::{Hybrid, INFO};
use kaustika_transport::{Frame, Method, Session, Workers, registry};
use serde_json::{Value, json};
use std::sync::Arc;

const SIZE: [u32; 2] = [24, 24];
/// Chen's classes (1991).
const CHEN: [&str; 3] = ["L[D]S*E", "LS+DS*E", "L(D|S)*DS*DS*E"];

fn made(method: &str, p: &Value) -> Box<dyn Method> {
    let Value::Object(p) = p else { panic!("an object") };
    (registry::find(method).expect("known").make)(p).expect("parameters")
}

/// The picture and its layers, those by path or those of the method: of each all pixels, grey, over
/// so many groups of passes.
pub(crate) fn pictures(
    scene: &Scene,
    (method, p): (&str, Value),
    expressions: &[&str],
    (size, groups, passes, seed): ([u32; 2], u64, u64, u64),
) -> Vec<Vec<RunningMean>> {
    let kind = SamplerKind::Independent;
    let config = SamplerConfig { kind, seed, spp: groups * passes, resolution: size };
    let mut frame = Frame::new(size, FilterDesc::BOX, config);
    let workers = Workers::new(2, Arc::default()).expect("threads");
    let mut method = made(method, &p);
    if !expressions.is_empty() {
        let parse = |(i, e): (usize, &&str)| PathLayer::parse(&format!("l{i}={e}")).expect(e);
        let parsed = expressions.iter().enumerate().map(parse).collect();
        frame.keep_paths(PathClasses::new(parsed).expect("layers"));
    }
    frame.keep_layers(&method.layers());
    method.prepare(scene, &frame, &workers).expect("prepared");
    let layers = frame.layers.paths().len() + 1;
    let pixels = (size[0] * size[1]) as usize;
    let mut means = vec![vec![RunningMean::new(); pixels]; layers];
    for group in 0..groups {
        let mut image = PassImage::new(size[0], size[1], frame.layers.clone());
        for pass in group * passes..(group + 1) * passes {
            method.pass(pass, scene, &frame, &mut image, &workers).expect("a pass");
        }
        for (i, pixel) in image.data().chunks(image.layers().stride()).enumerate() {
            for (k, mean) in means.iter_mut().enumerate() {
                let at = k.checked_sub(1).map_or(0, |k| image.layers().path_offset(k));
                let rgb = pixel[at] + pixel[at + 1] + pixel[at + 2];
                mean[i].push(f64::from(rgb) / (3.0 * f64::from(pixel[3])));
            }
        }
    }
    means
}

/// Relative L2 of a picture against a true one, the noise of both taken off.
fn error(picture: &[RunningMean], truth: &[RunningMean]) -> f64 {
    let pairs = || picture.iter().zip(truth);
    let noise = |m: &RunningMean| match m.standard_error() {
        e if e.is_finite() => e * e,
        _ => 0.0,
    };
    let sum: f64 = pairs().map(|(a, b)| (a.mean() - b.mean()).powi(2) - noise(a) - noise(b)).sum();
    let all: f64 = truth.iter().map(|t| t.mean().powi(2)).sum();
    (sum.max(0.0) / all).sqrt()
}

pub(crate) fn mean(picture: &[RunningMean]) -> RunningMean {
    let n = picture.len() as f64;
    let mean = picture.iter().map(RunningMean::mean).sum::<f64>() / n;
    let variance: f64 = picture.iter().map(|p| p.standard_error().powi(2)).sum();
    with_error(mean, variance.sqrt() / n)
}

/// With a picture of this size.
fn sized(mut stage: Stage) -> Stage {
    stage.d.cameras[0].film.resolution = SIZE;
    stage
}

/// The inside of a matte box with a lamp, a glass ball and a mirror.
pub(crate) fn small_room() -> Stage {
    let mut stage = Stage::new();
    let (white, red) = (stage.diffuse(0.5), stage.diffuse(0.8));
    stage.shape(GeometryDesc::Cube, HERE, white).flip_normals = true;
    stage.shape(GeometryDesc::Rectangle, at(0.0, 0.0, -0.99) * scale(0.9, 0.9, 1.0), red);
    let (glass, mirror) = (stage.glass(1.5, 0.0), stage.metal(0.0));
    stage.shape(sphere(0.3), at(0.3, 0.2, -0.5), glass);
    stage.shape(
        GeometryDesc::Rectangle,
        at(-0.98, 0.3, -0.2) * rotate(90.0, Vec3::Y) * scale(0.5, 0.4, 1.0),
        mirror,
    );
    stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, 0.99) * down() * scale(0.3, 0.3, 1.0), 10.0);
    stage.camera(pinhole(75.0), look(v(0.2, -0.95, 0.3), v(-0.1, 0.3, -0.35)), SIZE);
    stage
}

/// The room without the glass ball, and its lamp in the mirror.
fn mirror_room() -> Stage {
    let mut stage = small_room();
    stage.d.shapes.remove(2);
    stage
}

/// The same samples: terms of one method are its layers, and add up to its picture.
#[test]
fn terms_of_one_method_are_its_layers() {
    let scene = sized(all_kinds()).build();
    let of = (SIZE, 2, 4, 3);
    let [a, b, c] = CHEN;
    let terms = format!("A=path:{a}; B=path:{b}; C=path:{c}");
    let hybrid = pictures(&scene, ("hybrid", json!({"terms": terms})), &[], of);
    let path = pictures(&scene, ("path", json!({})), &CHEN, of);
    for (k, (ours, theirs)) in hybrid.iter().zip(&path).enumerate() {
        assert!(mean(ours).mean() > 0.0);
        for (a, b) in ours.iter().zip(theirs) {
            let difference = (a.mean() - b.mean()).abs();
            assert!(difference <= 1e-5 * b.mean().max(0.01), "{k}: {} {}", a.mean(), b.mean());
        }
    }
}

/// Each class by a method of its own, and features by the first.
#[test]
fn methods_share_the_paths() {
    let scene = sized(all_kinds()).build();
    let terms = "path:LE; bdpt:L(D|S)*S_ME; light:L(D|S)*(D|S_G)E";
    let shared = pictures(&scene, ("hybrid", json!({"terms": terms})), &[], (SIZE, 40, 10, 4));
    let path = pictures(&scene, ("path", json!({})), &[], (SIZE, 40, 10, 5));
    same("the picture", &mean(&shared[0]), &mean(&path[0]));
    let sum: f64 = shared[1..].iter().map(|layer| mean(layer).mean()).sum();
    close("the terms", sum, mean(&shared[0]).mean(), 1e-5);
    for layer in &shared[1..] {
        assert!(mean(layer).mean() > 0.0);
    }
}

/// Fails unless two means differ by no more than this share and four standard errors.
#[track_caller]
fn near(what: &str, a: &[RunningMean], b: &[RunningMean], share: f64) {
    let (a, b) = (mean(a), mean(b));
    let noise = a.standard_error().hypot(b.standard_error());
    let difference = (a.mean() - b.mean()).abs();
    let most = share * b.mean() + 4.0 * noise;
    assert!(difference < most, "{what}: {} and {} ± {noise}", a.mean(), b.mean());
}

/// A class that a method has alone, and the rest by another.
#[test]
fn radiosity_has_the_matte_paths_and_path_tracing_the_others() {
    let scene = small_room().build();
    let truth = pictures(&scene, ("bdpt", json!({})), &["LD*E"], (SIZE, 20, 20, 6));
    let terms = "radiosity(patches=4000, display=gather):LD*E; path:LD*S(D|S)*E";
    let shared = pictures(&scene, ("hybrid", json!({"terms": terms})), &[], (SIZE, 40, 10, 7));
    let e = error(&shared[1], &truth[1]);
    assert!(e < 0.03, "{e}");
    near("the picture", &shared[0], &truth[0], 0.02);
}

/// Chen's A, B and C are the layers of these classes, C within what its patches allow: relative L2,
/// noise taken off, at most 3 % at the finest mesh, and falling by half for four times the patches.
#[test]
fn chen_is_the_picture_class_by_class() {
    let scene = small_room().build();
    let truth = pictures(&scene, ("bdpt", json!({})), &CHEN, (SIZE, 20, 30, 1));
    let chen = |terms: &str, patches: u32, seed| {
        let p = json!({"patches": patches, "terms": terms, "photons": 20_000});
        pictures(&scene, ("chen", p), &[], (SIZE, 16, 8, seed))
    };
    let meshes = [300, 1200, 4800].map(|patches| chen("chen", patches, 2));
    let finest = &meshes[2];
    same("A", &mean(&finest[1]), &mean(&truth[1]));
    near("B", &finest[2], &truth[2], 0.02);
    near("C", &finest[3], &truth[3], 0.02);
    near("A + B + C", &finest[0], &truth[0], 0.01);
    let sum: f64 = finest[1..].iter().map(|term| mean(term).mean()).sum();
    close("the terms", sum, mean(&finest[0]).mean(), 1e-5);
    let of = |k: usize| meshes.each_ref().map(|found| error(&found[k], &truth[k]));
    let (all, c) = (of(0), of(3));
    assert!(all[2] < 0.03 && c[2] < 0.03, "{all:?} {c:?}");
    assert!(c.windows(2).all(|w| w[1] < w[0] / 1.5), "{c:?}");
    // The pictures before are the same light, coarser: each replaces the one before.
    let direct = chen("chen-direct", 4800, 3);
    let preview = chen("chen-preview", 4800, 4);
    near("C seen directly", &direct[3], &truth[3], 0.03);
    near("all seen directly", &preview[0], &truth[0], 0.02);
    let errors = [error(&direct[0], &truth[0]), error(&preview[0], &truth[0])];
    assert!(errors[0] < 0.03 && errors[1] < 0.1, "{errors:?}");
    // The same light in a map of photons instead of patches.
    let p = json!({"of": CHEN[2], "terms": "photons@2:L(D|S)*DS*DS*E", "radius": 0.1});
    let photons = pictures(&scene, ("hybrid", p), &[], (SIZE, 16, 8, 5));
    near("in photons", &photons[0], &truth[3], 0.02);
    let e = error(&finest[3], &photons[0]);
    assert!(e < 0.03, "{e}");
}

/// Irradiance caching in place of radiosity, for the light that matte surfaces send each other (Chen's C): the
/// same light, of patches and by bidirectional path tracing.
#[test]
fn irradiance_caching_may_replace_radiosity() {
    let scene = small_room().build();
    let truth = pictures(&scene, ("bdpt", json!({})), &CHEN, (SIZE, 20, 30, 13));
    let by = |terms: &str, seed| {
        let p = json!({"of": CHEN[2], "terms": terms, "patches": 4800, "radius": 0.1});
        pictures(&scene, ("hybrid", p), &[], (SIZE, 8, 2, seed))
    };
    let cached = by("cache@1:L(D|S)*DS*DS*E", 14);
    let patches = by("radiosity@2:L(D|S)*DS*DS*E", 15);
    near("the truth", &cached[0], &truth[3], 0.02);
    near("patches", &cached[0], &patches[0], 0.03);
    let errors = [&truth[3], &patches[0]].map(|other| error(&cached[0], other));
    assert!(errors.iter().all(|e| *e < 0.04), "{errors:?}");
    // All of the picture, and no light twice.
    let [a, b, c] = CHEN;
    let terms = format!("path:{a}; photons@1:{b}; cache@1:{c}");
    let p = json!({"terms": terms, "photons": 50_000});
    let all = pictures(&scene, ("hybrid", p), &[], (SIZE, 8, 8, 16));
    near("A + B + C", &all[0], &truth[0], 0.01);
}

/// What is cheaper than the truth may be believed: of all light, nearly every pixel is within 4 % of what
/// bidirectional path tracing predicts, or its noise.
#[test]
fn cheaper_pictures_are_believable() {
    let scene = small_room().build();
    let truth = pictures(&scene, ("bdpt", json!({})), &[], (SIZE, 20, 60, 17)).swap_remove(0);
    let believed = |picture: &[RunningMean]| {
        let pairs = picture.iter().zip(&truth);
        let right = pairs.filter(|(a, b)| {
            let noise = a.standard_error().hypot(b.standard_error());
            (a.mean() - b.mean()).abs() < 0.04 * b.mean() + 2.0 * noise
        });
        right.count() as f64 / truth.len() as f64
    };
    for (method, p, passes) in [
        ("chen", json!({"patches": 4800, "photons": 50_000}), 4),
        ("photonmap", json!({"cache": 0.2, "radius": 0.05}), 1),
    ] {
        let picture = pictures(&scene, (method, p), &[], (SIZE, 8, passes, 18)).swap_remove(0);
        let share = believed(&picture);
        assert!(share > 0.95, "{method}: {share}");
    }
    // Not everything is: without caustics the picture is another.
    let p = json!({"of": "L[D]S*E|L(D|S)*DS*DS*E", "terms": "path:L[D]S*E; radiosity@2:L(D|S)*DS*DS*E"});
    let without = pictures(&scene, ("hybrid", p), &[], (SIZE, 8, 4, 19)).swap_remove(0);
    assert!(believed(&without) < 0.9);
}

/// The two-pass methods have their classes, of which one by a planar mirror is most, and no light twice.
#[test]
fn two_pass_methods_are_their_classes() {
    let classes = ["L([S_M]D)*S_M*E", "L(D|S_M)*E"];
    let by = |scene: &Scene, terms: &str, patches: u32| {
        let p = json!({"patches": patches, "terms": terms});
        pictures(scene, ("hybrid", p), &[], (SIZE, 16, 4, 2)).swap_remove(0)
    };
    let scene = mirror_room().build();
    let truth = pictures(&scene, ("bdpt", json!({})), &classes, (SIZE, 20, 20, 8));
    let errors = [1200, 4800].map(|patches| error(&by(&scene, "wallace", patches), &truth[1]));
    assert!(errors[1] < 0.03 && errors[1] < errors[0] / 1.5, "{errors:?}");
    // Glass takes two surfaces to pass: radiosity by way of one misses what comes through the ball.
    let scene = small_room().build();
    let truth = pictures(&scene, ("bdpt", json!({})), &classes, (SIZE, 20, 20, 9));
    assert!(mean(&truth[1]).mean() < 0.95 * mean(&truth[2]).mean());
    near("Wallace", &by(&scene, "wallace", 4800), &truth[1], 0.02);
    let found = [1200, 4800].map(|patches| by(&scene, "sillion-puech", patches));
    near("Sillion", &found[1], &truth[2], 0.02);
    let errors = found.each_ref().map(|picture| error(picture, &truth[2]));
    assert!(errors[1] < 0.04 && errors[1] < errors[0] / 1.5, "{errors:?}");
    same("all is ideal here", &mean(&truth[0]), &mean(&truth[2]));
}

/// A final pass by ray tracing or by path tracing: the same for ideal mirrors.
#[test]
fn final_passes_are_interchangeable() {
    let scene = small_room().build();
    let rest = "radiosity@1:L(S_M+|(S_M*D)+S_M*)DS_M*E";
    let by = |method: &str, seed| {
        let of = "L[D|S]S_M*E|L(D|S_M)*E";
        let terms = format!("{method}:L[D|S]S_M*E; {rest}");
        let p = json!({"of": of, "terms": terms, "patches": 500});
        pictures(&scene, ("hybrid", p), &[], (SIZE, 40, 10, seed))
    };
    let (rays, paths) = (by("whitted", 10), by("path", 11));
    same("the picture", &mean(&rays[0]), &mean(&paths[0]));
    same("the final pass", &mean(&rays[1]), &mean(&paths[1]));
    assert!(mean(&rays[1]).mean() > 0.0 && mean(&rays[2]).mean() > 0.0);
}

/// Every kind of scattering under every kind of light.
#[test]
fn chen_knows_gloss_and_the_sky() {
    let scene = sized(all_kinds()).build();
    let truth = pictures(&scene, ("bdpt", json!({})), &CHEN, (SIZE, 20, 30, 9));
    let p = json!({"patches": 4000, "photons": 50_000});
    let found = pictures(&scene, ("chen", p), &[], (SIZE, 20, 20, 2));
    near("A", &found[1], &truth[1], 0.0);
    near("B", &found[2], &truth[2], 0.03);
    near("C", &found[3], &truth[3], 0.05);
    near("A + B + C", &found[0], &truth[0], 0.01);
}

/// A point light behind glass: what path tracing never finds is not given to it.
#[test]
fn what_a_method_never_finds_in_a_scene_is_refused() {
    let mut stage = sized(room());
    stage.point_light(v(0.3, -0.2, 1.6), 2.0);
    let plain = stage.build();
    let glass = stage.glass(1.5, 0.0);
    stage.shape(sphere(0.22), at(0.5, -0.3, 0.23), glass);
    let scene = stage.build();
    let config =
        SamplerConfig { kind: SamplerKind::Independent, seed: 1, spp: 1, resolution: SIZE };
    let workers = Workers::new(2, Arc::default()).expect("threads");
    let prepared = |scene: &Scene, terms: &str| {
        let mut frame = Frame::new(SIZE, FilterDesc::BOX, config);
        let method = made("hybrid", &json!({"terms": terms}));
        frame.keep_layers(&method.layers());
        Session::new(scene, &frame, method).prepare(&workers).map_err(|e| e.to_string())
    };
    let all = "path:L(D|S)*E";
    prepared(&plain, all).expect("no mirrors");
    let error = prepared(&scene, all).expect_err("caustics of a point");
    assert!(error.contains("`path` never finds `LS_MDE`"), "{error}");
    prepared(&scene, "path:L[D]S*E; sppm:LS+DS*E; photons@2:L(D|S)*DS*DS*E").expect("shared");
    // And photons find it: light tracing sees the same where no mirror is last.
    let light = pictures(&scene, ("light", json!({})), &["LS+DE"], (SIZE, 20, 100, 11));
    let p = json!({"of": "LS+DE", "terms": "photons@1:LS+DE", "radius": 0.01});
    let photons = pictures(&scene, ("hybrid", p), &[], (SIZE, 20, 5, 12));
    assert!(mean(&light[1]).mean() > 0.0);
    near("caustics of a point", &photons[0], &light[1], 0.03);
}

/// A z-buffer leaves glass out and shows what is behind it, which is none of its class.
#[test]
fn what_strays_from_its_class_is_refused() {
    let (with_glass, plain) = (small_room().build(), mirror_room().build());
    let config =
        SamplerConfig { kind: SamplerKind::Independent, seed: 1, spp: 1, resolution: SIZE };
    let workers = Workers::new(2, Arc::default()).expect("threads");
    let prepared = |scene: &Scene, maker: &str| {
        let mut frame = Frame::new(SIZE, FilterDesc::BOX, config);
        let terms = format!("{maker}:L[D|S]E; path:L(D|S)(D|S)+E");
        let method = made("hybrid", &json!({"terms": terms}));
        frame.keep_layers(&method.layers());
        Session::new(scene, &frame, method).prepare(&workers).map_err(|e| e.to_string())
    };
    let error = prepared(&with_glass, "zbuffer").expect_err("glass is left out");
    assert!(error.contains("`zbuffer` leaves out this scene's glass"), "{error}");
    prepared(&with_glass, "zbuffer(clear=true)").expect("glass is drawn");
    prepared(&plain, "zbuffer").expect("no glass");
}

/// One thread or three, with breaks or without.
#[test]
fn threads_and_breaks_change_nothing() {
    let mut stage = small_room();
    stage.camera(pinhole(75.0), look(v(0.2, -0.95, 0.3), v(-0.1, 0.3, -0.35)), [12, 8]);
    let scene = stage.build();
    let cached = "path:L[D]S*E; photons@1:LS+DS*E; cache@1:L(D|S)*DS*DS*E";
    for terms in ["chen", cached] {
        let p = json!({"terms": terms, "patches": 200, "form_rays": 64, "photons": 3000});
        let make = || {
            let params = serde_json::from_value(p.clone()).expect("parameters");
            Hybrid::new(&INFO, params).expect("a partition")
        };
        threads_and_breaks(&scene, make, 3, &[1, 2]);
    }
}
