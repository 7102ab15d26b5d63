//! All form factors at once: the system as a matrix.
//!
//! ```text
//! (I - ρF) B = S                                     direct                         (4)
//! H ← F(S + ρH)                                      Jacobi                         (5)
//! H_i ← Σⱼ F_ij (S_j + ρ_j H_j), the newest H_j      Gauss-Seidel                   (6)
//! ```
//!
//! ρ < 1 and rows of F that sum to at most 1 make (4) diagonally dominant: elimination needs no
//! pivots, and both iterations converge as ρ̄ⁿ or better (Cohen & Wallace 1993, ch. 5).

use super::{Patches, Rest};
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

/// (4), by Gauss's elimination in double precision, channel by channel. `None` if `each`, asked before each line, says `None`.
pub fn direct(
    rows: &[Row],
    patches: &Patches,
    each: impl Fn() -> Option<()>,
) -> Option<Vec<Spectrum>> {
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
            each()?;
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
    Some(rows.par_iter().map(|row| gather(row, |j| b[j])).collect())
}

/// (5), until what further iterations would add is no more than `tolerance` of all the light.
pub fn jacobi(rows: &[Row], patches: &Patches, tolerance: f32) -> Vec<Spectrum> {
    let mut h = vec![Spectrum::ZERO; rows.len()];
    let mut rest = Rest::default();
    for _ in 0..MOST {
        let b = patches.radiosity(&h);
        let next: Vec<Spectrum> = rows.par_iter().map(|row| gather(row, |j| b[j])).collect();
        let (mut change, mut all) = (0.0, 0.0);
        for (i, (new, old)) in next.iter().zip(&h).enumerate() {
            change += patches.power(i, *new - *old);
            all += patches.power(i, *new);
        }
        h = next;
        if rest.is_within(change, all, tolerance) {
            break;
        }
    }
    h
}

/// (6), likewise.
pub fn gauss_seidel(rows: &[Row], patches: &Patches, tolerance: f32) -> Vec<Spectrum> {
    let mut h = vec![Spectrum::ZERO; rows.len()];
    let mut b = patches.source.clone();
    let mut rest = Rest::default();
    for _ in 0..MOST {
        let (mut change, mut all) = (0.0, 0.0);
        for (i, row) in rows.iter().enumerate() {
            let next = gather(row, |j| b[j]);
            change += patches.power(i, next - h[i]);
            all += patches.power(i, next);
            h[i] = next;
            b[i] = patches.source[i] + patches.albedo[i] * next;
        }
        if rest.is_within(change, all, tolerance) {
            break;
        }
    }
    h
}
