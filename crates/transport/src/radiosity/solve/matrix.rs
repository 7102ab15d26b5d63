//! All form factors at once: the system as a matrix.
//!
//! ```text
//! (I - ρF) B = S                                     direct                         (3)
//! H ← F(S + ρH)                                      Jacobi                         (4)
//! H_i ← Σⱼ F_ij (S_j + ρ_j H_j), the newest H_j      Gauss-Seidel                   (5)
//! ```
//!
//! ρ < 1 and rows of F that sum to at most 1 make (3) diagonally dominant: elimination needs no
//! pivots, and both iterations converge as ρ̄ⁿ or better (Cohen & Wallace 1993, ch. 5).

use super::Patches;
use crate::radiosity::form_factor::Row;
use kaustika_spectra::Spectrum;
use rayon::prelude::*;

/// Iterations after which even white patches are given up.
const MOST: usize = 1000;

/// Σⱼ F_ij B_j.
fn gather(row: &Row, b: impl Fn(usize) -> Spectrum) -> Spectrum {
    let mut sum = Spectrum::ZERO;
    row.each(|j, f| sum += f * b(j));
    sum
}

/// True if no H changed by more than `tolerance` of the largest.
fn settled(change: f32, largest: f32, tolerance: f32) -> bool {
    change <= tolerance * largest
}

/// (3), by Gauss's elimination in double precision, channel by channel.
pub fn direct(rows: &[Row], patches: &Patches) -> Vec<Spectrum> {
    let n = rows.len();
    let mut b = vec![Spectrum::ZERO; n];
    for channel in 0..3 {
        // Rows of [I - ρF | S].
        let mut m: Vec<Vec<f64>> = (0..n)
            .into_par_iter()
            .map(|i| {
                let mut line = vec![0.0; n + 1];
                let rho = f64::from(patches.albedo[i].0[channel]);
                line[i] = 1.0;
                rows[i].each(|j, f| line[j] -= rho * f64::from(f.0[channel]));
                line[n] = f64::from(patches.source[i].0[channel]);
                line
            })
            .collect();
        for k in 0..n {
            let (above, below) = m.split_at_mut(k + 1);
            let pivot = &above[k];
            below.par_iter_mut().for_each(|line| {
                let factor = line[k] / pivot[k];
                if factor != 0.0 {
                    let terms = line[k..].iter_mut().zip(&pivot[k..]);
                    terms.for_each(|(x, p)| *x -= factor * p);
                }
            });
        }
        for k in (0..n).rev() {
            let sum: f64 = (k + 1..n).map(|j| m[k][j] * f64::from(b[j].0[channel])).sum();
            b[k].0[channel] = ((m[k][n] - sum) / m[k][k]) as f32;
        }
    }
    rows.par_iter().map(|row| gather(row, |j| b[j])).collect()
}

/// (4), until no patch changes by more than `tolerance` of the brightest.
pub fn jacobi(rows: &[Row], patches: &Patches, tolerance: f32) -> Vec<Spectrum> {
    let mut h = vec![Spectrum::ZERO; rows.len()];
    for _ in 0..MOST {
        let b = patches.radiosity(&h);
        let next: Vec<Spectrum> = rows.par_iter().map(|row| gather(row, |j| b[j])).collect();
        let change = next.iter().zip(&h).map(|(a, b)| distance(*a, *b)).fold(0.0, f32::max);
        let largest = next.iter().map(|h| h.max_component()).fold(0.0, f32::max);
        h = next;
        if settled(change, largest, tolerance) {
            break;
        }
    }
    h
}

/// (5), likewise.
pub fn gauss_seidel(rows: &[Row], patches: &Patches, tolerance: f32) -> Vec<Spectrum> {
    let mut h = vec![Spectrum::ZERO; rows.len()];
    let mut b = patches.source.clone();
    for _ in 0..MOST {
        let (mut change, mut largest) = (0.0f32, 0.0f32);
        for (i, row) in rows.iter().enumerate() {
            let next = gather(row, |j| b[j]);
            change = change.max(distance(next, h[i]));
            largest = largest.max(next.max_component());
            h[i] = next;
            b[i] = patches.source[i] + patches.albedo[i] * next;
        }
        if settled(change, largest, tolerance) {
            break;
        }
    }
    h
}

fn distance(a: Spectrum, b: Spectrum) -> f32 {
    (a - b).map(f32::abs).max_component()
}
