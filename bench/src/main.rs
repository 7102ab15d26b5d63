//! The k nearest photons: our structures beside the crates `kiddo` and `nabo`, on one thread.
//!
//! `cargo run --release -- [POINTS...]` prints a table: microseconds a query, the median of five
//! rounds in which all take turns, on the same points and queries; seconds to build; bytes a point.

use kaustika_math::Vec3;
use kaustika_sampling::hash::{combine, unit};
use kaustika_transport::nearest::{Layout, Nearest, Points};
use kiddo::SquaredEuclidean;
use kiddo::immutable::float::kdtree::ImmutableKdTree;
use nabo::simple_point::SimplePoint;
use nabo::{CandidateContainer, KDTree, Parameters};
use std::num::NonZero;
use std::time::Instant;

const QUERIES: usize = 5000;
const ROUNDS: usize = 5;

fn number(i: usize, k: u64) -> f32 {
    2.0 * unit((combine(i as u64, k) >> 32) as u32) - 1.0
}

fn in_a_cube(i: usize, k: u64) -> Vec3 {
    Vec3::new(number(i, k), number(i, k + 1), number(i, k + 2))
}

/// On the walls of a box and a ball in it; every third in a caustic on the floor.
fn on_surfaces(i: usize, k: u64) -> Vec3 {
    let p = in_a_cube(i, k);
    match combine(i as u64, k + 3) % 9 {
        0 => Vec3::new(p.x, p.y, -1.0),
        1 => Vec3::new(p.x, p.y, 1.0),
        2 => Vec3::new(p.x, -1.0, p.z),
        3 => Vec3::new(-1.0, p.y, p.z),
        4 => Vec3::new(1.0, p.y, p.z),
        5 => p.normalize() * 0.3,
        _ => Vec3::new(0.2 + 0.1 * p.x * p.x * p.x, 0.1 + 0.1 * p.y * p.z, -1.0),
    }
}

/// Something that finds the k nearest to a query and says how far the farthest is, d².
type Search<'a> = Box<dyn FnMut(Vec3, usize) -> f32 + 'a>;

fn main() {
    let counts: Vec<usize> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let counts = if counts.is_empty() { vec![100_000, 1_000_000, 10_000_000] } else { counts };
    println!("| points | set | structure | k = 50, µs | k = 100, µs | build, s | bytes |");
    println!("|---|---|---|---|---|---|---|");
    for &n in &counts {
        compare(n, "in a cube", in_a_cube);
        compare(n, "on surfaces", on_surfaces);
    }
}

fn compare(n: usize, set: &str, f: impl Fn(usize, u64) -> Vec3) {
    let points: Vec<Vec3> = (0..n).map(|i| f(i, 1)).collect();
    let queries: Vec<Vec3> = (0..QUERIES).map(|i| f(i, 77)).collect();
    let arrays: Vec<[f32; 3]> = points.iter().map(|p| [p.x, p.y, p.z]).collect();
    let cloud: Vec<SimplePoint<3>> =
        points.iter().map(|p| SimplePoint::new3d(p.x, p.y, p.z)).collect();

    let mut builds = Vec::new();
    let mut timed = |name: &str, bytes: Option<usize>, since: Instant| {
        builds.push((name.to_string(), since.elapsed().as_secs_f64(), bytes));
    };
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let ours: Vec<Points> = Layout::ALL
        .into_iter()
        .map(|layout| {
            let since = Instant::now();
            let (tree, _) = one.install(|| Points::new(layout, &points));
            timed(&format!("{layout:?}"), Some(tree.memory_bytes() / n), since);
            tree
        })
        .collect();
    let since = Instant::now();
    let kiddo: ImmutableKdTree<f32, u32, 3, 32> = ImmutableKdTree::new_from_slice(&arrays);
    timed("kiddo", None, since);
    let since = Instant::now();
    let nabo = KDTree::new(&cloud);
    timed("nabo", None, since);

    let mut searches: Vec<Search> = Vec::new();
    for tree in &ours {
        let mut found = Nearest::default();
        searches.push(Box::new(move |q, k| {
            found.begin(k, f32::INFINITY);
            tree.nearest(q, &mut found);
            found.farthest()
        }));
    }
    searches.push(Box::new(|q, k| {
        let k = NonZero::new(k).expect("not 0");
        let found =
            kiddo.nearest_n_within::<SquaredEuclidean>(&[q.x, q.y, q.z], f32::INFINITY, k, false);
        found.iter().map(|n| n.distance).fold(0.0, f32::max)
    }));
    searches.push(Box::new(|q, k| {
        let p = Parameters {
            epsilon: 0.0,
            max_radius: f32::INFINITY,
            allow_self_match: true,
            sort_results: false,
        };
        let q = SimplePoint::new3d(q.x, q.y, q.z);
        let found = nabo.knn_advanced(k as u32, &q, CandidateContainer::BinaryHeap, &p, None);
        found.iter().map(|n| n.dist2.into_inner()).fold(0.0, f32::max)
    }));

    let mut micros = vec![[0.0; 2]; searches.len()];
    for (j, k) in [50, 100].into_iter().enumerate() {
        let mut rounds = vec![Vec::new(); searches.len()];
        let mut sums = vec![0.0; searches.len()];
        for _ in 0..ROUNDS {
            for (s, search) in searches.iter_mut().enumerate() {
                let since = Instant::now();
                sums[s] = queries.iter().map(|&q| f64::from(search(q, k))).sum();
                rounds[s].push(since.elapsed().as_secs_f64() * 1e6 / QUERIES as f64);
            }
        }
        for (s, times) in rounds.iter_mut().enumerate() {
            times.sort_by(f64::total_cmp);
            micros[s][j] = times[ROUNDS / 2];
            let difference: f64 = sums[s] - sums[0];
            assert!(difference.abs() < 1e-5 * sums[0], "{}: another answer", builds[s].0);
        }
    }
    for ((name, build, bytes), [a, b]) in builds.iter().zip(micros) {
        let bytes = bytes.map_or("".into(), |b| b.to_string());
        println!("| {n} | {set} | {name} | {a:.2} | {b:.2} | {build:.2} | {bytes} |");
    }
}
