//! Piecewise linear densities on [0, 1].

use super::inversion::{linear_inverse, sample_linear};
use super::weights::{cell, check, within};
use super::{InvalidWeights, PiecewiseConstant1D};
use kaustika_math::lerp;

/// The density that interpolates linearly between n + 1 equidistant nodes of [0, 1]:
/// emission spectra, phase functions.
#[derive(Clone, Debug)]
pub struct PiecewiseLinear1D {
    /// The density at the nodes.
    nodes: Vec<f32>,
    /// Which of the n cells.
    cells: PiecewiseConstant1D,
}

impl PiecewiseLinear1D {
    /// With densities at the nodes proportional to `values`, at least two.
    ///
    /// # Errors
    /// If there are fewer than two values, an invalid one or no positive one.
    pub fn new(values: &[f32]) -> Result<Self, InvalidWeights> {
        if values.len() < 2 {
            return Err(InvalidWeights::Shape { expected: 2, found: values.len() });
        }
        check(values)?;
        let n = values.len() - 1;
        let area: f64 =
            values.windows(2).map(|v| 0.5 * (f64::from(v[0]) + f64::from(v[1]))).sum::<f64>()
                / n as f64;
        let nodes: Vec<f32> = values.iter().map(|&v| (f64::from(v) / area) as f32).collect();
        let areas: Vec<f32> = nodes.windows(2).map(|v| 0.5 * (v[0] + v[1])).collect();
        Ok(PiecewiseLinear1D { cells: PiecewiseConstant1D::new(&areas)?, nodes })
    }

    /// A point and its density; `u` in [0, 1).
    #[inline]
    pub fn sample(&self, u: f32) -> (f32, f32) {
        let (i, t) = super::constant::search(self.cells.cdf(), u);
        let x = within(i, sample_linear(t, self.nodes[i], self.nodes[i + 1]), self.len());
        (x, self.pdf(x))
    }

    /// The density at `x`; 0 outside [0, 1).
    #[inline]
    pub fn pdf(&self, x: f32) -> f32 {
        if !(0.0..1.0).contains(&x) {
            return 0.0;
        }
        let i = cell(x, self.len());
        lerp(x * self.len() as f32 - i as f32, self.nodes[i], self.nodes[i + 1])
    }

    /// The probability of less than `x`, which is the `u` that gives `x`.
    #[inline]
    pub fn invert(&self, x: f32) -> f32 {
        let x = x.clamp(0.0, 1.0);
        let i = cell(x, self.len());
        let t = linear_inverse(x * self.len() as f32 - i as f32, self.nodes[i], self.nodes[i + 1]);
        lerp(t, self.cells.cdf()[i], self.cells.cdf()[i + 1])
    }

    /// The number of cells, at least 1.
    #[expect(clippy::len_without_is_empty, reason = "never empty")]
    pub fn len(&self) -> usize {
        self.nodes.len() - 1
    }
}
