//! Piecewise bilinear densities on [0, 1]².

use super::inversion::{linear_inverse, sample_linear};
use super::weights::{cell, check, within};
use super::{InvalidWeights, PiecewiseLinear1D};
use kaustika_math::{ONE_MINUS_EPSILON, Vec2, lerp};

/// The density that interpolates bilinearly between the nodes of a width × height grid over
/// [0, 1]², sampled exactly: proportional to the luminance of an environment map that is
/// looked up bilinearly, which a piecewise constant table is not.
///
/// The marginal along y is piecewise linear in the rows' integrals. Given y, the cumulative
/// function along x is the interpolation of those of the two rows, so it is searched
/// without being built (Mitsuba's continuous 2D distributions work so too). Nodes lie on the
/// border: a map with texel centres at half-integers and wrapping columns is passed with its
/// first column repeated, and shifted by half a texel by the caller.
#[derive(Clone, Debug)]
pub struct Bilinear2D {
    width: usize,
    height: usize,
    rows: PiecewiseLinear1D,
    /// The density at the nodes, row by row.
    nodes: Vec<f32>,
    /// Running integrals of the rows along x, from 0, `width` values a row.
    integrals: Vec<f32>,
}

impl Bilinear2D {
    /// With densities at the nodes proportional to `values`, given row by row (first index along
    /// x), at least two in each direction.
    ///
    /// # Errors
    /// If there are not width × height values with both at least 2, an invalid one or no
    /// positive one.
    pub fn new(values: &[f32], width: usize, height: usize) -> Result<Self, InvalidWeights> {
        let expected = width.saturating_mul(height);
        if width < 2 || height < 2 || values.len() != expected {
            let expected = expected.max(4);
            return Err(InvalidWeights::Shape { expected, found: values.len() });
        }
        check(values)?;
        let row_integral = |row: &[f32]| {
            row.windows(2).map(|v| 0.5 * (f64::from(v[0]) + f64::from(v[1]))).sum::<f64>()
                / (width - 1) as f64
        };
        let totals: Vec<f64> = values.chunks_exact(width).map(row_integral).collect();
        let volume =
            totals.windows(2).map(|v| 0.5 * (v[0] + v[1])).sum::<f64>() / (height - 1) as f64;
        let row_totals: Vec<f32> = totals.iter().map(|t| (t / volume) as f32).collect();
        let nodes: Vec<f32> = values.iter().map(|&v| (f64::from(v) / volume) as f32).collect();
        let mut integrals = Vec::with_capacity(expected);
        for row in nodes.chunks_exact(width) {
            let mut running = 0.0f64;
            integrals.push(0.0);
            for v in row.windows(2) {
                running += 0.5 * (f64::from(v[0]) + f64::from(v[1])) / (width - 1) as f64;
                integrals.push(running as f32);
            }
        }
        Ok(Bilinear2D {
            width,
            height,
            rows: PiecewiseLinear1D::new(&row_totals)?,
            nodes,
            integrals,
        })
    }

    /// A point and its density; `u` in [0, 1)².
    pub fn sample(&self, u: Vec2) -> (Vec2, f32) {
        let (y, _) = self.rows.sample(u.y);
        let slice = self.slice(y);
        let columns = self.width - 1;
        let target = u.x * slice.integral(columns);
        // The last column whose integral is at most the target, with something to its right.
        let (mut low, mut high) = (0, columns);
        while high - low > 1 {
            let middle = low.midpoint(high);
            if slice.integral(middle) <= target { low = middle } else { high = middle }
        }
        let (i0, i1) = (slice.integral(low), slice.integral(low + 1));
        let rest =
            if i1 > i0 { ((target - i0) / (i1 - i0)).clamp(0.0, ONE_MINUS_EPSILON) } else { u.x };
        let t = sample_linear(rest, slice.node(low), slice.node(low + 1));
        let p = Vec2::new(within(low, t, columns), y);
        (p, self.pdf(p))
    }

    /// The density at `p`; 0 outside [0, 1)².
    pub fn pdf(&self, p: Vec2) -> f32 {
        if !(0.0..1.0).contains(&p.x) || !(0.0..1.0).contains(&p.y) {
            return 0.0;
        }
        let slice = self.slice(p.y);
        let i = cell(p.x, self.width - 1);
        lerp(p.x * (self.width - 1) as f32 - i as f32, slice.node(i), slice.node(i + 1))
    }

    /// The numbers that give `p`.
    pub fn invert(&self, p: Vec2) -> Vec2 {
        let p = Vec2::new(p.x.clamp(0.0, 1.0), p.y.clamp(0.0, 1.0));
        let slice = self.slice(p.y);
        let columns = self.width - 1;
        let i = cell(p.x, columns);
        let t = linear_inverse(p.x * columns as f32 - i as f32, slice.node(i), slice.node(i + 1));
        let total = slice.integral(columns);
        let x = if total > 0.0 {
            lerp(t, slice.integral(i), slice.integral(i + 1)) / total
        } else {
            p.x
        };
        Vec2::new(x, self.rows.invert(p.y))
    }

    fn slice(&self, y: f32) -> Slice<'_> {
        let row = cell(y, self.height - 1);
        let both = row * self.width..(row + 2) * self.width;
        Slice {
            width: self.width,
            t: y * (self.height - 1) as f32 - row as f32,
            nodes: &self.nodes[both.clone()],
            integrals: &self.integrals[both],
        }
    }
}

/// The grid cut at one y, between two rows.
struct Slice<'a> {
    width: usize,
    t: f32,
    nodes: &'a [f32],
    integrals: &'a [f32],
}

impl Slice<'_> {
    #[inline]
    fn node(&self, i: usize) -> f32 {
        lerp(self.t, self.nodes[i], self.nodes[i + self.width])
    }

    #[inline]
    fn integral(&self, i: usize) -> f32 {
        lerp(self.t, self.integrals[i], self.integrals[i + self.width])
    }
}
