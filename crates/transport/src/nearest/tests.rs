//! Every structure against brute force.

use super::*;
use kaustika_sampling::hash::combine;

/// A number in [-1, 1).
fn number(i: usize, k: u64) -> f32 {
    (combine(i as u64, k) >> 40) as f32 / (1u64 << 23) as f32 - 1.0
}

/// Rounded to multiples of 1/n.
fn rounded(p: Vec3, n: f32) -> Vec3 {
    Vec3::new((p.x * n).round(), (p.y * n).round(), (p.z * n).round()) / n
}

fn anywhere(i: usize, k: u64) -> Vec3 {
    Vec3::new(number(i, k), number(i, k + 1), number(i, k + 2))
}

/// Sets that a tree may stumble over, each of `n` points.
fn sets(n: usize) -> Vec<(&'static str, Vec<Vec3>)> {
    let make = |f: &dyn Fn(usize) -> Vec3| (0..n).map(f).collect::<Vec<_>>();
    vec![
        ("uniform", make(&|i| anywhere(i, 1))),
        ("on a sphere", make(&|i| anywhere(i, 1).normalize())),
        ("on a plane", make(&|i| Vec3::new(number(i, 1), 0.5, number(i, 2)))),
        ("on a line", make(&|i| Vec3::new(0.25, number(i, 1), 0.25))),
        ("one place", make(&|_| Vec3::new(0.1, 0.2, 0.3))),
        ("a lattice", make(&|i| rounded(anywhere(i, 1), 3.0))),
        ("clusters", make(&|i| anywhere(i % 5, 9) + anywhere(i, 1) * 1e-3)),
    ]
}

fn queries(points: &[Vec3]) -> impl Iterator<Item = Vec3> + '_ {
    let near = (0..20).filter_map(|i| Some(*points.get(i * 7)? + anywhere(i, 40) * 0.01));
    let on = points.iter().copied().take(10);
    let far = [Vec3::new(50.0, -3.0, 0.0), Vec3::new(1e9, 0.0, 0.0)];
    (0..20).map(|i| anywhere(i, 50)).chain(near).chain(on).chain(far)
}

fn brute(points: &[Vec3], q: Vec3) -> Vec<f32> {
    let mut d2: Vec<f32> = points.iter().map(|&p| (p - q).length_squared()).collect();
    d2.sort_by(f32::total_cmp);
    d2
}

/// Sums of three squares may be fused: equal up to a few roundings.
fn assert_same(what: &str, found: &[f32], truth: &[f32]) {
    assert_eq!(found.len(), truth.len(), "{what}: number");
    for (a, b) in found.iter().zip(truth) {
        assert!((a - b).abs() <= 4e-7 * b, "{what}: {a} instead of {b}");
    }
}

#[test]
fn the_nearest_are_those_of_brute_force() {
    let mut found = Nearest::default();
    for n in [0, 1, 2, 15, 16, 17, 33, 1000] {
        for (name, points) in sets(n) {
            for layout in Layout::ALL {
                let (tree, order) = Points::new(layout, &points);
                for (j, q) in queries(&points).enumerate() {
                    for (k, limit) in [(1, f32::INFINITY), (7, 0.3), (50, f32::INFINITY), (5, 0.0)]
                    {
                        let what = format!("{layout:?} of {n} points {name}, query {j}, k = {k}");
                        found.begin(k, limit);
                        tree.nearest(q, &mut found);
                        found.sort();
                        let places: std::collections::BTreeSet<u32> =
                            found.iter().map(|(i, _)| i).collect();
                        assert_eq!(places.len(), found.len(), "{what}: none twice");
                        for (i, d2) in found.iter() {
                            let p = points[order[i as usize] as usize];
                            assert_same(&what, &[d2], &[(p - q).length_squared()]);
                        }
                        let d2: Vec<f32> = found.iter().map(|(_, d2)| d2).collect();
                        let truth: Vec<f32> =
                            brute(&points, q).into_iter().filter(|&d| d < limit).take(k).collect();
                        assert_same(&what, &d2, &truth);
                    }
                }
            }
        }
    }
}

#[test]
fn all_within_a_radius_are_those_of_brute_force() {
    for n in [0, 1, 40, 1000] {
        for (name, points) in sets(n) {
            for layout in Layout::ALL {
                let (tree, _) = Points::new(layout, &points);
                for (j, q) in queries(&points).enumerate() {
                    for r2 in [0.0, 0.013, 0.37, 1e6, f32::INFINITY] {
                        if layout == Layout::Grid && r2 > 1e6 {
                            continue;
                        }
                        let what = format!("{layout:?} of {n} points {name}, query {j}, r² = {r2}");
                        let mut d2 = Vec::new();
                        tree.within(q, r2, |_, d| d2.push(d));
                        d2.sort_by(f32::total_cmp);
                        let truth: Vec<f32> =
                            brute(&points, q).into_iter().filter(|&d| d < r2).collect();
                        assert_same(&what, &d2, &truth);
                    }
                }
            }
        }
    }
}

#[test]
fn heaps_are_left_balanced_for_every_number_of_points() {
    for n in 1..1000 {
        let points: Vec<Vec3> = (0..n).map(|i| anywhere(i, 1)).collect();
        let (Points::Heap(tree), order) = Points::new(Layout::Heap, &points) else { panic!() };
        let mut seen = order.clone();
        seen.sort_unstable();
        assert!(seen.iter().copied().eq(0..n as u32), "{n}: every place is taken, none twice");
        if n % 37 == 0 {
            tree.check();
        }
    }
}

#[test]
fn any_number_of_threads_builds_the_same_order() {
    let points: Vec<Vec3> = (0..100_000).map(|i| rounded(anywhere(i, 1), 64.0)).collect();
    let build = |threads: usize, layout| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| Points::new(layout, &points).1)
    };
    for layout in Layout::ALL {
        assert_eq!(build(1, layout), build(3, layout), "{layout:?}");
    }
}
