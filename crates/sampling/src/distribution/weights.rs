//! Which tables of weights are densities.

use std::fmt;

/// Why a table of weights defines no distribution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InvalidWeights {
    /// The number of weights does not fit the shape, or is too small for it.
    Shape {
        /// Weights needed at least (for a product of sizes: exactly).
        expected: usize,
        /// Weights given.
        found: usize,
    },
    /// A weight is negative, infinite or NaN.
    Value {
        /// Index of the first such weight.
        index: usize,
    },
    /// No weight is positive.
    Zero,
}

impl fmt::Display for InvalidWeights {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            InvalidWeights::Shape { expected, found } => {
                write!(f, "expected {expected} weights, found {found}")
            }
            InvalidWeights::Value { index } => {
                write!(f, "weight {index} is negative, infinite or not a number")
            }
            InvalidWeights::Zero => f.write_str("no weight is positive"),
        }
    }
}

impl std::error::Error for InvalidWeights {}

/// Checks every weight; returns their sum, which is positive and finite.
pub(super) fn check(weights: &[f32]) -> Result<f64, InvalidWeights> {
    let valid = |w: &f32| *w >= 0.0 && w.is_finite();
    if let Some(index) = weights.iter().position(|w| !valid(w)) {
        return Err(InvalidWeights::Value { index });
    }
    let sum: f64 = weights.iter().map(|&w| f64::from(w)).sum();
    if sum > 0.0 { Ok(sum) } else { Err(InvalidWeights::Zero) }
}

/// The cell of `n` equal cells of [0, 1) that `x` lies in.
#[inline]
pub(super) fn cell(x: f32, n: usize) -> usize {
    ((x * n as f32) as usize).min(n - 1)
}

/// (i + t)/n, moved by a rounding error if [`cell`] would put it into a neighbouring cell; so
/// a sample keeps the density it was sampled with.
#[inline]
pub(super) fn within(i: usize, t: f32, n: usize) -> f32 {
    let mut x = (i as f32 + t) / n as f32;
    while x >= 1.0 || cell(x, n) > i {
        x = x.next_down();
    }
    while cell(x, n) < i {
        x = x.next_up();
    }
    x
}
