//! Paths side by side against paths one after the other, with the same random numbers: the same
//! picture but for rounding.
//!
//! Rounding moves a sample by about 1e-6 of itself, unless a decision hangs on it: an edge that a
//! ray just passes, a roulette that it just survives. Such samples are few, and are counted.

use crate::placing::stages;
use crate::scenes::*;
use kaustika_film::FilterDesc;
use kaustika_film::accumulate::{Feature, Layers, PassImage};
use kaustika_math::Vec3;
use kaustika_sampling::estimator::RunningMean;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::Scene;
use kaustika_scene::description::*;
use kaustika_scene::lanes::Gloss;
use kaustika_spectra::ColorMode;
use kaustika_transport::path::PathTracer;
use kaustika_transport::{Frame, Method, PassStats, Workers};
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Not a multiple of sixteen, and more pixels in a band than a wave has paths.
const SIZE: [u32; 2] = [150, 33];

/// Of 4950 samples those that may differ by more than 1e-3 of their size.
const FEW: usize = 12;

struct Pass {
    image: PassImage,
    stats: PassStats,
}

fn pass(scene: &Scene, method: PathTracer, features: &[Feature], kind: SamplerKind) -> Pass {
    pass_of(scene, method, 3, features, kind)
}

fn pass_of(
    scene: &Scene,
    method: PathTracer,
    index: u64,
    features: &[Feature],
    kind: SamplerKind,
) -> Pass {
    let config = SamplerConfig { kind, seed: 5, spp: 4, resolution: SIZE };
    let mut frame = Frame::new(SIZE, FilterDesc::BOX, config);
    frame.layers = Layers::new(features);
    let workers = Workers::new(2, Arc::new(AtomicBool::new(false))).expect("threads");
    let mut image = PassImage::new(SIZE[0], SIZE[1], frame.layers.clone());
    let mut method = method;
    method.prepare(scene, &frame, &workers).expect("prepared");
    let commit = method.pass(index, scene, &frame, &mut image, &workers).expect("a pass");
    Pass { image, stats: commit.stats }
}

/// How many numbers of two pictures differ by more than rounding explains.
fn differing(a: &PassImage, b: &PassImage) -> usize {
    // Not a number is far from everything.
    let near = |(a, b): (&f32, &f32)| (a - b).abs() <= 1e-3 * (a.abs() + b.abs()).max(1e-3);
    a.data().iter().zip(b.data()).filter(|&pair| !near(pair)).count()
}

fn check(name: &str, scene: &Scene, p: Value, features: &[Feature], kind: SamplerKind) {
    let tracer = || PathTracer::new(params(p.clone()));
    let together = pass(scene, tracer(), features, kind);
    let alone = pass(scene, tracer().alone(), features, kind);
    let (s, t) = (together.stats, alone.stats);
    assert!(s.closest_rays > 5000 && s.bad_samples == 0, "{name}: {s:?}");
    let near = |a: u64, b: u64| a.abs_diff(b) <= 100 + a / 500;
    assert!(near(s.closest_rays, t.closest_rays), "{name}: {s:?} {t:?}");
    assert!(near(s.shadow_rays, t.shadow_rays), "{name}: {s:?} {t:?}");
    let count = differing(&together.image, &alone.image);
    // Each sample has several numbers; discrete ones (names of shapes) differ at edges alone.
    let allowed = FEW * together.image.layers().stride();
    assert!(count <= allowed, "{name}: {count} numbers differ");
    let sum = |image: &PassImage| image.data().iter().map(|&v| f64::from(v)).sum::<f64>();
    let (a, b) = (sum(&together.image), sum(&alone.image));
    assert!((a - b).abs() < 1e-2 * b.abs(), "{name}: {a} {b}");
}

fn camera(stage: &mut Stage, kind: CameraKind) {
    stage.camera(kind, look(v(0.0, -3.5, 1.8), v(0.0, 0.2, 0.4)), SIZE);
}

/// A wavy square with shading normals, seen from both sides.
fn waves(n: u32) -> GeometryDesc {
    let point = |i: u32| {
        let (x, y) = ((i % (n + 1)) as f32 / n as f32, (i / (n + 1)) as f32 / n as f32);
        v(2.0 * x - 1.0, 2.0 * y - 1.0, 0.5 + 0.1 * (9.0 * x).sin() * (7.0 * y).cos())
    };
    let normal = |i: u32| {
        let (x, y) = ((i % (n + 1)) as f32 / n as f32, (i / (n + 1)) as f32 / n as f32);
        v(-0.45 * (9.0 * x).cos() * (7.0 * y).cos(), 0.35 * (9.0 * x).sin() * (7.0 * y).sin(), 1.0)
            .normalize()
    };
    let indices = (0..n * n).flat_map(|i| {
        let a = i / n * (n + 1) + i % n;
        [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
    });
    GeometryDesc::Mesh(Arc::new(TriMesh {
        positions: (0..(n + 1) * (n + 1)).map(point).collect(),
        normals: (0..(n + 1) * (n + 1)).map(normal).collect(),
        indices: indices.collect(),
        ..TriMesh::default()
    }))
}

fn plastic(stage: &mut Stage, alpha: f32, rho: f32, nonlinear: bool) -> MaterialId {
    let (diffuse, specular) = (stage.d.float(rho), stage.d.float(0.9));
    let roughness = Some(stage.rough(alpha));
    stage.material(MaterialModel::Plastic {
        diffuse_reflectance: diffuse,
        specular_reflectance: specular,
        ior: 1.5,
        nonlinear,
        roughness,
    })
}

/// The principled model with a base colour and nothing but the diffuse part and the main lobe.
fn principled(
    stage: &mut Stage,
    base_color: TextureId,
    roughness: f32,
    metallic: f32,
) -> MaterialId {
    let (zero, roughness) = (stage.d.float(0.0), stage.d.float(roughness));
    let metallic = stage.d.float(metallic);
    stage.material(MaterialModel::Principled(PrincipledDesc {
        thin: false,
        base_color,
        roughness,
        anisotropic: zero,
        metallic,
        spec_trans: zero,
        diff_trans: zero,
        eta: 1.5,
        spec_tint: zero,
        sheen: zero,
        sheen_tint: zero,
        flatness: zero,
        clearcoat: zero,
        clearcoat_gloss: zero,
    }))
}

/// A room with everything that is shaded sixteen at a time, and things that are not.
fn room(format: SourceFormat) -> Stage {
    let mut stage = Stage::new();
    stage.d.format = format;
    let checks = bitmap(8, 8, |u, v| {
        let dark = ((u * 8.0) as u32 + (v * 8.0) as u32).is_multiple_of(2);
        if dark { [0.1, 0.2, 0.5] } else { [0.8, 0.7, 0.6] }
    });
    let reflectance = texture(&mut stage, checks, BitmapFilter::Bilinear);
    let tiles = stage.material(MaterialModel::Diffuse { reflectance });
    stage.shape(GeometryDesc::Rectangle, scale(3.0, 3.0, 1.0), tiles);
    let (white, shiny, dull) = (
        stage.diffuse(0.7),
        plastic(&mut stage, 0.1, 0.4, true),
        plastic(&mut stage, 0.4, 0.6, false),
    );
    let both = stage.two_sided(shiny);
    let part_metal = principled(&mut stage, reflectance, 0.35, 0.6);
    let part_metal = stage.two_sided(part_metal);
    // Seen from behind.
    let tilted = at(1.7, 0.6, 0.5) * rotate(70.0, Vec3::Y);
    stage.shape(GeometryDesc::Rectangle, tilted, part_metal);
    let (dielectric, gold) = (
        principled(&mut stage, reflectance, 0.6, 0.0),
        principled(&mut stage, reflectance, 0.25, 1.0),
    );
    stage.shape(waves(7), at(-1.4, -0.3, 0.1) * scale(0.5, 0.5, 0.5), dielectric);
    stage.shape(waves(4), at(1.0, -1.3, 0.65) * scale(0.35, 0.35, 0.35), gold);
    stage.shape(waves(12), at(-0.2, 0.3, 0.0), both);
    stage.shape(GeometryDesc::Rectangle, at(0.0, 2.0, 1.0) * rotate(90.0, Vec3::X), dull);
    // Seen from behind, where it is black.
    stage.shape(GeometryDesc::Rectangle, at(-1.6, 0.5, 0.8) * rotate(-60.0, Vec3::Y), white);
    stage.shape(waves(5), at(0.9, -0.6, 0.2) * scale(0.4, 0.4, -0.6), white).flip_normals = true;
    let (glass, metal) = (stage.glass(1.5, 0.0), stage.metal(0.2));
    stage.shape(sphere(0.35), at(0.3, -0.9, 0.4), glass);
    stage.shape(sphere(0.3), at(-0.9, -0.8, 0.3), metal);
    stage.shape(sphere(0.25), at(1.2, 0.4, 0.25), white);
    camera(&mut stage, pinhole(55.0));
    stage
}

/// A square lamp overhead: two triangles.
fn square_lamp(stage: &mut Stage, x: f32, radiance: f32) {
    stage.lamp(GeometryDesc::Rectangle, at(x, 0.0, 2.5) * down() * scale(0.4, 0.3, 1.0), radiance);
}

#[test]
fn few_lamps_in_rooms_of_three_formats() {
    for format in [SourceFormat::BuiltIn, SourceFormat::Pbrt, SourceFormat::Mitsuba3] {
        let mut stage = room(format);
        square_lamp(&mut stage, -0.6, 9.0);
        square_lamp(&mut stage, 0.8, 4.0);
        let scene = stage.build();
        assert!(scene.lamps.is_some());
        let glosses = || scene.plains.iter().flatten().filter_map(|p| p.gloss.as_ref());
        assert!(glosses().any(|g| matches!(g, Gloss::Coat(_))));
        assert_eq!(glosses().filter(|g| matches!(g, Gloss::Principled(_))).count(), 3);
        for kind in [SamplerKind::Sobol, SamplerKind::Independent, SamplerKind::Halton] {
            let p = json!({ "max_depth": 7, "rr_depth": 2 });
            check(&format!("{format:?} {kind}"), &scene, p, &[], kind);
        }
    }
}

#[test]
fn one_lamp_that_shines_both_ways() {
    let mut stage = room(SourceFormat::BuiltIn);
    let corners = [v(-0.5, -0.4, 2.0), v(0.6, -0.3, 2.1), v(0.0, 0.7, 2.2)];
    let lamp = stage.lamp(mesh(&corners, &[[0, 1, 2]]), HERE, 8.0);
    lamp.emission.as_mut().expect("a lamp").two_sided = true;
    let scene = stage.build();
    assert!(scene.lamps.is_some());
    check("both ways", &scene, json!({ "max_depth": 6 }), &[], SamplerKind::Sobol);
}

#[test]
fn lights_of_all_kinds() {
    let mut stage = room(SourceFormat::BuiltIn);
    stage.lamp(disk(0.3), at(0.0, 0.0, 2.5) * down(), 6.0);
    stage.lamp(sphere(0.2), at(1.5, 1.0, 1.8), 6.0);
    stage.point_light(v(1.0, -1.5, 1.5), 2.0);
    stage.sky(0.2);
    let scene = stage.build();
    assert!(scene.lamps.is_none());
    check("all lights", &scene, json!({ "max_depth": 6 }), &[], SamplerKind::Sobol);
    let spectral = stage.build_in(ColorMode::Spectral);
    check("spectral", &spectral, json!({ "max_depth": 6 }), &[], SamplerKind::Sobol);
}

#[test]
fn parameters_mean_the_same() {
    let mut stage = room(SourceFormat::BuiltIn);
    square_lamp(&mut stage, 0.0, 9.0);
    let scene = stage.build();
    for p in [
        json!({ "mis": "balance", "max_depth": 5 }),
        json!({ "mis": "power:3", "max_depth": 5 }),
        json!({ "mis": "max", "max_depth": 5 }),
        json!({ "mis": "light", "max_depth": 5 }),
        json!({ "mis": "bsdf", "max_depth": 5 }),
        json!({ "roulette": "albedo", "rr_depth": 1, "max_depth": 9 }),
        json!({ "roulette": "none", "max_depth": 4 }),
        json!({ "only_depth": 2 }),
        json!({ "max_depth": 1 }),
        json!({ "hide_emitters": true, "max_depth": 4 }),
    ] {
        check(&p.to_string(), &scene, p, &[], SamplerKind::Sobol);
    }
}

#[test]
fn cameras_and_features() {
    let features = Feature::FIRST_SURFACE;
    for kind in [thin_lens(55.0, 0.05, 3.0), parallel(4.0, 0.0, 1.0), parallel(4.0, 0.1, 3.0)] {
        let mut stage = room(SourceFormat::BuiltIn);
        square_lamp(&mut stage, 0.0, 9.0);
        camera(&mut stage, kind.clone());
        let scene = stage.build();
        let p = json!({ "max_depth": 4 });
        check(&format!("{kind:?}"), &scene, p, &features, SamplerKind::Sobol);
    }
}

/// Whether half-transparent cut-outs let a ray pass is decided by its bits, which rounding
/// changes: the same only in the mean. Student's t of the passes' differences, at 1e-3.
#[test]
fn cut_outs_and_instances() {
    let (flat, instanced) = stages();
    for (name, mut stage) in [("flat", flat), ("instanced", instanced)] {
        camera(&mut stage, pinhole(50.0));
        let scene = stage.build();
        let tracer = || PathTracer::new(params(json!({ "max_depth": 12 })));
        let sum = |method, index| {
            let image = pass_of(&scene, method, index, &[], SamplerKind::Sobol).image;
            image.data().iter().map(|&v| f64::from(v)).sum::<f64>()
        };
        let mut difference = RunningMean::default();
        for index in 0..24 {
            difference.push(sum(tracer(), index) - sum(tracer().alone(), index));
        }
        let t = difference.mean() / difference.standard_error();
        assert!(t.abs() < 3.77, "{name}: {difference:?}");
    }
}

#[test]
fn interfaces_and_a_mesh_beyond_the_caches() {
    let mut stage = Stage::new();
    floor(&mut stage);
    stage.sky(0.3);
    stage.lamp(disk(0.5), at(0.0, 0.0, 2.5) * down(), 6.0);
    let veil = stage.material(MaterialModel::Null { counts: false });
    stage.d.shapes.push(shape(sphere(0.6), at(0.4, 0.0, 0.6), veil));
    let grey = stage.diffuse(0.6);
    stage.shape(waves(200), HERE, grey);
    camera(&mut stage, pinhole(50.0));
    let scene = stage.build();
    assert!(scene.geometry.memory_bytes() > 1 << 20);
    check("a fine mesh", &scene, json!({ "max_depth": 12 }), &[], SamplerKind::Sobol);
}
