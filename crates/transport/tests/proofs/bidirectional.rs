//! Bidirectional path tracing: its strategies agree with each other and with the path tracer.

use crate::scenes::*;
use crate::stats::same;
use kaustika_film::FilterDesc;
use kaustika_film::accumulate::PassImage;
use kaustika_math::Vec3;
use kaustika_sampling::estimator::RunningMean;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::Scene;
use kaustika_scene::description::*;
use kaustika_transport::bidirectional::VcmParams;
use kaustika_transport::{Frame, Method, Workers, registry};
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

pub(crate) const SIZE: [u32; 2] = [12, 8];

/// The mean of the picture and of its quarters by a method; passes count as independent.
pub(crate) fn means(
    scene: &Scene,
    method: &str,
    p: Value,
    passes: u64,
    seed: u64,
) -> Vec<RunningMean> {
    let entry = registry::find(method).expect("known");
    let Value::Object(p) = p else { panic!("an object") };
    means_of(scene, (entry.make)(&p).expect("sound parameters"), passes, seed)
}

/// As [`means`], of a method that was made.
pub(crate) fn means_of(
    scene: &Scene,
    mut method: Box<dyn Method>,
    passes: u64,
    seed: u64,
) -> Vec<RunningMean> {
    let config =
        SamplerConfig { kind: SamplerKind::Independent, seed, spp: passes, resolution: SIZE };
    let frame = Frame::new(SIZE, FilterDesc::BOX, config);
    let workers = Workers::new(2, Arc::new(AtomicBool::new(false))).expect("threads");
    method.prepare(scene, &frame, &workers).expect("prepared");
    let mut means = vec![RunningMean::new(); 5];
    for index in 0..passes {
        let mut image = PassImage::new(SIZE[0], SIZE[1], frame.layers.clone());
        let commit = method.pass(index, scene, &frame, &mut image, &workers).expect("a pass");
        assert_eq!(commit.stats.bad_samples, 0);
        let mut sums = [0.0; 5];
        let stride = image.layers().stride();
        for (i, pixel) in image.data().chunks(stride).enumerate() {
            let (x, y) = (i as u32 % SIZE[0], i as u32 / SIZE[0]);
            let quarter = 2 * usize::from(y >= SIZE[1] / 2) + usize::from(x >= SIZE[0] / 2);
            let grey = f64::from(pixel[0] + pixel[1] + pixel[2]) / 3.0;
            sums[quarter] += grey;
            sums[4] += grey;
        }
        means.iter_mut().zip(sums).for_each(|(m, s)| m.push(s));
    }
    means
}

/// Fails unless two pictures agree as a whole and quarter by quarter.
pub(crate) fn agree(what: &str, a: &[RunningMean], b: &[RunningMean]) {
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        same(&format!("{what}, part {i}"), a, b);
    }
}

/// A box with an open front, a glossy block, and whatever lights it.
pub(crate) fn room() -> Stage {
    let mut stage = Stage::new();
    let (white, red) = (stage.diffuse(0.7), stage.diffuse(0.3));
    let metal = stage.metal(0.3);
    let wall = |stage: &mut Stage, t, m| {
        let m = stage.two_sided(m);
        stage.shape(GeometryDesc::Rectangle, t, m);
    };
    wall(&mut stage, at(0.0, 0.0, 0.0), white);
    wall(&mut stage, at(0.0, 1.0, 1.0) * rotate(90.0, Vec3::X), white);
    wall(&mut stage, at(-1.0, 0.0, 1.0) * rotate(90.0, Vec3::Y), red);
    wall(&mut stage, at(1.0, 0.0, 1.0) * rotate(90.0, Vec3::Y), white);
    stage.shape(sphere(0.3), at(-0.35, 0.1, 0.31), metal);
    stage.camera(pinhole(60.0), look(v(0.1, -2.6, 1.0), v(0.0, 0.0, 0.7)), SIZE);
    stage
}

fn lamp(stage: &mut Stage) {
    stage.lamp(GeometryDesc::Rectangle, at(0.2, 0.1, 1.7) * down() * scale(0.3, 0.2, 1.0), 8.0);
}

/// Adds a light to a stage.
pub type Light = Box<dyn Fn(&mut Stage)>;

#[test]
fn it_agrees_with_the_path_tracer_under_every_light() {
    let kinds: Vec<(&str, Light)> = vec![
        ("rectangle", Box::new(lamp)),
        (
            "sphere",
            Box::new(|s| {
                s.lamp(sphere(0.15), at(0.3, -0.1, 1.4), 10.0);
            }),
        ),
        (
            "two-sided disk",
            Box::new(|s| {
                s.lamp(disk(0.25), at(0.3, 0.2, 1.2) * rotate(60.0, Vec3::Y), 8.0);
                let l = s.d.shapes.last_mut().expect("a lamp");
                l.emission.as_mut().expect("it emits").two_sided = true;
            }),
        ),
        ("point", Box::new(|s| s.point_light(v(0.4, -0.2, 1.3), 2.0))),
        (
            "parallel",
            Box::new(|s| {
                let irradiance = grey(2.0);
                let kind = LightKind::Directional { irradiance, scale: 1.0, illuminance: None };
                s.light(kind, rotate(150.0, v(1.0, 0.3, 0.1)));
            }),
        ),
        ("sky", Box::new(|s| s.sky(0.7))),
        (
            "painted sky and lamp",
            Box::new(|s| {
                let picture = |x: f32, y: f32| [0.2 + x, 0.5 + y, 0.3 + 3.0 * x * y];
                let kind = LightKind::Image {
                    bitmap: bitmap(8, 4, picture),
                    space: kaustika_spectra::ColorSpace::Srgb,
                    layout: EnvironmentLayout::LatLong,
                    scale: 0.5,
                    illuminance: None,
                };
                s.light(kind, HERE);
                lamp(s);
            }),
        ),
    ];
    for (i, (what, light)) in kinds.iter().enumerate() {
        let mut stage = room();
        light(&mut stage);
        let scene = stage.build();
        let p = json!({"max_depth": 4});
        let path = means(&scene, "path", p.clone(), 400, 100 + i as u64);
        let bdpt = means(&scene, "bdpt", p, 250, 200 + i as u64);
        agree(what, &bdpt, &path);
    }
}

#[test]
fn it_agrees_with_the_path_tracer_through_every_camera() {
    let cameras = [
        ("thin lens", thin_lens(60.0, 0.2, 2.5)),
        ("parallel", parallel(1.0, 0.0, 1.0)),
        ("parallel with a lens", parallel(1.0, 0.1, 2.5)),
        ("spherical", CameraKind::Spherical { equal_area: true }),
    ];
    for (i, (what, kind)) in cameras.into_iter().enumerate() {
        let mut stage = room();
        lamp(&mut stage);
        stage.camera(kind, look(v(0.1, -2.6, 1.0), v(0.0, 0.0, 0.7)), SIZE);
        let scene = stage.build();
        let p = json!({"max_depth": 3});
        let path = means(&scene, "path", p.clone(), 400, 300 + i as u64);
        let bdpt = means(&scene, "bdpt", p, 250, 400 + i as u64);
        agree(what, &bdpt, &path);
    }
}

#[test]
fn light_tracing_draws_what_it_can_see() {
    // No mirrors, and no lights seen: paths of one to three bounces, in an open room.
    let mut stage = room();
    lamp(&mut stage);
    stage.camera(thin_lens(60.0, 0.2, 2.5), look(v(0.1, -2.6, 1.0), v(0.0, 0.0, 0.7)), SIZE);
    let scene = stage.build();
    let p = json!({"max_depth": 3});
    let path = means(&scene, "path", json!({"max_depth": 3, "hide_emitters": true}), 600, 800);
    agree("connected", &means(&scene, "light", p, 600, 801), &path);
    let p = json!({"max_depth": 3, "nee": false});
    agree("met", &means(&scene, "light", p, 6000, 802), &path);
    for depth in 1..=3 {
        let p = json!({"only_depth": depth});
        let path = means(&scene, "path", p.clone(), 600, 810 + depth);
        agree(&format!("{depth} bounces"), &means(&scene, "light", p, 600, 820 + depth), &path);
    }
}

#[test]
fn heuristics_and_roulette_do_not_move_the_mean() {
    let mut stage = room();
    let glass = stage.glass(1.5, 0.0);
    stage.shape(sphere(0.25), at(0.45, -0.2, 0.26), glass);
    lamp(&mut stage);
    let scene = stage.build();
    let path = means(&scene, "path", json!({"max_depth": 6}), 1500, 500);
    for (i, p) in [
        json!({"max_depth": 6, "mis": "balance"}),
        json!({"max_depth": 6, "mis": "power"}),
        json!({"max_depth": 6, "mis": "max"}),
        json!({"max_depth": 6, "roulette": "none"}),
        json!({"max_depth": 6, "roulette": "albedo", "rr_depth": 0}),
    ]
    .into_iter()
    .enumerate()
    {
        let what = p.to_string();
        agree(&what, &means(&scene, "bdpt", p, 300, 510 + i as u64), &path);
    }
}

#[test]
fn every_strategy_alone_makes_the_paths_of_its_length() {
    // Diffuse walls, a lens with an area: every strategy can make every path (but those seen
    // directly, which are the eye's).
    let mut stage = Stage::new();
    let white = stage.diffuse(0.6);
    stage.shape(GeometryDesc::Cube, HERE, white).flip_normals = true;
    stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, 0.9) * down() * scale(0.5, 0.5, 1.0), 3.0);
    stage.camera(thin_lens(80.0, 0.3, 1.2), look(v(0.0, -0.9, 0.1), v(0.0, 1.0, -0.2)), SIZE);
    let scene = stage.build();
    for depth in 1..=3usize {
        let only = json!({"only_depth": depth});
        let path = means(&scene, "path", only, 600, 600 + depth as u64);
        for s in 0..=depth + 2 {
            let p = json!({
                "only_depth": depth, "strategy": format!("{s},{}", depth + 2 - s),
                "weighted": false, "roulette": "none",
            });
            let passes = if s == depth + 2 { 3000 } else { 600 };
            let alone = means(&scene, "bdpt", p, passes, 620 + s as u64);
            agree(&format!("{depth} bounces, {s} vertices from the light"), &alone, &path);
        }
    }
}

#[test]
fn weighted_strategies_add_up_to_the_picture() {
    let mut stage = room();
    lamp(&mut stage);
    stage.camera(thin_lens(60.0, 0.2, 2.5), look(v(0.1, -2.6, 1.0), v(0.0, 0.0, 0.7)), SIZE);
    let scene = stage.build();
    // The same random numbers: the same paths, weighted alike, each in one of the pictures.
    let picture = |p: Value| -> Vec<f64> {
        means(&scene, "bdpt", p, 4, 700).iter().map(RunningMean::mean).collect()
    };
    let whole = picture(json!({"only_depth": 2}));
    let mut sum = vec![0.0; whole.len()];
    for s in 0..=4 {
        let p = json!({"only_depth": 2, "strategy": format!("{s},{}", 4 - s)});
        sum.iter_mut().zip(picture(p)).for_each(|(sum, v)| *sum += v);
    }
    for (sum, whole) in sum.iter().zip(&whole) {
        crate::stats::close("sum of strategies", *sum, *whole, 1e-5);
    }
}

/// As [`means`], of a method whose passes are not alike: the mean of independent renders.
pub(crate) fn renders(
    scene: &Scene,
    method: &str,
    p: Value,
    passes: u64,
    seed: u64,
) -> Vec<RunningMean> {
    let mut all = vec![RunningMean::new(); 5];
    for k in 0..12 {
        let one = means(scene, method, p.clone(), passes, seed * 100 + k);
        all.iter_mut().zip(one).for_each(|(all, m)| all.push(m.mean()));
    }
    all
}

#[test]
fn connections_of_both_weightings_are_the_same_samples() {
    // The recursion and the densities kept along the path are two ways to the same weights.
    let mut stage = room();
    let glass = stage.glass(1.5, 0.0);
    stage.shape(sphere(0.25), at(0.45, -0.2, 0.26), glass);
    lamp(&mut stage);
    stage.sky(0.2);
    // A lamp that is black on one side: some light paths begin with nothing, eye paths go on.
    let dark = bitmap(8, 8, |x, _| if x < 0.5 { [0.0; 3] } else { [8.0; 3] });
    let picture = texture(&mut stage, dark, BitmapFilter::Nearest);
    let emission = stage.d.shapes.last_mut().and_then(|s| s.emission.as_mut());
    emission.expect("the lamp").radiance = picture;
    let scene = stage.build();
    for mis in ["balance", "power"] {
        let p = |extra: (&str, &str)| json!({"max_depth": 5, "mis": mis, extra.0: extra.1});
        let a = means(&scene, "bdpt", p(("roulette", "throughput")), 3, 900);
        let b = means(&scene, "vcm", p(("mode", "bpt")), 3, 900);
        for (a, b) in a.iter().zip(&b) {
            crate::stats::close(mis, b.mean(), a.mean(), 2e-3);
        }
    }
}

#[test]
fn merging_is_exact_in_an_integrating_sphere() {
    // A cap of a sphere has the area of a disk whose radius is its chord, so that even a wide
    // kernel is exact: L = Σ ρᵏ over the bounces k that are wanted.
    let mut stage = Stage::new();
    let (m, e) = (stage.diffuse(0.5), stage.emission(1.0));
    let s = stage.shape(sphere(1.0), HERE, m);
    (s.flip_normals, s.emission) = (true, Some(e));
    stage.camera(pinhole(90.0), look(v(0.1, 0.2, 0.0), v(0.0, 1.0, 0.1)), SIZE);
    let scene = stage.build();
    let pixels = f64::from(SIZE[0] * SIZE[1]);
    for (method, mode) in [("vcm", "vcm"), ("vcm", "bpm"), ("vcm", "bpt"), ("sppm", "")] {
        for depth in [1, 3] {
            let mut p = json!({"max_depth": depth, "radius": 0.2, "alpha": 1.0});
            if !mode.is_empty() {
                p["mode"] = mode.into();
            }
            let merged = &renders(&scene, method, p, 20, 920)[4];
            let truth = (2.0 - 0.5f64.powi(depth)) * pixels;
            crate::stats::agrees(&format!("{method} {mode}, {depth} bounces"), merged, truth);
        }
    }
}

#[test]
fn merging_agrees_with_path_tracing() {
    // The radius is so small that its bias is nothing beside the noise; glass, so that merges
    // have caustics of their own to make.
    let mut stage = room();
    let glass = stage.glass(1.5, 0.0);
    stage.shape(sphere(0.25), at(0.45, -0.2, 0.26), glass);
    lamp(&mut stage);
    let scene = stage.build();
    let path = means(&scene, "path", json!({"max_depth": 5}), 3000, 910);
    for mis in ["balance", "power"] {
        let p = json!({"max_depth": 5, "radius": 0.004, "mis": mis});
        agree(mis, &renders(&scene, "vcm", p, 40, 930), &path);
    }
}

#[test]
fn the_radius_shrinks_as_its_schedule_says() {
    let params = |alpha: f32| VcmParams { radius: 0.01, alpha, ..VcmParams::default() };
    crate::stats::close("first", params(0.5).radius(10.0, 0).into(), 0.1, 1e-6);
    crate::stats::close("halved", params(0.5).radius(10.0, 15).into(), 0.05, 1e-6);
    crate::stats::close("kept", params(1.0).radius(10.0, 99).into(), 0.1, 1e-6);
}
