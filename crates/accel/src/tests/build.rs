//! The builder: the same tree for any number of threads, sound trees, bounded depth.

use kaustika_math::{Bounds3, Vec3};
use rayon::prelude::*;

use super::meshes::{Mesh, Random};
use crate::builder::{self, WideTree};
use crate::{BuildOptions, TriangleBvh};

fn build_with(threads: usize, mesh: &Mesh) -> TriangleBvh {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| TriangleBvh::build(&mesh.positions, &mesh.indices, &BuildOptions::default()))
}

#[test]
fn the_number_of_threads_does_not_matter() {
    // The largest is split by the parallel code paths.
    for mesh in [Mesh::random("soup", 300, 0.2, 1.0), Mesh::icosphere(3), Mesh::grid(250)] {
        let one = build_with(1, &mesh);
        for threads in [2, 5] {
            assert!(one.is_same_tree(&build_with(threads, &mesh)), "{}", mesh.name);
        }
    }
}

#[test]
fn every_triangle_is_in_one_leaf() {
    for mesh in Mesh::all() {
        let stats = build_with(1, &mesh).stats();
        assert_eq!(stats.primitives, mesh.indices.len(), "{}", mesh.name);
        // Each node and leaf but the root is the child of one node.
        let root_is_node = usize::from(stats.nodes > 0);
        assert_eq!(
            stats.children,
            (stats.nodes + stats.leaves - 1) * root_is_node,
            "{}",
            mesh.name
        );
    }
}

#[test]
fn coinciding_triangles_do_not_make_a_deep_tree() {
    let n = 50_000;
    let positions = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let bvh = TriangleBvh::build(&positions, &vec![[0, 1, 2]; n], &BuildOptions::default());
    assert_eq!(bvh.stats().primitives, n);
    assert!(bvh.stats().depth <= 16, "depth {}", bvh.stats().depth);
}

#[test]
fn geometry_over_all_magnitudes_does_not_make_too_deep_a_tree() {
    let mut r = Random::new(6);
    let mut positions = Vec::new();
    for i in 0..30_000 {
        let c = r.direction() * 2f32.powf(-100.0 + 140.0 * i as f32 / 30_000.0);
        positions.extend([c, c * 1.001 + r.cube() * 1e-30, c + r.cube() * c.length() * 0.01]);
    }
    let indices: Vec<[u32; 3]> =
        (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let bvh = TriangleBvh::build(&positions, &indices, &BuildOptions::default());
    assert!(bvh.stats().depth <= crate::builder::MAX_DEPTH);
    let mesh = Mesh { name: "magnitudes", positions, indices };
    for _ in 0..2000 {
        let i = mesh.indices[r.below(mesh.indices.len())][0] as usize;
        let d = mesh.positions[i] * 1.3;
        let ray = kaustika_math::Ray::new(d, mesh.positions[i] - d);
        assert_eq!(bvh.intersect(&ray, 9.0).is_some(), bvh.occluded(&ray, 9.0));
    }
}

#[test]
fn options_out_of_range_are_brought_into_it() {
    let mesh = Mesh::icosphere(2);
    for options in [
        BuildOptions { bins: 0, leaf_cost: 0.0 },
        BuildOptions { bins: 1 << 20, leaf_cost: 1e30 },
        BuildOptions { bins: 7, leaf_cost: f32::NAN },
        BuildOptions { bins: 7, leaf_cost: -1.0 },
    ] {
        let bvh = TriangleBvh::build(&mesh.positions, &mesh.indices, &options);
        assert_eq!(bvh.stats().primitives, mesh.indices.len(), "{options:?}");
    }
}

/// A wide tree written down as nodes of (box, leaf or node, place) and leaves of primitives.
fn check_wide_tree<const WIDTH: usize>(boxes: &[Bounds3], leaf_size: usize) {
    let mut refs = builder::references(boxes.len(), |i| Some(boxes[i]));
    let tree = WideTree::<WIDTH>::build(&mut refs, leaf_size, &BuildOptions::default());
    let (root, bounds) = (tree.root.unwrap(), tree.bounds);
    assert!(!root.is_leaf() && root.index() == 0);
    let leaves = tree.leaves.map(&refs, |l| l.iter().map(|r| r.prim()).collect());
    let leaves: Vec<Vec<u32>> = leaves.collect();
    let nodes = tree.nodes.map(|children| {
        assert!((2..=WIDTH).contains(&children.len()));
        children.iter().map(|c| (c.bounds, c.place)).collect()
    });
    let nodes: Vec<Vec<_>> = nodes.collect();
    // Siblings are consecutive, nodes among nodes and leaves among leaves.
    for node in &nodes {
        for leaf in [false, true] {
            let places = node.iter().filter(|c| c.1.is_leaf() == leaf).map(|c| c.1.index());
            let places: Vec<usize> = places.collect();
            assert!(places.windows(2).all(|w| w[1] == w[0] + 1), "{places:?}");
        }
    }
    // From the root down all is met once, and lies within the boxes above it.
    let (mut met_nodes, mut met_prims) = (0, vec![0; boxes.len()]);
    let mut stack = vec![(root, bounds)];
    while let Some((place, bounds)) = stack.pop() {
        let held = if place.is_leaf() {
            let prims = &leaves[place.index()];
            assert!((1..=leaf_size).contains(&prims.len()));
            prims.iter().for_each(|&p| met_prims[p as usize] += 1);
            prims.iter().fold(Bounds3::EMPTY, |all, &p| all.union(boxes[p as usize]))
        } else {
            met_nodes += 1;
            stack.extend(nodes[place.index()].iter().map(|&(b, p)| (p, b)));
            nodes[place.index()].iter().fold(Bounds3::EMPTY, |all, c| all.union(c.0))
        };
        assert_eq!(held, bounds);
    }
    assert_eq!(met_nodes, nodes.len());
    assert!(met_prims.iter().all(|&n| n == 1));
}

#[test]
fn trees_of_any_width_hold_everything_once_and_siblings_together() {
    let mut r = Random::new(12);
    // More than are cut as one chunk, some in one place.
    let boxes: Vec<Bounds3> = (0..40_000)
        .map(|i| {
            let c = if i % 7 == 0 { Vec3::X } else { r.cube() };
            Bounds3::new(c, c + r.cube() * 0.01)
        })
        .collect();
    for n in [9, 100, boxes.len()] {
        check_wide_tree::<4>(&boxes[..n], 4);
        check_wide_tree::<8>(&boxes[..n], 8);
        check_wide_tree::<8>(&boxes[..n], 1);
        check_wide_tree::<16>(&boxes[..n], 5);
    }
}

#[test]
fn walls_do_not_spoil_what_is_between_them() {
    let mut room = Mesh::random("room", 20_000, 0.01, 0.9);
    let tests = |mesh: &Mesh| {
        let stats = build_with(1, mesh).stats();
        stats.expected_tests[0] + stats.expected_tests[1]
    };
    let without = tests(&room);
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let first = room.positions.len() as u32;
            for (u, v) in [(-1.0, -1.0), (3.0, -1.0), (-1.0, 3.0)] {
                let mut p = Vec3::splat(side);
                (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (u, v);
                room.positions.push(p);
            }
            room.indices.push([first, first + 1, first + 2]);
        }
    }
    // What is between the walls is met by fewer lines through the larger box; the six walls take a
    // node and a leaf or two.
    let with = tests(&room);
    assert!(with < without + 4.0, "{without} -> {with}");
}
