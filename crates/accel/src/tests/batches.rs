//! Batches of segments against one ray at a time: equal bit for bit.

use kaustika_math::{Ray, Vec3};

use super::meshes::{Mesh, Random};
use crate::accept::{Accept, Everything};
use crate::batch::Way;
use crate::classes::Classes;
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

const WAYS: [Way; 2] = [Way::Crowds, Way::Flights];

fn hits(
    bvh: &TriangleBvh,
    way: Way,
    segments: &[Segment],
    accept: impl Accept,
) -> Vec<Option<TriangleHit>> {
    let mut hits = vec![None; segments.len()];
    bvh.trace::<false>(Some(way), segments, accept, |i, hit| hits[i] = hit);
    hits
}

fn occluded(bvh: &TriangleBvh, way: Way, segments: &[Segment], accept: impl Accept) -> Vec<bool> {
    let mut occluded = vec![false; segments.len()];
    bvh.trace::<true>(Some(way), segments, accept, |i, hit| occluded[i] = hit.is_some());
    occluded
}

/// All queries for batches against those for single rays, on all ways.
fn compare(mesh: &Mesh, bvh: &TriangleBvh, segments: &[Segment], salt: u32) {
    let name = mesh.name;
    let rubbish = Some(TriangleHit { t: 1.0, prim: 1 << 30, b: [1.0; 3] });
    let (mut nearest, mut any) = (vec![rubbish; segments.len()], vec![true; segments.len()]);
    bvh.intersect_all(segments, &mut nearest);
    bvh.occluded_all(segments, &mut any);
    for (i, s) in segments.iter().enumerate() {
        assert_eq!(nearest[i], bvh.intersect(&s.ray, s.t_max), "{name} {i}: {s:?}");
        assert_eq!(any[i], bvh.occluded(&s.ray, s.t_max), "{name} {i}: {s:?}");
    }
    for way in WAYS {
        assert_eq!(hits(bvh, way, segments, Everything), nearest, "{name} {way:?}");
        assert_eq!(occluded(bvh, way, segments, Everything), any, "{name} {way:?}");
    }

    // Through a mask that differs from segment to segment.
    let accept = |i: usize, h: &TriangleHit| (h.prim ^ salt ^ i as u32).count_ones() & 1 == 0;
    bvh.intersect_all_filtered(segments, &mut nearest, accept);
    bvh.occluded_all_filtered(segments, &mut any, accept);
    for (i, s) in segments.iter().enumerate() {
        let alone = bvh.intersect_filtered(&s.ray, s.t_max, |h| accept(i, h));
        assert_eq!(nearest[i], alone, "{name} {i}: {s:?}");
        assert_eq!(any[i], alone.is_some(), "{name} {i}: {s:?}");
    }
    for way in WAYS {
        assert_eq!(hits(bvh, way, segments, accept), nearest, "{name} {way:?}");
        let mut seen = vec![Vec::new(); segments.len()];
        let occluded = occluded(bvh, way, segments, |i: usize, h: &TriangleHit| {
            seen[i].push(*h);
            accept(i, h)
        });
        assert_eq!(occluded, any, "{name} {way:?}");
        for (i, s) in segments.iter().enumerate() {
            let context = || format!("{name} {way:?} {i}: {s:?}");
            if occluded[i] {
                let (last, before) = seen[i].split_last().expect("something was accepted");
                let first = accept(i, last) && !before.iter().any(|h| accept(i, h));
                assert!(first, "{}", context());
            } else {
                // Every hit was shown once, as it is.
                let mut all = Vec::new();
                bvh.occluded_filtered(&s.ray, s.t_max, |h| {
                    all.push(*h);
                    false
                });
                all.sort_by_key(|h| h.prim);
                seen[i].sort_by_key(|h| h.prim);
                assert_eq!(seen[i], all, "{}", context());
            }
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

/// More rays than are sorted at a time.
#[test]
fn long_batches_equal_single_rays() {
    let mesh = Mesh::random("soup", 1500, 0.1, 1.0);
    let segments = segments(&mesh, 9000, &mut Random::new(15));
    compare(&mesh, &build(&mesh), &segments, 1);
}

/// The tests above would pass without crowds.
#[test]
fn most_rays_of_the_test_go_in_crowds_and_some_do_not() {
    for mesh in Mesh::all() {
        let bvh = build(&mesh);
        let segments = segments(&mesh, 4000, &mut Random::new(14));
        let classes = Classes::new(&segments, 0, &bvh.bounds());
        let sizes: Vec<usize> = classes.plain().map(|(_, rays)| rays.len()).collect();
        let (plain, special) = (sizes.iter().sum::<usize>(), classes.special().len());
        assert_eq!(plain + special, 4000);
        // Single precision may overflow on the largest coordinates. Directions are very short between
        // points of the smallest meshes, and long in large ones.
        let expected = if mesh.name == "huge" { 0..1 } else { 500..3500 };
        assert!(expected.contains(&plain), "{}: {plain} of 4000, {sizes:?}", mesh.name);
    }
}

#[test]
fn small_trees_are_for_crowds_and_large_ones_are_not() {
    let triangles = [12, 1200, 120_000];
    let expected =
        [(Way::Crowds, Way::Crowds), (Way::Crowds, Way::Crowds), (Way::Flights, Way::Flights)];
    for (triangles, ways) in triangles.into_iter().zip(expected) {
        let bvh = build(&Mesh::random("soup", triangles, 0.01, 1.0));
        assert_eq!(bvh.ways(), ways, "{triangles} triangles");
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
