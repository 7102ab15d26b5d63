//! Drawing the numbers of a path from each sampler.
//!
//! `cargo bench -p kaustika-sampling`. The rate is numbers a second, each in [0, 1).

use divan::Bencher;
use divan::counter::ItemsCount;
use kaustika_sampling::{SamplerConfig, SamplerKind, SamplerPlan};

fn main() {
    divan::main();
}

/// Pixels a run visits.
const PIXELS: u32 = 64;
/// Vertices of a path.
const VERTICES: u32 = 6;
/// Numbers of a path: position in the pixel, then five a vertex.
const NUMBERS: u32 = 2 + VERTICES * 5;

#[divan::bench(args = SamplerKind::ALL, min_time = 0.2, max_time = 1)]
fn path(bencher: Bencher, kind: SamplerKind) {
    let plan = SamplerPlan::new(SamplerConfig { kind, seed: 1, spp: 64, resolution: [512, 512] });
    let mut pass = 0;
    bencher.counter(ItemsCount::new(PIXELS * NUMBERS)).bench_local(|| {
        pass = (pass + 1) % 64;
        let mut sum = 0.0;
        for x in 0..PIXELS {
            let mut sampler = plan.start([x, 17], pass);
            let p = sampler.get_2d();
            sum += p.x + p.y;
            for _ in 0..VERTICES {
                // A light, a point of it, a direction: as `path` draws them.
                sum += sampler.get_1d();
                let (a, b) = (sampler.get_2d(), sampler.get_2d());
                sum += a.x + a.y + b.x + b.y;
            }
        }
        sum
    });
}

/// What a render does once.
#[divan::bench(args = SamplerKind::ALL, min_time = 0.2, max_time = 1, sample_count = 20)]
fn plan(kind: SamplerKind) -> SamplerPlan {
    SamplerPlan::new(SamplerConfig { kind, seed: 1, spp: 256, resolution: [512, 512] })
}
