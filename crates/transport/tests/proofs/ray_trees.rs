//! Whitted's and distributed ray tracing find the paths of their classes, and these alone.

use crate::bidirectional::{SIZE, means, room};
use crate::classes::{all_kinds, layers};
use crate::scenes::*;
use crate::stats::{close, level, same};
use kaustika_film::FilterDesc;
use kaustika_film::accumulate::PassImage;
use kaustika_film::path_expression::PathLayer;
use kaustika_math::Vec3;
use kaustika_math::special::p_two_sided;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::Scene;
use kaustika_scene::description::*;
use kaustika_spectra::ColorMode;
use kaustika_transport::{Frame, PassStats, Workers, registry};
use serde_json::{Value, json};
use std::sync::Arc;

/// The paths of a method, as `kaustika methods` tells them.
fn class(method: &str) -> &'static str {
    registry::find(method).expect("known").info.path_class
}

/// One pass of a 1 x 1 picture: its first component, and its work.
pub(crate) fn one(scene: &Scene, method: &str, p: Value, index: u64) -> (f64, PassStats) {
    let kind = SamplerKind::Independent;
    let config = SamplerConfig { kind, seed: 5, spp: 1, resolution: [1, 1] };
    let frame = Frame::new([1, 1], FilterDesc::BOX, config);
    let workers = Workers::new(1, Arc::default()).expect("threads");
    let Value::Object(p) = p else { panic!("an object") };
    let mut method = (registry::find(method).expect("known").make)(&p).expect("parameters");
    method.prepare(scene, &frame, &workers).expect("prepared");
    let mut image = PassImage::new(1, 1, frame.layers.clone());
    let commit = method.pass(index, scene, &frame, &mut image, &workers).expect("a pass");
    (f64::from(image.data()[0]), commit.stats)
}

/// All kinds of scattering and of lights, a mirror among them, behind a lens.
fn stage() -> Stage {
    let mut stage = all_kinds();
    let mirror = stage.metal(0.0);
    let upright = at(-0.3, 0.85, 0.6) * rotate(80.0, v(1.0, 0.0, 0.2));
    stage.shape(GeometryDesc::Rectangle, upright * scale(0.5, 0.4, 1.0), mirror);
    stage.point_light(v(-0.6, -0.5, 1.3), 0.8);
    let view = look(v(0.0, -3.0, 1.0), v(0.0, 0.0, 0.8));
    stage.camera(thin_lens(45.0, 0.05, 3.0), view, SIZE);
    stage
}

#[test]
fn classes_are_those_of_the_lecture() {
    assert_eq!(class("whitted"), "L[D|S]S_M*E");
    assert_eq!(class("distributed"), "L[D]S*E");
    for method in ["whitted", "distributed"] {
        PathLayer::parse(&format!("paths={}", class(method))).expect("an expression");
    }
}

#[test]
fn each_method_is_a_layer_of_path_tracing() {
    for mode in [ColorMode::Rgb, ColorMode::Spectral] {
        let scene = stage().build_in(mode);
        let p = json!({"max_depth": 6});
        let classes = [class("whitted"), class("distributed")];
        let path = layers(&scene, "path", p, &classes, 12_000, 1300);
        let p = |rays: u32| json!({"max_depth": 6, "shadow_rays": rays});
        let few = means(&scene, "whitted", p(1), 4000, 1301);
        same(&format!("whitted, one light, {mode:?}"), &few[4], &path[1]);
        let all = means(&scene, "whitted", p(0), 2000, 1302);
        same(&format!("whitted, every light, {mode:?}"), &all[4], &path[1]);
        for (i, (n, rays)) in [(1, 1), (1, 0), (4, 3), (3, 0)].into_iter().enumerate() {
            let p = json!({"max_depth": 6, "secondary_rays": n, "shadow_rays": rays});
            let tree = means(&scene, "distributed", p, 3000, 1310 + i as u64);
            let what = format!("distributed, {n} rays, {rays} shadow rays, {mode:?}");
            same(&what, &tree[4], &path[2]);
        }
        // The classes are different enough for a mistake to show.
        let (a, b) = (&few[4], &path[2]);
        let error = a.standard_error().hypot(b.standard_error());
        assert!(p_two_sided((a.mean() - b.mean()).abs() / error) < level());
    }
}

/// Rough metal under a lamp: both ways to find it count much, and their weights must know of all
/// rays of either.
#[test]
fn weights_of_rays_to_lamps_and_of_glossy_rays_add_up() {
    let mut stage = Stage::default();
    let metal = stage.metal(0.35);
    stage.shape(GeometryDesc::Rectangle, scale(4.0, 4.0, 1.0), metal);
    stage.lamp(GeometryDesc::Rectangle, at(0.0, 1.0, 1.5) * down() * scale(0.8, 0.8, 1.0), 3.0);
    let view = look(v(0.0, -2.5, 1.6), v(0.0, 0.0, 0.0));
    stage.camera(pinhole(45.0), view, SIZE);
    let scene = stage.build();
    let path = means(&scene, "path", json!({"max_depth": 1}), 6000, 1350);
    for (i, (n, rays)) in [(1, 1), (4, 1), (1, 3), (3, 2)].into_iter().enumerate() {
        let p = json!({"max_depth": 1, "secondary_rays": n, "shadow_rays": rays});
        let tree = means(&scene, "distributed", p, 3000, 1351 + i as u64);
        same(&format!("{n} rays, {rays} to the lamp"), &tree[4], &path[4]);
    }
}

/// The farther what a glossy mirror shows, the more it is blurred: as far, to scale.
#[test]
fn blur_widens_with_distance() {
    // The edge of a glowing wall, at a distance behind the place that is seen and to the side of it.
    let seen = |distance: f32, aside: f32, seed| {
        let mut stage = Stage::default();
        let metal = stage.metal(0.15);
        stage.shape(GeometryDesc::Rectangle, scale(50.0, 50.0, 1.0), metal);
        let upright = at(60.0, distance, 60.0) * rotate(90.0, Vec3::X) * scale(60.0, 60.0, 1.0);
        stage.lamp(GeometryDesc::Rectangle, upright, 1.0);
        let p = v(aside, 0.0, 0.0);
        stage.camera(parallel(1e-3, 0.0, 1.0), look(p + v(0.0, -0.5, 0.5), p), SIZE);
        means(&stage.build(), "distributed", json!({"max_depth": 1}), 200, seed)[4]
    };
    let (sharp, same_place) = (seen(1.0, 0.2, 1360), seen(3.0, 0.2, 1361));
    let to_scale = seen(3.0, 0.6, 1362);
    same("to scale", &to_scale, &sharp);
    assert!(same_place.mean() < 0.95 * sharp.mean(), "{} {}", same_place.mean(), sharp.mean());
}

#[test]
fn roulette_changes_no_mean() {
    let scene = stage().build();
    let picture = |method: &str, rule: &str, seed| {
        let p = json!({"max_depth": 6, "roulette": rule, "rr_depth": 0, "rr_threshold": 0.7});
        means(&scene, method, p, 3000, seed)[4]
    };
    for (i, method) in ["whitted", "distributed"].into_iter().enumerate() {
        let seed = 1330 + 10 * i as u64;
        let none = picture(method, "none", seed);
        same(method, &picture(method, "throughput", seed + 1), &none);
        same(method, &picture(method, "albedo", seed + 2), &none);
    }
}

/// Two mirrors face each other, a lamp is before one of them: image after image, each darker by the
/// mirror's reflectance.
#[test]
fn images_in_a_corridor_of_mirrors_darken_by_a_power() {
    const RHO: f32 = 0.7;
    for n in 0..8 {
        let mut stage = Stage::new();
        let (roughness, rho) = (stage.rough(0.0), stage.d.float(RHO));
        let color = ConductorColor::Mirror;
        let mirror = stage.material(MaterialModel::Conductor {
            color,
            specular_reflectance: rho,
            roughness,
        });
        let mirror = stage.two_sided(mirror);
        // The ray zigzags between x = -1 and x = 1, and climbs by 1 at each of them: the first is
        // met at y = 1/2, the others at 3/2, 5/2, ... A lamp closes the corridor behind mirror n.
        for side in [-1.0, 1.0] {
            let turned = at(side, 0.0, 0.0) * rotate(90.0, v(0.0, 1.0, 0.0));
            stage.shape(GeometryDesc::Rectangle, turned * scale(5.0, 50.0, 1.0), mirror);
        }
        let end = at(0.0, n as f32, 0.0) * rotate(90.0, Vec3::X) * scale(2.0, 5.0, 1.0);
        let lamp = stage.lamp(GeometryDesc::Rectangle, end, 3.0);
        lamp.emission.as_mut().expect("a lamp").two_sided = true;
        let start = v(0.0, if n == 0 { -0.25 } else { 0.0 }, 0.0);
        stage.camera(parallel(1e-3, 0.0, 1.0), look(start, start + v(1.0, 0.5, 0.0)), [1, 1]);
        let scene = stage.build();
        for method in ["whitted", "distributed"] {
            let (found, _) = one(&scene, method, json!({"roulette": "none", "max_depth": 20}), 0);
            close(method, found, 3.0 * f64::from(RHO).powi(n), 1e-4);
        }
    }
}

/// Both ways are followed: what glass reflects and what it lets through, without noise.
#[test]
fn whitted_follows_reflection_and_refraction() {
    // A slab of glass before a lamp of radiance 2, a lamp of radiance 5 behind the eye; (1 - R) and R
    // of them, R of both faces with all reflections between.
    let mut stage = Stage::new();
    let glass = stage.glass(1.5, 0.0);
    stage.shape(GeometryDesc::Cube, at(0.0, 0.0, 2.0) * scale(3.0, 3.0, 0.5), glass);
    stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, 4.0) * down() * scale(9.0, 9.0, 1.0), 2.0);
    stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, -1.0) * scale(9.0, 9.0, 1.0), 5.0);
    stage.camera(parallel(1e-3, 0.0, 1.0), HERE, [1, 1]);
    let p = json!({"roulette": "none", "max_depth": 16});
    let (found, stats) = one(&stage.build(), "whitted", p, 0);
    let r = 0.04f64;
    let reflected = 2.0 * r / (1.0 + r);
    close("slab", found, 5.0 * reflected + 2.0 * (1.0 - reflected), 1e-5);
    assert!(stats.closest_rays > 16, "{stats:?}");
}

/// The cost of splitting: n rays at each hit are nᵏ after k bounces.
#[test]
fn secondary_rays_multiply() {
    // A closed box of rough metal that loses nothing: every ray goes on.
    let mut stage = room();
    stage.d.shapes.clear();
    let glossy = stage.metal(0.1);
    let inside = stage.two_sided(glossy);
    stage.shape(sphere(2.0), HERE, inside);
    stage.camera(pinhole(30.0), HERE, [1, 1]);
    let scene = stage.build();
    for n in 1..=4u32 {
        let p = json!({"secondary_rays": n, "max_depth": 5, "roulette": "none"});
        // Light that passes behind the facets of one end is lost; 5 % at most of a bounce.
        let most: u64 = (0..=5).map(|k| u64::from(n).pow(k)).sum();
        let rays = one(&scene, "distributed", p, 0).1.closest_rays;
        assert!(rays <= most && rays > most / 2, "{n}: {rays} of {most}");
    }
}
