//! Piecewise constant densities on [0, 1)².

use super::InvalidWeights;
use super::PiecewiseConstant1D;
use super::constant::{cumulative, search};
use super::weights::{cell, check, within};
use kaustika_math::{Vec2, lerp};

/// The density that is constant on each cell of a width × height grid over [0, 1)²: first the
/// row by the marginal density, then the column by the conditional one.
#[derive(Clone, Debug)]
pub struct PiecewiseConstant2D {
    width: usize,
    rows: PiecewiseConstant1D,
    /// Conditional cumulative functions, width + 1 values a row.
    cdf: Vec<f32>,
    /// The density in each cell.
    pdf: Vec<f32>,
}

impl PiecewiseConstant2D {
    /// With densities proportional to `weights`, given row by row (first index along x).
    ///
    /// # Errors
    /// If there are not width × height > 0 weights, an invalid one or no positive one.
    pub fn new(weights: &[f32], width: usize, height: usize) -> Result<Self, InvalidWeights> {
        let expected = width.saturating_mul(height);
        if expected == 0 || weights.len() != expected {
            return Err(InvalidWeights::Shape { expected: expected.max(1), found: weights.len() });
        }
        let sum = check(weights)?;
        let mut row_sums = Vec::with_capacity(height);
        let mut cdf = Vec::with_capacity((width + 1) * height);
        for row in weights.chunks_exact(width) {
            let row_sum: f64 = row.iter().map(|&w| f64::from(w)).sum();
            row_sums.push((row_sum / sum) as f32);
            // A row of zeros is never chosen; its table must only be free of NaN.
            cdf.extend(cumulative(row, if row_sum > 0.0 { row_sum } else { 1.0 }));
        }
        let scale = expected as f64 / sum;
        Ok(PiecewiseConstant2D {
            width,
            rows: PiecewiseConstant1D::new(&row_sums)?,
            cdf,
            pdf: weights.iter().map(|&w| (f64::from(w) * scale) as f32).collect(),
        })
    }

    fn row_cdf(&self, row: usize) -> &[f32] {
        &self.cdf[row * (self.width + 1)..(row + 1) * (self.width + 1)]
    }

    /// A point and its density; `u` in [0, 1)².
    #[inline]
    pub fn sample(&self, u: Vec2) -> (Vec2, f32) {
        let (y, _, row) = self.rows.sample(u.y);
        let (column, t) = search(self.row_cdf(row), u.x);
        let x = within(column, t, self.width);
        (Vec2::new(x, y), self.pdf[row * self.width + column])
    }

    /// The density at `p`; 0 outside [0, 1)².
    #[inline]
    pub fn pdf(&self, p: Vec2) -> f32 {
        let inside = (0.0..1.0).contains(&p.x) && (0.0..1.0).contains(&p.y);
        if !inside {
            return 0.0;
        }
        let row = cell(p.y, self.pdf.len() / self.width);
        self.pdf[row * self.width + cell(p.x, self.width)]
    }

    /// The numbers that give `p`. Where the density is zero a neighbour's.
    pub fn invert(&self, p: Vec2) -> Vec2 {
        let cdf = self.row_cdf(cell(p.y.clamp(0.0, 1.0), self.pdf.len() / self.width));
        let scaled = p.x.clamp(0.0, 1.0) * self.width as f32;
        let i = (scaled as usize).min(self.width - 1);
        Vec2::new(lerp(scaled - i as f32, cdf[i], cdf[i + 1]), self.rows.invert(p.y))
    }
}
