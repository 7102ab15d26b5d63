//! The hierarchy of radiosity where surfaces are many and small: clusters, and how refining ends early.

use crate::radiosity::{cube, solved};
use crate::scenes::*;
use kaustika_scene::Scene;
use kaustika_scene::description::GeometryDesc;
use kaustika_transport::Workers;
use kaustika_transport::method::RenderError;
use kaustika_transport::radiosity::{RadiosityParams, Solution};
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// A room with `n`³ small boxes that float in it, 12 n³ triangles, under a lamp.
fn crowded(n: u32) -> Scene {
    let mut stage = cube(0.5);
    let white = stage.diffuse(0.7);
    let at_cell = |i: u32| 1.6 * (i as f32 + 0.5) / n as f32 - 0.8;
    let wide = 0.25 / n as f32;
    for (x, y, z) in (0..n).flat_map(|x| (0..n).flat_map(move |y| (0..n).map(move |z| (x, y, z)))) {
        let place = at(at_cell(x), at_cell(y), at_cell(z));
        stage.shape(GeometryDesc::Cube, place * scale(wide, wide, wide), white);
    }
    stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, 0.99) * down() * scale(0.3, 0.3, 1.0), 10.0);
    stage.build()
}

fn params(p: Value) -> RadiosityParams {
    serde_json::from_value(p).expect("parameters")
}

/// Links are of patches as large as were asked for, not of triangles: of 2,320 leaves there are 270,979, of 6,928
/// 366,517, 53 of each. Were small clusters divided too, there would be 64, and 56 if what is hidden were divided for
/// being near.
#[test]
fn links_do_not_grow_as_small_triangles() {
    let found = [4, 8].map(|n| {
        let s = solved(
            &crowded(n),
            json!({"solver": "hierarchical", "direct": "mesh", "patches": 1000, "polish": 0}),
        );
        (s.leaves.len(), s.links)
    });
    assert!(2 * found[1].0 > 5 * found[0].0, "{found:?}");
    assert!(found[1].1 < 2 * found[0].1, "{found:?}");
    assert!(2 * found[1].1 < 109 * found[1].0, "{found:?}");
}

/// However little links may err by, there are at most 64 of each element.
#[test]
fn links_are_limited() {
    let scene = crowded(4);
    let s = solved(
        &scene,
        json!({"solver": "hierarchical", "direct": "mesh", "patches": 1500, "polish": 0, "error": 1e-6}),
    );
    let elements = s.mesh.elements.len();
    // Links that carry nothing are not kept in the end.
    assert!(s.links <= 64 * elements && 3 * s.links > 64 * elements, "{} of {elements}", s.links);
}

/// What clusters exchange is what the matrix finds, over all surfaces by area.
#[test]
fn crowds_get_the_light_of_the_matrix() {
    let scene = crowded(4);
    let matrix = solved(
        &scene,
        json!({"solver": "jacobi", "direct": "mesh", "patches": 2500, "samples": 2048, "polish": 0}),
    );
    let of = |p: Value| {
        let hierarchy = solved(&scene, p);
        let (mut difference, mut all, mut sums) = (0.0f64, 0.0f64, [0.0f64; 2]);
        for (&leaf, h) in matrix.leaves.iter().zip(&matrix.indirect.leaves) {
            let element = &matrix.mesh.elements[leaf as usize];
            let s = matrix.mesh.surface(&scene, leaf, [1.0 / 3.0; 3]);
            let [other, _] = hierarchy.irradiance(&scene, &s, element.normal).expect("a leaf");
            let weight = f64::from(element.area * element.albedo.0[0]);
            difference += weight * f64::from(h.0[0] - other.0[0]).powi(2);
            all += weight * f64::from(h.0[0]).powi(2);
            sums[0] += weight * f64::from(h.0[0]);
            sums[1] += weight * f64::from(other.0[0]);
        }
        ((difference / all).sqrt(), sums[1] / sums[0])
    };
    let bare =
        of(json!({"solver": "hierarchical", "direct": "mesh", "patches": 2500, "polish": 0}));
    let polished = of(json!({"solver": "hierarchical", "direct": "mesh", "patches": 2500}));
    assert!(bare.0 < 0.2 && (bare.1 - 1.0).abs() < 0.06, "{bare:?}");
    assert!(polished.0 < 0.1 && (polished.1 - 1.0).abs() < 0.02, "{polished:?}");
}

/// With one thread or three, listened to or not: the same bits.
#[test]
fn a_hierarchy_is_the_same_for_any_number_of_threads() {
    let scene = crowded(4);
    let p =
        params(json!({"solver": "hierarchical", "direct": "mesh", "patches": 1000, "polish": 8}));
    let told = Arc::new(AtomicUsize::new(0));
    let listener = told.clone();
    let workers = |n| Workers::new(n, Arc::default()).expect("threads");
    let listened = workers(3).told_to(move |_| {
        listener.fetch_add(1, Ordering::Relaxed);
    });
    let [one, three] = [workers(1), listened]
        .map(|workers| Solution::new(&scene, &p, &workers).expect("a solution"));
    assert!(told.load(Ordering::Relaxed) > 0);
    assert_eq!(one.links, three.links);
    assert_eq!(one.indirect.leaves, three.indirect.leaves);
}

/// Refining ends where it is when it is cancelled, in the middle of a sweep over the links: of two threads, one may
/// be about to tell that it asked.
#[test]
fn refining_ends_when_cancelled() {
    let scene = crowded(4);
    let cancel = Arc::new(AtomicBool::new(false));
    let (asked, flag) = (Arc::new(AtomicUsize::new(0)), cancel.clone());
    let heard = asked.clone();
    let workers = Workers::new(2, cancel).expect("threads").told_to(move |text| {
        let of = |text: &str| text.strip_suffix(" links asked")?.rsplit(' ').next()?.parse().ok();
        if of(text).is_some_and(|all: usize| all > 20_000) {
            heard.fetch_add(1, Ordering::Relaxed);
            flag.store(true, Ordering::Relaxed);
        }
    });
    let p = params(json!({"solver": "hierarchical", "direct": "mesh", "patches": 4000}));
    let found = Solution::new(&scene, &p, &workers);
    assert!(matches!(found, Err(RenderError::Cancelled)));
    let asked = asked.load(Ordering::Relaxed);
    assert!((1..=2).contains(&asked), "told {asked} times");
}

/// Where there are more triangles than patches, rays from each find a matrix; else links.
#[test]
fn solvers_are_chosen_by_the_number_of_triangles() {
    let scene = crowded(2);
    let links = |patches: u32| {
        solved(&scene, json!({"direct": "mesh", "patches": patches, "samples": 8, "polish": 0}))
            .links
    };
    assert!(links(1000) > 0);
    assert_eq!(links(50), 0);
    // Mirrors and gloss are in rows alone.
    let extended = json!({"patches": 1000, "extended": true, "samples": 8});
    assert_eq!(solved(&scene, extended).links, 0);
}
