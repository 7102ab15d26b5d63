//! Radiosity: form factors against closed forms, and solvers against each other.

use crate::scenes::*;
use crate::stats::close;
use kaustika_film::FilterDesc;
use kaustika_math::Vec3;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::Scene;
use kaustika_scene::description::GeometryDesc;
use kaustika_spectra::Spectrum;
use kaustika_transport::method::Method;
use kaustika_transport::radiosity::form_factor::{FormFactorKind, FormFactors, Row};
use kaustika_transport::radiosity::mesh::Mesh;
use kaustika_transport::radiosity::solve::{
    Patches, Shooting, direct, gauss_seidel, jacobi, shoot,
};
use kaustika_transport::radiosity::{Radiosity, RadiosityParams, Solution};
use kaustika_transport::{Frame, Workers};
use serde_json::{Value, json};
use std::sync::Arc;

/// The inside of a cube.
pub fn cube(rho: f32) -> Stage {
    let mut stage = Stage::new();
    let white = stage.diffuse(rho);
    stage.shape(GeometryDesc::Cube, HERE, white).flip_normals = true;
    stage
}

/// A mesh of so many patches.
pub fn meshed(scene: &Scene, patches: usize) -> Mesh {
    let mut mesh = Mesh::new(scene, false);
    mesh.divide_evenly(scene, patches);
    mesh
}

/// Σ A_i F_ij over patches i of the face with normal `n` and j of that with normal `m`, over the
/// area of the first.
fn between(ff: &FormFactors, n: Vec3, m: Vec3) -> f64 {
    let of = |i: usize| &ff.mesh.elements[ff.patches[i] as usize];
    let (mut flow, mut area) = (0.0, 0.0);
    for i in (0..ff.len()).filter(|&i| of(i).normal.dot(n) > 0.9) {
        let a = f64::from(of(i).area);
        area += a;
        ff.row(i).each(|j, f| {
            if of(j).normal.dot(m) > 0.9 {
                flow += a * f64::from(f.0[0]);
            }
        });
    }
    flow / area
}

const OPPOSITE: f64 = 0.199825;
const ADJACENT: f64 = 0.200044;

/// The faces of a cube (Howell's catalogue, C-11 and C-14 with equal sides).
#[test]
fn form_factors_of_a_cube() {
    let stage = cube(0.5);
    let scene = stage.build();
    let mesh = meshed(&scene, 384);
    assert_eq!(mesh.leaves().len(), 384);
    // What each can do: rays err by chance; disks, and middles that stand for patches, where patches
    // touch along an edge.
    for (kind, samples, touching, apart) in [
        (FormFactorKind::Rays, 4096, 3e-3, 3e-3),
        (FormFactorKind::Area, 64, 4e-2, 2e-3),
        (FormFactorKind::Analytic, 64, 3e-3, 1e-3),
        (FormFactorKind::Hemicube, 256, 2e-2, 5e-3),
    ] {
        let ff = FormFactors::new(&scene, &mesh, kind, samples, false);
        let opposite = between(&ff, Vec3::X, -Vec3::X);
        let adjacent = between(&ff, Vec3::X, Vec3::Y);
        close(&format!("{kind:?}, opposite"), opposite, OPPOSITE, apart);
        close(&format!("{kind:?}, adjacent"), adjacent, ADJACENT, touching);
    }
}

/// (2): rows of a closed scene sum to 1, and both ways are the same.
#[test]
fn rows_sum_to_one_and_both_ways_agree() {
    let stage = cube(0.5);
    let scene = stage.build();
    let mesh = meshed(&scene, 192);
    for (kind, samples, sum, both) in [
        // 85 rays meet a patch: their numbers differ by √(4/85π), 12 %, if not stratified.
        (FormFactorKind::Rays, 16_384, 1e-5, 0.12),
        // Disks lose most in corners, where a patch touches others along two sides.
        (FormFactorKind::Area, 64, 0.2, 1e-5),
        (FormFactorKind::Analytic, 64, 0.01, 0.03),
        (FormFactorKind::Hemicube, 512, 1e-4, 0.1),
    ] {
        let ff = FormFactors::new(&scene, &mesh, kind, samples, false);
        let (rows, areas) = (ff.rows(|_| Some(())).expect("rows"), ff.areas());
        let mut worst_sum = 0.0f32;
        let mut ways = vec![0.0f32; ff.len() * ff.len()];
        for (i, row) in rows.iter().enumerate() {
            worst_sum = worst_sum.max((row.sum() - 1.0).abs());
            row.each(|j, f| ways[i * ff.len() + j] = f.0[0] * areas[i]);
        }
        let n = ff.len();
        let pairs = (0..n).flat_map(|i| (0..i).map(move |j| (i, j)));
        let (mut difference, mut all) = (0.0, 0.0);
        for (i, j) in pairs {
            difference += (ways[i * n + j] - ways[j * n + i]).abs();
            all += 0.5 * (ways[i * n + j] + ways[j * n + i]);
        }
        assert!(worst_sum < sum, "{kind:?}: rows sum to 1 within {worst_sum}");
        assert!(difference < both * all, "{kind:?}: ways differ by {}", difference / all);
    }
}

/// A square half hidden: what is left is the other half, which is exact.
#[test]
fn hidden_halves_do_not_count() {
    let mut stage = Stage::new();
    let white = stage.diffuse(0.5);
    let small = scale(0.01, 0.01, 1.0);
    stage.shape(GeometryDesc::Rectangle, small, white);
    // Half as far as the square above, and half as wide: it hides x > 0.
    stage.shape(GeometryDesc::Rectangle, at(0.5, 0.0, 0.5) * scale(0.5, 1.0, 1.0), white);
    stage.shape(GeometryDesc::Rectangle, at(0.0, 0.0, 1.0) * down(), white);
    let scene = stage.build();
    let mesh = meshed(&scene, 1000);
    let x = 0.5f64.sqrt();
    let truth = 0.5 * 4.0 / std::f64::consts::PI * x * x.atan();
    for (kind, samples, tolerance) in [
        (FormFactorKind::Rays, 16_384, 0.01),
        (FormFactorKind::Area, 16, 0.02),
        (FormFactorKind::Analytic, 16, 0.02),
        (FormFactorKind::Hemicube, 256, 0.02),
    ] {
        let ff = FormFactors::new(&scene, &mesh, kind, samples, false);
        let of = |i: usize| &mesh.elements[ff.patches[i] as usize];
        let (mut flow, mut area) = (0.0, 0.0);
        for i in (0..ff.len()).filter(|&i| of(i).center().z == 0.0 && of(i).normal.z > 0.0) {
            area += f64::from(of(i).area);
            ff.row(i).each(|j, f| {
                if of(j).center().z == 1.0 {
                    flow += f64::from(of(i).area * f.0[0]);
                }
            });
        }
        close(&format!("{kind:?}"), flow / area, truth, tolerance);
    }
}

/// By way of a lossless mirror, the form factor is that to the mirror image (Wallace, Cohen &
/// Greenberg 1987): here of a square 2 wide, which is 2.5 away.
#[test]
fn mirrors_show_mirror_images() {
    let mut stage = Stage::new();
    let (white, mirror) = (stage.diffuse(0.5), stage.metal(0.0));
    stage.shape(GeometryDesc::Rectangle, scale(0.01, 0.01, 1.0), white);
    stage.shape(GeometryDesc::Rectangle, at(0.0, 0.0, 1.0) * down() * scale(3.0, 3.0, 1.0), mirror);
    stage.shape(GeometryDesc::Rectangle, at(0.0, 0.0, -0.5), white);
    let scene = stage.build();
    let mesh = meshed(&scene, 100);
    let x = 0.4 / (1.0f64 + 0.16).sqrt();
    let truth = 4.0 / std::f64::consts::PI * x * x.atan();
    for (extended, expected) in [(true, truth), (false, 0.0)] {
        let ff = FormFactors::new(&scene, &mesh, FormFactorKind::Rays, 65_536, extended);
        let of = |i: usize| &mesh.elements[ff.patches[i] as usize];
        let small = (0..ff.len()).filter(|&i| of(i).center().z == 0.0 && of(i).normal.z > 0.0);
        for i in small {
            let row = ff.row(i);
            let mut sum = 0.0;
            row.each(|j, f| sum += if of(j).center().z < 0.0 { f64::from(f.0[0]) } else { 0.0 });
            close("by the mirror", sum, expected, 0.01);
        }
    }
}

/// E/(1 - ρ): every patch of a furnace emits and reflects alike, H = E/(1 - ρ) (Goral et al. 1984).
#[test]
fn a_furnace_glows_evenly() {
    let rho = 0.75;
    let mut stage = cube(rho);
    let emission = stage.emission(2.0);
    stage.d.shapes[0].emission = Some(emission);
    let scene = stage.build();
    let mesh = meshed(&scene, 96);
    let ff = FormFactors::new(&scene, &mesh, FormFactorKind::Rays, 4096, false);
    let rows = ff.rows(|_| Some(())).expect("rows");
    let none = vec![Spectrum::ZERO; ff.len()];
    let patches = Patches::new(&mesh, &ff.patches, &none, true);
    let truth = 2.0 * std::f64::consts::PI / f64::from(1.0 - rho);
    let shooting = Shooting { tolerance: 1e-5, shots: 100_000, ambient: false };
    let (shot, _) = shoot(&patches, &shooting, |i| Some(rows[i].clone()), |_| ()).expect("done");
    for (what, h, tolerance) in [
        ("direct", direct(&rows, &patches, || Some(())).expect("solved"), 1e-5),
        ("Jacobi", jacobi(&rows, &patches, 1e-6), 1e-5),
        ("Gauss-Seidel", gauss_seidel(&rows, &patches, 1e-6), 1e-5),
        // Rows are by chance, and shots have columns: they sum to 1 less exactly.
        ("Southwell", shot, 0.05),
    ] {
        for h in &h {
            close(what, f64::from(h.0[1]), truth, tolerance);
        }
    }
}

/// The same by links at many levels.
#[test]
fn a_hierarchy_is_a_furnace_too() {
    let mut stage = cube(0.75);
    let emission = stage.emission(2.0);
    stage.d.shapes[0].emission = Some(emission);
    let scene = stage.build();
    let truth = 8.0 * std::f32::consts::PI;
    for patches in [100, 3000] {
        let s = solved(&scene, json!({"direct": "mesh", "patches": patches}));
        let h: Vec<f32> = s.indirect.leaves.iter().map(|h| h.0[1] / truth).collect();
        let mean = h.iter().sum::<f32>() / h.len() as f32;
        let (least, most) =
            h.iter().fold((f32::INFINITY, 0.0f32), |(a, b), &h| (a.min(h), b.max(h)));
        // Small patches are linked as coarsely as their little power allows.
        assert!((mean - 1.0).abs() < 0.01, "{patches}: {mean}");
        assert!(least > 0.9 && most < 1.1, "{patches}: {least} to {most}");
    }
}

/// The method, ready for its first pass.
pub fn prepared(scene: &Scene, p: Value) -> Radiosity {
    let params = serde_json::from_value(p).expect("parameters");
    let mut method = Radiosity::new(params).expect("they go together");
    assert!(method.bakes() && method.baked(scene).is_none());
    let config = SamplerConfig { kind: SamplerKind::Sobol, seed: 1, spp: 1, resolution: [1, 1] };
    let frame = Frame::new([1, 1], FilterDesc::BOX, config);
    let workers = Workers::new(2, Arc::default()).expect("threads");
    method.prepare(scene, &frame, &workers).expect("prepared");
    method
}

/// A furnace baked: radiance 2 + 0.75 · 8 everywhere, triangles that face inward.
#[test]
fn a_baked_furnace_glows_evenly() {
    let mut stage = cube(0.75);
    let emission = stage.emission(2.0);
    stage.d.shapes[0].emission = Some(emission);
    let scene = stage.build();
    let p = json!({"direct": "mesh", "solver": "jacobi", "patches": 96, "tolerance": 1e-6, "polish": 0});
    let method = prepared(&scene, p);
    let baked = method.baked(&scene).expect("a mesh");
    assert_eq!(baked.indices.len(), 96);
    let colors = &baked.attributes[0];
    assert_eq!(
        (colors.name.as_str(), colors.values.len()),
        ("vertex_color", 3 * baked.positions.len())
    );
    colors.values.iter().for_each(|&c| close("colour", f64::from(c), 8.0, 1e-4));
    for triangle in &baked.indices {
        let [a, b, c] = triangle.map(|i| baked.positions[i as usize]);
        assert!((b - a).cross(c - a).dot(a + b + c) < 0.0, "a triangle faces outward");
    }
}

/// A cube with walls of several albedos, one of which emits.
pub fn one_wall() -> Stage {
    let mut stage = cube(0.5);
    let red = stage.diffuse(0.9);
    stage.shape(GeometryDesc::Rectangle, at(0.0, 0.0, -0.99) * scale(0.9, 0.9, 1.0), red);
    stage.shape(GeometryDesc::Cube, at(0.3, 0.2, -0.5) * scale(0.3, 0.3, 0.45), red);
    stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, 0.99) * down() * scale(0.3, 0.3, 1.0), 10.0);
    stage
}

/// All rows, (2) holding exactly: shots use columns where the matrix uses rows.
pub fn reciprocal(ff: &FormFactors) -> Vec<Row> {
    let mut rows = ff.rows(|_| Some(())).expect("rows");
    let areas = ff.areas();
    let mut both = vec![vec![0.0f32; ff.len()]; ff.len()];
    for (i, row) in rows.iter().enumerate() {
        row.each(|j, f| {
            both[i][j] += 0.5 * areas[i] * f.0[0];
            both[j][i] += 0.5 * areas[i] * f.0[0];
        });
    }
    for (i, row) in rows.iter_mut().enumerate() {
        let line = both[i].iter().enumerate().filter(|(_, f)| **f > 0.0);
        row.seen = line.map(|(j, f)| (j as u32, f / areas[i])).collect();
    }
    rows
}

/// Elimination, both iterations and Southwell's solve the same system; what is unshot falls.
#[test]
fn solvers_agree() {
    let stage = one_wall();
    let scene = stage.build();
    let mesh = meshed(&scene, 600);
    // Fewer points do not know what is right below the box: rows of both ways together sum to more than 1/ρ.
    let ff = FormFactors::new(&scene, &mesh, FormFactorKind::Analytic, 16, false);
    let (rows, areas) = (reciprocal(&ff), ff.areas());
    let most = |i: usize| rows[i].sum() * ff.element(i).albedo.0[0];
    let most = (0..ff.len()).map(most).fold(0.0, f32::max);
    assert!(most < 1.0, "shots would add power: {most}");
    let none = vec![Spectrum::ZERO; ff.len()];
    let patches = Patches::new(&mesh, &ff.patches, &none, true);
    let truth = direct(&rows, &patches, || Some(())).expect("solved");
    let mut left = vec![1.0];
    let shooting = Shooting { tolerance: 1e-5, shots: 100_000, ambient: false };
    let (shot, _) =
        shoot(&patches, &shooting, |i| Some(rows[i].clone()), |l| left.push(l)).expect("done");
    assert!(left.windows(2).all(|w| w[1] < w[0]), "unshot power rises");
    let brightest = truth.iter().map(|h| h.0[0]).fold(0.0, f32::max);
    for (what, h, tolerance) in [
        ("Jacobi", jacobi(&rows, &patches, 1e-7), 1e-5),
        ("Gauss-Seidel", gauss_seidel(&rows, &patches, 1e-7), 1e-5),
        ("Southwell", shot, 1e-3),
    ] {
        let worst = h.iter().zip(&truth).map(|(a, b)| (a.0[0] - b.0[0]).abs()).fold(0.0, f32::max);
        assert!(worst < tolerance * brightest, "{what}: {worst} of {brightest}");
    }
    // The ambient term stands for what a few shots leave, on average.
    let energy = |h: &[Spectrum]| h.iter().zip(&areas).map(|(h, a)| h.0[0] * a).sum::<f32>();
    let early = |ambient| {
        let shooting = Shooting { tolerance: 0.0, shots: 8, ambient };
        shoot(&patches, &shooting, |i| Some(rows[i].clone()), |_| ()).expect("done").0
    };
    let (bare, with, all) = (energy(&early(false)), energy(&early(true)), energy(&truth));
    assert!((with - all).abs() < 0.5 * (bare - all).abs(), "{bare} {with} {all}");
}

pub fn solved(scene: &Scene, p: Value) -> Solution {
    let params: RadiosityParams = serde_json::from_value(p).expect("parameters");
    let workers = Workers::new(2, Arc::default()).expect("threads");
    Solution::new(scene, &params, &workers).expect("a solution")
}

/// The hierarchy comes to what the matrix does: over the middles of the matrix's patches, by area.
#[test]
fn the_hierarchy_agrees_with_the_matrix() {
    let scene = one_wall().build();
    let matrix = solved(
        &scene,
        json!({"solver": "direct", "direct": "mesh", "patches": 2500,
            "form_factors": "analytic", "samples": 8}),
    );
    let mut errors = Vec::new();
    for (error, polish) in [(0.1, 0), (0.004, 0), (0.1, 2048)] {
        let p = json!({"direct": "mesh", "patches": 4000, "error": error, "polish": polish});
        let hierarchy = solved(&scene, p);
        let (mut difference, mut all) = (0.0f64, 0.0f64);
        for (&leaf, h) in matrix.leaves.iter().zip(&matrix.indirect.leaves) {
            let element = &matrix.mesh.elements[leaf as usize];
            let s = matrix.mesh.surface(&scene, leaf, [1.0 / 3.0; 3]);
            let [other, _] = hierarchy.irradiance(&scene, &s, element.normal).expect("a leaf");
            let weight = f64::from(element.area * element.albedo.0[0]);
            difference += weight * f64::from(h.0[0] - other.0[0]).powi(2);
            all += weight * f64::from(h.0[0]).powi(2);
        }
        errors.push((difference / all).sqrt());
    }
    assert!(errors[1] < 0.04, "{errors:?}");
    assert!(errors[1] < 0.6 * errors[0], "{errors:?}");
    // Coarse links lose light, of which gatherings leave little: 4.0 %, and 5.7 % with one gathering instead of three.
    assert!(errors[2] < 0.048, "{errors:?}");
}

/// Hanrahan, Salzman & Aupperle 1991: links grow as elements, not as their square. Of each leaf there are as many,
/// whatever the smallest area: 85, 79, 61. Were what sends divided by power, as what receives is, there would be
/// 84, 84, 92.
#[test]
fn links_are_linear_in_elements() {
    let scene = one_wall().build();
    let found = [1000, 4000, 16_000].map(|patches| {
        let s = solved(&scene, json!({"direct": "mesh", "patches": patches, "polish": 0}));
        (s.leaves.len(), s.links as f64 / s.leaves.len() as f64)
    });
    assert!(found[2].0 > 8 * found[0].0, "{found:?}");
    assert!(found[1..].iter().all(|f| f.1 < 1.05 * found[0].1), "{found:?}");
}
