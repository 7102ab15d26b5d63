//! From what a render knows of each pixel to what the fits compare.

use super::fireflies;
use super::plane::{Plane, box_mean};
use super::solve::Columns;
use super::{Features, Noisy};
use rayon::prelude::*;

/// The picture as the fits see it.
pub struct Prepared<const C: usize> {
    /// Columns and rows.
    pub size: (usize, usize),
    /// u: colour over [`Prepared::albedo`], without its outliers.
    pub value: Vec<[f32; C]>,
    /// What was divided by.
    pub albedo: Vec<[f32; C]>,
    /// What outliers had too much, as colour.
    pub excess: Vec<[f32; C]>,
    /// x of (3).
    pub columns: Vec<Columns>,
    /// Mean of u over the channels, and its variance.
    pub grey: Plane,
    /// Variance of `grey`.
    pub variance: Plane,
    /// [`Columns`] but for the constant, each a plane.
    pub features: [Plane; 7],
}

/// Albedos below are not divided by: what is seen there is no reflected light of theirs.
const DARK: f32 = 0.01;

impl<const C: usize> Prepared<C> {
    /// Looks at a picture and its features.
    pub fn new(noisy: &Noisy<C>, features: &Features) -> Prepared<C> {
        let size @ (width, height) = (noisy.width, noisy.height);
        let pixels = width * height;
        let albedo: Vec<[f32; C]> =
            (0..pixels).into_par_iter().map(|i| divisor(features, i, size)).collect();
        let mut value: Vec<[f32; C]> = (0..pixels)
            .into_par_iter()
            .map(|i| std::array::from_fn(|c| noisy.mean[c][i] / albedo[i][c]))
            .collect();
        let filled = fill_holes(&value, size);
        let holes: Vec<bool> = value.iter().map(|v| !is_finite(v)).collect();
        value = filled;

        // Channels of one sample rise and fall together, so their deviations add up.
        let known = |i: usize| {
            let planes = noisy.variance?;
            let sum: f32 = (0..C).map(|c| planes[c][i].max(0.0).sqrt() / albedo[i][c]).sum();
            let deviation = sum / C as f32;
            (deviation.is_finite() && !holes[i]).then_some(deviation * deviation)
        };
        let grey: Vec<f32> = value.par_iter().map(grey_of).collect();
        let scatter = scatter(&grey, size);
        let variance: Vec<f32> =
            (0..pixels).into_par_iter().map(|i| known(i).unwrap_or(scatter[i])).collect();
        let clip = fireflies::clip(&grey, &variance, size);
        let excess: Vec<[f32; C]> = (0..pixels)
            .into_par_iter()
            .map(|i| std::array::from_fn(|c| value[i][c] * (1.0 - clip[i]) * albedo[i][c]))
            .collect();
        value.par_iter_mut().zip(&clip).for_each(|(v, k)| *v = v.map(|v| v * k));
        let grey: Vec<f32> = value.par_iter().map(grey_of).collect();
        let clipped: Vec<f32> = variance.iter().zip(&clip).map(|(v, k)| v * k * k).collect();
        let variance = believed_variance(&grey, &clipped, size);

        let columns = columns(features, size);
        let plane = |j: usize| Plane::new(size, |x, y| columns[y * width + x][j]);
        Prepared {
            size,
            grey: Plane::new(size, |x, y| grey[y * width + x]),
            variance: Plane::new(size, |x, y| variance[y * width + x]),
            features: [1, 2, 3, 4, 5, 6, 7].map(plane),
            value,
            albedo,
            excess,
            columns,
        }
    }
}

fn is_finite<const C: usize>(v: &[f32; C]) -> bool {
    v.iter().all(|v| v.is_finite())
}

fn grey_of<const C: usize>(v: &[f32; C]) -> f32 {
    v.iter().sum::<f32>() / C as f32
}

/// The albedo of a pixel where it can be divided by, else 1. One channel has the mean of three.
///
/// What is seen where no surface is has an albedo of 0 but is divided by 1. Pixels beside such ones
/// may show both: the part of theirs without a surface, 1 - |mean normal|, counts as 1 too.
fn divisor<const C: usize>(features: &Features, i: usize, size: (usize, usize)) -> [f32; C] {
    let Some(albedo) = features.albedo else { return [1.0; C] };
    let bare = match features.normal {
        Some(n) if beside_nothing(albedo, i, size) => {
            let length = n.iter().map(|plane| plane[i] * plane[i]).sum::<f32>().sqrt();
            (1.0 - length).clamp(0.0, 1.0)
        }
        _ => 0.0,
    };
    let rgb = albedo.map(|plane| plane[i] + bare);
    let grey = grey_of(&rgb);
    if !(grey > DARK && grey.is_finite()) {
        return [1.0; C];
    }
    std::array::from_fn(|c| if C == 3 { rgb[c].max(DARK) } else { grey })
}

/// Pixels over which a silhouette may be spread.
const BLEND: usize = 4;

/// True where a pixel has an albedo of 0 that is no farther than twice the radius of common pixel
/// filters: both are then parts of one mixture.
fn beside_nothing(albedo: [&[f32]; 3], i: usize, (width, height): (usize, usize)) -> bool {
    let (x, y) = (i % width, i / width);
    let mut rows = y.saturating_sub(BLEND)..(y + BLEND + 1).min(height);
    rows.any(|b| {
        let mut columns = x.saturating_sub(BLEND)..(x + BLEND + 1).min(width);
        columns.any(|a| albedo.iter().all(|plane| plane[b * width + a] == 0.0))
    })
}

/// Pixels that are not numbers become the mean of those around that are.
fn fill_holes<const C: usize>(
    value: &[[f32; C]],
    (width, height): (usize, usize),
) -> Vec<[f32; C]> {
    let fill = |i: usize| {
        let (x, y) = (i % width, i / width);
        for reach in [1, 2, 4, 8] {
            let (mut sum, mut count) = ([0.0; C], 0.0);
            for b in y.saturating_sub(reach)..(y + reach + 1).min(height) {
                for a in x.saturating_sub(reach)..(x + reach + 1).min(width) {
                    let v = &value[b * width + a];
                    if is_finite(v) {
                        (0..C).for_each(|c| sum[c] += v[c]);
                        count += 1.0;
                    }
                }
            }
            if count > 0.0 {
                return sum.map(|s| s / count);
            }
        }
        [0.0; C]
    };
    let one = |(i, v): (usize, &[f32; C])| if is_finite(v) { *v } else { fill(i) };
    value.par_iter().enumerate().map(one).collect()
}

/// (5): what a pixel is off the mean of its eight neighbours, squared, on the scale of a variance.
fn scatter(grey: &[f32], size @ (width, height): (usize, usize)) -> Vec<f32> {
    let around = Plane::new(size, |x, y| grey[y * width + x]);
    (0..width * height)
        .into_par_iter()
        .map(|i| {
            let at = around.at((i % width) as isize, (i / width) as isize);
            let rows = [at - around.stride(), at, at + around.stride()];
            let sum: f32 =
                rows.iter().flat_map(|r| [r - 1, *r, r + 1]).map(|a| around.get(a)).sum();
            let off = grey[i] - (sum - grey[i]) / 8.0;
            off * off / 1.125
        })
        .collect()
}

/// Radius of the squares over which (5) is averaged.
const WIDE: usize = 7;

/// The variance smoothed over three by three pixels, and lowered to what (5) says.
fn believed_variance(grey: &[f32], variance: &[f32], size: (usize, usize)) -> Vec<f32> {
    let smooth = box_mean(variance, size, 1);
    let seen = box_mean(&scatter(grey, size), size, WIDE);
    let told = box_mean(&smooth, size, WIDE);
    let least = smooth.iter().sum::<f32>() / smooth.len() as f32 * 1e-6;
    (0..smooth.len())
        .map(|i| {
            let ratio = if told[i] > 0.0 { (seen[i] / told[i]).min(1.0) } else { 1.0 };
            (smooth[i] * ratio).max(least)
        })
        .collect()
}

/// Distance over which the columns of the position change by 1, in pixels.
const REACH: f32 = 10.0;

/// x of (3): 1, column, row, normal, depth, albedo.
fn columns(features: &Features, (width, height): (usize, usize)) -> Vec<Columns> {
    let finite = |v: f32| if v.is_finite() { v } else { 0.0 };
    let depth = |i: usize| features.depth.map_or(0.0, |d| finite(d[i]).max(0.0));
    let total: f64 = (0..width * height).map(|i| f64::from(depth(i))).sum();
    let mean = (total / (width * height) as f64) as f32;
    (0..width * height)
        .into_par_iter()
        .map(|i| {
            let n = features.normal.map_or([0.0; 3], |n| n.map(|plane| finite(plane[i])));
            let z = depth(i);
            let z = if z > 0.0 { 2.0 * z / (z + mean) } else { 2.0 };
            let a = features.albedo.map_or(0.0, |a| grey_of(&a.map(|plane| finite(plane[i]))));
            let (x, y) = ((i % width) as f32 / REACH, (i / width) as f32 / REACH);
            [1.0, x, y, n[0], n[1], n[2], z, a]
        })
        .collect()
}
