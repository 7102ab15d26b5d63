//! Piecewise constant densities on [0, 1)².

use super::InvalidWeights;
use super::PiecewiseConstant1D;
use super::constant::{cumulative, search_among};
use super::weights::{cell, check, within};
use kaustika_math::{Vec2, lerp};

/// Columns a cutpoint, about.
const COLUMNS: usize = 8;

/// The density that is constant on each cell of a width × height grid over [0, 1)²: first the
/// row by the marginal density, then the column by the conditional one.
#[derive(Clone, Debug)]
pub struct PiecewiseConstant2D {
    width: usize,
    rows: PiecewiseConstant1D,
    /// Conditional cumulative functions, width + 1 values a row.
    cdf: Vec<f32>,
    /// Cutpoints (Chen & Asau 1974): for k/parts, k = 0 to parts, how many values of a row's
    /// function are at most that; parts + 1 a row. A search begins between two of them, for the
    /// functions leave the cache that these stay in.
    cuts: Vec<u32>,
    /// A power of two, so that u parts is exact, and the search's answer that of the whole row.
    parts: usize,
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
        let parts = width.div_ceil(COLUMNS).next_power_of_two();
        let mut cuts = Vec::with_capacity((parts + 1) * height);
        for row in weights.chunks_exact(width) {
            let row_sum: f64 = row.iter().map(|&w| f64::from(w)).sum();
            row_sums.push((row_sum / sum) as f32);
            // A row of zeros is never chosen; its table must only be free of NaN.
            let start = cdf.len();
            cdf.extend(cumulative(row, if row_sum > 0.0 { row_sum } else { 1.0 }));
            let row = &cdf[start..];
            let at_most = |u: f32| row.partition_point(|&c| c <= u) as u32;
            cuts.extend((0..=parts).map(|k| at_most(k as f32 / parts as f32)));
        }
        let scale = expected as f64 / sum;
        Ok(PiecewiseConstant2D {
            width,
            rows: PiecewiseConstant1D::new(&row_sums)?,
            cdf,
            cuts,
            parts,
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
        let k = ((u.x * self.parts as f32) as usize).min(self.parts - 1);
        let cuts = &self.cuts[row * (self.parts + 1)..(row + 1) * (self.parts + 1)];
        let (column, t) =
            search_among(self.row_cdf(row), u.x, cuts[k] as usize..cuts[k + 1] as usize);
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

#[cfg(test)]
mod tests {
    use super::super::constant::search;
    use super::*;
    use kaustika_math::mix_bits;

    /// Cutpoints change no sample: numbers at and beside them, cells and rows of zeros.
    #[test]
    fn the_search_between_cutpoints_is_that_of_the_whole_row() {
        let number = |i: usize| (mix_bits(i as u64) >> 40) as f32 / (1u64 << 24) as f32;
        for width in [1, 2, 7, 8, 9, 64, 65, 200, 512] {
            let height = 5;
            let weight = |i: usize| match i / width {
                3 => 0.0,
                row if (i + row).is_multiple_of(3) => 0.0,
                row => number(i).powi(1 << (2 * row)),
            };
            let mut weights: Vec<f32> = (0..width * height).map(weight).collect();
            weights[0] = 1.0;
            let d = PiecewiseConstant2D::new(&weights, width, height).expect("one is positive");
            let cuts = (0..=64).map(|k| k as f32 / 64.0);
            let beside = cuts.flat_map(|c| [c.next_down(), c, c.next_up()]);
            for (i, ux) in beside.chain((0..1000).map(number)).enumerate() {
                let u = Vec2::new(ux.clamp(0.0, 1.0), number(i + 5000));
                let (y, _, row) = d.rows.sample(u.y);
                let (column, t) = search(d.row_cdf(row), u.x);
                let whole = Vec2::new(within(column, t, width), y);
                assert_eq!(d.sample(u).0, whole, "{width} {u:?}");
            }
        }
    }
}
