//! Meters against closed forms: inverse square, cosine, configuration factors.

use crate::scenes::*;
use crate::stats::agrees;
use kaustika_math::{Transform, Vec3};
use kaustika_scene::description::*;
use serde_json::json;
use std::f64::consts::PI;

/// A stage whose first shape, black, carries a meter of one pixel.
fn metered(form: GeometryDesc, t: Transform, flux: bool) -> Stage {
    let mut stage = Stage::new();
    let black = stage.diffuse(0.0);
    stage.shape(form, t, black);
    stage.camera(CameraKind::Irradiance { shape: 0, flux }, HERE, [1, 1]);
    stage
}

/// Every way to sample must give what theory says.
fn measures(what: &str, stage: &Stage, truth: f64, modes: &[&str]) {
    for mis in modes {
        let p = json!({"mis": mis, "max_depth": 0});
        let found = stage.render(p, 40_000, 7);
        agrees(&format!("{what}, {mis}"), found.at(0, 0), truth);
    }
}

const ALL: [&str; 3] = ["power", "light", "bsdf"];

/// ∫ over a rectangle around (0, 0), a point of intensity I at height h above: Φ = I Ω, where
/// Ω = 4 asin(ab / √((a² + h²)(b² + h²))).
#[test]
fn flux_of_a_point_light_through_a_rectangle() {
    for (a, b, h) in [(1.0f32, 0.5f32, 0.8f32), (0.1, 0.1, 2.0)] {
        let mut stage = metered(GeometryDesc::Rectangle, scale(a, b, 1.0), true);
        stage.point_light(v(0.0, 0.0, h), 3.0);
        let [a, b, h] = [a, b, h].map(f64::from);
        let solid_angle = 4.0 * (a * b / ((a * a + h * h) * (b * b + h * h)).sqrt()).asin();
        measures("flux", &stage, 3.0 * solid_angle, &ALL);
    }
}

/// E = I cos θ / d² on so small a rectangle that it is a point.
#[test]
fn inverse_square_and_cosine() {
    for (x, h) in [(0.0f32, 1.0f32), (0.7, 1.5), (2.0, 0.5)] {
        let mut stage = metered(GeometryDesc::Rectangle, scale(1e-3, 1e-3, 1.0), false);
        stage.point_light(v(x, 0.0, h), 3.0);
        let d2 = f64::from(x * x + h * h);
        measures("point", &stage, 3.0 * f64::from(h) / d2.powf(1.5), &["power"]);
    }
    // Half as much where it is turned by 60°.
    let turned = rotate(60.0, Vec3::X) * scale(1e-3, 1e-3, 1.0);
    let mut stage = metered(GeometryDesc::Rectangle, turned, false);
    stage.point_light(v(0.0, 0.0, 2.0), 3.0);
    measures("turned", &stage, 3.0 * 0.5 / 4.0, &["power"]);
}

/// E = π L (r/d)² cos θ of a sphere above the horizon.
#[test]
fn a_sphere() {
    let mut stage = metered(GeometryDesc::Rectangle, scale(1e-3, 1e-3, 1.0), false);
    let c = v(0.9, 0.5, 1.4);
    stage.lamp(sphere(0.6), at(c.x, c.y, c.z), 2.0);
    let d = f64::from(c.length());
    measures("sphere", &stage, PI * 2.0 * (0.6 / d).powi(2) * f64::from(c.z) / d, &ALL);
}

/// Φ = L π A F₁₂ between equal rectangles, parallel and facing each other: with X = a/c, Y = b/c
/// (Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", C-11)
/// F₁₂ = 2/(πXY) (ln √((1 + X²)(1 + Y²)/(1 + X² + Y²)) + X √(1 + Y²) atan(X/√(1 + Y²))
///       + Y √(1 + X²) atan(Y/√(1 + X²)) - X atan X - Y atan Y).
#[test]
fn configuration_factors_of_rectangles() {
    for (a, b, c) in [(2.0f64, 1.0f64, 0.7f64), (1.0, 1.0, 3.0)] {
        let (x, y) = (a / c, b / c);
        let (rx, ry) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
        let log = (rx * ry / (1.0 + x * x + y * y).sqrt()).ln();
        let sum =
            log + x * ry * (x / ry).atan() + y * rx * (y / rx).atan() - x * x.atan() - y * y.atan();
        let factor = 2.0 / (PI * x * y) * sum;
        let size = scale(0.5 * a as f32, 0.5 * b as f32, 1.0);
        let mut stage = metered(GeometryDesc::Rectangle, size, true);
        stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, c as f32) * down() * size, 5.0);
        measures("rectangles", &stage, 5.0 * PI * a * b * factor, &ALL);
    }
}

/// E = π L on anything convex under a sky all around; flux by its area.
#[test]
fn every_shape_measures() {
    let cube = metered(GeometryDesc::Cube, scale(1.0, 0.5, 0.2), true);
    let ball = metered(sphere(0.5), at(0.3, 0.0, 0.0), true);
    let ellipsoid = metered(sphere(1.0), scale(1.0, 0.4, 2.0), false);
    let plate = metered(disk(0.5), rotate(30.0, Vec3::X), false);
    let points = [v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(1.0, 1.0, 0.5), v(0.0, 1.0, 0.5)];
    let tiles = metered(mesh(&points, &[[0, 1, 2], [0, 2, 3]]), HERE, false);
    let areas = [8.0 * (0.5 + 0.2 + 0.1), PI, 1.0, 1.0, 1.0];
    for (mut stage, area) in [cube, ball, ellipsoid, plate, tiles].into_iter().zip(areas) {
        stage.sky(2.0);
        measures("convex", &stage, 2.0 * PI * area, &ALL);
    }
}

/// Light that comes by way of a wall is measured, too: between two planes that send on half of
/// it, E = E₀ (1 + ½ F), where both are so wide that F = 1 and the lamp is the other plane.
#[test]
fn indirect_light_counts() {
    let mut stage = Stage::new();
    let grey = stage.diffuse(0.5);
    stage.shape(GeometryDesc::Rectangle, scale(500.0, 500.0, 1.0), grey);
    stage.camera(CameraKind::Irradiance { shape: 0, flux: false }, HERE, [1, 1]);
    let lamp = at(0.0, 0.0, 1.0) * down() * scale(500.0, 500.0, 1.0);
    stage.lamp(GeometryDesc::Rectangle, lamp, 1.0).material = grey;
    let found = stage.render(json!({"max_depth": 40, "roulette": "none"}), 20_000, 3);
    let e = found.at(0, 0);
    // E = π + ¼ E, less what leaves at the border: 1/500 of it at most.
    let truth = PI / 0.75;
    assert!((e.mean() / truth - 1.0).abs() < 0.01, "{} {truth}", e.mean());
}

/// The pixels of a rectangle's film lie side by side.
#[test]
fn a_map_of_irradiance() {
    let mut stage = Stage::new();
    let black = stage.diffuse(0.0);
    stage.shape(GeometryDesc::Rectangle, scale(2.0, 1.0, 1.0), black);
    stage.camera(CameraKind::Irradiance { shape: 0, flux: false }, HERE, [4, 1]);
    stage.point_light(v(-1.5, 0.0, 1.0), 1.0);
    let found = stage.render(json!({"max_depth": 0}), 40_000, 9);
    let solid_angle = |x: f64, y: f64| (x * y / ((x * x + 1.0) * (y * y + 1.0)).sqrt()).asin();
    for i in 0..4u32 {
        let [from, to] = [f64::from(i) - 0.5, f64::from(i) + 0.5];
        let flux = 2.0 * (solid_angle(to, 1.0) - solid_angle(from, 1.0));
        agrees(&format!("column {i}"), found.at(i, 0), flux / 2.0);
    }
}

#[test]
fn radiance_and_distant_light() {
    let mut stage = Stage::new();
    let m = stage.diffuse(0.4);
    stage.shape(GeometryDesc::Rectangle, HERE, m);
    let sun = LightKind::Directional { irradiance: grey(2.0), scale: 1.0, illuminance: None };
    stage.light(sun, down());
    // L = ρ E / π.
    let truth = 0.4 * 2.0 / PI;
    let looking = look(v(0.5, 0.5, 3.0), v(0.2, 0.1, 0.0));
    let toward = look(v(0.0, 0.0, 3.0), v(0.0, 0.0, 0.0));
    let rectangle = MeterTarget::Rectangle(scale(0.5, 0.5, 1.0));
    for (kind, t, truth) in [
        (CameraKind::Radiance, looking, truth),
        (CameraKind::Distant { target: MeterTarget::Point(v(0.1, 0.2, 0.0)) }, toward, truth),
        (CameraKind::Distant { target: rectangle }, looking, truth),
        // The square fills 2/π of the disc about it.
        (CameraKind::Distant { target: MeterTarget::Scene }, toward, truth * 2.0 / PI),
    ] {
        stage.camera(kind.clone(), t, [1, 1]);
        let found = stage.render(json!({"max_depth": 1}), 20_000, 5);
        agrees(&format!("{kind:?}"), found.at(0, 0), truth);
    }
    // Side by side: what each sees alone.
    let part = |o: Vec3| {
        let mut stage = Stage::new();
        stage.camera(CameraKind::Radiance, look(o, o - Vec3::Z), [1, 1]);
        stage.d.cameras.remove(0)
    };
    let cameras = vec![part(v(0.0, 0.0, 1.0)), part(v(5.0, 0.0, 1.0))];
    stage.camera(CameraKind::Batch { cameras }, HERE, [2, 1]);
    let found = stage.render(json!({"max_depth": 1}), 100, 5);
    agrees("left", found.at(0, 0), truth);
    assert_eq!(found.at(1, 0).mean(), 0.0);
}

#[test]
fn a_meter_needs_a_surface() {
    let mut stage = Stage::new();
    stage.camera(CameraKind::Irradiance { shape: 3, flux: false }, HERE, [1, 1]);
    let options = kaustika_scene::SceneOptions {
        mode: kaustika_spectra::ColorMode::Rgb,
        camera: 0,
        resolution: None,
        light_selection: None,
    };
    let error = kaustika_scene::Scene::build(&stage.d, &options).expect_err("it has no area");
    assert_eq!(error.to_string(), "what this sensor measures at has no area");
}
