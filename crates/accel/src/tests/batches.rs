//! Batches of segments against one ray at a time: equal bit for bit.

use kaustika_math::{Ray, Vec3};

use super::meshes::{Mesh, Random};
use crate::packet::Packet;
use crate::{BuildOptions, Segment, TriangleBvh, TriangleHit};

fn build(mesh: &Mesh) -> TriangleBvh {
    TriangleBvh::build(&mesh.positions, &mesh.indices, &BuildOptions::default())
}

/// Runs of rays of one kind: of any directions, of nearly one direction from one point or from
/// nearby points, and here and there what is no ray.
fn segments(mesh: &Mesh, count: usize, r: &mut Random) -> Vec<Segment> {
    let mut out = Vec::new();
    while out.len() < count {
        let first = mesh.ray(r);
        let (kind, spread) = (r.below(4), [0.0, 1e-4, 0.01, 0.1][r.below(4)]);
        let size = first.d.length();
        for _ in 0..r.below(40) {
            let mut ray = match kind {
                0 => mesh.ray(r),
                1 => Ray::new(first.o, first.d + r.cube() * (spread * size)),
                _ => Ray::new(first.o + r.cube() * spread, first.d + r.cube() * (spread * size)),
            };
            if r.below(50) == 0 {
                let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][r.below(3)];
                [&mut ray.o, &mut ray.d][r.below(2)][r.below(3)] = bad;
            }
            let t_max = match r.below(12) {
                0 => f32::NAN,
                1 => -1.0,
                2 => 0.0,
                3..=6 => 2.0 * r.unit() / size,
                _ => f32::INFINITY,
            };
            out.push(Segment { ray, t_max });
        }
    }
    out.truncate(count);
    out
}

fn compare(mesh: &Mesh, bvh: &TriangleBvh, segments: &[Segment], salt: u32) {
    let name = mesh.name;
    let rubbish = Some(TriangleHit { t: 1.0, prim: 1 << 30, b: [1.0; 3] });
    let (mut hits, mut occluded) = (vec![rubbish; segments.len()], vec![true; segments.len()]);
    bvh.intersect_all(segments, &mut hits);
    bvh.occluded_all(segments, &mut occluded);
    for (i, s) in segments.iter().enumerate() {
        assert_eq!(hits[i], bvh.intersect(&s.ray, s.t_max), "{name} {i}: {s:?}");
        assert_eq!(occluded[i], bvh.occluded(&s.ray, s.t_max), "{name} {i}: {s:?}");
    }

    // Through a mask that differs from segment to segment.
    let accept = |i: usize, h: &TriangleHit| (h.prim ^ salt ^ i as u32).count_ones() & 1 == 0;
    bvh.intersect_all_filtered(segments, &mut hits, accept);
    let mut seen = vec![Vec::new(); segments.len()];
    bvh.occluded_all_filtered(segments, &mut occluded, |i, h| {
        seen[i].push(*h);
        accept(i, h)
    });
    for (i, s) in segments.iter().enumerate() {
        let alone = bvh.intersect_filtered(&s.ray, s.t_max, |h| accept(i, h));
        assert_eq!(hits[i], alone, "{name} {i}: {s:?}");
        assert_eq!(occluded[i], alone.is_some(), "{name} {i}: {s:?}");
        if occluded[i] {
            let (last, before) = seen[i].split_last().expect("something was accepted");
            assert!(accept(i, last) && !before.iter().any(|h| accept(i, h)), "{name} {i}");
        } else {
            // Every hit was shown once, as it is.
            let mut all = Vec::new();
            bvh.occluded_filtered(&s.ray, s.t_max, |h| {
                all.push(*h);
                false
            });
            all.sort_by_key(|h| h.prim);
            seen[i].sort_by_key(|h| h.prim);
            assert_eq!(seen[i], all, "{name} {i}: {s:?}");
        }
    }
}

#[test]
fn batches_equal_single_rays() {
    for mesh in Mesh::all() {
        let bvh = build(&mesh);
        let mut r = Random::new(11);
        for round in 0..10 {
            for count in [0, 1, 7, 8, 9, 17, 1000] {
                let segments = segments(&mesh, count, &mut r);
                compare(&mesh, &bvh, &segments, round);
            }
        }
    }
}

/// The tests above would pass without packets.
#[test]
fn many_groups_of_the_test_are_packets_and_many_are_not() {
    for mesh in Mesh::all() {
        let bvh = build(&mesh);
        let segments = segments(&mesh, 8000, &mut Random::new(14));
        let (groups, _) = segments.as_chunks();
        let packets = groups.iter().filter(|g| Packet::new(g, &bvh.bounds()).is_some()).count();
        // Single precision may overflow on the largest coordinates: no packets there. Nor where
        // directions are very short, as between points of the smallest meshes.
        let expected = if bvh.bounds().max.max_component() > 1e12 { 0..1 } else { 20..950 };
        assert!(expected.contains(&packets), "{}: {packets} of 1000", mesh.name);
    }
}

#[test]
fn a_batch_may_be_cut_anywhere() {
    let mesh = Mesh::random("soup", 300, 0.2, 1.0);
    let bvh = build(&mesh);
    let segments = segments(&mesh, 500, &mut Random::new(12));
    let mut whole = vec![None; segments.len()];
    bvh.intersect_all(&segments, &mut whole);
    for size in [1, 3, 8, 16, 30, 64, 499] {
        let mut parts = vec![None; segments.len()];
        for (segments, hits) in segments.chunks(size).zip(parts.chunks_mut(size)) {
            bvh.intersect_all(segments, hits);
        }
        assert_eq!(parts, whole, "in parts of {size}");
    }
}

#[test]
fn trees_without_nodes_or_triangles() {
    let segment =
        Segment { ray: Ray::new(Vec3::new(0.25, 0.25, -2.0), Vec3::Z), t_max: f32::INFINITY };
    for (count, expected) in [(0, None), (1, Some(2.0))] {
        let bvh = TriangleBvh::build(
            &[Vec3::ZERO, Vec3::X, Vec3::Y],
            &vec![[0, 1, 2]; count],
            &BuildOptions::default(),
        );
        let mut hits = [Some(TriangleHit { t: 9.0, prim: 9, b: [0.0; 3] }); 20];
        let mut occluded = [count == 0; 20];
        bvh.intersect_all(&[segment; 20], &mut hits);
        bvh.occluded_all(&[segment; 20], &mut occluded);
        assert!(hits.iter().all(|h| h.map(|h| h.t) == expected));
        assert_eq!(occluded, [count == 1; 20]);
    }
}

#[test]
#[should_panic(expected = "one place for each hit")]
fn lengths_must_agree() {
    build(&Mesh::icosphere(1)).intersect_all(&[], &mut [None]);
}

#[test]
fn deep_trees_have_room_on_the_stack() {
    // Triangles over all magnitudes make trees of many levels.
    let mut r = Random::new(13);
    let mut positions = Vec::new();
    for i in 0..30_000 {
        let c = r.direction() * 2f32.powf(-100.0 + 140.0 * i as f32 / 30_000.0);
        positions.extend([c, c * 1.001 + r.cube() * 1e-30, c + r.cube() * c.length() * 0.01]);
    }
    let indices: Vec<[u32; 3]> =
        (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = Mesh { name: "magnitudes", positions, indices };
    let bvh = build(&mesh);
    assert!(bvh.stats().depth > 12, "depth {}", bvh.stats().depth);
    let segments: Vec<Segment> = (0..2000)
        .map(|_| {
            let i = mesh.indices[r.below(mesh.indices.len())][0] as usize;
            let o = mesh.positions[i] * 1.3;
            Segment { ray: Ray::new(o, mesh.positions[i] - o), t_max: 9.0 }
        })
        .collect();
    compare(&mesh, &bvh, &segments, 0);
}
