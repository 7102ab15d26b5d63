//! Direct light in absolute units (instruments DISC and PENUMBRA).

use crate::scenes::*;
use crate::stats::{agrees, close};
use kaustika_math::Vec3;
use kaustika_scene::description::*;
use serde_json::json;
use std::f64::consts::PI;

const MODES: [&str; 3] = ["power", "light", "bsdf"];

/// E = (L/2) Σ Θᵢ (Γᵢ·n) of a polygon of radiance L at a point, anticlockwise from there.
pub(crate) fn lambert(l: f64, corners: &[[f64; 3]], p: [f64; 3]) -> f64 {
    let sub = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let unit = |a: [f64; 3]| a.map(|c| c / dot(a, a).sqrt());
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let n = corners.len();
    let sum: f64 = (0..n)
        .map(|i| {
            let (a, b) = (unit(sub(corners[i], p)), unit(sub(corners[(i + 1) % n], p)));
            dot(a, b).acos() * unit(cross(a, b))[2]
        })
        .sum();
    0.5 * l * sum.abs()
}

#[test]
fn a_disc_above_the_receiver() {
    let mut stage = Stage::new();
    floor(&mut stage);
    stage.lamp(disk(0.7), at(0.0, 0.0, 1.5) * down(), 3.0);
    let truth = PI * 3.0 * 0.49 / (0.49 + 2.25);
    for mis in MODES {
        let e = irradiance(&stage.build(), 0.0, 0.0, json!({"mis": mis}), 20_000);
        agrees(&format!("disc, {mis}"), &e, truth);
    }
}

#[test]
fn a_sphere_above_the_horizon() {
    let mut stage = Stage::new();
    floor(&mut stage);
    let c = v(0.9, 0.5, 1.4);
    stage.lamp(sphere(0.6), at(c.x, c.y, c.z), 2.0);
    let d = c.length() as f64;
    let truth = PI * 2.0 * (0.6 / d).powi(2) * c.z as f64 / d;
    for mis in MODES {
        let e = irradiance(&stage.build(), 0.0, 0.0, json!({"mis": mis}), 20_000);
        agrees(&format!("sphere, {mis}"), &e, truth);
    }
}

#[test]
fn a_polygon_by_lambert_s_formula() {
    let corners = [[0.4, -0.6, 1.0], [1.3, 0.2, 1.6], [-0.5, 0.9, 0.8]];
    let points = corners.map(|c: [f64; 3]| v(c[0] as f32, c[1] as f32, c[2] as f32));
    let mut stage = Stage::new();
    floor(&mut stage);
    let front = (points[1] - points[0]).cross(points[2] - points[0]).z < 0.0;
    let indices = if front { [0, 1, 2] } else { [0, 2, 1] };
    stage.lamp(mesh(&points, &[indices]), HERE, 5.0);
    for mis in MODES {
        let e = irradiance(&stage.build(), 0.1, -0.2, json!({"mis": mis}), 20_000);
        agrees(&format!("triangle, {mis}"), &e, lambert(5.0, &corners, [0.1, -0.2, 0.0]));
    }
}

/// E = π L sin² r cos θ of a whole disc at infinity, and its flux through the scene's disk.
#[test]
fn the_sun() {
    for (radius, cos) in [(0.2679f32, 0.8f64), (4.0, 0.6), (25.0, 0.7)] {
        let mut stage = Stage::new();
        floor(&mut stage);
        let sin = (1.0 - cos * cos).sqrt() as f32;
        let toward = look(v(0.0, 0.0, 0.0), v(sin * 0.6, sin * 0.8, cos as f32));
        stage.light(LightKind::Sun { radiance: grey(5.0), scale: 2.0, radius }, toward);
        let r = f64::from(radius).to_radians();
        for mis in ["power", "light"] {
            let e = irradiance(&stage.build(), 0.0, 0.0, json!({"mis": mis}), 20_000);
            agrees(&format!("sun of {radius}, {mis}"), &e, PI * 10.0 * r.sin().powi(2) * cos);
        }
    }
}

/// E = ∫ L cos θ dω over the formula's radiance, by the midpoint rule.
#[test]
fn a_clear_sky() {
    use kaustika_spectra::{ColorMode, HosekSky, Wavelengths};
    let sun = v(0.48, 0.64, 0.6);
    for turbidity in [1.5, 3.0, 8.0] {
        let model = HosekSky::new(turbidity, &grey(0.3), 0.6f32.asin(), ColorMode::Rgb);
        let n = 400;
        let mut truth = 0.0f64;
        for k in 0..n * n {
            let u = v2((k % n) as f32 + 0.5, (k / n) as f32 + 0.5) / n as f32;
            let d = kaustika_math::warp::cosine_hemisphere(u);
            truth += f64::from(model.radiance(d.z, d.dot(sun), &Wavelengths::rgb()).0[0]);
        }
        truth *= PI / (n * n) as f64;
        let mut stage = Stage::new();
        floor(&mut stage);
        let sky = SkyDesc { turbidity, albedo: grey(0.3), sun, stretch: 1.0, extend: false };
        stage.light(LightKind::Sky { sky, scale: 1.0 }, HERE);
        for mis in MODES {
            let e = irradiance(&stage.build(), 0.0, 0.0, json!({"mis": mis}), 20_000);
            agrees(&format!("sky {turbidity}, {mis}"), &e, truth);
        }
    }
}

#[test]
fn uniform_and_half_skies() {
    for (wall, truth) in [(false, 1.0), (true, 0.5)] {
        let mut stage = Stage::new();
        floor(&mut stage);
        stage.sky(1.0);
        if wall {
            // A black wall hides half the sky, up to what lies above it at a great height.
            let black = stage.diffuse(0.0);
            let t = at(1e-4, 0.0, 0.0) * rotate(90.0, Vec3::Y) * scale(1e4, 1e4, 1.0);
            stage.shape(GeometryDesc::Rectangle, t, black);
        }
        for mis in MODES {
            let e = irradiance(&stage.build(), 0.0, 0.0, json!({"mis": mis}), 20_000);
            agrees(&format!("sky, wall {wall}, {mis}"), &e, PI * truth);
        }
    }
}

#[test]
fn point_spot_and_parallel_light_follow_distance_and_cosine() {
    let p = json!({"max_depth": 1});
    let mut stage = Stage::new();
    floor(&mut stage);
    stage.point_light(v(0.6, 0.0, 0.8), 3.0);
    let e = irradiance(&stage.build(), 0.0, 0.0, p.clone(), 2);
    close("point", e.mean(), 3.0 * 0.8, 1e-5);

    let mut stage = Stage::new();
    floor(&mut stage);
    let (intensity, scale) = (grey(2.0), 1.5);
    stage.light(
        LightKind::Spot {
            intensity,
            scale,
            power: None,
            cutoff: 40.0,
            beam_width: 20.0,
            falloff: SpotFalloff::LinearAngle,
            texture: None,
        },
        look(v(0.0, 0.0, 2.0), v(0.0, 0.0, 0.0)),
    );
    let scene = stage.build();
    close("spot axis", irradiance(&scene, 0.0, 0.0, p.clone(), 2).mean(), 3.0 / 4.0, 1e-5);
    // At 30 degrees half of the intensity is left.
    let cos = (30f64).to_radians().cos();
    let x = 2.0 * (30f32).to_radians().tan();
    let edge = 1.5 * cos * (cos / 2.0).powi(2);
    close("spot edge", irradiance(&scene, x, 0.0, p.clone(), 2).mean(), edge, 1e-4);
    assert_eq!(irradiance(&scene, 1.8, 0.0, p.clone(), 2).mean(), 0.0);

    let mut stage = Stage::new();
    floor(&mut stage);
    let kind = LightKind::Directional { irradiance: grey(2.0), scale: 1.0, illuminance: None };
    stage.light(kind, look(v(3.0, 0.0, 4.0), v(0.0, 0.0, 0.0)));
    close("parallel", irradiance(&stage.build(), 0.5, 0.3, p, 2).mean(), 2.0 * 0.8, 1e-5);
}

#[test]
fn power_given_in_watts_is_emitted() {
    // pbrt's `power`: a point light of Φ watts has intensity Φ/4π.
    let mut stage = Stage::new();
    floor(&mut stage);
    let kind = LightKind::Point { intensity: grey(1.0), scale: 1.0, power: Some(40.0) };
    stage.light(kind, at(0.0, 0.0, 2.0));
    let e = irradiance(&stage.build(), 0.0, 0.0, json!({"max_depth": 1}), 2);
    close("point", e.mean(), 40.0 / (4.0 * PI) / 4.0, 1e-5);

    // A disc of Φ watts has radiance Φ/(πA), also where a mesh shares it.
    for square in [false, true] {
        let mut stage = Stage::new();
        floor(&mut stage);
        let form = if square { GeometryDesc::Rectangle } else { disk(0.5) };
        let t = at(0.0, 0.0, 1.0) * down() * scale(0.5, 0.5, 1.0);
        stage.lamp(form, t, 1.0).emission.as_mut().expect("a lamp").power = Some(10.0);
        let scene = stage.build();
        let area = if square { 1.0 } else { PI * 0.25 * 0.25 };
        let seen = probe(&scene, v(0.1, 0.05, 0.5), v(0.0, 0.0, 1.0), json!({}), 1).0;
        close("radiance", seen.mean(), 10.0 / (PI * area), 1e-4);
    }
}

#[test]
fn scaling_all_sources_scales_every_pixel() {
    let picture = |k: f32| {
        let mut stage = Stage::new();
        floor(&mut stage);
        let m = stage.metal(0.2);
        stage.shape(sphere(0.4), at(0.3, 0.0, 0.4), m);
        stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, 2.0) * down(), 3.0 * k);
        stage.lamp(sphere(0.1), at(-1.0, 0.5, 0.6), 20.0 * k);
        stage.point_light(v(1.0, 1.0, 1.0), 2.0 * k);
        stage.sky(0.25 * k);
        stage.camera(pinhole(50.0), look(v(0.0, -3.0, 1.5), v(0.0, 0.0, 0.3)), [8, 8]);
        stage.render(json!({}), 8, 12)
    };
    let (one, eight) = (picture(1.0), picture(8.0));
    for (a, b) in one.pixels.iter().zip(&eight.pixels) {
        // A power of two changes no rounding.
        assert_eq!(8.0 * a.mean(), b.mean());
    }
}

#[test]
fn a_penumbra_has_the_width_and_the_ramp_of_geometry() {
    // Light of width w, its long edges along y; an occluder's edge at x = 0, d1 below it and d2
    // above the floor: the penumbra is w d2/d1 wide.
    let (w, d1, d2) = (0.3f64, 3.0f64, 1.5f64);
    let mut stage = Stage::new();
    floor(&mut stage);
    let half = (0.5 * w) as f32;
    let h = (d1 + d2) as f32;
    stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, h) * down() * scale(half, half, 1.0), 1.0);
    let black = stage.diffuse(0.0);
    let t = at(-1.0, 0.0, d2 as f32) * scale(1.0, 0.5, 1.0);
    stage.shape(GeometryDesc::Rectangle, t, black);
    let scene = stage.build();
    let width = w * d2 / d1;
    let probe_at = |x: f64| irradiance(&scene, x as f32, 0.0, json!({"max_depth": 1}), 4000);
    let full = irradiance(&scene, 1.5 * width as f32, 0.0, json!({"max_depth": 1}), 4000);
    for i in 0..=10 {
        let x = width * (i as f64 / 10.0 - 0.5) * 1.2;
        // The floor point sees what lies beyond the edge, projected onto the light.
        let cut = (-x * d1 / d2).clamp(-0.5 * w, 0.5 * w);
        let (y, z) = (0.5 * w, d1 + d2);
        let seen = [[cut, -y, z], [0.5 * w, -y, z], [0.5 * w, y, z], [cut, y, z]];
        let e = probe_at(x);
        let truth = if cut < 0.5 * w { lambert(1.0, &seen, [x, 0.0, 0.0]) } else { 0.0 };
        agrees(&format!("penumbra at {x:.3}"), &e, truth);
        // Small light far away: linear to a percent.
        let ramp = (0.5 + x / width).clamp(0.0, 1.0);
        let room = 0.01 + 5.0 * (e.standard_error() + full.standard_error()) / full.mean();
        assert!((e.mean() / full.mean() - ramp).abs() < room, "ramp at {x:.3}");
    }
}

#[test]
fn what_stands_behind_a_light_does_not_shade() {
    // Every kind of shape casts a shadow, and only on what is behind it.
    for (form, t) in [
        (sphere(0.3), at(0.0, 0.0, 1.0)),
        (disk(0.3), at(0.0, 0.0, 1.0)),
        (
            GeometryDesc::Cylinder { radius: 0.3, z_min: -1.0, z_max: 1.0, phi_max: 360.0 },
            at(0.0, 0.0, 1.0) * rotate(90.0, Vec3::X),
        ),
        (GeometryDesc::Rectangle, at(0.0, 0.0, 1.0) * scale(0.3, 0.3, 1.0)),
        (GeometryDesc::Cube, at(0.0, 0.0, 1.0) * scale(0.3, 0.3, 0.3)),
    ] {
        for (height, lit) in [(0.5, true), (2.0, false)] {
            let mut stage = Stage::new();
            floor(&mut stage);
            let black = stage.diffuse(0.0);
            stage.shape(form.clone(), t, black);
            stage.point_light(v(0.0, 0.0, height), 1.0);
            let e = irradiance(&stage.build(), 0.0, 0.0, json!({"max_depth": 1}), 2);
            assert_eq!(e.mean() > 0.0, lit, "{form:?} under a light at {height}");
        }
    }
}
