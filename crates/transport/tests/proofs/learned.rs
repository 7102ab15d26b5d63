//! Light selection that has learned: it is a distribution, the same for everyone, changes no mean
//! whatever it knows, and less is wasted.

use crate::scenes::*;
use crate::stats::{Random, close, follows, same};
use kaustika_film::FilterDesc;
use kaustika_film::accumulate::{PassImage, PassTree};
use kaustika_math::{Vec2, Vec3, warp};
use kaustika_sampling::estimator::RunningMean;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::description::*;
use kaustika_scene::{
    LearnedLights, Light, LightId, LightSelection, LightSelectionKind, Scene, ShadingPoint,
};
use kaustika_spectra::Wavelengths;
use kaustika_transport::path::PathTracer;
use kaustika_transport::{Frame, Method, Workers, lights};
use serde_json::json;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn workers(threads: usize) -> Workers {
    Workers::new(threads, Arc::new(AtomicBool::new(false))).expect("threads")
}

fn frame(spp: u64, seed: u64) -> Frame {
    let resolution = [12, 12];
    let kind = SamplerKind::Independent;
    Frame::new(resolution, FilterDesc::BOX, SamplerConfig { kind, seed, spp, resolution })
}

/// As for a picture of more pixels than the tests can render.
fn learned(scene: &Scene, seed: u64) -> LightSelection {
    let frame = Frame { resolution: [128, 128], ..frame(1, seed) };
    lights::learn(scene, &frame, 4, &workers(2)).expect("something to learn")
}

/// A closed room of side 4 but for a hole of side 1 in a wall; the camera looks at it.
fn room() -> Stage {
    let mut stage = Stage::new();
    let white = stage.diffuse(0.6);
    let white = stage.two_sided(white);
    let mut wall = |t| {
        stage.shape(GeometryDesc::Rectangle, t, white);
    };
    for (angle, axis) in [(90.0, Vec3::X), (-90.0, Vec3::X), (180.0, Vec3::X), (0.0, Vec3::X)] {
        wall(rotate(angle, axis) * at(0.0, 0.0, -2.0) * scale(2.0, 2.0, 1.0));
    }
    wall(rotate(90.0, Vec3::Y) * at(0.0, 0.0, -2.0) * scale(2.0, 2.0, 1.0));
    // Around the hole at x = 2.
    for (y, z, w, h) in [
        (0.0, -1.25, 2.0, 0.75),
        (0.0, 1.25, 2.0, 0.75),
        (-1.25, 0.0, 0.75, 0.5),
        (1.25, 0.0, 0.75, 0.5),
    ] {
        wall(at(2.0, y, z) * rotate(90.0, Vec3::Y) * scale(h, w, 1.0));
    }
    stage.camera(pinhole(75.0), look(v(-1.7, -1.6, 0.9), v(0.8, 0.7, -0.5)), [12, 12]);
    stage.selection = Some(LightSelectionKind::Learned);
    stage
}

/// A sky with a sun that does not reach through the hole, and a brighter part that does.
fn sky(layout: EnvironmentLayout) -> LightKind {
    let bitmap = bitmap(48, 32, |x, y| {
        let near = |a: f32, b: f32| (x - a).abs() < 0.03 && (y - b).abs() < 0.05;
        let k = if near(0.1, 0.3) {
            300.0
        } else {
            0.5 + x + if near(0.25, 0.45) { 20.0 } else { 0.0 }
        };
        [k, 0.9 * k, 0.7 * k]
    });
    let space = kaustika_spectra::ColorSpace::Srgb;
    LightKind::Image { bitmap, space, layout, scale: 1.0, illuminance: None }
}

/// Lamps of all kinds in and outside the room.
fn lamps(stage: &mut Stage) {
    stage.lamp(disk(0.3), at(0.0, 0.0, 1.9) * down(), 4.0);
    stage.lamp(sphere(0.15), at(-1.0, 1.2, -1.2), 8.0);
    let t = at(3.5, 0.0, 0.3) * rotate(-90.0, Vec3::Y) * scale(0.4, 0.4, 1.0);
    stage.lamp(GeometryDesc::Rectangle, t, 30.0);
    for i in 0..6 {
        stage.lamp(sphere(0.2), at(-4.0, i as f32 - 3.0, 0.0), 50.0);
    }
    stage.point_light(v(4.0, 0.5, 0.2), 40.0);
    stage.point_light(v(1.0, 1.0, 1.0), 0.5);
    let irradiance = grey(2.0);
    let kind = LightKind::Directional { irradiance, scale: 1.0, illuminance: None };
    stage.light(kind, rotate(-70.0, Vec3::Y));
    let spot = LightKind::Spot {
        intensity: grey(9.0),
        scale: 1.0,
        power: None,
        cutoff: 40.0,
        beam_width: 20.0,
        falloff: SpotFalloff::SmoothstepCosine,
        texture: None,
    };
    stage.light(spot, at(0.5, -0.5, 1.5) * down());
}

fn stages() -> Vec<(&'static str, Stage)> {
    let image = |layout| {
        let mut stage = room();
        stage.light(sky(layout), rotate(90.0, Vec3::X));
        stage
    };
    let mut stages = vec![
        ("latitude-longitude", image(EnvironmentLayout::LatLong)),
        ("octahedral", image(EnvironmentLayout::EqualArea)),
        ("constant", room()),
        ("lamps", room()),
        ("all", image(EnvironmentLayout::LatLong)),
    ];
    stages[2].1.sky(1.0);
    lamps(&mut stages[3].1);
    lamps(&mut stages[4].1);
    stages
}

#[test]
fn the_mean_is_that_of_the_hierarchy() {
    for (i, (what, stage)) in stages().into_iter().enumerate() {
        let scene = stage.build();
        let lights = learned(&scene, i as u64);
        // It knows one place only, and that wrongly: outside, facing away.
        let point =
            ShadingPoint { p: v(9.0, 9.0, 9.0), p_error: Vec3::ZERO, n: Vec3::Z, transmits: false };
        let misled = LearnedLights::new(&scene, vec![point], 3).expect("lights");
        let misled = LightSelection::learned(misled);
        let p = |mis: &str| json!({"mis": mis, "max_depth": 3});
        let reference = render_with(&scene, &scene.light_selection, &frame(400, 99), p("power"));
        for (mis, lights, spp) in [
            ("power", &lights, 200),
            ("balance", &lights, 100),
            ("light", &lights, 200),
            ("bsdf", &lights, 200),
            ("power", &misled, 200),
            ("light", &misled, 400),
        ] {
            if mis == "bsdf" && !scene.lights.iter().all(|l| !l.is_delta()) {
                // What is lit by delta lights alone is sampled in this mode, too.
                continue;
            }
            let picture = render_with(&scene, lights, &frame(spp, 7), p(mis));
            same(&format!("{what}, {mis}"), &picture.mean(), &reference.mean());
            if mis != "power" {
                continue;
            }
            for (x, y) in [(0, 0), (6, 0), (0, 6), (6, 6)] {
                let tile = |p: &Picture| {
                    let mut sum = RunningMean::new();
                    for k in 0..36 {
                        sum.merge(p.at(x + k % 6, y + k / 6));
                    }
                    sum
                };
                let what = format!("{what}, {mis}, tile {x} {y}");
                same(&what, &tile(&picture), &tile(&reference));
            }
        }
    }
}

/// (light, region) of all that can be chosen, with probabilities.
fn probabilities(scene: &Scene, lights: &LightSelection, p: Vec3, n: Vec3) -> Vec<f64> {
    let mut all = Vec::new();
    for (i, light) in scene.lights.iter().enumerate() {
        let id = LightId(i as u32);
        match light {
            Light::Environment(e) => {
                let [columns, rows] = e.regions();
                all.extend(
                    (0..columns * rows)
                        .map(|r| (lights.pmf_escaped(p, n, id, r) * e.region_pmf(r)) as f64),
                );
            }
            _ => all.push(lights.pmf(p, n, id) as f64),
        }
    }
    all
}

#[test]
fn probabilities_sum_to_one_and_frequencies_follow_them() {
    let mut random = Random::new(1);
    for (what, stage) in stages() {
        let scene = stage.build();
        let lights = learned(&scene, 1);
        // Where each light's entries begin.
        let first: Vec<usize> = scene
            .lights
            .iter()
            .scan(0, |next, light| {
                let first = *next;
                *next += match light {
                    Light::Environment(e) => (e.regions()[0] * e.regions()[1]) as usize,
                    _ => 1,
                };
                Some(first)
            })
            .collect();
        for i in 0..12 {
            let p = random.v3() * if i % 4 == 3 { 100.0 } else { 2.0 };
            let n = if i % 3 == 0 { Vec3::ZERO } else { random.v3().normalize() };
            let pmf = probabilities(&scene, &lights, p, n);
            close(what, pmf.iter().sum(), 1.0, 2e-5);
            if i >= 3 {
                continue;
            }
            let (mut counts, draws) = (vec![0.0; pmf.len()], 20_000);
            for _ in 0..draws {
                let c = lights.sample(p, n, random.f(), random.v2()).expect("lights");
                let at = first[c.light.0 as usize] + c.region.unwrap_or(0) as usize;
                close("sample and pmf", c.p as f64, pmf[at], 1e-4);
                counts[at] += 1.0;
            }
            let expected: Vec<f64> = pmf.iter().map(|q| q * draws as f64).collect();
            follows(what, &counts, &expected);
        }
    }
}

#[test]
fn an_escaped_ray_has_the_density_that_samples_have() {
    let mut random = Random::new(4);
    let lambda = Wavelengths::rgb();
    for (what, stage) in &stages()[..3] {
        let scene = stage.build();
        let lights = learned(&scene, 1);
        let (id, sky) = (LightId(0), scene.light(LightId(0)));
        let (p, n) = (v(0.3, -0.4, -1.9), Vec3::Z);
        let density = |wi: Vec3| {
            let e = sky.escaped(p, wi, &lambda);
            (lights.pmf_escaped(p, n, id, e.region) * e.pdf_li) as f64
        };
        let (mut differing, count) = (0, 4000);
        for _ in 0..count {
            let c = lights.sample(p, n, random.f(), random.v2()).expect("lights");
            let Some(l) = sky.sample_li_in(&scene, p, c.region, c.u, &lambda) else { continue };
            let (sampled, found) = ((c.p * l.pdf_w) as f64, density(l.wi));
            // Rounding may put a direction across a border.
            differing += usize::from((found / sampled - 1.0).abs() > 1e-2);
        }
        assert!(differing < count / 200, "{what}: {differing}");
        // Nothing else can be chosen: the density integrates to 1. Jittered, because an even grid
        // beats with the borders of regions.
        let side = 1500;
        let mut sum = 0.0;
        for i in 0..side * side {
            let u = Vec2::new((i % side) as f32, (i / side) as f32) + random.v2();
            let u = u / side as f32;
            sum += density(warp::uniform_sphere(u)) * 4.0 * std::f64::consts::PI;
        }
        close(what, sum / (side * side) as f64, 1.0, 2e-3);
    }
}

#[test]
fn threads_and_crops_learn_the_same() {
    let (_, stage) = stages().pop().expect("stages");
    let scene = stage.build();
    let pass = |threads: usize, region: [u32; 4]| {
        let resolution = [24, 16];
        let kind = SamplerKind::Sobol;
        let config = SamplerConfig { kind, seed: 5, spp: 4, resolution };
        let frame = Frame { region, ..Frame::new(resolution, FilterDesc::BOX, config) };
        let workers = workers(threads);
        let mut method = PathTracer::new(params(json!({"max_depth": 3})));
        method.prepare(&scene, &frame, &workers).expect("prepared");
        let [w, h] = frame.size();
        let mut image = PassImage::new(w, h, frame.layers.clone());
        method.pass(1, &scene, &frame, &mut image, &workers).expect("a pass");
        let mut tree = PassTree::new(w, h, frame.layers.clone());
        tree.push(1, image).expect("the first");
        let total = tree.total().expect("a pass");
        (0..(w * h) as usize).map(|i| total.rgb(i)).collect::<Vec<_>>()
    };
    let (whole, again) = (pass(1, [0, 0, 24, 16]), pass(3, [0, 0, 24, 16]));
    assert!(whole == again, "threads change the picture");
    let part = pass(2, [8, 4, 16, 12]);
    for y in 0..8 {
        for x in 0..8 {
            assert_eq!(part[y * 8 + x], whole[(y + 4) * 24 + x + 8]);
        }
    }
}

#[test]
fn less_is_wasted_through_a_window() {
    for (what, stage) in &stages()[..3] {
        let scene = stage.build();
        let noise = |lights: &LightSelection| {
            let picture = render_with(
                &scene,
                lights,
                &frame(1000, 3),
                json!({"mis": "light", "only_depth": 1}),
            );
            picture.pixels.iter().map(|p| p.variance()).sum::<f64>()
        };
        let (before, after) = (noise(&scene.light_selection), noise(&learned(&scene, 2)));
        assert!(after < 0.5 * before, "{what}: {before} {after}");
    }
}

#[test]
fn without_lights_or_points_nothing_is_learned() {
    let mut dark = room();
    let frame = frame(1, 1);
    assert!(lights::learn(&dark.build(), &frame, 3, &workers(1)).is_none());
    // Alone in empty space: no point to learn from.
    dark.d.shapes.clear();
    dark.sky(1.0);
    assert!(lights::learn(&dark.build(), &frame, 3, &workers(1)).is_none());
    // A single lamp leaves no choice.
    let mut single = room();
    single.lamp(sphere(0.2), at(0.0, 0.0, 0.5), 3.0);
    assert!(lights::learn(&single.build(), &frame, 3, &workers(1)).is_none());
}

/// A sun of one texel, which no grid of directions need meet, beside a lamp: it lights the floor,
/// and learning must know of it. Variances by 64 samples a pixel; learning may lose a factor of
/// two to the hierarchy, not the twenty it lost when the sun's power was guessed from such a grid.
#[test]
fn a_small_sun_is_not_forgotten() {
    let mut stage = Stage::new();
    floor(&mut stage);
    let (w, h) = (1024, 512);
    let sun = bitmap(w, h, |x, y| {
        let at = |v: f32, n: u32, i: u32| (v * n as f32) as u32 == i;
        if at(x, w, 250) && at(y, h, 140) { [3e5; 3] } else { [0.0; 3] }
    });
    let space = kaustika_spectra::ColorSpace::Srgb;
    let layout = EnvironmentLayout::LatLong;
    let kind = LightKind::Image { bitmap: sun, space, layout, scale: 1.0, illuminance: None };
    stage.light(kind, rotate(90.0, Vec3::X));
    stage.lamp(sphere(0.2), at(1.0, 1.0, 1.5), 20.0);
    stage.camera(pinhole(50.0), look(v(0.0, -4.0, 3.0), Vec3::ZERO), [12, 12]);
    stage.selection = Some(LightSelectionKind::Learned);
    let scene = stage.build();
    let p = || json!({"max_depth": 1});
    let variance = |lights: &LightSelection| {
        let picture = render_with(&scene, lights, &frame(64, 5), p());
        picture.pixels.iter().map(RunningMean::variance).sum::<f64>()
    };
    let (taught, untaught) = (variance(&learned(&scene, 1)), variance(&scene.light_selection));
    assert!(untaught > 0.0 && taught < 2.0 * untaught, "{taught} {untaught}");
}

/// More lights at infinity than can be told apart: nothing is learned, and none is lost.
#[test]
fn too_many_suns_are_not_learned() {
    let mut stage = Stage::new();
    floor(&mut stage);
    (0..5).for_each(|_| stage.sky(0.1));
    let kind = || LightKind::Directional { irradiance: grey(1e-3), scale: 1.0, illuminance: None };
    (0..3000).for_each(|_| stage.light(kind(), down()));
    stage.selection = Some(LightSelectionKind::Learned);
    let scene = stage.build();
    let frame = Frame { resolution: [64, 64], ..frame(1, 0) };
    assert!(lights::learn(&scene, &frame, 4, &workers(1)).is_none());
}
