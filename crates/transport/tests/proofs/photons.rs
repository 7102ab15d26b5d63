//! Photon mapping: power, closed forms, the path tracer.

use crate::bidirectional::{SIZE, agree, means, renders};
use crate::scenes::*;
use crate::stats::{agrees, close, same};
use kaustika_sampling::estimator::RunningMean;
use kaustika_scene::description::*;
use kaustika_transport::particle::photon_map::PhotonMapParams;
use serde_json::{Value, json};

/// Parameters of small tests, and others over them.
fn with(extra: Value) -> Value {
    let mut p = json!({
        "photons": 4000, "caustic_photons": 1000, "nearest": 40, "radius": 0.3, "gather": 1,
        "alpha": 1.0, "roulette": "none",
    });
    let (Value::Object(all), Value::Object(extra)) = (&mut p, extra) else { panic!("objects") };
    all.extend(extra);
    p
}

/// The inside of a sphere that emits 1 and reflects `rho`: L = Σ ρᵏ.
pub(crate) fn furnace(rho: f32) -> Stage {
    let mut stage = Stage::new();
    let (m, e) = (stage.diffuse(rho), stage.emission(1.0));
    let s = stage.shape(sphere(1.0), HERE, m);
    (s.flip_normals, s.emission) = (true, Some(e));
    stage.camera(pinhole(90.0), look(v(0.1, 0.2, 0.0), v(0.0, 1.0, 0.1)), SIZE);
    stage
}

#[test]
fn the_map_alone_is_exact_in_an_integrating_sphere() {
    // A cap of a sphere has the area of a disk whose radius is its chord, so that even a wide
    // kernel is exact; no filter, for a filter's weights fall with the chord, not in the disk.
    let scene = furnace(0.5).build();
    let pixels = f64::from(SIZE[0] * SIZE[1]);
    for search in ["buckets", "median", "heap", "grid"] {
        for depth in [1, 3, 20] {
            let p =
                with(json!({"max_depth": depth, "gather": 0, "filter": "box", "search": search}));
            let mapped = &renders(&scene, "photonmap", p, 20, 920)[4];
            let truth = (2.0 - 0.5f64.powi(depth)) * pixels;
            agrees(&format!("{search}, {depth} bounces"), mapped, truth);
        }
    }
}

#[test]
fn every_filter_and_estimate_keeps_a_uniform_field() {
    let scene = furnace(0.5).build();
    let pixels = f64::from(SIZE[0] * SIZE[1]);
    for (i, extra) in [
        json!({"filter": "cone"}),
        json!({"filter": "gauss"}),
        json!({"guide": false}),
        json!({"gather": 3}),
        json!({"alpha": 0.5}),
        json!({"weak": 0.9}),
        json!({"cache": 0.3, "cache_rays": 64}),
        json!({"cache": 0.3, "cache_rays": 64, "renew": 5}),
    ]
    .into_iter()
    .enumerate()
    {
        let mut p = with(extra.clone());
        p["max_depth"] = 4.into();
        let mapped = &renders(&scene, "photonmap", p, 10, 930 + i as u64)[4];
        agrees(&extra.to_string(), mapped, (2.0 - 0.5f64.powi(4)) * pixels);
    }
}

#[test]
fn each_bounce_alone_is_a_power_of_the_albedo() {
    let scene = furnace(0.6).build();
    let pixels = f64::from(SIZE[0] * SIZE[1]);
    for depth in 0..5 {
        for gather in [0, 1] {
            let p = with(json!({"only_depth": depth, "gather": gather, "filter": "box"}));
            let mapped = &renders(&scene, "photonmap", p, 10, 940)[4];
            agrees(&format!("{depth}, {gather}"), mapped, 0.6f32.powi(depth) as f64 * pixels);
        }
    }
}

/// A room with a lamp, a rough metal ball and, if wanted, glass and a mirror.
fn room(glass: bool) -> Stage {
    let mut stage = crate::bidirectional::room();
    if glass {
        let m = stage.glass(1.5, 0.0);
        stage.shape(sphere(0.25), at(0.45, -0.2, 0.26), m);
    }
    stage.lamp(GeometryDesc::Rectangle, at(0.2, 0.1, 1.7) * down() * scale(0.3, 0.2, 1.0), 8.0);
    stage
}

/// Estimates at radii r·(1, ½, …) and what they are at 0, by a parabola: the bias of a kernel is even in r.
fn at_zero(scene: &kaustika_scene::Scene, p: &Value, passes: u64, seed: u64) -> Vec<RunningMean> {
    let at = |k: f32| {
        let mut p = p.clone();
        for key in ["radius", "caustic_radius"] {
            p[key] = (k * p[key].as_f64().expect("a radius") as f32).into();
        }
        means(scene, "photonmap", p, passes, seed + (8.0 * k) as u64)
    };
    let (wide, narrow) = (at(1.0), at(0.5));
    let zero = |(w, n): (&RunningMean, &RunningMean)| {
        let mean = (4.0 * n.mean() - w.mean()) / 3.0;
        let error = (4.0 * n.standard_error()).hypot(w.standard_error()) / 3.0;
        with_error(mean, error)
    };
    wide.iter().zip(&narrow).map(zero).collect()
}

#[test]
fn it_agrees_with_the_path_tracer() {
    // What is left of the kernel's blur is nothing beside the noise.
    for (i, glass) in [false, true].into_iter().enumerate() {
        let scene = room(glass).build();
        let path = means(&scene, "path", json!({"max_depth": 5}), 3000, 950 + i as u64);
        let p = with(json!({
            "max_depth": 5, "photons": 20_000, "caustic_photons": 20_000, "nearest": 1_000_000,
            "caustic_nearest": 1_000_000, "radius": 0.02, "caustic_radius": 0.01, "filter": "box",
        }));
        agree(&format!("glass {glass}"), &means(&scene, "photonmap", p, 60, 960), &path);
    }
}

#[test]
fn glossy_parts_are_matte_or_sharp_and_the_picture_the_same() {
    // The metal ball by photons, or by rays; plastic, which has both parts.
    let mut stage = room(false);
    let (rough, gray, one) = (stage.rough(0.3), stage.d.float(0.5), stage.d.float(1.0));
    let plastic = stage.material(MaterialModel::Plastic {
        diffuse_reflectance: gray,
        specular_reflectance: one,
        ior: 1.5,
        nonlinear: true,
        roughness: Some(rough),
    });
    stage.shape(sphere(0.25), at(0.45, -0.2, 0.26), plastic);
    let scene = stage.build();
    let path = means(&scene, "path", json!({"max_depth": 4}), 3000, 970);
    for matte in [0.1, 0.9] {
        let p = with(json!({
            "max_depth": 4, "photons": 20_000, "caustic_photons": 20_000, "nearest": 1_000_000,
            "caustic_nearest": 1_000_000, "radius": 0.02, "caustic_radius": 0.01, "filter": "box",
            "matte": matte,
        }));
        let mapped = means(&scene, "photonmap", p, 60, 971);
        agree(&format!("matte from {matte}"), &mapped, &path);
    }
}

#[test]
fn light_in_a_glossy_plate_is_counted_once() {
    // Direct light alone, which shadow rays and the plate's own rays both find.
    let mut stage = Stage::new();
    let plate = stage.metal(0.3);
    stage.shape(GeometryDesc::Rectangle, scale(2.0, 2.0, 1.0), plate);
    stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.8, 1.0) * down() * scale(0.5, 0.5, 1.0), 3.0);
    stage.camera(pinhole(40.0), look(v(0.0, -1.5, 1.2), v(0.0, 0.0, 0.0)), SIZE);
    let scene = stage.build();
    let path = means(&scene, "path", json!({"max_depth": 1}), 400, 975);
    let p = with(json!({"max_depth": 1, "matte": 0.9}));
    agree("plate", &means(&scene, "photonmap", p, 400, 976), &path);
}

#[test]
fn differential_checking_leaves_a_uniform_field_nearly_as_it_is() {
    // It looks at the photons to decide where to stop: that moves the mean, by little.
    let scene = furnace(0.5).build();
    let p = with(json!({"max_depth": 4, "gather": 0, "filter": "box", "checking": true}));
    let checked = &renders(&scene, "photonmap", p, 20, 978)[4];
    let truth = (2.0 - 0.5f64.powi(4)) * f64::from(SIZE[0] * SIZE[1]);
    close("checked", checked.mean(), truth, 0.03);
}

/// A glass ball under a small lamp over a floor, and a camera that sees the caustic alone.
fn caustic() -> Stage {
    let mut stage = Stage::new();
    let (white, glass) = (stage.diffuse(0.8), stage.glass(1.5, 0.0));
    stage.shape(GeometryDesc::Rectangle, scale(2.0, 2.0, 1.0), white);
    stage.shape(sphere(0.4), at(0.0, 0.0, 0.8), glass);
    stage.lamp(GeometryDesc::Rectangle, at(0.3, 0.2, 3.0) * down() * scale(0.3, 0.3, 1.0), 20.0);
    stage.camera(parallel(0.25, 0.0, 1.0), look(v(-0.07, -0.05, 0.3), v(-0.07, -0.05, 0.0)), SIZE);
    stage
}

#[test]
fn a_caustic_s_error_falls_with_the_photons_and_ends_at_the_path_tracer_s() {
    let scene = caustic().build();
    let path = means(&scene, "path", json!({"max_depth": 6}), 20_000, 980);
    // 1, 4, 16 times the photons, r² ~ N^(-1/2): the error is the mean of the quarters', of single passes.
    let error = |k: u32| {
        let p = with(json!({
            "max_depth": 6, "photons": 100, "caustic_photons": 500 * k, "caustic_nearest": 1_000_000,
            "caustic_radius": 0.06 * f64::from(k).powf(-0.25),
        }));
        let passes = means(&scene, "photonmap", p, 60, 981);
        // Variance of one pass, and the square of the bias.
        let of =
            |(a, b): (&RunningMean, &RunningMean)| a.variance() + (a.mean() - b.mean()).powi(2);
        passes[..4].iter().zip(&path[..4]).map(of).sum::<f64>().sqrt()
    };
    let errors = [1, 4, 16].map(error);
    for pair in errors.windows(2) {
        assert!(pair[1] < 0.8 * pair[0], "errors {errors:?}");
    }
    let p = with(json!({
        "max_depth": 6, "photons": 100, "caustic_photons": 20_000, "caustic_nearest": 1_000_000,
        "caustic_radius": 0.02, "filter": "box",
    }));
    agree("at zero radius", &at_zero(&scene, &p, 100, 990), &path);
}

#[test]
fn projection_maps_do_not_change_the_mean() {
    // Nothing but the caustic: with the map, photons are dense; the global map's are not aimed.
    let scene = caustic().build();
    let p = |gather: u32| {
        with(json!({
            "max_depth": 6, "gather": gather, "photons": 200_000, "caustic_photons": 5_000,
            "nearest": 1_000_000, "caustic_nearest": 1_000_000, "radius": 0.03,
            "caustic_radius": 0.03, "filter": "box",
        }))
    };
    // Direct light apart: at two bounces and more only the caustic is left.
    let only = |p: Value| {
        let all = means(&scene, "photonmap", p.clone(), 40, 985);
        let mut direct = p;
        direct["max_depth"] = 1.into();
        let direct = means(&scene, "photonmap", direct, 40, 986);
        let difference = |(a, b): (&RunningMean, &RunningMean)| {
            with_error(a.mean() - b.mean(), a.standard_error().hypot(b.standard_error()))
        };
        all.iter().zip(&direct).map(difference).collect::<Vec<_>>()
    };
    for (i, (aimed, not)) in only(p(1)).iter().zip(&only(p(0))).enumerate() {
        same(&format!("part {i}"), aimed, not);
    }
}

#[test]
fn the_cache_s_error_falls_with_its_parameter() {
    // Against a gather at every pixel, from the same map and many rays.
    let scene = room(false).build();
    let p = |extra: Value| {
        let mut p = with(json!({"photons": 20_000, "radius": 0.1, "max_depth": 4, "renew": 1000}));
        let (Value::Object(p), Value::Object(extra)) = (&mut p, extra) else { panic!() };
        p.extend(extra);
        Value::Object(p.clone())
    };
    let gathered = means(&scene, "photonmap", p(json!({"gather": 64})), 40, 995);
    let error = |a: f32| {
        let cached = p(json!({"cache": a, "cache_rays": 2000}));
        let cached = means(&scene, "photonmap", cached, 40, 995);
        let of = |(a, b): (&RunningMean, &RunningMean)| (a.mean() / b.mean() - 1.0).powi(2);
        cached.iter().zip(&gathered).map(of).sum::<f64>().sqrt()
    };
    let errors = [4.0, 0.1].map(error);
    assert!(errors[1] < 0.4 * errors[0], "errors {errors:?}");
    assert!(errors[1] < 0.03, "errors {errors:?}");
}

#[test]
fn dispersed_photons_have_one_wavelength() {
    // In a spectral furnace with nothing that disperses all passes agree in the mean.
    let scene = furnace(0.5).build_in(kaustika_spectra::ColorMode::Spectral);
    let path = means(&scene, "path", json!({"max_depth": 3}), 200, 996);
    let p = with(json!({"max_depth": 3}));
    agree("spectral", &means(&scene, "photonmap", p, 200, 997), &path);
}

#[test]
fn the_radius_shrinks_as_its_schedule_says() {
    let p = |alpha: f32| PhotonMapParams { alpha, ..PhotonMapParams::default() };
    close("first", p(0.5).shrink(0).into(), 1.0, 1e-6);
    close("halved", p(0.5).shrink(15).into(), 0.5, 1e-6);
    close("kept", p(1.0).shrink(99).into(), 1.0, 1e-6);
}
