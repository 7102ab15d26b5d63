//! The small print: ends of rays, degenerate input, odd rays.

use kaustika_math::{Bounds3, Ray, Vec3};

use crate::{BoxBvh, BuildOptions, TriangleBvh};

fn build(positions: &[Vec3], indices: &[[u32; 3]]) -> TriangleBvh {
    TriangleBvh::build(positions, indices, &BuildOptions::default())
}

fn one_triangle() -> TriangleBvh {
    build(&[Vec3::ZERO, Vec3::X, Vec3::Y], &[[0, 1, 2]])
}

#[test]
fn ends_of_the_ray_are_excluded() {
    let bvh = one_triangle();
    let ray = Ray::new(Vec3::new(0.25, 0.25, -2.0), Vec3::Z);
    assert_eq!(bvh.intersect(&ray, f32::INFINITY).unwrap().t, 2.0);
    assert!(bvh.intersect(&ray, 2.0).is_none() && !bvh.occluded(&ray, 2.0));
    assert!(bvh.intersect(&ray, 2f32.next_up()).is_some() && bvh.occluded(&ray, 2f32.next_up()));
    let on = Ray::new(Vec3::new(0.25, 0.25, 0.0), Vec3::Z);
    assert!(bvh.intersect(&on, f32::INFINITY).is_none() && !bvh.occluded(&on, 1.0));
    let beyond = Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::Z);
    assert!(bvh.intersect(&beyond, f32::INFINITY).is_none());
    for t_max in [0.0, -1.0, f32::NEG_INFINITY, f32::NAN] {
        assert!(bvh.intersect(&ray, t_max).is_none() && !bvh.occluded(&ray, t_max), "{t_max}");
    }
}

#[test]
fn distances_are_in_lengths_of_the_direction() {
    let bvh = one_triangle();
    for k in -90..=90 {
        let length = 2f32.powi(k);
        let ray = Ray::new(Vec3::new(0.25, 0.25, -2.0), Vec3::Z * length);
        assert_eq!(bvh.intersect(&ray, f32::INFINITY).unwrap().t, 2.0 / length, "2^{k}");
    }
}

#[test]
fn weights_belong_to_the_corners_in_order() {
    let hit = one_triangle()
        .intersect(&Ray::new(Vec3::new(0.5, 0.125, -1.0), Vec3::Z), f32::INFINITY)
        .unwrap();
    assert_eq!(hit.b, [0.375, 0.5, 0.125]);
}

#[test]
fn of_equal_distances_the_lowest_triangle_wins() {
    // Twenty copies, so that they are spread over several leaves.
    let indices = vec![[0, 1, 2]; 20];
    let bvh = build(&[Vec3::ZERO, Vec3::X, Vec3::Y], &indices);
    let ray = Ray::new(Vec3::new(0.25, 0.25, -2.0), Vec3::Z);
    assert_eq!(bvh.intersect(&ray, f32::INFINITY).unwrap().prim, 0);
    let late = bvh.intersect_filtered(&ray, f32::INFINITY, |h| h.prim >= 13);
    assert_eq!(late.unwrap().prim, 13);
}

#[test]
fn empty_and_degenerate_input() {
    let ray = Ray::new(Vec3::new(0.25, 0.25, -2.0), Vec3::Z);
    let none = build(&[], &[]);
    assert!(none.intersect(&ray, f32::INFINITY).is_none() && !none.occluded(&ray, 9.0));
    assert!(none.bounds().is_empty());
    assert_eq!((none.triangle_count(), none.memory_bytes(), none.stats().depth), (0, 0, 0));

    let nan = Vec3::new(0.0, f32::NAN, 0.0);
    let inf = Vec3::new(f32::INFINITY, 0.0, 0.0);
    let positions =
        [Vec3::ZERO, Vec3::X, Vec3::Y, nan, inf, Vec3::X * 2.0, Vec3::X * 1e19, Vec3::splat(7.0)];
    let indices =
        [[0, 1, 3], [4, 1, 2], [0, 0, 1], [0, 1, 5], [0, 1, 99], [0, 2, 6], [7, 7, 7], [0, 1, 2]];
    let bvh = build(&positions, &indices);
    assert_eq!(bvh.triangle_count(), 1);
    assert_eq!(bvh.bounds(), Bounds3::new(Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)));
    assert_eq!(bvh.intersect(&ray, f32::INFINITY).unwrap().prim, 7);
    assert_eq!(build(&positions, &indices[..7]).triangle_count(), 0);
}

#[test]
fn rays_that_are_none_hit_nothing() {
    let bvh = one_triangle();
    let o = Vec3::new(0.25, 0.25, -2.0);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            let (mut p, mut d) = (o, Vec3::Z);
            p[axis] = bad;
            d[axis] = bad;
            for ray in [Ray::new(p, Vec3::Z), Ray::new(o, d), Ray::new(p, d)] {
                assert!(bvh.intersect(&ray, f32::INFINITY).is_none(), "{ray:?}");
                assert!(!bvh.occluded(&ray, f32::INFINITY), "{ray:?}");
            }
        }
    }
    for d in [Vec3::ZERO, -Vec3::ZERO] {
        assert!(bvh.intersect(&Ray::new(o, d), f32::INFINITY).is_none());
    }
}

#[test]
fn axis_aligned_rays_on_box_faces_hit() {
    // A unit square in each axis plane through the origin; rays run within its border lines.
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let at = |a: f32, b: f32| {
            let mut p = Vec3::ZERO;
            (p[u], p[v]) = (a, b);
            p
        };
        let positions = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
        let bvh = build(&positions, &[[0, 1, 2], [0, 2, 3]]);
        for (a, b) in [(0.0, 0.0), (1.0, 1.0), (0.0, 0.5), (1.0, 0.25), (0.5, 0.0), (0.5, 0.5)] {
            for (sign, zero) in [(1.0, 0.0), (1.0, -0.0), (-1.0, 0.0), (-1.0, -0.0)] {
                let mut d = Vec3::splat(zero);
                d[axis] = sign;
                let mut o = at(a, b);
                o[axis] = -3.0 * sign;
                let hit = bvh.intersect(&Ray::new(o, d), f32::INFINITY);
                assert_eq!(hit.map(|h| h.t), Some(3.0), "axis {axis} at {a} {b} {d:?}");
            }
        }
        // And just outside they do not.
        let mut o = at(1f32.next_up(), 0.5);
        o[axis] = -3.0;
        let mut d = Vec3::ZERO;
        d[axis] = 1.0;
        assert!(bvh.intersect(&Ray::new(o, d), f32::INFINITY).is_none());
    }
}

#[test]
fn trees_of_boxes_take_odd_input() {
    let ray = Ray::new(Vec3::splat(-2.0), Vec3::splat(1.0));
    let empty = BoxBvh::build(&[]);
    assert!(empty.intersect(&ray, 9.0, |_, _| Some((1.0, ()))).is_none());
    assert!(!empty.any(&ray, 9.0, |_, _| true));
    let nan = Bounds3 { min: Vec3::splat(f32::NAN), max: Vec3::splat(1.0) };
    let bvh = BoxBvh::build(&[Bounds3::EMPTY, nan, Bounds3::new(Vec3::ZERO, Vec3::splat(1.0))]);
    assert_eq!(bvh.primitive_count(), 1);
    let hit = bvh.intersect(&ray, 9.0, |prim, _| Some((2.0, prim + 10)));
    assert_eq!(hit, Some((2.0, 2, 12)));
    assert!(bvh.any(&ray, 9.0, |_, _| true) && !bvh.any(&ray, 1.0, |_, _| true));
}
