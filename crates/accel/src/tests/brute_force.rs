//! Every query against testing all triangles with the scalar twin: equal bit for bit.

use kaustika_math::{Bounds3, Ray};

use super::meshes::{Mesh, Random};
use crate::edges::intersect_one;
use crate::ray::PreparedRay;
use crate::{BuildOptions, TriangleBvh, TriangleHit};

/// All hits with t in (0, t_max), in the order of the triangles.
fn all_hits(mesh: &Mesh, bounds: &Bounds3, ray: &Ray, t_max: f32) -> Vec<TriangleHit> {
    let Some(prepared) = PreparedRay::new(ray, bounds) else { return Vec::new() };
    (0..mesh.indices.len() as u32)
        .filter_map(|prim| {
            let hit = intersect_one(&mesh.corners(prim), &prepared)?;
            let t = hit.t * prepared.scale;
            (hit.t < t_max / prepared.scale).then_some(TriangleHit { t, prim, b: hit.b })
        })
        .collect()
}

/// Of equal distances the first.
fn nearest(hits: &[TriangleHit]) -> Option<TriangleHit> {
    hits.iter().copied().reduce(|a, b| if b.t < a.t { b } else { a })
}

fn compare(mesh: &Mesh, rays: usize) {
    let bvh = TriangleBvh::build(&mesh.positions, &mesh.indices, &BuildOptions::default());
    assert_eq!(bvh.triangle_count(), mesh.indices.len(), "{}", mesh.name);
    let mut r = Random::new(mesh.indices.len() as u64);
    let mut hit_count = 0;
    for i in 0..rays {
        let ray = mesh.ray(&mut r);
        let hits = all_hits(mesh, &bvh.bounds(), &ray, f32::INFINITY);
        let expected = nearest(&hits);
        let name = mesh.name;
        assert_eq!(bvh.intersect(&ray, f32::INFINITY), expected, "{name} {i}: {ray:?}");
        assert_eq!(bvh.occluded(&ray, f32::INFINITY), expected.is_some(), "{name} {i}: {ray:?}");
        hit_count += hits.len();

        // With an end, sometimes exactly at a hit.
        let t_max = match hits.get(r.below(hits.len() + 2)) {
            Some(h) => h.t,
            None => hits.first().map_or(1.0, |h| h.t * (0.5 + r.unit())),
        };
        let hits = all_hits(mesh, &bvh.bounds(), &ray, t_max);
        assert_eq!(bvh.intersect(&ray, t_max), nearest(&hits), "{name} {i}: {ray:?} to {t_max}");
        assert_eq!(bvh.occluded(&ray, t_max), !hits.is_empty(), "{name} {i}: {ray:?} to {t_max}");

        // Through a mask.
        let salt = r.bits() as u32;
        let accept = |h: &TriangleHit| (h.prim ^ salt).count_ones() & 1 == 0;
        let accepted: Vec<_> = hits.iter().copied().filter(accept).collect();
        assert_eq!(bvh.intersect_filtered(&ray, t_max, accept), nearest(&accepted), "{name} {i}");
        let mut seen = Vec::new();
        let any = bvh.occluded_filtered(&ray, t_max, |h| {
            seen.push(*h);
            accept(h)
        });
        assert_eq!(any, !accepted.is_empty(), "{name} {i}");
        if !any {
            // Nothing stopped the walk: it has shown every hit once.
            seen.sort_by_key(|h| h.prim);
            assert_eq!(seen, hits, "{name} {i}");
        }
    }
    assert!(hit_count > rays / 20, "{}: only {hit_count} hits", mesh.name);
}

#[test]
fn queries_equal_brute_force() {
    for mesh in Mesh::all() {
        compare(&mesh, (3_000_000 / mesh.indices.len()).min(20_000));
    }
}

/// A million rays on each mesh: minutes.
#[test]
#[ignore = "slow; the test above is the same with fewer rays"]
fn a_million_queries_equal_brute_force() {
    for mesh in Mesh::all() {
        compare(&mesh, 1_000_000);
    }
}
