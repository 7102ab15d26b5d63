//! The tree over triangles: building it, and asking it along coherent and incoherent rays.
//!
//! `cargo bench -p kaustika-accel`. The rate is rays (or triangles) a second, on one thread.

use divan::Bencher;
use divan::counter::ItemsCount;
use kaustika_accel::{BuildOptions, Segment, TriangleBvh};
use kaustika_math::{Ray, Vec3, mix_bits};
use std::f32::consts::{PI, TAU};
use std::sync::LazyLock;

fn main() {
    divan::main();
}

/// Rays along a side of the picture; a run traces its square.
const SIDE: usize = 64;
const RAYS: usize = SIDE * SIDE;

struct Mesh {
    positions: Vec<Vec3>,
    indices: Vec<[u32; 3]>,
}

/// Some 100,000 triangles: hills in [0, 10]² and balls of many sizes above them; y is up.
static MESH: LazyLock<Mesh> = LazyLock::new(|| {
    let mut mesh = Mesh { positions: Vec::new(), indices: Vec::new() };
    mesh.grid(160, 160, |u, v| {
        let height = (7.0 * u).sin() * (9.0 * v).cos() + 0.3 * (31.0 * u + 17.0 * v).sin();
        Vec3::new(10.0 * u, 1.0 + 0.5 * height, 10.0 * v)
    });
    for ball in 0..40 {
        let place = Vec3::new(number(4 * ball), number(4 * ball + 1), number(4 * ball + 2));
        let centre = Vec3::new(0.5, 2.0, 0.5) + place * 9.0;
        let radius = 0.2 + number(4 * ball + 3);
        mesh.grid(32, 20, |u, v| centre + on_sphere(u, v) * radius);
    }
    mesh
});

static TREE: LazyLock<TriangleBvh> =
    LazyLock::new(|| TriangleBvh::build(&MESH.positions, &MESH.indices, &BuildOptions::default()));

/// A pinhole's rays, line by line.
static COHERENT: LazyLock<Vec<Ray>> = LazyLock::new(|| {
    let along = |i: usize| (i as f32 + 0.5) / SIDE as f32 - 0.5;
    (0..RAYS)
        .map(|i| {
            let d = Vec3::new(along(i % SIDE), -0.2 - along(i / SIDE), 0.8);
            Ray::new(Vec3::new(5.0, 6.0, -1.0), d.normalize())
        })
        .collect()
});

/// Rays from where a pinhole's rays meet the mesh, in all directions.
static INCOHERENT: LazyLock<Vec<Ray>> = LazyLock::new(|| {
    let bounce = |(i, ray): (usize, &Ray)| {
        let t = TREE.intersect(ray, f32::INFINITY).map_or(1.0, |hit| 0.999 * hit.t);
        let d = on_sphere(number(2 * i as u64 + 1000), number(2 * i as u64 + 1001).acos() / PI);
        Ray::new(ray.at(t), d)
    };
    COHERENT.iter().enumerate().map(bounce).collect()
});

impl Mesh {
    /// Adds `nu` by `nv` cells of two triangles over (u, v) in [0, 1]².
    fn grid(&mut self, nu: u32, nv: u32, surface: impl Fn(f32, f32) -> Vec3) {
        let first = self.positions.len() as u32;
        for j in 0..=nv {
            for i in 0..=nu {
                self.positions.push(surface(i as f32 / nu as f32, j as f32 / nv as f32));
            }
        }
        for cell in 0..nu * nv {
            let a = first + cell / nu * (nu + 1) + cell % nu;
            let [b, c, d] = [a + 1, a + nu + 2, a + nu + 1];
            self.indices.extend([[a, b, c], [a, c, d]]);
        }
    }
}

/// The direction of azimuth 2πu and polar angle πv.
fn on_sphere(u: f32, v: f32) -> Vec3 {
    let ((s, c), (r, y)) = ((TAU * u).sin_cos(), (PI * v).sin_cos());
    Vec3::new(r * c, y, r * s)
}

/// The `i`th of a fixed list of numbers uniform in [0, 1).
fn number(i: u64) -> f32 {
    (mix_bits(i + 1) >> 40) as f32 / (1u64 << 24) as f32
}

fn closest(bencher: Bencher, rays: &[Ray]) {
    let tree = &*TREE;
    bencher.counter(ItemsCount::new(RAYS)).bench_local(|| {
        rays.iter()
            .filter_map(|ray| tree.intersect(ray, f32::INFINITY))
            .map(|hit| hit.t)
            .sum::<f32>()
    });
}

fn any(bencher: Bencher, rays: &[Ray]) {
    let tree = &*TREE;
    bencher
        .counter(ItemsCount::new(RAYS))
        .bench_local(|| rays.iter().filter(|ray| tree.occluded(ray, 3.0)).count());
}

fn segments(rays: &[Ray], t_max: f32) -> Vec<Segment> {
    rays.iter().map(|&ray| Segment { ray, t_max }).collect()
}

fn closest_batch(bencher: Bencher, rays: &[Ray]) {
    let (tree, segments) = (&*TREE, segments(rays, f32::INFINITY));
    let mut hits = vec![None; RAYS];
    bencher.counter(ItemsCount::new(RAYS)).bench_local(|| {
        tree.intersect_all(&segments, &mut hits);
        hits.iter().flatten().map(|hit| hit.t).sum::<f32>()
    });
}

fn any_batch(bencher: Bencher, rays: &[Ray]) {
    let (tree, segments) = (&*TREE, segments(rays, 3.0));
    let mut occluded = vec![false; RAYS];
    bencher.counter(ItemsCount::new(RAYS)).bench_local(|| {
        tree.occluded_all(&segments, &mut occluded);
        occluded.iter().filter(|&&o| o).count()
    });
}

#[divan::bench(min_time = 0.2, max_time = 1)]
fn closest_coherent(bencher: Bencher) {
    closest(bencher, &COHERENT);
}

#[divan::bench(min_time = 0.2, max_time = 1)]
fn closest_coherent_batch(bencher: Bencher) {
    closest_batch(bencher, &COHERENT);
}

#[divan::bench(min_time = 0.2, max_time = 1)]
fn closest_incoherent(bencher: Bencher) {
    closest(bencher, &INCOHERENT);
}

#[divan::bench(min_time = 0.2, max_time = 1)]
fn closest_incoherent_batch(bencher: Bencher) {
    closest_batch(bencher, &INCOHERENT);
}

#[divan::bench(min_time = 0.2, max_time = 1)]
fn any_coherent(bencher: Bencher) {
    any(bencher, &COHERENT);
}

#[divan::bench(min_time = 0.2, max_time = 1)]
fn any_coherent_batch(bencher: Bencher) {
    any_batch(bencher, &COHERENT);
}

#[divan::bench(min_time = 0.2, max_time = 1)]
fn any_incoherent(bencher: Bencher) {
    any(bencher, &INCOHERENT);
}

#[divan::bench(min_time = 0.2, max_time = 1)]
fn any_incoherent_batch(bencher: Bencher) {
    any_batch(bencher, &INCOHERENT);
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn build(bencher: Bencher) {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread starts");
    bencher.counter(ItemsCount::new(MESH.indices.len())).bench_local(|| {
        one.install(|| TriangleBvh::build(&MESH.positions, &MESH.indices, &BuildOptions::default()))
    });
}
