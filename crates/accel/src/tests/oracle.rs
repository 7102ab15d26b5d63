//! Hits against a triangle test in double precision.

use kaustika_math::Ray;

use super::meshes::{Mesh, Random};
use crate::{BuildOptions, Segment, TriangleBvh};

type V = [f64; 3];

fn sub(a: V, b: V) -> V {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn cross(a: V, b: V) -> V {
    [0, 1, 2].map(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Möller & Trumbore (1997): t, the weights, and how t reacts to a relative error of the
/// coordinates: its condition number times t.
fn double(corners: [[f32; 3]; 3], ray: &Ray) -> (f64, [f64; 3], f64) {
    let [a, b, c] = corners.map(|p| p.map(f64::from));
    let (o, d): (V, V) =
        (<[f32; 3]>::from(ray.o).map(f64::from), <[f32; 3]>::from(ray.d).map(f64::from));
    let (e1, e2, s) = (sub(b, a), sub(c, a), sub(o, a));
    let n = cross(e1, e2);
    let det = -dot(d, n);
    let t = dot(s, n) / det;
    let m = cross(s, d);
    let (u, v) = (dot(e2, m) / det, -dot(e1, m) / det);
    let length = |v: V| dot(v, v).sqrt();
    // A shift of a corner by the error of its sheared coordinates moves the plane by as much, and
    // the hit by that over the cosine.
    let reach = [a, b, c].iter().map(|p| length(sub(*p, o))).fold(0.0, f64::max);
    let condition = reach * length(n) / dot(d, n).abs();
    (t, [1.0 - u - v, u, v], condition)
}

#[test]
fn hits_are_as_near_to_the_exact_ones_as_single_precision_allows() {
    for mesh in Mesh::all() {
        let bvh = TriangleBvh::build(&mesh.positions, &mesh.indices, &BuildOptions::default());
        let mut r = Random::new(9);
        let mut worst = 0f64;
        // Each ray and seven beside it, so that there are packets and single rays.
        let mut segments = Vec::new();
        for _ in 0..20_000 / 8 {
            let ray = mesh.ray(&mut r);
            for _ in 0..8 {
                let d = ray.d + r.cube() * (1e-3 * ray.d.length());
                segments.push(Segment { ray: Ray::new(ray.o, d), t_max: f32::INFINITY });
            }
        }
        segments
            .extend((0..10_000).map(|_| Segment { ray: mesh.ray(&mut r), t_max: f32::INFINITY }));
        let mut hits = vec![None; segments.len()];
        bvh.intersect_all(&segments, &mut hits);
        for (Segment { ray, .. }, hit) in segments.iter().zip(hits) {
            let Some(hit) = hit else { continue };
            let corners = mesh.corners(hit.prim);
            let sum: f32 = hit.b.iter().sum();
            assert!((sum - 1.0).abs() <= 4e-7 && hit.b.iter().all(|b| *b >= 0.0), "{hit:?}");
            let (t, _, condition) = double(corners, ray);
            if !(t.is_finite() && condition.is_finite()) {
                continue;
            }
            let error = (f64::from(hit.t) - t).abs() / condition / 2f64.powi(-24);
            worst = worst.max(error);
            assert!(error <= 8.0, "{}: {ray:?} {hit:?} exact {t}: {error} units", mesh.name);
        }
        println!("{}: t within {worst:.2} units", mesh.name);
    }
}

#[test]
fn weights_of_well_shaped_triangles_are_exact_to_rounding() {
    let mesh = Mesh::icosphere(2);
    let bvh = TriangleBvh::build(&mesh.positions, &mesh.indices, &BuildOptions::default());
    let mut r = Random::new(10);
    for _ in 0..50_000 {
        let ray = Ray::new(r.cube() * 0.5, r.direction());
        let hit = bvh.intersect(&ray, f32::INFINITY).expect("the sphere is closed");
        let (t, b, _) = double(mesh.corners(hit.prim), &ray);
        assert!((f64::from(hit.t) - t).abs() < 1e-6, "{ray:?} {hit:?} {t}");
        for (x, y) in hit.b.iter().zip(b) {
            // Edges are 0.3 long, and the corners at most 1.9 away.
            assert!((f64::from(*x) - y).abs() < 4e-6, "{ray:?} {hit:?} {b:?}");
        }
    }
}
