//! Mutations keep chains where the light is: in one step from starts that are right nothing drifts.
//!
//! ```text
//! E[ W(x) a(x→y) (φ(y) - φ(x)) ] = 0        for every φ, if (1) of the sampler holds      (1)
//! ```
//!
//! and as much light goes from one cell of path space to another as comes back:
//!
//! ```text
//! E[ W(x) a(x→y) (1[x ∈ i, y ∈ j] - 1[x ∈ j, y ∈ i]) ] = 0                                (2)
//! ```
//!
//! x is a candidate for a start, W its weight, y what a mutation proposes, a its acceptance. Every
//! candidate is an independent sample of (1) and (2), so that small errors in a density show.

use super::bidirectional::Lengths;
use super::params::Mutation;
use super::path::{Path, Turn, toward};
use super::specular::{Interface, Place, first_by_last};
use super::tracer::Onward;
use super::walk::{candidate, propose};
use super::{Mlt, PathParams};
use crate::metropolis::acceptance;
use crate::metropolis::film::stream;
use crate::path_space::{Walker, emission_table};
use crate::roulette::{Roulette, Survival};
use crate::test_scenes::*;
use crate::{Frame, Workers};
use kaustika_film::FilterDesc;
use kaustika_math::special::p_two_sided;
use kaustika_math::{Ray, Vec2};
use kaustika_sampling::estimator::RunningMean;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::Scene;
use kaustika_scene::bsdf::{Lobes, Mode};
use kaustika_scene::description::*;
use kaustika_spectra::Wavelengths;
use rayon::prelude::*;
use std::sync::Arc;

const SIZE: [u32; 2] = [48, 32];

/// Names of the φ of [`features`].
const FEATURES: [&str; 11] = [
    "film x",
    "film y",
    "bounces",
    "Dirac lobes",
    "length",
    "g to the light",
    "g to the eye",
    "g between lobes",
    "light",
    "x of x1",
    "z of x1",
];

/// What is looked at.
fn features(x: &Path) -> [f64; 11] {
    let places: Vec<_> = x.turns.iter().map(|t| t.node.p()).collect();
    let pairs = || places.windows(2);
    let length: f32 = pairs().map(|p| (p[1] - p[0]).length()).sum();
    let forth: f64 = (1..x.len()).map(|i| x.turns[i].node.g(places[i - 1]).ln()).sum();
    let back: f64 = (1..x.len()).map(|i| x.turns[i - 1].node.g(places[i]).ln()).sum();
    let lobes =
        (1..x.len()).filter(|&i| x.turns[i].dirac.is_some() && x.turns[i - 1].dirac.is_some());
    let between: f64 = lobes.map(|i| x.turns[i].node.g(places[i - 1]).ln()).sum();
    [
        f64::from(x.sensed.film.x),
        f64::from(x.sensed.film.y),
        x.len() as f64,
        x.turns.iter().filter(|t| t.dirac.is_some()).count() as f64,
        f64::from(length),
        forth.clamp(-20.0, 20.0),
        back.clamp(-20.0, 20.0),
        between.clamp(-20.0, 20.0),
        x.source.le.0.iter().map(|v| f64::from(*v)).sum(),
        f64::from(places[0].x),
        f64::from(places[0].z),
    ]
}

/// Cells of (2): by bounces, halves of the film, and length.
const CELLS: usize = 24;

fn cell([x, y, bounces, _, length, ..]: &[f64; 11], fewest: usize) -> usize {
    let halves = [*x > f64::from(SIZE[0]) / 2.0, *y > f64::from(SIZE[1]) / 2.0, *length > 4.0];
    let more = (*bounces as usize - fewest).min(2);
    halves.iter().fold(more, |cell, &h| 2 * cell + usize::from(h))
}

/// The histogram of (2): what goes from cell i to cell j, and the same of squares.
struct Flows(Vec<[f64; 2]>);

impl Flows {
    fn new() -> Flows {
        Flows(vec![[0.0; 2]; CELLS * CELLS])
    }

    fn add(&mut self, i: usize, j: usize, light: f64) {
        let [sum, squares] = &mut self.0[i * CELLS + j];
        *sum += light;
        *squares += light * light;
    }

    fn merge(&mut self, other: &Flows) {
        for (a, b) in self.0.iter_mut().flatten().zip(other.0.iter().flatten()) {
            *a += b;
        }
    }

    /// Of two cells what goes from one to the other more than back, as a normal score: the largest, and whose it is.
    fn worst(&self) -> (f64, [usize; 2]) {
        let pairs = (0..CELLS).flat_map(|i| (0..i).map(move |j| [i, j]));
        let score = |[i, j]: [usize; 2]| {
            let ([there, a], [back, b]) = (self.0[i * CELLS + j], self.0[j * CELLS + i]);
            if a + b > 0.0 { (there - back) / (a + b).sqrt() } else { 0.0 }
        };
        pairs.map(|p| (score(p), p)).max_by(|a, b| a.0.abs().total_cmp(&b.0.abs())).expect("cells")
    }
}

/// (1) for each φ, the share of starts that moved, and (2).
fn drift(
    scene: &Scene,
    lengths: Lengths,
    kind: Mutation,
    candidates: u64,
    seed: u64,
) -> (Vec<RunningMean>, f64, Flows) {
    let config = SamplerConfig { kind: SamplerKind::Independent, seed, spp: 1, resolution: SIZE };
    let frame = Frame::new(SIZE, FilterDesc::BOX, config);
    let mut mlt = Mlt::new(PathParams::default());
    mlt.emission = emission_table(scene);
    let chunk = |c: u64| {
        let mut tracer = mlt.tracer(scene, &frame);
        let mut means = vec![RunningMean::new(); FEATURES.len()];
        let mut moved = RunningMean::new();
        let mut flows = Flows::new();
        for number in c * 1024..candidates.min((c + 1) * 1024) {
            let mut draws = stream(seed, 0x7465_7374, number);
            let mut one = || {
                let (x, w) = candidate(&mut tracer, lengths, seed, number)?;
                let p = propose(&mut tracer, &x, kind, lengths, &mut draws)?;
                let a = acceptance(p.there, p.back).expect("a number");
                let (before, after) = (features(&x), features(&p.path));
                Some((w * a, before, after))
            };
            let found = one();
            moved.push(found.as_ref().map_or(0.0, |f| f64::from(u8::from(f.0 > 0.0))));
            if let Some((wa, x, y)) = &found {
                flows.add(cell(x, lengths.fewest), cell(y, lengths.fewest), *wa);
            }
            for (k, m) in means.iter_mut().enumerate() {
                m.push(found.as_ref().map_or(0.0, |(wa, x, y)| wa * (y[k] - x[k])));
            }
        }
        (means, moved, flows)
    };
    let workers = Workers::new(2, Arc::default()).expect("threads");
    let parts: Vec<_> =
        workers.install(|| (0..candidates.div_ceil(1024)).into_par_iter().map(chunk).collect());
    let mut means = vec![RunningMean::new(); FEATURES.len()];
    let mut moved = RunningMean::new();
    let mut flows = Flows::new();
    for (m, k, f) in &parts {
        means.iter_mut().zip(m).for_each(|(a, b)| a.merge(b));
        moved.merge(k);
        flows.merge(f);
    }
    (means, moved.mean(), flows)
}

/// Fails if a mutation draws light anywhere; at least `moving` of the candidates must move.
fn stays(what: &str, scene: &Scene, lengths: Lengths, kind: Mutation, moving: f64) {
    let (drifts, moved, flows) = drift(scene, lengths, kind, 400_000, 4400);
    assert!(moved > moving, "{what}, {kind:?}: {moved} moved");
    for (name, d) in FEATURES.iter().zip(&drifts) {
        let error = d.standard_error();
        // At most 1000 comparisons in this file: 1 % for all of them.
        let z = if error > 0.0 { d.mean() / error } else { 0.0 };
        assert!(
            p_two_sided(z.abs()) > 1e-5,
            "{what}, {kind:?}: {name} drifts by {} ± {error}",
            d.mean(),
        );
    }
    // At most 10,000 pairs of cells: 1 % for all of them.
    let (z, [i, j]) = flows.worst();
    assert!(p_two_sided(z.abs()) > 1e-6, "{what}, {kind:?}: cells {i} and {j} differ by {z} σ");
}

fn wall(stage: &mut Stage, t: kaustika_math::Transform, m: MaterialId) {
    let m = stage.two_sided(m);
    stage.shape(GeometryDesc::Rectangle, t, m);
}

/// A matte room with a lamp.
fn matte_room() -> Scene {
    let mut stage = Stage::new();
    let (white, red) = (stage.diffuse(0.7), stage.diffuse(0.3));
    let (x, y) = (v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0));
    wall(&mut stage, HERE, white);
    wall(&mut stage, at(0.0, 1.0, 1.0) * rotate(90.0, x), white);
    wall(&mut stage, at(-1.0, 0.0, 1.0) * rotate(90.0, y), red);
    wall(&mut stage, at(1.0, 0.0, 1.0) * rotate(90.0, y), white);
    stage.shape(sphere(0.3), at(-0.35, 0.1, 0.31), red);
    stage.lamp(GeometryDesc::Rectangle, at(0.2, 0.1, 1.7) * down() * scale(0.3, 0.2, 1.0), 8.0);
    stage.camera(pinhole(60.0), look(v(0.1, -2.6, 1.0), v(0.0, 0.0, 0.7)), SIZE);
    stage.build()
}

/// A room with a lamp, a block of rough metal and a ball of glass, seen through a lens.
fn glass_room() -> Scene {
    let mut stage = Stage::new();
    let (white, red) = (stage.diffuse(0.7), stage.diffuse(0.3));
    let (metal, glass) = (stage.metal(0.3), stage.glass(1.5, 0.0));
    let x = v(1.0, 0.0, 0.0);
    let y = v(0.0, 1.0, 0.0);
    wall(&mut stage, HERE, white);
    wall(&mut stage, at(0.0, 1.0, 1.0) * rotate(90.0, x), white);
    wall(&mut stage, at(-1.0, 0.0, 1.0) * rotate(90.0, y), red);
    wall(&mut stage, at(1.0, 0.0, 1.0) * rotate(90.0, y), white);
    stage.shape(sphere(0.3), at(-0.35, 0.1, 0.31), metal);
    stage.shape(sphere(0.45), at(0.45, -0.2, 0.46), glass);
    stage.lamp(GeometryDesc::Rectangle, at(0.2, 0.1, 1.7) * down() * scale(0.3, 0.2, 1.0), 8.0);
    stage.camera(thin_lens(60.0, 0.1, 2.5), look(v(0.1, -2.6, 1.0), v(0.0, 0.0, 0.7)), SIZE);
    stage.build()
}

/// A room with a floor of plastic, seen from below the water that its lamp is above of.
fn water() -> Scene {
    let mut stage = Stage::new();
    let (white, glass) = (stage.diffuse(0.7), stage.glass(1.33, 0.0));
    let (diffuse_reflectance, specular_reflectance) = (stage.d.float(0.5), stage.d.float(1.0));
    let plastic = stage.material(MaterialModel::Plastic {
        diffuse_reflectance,
        specular_reflectance,
        ior: 1.5,
        nonlinear: false,
        roughness: None,
    });
    let x = v(1.0, 0.0, 0.0);
    let y = v(0.0, 1.0, 0.0);
    wall(&mut stage, HERE, plastic);
    wall(&mut stage, at(0.0, 1.0, 1.0) * rotate(90.0, x), white);
    wall(&mut stage, at(-1.0, 0.0, 1.0) * rotate(90.0, y), white);
    wall(&mut stage, at(1.0, 0.0, 1.0) * rotate(90.0, y), plastic);
    stage.shape(GeometryDesc::Rectangle, at(0.0, 0.0, 1.0) * scale(4.0, 4.0, 1.0), glass);
    stage.lamp(GeometryDesc::Rectangle, at(0.2, 0.1, 1.7) * down() * scale(0.3, 0.2, 1.0), 8.0);
    stage.camera(pinhole(70.0), look(v(0.1, -1.6, 0.8), v(0.0, 0.0, 0.5)), SIZE);
    stage.build()
}

/// A hall between mirrors, with a floor and a ceiling that are matte.
fn mirror_hall() -> Scene {
    let mut stage = Stage::new();
    let (white, mirror) = (stage.diffuse(0.7), stage.metal(0.0));
    wall(&mut stage, scale(2.0, 2.0, 1.0), white);
    wall(&mut stage, at(0.0, 0.0, 1.0) * scale(2.0, 2.0, 1.0), white);
    for (x, y, axis) in [
        (2.0, 0.0, v(0.0, 1.0, 0.0)),
        (-2.0, 0.0, v(0.0, 1.0, 0.0)),
        (0.0, 2.0, v(1.0, 0.0, 0.0)),
        (0.0, -2.0, v(1.0, 0.0, 0.0)),
    ] {
        wall(&mut stage, at(x, y, 0.5) * rotate(90.0, axis) * scale(2.0, 2.0, 1.0), mirror);
    }
    stage.lamp(GeometryDesc::Rectangle, at(0.5, 0.3, 0.95) * down() * scale(0.4, 0.4, 1.0), 4.0);
    stage.camera(pinhole(80.0), look(v(-1.8, -1.7, 0.5), v(0.2, 0.1, 0.45)), SIZE);
    stage.build()
}

#[test]
fn guided_directions_have_the_density_that_candidates_divide_by() {
    // E[1/r] over guided directions is the share that the BSDF alone draws, of either kind; so is that of p_bsdf/p.
    let scene = water();
    let config =
        SamplerConfig { kind: SamplerKind::Independent, seed: 4500, spp: 1, resolution: SIZE };
    let frame = Frame::new(SIZE, FilterDesc::BOX, config);
    let workers = Workers::new(2, Arc::default()).expect("threads");
    let mut mlt = Mlt::new(PathParams { bootstrap: 4096, ..PathParams::default() });
    mlt.learn(&scene, &frame, &workers).expect("learned");
    assert!(mlt.guides.is_some(), "there are caustics");
    let mut tracer = mlt.tracer(&scene, &frame);
    let wo = v(0.6, -0.3, 0.5).normalize();
    let o = v(0.3, -0.2, 0.0) + wo * 0.8;
    let lambda = Wavelengths::sample_for(scene.mode, 0.5);
    let node = tracer.node(Ray { o, d: -wo, time: 0.0 }, f32::INFINITY, &lambda).expect("a floor");
    let mut draws = stream(4500, 0x7465_7374, 1);
    let roulette = Roulette { survival: Survival::None, rr_depth: 1, threshold: 1.0 };
    let walker = Walker { guides: tracer.guides, ..Walker::new(&scene, roulette, Mode::Radiance) };
    let mut shares = [[RunningMean::new(); 2]; 3];
    let mut largest: f64 = 0.0;
    for _ in 0..200_000 {
        let plain = tracer.scatter(&node, wo, Mode::Radiance, &mut draws);
        let plain = plain.map(|onward| (onward.dirac.is_some(), 1.0));
        let guided = tracer.scatter_guided(&node, wo, &mut draws).map(|Onward { ray, dirac }| {
            let r = tracer.ratio(&Turn { node: node.clone(), dirac }, wo, ray.d);
            (dirac.is_some(), 1.0 / r)
        });
        let u = (draws.f32(), Vec2::new(draws.f32(), draws.f32()));
        let walked = walker.scatter(&node.surface, wo, &node.bsdf, u);
        let walked = walked.map(|(s, share)| (s.lobe.has(Lobes::DELTA), f64::from(share)));
        for (shares, drawn) in shares.iter_mut().zip([plain, guided, walked]) {
            let mut found = [0.0; 2];
            if let Some((dirac, share)) = drawn {
                largest = largest.max(1.0 / share);
                found[usize::from(dirac)] = share;
            }
            shares.iter_mut().zip(found).for_each(|(m, x)| m.push(x));
        }
    }
    assert!(largest > 10.0, "nothing is guided: {largest}");
    let [plain, guided, walked] = shares;
    for (what, with) in [("candidates", guided), ("subpaths", walked)] {
        for (kind, (a, b)) in ["smooth", "Dirac"].iter().zip(plain.iter().zip(&with)) {
            let z = (a.mean() - b.mean()) / a.standard_error().hypot(b.standard_error());
            let (a, b) = (a.mean(), b.mean());
            assert!(a > 0.01 && p_two_sided(z.abs()) > 1e-5, "{what}, {kind}: {a} {b}, z {z}");
        }
    }
}

#[test]
fn no_mutation_draws_light_where_it_does_not_belong() {
    let lengths = Lengths { fewest: 2, most: 5 };
    for (what, scene) in [("glass", glass_room()), ("hall", mirror_hall()), ("water", water())] {
        for kind in Mutation::ALL {
            stays(what, &scene, lengths, kind, 0.001);
        }
    }
}

#[test]
fn matte_paths_go_as_often_as_they_come_back() {
    let scene = matte_room();
    for (fewest, most) in [(2, 2), (1, 3)] {
        for kind in [Mutation::Bidirectional, Mutation::Lens, Mutation::Caustic] {
            stays("matte", &scene, Lengths { fewest, most }, kind, 0.01);
        }
    }
}

/// A ball of glass close under a wide lamp, over a floor: chords and distances to the lamp vary by much.
fn ball_under_lamp() -> Scene {
    let mut stage = Stage::new();
    let (white, glass) = (stage.diffuse(0.7), stage.glass(1.5, 0.0));
    wall(&mut stage, scale(2.0, 2.0, 1.0), white);
    stage.shape(sphere(0.4), at(0.0, 0.0, 0.7), glass);
    stage.lamp(GeometryDesc::Rectangle, at(0.2, 0.0, 1.2) * down() * scale(0.5, 0.5, 1.0), 4.0);
    stage.camera(pinhole(70.0), look(v(0.0, -2.2, 0.5), v(0.0, 0.0, 0.1)), SIZE);
    stage.build()
}

/// The same floor through a ball close to a wide lens.
fn ball_at_the_lens() -> Scene {
    let mut stage = Stage::new();
    let (white, glass) = (stage.diffuse(0.7), stage.glass(1.5, 0.0));
    wall(&mut stage, scale(3.0, 3.0, 1.0), white);
    stage.shape(sphere(0.5), at(0.0, 0.0, 1.2), glass);
    stage.lamp(GeometryDesc::Rectangle, at(1.0, 1.0, 3.0) * down() * scale(0.5, 0.5, 1.0), 8.0);
    stage.camera(thin_lens(90.0, 0.25, 1.0), look(v(0.1, -0.2, 2.1), v(0.0, 0.0, 0.0)), SIZE);
    stage.build()
}

/// A corner of two mirrors over a floor: near its edge light goes from one to the other in no time.
fn corner() -> Scene {
    let mut stage = Stage::new();
    let (white, mirror) = (stage.diffuse(0.7), stage.metal(0.0));
    wall(&mut stage, scale(4.0, 4.0, 1.0), white);
    wall(&mut stage, rotate(90.0, v(0.0, 1.0, 0.0)) * scale(3.0, 3.0, 1.0), mirror);
    wall(&mut stage, rotate(90.0, v(1.0, 0.0, 0.0)) * scale(3.0, 3.0, 1.0), mirror);
    let down = at(0.5, 0.3, 1.0) * down() * scale(0.2, 0.2, 1.0);
    stage.lamp(GeometryDesc::Rectangle, down, 4.0);
    stage.camera(pinhole(70.0), look(v(1.8, 1.5, 1.2), v(0.4, 0.4, 0.0)), SIZE);
    stage.build()
}

/// Waves over a floor: from one place of it the lamp is seen by several ways.
fn waves() -> Scene {
    const N: u32 = 40;
    let mut stage = Stage::new();
    let (white, glass) = (stage.diffuse(0.7), stage.glass(1.33, 0.0));
    wall(&mut stage, scale(2.0, 2.0, 1.0), white);
    let mut mesh = TriMesh::default();
    for k in 0..(N + 1) * (N + 1) {
        let [x, y] = [k % (N + 1), k / (N + 1)].map(|i| 4.0 * i as f32 / N as f32 - 2.0);
        let (a, b) = (5.0 * x, 4.0 * y);
        mesh.positions.push(v(x, y, 0.8 + 0.05 * a.sin() * b.cos()));
        mesh.normals.push(v(-0.25 * a.cos() * b.cos(), 0.2 * a.sin() * b.sin(), 1.0).normalize());
    }
    for k in (0..N * (N + 1)).filter(|k| k % (N + 1) < N) {
        mesh.indices.extend([[k, k + 1, k + N + 2], [k, k + N + 2, k + N + 1]]);
    }
    stage.shape(GeometryDesc::Mesh(Arc::new(mesh)), HERE, glass);
    stage.lamp(GeometryDesc::Rectangle, at(0.2, 0.1, 1.7) * down() * scale(0.2, 0.2, 1.0), 8.0);
    stage.camera(pinhole(70.0), look(v(0.1, -1.6, 0.5), v(0.0, 0.0, 0.0)), SIZE);
    stage.build()
}

#[test]
fn manifolds_keep_light_where_distances_vary() {
    for (what, scene, fewest) in [
        ("lamp", ball_under_lamp(), 3),
        ("lens", ball_at_the_lens(), 3),
        ("corner", corner(), 3),
        ("waves", waves(), 2),
    ] {
        // Bounces at what is clear or mirrors, and one or two at the floor.
        stays(what, &scene, Lengths { fewest, most: fewest + 1 }, Mutation::Manifold, 0.001);
    }
}

/// Two triangles whose normals are bent outward.
fn bent() -> GeometryDesc {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let mesh = TriMesh {
        positions: corners.map(|(x, y)| v(x, y, 0.0)).to_vec(),
        normals: corners.map(|(x, y)| v(0.2 * x, 0.3 * y, 1.0).normalize()).to_vec(),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..TriMesh::default()
    };
    GeometryDesc::Mesh(Arc::new(mesh))
}

#[test]
fn chains_move_as_their_derivative_says() {
    // A ray from x_0 through an ellipsoid, a cylinder and a pane with bent normals, of glass, or off a mirror; it ends on
    // a floor. ∂S₁/∂x_{m+1} against differences of rays.
    let squeezed = at(0.1, 0.0, 1.0) * rotate(30.0, v(1.0, 1.0, 0.0)) * scale(1.0, 0.7, 0.5);
    let tube = GeometryDesc::Cylinder { radius: 0.5, z_min: -3.0, z_max: 3.0, phi_max: 360.0 };
    let across = at(0.1, 0.0, 1.0) * rotate(80.0, v(1.0, 0.2, 0.0));
    let pane = at(0.0, 0.0, 1.0) * rotate(10.0, v(1.0, 0.0, 0.0));
    let cases = [
        ("ellipsoid", sphere(1.0), squeezed, 2, false),
        ("tube", tube, across, 2, false),
        ("pane", bent(), pane, 1, false),
        ("mirror", bent(), at(0.0, 0.0, 1.0) * rotate(-160.0, v(1.0, 0.0, 0.0)), 1, true),
    ];
    for (what, shape, to_world, interfaces, mirror) in cases {
        let mut stage = Stage::new();
        let white = stage.diffuse(0.5);
        let material = if mirror { stage.metal(0.0) } else { stage.glass(1.5, 0.0) };
        let material = if mirror { stage.two_sided(material) } else { material };
        stage.shape(shape, to_world, material);
        for side in [0.0, 180.0] {
            let far = rotate(side, v(1.0, 0.0, 0.0)) * at(0.0, 0.0, -6.0) * scale(60.0, 60.0, 1.0);
            let both = stage.two_sided(white);
            stage.shape(GeometryDesc::Rectangle, far, both);
        }
        stage.lamp(GeometryDesc::Rectangle, at(0.0, 9.0, 0.0), 1.0);
        stage.camera(pinhole(60.0), look(v(0.1, -1.6, 4.0), v(0.0, 0.0, 1.0)), SIZE);
        let scene = stage.build();
        let config =
            SamplerConfig { kind: SamplerKind::Independent, seed: 1, spp: 1, resolution: SIZE };
        let frame = Frame::new(SIZE, FilterDesc::BOX, config);
        let mut mlt = Mlt::new(PathParams::default());
        mlt.emission = emission_table(&scene);
        let mut tracer = mlt.tracer(&scene, &frame);
        let lambda = Wavelengths::sample_for(scene.mode, 0.5);
        let x0 = v(0.3, -0.2, 2.6);
        let lobe = if mirror { Lobes::DELTA_REFLECTION } else { Lobes::DELTA_TRANSMISSION };
        let mut trace = |aim: kaustika_math::Vec3| {
            let mut ray = kaustika_math::Ray { o: x0, d: toward(x0, aim), time: 0.0 };
            let mut chain = Vec::new();
            for _ in 0..interfaces {
                let node = tracer.node(ray, f32::INFINITY, &lambda).expect("met");
                let onward = tracer.turn(&node, -ray.d, lobe, Mode::Radiance).expect("a lobe");
                ray = onward.ray;
                chain.push((node, onward.dirac.expect("Dirac").eta));
            }
            (chain, tracer.node(ray, f32::INFINITY, &lambda).expect("the floor"))
        };
        let (chain, landing) = trace(v(0.1, 0.1, 1.0));
        let all: Vec<Interface> = chain.iter().map(|(node, eta)| (&**node, [1.0, *eta])).collect();
        let first = Place::new(x0, kaustika_math::Vec3::Z);
        let last = Place::new(landing.p(), landing.surface.ng);
        let m = first_by_last(&scene.geometry, first, &all, last).expect("regular");
        let start = chain[0].0.clone();
        let tangents = Place::new(start.p(), start.surface.ng);
        for t in tangents.tangents {
            let step = 4e-3;
            let (a, b) = (trace(start.p() + t * step), trace(start.p() - t * step));
            let moved = tangents.local(a.0[0].0.p() - b.0[0].0.p());
            let told = m.of(last.local(a.1.p() - b.1.p()));
            for k in 0..2 {
                let off = (moved[k] - told[k]).abs();
                assert!(off < 0.01 * 2.0 * f64::from(step), "{what}: {moved:?} {told:?}");
            }
        }
    }
}
