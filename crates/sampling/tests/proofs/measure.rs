//! Prints the table of the samplers' cost and error; figures, not assertions:
//! `cargo test --release -p kaustika-sampling --test proofs -- --ignored measure --nocapture`.

use crate::support::plan;
use kaustika_math::Vec2;
use kaustika_sampling::{Sampler, SamplerKind};
use std::hint::black_box;
use std::time::Instant;

/// Nanoseconds of one path of `draws` draws, the best of several runs.
fn path_time(kind: SamplerKind, draws: usize, body: fn(&mut Sampler) -> f32) -> f64 {
    let plan = plan(kind, 1, 256);
    let paths = 50_000u32;
    (0..9)
        .map(|_| {
            let clock = Instant::now();
            let mut sum = 0.0;
            for p in 0..paths {
                let mut s = plan.start([p & 63, p >> 6 & 63], u64::from(p >> 12));
                for _ in 0..draws {
                    sum += body(&mut s);
                }
            }
            black_box(sum);
            clock.elapsed().as_secs_f64() / f64::from(paths) * 1e9
        })
        .fold(f64::INFINITY, f64::min)
}

/// RMSE over 64 seeds.
fn rmse(kind: SamplerKind, n: u64, truth: f64, f: impl Fn(&mut Sampler) -> f64) -> f64 {
    let sum: f64 = (0..64)
        .map(|seed| {
            let plan = plan(kind, seed, n);
            let mean = (0..n).map(|i| f(&mut plan.start([7, 9], i))).sum::<f64>() / n as f64;
            (mean - truth).powi(2)
        })
        .sum();
    (sum / 64.0).sqrt()
}

fn smooth(u: Vec2) -> f64 {
    f64::from(u.x).exp() * (1.0 + f64::from(u.y)).powi(2)
}

fn disc(u: Vec2) -> f64 {
    if u.x * u.x + u.y * u.y < 0.64 { 1.0 } else { 0.0 }
}

#[test]
#[ignore = "a measurement"]
fn cost_and_error() {
    let smooth_truth = (std::f64::consts::E - 1.0) * 7.0 / 3.0;
    let disc_truth = 0.64 * std::f64::consts::FRAC_PI_4;
    println!("ns: start, 1D, 2D; RMSE at 16, 100, 256, 1024 samples");
    for kind in SamplerKind::ALL {
        let one = |s: &mut Sampler| s.get_1d();
        let two = |s: &mut Sampler| {
            let u = s.get_2d();
            u.x + u.y
        };
        let t1 = (path_time(kind, 33, one) - path_time(kind, 1, one)) / 32.0;
        let t2 = (path_time(kind, 33, two) - path_time(kind, 1, two)) / 32.0;
        let start = path_time(kind, 1, one) - t1;
        print!("{:12} {start:5.1} {t1:5.1} {t2:5.1} ", kind.name());
        let counts = [16, 100, 256, 1024];
        print!("| smooth");
        counts.iter().for_each(|&n| {
            print!(" {:7.1e}", rmse(kind, n, smooth_truth, |s| smooth(s.get_2d())));
        });
        print!(" | disc");
        counts.iter().for_each(|&n| {
            print!(" {:7.1e}", rmse(kind, n, disc_truth, |s| disc(s.get_2d())));
        });
        print!(" | second 2D draw, smooth");
        counts.iter().for_each(|&n| {
            let f = |s: &mut Sampler| {
                s.get_2d();
                smooth(s.get_2d())
            };
            print!(" {:7.1e}", rmse(kind, n, smooth_truth, f));
        });
        print!(" | 4D edge");
        counts.iter().for_each(|&n| {
            // P(x + y² < z) = 4/15 over two draws.
            let f = |s: &mut Sampler| {
                let (a, b) = (s.get_2d(), s.get_2d());
                if a.x + a.y * a.y < b.x { f64::from(1.0 + b.y) } else { 0.0 }
            };
            print!(" {:7.1e}", rmse(kind, n, 0.4, f));
        });
        println!();
    }
}
