//! Piecewise constant densities on [0, 1).

use super::InvalidWeights;
use super::weights::{cell, check, within};
use kaustika_math::{ONE_MINUS_EPSILON, lerp};
use std::ops::Range;

/// The density that is constant on each of n equal cells of [0, 1), sampled by inversion, so
/// that stratified numbers give stratified samples.
#[derive(Clone, Debug)]
pub struct PiecewiseConstant1D {
    /// n + 1 values from 0 to 1.
    cdf: Vec<f32>,
    /// The density in each cell.
    pdf: Vec<f32>,
    mean: f32,
}

/// The running sum of the weights over their sum, 0 to 1, n + 1 values. Cells after the last
/// positive weight get exactly 1, so that they are never chosen.
pub(super) fn cumulative(weights: &[f32], sum: f64) -> impl Iterator<Item = f32> {
    let running = weights.iter().scan(0.0f64, |running, &w| {
        *running += f64::from(w);
        Some(*running)
    });
    std::iter::once(0.0).chain(running.map(move |r| (r / sum) as f32))
}

/// The cell whose part of the cumulative function holds `u`, and where in it; never one that
/// is empty.
#[inline]
pub(super) fn search(cdf: &[f32], u: f32) -> (usize, f32) {
    search_among(cdf, u, 0..cdf.len())
}

/// As [`search`], where the number of values at most `u` is known to be in `among` or its end.
#[inline]
pub(super) fn search_among(cdf: &[f32], u: f32, among: Range<usize>) -> (usize, f32) {
    let u = u.min(ONE_MINUS_EPSILON);
    let at_most = among.start + cdf[among].partition_point(|&c| c <= u);
    let i = at_most.clamp(1, cdf.len() - 1) - 1;
    let (c0, c1) = (cdf[i], cdf[i + 1]);
    (i, ((u - c0) / (c1 - c0)).min(ONE_MINUS_EPSILON))
}

impl PiecewiseConstant1D {
    /// With densities proportional to `weights`, one a cell.
    ///
    /// # Errors
    /// If there are no weights, an invalid one or no positive one.
    pub fn new(weights: &[f32]) -> Result<Self, InvalidWeights> {
        let n = weights.len();
        if n == 0 {
            return Err(InvalidWeights::Shape { expected: 1, found: 0 });
        }
        let sum = check(weights)?;
        Ok(PiecewiseConstant1D {
            cdf: cumulative(weights, sum).collect(),
            pdf: weights.iter().map(|&w| (f64::from(w) * n as f64 / sum) as f32).collect(),
            mean: (sum / n as f64) as f32,
        })
    }

    /// A point, its density and its cell; `u` in [0, 1).
    #[inline]
    pub fn sample(&self, u: f32) -> (f32, f32, usize) {
        let (i, t) = search(&self.cdf, u);
        (within(i, t, self.pdf.len()), self.pdf[i], i)
    }

    /// The density at `x`; 0 outside [0, 1).
    #[inline]
    pub fn pdf(&self, x: f32) -> f32 {
        if (0.0..1.0).contains(&x) { self.pdf[cell(x, self.pdf.len())] } else { 0.0 }
    }

    /// The probability of less than `x`, which is the `u` that gives `x`.
    #[inline]
    pub fn invert(&self, x: f32) -> f32 {
        let scaled = x.clamp(0.0, 1.0) * self.pdf.len() as f32;
        let i = (scaled as usize).min(self.pdf.len() - 1);
        lerp(scaled - i as f32, self.cdf[i], self.cdf[i + 1])
    }

    /// The probability of cell `i`.
    #[inline]
    pub fn pmf(&self, i: usize) -> f32 {
        self.cdf[i + 1] - self.cdf[i]
    }

    /// The probabilities of the first 0, 1, … n cells.
    #[inline]
    pub(super) fn cdf(&self) -> &[f32] {
        &self.cdf
    }

    /// The mean of the weights: the integral over [0, 1) of the function that they tabulate.
    pub fn integral(&self) -> f32 {
        self.mean
    }
}
