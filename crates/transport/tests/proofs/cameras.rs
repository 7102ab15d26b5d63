//! What the film sees: coverage of edges, circles of confusion, distance.

use crate::scenes::*;
use crate::stats::{Random, agrees, close};
use kaustika_sampling::estimator::RunningMean;
use kaustika_scene::description::*;
use serde_json::json;

#[test]
fn radiance_does_not_depend_on_distance() {
    let mut stage = Stage::new();
    stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, 0.0) * scale(1e5, 1e5, 1.0), 0.7);
    for distance in [1e-3, 1.0, 37.0, 1e4] {
        let o = v(0.3, 0.2, distance);
        let seen = stage.probe(o, v(0.1, 0.2, -1.0), json!({}), 1);
        assert_eq!(seen.mean(), 0.7f32 as f64, "from {distance}");
        stage.camera(pinhole(30.0), look(o, v(0.3, 0.2, 0.0)), [2, 2]);
        for p in &stage.render(json!({}), 2, 1).pixels {
            assert_eq!(p.mean(), 0.7f32 as f64, "from {distance}");
        }
    }
}

/// Area of the part of the unit square at (x, y) where a·x + b·y < c.
fn coverage(x: f64, y: f64, [a, b, c]: [f64; 3]) -> f64 {
    let corners = [[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]];
    let side = |p: [f64; 2]| a * p[0] + b * p[1] - c;
    let mut inside = Vec::new();
    for i in 0..4 {
        let (p, q) = (corners[i], corners[(i + 1) % 4]);
        let (s, t) = (side(p), side(q));
        if s < 0.0 {
            inside.push(p);
        }
        if s * t < 0.0 {
            let k = s / (s - t);
            inside.push([p[0] + k * (q[0] - p[0]), p[1] + k * (q[1] - p[1])]);
        }
    }
    let n = inside.len();
    (0..n)
        .map(|i| {
            let (p, q) = (inside[i], inside[(i + 1) % n]);
            0.5 * (p[0] * q[1] - p[1] * q[0])
        })
        .sum::<f64>()
        .abs()
}

#[test]
fn a_slanted_edge_shows_its_coverage() {
    // Film 8 x 8 over [-4, 4]²: a triangle's edge crosses it; x = film x - 4, y = 4 - film y.
    let mut stage = Stage::new();
    let (a, b) = ([-3.1, -40.0], [2.3, 40.0]);
    let corner = |p: [f64; 2]| v(p[0] as f32, p[1] as f32, 5.0);
    stage.lamp(mesh(&[corner(a), corner(b), v(-90.0, 0.0, 5.0)], &[[0, 1, 2]]), HERE, 1.0);
    stage.d.shapes[0].emission.as_mut().expect("a lamp").two_sided = true;
    stage.camera(parallel(4.0, 0.0, 1.0), HERE, [8, 8]);
    // dy (x - ax) - dx (y - ay) < 0 is covered.
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let edge = [dy, -dx, dy * a[0] - dx * a[1]];
    let n = 2000;
    let picture = stage.render(json!({}), n, 2);
    let mut partly = 0;
    for y in 0..8 {
        for x in 0..8 {
            let truth = coverage(x as f64 - 4.0, 3.0 - y as f64, edge);
            let mean = picture.at(x, y).mean();
            if truth == 0.0 || truth == 1.0 {
                assert_eq!(mean, truth);
            } else {
                // Hits and misses: the law is known, also where a sample saw no miss.
                let error = (truth * (1.0 - truth) / n as f64).sqrt();
                agrees(&format!("pixel {x} {y}"), &with_error(mean, error), truth);
                partly += 1;
            }
        }
    }
    assert!(partly >= 8);
}

#[test]
fn the_circle_of_confusion_is_the_thin_lens_s() {
    // DOF on a film at distance 1: a point at z blurs over a circle of radius
    // r |z - z_f| / (z z_f), uniformly: E[ρ²] is half its square, and a small disc of radius s
    // adds (s/z)²/2. Parallel projection has r |z - z_f| / z_f and s.
    let (r, zf, size) = (0.2f64, 4.0f64, 48f64);
    let fov = 20f64;
    for (z, parallel_projection) in
        [(2.0, false), (4.0, false), (9.0, false), (7.0, true), (2.0, true)]
    {
        let s = 0.05 * z / 4.0;
        let mut stage = Stage::new();
        stage.lamp(disk(s as f32), at(0.0, 0.0, z as f32) * down(), 1.0);
        let (camera, pixels, blur, disc) = if parallel_projection {
            (parallel(0.5, r as f32, zf as f32), size, r * (z - zf).abs() / zf, s)
        } else {
            let pixels = size / (2.0 * (fov.to_radians() / 2.0).tan());
            let blur = r * (z - zf).abs() / (z * zf);
            (thin_lens(fov as f32, r as f32, zf as f32), pixels, blur, s / z)
        };
        stage.camera(camera, HERE, [size as u32; 2]);
        let scene = stage.build();
        let mut random = Random::new(z as u64);
        let (mut light, mut moment) = (RunningMean::new(), RunningMean::new());
        for _ in 0..200_000 {
            let film = random.v2() * size as f32;
            let ray = scene.camera.sample_we(film, random.v2(), 0.0).ray;
            let hit = scene.intersect(&ray, f32::INFINITY).is_some();
            light.push(f64::from(hit));
            if hit {
                let from_centre = film - v2(24.0, 24.0);
                moment.push(from_centre.length_squared() as f64);
            }
        }
        let truth = 0.5 * (blur * blur + disc * disc) * pixels * pixels;
        agrees(&format!("blur at {z}"), &moment, truth);
        let truth = std::f64::consts::PI * (disc * pixels / size).powi(2);
        agrees(&format!("light at {z}"), &light, truth);
    }
}

#[test]
fn clipping_planes_hide_what_is_nearer_and_farther() {
    let mut stage = Stage::new();
    for (z, l) in [(1.0, 1.0), (3.0, 2.0), (9.0, 4.0)] {
        stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, z) * down() * scale(20.0, 20.0, 1.0), l);
    }
    for (lens_radius, near, far, seen) in
        [(0.0, 2.0, 5.0, 2.0), (0.1, 2.0, 5.0, 2.0), (0.0, 4.0, 50.0, 4.0), (0.0, 1.5, 2.5, 0.0)]
    {
        let mut kind = thin_lens(40.0, lens_radius, 2.0);
        if let CameraKind::Perspective { near_clip, far_clip, .. } = &mut kind {
            (*near_clip, *far_clip) = (near, far);
        }
        stage.camera(kind, HERE, [3, 3]);
        for p in &stage.render(json!({}), 4, 3).pixels {
            close(&format!("{near}..{far}"), p.mean(), seen, 1e-6);
        }
    }
}
