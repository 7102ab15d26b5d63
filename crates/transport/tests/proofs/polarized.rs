//! Polarized light: optical benches with closed forms, and the unpolarized path where nothing
//! depends on polarization.

use crate::scenes::*;
use crate::stats::{agrees, close};
use kaustika_film::FilterDesc;
use kaustika_film::accumulate::{Feature, Layers, PassImage};
use kaustika_math::{Transform, Vec3};
use kaustika_sampling::estimator::RunningMean;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::description::*;
use kaustika_transport::path::{Integrator, PathTracer};
use kaustika_transport::{Frame, Method, PassStats, Workers};
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// S₀ to S₃ in the middle of the picture, first colour component.
fn stokes(stage: &Stage, p: Value, n: u64) -> [RunningMean; 4] {
    let (scene, resolution) = (stage.build(), stage.resolution());
    let config = SamplerConfig { kind: SamplerKind::Independent, seed: 3, spp: n, resolution };
    let frame = Frame::new(resolution, FilterDesc::BOX, config);
    let p = params(p);
    let integrator = Integrator::new(&scene, &frame, &p);
    let mut stats = PassStats::default();
    let mut means = [(); 4].map(|()| RunningMean::new());
    for index in 0..n {
        let s = integrator.stokes(resolution.map(|r| r / 2), index, &mut stats);
        means.iter_mut().zip(s).for_each(|(m, s)| m.push(f64::from(s[0])));
    }
    assert_eq!(stats.bad_samples, 0);
    means
}

/// One narrow pixel from `o` toward `target`, `up` at its top.
fn narrow(stage: &mut Stage, o: Vec3, target: Vec3, up: Vec3) {
    let to_world = Transform::look_at(o, target, up).expect("two points");
    stage.camera(pinhole(0.01), to_world, [1, 1]);
}

fn expect(what: &str, got: &[RunningMean; 4], expected: [f64; 4], tolerance: f64) {
    for (i, (got, expected)) in got.iter().zip(expected).enumerate() {
        let difference = (got.mean() - expected).abs();
        assert!(difference < tolerance, "{what}, S{i}: {}, expected {expected}", got.mean());
    }
}

/// A camera that looks down -z at a lamp of radiance 1, with z = 1, 2, ... for what is between.
struct Bench(Stage);

impl Bench {
    fn new() -> Bench {
        let mut stage = Stage::new();
        narrow(&mut stage, v(0.0, 0.0, 9.0), v(0.0, 0.0, 0.0), Vec3::Y);
        stage.lamp(GeometryDesc::Rectangle, scale(50.0, 50.0, 1.0), 1.0);
        Bench(stage)
    }

    /// Light comes from the lamp, so that the first filter is the one at the lowest z.
    fn filter(&mut self, z: f32, element: FilterModel) {
        let transmittance = self.0.d.float(1.0);
        let m = self.0.material(MaterialModel::Filter { element, transmittance });
        self.0.shape(GeometryDesc::Rectangle, at(0.0, 0.0, z), m);
    }

    /// Passes light at `degrees` counterclockwise from the picture's rows.
    fn polarizer(&mut self, z: f32, degrees: f32) {
        let theta = self.0.d.float(-degrees);
        self.filter(z, FilterModel::Linear { theta });
    }

    /// Fast axis at `theta`, counterclockwise from the picture's rows.
    fn retarder(&mut self, z: f32, theta: f32, delta: f32) {
        let (theta, delta) = (self.0.d.float(theta), self.0.d.float(delta));
        self.filter(z, FilterModel::Retarder { theta, delta });
    }

    fn seen(&self) -> [RunningMean; 4] {
        stokes(&self.0, json!({"roulette": "none"}), 4)
    }
}

/// Malus 1810: cos² of the angle between two polarizers, 1/8 through three by 45° each.
#[test]
fn polarizers_obey_malus() {
    for degrees in [0.0f32, 25.0, 45.0, 60.0, 90.0, 150.0] {
        let mut bench = Bench::new();
        bench.polarizer(1.0, 10.0);
        bench.polarizer(2.0, 10.0 + degrees);
        let (passed, axis) = (0.5 * f64::from(degrees.to_radians().cos()).powi(2), 10.0 + degrees);
        let (sin, cos) = (2.0 * f64::from(axis)).to_radians().sin_cos();
        expect("two", &bench.seen(), [passed, passed * cos, passed * sin, 0.0], 1e-5);
    }
    let mut bench = Bench::new();
    for (z, degrees) in [(1.0, 0.0), (2.0, 45.0), (3.0, 90.0)] {
        bench.polarizer(z, degrees);
    }
    expect("three", &bench.seen(), [0.125, -0.125, 0.0, 0.0], 1e-5);
}

/// A polarizer at 45° and a quarter-wave plate make circular light: left, by a fast axis along
/// the rows; the circular filter of that handedness passes all of it, the other none.
#[test]
fn a_quarter_wave_plate_makes_circular_light() {
    for (theta, sign) in [(0.0, -1.0), (90.0, 1.0)] {
        let mut bench = Bench::new();
        bench.polarizer(1.0, 45.0);
        bench.retarder(2.0, theta, 90.0);
        expect("circular", &bench.seen(), [0.5, 0.0, 0.0, 0.5 * sign], 1e-5);
        for left_handed in [true, false] {
            let mut bench = Bench(bench.0.clone());
            bench.filter(3.0, FilterModel::Circular { left_handed });
            let passed = if left_handed == (sign < 0.0) { 0.5 } else { 0.0 };
            expect("filtered", &bench.seen(), [passed, 0.0, 0.0, passed * sign], 1e-5);
        }
    }
}

/// Glass under Brewster's angle reflects s alone; a polarizer before the camera that turns
/// extinguishes the reflection as cos².
#[test]
fn a_polarizer_extinguishes_brewsters_reflection() {
    let brewster = 1.5f32.atan();
    let reflectance = 0.147_929_f64 / 2.0;
    for degrees in [0.0f32, 30.0, 60.0, 90.0] {
        let mut stage = Stage::new();
        let glass = stage.glass(1.5, 0.0);
        stage.shape(GeometryDesc::Rectangle, scale(5.0, 5.0, 1.0), glass);
        // The mirror image of the camera's ray ends on a lamp; below the glass it is dark.
        let d = v(brewster.sin(), 0.0, -brewster.cos());
        stage.lamp(sphere(1.0), Transform::translate(v(d.x, 0.0, -d.z) * 8.0), 1.0);
        narrow(&mut stage, d * -4.0, v(0.0, 0.0, 0.0), Vec3::Z);
        let theta = stage.d.float(-degrees);
        let (element, transmittance) = (FilterModel::Linear { theta }, stage.d.float(1.0));
        let filter = stage.material(MaterialModel::Filter { element, transmittance });
        let facing = Transform::look_at(d * -3.0, d * -4.0, Vec3::Z).expect("two points");
        let plain = stokes(&stage, json!({"roulette": "none"}), 20_000);
        // s lies along the rows.
        agrees("S₀", &plain[0], reflectance);
        agrees("S₁", &plain[1], reflectance);
        // The filter's u runs along the rows, seen from the camera.
        stage.shape(GeometryDesc::Rectangle, facing, filter);
        let seen = stokes(&stage, json!({"roulette": "none"}), 20_000);
        let cos2 = f64::from(degrees.to_radians().cos()).powi(2);
        assert!((seen[0].mean() - reflectance * cos2).abs() < 2e-3, "{degrees}: {seen:?}");
    }
}

/// A slab before a lamp, with all reflections between its faces, each polarization for itself:
/// T = ((1 - Rₛ)/(1 + Rₛ) + (1 - R_p)/(1 + R_p))/2. A pane polarizes as much; what it passes is, as
/// without polarization, (1 - R)/(1 + R) of the mean R.
#[test]
fn a_slab_adds_the_orders_of_each_polarization() {
    for degrees in [30.0f32, 56.31, 75.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let (c, q) = (f64::from(cos), f64::from(2.25 - sin * sin).sqrt());
        let (rs, rp) = ((c - q) / (c + q), (2.25 * c - q) / (2.25 * c + q));
        let through = |r: f64| (1.0 - r) / (1.0 + r);
        let (ts, tp, r) = (through(rs * rs), through(rp * rp), 0.5 * (rs * rs + rp * rp));
        for pane in [false, true] {
            let mut stage = Stage::new();
            stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, -2.0) * scale(80.0, 80.0, 1.0), 1.0);
            if pane {
                let factor = stage.d.float(1.0);
                let m = stage.material(MaterialModel::ThinDielectric {
                    ior: IorDesc::Constant(1.5),
                    specular_reflectance: factor,
                    specular_transmittance: factor,
                });
                stage.shape(GeometryDesc::Rectangle, scale(50.0, 50.0, 1.0), m);
            } else {
                let glass = stage.glass(1.5, 0.0);
                stage.shape(GeometryDesc::Cube, scale(50.0, 50.0, 0.2), glass);
            }
            narrow(&mut stage, v(-sin, 0.0, cos), v(0.0, 0.0, 0.0), Vec3::Y);
            // The plane of incidence lies along the rows: s is S₁ < 0.
            let seen = stokes(&stage, json!({"rr_depth": 100}), 60_000);
            let what = format!("{degrees}°, pane {pane}");
            let passed = if pane { through(r) } else { 0.5 * (ts + tp) };
            agrees(&format!("{what}, S₀"), &seen[0], passed);
            agrees(&format!("{what}, S₁"), &seen[1], passed * (tp - ts) / (tp + ts));
            assert!(seen[2].mean().abs() < 1e-3 && seen[3].mean().abs() < 1e-3);
        }
    }
}

/// Light at 45° that a metal reflects becomes elliptic, by the phases of its complex index: gold,
/// 0.143 + 3.98i, at 60° (ρ = -0.744831 - 0.633827i by complex arithmetic).
#[test]
fn metals_make_elliptic_light() {
    let mut stage = Stage::new();
    let (eta, k) = (stage.d.float(0.143), stage.d.float(3.98));
    let (roughness, one) = (stage.rough(0.0), stage.d.float(1.0));
    let gold = stage.material(MaterialModel::Conductor {
        color: ConductorColor::EtaK { eta, k },
        specular_reflectance: one,
        roughness,
    });
    stage.shape(GeometryDesc::Rectangle, scale(5.0, 5.0, 1.0), gold);
    let (sin, cos) = 60f32.to_radians().sin_cos();
    let (from, to) = (v(-sin, 0.0, cos), v(sin, 0.0, cos));
    narrow(&mut stage, from * 4.0, v(0.0, 0.0, 0.0), Vec3::Z);
    // A polarizer before the lamp, that passes light at 45° to the plane of incidence.
    let facing = Transform::look_at(to * 3.0, v(0.0, 0.0, 0.0), Vec3::Z).expect("two points");
    let (theta, transmittance) = (stage.d.float(45.0), stage.d.float(1.0));
    let element = FilterModel::Linear { theta };
    let filter = stage.material(MaterialModel::Filter { element, transmittance });
    stage.shape(GeometryDesc::Rectangle, facing, filter);
    stage.lamp(sphere(1.0), Transform::translate(to * 8.0), 1.0);
    let seen = stokes(&stage, json!({"roulette": "none"}), 4).map(|s| s.mean());
    // |ρ|, and the phase between both components, from the Stokes vector.
    let (rho2, phase) = ((seen[0] - seen[1]) / (seen[0] + seen[1]), seen[3].atan2(seen[2]));
    close("|ρ|²", rho2, 0.744831f64.powi(2) + 0.633827f64.powi(2), 1e-4);
    // 180° - 139.603°: of which sign depends on that of the diagonal before the lamp.
    let phase = phase.to_degrees().abs();
    assert!((phase - 139.603).abs() < 0.05 || (phase - 40.397).abs() < 0.05, "{phase}");
    close(
        "polarized fully",
        (seen[1].powi(2) + seen[2].powi(2) + seen[3].powi(2)).sqrt(),
        seen[0],
        1e-5,
    );
}

/// Rough spheres and glass in a room of matte walls.
fn room() -> Stage {
    let mut stage = Stage::new();
    let wall = stage.diffuse(0.6);
    stage.shape(GeometryDesc::Rectangle, scale(4.0, 4.0, 1.0), wall);
    let (metal, glass) = (stage.metal(0.3), stage.glass(1.5, 0.2));
    stage.shape(sphere(0.5), at(-0.6, 0.0, 0.5), metal);
    stage.shape(sphere(0.5), at(0.6, 0.0, 0.5), glass);
    stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, 3.0) * down(), 4.0);
    stage.sky(0.2);
    let eye = Transform::look_at(v(0.0, -4.0, 2.0), v(0.0, 0.0, 0.4), Vec3::Z).expect("two points");
    stage.camera(pinhole(35.0), eye, [8, 6]);
    stage
}

/// Passes by the method.
fn passes(stage: &Stage, p: Value, count: u64) -> Vec<PassImage> {
    let (scene, resolution) = (stage.build(), stage.resolution());
    let kind = SamplerKind::Independent;
    let config = SamplerConfig { kind, seed: 5, spp: count, resolution };
    let mut frame = Frame::new(resolution, FilterDesc::BOX, config);
    frame.layers = Layers::new(&[Feature::Stokes, Feature::Depth]);
    let mut method = PathTracer::new(params(p)).alone();
    let workers = Workers::new(2, Arc::new(AtomicBool::new(false))).expect("threads");
    method.prepare(&scene, &frame, &workers).expect("prepared");
    let pass = |index| {
        let mut image = PassImage::new(resolution[0], resolution[1], frame.layers.clone());
        method.pass(index, &scene, &frame, &mut image, &workers).expect("a pass");
        image
    };
    (0..count).map(pass).collect()
}

/// With one bounce nothing depends on polarization: S₀ is the unpolarized picture, sample by
/// sample but for rounding, on which decisions of a few samples may hang.
#[test]
fn s0_of_one_bounce_is_the_unpolarized_picture() {
    let stage = room();
    for mis in ["power", "light", "bsdf"] {
        let p = |polarized: bool| json!({"max_depth": 1, "mis": mis, "polarized": polarized});
        let (mut differ, mut lit) = (0, 0);
        for (with, without) in passes(&stage, p(true), 40).iter().zip(passes(&stage, p(false), 40))
        {
            let stride = with.layers().stride();
            let offset = with.layers().offset(Feature::Stokes).expect("kept");
            for (a, b) in with.data().chunks(stride).zip(without.data().chunks(stride)) {
                differ += usize::from((a[0] - b[0]).abs() > 1e-3 * b[0].max(1e-3));
                lit += usize::from(b[0] > 0.0);
                assert_eq!(a[0..3], a[offset..offset + 3], "S₀ is the colour");
                assert_eq!(a[4], b[4], "other features are kept too");
            }
        }
        assert!(differ <= 2 && lit > 500, "{mis}: {differ} of {lit} differ");
    }
}

/// Within a furnace whatever polarization does, it adds no light and loses none: glass, rough and
/// smooth, and panes see the field.
#[test]
fn a_furnace_is_unpolarized() {
    let mut stage = Stage::new();
    let glass = stage.glass(1.5, 0.0);
    stage.shape(sphere(1.0), at(0.0, 0.0, 0.0), glass);
    let mirror = stage.metal(0.0);
    stage.shape(GeometryDesc::Rectangle, at(0.0, 0.0, -1.5) * scale(9.0, 9.0, 1.0), mirror);
    stage.sky(1.0);
    for x in [0.0, 0.4, 0.8, 0.95] {
        narrow(&mut stage, v(x, 0.1, 4.0), v(x, 0.1, 0.0), Vec3::Y);
        let seen = stokes(&stage, json!({"rr_depth": 50}), 40_000);
        agrees(&format!("S₀ at {x}"), &seen[0], 1.0);
        for (i, s) in seen.iter().enumerate().skip(1) {
            agrees(&format!("S{i} at {x}"), &with_error(1.0 + s.mean(), s.standard_error()), 1.0);
        }
    }
}
