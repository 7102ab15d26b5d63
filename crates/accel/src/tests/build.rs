//! The builder: the same tree for any number of threads, sound trees, bounded depth.

use kaustika_math::Vec3;

use super::meshes::{Mesh, Random};
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
