//! What groups of chains tell of the picture's error: each is an independent render, with candidates and
//! a brightness of its own.
//!
//! ```text
//! σ² = Σ_g (X_g - X̄)² / (G (G - 1)) + M₂ / (n (n - 1))                                  (1)
//! ```
//!
//! X_g is group g's own estimate of a pixel or of a tile, of G, or that of some groups together: pixels are told of by fewer, for
//! the memory that each takes; M₂ the sum of squared deviations over n passes of
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

/// Most groups, or groups together, that have a picture of their own: they know a pixel's error to a fifth.
const MOST_FILMS: usize = 16;

/// What groups have left on the film.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Groups {
    size: [u32; 2],
    groups: u64,
    passes: u64,
    /// Pictures, each of as many groups as the others.
    films: u64,
    /// Σ over passes, picture by picture, of r, g, b of each pixel.
    sums: Vec<f32>,
    /// Σ over passes, group by group, of r, g, b of each tile.
    tiles: Vec<[f64; 3]>,
    /// Mean and M₂ of each number of what is rendered separately.
    separate: Vec<[f32; 2]>,
    /// Light in the tiles in this pass, group by group.
    now: Vec<f64>,
    /// The same over all passes.
    series: Series,
}
saved!(Groups { size, groups, passes, films, sums, tiles, separate, now, series });

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
        let films = (1..=MOST_FILMS).rev().find(|films| groups.is_multiple_of(*films)).unwrap_or(1);
        Groups {
            size,
            groups: groups as u64,
            passes: 0,
            films: films as u64,
            sums: vec![0.0; films * pixels * 3],
            tiles: vec![[0.0; 3]; groups * tiles],
            separate: vec![[0.0; 2]; pixels * 3],
            now: vec![0.0; groups * tiles],
            series: Series::new(groups * tiles),
        }
    }

    fn cut(&self) -> Tiles {
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
        let (pixels, cut) = (self.pixels(), self.cut());
        let film = group * self.films as usize / self.groups as usize;
        each_covered(frame, s.film, |x, y, k| {
            let pixel = y as usize * self.size[0] as usize + x as usize;
            let at = 3 * (film * pixels + pixel);
            let rgb = s.rgb.map(|v| k * v);
            self.sums[at..at + 3].iter_mut().zip(rgb).for_each(|(sum, v)| *sum += v);
            let tile = group * cut.count() + cut.of(x, y);
            self.tiles[tile].iter_mut().zip(rgb).for_each(|(sum, v)| *sum += f64::from(v));
            self.now[tile] += modulus(rgb);
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
        let n = self.passes as f64;
        let pixels = self.pixels();
        // What one of `parts` leaves is its part of the mean over all.
        let spread = |parts: usize, of: &dyn Fn(usize) -> f64| {
            let g = parts as f64;
            let all: Vec<f64> = (0..parts).map(|k| g / n * of(k)).collect();
            let mean = all.iter().sum::<f64>() / g;
            all.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (g * (g - 1.0))
        };
        let separate = |at: usize| f64::from(self.separate[at][1]) / (n * (n - 1.0)).max(1.0);
        let of_pixel = |i: usize| {
            std::array::from_fn(|c| {
                let at = 3 * i + c;
                let film = |k| f64::from(self.sums[3 * k * pixels + at]);
                (spread(self.films as usize, &film) + separate(at)).sqrt() as f32
            })
        };
        let cut = self.cut();
        let mut variances = vec![[0.0; 3]; cut.count()];
        for (i, t) in cut.of_all().enumerate() {
            for c in 0..3 {
                variances[t][c] += separate(3 * i + c);
            }
        }
        let of_group = |k: usize, t: usize| self.tiles[k * cut.count() + t];
        let counts = cut.pixels();
        let of_tile = |t: usize| {
            std::array::from_fn(|c| {
                let chains = spread(groups, &|k| of_group(k, t)[c]);
                (chains + variances[t][c]).sqrt() / counts[t]
            })
        };
        let luminance = |rgb: [f64; 3]| 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
        let light = |t: usize| (0..groups).map(|k| luminance(of_group(k, t))).sum();
        let r_hat =
            |t: usize| self.series.r_hat((0..groups).map(|k| k * cut.count() + t)).unwrap_or(1.0);
        Some(Errors {
            pixels: (0..pixels).map(of_pixel).collect(),
            tiles: (0..cut.count()).map(of_tile).collect(),
            r_hat: (0..cut.count()).map(r_hat).collect(),
            light: (0..cut.count()).map(light).collect(),
        })
    }
}
