//! Directions as quadtrees and as mixtures, on one thread: nanoseconds for `at`, `towards`,
//! `pdf`, `sample`, `irradiance` and to learn a record.
//!
//! `cargo run --release --bin guiding` prints a table, the median of rounds in which all take
//! turns. What is learned are 1 to 60 lights of different widths under a dim sky, so that there
//! are quadtrees and mixtures of different sizes.

use kaustika_math::{Vec2, Vec3, warp};
use kaustika_sampling::hash::{combine, unit};
use kaustika_transport::guiding::{Directions, LightRecord, LocalDirections, Mixture, Quadtree};
use std::hint::black_box;
use std::time::Instant;

const QUERIES: usize = 20_000;
const ROUNDS: usize = 9;
const ITERATIONS: usize = 6;
const RECORDS: usize = 20_000;

fn number(i: usize, k: u64) -> f32 {
    unit((combine(i as u64, k) >> 32) as u32)
}

fn direction(i: usize, k: u64) -> Vec3 {
    warp::uniform_sphere(Vec2::new(number(i, k), number(i, k + 1)))
}

/// Radiance from `w`: `lights` of them.
fn radiance(w: Vec3, lights: usize) -> f32 {
    let light = |i| {
        let kappa = 100.0 * 10f32.powf(number(i, 9));
        kappa * (-0.5 * kappa * (w - direction(i, 1)).length_squared()).exp()
    };
    0.05 + (0..lights).map(light).sum::<f32>()
}

fn records(iteration: usize, lights: usize) -> Vec<LightRecord> {
    let pdf = 0.25 / std::f32::consts::PI;
    let record = |i| {
        let (p, w) = (direction(i, 5) * 0.1, direction(i, 7));
        let radiance = radiance(w, lights);
        LightRecord { p, w, pdf, radiance, distance: 3.0, pdf_bsdf: pdf, product: radiance }
    };
    (iteration * RECORDS..(iteration + 1) * RECORDS).map(record).collect()
}

/// Learned, and nanoseconds a record.
fn learned<D: Directions>(lights: usize) -> (D, f64) {
    let mut d = D::default();
    let mut seconds = 0.0;
    for iteration in 0..ITERATIONS {
        let records = records(iteration, lights);
        let since = Instant::now();
        d.learn(&records);
        d.refine();
        seconds += since.elapsed().as_secs_f64();
    }
    (d, seconds * 1e9 / (ITERATIONS * RECORDS) as f64)
}

/// Nanoseconds of one `f`.
fn time(mut f: impl FnMut(usize) -> f32) -> f64 {
    let since = Instant::now();
    black_box((0..QUERIES).map(&mut f).sum::<f32>());
    since.elapsed().as_secs_f64() * 1e9 / QUERIES as f64
}

/// One round: `at`, `towards` after `at`, `pdf`, `sample`, `irradiance`.
fn round<D: Directions>(d: &D) -> [f64; 5] {
    let places: Vec<Vec3> = (0..QUERIES).map(|i| direction(i, 5) * 0.1).collect();
    let ws: Vec<Vec3> = (0..QUERIES).map(|i| direction(i, 11)).collect();
    let us: Vec<Vec2> = (0..QUERIES).map(|i| Vec2::new(number(i, 13), number(i, 14))).collect();
    let at = |i: usize| d.at(places[i]).expect("learned");
    let local = at(0);
    let at_ns = time(|i| black_box(at(i)).pdf(ws[0]));
    let towards = time(|i| black_box(at(i).towards(ws[i])).pdf(ws[0]));
    let pdf = time(|i| local.pdf(ws[i]));
    let sample = time(|i| local.sample(us[i]).1);
    let irradiance = time(|i| local.irradiance(ws[i]));
    [at_ns - pdf, towards - at_ns, pdf, sample, irradiance]
}

fn row<D: Directions>(name: &str, lights: usize, size: impl Fn(&D) -> usize) {
    let (d, learn) = learned::<D>(lights);
    let rounds: Vec<[f64; 5]> = (0..ROUNDS).map(|_| round(&d)).collect();
    let median = |k: usize| {
        let mut times: Vec<f64> = rounds.iter().map(|r| r[k]).collect();
        times.sort_by(f64::total_cmp);
        times[ROUNDS / 2]
    };
    let cells: Vec<String> = (0..5).map(|k| format!("{:.0}", median(k).max(0.0))).collect();
    println!("| {lights} | {name} | {} | {} | {learn:.0} |", size(&d), cells.join(" | "));
}

fn main() {
    println!(
        "| lights | directions | lobes, nodes | at | towards | pdf | sample | irradiance | learn |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for lights in [1, 8, 20, 60] {
        row::<Quadtree>("quadtree", lights, Quadtree::size);
        row::<Mixture>("mixture", lights, Mixture::size);
    }
}
