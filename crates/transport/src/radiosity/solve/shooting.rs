//! Southwell's iteration, known as progressive refinement (Cohen, Chen, Wallace & Greenberg 1988):
//! always the patch with the most unshot power shoots.
//!
//! ```text
//! R = S at first;   i = argmax A_i R_i                                              (7)
//! ΔH_j = F_ji R_i = F_ij R_i A_i / A_j;   R_j += ρ_j ΔH_j;   R_i = 0                (8)
//! until Σ A_i R_i ≤ ε Σ A_i S_i                                                     (9)
//! H'_j = H_j + (Σ A_i R_i / Σ A_i) / (1 - ρ̄)                                        (10)
//! ```
//!
//! R is the residual of the patches that have shot: (8) relaxes its largest part. (10) adds what is not
//! shot yet as if it were even everywhere, for display alone. Form factors are found row by row when
//! they are wanted; nothing of the order n² is kept.

use super::Patches;
use crate::radiosity::form_factor::Row;
use kaustika_spectra::Spectrum;

/// When to stop, and what to show.
#[derive(Clone, Copy, Debug)]
pub struct Shooting {
    /// ε of (9).
    pub tolerance: f32,
    /// Shots at most.
    pub shots: usize,
    /// True: (10) is added.
    pub ambient: bool,
}

/// (7) to (10). `row` finds form factors, or `None` if it is to end at once; `each` is told what is
/// left unshot, as a part of all, after each shot. The irradiances, and how many shots there were.
pub fn shoot(
    patches: &Patches,
    shooting: &Shooting,
    mut row: impl FnMut(usize) -> Option<Row>,
    mut each: impl FnMut(f32),
) -> Option<(Vec<Spectrum>, usize)> {
    let n = patches.source.len();
    let mut h = vec![Spectrum::ZERO; n];
    let mut unshot = patches.source.clone();
    let power = |r: &[Spectrum], i: usize| r[i].rgb().iter().sum::<f32>() * patches.area[i];
    let total: f64 = (0..n).map(|i| f64::from(power(&unshot, i))).sum();
    let mut shots = 0;
    loop {
        let (mut most, mut brightest, mut left) = (0.0, 0, 0.0f64);
        for i in 0..n {
            let power = power(&unshot, i);
            left += f64::from(power);
            if power > most {
                (most, brightest) = (power, i);
            }
        }
        if shots > 0 {
            each((left / total) as f32);
        }
        if shots == shooting.shots || left <= f64::from(shooting.tolerance) * total || most == 0.0 {
            break; // (9)
        }
        let i = brightest; // (7)
        let shot = std::mem::replace(&mut unshot[i], Spectrum::ZERO) * patches.area[i];
        row(i)?.each(|j, f| {
            let delta = f * shot / patches.area[j]; // (8)
            h[j] += delta;
            unshot[j] += patches.albedo[j] * delta;
        });
        shots += 1;
    }
    if shooting.ambient {
        let area: f32 = patches.area.iter().sum();
        let mean = |of: &[Spectrum]| {
            let sum = of.iter().zip(&patches.area).fold(Spectrum::ZERO, |s, (x, a)| s + *x * *a);
            sum / area.max(f32::MIN_POSITIVE)
        };
        let (left, rho) = (mean(&unshot), mean(&patches.albedo).clamp(0.0, 0.99));
        let ambient = left.safe_div(Spectrum::ONE - rho); // (10)
        h.iter_mut().for_each(|h| *h += ambient);
    }
    Some((h, shots))
}
