//! Metropolis sampling in one dimension: histograms of chains for f(x) = (x - ½)², written as
//! `metropolis_histograms.png`.
//!
//! Columns: proposals anywhere, small steps of up to 0.05, a tenth of the one and the rest of the
//! other. Rows: after 10³, 10⁴ and 10⁵ steps from x = 0.9. The line is f over its integral.
//!
//! ```sh
//! cargo run --release --example 02_metropolis_histograms [file]
//! ```

use kaustika::film::{self, Picture};
use kaustika::transport::metropolis::{Chain, Draws, Recording, acceptance};
use std::error::Error;

/// Pixels of a histogram, and of a bin of it.
const SIZE: [usize; 2] = [200, 120];
const BIN: usize = 4;
/// The density at the top of a histogram; f's is 3 at most.
const TOP: f64 = 4.0;

fn f(x: f64) -> f64 {
    if (0.0..=1.0).contains(&x) { (x - 0.5).powi(2) } else { 0.0 }
}

/// The density of a chain's states, bin by bin.
fn histogram(anywhere: f64, steps: u32) -> Vec<f64> {
    let bins = SIZE[0] / BIN;
    let mut density = vec![0.0; bins];
    let mut record = |x: &f64, w: f64| density[((x * bins as f64) as usize).min(bins - 1)] += w;
    let mut r = Draws::new(1, u64::from(steps));
    let mut chain = Chain::new(0.9, Recording::Visited);
    for _ in 0..steps {
        let mut y = match r.f64() < anywhere {
            true => r.f64(),
            false => chain.state() + 0.1 * (r.f64() - 0.5),
        };
        let a = acceptance(f(*chain.state()), f(y)).unwrap_or(0.0);
        chain.step(&mut y, a, r.f64(), &mut record);
    }
    chain.record(&mut record);
    density.iter().map(|w| w * bins as f64 / f64::from(steps)).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args().nth(1).unwrap_or("metropolis_histograms.png".into());
    let [w, h] = SIZE;
    let gap = 8;
    let (width, height) = (3 * w + 4 * gap, 3 * h + 4 * gap);
    let mut pixels = vec![[0.6f32; 3]; width * height];
    for (row, steps) in [1000, 10_000, 100_000].into_iter().enumerate() {
        for (column, anywhere) in [1.0, 0.0, 0.1].into_iter().enumerate() {
            let density = histogram(anywhere, steps);
            for y in 0..h {
                for x in 0..w {
                    let level = TOP * (h - y) as f64 / h as f64;
                    let curve = 12.0 * f((x as f64 + 0.5) / w as f64);
                    let color = match () {
                        () if (level - curve).abs() < 0.6 * TOP / h as f64 => [0.6, 0.02, 0.02],
                        () if density[x / BIN] >= level => [0.05, 0.15, 0.4],
                        () => [0.9; 3],
                    };
                    let at = (gap + row * (h + gap) + y) * width + gap + column * (w + gap) + x;
                    pixels[at] = color;
                }
            }
        }
    }
    let picture = Picture::from_rgb(width as u32, height as u32, &pixels);
    film::write_picture(&file, &picture, &Default::default())?;
    eprintln!("-> {file}");
    Ok(())
}
