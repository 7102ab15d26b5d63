//! A filter that takes the noise out of a picture, led by what is known of the first surface: weights
//! of non-local means (Rousselle et al. 2012, 2013), local linear fits to the features (Bitterli et al.
//! 2016, NFOR) around some of the pixels, whose windows overlap (Moon et al. 2015).
//!
//! ```text
//! u = colour / albedo                                                     noisy, variance σ²
//! d(p, q) = mean over patches of ((u_p - u_q)² - σ²_p - min(σ²_p, σ²_q)) / (k² (σ²_p + σ²_q))    (1)
//! w(p, q) = e⁻ᵈ, d the largest of 0, (1) and |f_p - f_q|² / k_f² of normal, depth, albedo      (2)
//! β_p     = argmin Σ_q w(p, q) (u_q - β·(x_q - x_p))² + κ σ̄²/ū² Σ_j>0 β_j²                     (3)
//! û_q     = Σ_p w(p, q) β_p·(x_q - x_p) / Σ_p w(p, q)                                          (4)
//! σ²_p   *= min(1, mean (u_p - mean of 8 neighbours)² / 1.125 / mean σ²)                       (5)
//! ```
//!
//! x is 1, column, row, normal, depth and albedo. (3) is solved at every fourth pixel of every fourth
//! row, p of (4), and at pixels like none of these. What lies between two surfaces has features like
//! neither, and k_f grows with their difference there. (5), over a wide square, is for samplers whose
//! pixels are better than their variance says; without variances it is all there is. Outliers are
//! lowered before, with (6) and (7) of `fireflies.rs`. Pixels that are not numbers take the mean of
//! those around.
//!
//! Same input, same bits, whatever the number of threads.

mod fireflies;
mod fits;
mod plane;
mod prepare;
mod solve;
#[cfg(test)]
mod tests;
mod weights;

use prepare::Prepared;
use rayon::prelude::*;

/// A noisy picture of C channels.
#[derive(Clone, Copy, Debug)]
pub struct Noisy<'a, const C: usize> {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Linear values, row after row.
    pub mean: [&'a [f32]; C],
    /// Variance of `mean`, of each pixel; where it is unknown the picture tells.
    pub variance: Option<[&'a [f32]; C]>,
}

/// What is known of the first surface of each pixel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Features<'a> {
    /// Albedo, linear RGB.
    pub albedo: Option<[&'a [f32]; 3]>,
    /// Normal, x, y and z.
    pub normal: Option<[&'a [f32]; 3]>,
    /// Distance; 0 where nothing is met.
    pub depth: Option<&'a [f32]>,
}

/// A filtered picture.
#[derive(Clone, Debug)]
pub struct Denoised<const C: usize> {
    /// Linear values of each pixel, finite and not negative.
    pub pixels: Vec<[f32; C]>,
    /// Share of the light that was in outliers and stays out.
    pub left_out: f64,
}

/// Takes the noise out.
///
/// # Panics
/// If a plane does not hold `width * height` numbers.
pub fn denoise<const C: usize>(noisy: &Noisy<C>, features: &Features) -> Denoised<C> {
    let p = Prepared::new(noisy, features);
    let mut pixels = fits::filter(&p);
    pixels.par_iter_mut().zip(&p.albedo).for_each(|(v, a)| {
        (0..C).for_each(|c| v[c] *= a[c]);
    });
    let left_out = fireflies::give_back(&mut pixels, &p.excess, p.size);
    Denoised { pixels, left_out }
}

/// A guess of each pixel's luminance to divide by, as roulette and splitting do: positive and finite.
/// `variance` is that of `mean`, which has `size` = (columns, rows).
pub fn filter_luminance(
    mean: &[f32],
    variance: &[f32],
    features: &Features,
    size: (usize, usize),
) -> Vec<f32> {
    let (width, height) = size;
    let noisy = Noisy { width, height, mean: [mean], variance: Some([variance]) };
    let filtered = denoise(&noisy, features).pixels;
    let total: f64 = filtered.iter().map(|[v]| f64::from(*v)).sum();
    let least = (total / filtered.len() as f64) as f32 * DARKEST;
    filtered.iter().map(|[v]| v.max(least).max(f32::MIN_POSITIVE)).collect()
}

/// Least guess of [`filter_luminance`], as a part of the picture's mean.
const DARKEST: f32 = 1e-3;
