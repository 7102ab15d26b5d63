//! Radiosity: what iterations leave, glossy patches, light by way of mirrors from outside, and
//! light maps.

use crate::radiosity::{cube, meshed, one_wall, solved};
use crate::scenes::*;
use crate::stats::{Random, close};
use kaustika_math::{Vec2, Vec3};
use kaustika_scene::description::GeometryDesc;
use kaustika_spectra::Spectrum;
use kaustika_transport::method::{LightMap, Method};
use kaustika_transport::radiosity::Radiosity;
use kaustika_transport::radiosity::form_factor::{FormFactorKind, FormFactors};
use kaustika_transport::radiosity::solve::{Patches, direct, gauss_seidel, jacobi};
use serde_json::json;

/// A small lamp far brighter than all else in a bright room: iterations must not end because they change
/// the walls by little beside the lamp.
#[test]
fn iterations_end_when_little_is_left() {
    let mut stage = cube(0.9);
    let small = at(0.0, 0.0, 0.99) * down() * scale(0.05, 0.05, 1.0);
    stage.lamp(GeometryDesc::Rectangle, small, 1000.0);
    let scene = stage.build();
    let mesh = meshed(&scene, 200);
    let ff = FormFactors::new(&scene, &mesh, FormFactorKind::Rays, 1024, false);
    let rows = ff.rows(|_| Some(())).expect("rows");
    let none = vec![Spectrum::ZERO; ff.len()];
    let patches = Patches::new(&mesh, &ff.patches, &none, true);
    let light =
        |h: &[Spectrum]| h.iter().zip(ff.areas()).map(|(h, a)| f64::from(h.0[0] * a)).sum::<f64>();
    let truth = light(&direct(&rows, &patches, || Some(())).expect("solved"));
    for tolerance in [1e-2, 1e-3] {
        let found = [jacobi(&rows, &patches, tolerance), gauss_seidel(&rows, &patches, tolerance)];
        for found in found.map(|h| light(&h)) {
            close("all light", found, truth, 1.5 * f64::from(tolerance));
        }
    }
}

/// A tiny square under a lossless mirror of half side `side` that shows the sky below: its irradiance by the
/// mirror, π F = 4 x atan x with x = side/√(1 + side²), and what is found of it by its patches.
fn by_a_mirror(side: f32, patches: usize, rays: u32, extended: bool) -> (f64, Vec<f64>) {
    let mut stage = Stage::new();
    let (white, mirror) = (stage.diffuse(0.5), stage.metal(0.0));
    stage.shape(GeometryDesc::Rectangle, scale(0.001, 0.001, 1.0), white);
    let above = at(0.0, 0.0, 1.0) * down() * scale(side, side, 1.0);
    stage.shape(GeometryDesc::Rectangle, above, mirror);
    stage.sky(1.0);
    let scene = stage.build();
    let mesh = meshed(&scene, patches);
    let ff = FormFactors::new(&scene, &mesh, FormFactorKind::Rays, rays, extended);
    let light = ff.by_mirrors(true, |_| Some(())).expect("rows");
    let of = |i: usize| &mesh.elements[ff.patches[i] as usize];
    let upper = (0..ff.len()).filter(|&i| of(i).normal.z > 0.0 && of(i).center().z == 0.0);
    let side = f64::from(side);
    let x = side / (1.0 + side * side).sqrt();
    (4.0 * x * x.atan(), upper.map(|i| f64::from(light[i].0[0])).collect())
}

/// Without extended form factors it is black.
#[test]
fn mirrors_show_what_surrounds_the_scene() {
    let (truth, found) = by_a_mirror(3.0, 8, 65_536, true);
    found.iter().for_each(|h| close("by the mirror", *h, truth, 0.01));
    assert!(by_a_mirror(3.0, 8, 1024, false).1.iter().all(|h| *h == 0.0));
}

/// Of a small mirror, which a hundredth of the rays meet by their cosine, 1024 rays know the irradiance within
/// 1/√(1024 F), 28 %. As many more that look where light was found to come from know it within a fifth of
/// that, and are right on average: within 1 %, three standard errors and more of the mean of 250 patches.
#[test]
fn small_mirrors_are_looked_for() {
    let (truth, found) = by_a_mirror(0.1, 512, 1024, true);
    assert!(found.len() > 200, "{}", found.len());
    let n = found.len() as f64;
    let mean = found.iter().sum::<f64>() / n;
    let rms = (found.iter().map(|h| (h / truth - 1.0).powi(2)).sum::<f64>() / n).sqrt();
    close("on average", mean, truth, 0.01);
    assert!(rms < 0.28 / 5.0, "{rms}");
}

/// What a bilinear filter reads at a place of a map.
fn read(map: &LightMap, values: &[[f32; 3]], uv: Vec2) -> f64 {
    let [w, h] = map.size.map(|n| n as f32);
    let (x, y) = (uv.x * w - 0.5, (1.0 - uv.y) * h - 0.5);
    let at = |i: f32, j: f32| f64::from(values[(j * w + i) as usize][0]);
    let ([i, fx], [j, fy]) = ([x.floor(), x.fract()], [y.floor(), y.fract()]);
    let (fx, fy) = (f64::from(fx), f64::from(fy));
    let row = |j: f32| at(i, j) * (1.0 - fx) + at(i + 1.0, j) * fx;
    row(j) * (1.0 - fy) + row(j + 1.0) * fy
}

/// A light map, read at places of its triangles, is the solution there: exactly so in a furnace, and
/// within what texels blur in a room. Charts do not overlap.
#[test]
fn a_light_map_is_the_solution() {
    let mut furnace = cube(0.75);
    let emission = furnace.emission(2.0);
    furnace.d.shapes[0].emission = Some(emission);
    for (stage, patches, tolerance) in [(furnace, 96, 1e-3), (one_wall(), 3000, 0.02)] {
        let scene = stage.build();
        let p = json!({"direct": "mesh", "solver": "gauss-seidel", "patches": patches,
            "tolerance": 1e-6, "polish": 0});
        let solution = solved(&scene, p.clone());
        let map = crate::radiosity::prepared(&scene, p).light_map(&scene).expect("a map");
        let mut random = Random::new(5);
        let (mut error, mut all) = (0.0, 0.0);
        for triangle in &map.mesh.indices {
            let [a, b, c] = triangle.map(|i| map.mesh.positions[i as usize]);
            let n = (b - a).cross(c - a).normalize();
            for _ in 0..8 {
                let (x, y) = (random.f(), random.f());
                let (x, y) = if x + y < 1.0 { (x, y) } else { (1.0 - x, 1.0 - y) };
                let place = a + (b - a) * x + (c - a) * y;
                let uv = triangle.map(|i| map.mesh.uvs[i as usize]);
                let uv = uv[0] + (uv[1] - uv[0]) * x + (uv[2] - uv[0]) * y;
                let ray = kaustika_math::Ray::new(place + n * 1e-3, -n);
                let s = scene.intersect(&ray, f32::INFINITY).expect("the wall");
                let Some([h, d]) = solution.irradiance(&scene, &s, n) else { continue };
                let truth = f64::from((h + d).0[0]);
                error += (read(&map, &map.irradiance, uv) - truth).powi(2);
                all += truth * truth;
            }
        }
        let relative = (error / all).sqrt();
        assert!(relative < tolerance, "{patches} patches: {relative}");
        assert!(all > 0.0 && map.mesh.uvs.iter().all(|uv| uv.x > 0.0 && uv.y < 1.0));
    }
}

/// (1) of `light_map`: of a furnace, radiance is the same in every texel of a chart.
#[test]
fn a_furnace_has_an_even_map() {
    let mut stage = cube(0.75);
    let emission = stage.emission(2.0);
    stage.d.shapes[0].emission = Some(emission);
    let scene = stage.build();
    let p = json!({"direct": "mesh", "solver": "jacobi", "patches": 96, "tolerance": 1e-6, "polish": 0});
    let map = crate::radiosity::prepared(&scene, p).light_map(&scene).expect("a map");
    let lit = map.radiance.iter().filter(|l| l[0] > 0.0);
    lit.clone().for_each(|l| close("radiance", f64::from(l[0]), 8.0, 1e-3));
    assert!(2 * lit.count() > map.radiance.len(), "the map is mostly empty");
    let bounds = |k: usize| map.mesh.positions.iter().map(move |p: &Vec3| p[k]);
    assert!((0..3).all(|k| bounds(k).fold(0.0, f32::max) == 1.0));
}

/// What is matte alone is the same with harmonics as without.
#[test]
fn matte_patches_are_those_of_radiosity() {
    let scene = one_wall().build();
    let solve = |bands: u32| {
        let p = json!({"solver": "jacobi", "direct": "mesh", "patches": 300, "tolerance": 1e-6,
            "polish": 0, "glossy": bands});
        solved(&scene, p).indirect.leaves
    };
    for (a, b) in solve(0).iter().zip(solve(3)) {
        close("irradiance", f64::from(a.0[0]), f64::from(b.0[0]), 1e-4);
    }
}

/// A wall is divided before a hundred slivers nearly as long: that its patches err by more counts, not that slivers
/// are long. By the longest side alone the wall has 64 of the 1500 patches.
#[test]
fn slivers_are_left_whole() {
    let mut stage = Stage::new();
    let white = stage.diffuse(0.5);
    stage.shape(GeometryDesc::Rectangle, HERE, white);
    for i in 0..50 {
        let place = at(0.0, 0.04 * i as f32 - 1.0, 0.5) * scale(1.0, 1e-4, 1.0);
        stage.shape(GeometryDesc::Rectangle, place, white);
    }
    let mesh = meshed(&stage.build(), 1500);
    let leaves = mesh.leaves();
    let area = |e: &u32| mesh.elements[*e as usize].area;
    let of_wall = leaves.iter().filter(|e| mesh.elements[**e as usize].center().z < 0.25);
    let (count, largest) = of_wall.fold((0, 0.0f32), |(n, most), e| (n + 1, most.max(area(e))));
    assert!(2 * count > leaves.len(), "{count} of {}", leaves.len());
    // As even as halves allow.
    assert!(largest < 2.5 * 4.0 / count as f32, "{largest} of {count}");
}

/// Patches that are a scene's triangles as they are, are told.
#[test]
fn a_mesh_that_divides_little_says_so() {
    let scene = one_wall().build();
    let remarks = |patches: u32| {
        let p = json!({"solver": "jacobi", "samples": 16, "patches": patches});
        crate::radiosity::prepared(&scene, p).remarks()
    };
    assert!(remarks(30)[0].contains("set `patches` to several times"), "{:?}", remarks(30));
    assert!(remarks(300).is_empty());
}

#[test]
fn nothing_is_baked_before_it_is_solved() {
    let scene = one_wall().build();
    let method = Radiosity::new(serde_json::from_value(json!({})).expect("parameters"));
    assert!(method.expect("they go together").light_map(&scene).is_none());
}
