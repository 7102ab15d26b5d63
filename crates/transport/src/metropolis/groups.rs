//! What groups of chains tell of the picture's error: each is an independent render, with candidates and
//! a brightness of its own.
//!
//! ```text
//! σ² = Σ_g (X_g - X̄)² / (G (G - 1)) + M₂ / (n (n - 1))                                  (1)
//! ```
//!
//! X_g is group g's own estimate of a pixel or of a tile, of G; M₂ the sum of squared deviations over n passes of
//! what is rendered separately, whose samples are independent.

use super::convergence::Series;
use super::film::modulus;
use super::tiles::Tiles;
use crate::frame::Frame;
use crate::path_space::{Splat, each_covered};
use crate::saved::saved;
use kaustika_film::accumulate::PassImage;

/// Fewest groups that tell an error.
const FEWEST: usize = 8;

/// What groups have left on the film.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Groups {
    size: [u32; 2],
    groups: u64,
    passes: u64,
    /// Σ over passes, group by group, of r, g, b of each pixel.
    sums: Vec<f32>,
    /// Mean and M₂ of each number of what is rendered separately.
    separate: Vec<[f32; 2]>,
    /// Light in the tiles in this pass, group by group.
    now: Vec<f64>,
    /// The same over all passes.
    series: Series,
}
saved!(Groups { size, groups, passes, sums, separate, now, series });

/// The errors of pixels and tiles, and how well groups agree.
#[derive(Clone, Debug)]
pub struct Errors {
    /// Standard error of each pixel's mean.
    pub pixels: Vec<[f32; 3]>,
    /// That of the mean of the tile that it lies in.
    pub tiles: Vec<[f64; 3]>,
    /// R̂ of each tile; 1 of too few passes.
    pub r_hat: Vec<f64>,
    /// The chains' light in each tile.
    pub light: Vec<f64>,
}

impl Groups {
    /// Nothing yet.
    pub fn new(frame: &Frame, groups: usize) -> Groups {
        let size = frame.size();
        let pixels = size[0] as usize * size[1] as usize;
        let tiles = Tiles::new(size).count();
        Groups {
            size,
            groups: groups as u64,
            passes: 0,
            sums: vec![0.0; groups * pixels * 3],
            separate: vec![[0.0; 2]; pixels * 3],
            now: vec![0.0; groups * tiles],
            series: Series::new(groups * tiles),
        }
    }

    fn tiles(&self) -> Tiles {
        Tiles::new(self.size)
    }

    fn pixels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// A pass begins, of which the image shows what is rendered separately.
    pub fn begin(&mut self, image: &PassImage) {
        self.passes += 1;
        let n = self.passes as f32;
        let seen = image.data().chunks(image.layers().stride());
        for (mean_m2, pixel) in self.separate.chunks_mut(3).zip(seen) {
            for ([mean, m2], x) in mean_m2.iter_mut().zip(pixel) {
                // Welford 1962.
                let d = x - *mean;
                *mean += d / n;
                *m2 += d * (x - *mean);
            }
        }
        self.now.fill(0.0);
    }

    /// A splat of a group's.
    pub fn add(&mut self, frame: &Frame, group: usize, s: &Splat) {
        if s.layer.is_some() {
            return;
        }
        let (pixels, tiles) = (self.pixels(), self.tiles());
        each_covered(frame, s.film, |x, y, k| {
            let pixel = y as usize * self.size[0] as usize + x as usize;
            let at = 3 * (group * pixels + pixel);
            let rgb = s.rgb.map(|v| k * v);
            self.sums[at..at + 3].iter_mut().zip(rgb).for_each(|(sum, v)| *sum += v);
            self.now[group * tiles.count() + tiles.of(x, y)] += modulus(rgb);
        });
    }

    /// The pass is over.
    pub fn end(&mut self) {
        self.series.push(&self.now);
    }

    /// (1); `None` of too few groups.
    pub fn errors(&self) -> Option<Errors> {
        let groups = self.groups as usize;
        if groups < FEWEST || self.passes == 0 {
            return None;
        }
        let (g, n) = (groups as f64, self.passes as f64);
        let pixels = self.pixels();
        // What a group leaves is its part of the mean over all.
        let spread = |of: &dyn Fn(usize) -> f64| {
            let all: Vec<f64> = (0..groups).map(|k| g / n * of(k)).collect();
            let mean = all.iter().sum::<f64>() / g;
            all.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (g * (g - 1.0))
        };
        let separate = |at: usize| f64::from(self.separate[at][1]) / (n * (n - 1.0)).max(1.0);
        let of_pixel = |i: usize| {
            std::array::from_fn(|c| {
                let at = 3 * i + c;
                let chains = spread(&|k| f64::from(self.sums[3 * k * pixels + at]));
                (chains + separate(at)).sqrt() as f32
            })
        };
        let tiles = self.tiles();
        let mut sums = vec![[0.0; 3]; groups * tiles.count()];
        let mut variances = vec![[0.0; 3]; tiles.count()];
        for (i, t) in tiles.of_all().enumerate() {
            for c in 0..3 {
                variances[t][c] += separate(3 * i + c);
                for k in 0..groups {
                    let x = f64::from(self.sums[3 * (k * pixels + i) + c]);
                    sums[k * tiles.count() + t][c] += x;
                }
            }
        }
        let counts = tiles.pixels();
        let of_tile = |t: usize| {
            std::array::from_fn(|c| {
                let chains = spread(&|k| sums[k * tiles.count() + t][c]);
                (chains + variances[t][c]).sqrt() / counts[t]
            })
        };
        let luminance = |rgb: [f64; 3]| 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
        let light = |t: usize| (0..groups).map(|k| luminance(sums[k * tiles.count() + t])).sum();
        let r_hat =
            |t: usize| self.series.r_hat((0..groups).map(|k| k * tiles.count() + t)).unwrap_or(1.0);
        Some(Errors {
            pixels: (0..pixels).map(of_pixel).collect(),
            tiles: (0..tiles.count()).map(of_tile).collect(),
            r_hat: (0..tiles.count()).map(r_hat).collect(),
            light: (0..tiles.count()).map(light).collect(),
        })
    }
}
