//! No ray leaves a closed mesh.

use kaustika_math::{Ray, Vec3};

use super::meshes::{Mesh, Random};
use crate::{BuildOptions, Segment, TriangleBvh};

/// Rays that leave, alone or in a batch.
fn leaks(mesh: &Mesh, rays: impl Iterator<Item = Ray>) -> usize {
    let bvh = TriangleBvh::build(&mesh.positions, &mesh.indices, &BuildOptions::default());
    let segments: Vec<Segment> = rays.map(|ray| Segment { ray, t_max: f32::INFINITY }).collect();
    let alone =
        |s: &&Segment| bvh.intersect(&s.ray, s.t_max).is_none() || !bvh.occluded(&s.ray, s.t_max);
    segments.iter().filter(alone).count() + leaks_of_batches(&bvh, &segments)
}

fn leaks_of_batches(bvh: &TriangleBvh, segments: &[Segment]) -> usize {
    const SIZE: usize = 4096;
    let (mut hits, mut occluded) = (vec![None; SIZE], vec![false; SIZE]);
    let mut leaks = 0;
    for batch in segments.chunks(SIZE) {
        let (hits, occluded) = (&mut hits[..batch.len()], &mut occluded[..batch.len()]);
        bvh.intersect_all(batch, hits);
        bvh.occluded_all(batch, occluded);
        leaks += hits.iter().zip(occluded).filter(|(h, o)| h.is_none() || !**o).count();
    }
    leaks
}

/// Half of the rays in all directions, half in bundles that go as packets.
#[test]
#[ignore = "slow; the tests below are the same with fewer rays"]
fn ten_million_rays_stay_in_a_sphere() {
    let mesh = Mesh::icosphere(6);
    let bvh = TriangleBvh::build(&mesh.positions, &mesh.indices, &BuildOptions::default());
    let mut r = Random::new(5);
    let mut leaks = 0;
    for _ in 0..1000 {
        let mut segments = Vec::new();
        for bundle in 0..10_000 / 8 {
            let (o, d) = (r.direction() * (0.95 * r.unit()), r.direction());
            for _ in 0..8 {
                let ray = match bundle % 2 {
                    0 => Ray::new(r.direction() * (0.95 * r.unit()), r.direction()),
                    _ => Ray::new(o, d + r.cube() * 0.02),
                };
                segments.push(Segment { ray, t_max: f32::INFINITY });
            }
        }
        leaks += leaks_of_batches(&bvh, &segments);
    }
    assert_eq!(leaks, 0);
}

#[test]
fn a_million_rays_stay_in_a_sphere() {
    let mesh = Mesh::icosphere(5);
    assert_eq!(mesh.indices.len(), 20_480);
    let mut r = Random::new(1);
    let rays = (0..1_000_000).map(|_| Ray::new(r.direction() * (0.95 * r.unit()), r.direction()));
    assert_eq!(leaks(&mesh, rays), 0);
}

#[test]
fn rays_at_vertices_and_edges_stay_in_a_sphere() {
    let mesh = Mesh::icosphere(5);
    let mut r = Random::new(2);
    let origins = [Vec3::ZERO, Vec3::new(0.3, -0.2, 0.5), Vec3::new(0.0, 0.0, 0.9)];
    let mut rays = Vec::new();
    for &i in &mesh.indices {
        let [a, b, c] = i.map(|i| mesh.positions[i as usize]);
        for target in [a, b, c, (a + b) * 0.5, (b + c) * 0.5, a.lerp(b, r.unit())] {
            let o = if r.below(2) == 0 { origins[r.below(3)] } else { r.cube() * 0.5 };
            rays.push(Ray::new(o, target - o));
            rays.push(Ray::new(o, (target - o).normalize()));
        }
    }
    assert_eq!(leaks(&mesh, rays.into_iter()), 0);
}

#[test]
fn moved_and_scaled_spheres_are_watertight_too() {
    let sphere = Mesh::icosphere(3);
    for (scale, offset) in [
        (1e-6, Vec3::ZERO),
        (1e-25, Vec3::ZERO),
        (1e14, Vec3::ZERO),
        (1.0, Vec3::new(1000.0, -2000.0, 50.0)),
        (0.01, Vec3::new(30.0, 20.0, -10.0)),
    ] {
        let place = |p: &Vec3| *p * scale + offset;
        let positions: Vec<Vec3> = sphere.positions.iter().map(place).collect();
        let mesh = Mesh { name: "sphere", positions, indices: sphere.indices.clone() };
        let mut r = Random::new(3);
        let mut rays = Vec::new();
        for k in 0..100_000 {
            let o = place(&(r.direction() * (0.8 * r.unit())));
            let target = match k % 3 {
                0 => place(&r.direction()),
                1 => mesh.positions[r.below(mesh.positions.len())],
                _ => {
                    let [a, b, _] = mesh.indices[r.below(mesh.indices.len())]
                        .map(|i| mesh.positions[i as usize]);
                    (a + b) * 0.5
                }
            };
            rays.push(Ray::new(o, target - o));
        }
        assert_eq!(leaks(&mesh, rays.into_iter()), 0, "scale {scale} offset {offset:?}");
    }
}

/// Large triangles close to the origin, at grazing angles: where sheared coordinates are worst.
#[test]
fn a_long_box_is_watertight_from_a_corner() {
    for length in [10.0, 1e3, 1e6] {
        let size = Vec3::new(length, 1.0, 1.0);
        let positions: Vec<Vec3> = (0..8)
            .map(|i| {
                let bit = |k: usize| if i >> k & 1 == 0 { -0.5 } else { 0.5 };
                Vec3::new(bit(0), bit(1), bit(2)) * size
            })
            .collect();
        let quads =
            [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
        let indices = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let mesh = Mesh { name: "box", positions, indices };
        let mut r = Random::new(4);
        let rays = (0..200_000).map(|k| {
            let o = r.cube() * 0.49 * size;
            let mut d = r.direction();
            if k % 2 == 0 {
                // Nearly along the box.
                d = Vec3::new(d.x, d.y / length, d.z / length);
            }
            Ray::new(o, d)
        });
        assert_eq!(leaks(&mesh, rays), 0, "length {length}");
    }
}
