//! Planes of numbers, and means over squares of them.

use rayon::prelude::*;

/// Numbers of a grid of pixels with a rim around, which repeats the outermost ones: windows may
/// reach over the border without asking.
pub struct Plane {
    stride: usize,
    data: Vec<f32>,
}

/// Width of the rim.
pub const RIM: usize = 24;

impl Plane {
    /// Of `value` at each column and row.
    pub fn new(
        (width, height): (usize, usize),
        value: impl Fn(usize, usize) -> f32 + Sync,
    ) -> Plane {
        let stride = width + 2 * RIM;
        let mut data = vec![0.0; stride * (height + 2 * RIM)];
        let inside = |i: usize, n: usize| i.saturating_sub(RIM).min(n - 1);
        data.par_chunks_exact_mut(stride).enumerate().for_each(|(j, row)| {
            for (i, out) in row.iter_mut().enumerate() {
                *out = value(inside(i, width), inside(j, height));
            }
        });
        Plane { stride, data }
    }

    /// Where the pixel at column `x` and row `y` lies; both may reach into the rim.
    #[inline(always)]
    pub fn at(&self, x: isize, y: isize) -> usize {
        (y + RIM as isize) as usize * self.stride + (x + RIM as isize) as usize
    }

    /// From one row to the next.
    #[inline(always)]
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// The number at [`Plane::at`].
    #[inline(always)]
    pub fn get(&self, at: usize) -> f32 {
        self.data[at]
    }

    /// Eight numbers from there on.
    #[inline(always)]
    pub fn eight(&self, at: usize) -> [f32; 8] {
        let mut eight = [0.0; 8];
        eight.copy_from_slice(&self.data[at..at + 8]);
        eight
    }
}

/// Means over the squares of `radius` around each pixel, as far as they lie in the picture. Every
/// sum is formed in the same order, whoever forms it.
pub fn box_mean(data: &[f32], (width, height): (usize, usize), radius: usize) -> Vec<f32> {
    let reach = |i: usize, n: usize| (i.saturating_sub(radius), (i + radius + 1).min(n));
    let mut rows = vec![0.0f32; width * height];
    rows.par_chunks_exact_mut(width).zip(data.par_chunks_exact(width)).for_each(|(out, row)| {
        for (x, out) in out.iter_mut().enumerate() {
            let (a, b) = reach(x, width);
            *out = row[a..b].iter().sum::<f32>() / (b - a) as f32;
        }
    });
    let mut means = vec![0.0f32; width * height];
    means.par_chunks_exact_mut(width).enumerate().for_each(|(y, out)| {
        let (a, b) = reach(y, height);
        for row in rows[a * width..b * width].chunks_exact(width) {
            out.iter_mut().zip(row).for_each(|(o, v)| *o += v);
        }
        out.iter_mut().for_each(|o| *o /= (b - a) as f32);
    });
    means
}
