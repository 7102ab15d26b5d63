//! Linear fits around some pixels, each of which speaks for its window.

use super::plane::Plane;
use super::prepare::Prepared;
use super::solve::{Columns, UNKNOWNS, solve};
use super::weights::{RADIUS, ROW, SIDE, Window, weigh};
use rayon::prelude::*;
use wide::f32x8;

/// Columns and rows between the centres of windows.
const STEP: usize = 4;

/// Rows of centres that one task takes.
const ROWS: usize = 4;

/// Weight of a pixel below which it gets a fit of its own.
const LONELY: f32 = 1.0;

/// κ of (3).
const RIDGE: f32 = 0.1;

/// u of every pixel as the fits see it, (4).
pub fn filter<const C: usize>(p: &Prepared<C>) -> Vec<[f32; C]> {
    let (width, height) = p.size;
    let bands: Vec<Band<C>> = (0..height.div_ceil(STEP * ROWS))
        .into_par_iter()
        .map(|band| {
            let first = band * STEP * ROWS;
            let mut out = Band::new(first.saturating_sub(RADIUS as usize), p.size);
            let mut window = [[0.0; ROW]; SIDE];
            for y in (first + STEP / 2..height.min(first + STEP * ROWS)).step_by(STEP) {
                for x in (STEP / 2..width).step_by(STEP) {
                    let fit = fit(p, x, y, &mut window);
                    out.add(p, x, y, &window, &fit);
                }
            }
            out
        })
        .collect();
    let mut result = vec![[0.0; C]; width * height];
    result.par_chunks_exact_mut(width).enumerate().for_each(|(y, row)| {
        let mut window = [[0.0; ROW]; SIDE];
        let reach = STEP * ROWS;
        let from = y.saturating_sub(RADIUS as usize + reach - 1) / reach;
        let to = ((y + RADIUS as usize) / reach).min(bands.len() - 1);
        for (x, out) in row.iter_mut().enumerate() {
            let (mut sum, mut weight) = ([0.0; C], 0.0);
            for band in &bands[from..=to] {
                let Some((s, w)) = band.get(x, y) else { continue };
                (0..C).for_each(|c| sum[c] += s[c]);
                weight += w;
            }
            if weight < LONELY {
                let own = fit(p, x, y, &mut window);
                let columns = &p.columns[y * width + x];
                (0..C).for_each(|c| sum[c] += value(&own[c], columns));
                weight += 1.0;
            }
            *out = sum.map(|s| (s / weight).max(0.0));
        }
    });
    result
}

fn value(beta: &Columns, x: &Columns) -> f32 {
    beta.iter().zip(x).map(|(b, x)| b * x).sum()
}

/// β of (3) for each channel, with the weights of the window around a pixel. The constant is that of
/// columns that are zero at the origin, not at the pixel.
fn fit<const C: usize>(p: &Prepared<C>, x: usize, y: usize, window: &mut Window) -> [Columns; C] {
    let (width, height) = p.size;
    weigh(p, x as isize, y as isize, window);
    let mut origin = p.columns[y * width + x];
    origin[0] = 0.0;
    let centre = f32x8::new(origin);
    let mut gram = [f32x8::splat(0.0); UNKNOWNS];
    let mut right = [f32x8::splat(0.0); C];
    let mut noise = 0.0;
    let rows = y.saturating_sub(RADIUS as usize)..(y + RADIUS as usize + 1).min(height);
    let (left, end) = (x.saturating_sub(RADIUS as usize), (x + RADIUS as usize + 1).min(width));
    for b in rows {
        let weights = &window[b + RADIUS as usize - y][left + RADIUS as usize - x..];
        let at = b * width;
        let pixels = p.columns[at + left..at + end].iter().zip(&p.value[at + left..at + end]);
        let spread = p.variance.at(left as isize, b as isize);
        for (k, ((columns, value), w)) in pixels.zip(weights).enumerate() {
            if *w == 0.0 {
                continue;
            }
            let x = f32x8::new(*columns) - centre;
            let weighted = x * f32x8::splat(*w);
            let lanes = x.to_array();
            for (g, x) in gram.iter_mut().zip(lanes) {
                *g = weighted.mul_add(f32x8::splat(x), *g);
            }
            for (r, v) in right.iter_mut().zip(value) {
                *r = weighted.mul_add(f32x8::splat(*v), *r);
            }
            noise += w * p.variance.get(spread + k);
        }
    }
    let gram = gram.map(f32x8::to_array);
    let right = right.map(f32x8::to_array);
    let total = gram[0][0].max(f32::MIN_POSITIVE);
    let mean = right.iter().map(|r| r[0]).sum::<f32>() / (C as f32 * total);
    let ridge = RIDGE * noise / total / (mean * mean).max(f32::MIN_POSITIVE) + 1e-4 * total;
    let mut beta = solve(&gram, ridge, &right);
    for b in &mut beta {
        b[0] -= value(b, &origin);
    }
    beta
}

/// Sums of (4) over the windows of a few rows of centres.
struct Band<const C: usize> {
    first: usize,
    width: usize,
    stride: usize,
    /// C planes of w u, and one of w.
    planes: Vec<Vec<f32>>,
}

impl<const C: usize> Band<C> {
    /// From row `first` on; each row has a rim of a window's reach.
    fn new(first: usize, (width, _): (usize, usize)) -> Band<C> {
        let stride = width + 2 * ROW;
        let rows = STEP * ROWS + SIDE;
        Band { first, width, stride, planes: vec![vec![0.0; stride * rows]; C + 1] }
    }

    fn at(&self, x: isize, y: isize) -> usize {
        (y - self.first as isize) as usize * self.stride + (x + ROW as isize) as usize
    }

    /// Adds what a fit says of the pixels of its window.
    fn add(&mut self, p: &Prepared<C>, x: usize, y: usize, window: &Window, fit: &[Columns; C]) {
        let (x, y) = (x as isize, y as isize);
        for (j, weights) in window.iter().enumerate() {
            let row = y + j as isize - RADIUS;
            if row < 0 || row >= p.size.1 as isize {
                continue;
            }
            for (k, w) in weights.chunks_exact(8).enumerate() {
                let column = x - RADIUS + 8 * k as isize;
                let from = p.grey.at(column, row);
                let at = self.at(column, row);
                let mut eight = [0.0; 8];
                eight.copy_from_slice(w);
                let w = f32x8::new(eight);
                let load = |plane: &Plane| f32x8::new(plane.eight(from));
                let x = p.features.each_ref().map(load);
                let (colours, weights) = self.planes.split_at_mut(C);
                for (plane, beta) in colours.iter_mut().zip(fit) {
                    let mut v = f32x8::splat(beta[0]);
                    for (x, b) in x.iter().zip(&beta[1..]) {
                        v = x.mul_add(f32x8::splat(*b), v);
                    }
                    add(&mut plane[at..at + 8], v * w);
                }
                add(&mut weights[0][at..at + 8], w);
            }
        }
    }

    /// Σ w u and Σ w at a pixel.
    fn get(&self, x: usize, y: usize) -> Option<([f32; C], f32)> {
        debug_assert!(x < self.width);
        let rows = self.planes[C].len() / self.stride;
        if y < self.first || y >= self.first + rows {
            return None;
        }
        let at = self.at(x as isize, y as isize);
        Some((std::array::from_fn(|c| self.planes[c][at]), self.planes[C][at]))
    }
}

#[inline(always)]
fn add(to: &mut [f32], v: f32x8) {
    to.iter_mut().zip(v.to_array()).for_each(|(t, v)| *t += v);
}
