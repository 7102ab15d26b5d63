//! Pictures of radiosity against those of path tracing.

use crate::radiosity::{cube, one_wall};
use crate::scenes::*;
use kaustika_film::FilterDesc;
use kaustika_film::accumulate::PassImage;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::Scene;
use kaustika_scene::description::{GeometryDesc, MaterialModel};
use kaustika_transport::method::Method;
use kaustika_transport::radiosity::{Radiosity, RadiosityParams};
use kaustika_transport::{Frame, Workers};
use serde_json::{Value, json};
use std::sync::Arc;

/// The picture, mean over the colours, by pixel.
pub fn picture(scene: &Scene, size: [u32; 2], p: Value, passes: u64) -> Vec<f64> {
    let config = SamplerConfig { kind: SamplerKind::Sobol, seed: 1, spp: passes, resolution: size };
    let frame = Frame::new(size, FilterDesc::BOX, config);
    let workers = Workers::new(2, Arc::default()).expect("threads");
    let params: RadiosityParams = serde_json::from_value(p).expect("parameters");
    let mut method = Radiosity::new(params).expect("they go together");
    method.prepare(scene, &frame, &workers).expect("prepared");
    let mut sums = vec![0.0; (size[0] * size[1]) as usize];
    for index in 0..passes {
        let mut out = PassImage::new(size[0], size[1], frame.layers.clone());
        method.pass(index, scene, &frame, &mut out, &workers).expect("a pass");
        let stride = out.layers().stride();
        for (sum, pixel) in sums.iter_mut().zip(out.data().chunks(stride)) {
            *sum += f64::from(pixel[0] + pixel[1] + pixel[2]) / (3.0 * passes as f64);
        }
    }
    sums
}

/// Pixels at edges of shadows and of what is seen: whose neighbours differ by more than a quarter.
fn edges(truth: &[f64], [w, h]: [usize; 2]) -> Vec<bool> {
    let differs = |i: usize| {
        let (x, y) = (i % w, i / w);
        let rows = y.saturating_sub(1)..(y + 2).min(h);
        let near =
            rows.flat_map(|y| (x.saturating_sub(1)..(x + 2).min(w)).map(move |x| truth[y * w + x]));
        let near: Vec<f64> = near.collect();
        let (least, most) =
            near.iter().fold((f64::INFINITY, 0.0f64), |(a, b), &t| (a.min(t), b.max(t)));
        most - least > 0.25 * near.iter().sum::<f64>() / near.len() as f64
    };
    (0..truth.len()).map(differs).collect()
}

/// A matte room is all LD*E: the path tracer's picture is that of radiosity. Relative L2, of which
/// the path tracer's noise is taken off, at most 3 % at the finest mesh, and falling: without edges by 1.5 for
/// four times as many patches; edges, across which patches lie, by less.
#[test]
fn a_matte_room_is_that_of_path_tracing() {
    let mut stage = one_wall();
    let size = [24, 24];
    stage.camera(pinhole(75.0), look(v(-0.1, -0.95, 0.3), v(0.0, 0.3, -0.35)), size);
    let scene = stage.build();
    let path = render(&scene, size, json!({}), 1500, 7, SamplerKind::Independent);
    let truth: Vec<f64> = path.pixels.iter().map(|p| p.mean()).collect();
    let edges = edges(&truth, [24, 24]);
    // Of all pixels, and without edges.
    let errors = |p: Value, passes| {
        let found = picture(&scene, size, p, passes);
        [true, false].map(|with_edges| {
            let (mut sum, mut all) = (0.0, 0.0);
            for i in (0..truth.len()).filter(|&i| with_edges || !edges[i]) {
                let noise = path.pixels[i].standard_error().powi(2);
                sum += (found[i] - truth[i]).powi(2) - noise;
                all += truth[i].powi(2);
            }
            (sum.max(0.0) / all).sqrt()
        })
    };
    let meshes = [500, 2000, 8000].map(|n| errors(json!({"direct": "mesh", "patches": n}), 16));
    assert!(meshes[2][0] < 0.03, "{meshes:?}");
    assert!(meshes.windows(2).all(|w| w[1][0] < w[0][0] / 1.3), "{meshes:?}");
    assert!(meshes.windows(2).all(|w| w[1][1] < w[0][1] / 1.5), "{meshes:?}");

    let error = |p: Value, passes| errors(p, passes)[0];
    let rays = error(json!({"patches": 2000}), 256);
    let gather = error(json!({"patches": 2000, "display": "gather"}), 256);
    let shot = error(json!({"patches": 2000, "solver": "southwell"}), 256);
    assert!(rays < 0.03 && gather < 0.03 && shot < 0.03, "{rays} {gather} {shot}");

    // The last gathering takes off what coarse links err by.
    let coarse = |polish: u32| {
        error(json!({"direct": "mesh", "patches": 2000, "error": 0.1, "polish": polish}), 16)
    };
    let (without, with) = (coarse(0), coarse(512));
    assert!(with < 0.7 * without, "{without} without polish, {with} with it");
    // As many patches, where light changes.
    let flat = |adapt: bool| {
        let p =
            json!({"direct": "mesh", "patches": 2000, "solver": "gauss-seidel", "adapt": adapt});
        error(p, 16)
    };
    let (even, adapted) = (flat(false), flat(true));
    assert!(adapted < 0.9 * even, "{even} of even patches, {adapted} of adapted ones");
}

/// A glossy floor under a lamp in a room: of no band radiosity is matte, of more it nears the path tracer's
/// picture of everything (Sillion, Arvo, Westin & Greenberg 1991). Patches without gloss stay as they are.
#[test]
fn glossy_patches_near_all_light() {
    let mut stage = cube(0.6);
    let (d, s, n) = (stage.d.float(0.2), stage.d.float(0.6), stage.d.float(6.0));
    let phong = stage.material(MaterialModel::Phong {
        diffuse_reflectance: d,
        specular_reflectance: s,
        exponent: n,
    });
    stage.shape(GeometryDesc::Rectangle, at(0.0, 0.0, -0.99), phong);
    let place = at(0.3, 0.5, 0.9) * down() * scale(0.4, 0.4, 1.0);
    stage.lamp(GeometryDesc::Rectangle, place, 5.0);
    let size = [16, 16];
    stage.camera(pinhole(60.0), look(v(0.0, -0.95, 0.4), v(0.0, 0.2, -0.9)), size);
    let scene = stage.build();
    let path = render(&scene, size, json!({}), 1000, 7, SamplerKind::Independent);
    let truth: Vec<f64> = path.pixels.iter().map(|p| p.mean()).collect();
    let all: f64 = truth.iter().map(|t| t * t).sum();
    let errors = [0, 2, 4, 8].map(|bands| {
        let p = json!({"solver": "jacobi", "direct": "mesh", "patches": 1200, "samples": 1024,
            "glossy": bands});
        let found = picture(&scene, size, p, 8);
        let sum: f64 = found.iter().zip(&truth).map(|(a, b)| (a - b).powi(2)).sum();
        (sum / all).sqrt()
    });
    assert!(errors.windows(2).all(|w| w[1] < 0.8 * w[0]), "{errors:?}");
    assert!(errors[3] < 0.1, "{errors:?}");
}

/// A glossy floor, seen nearly along it, that reflects one large lamp: harmonics cannot follow a surface's
/// horizon, beyond which nothing is reflected, and are continued below as above ((4) of `glossy`): without
/// that they have half of the light there. Few bands know little of a lobe: the nearest even functions of 2, 4 and 6
/// bands are 1.323, 1.138 and 1.046 of the truth toward this eye (for the point in the middle, by quadrature of
/// lamp and hemisphere with 400 and 6144 points).
#[test]
fn glossy_patches_reflect_toward_the_horizon() {
    let mut stage = Stage::new();
    let (d, s, n) = (stage.d.float(0.0), stage.d.float(0.6), stage.d.float(2.0));
    let phong = stage.material(MaterialModel::Phong {
        diffuse_reflectance: d,
        specular_reflectance: s,
        exponent: n,
    });
    stage.shape(GeometryDesc::Rectangle, HERE, phong);
    let place = at(0.0, 2.5, 1.0) * down() * scale(2.0, 2.0, 1.0);
    stage.lamp(GeometryDesc::Rectangle, place, 1.0);
    let size = [8, 8];
    stage.camera(pinhole(0.5), look(v(0.0, -4.0, 0.4), v(0.0, 0.0, 0.0)), size);
    let scene = stage.build();
    let mean = |p: &[f64]| p.iter().sum::<f64>() / p.len() as f64;
    let path = render(&scene, size, json!({}), 1000, 7, SamplerKind::Independent);
    let truth = mean(&path.pixels.iter().map(|p| p.mean()).collect::<Vec<_>>());
    let ratios = [2, 4, 6].map(|bands| {
        let p = json!({"solver": "jacobi", "direct": "mesh", "patches": 600, "samples": 1024,
            "glossy": bands});
        mean(&picture(&scene, size, p, 8)) / truth
    });
    for (ratio, expected) in ratios.iter().zip([1.323, 1.138, 1.046]) {
        assert!((ratio / expected - 1.0).abs() < 0.03, "{ratios:?}");
    }
}
