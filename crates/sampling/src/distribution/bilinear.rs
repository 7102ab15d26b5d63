//! Piecewise bilinear densities on [0, 1]².

use super::guide::Guide;
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
/// without being built (Mitsuba's continuous 2D distributions work so too), between the columns
/// that a table of cutpoints tells (Chen & Asau 1974): a large map lies outside of the caches,
/// and a bisection of its whole rows would wait for memory at each step. Nodes lie on the
/// border: a map with texel centres at half-integers and wrapping columns is passed with its
/// first column repeated, and shifted by half a texel by the caller.
#[derive(Clone, Debug)]
pub struct Bilinear2D {
    width: usize,
    height: usize,
    rows: PiecewiseLinear1D,
    /// Row by row.
    nodes: Vec<Node>,
    /// The integral of each row along x.
    totals: Vec<f32>,
    guide: Guide,
}

/// What the table knows of a node, side by side as it is needed.
#[derive(Clone, Copy, Debug)]
struct Node {
    density: f32,
    /// The row's integral along x up to the node.
    integral: f32,
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
        let mut nodes = Vec::with_capacity(expected);
        for row in values.chunks_exact(width) {
            let density = |v: f32| (f64::from(v) / volume) as f32;
            nodes.push(Node { density: density(row[0]), integral: 0.0 });
            let mut running = 0.0f64;
            for v in row.windows(2) {
                let [left, right] = [density(v[0]), density(v[1])];
                running += 0.5 * (f64::from(left) + f64::from(right)) / (width - 1) as f64;
                nodes.push(Node { density: right, integral: running as f32 });
            }
        }
        let integrals: Vec<f32> = nodes.iter().map(|n| n.integral).collect();
        Ok(Bilinear2D {
            width,
            height,
            rows: PiecewiseLinear1D::new(&row_totals)?,
            nodes,
            totals: integrals.chunks_exact(width).map(|row| row[width - 1]).collect(),
            guide: Guide::new(&integrals, width),
        })
    }

    /// A point and its density; `u` in [0, 1)².
    pub fn sample(&self, u: Vec2) -> (Vec2, f32) {
        let (y, _) = self.rows.sample(u.y);
        let slice = self.slice(y);
        let columns = self.width - 1;
        let target = u.x * slice.total;
        let (column, left, right) = self.column(&slice, u.x);
        let (i0, i1) = (left.integral, right.integral);
        let rest =
            if i1 > i0 { ((target - i0) / (i1 - i0)).clamp(0.0, ONE_MINUS_EPSILON) } else { u.x };
        let t = sample_linear(rest, left.density, right.density);
        let x = within(column, t, columns);
        let t = x * columns as f32 - column as f32;
        (Vec2::new(x, y), lerp(t, left.density, right.density))
    }

    /// The last column whose integral is at most `u` of the slice's total, with something to
    /// its right, and its two nodes.
    #[inline]
    fn column(&self, slice: &Slice, u: f32) -> (usize, Node, Node) {
        let (last, target) = (self.width - 1, u * slice.total);
        let (low, high) = self.guide.bracket(slice.row, u);
        let column = slice.search(target, low, high.min(last));
        let (left, right) = (slice.node(column), slice.node(column + 1));
        // The integrals do not decrease, so it is the one if its two ends say so; rounding may
        // have put the target beside the bracket.
        if (column == 0 || left.integral <= target)
            && (column + 1 == last || right.integral > target)
        {
            return (column, left, right);
        }
        let column = slice.search(target, 0, last);
        (column, slice.node(column), slice.node(column + 1))
    }

    /// The density at `p`; 0 outside [0, 1)².
    pub fn pdf(&self, p: Vec2) -> f32 {
        if !(0.0..1.0).contains(&p.x) || !(0.0..1.0).contains(&p.y) {
            return 0.0;
        }
        let slice = self.slice(p.y);
        let i = cell(p.x, self.width - 1);
        let t = p.x * (self.width - 1) as f32 - i as f32;
        lerp(t, slice.node(i).density, slice.node(i + 1).density)
    }

    /// The numbers that give `p`.
    pub fn invert(&self, p: Vec2) -> Vec2 {
        let p = Vec2::new(p.x.clamp(0.0, 1.0), p.y.clamp(0.0, 1.0));
        let slice = self.slice(p.y);
        let columns = self.width - 1;
        let i = cell(p.x, columns);
        let (left, right) = (slice.node(i), slice.node(i + 1));
        let t = linear_inverse(p.x * columns as f32 - i as f32, left.density, right.density);
        let x = if slice.total > 0.0 {
            lerp(t, left.integral, right.integral) / slice.total
        } else {
            p.x
        };
        Vec2::new(x, self.rows.invert(p.y))
    }

    #[inline]
    fn slice(&self, y: f32) -> Slice<'_> {
        let row = cell(y, self.height - 1);
        let t = y * (self.height - 1) as f32 - row as f32;
        Slice {
            row,
            t,
            total: lerp(t, self.totals[row], self.totals[row + 1]),
            lower: &self.nodes[row * self.width..(row + 1) * self.width],
            upper: &self.nodes[(row + 1) * self.width..(row + 2) * self.width],
        }
    }
}

/// The grid cut at one y, between two rows.
struct Slice<'a> {
    row: usize,
    t: f32,
    /// Its integral along x.
    total: f32,
    lower: &'a [Node],
    upper: &'a [Node],
}

impl Slice<'_> {
    #[inline]
    fn node(&self, i: usize) -> Node {
        let (a, b) = (self.lower[i], self.upper[i]);
        Node {
            density: lerp(self.t, a.density, b.density),
            integral: lerp(self.t, a.integral, b.integral),
        }
    }

    /// The last column of low..high whose integral is at most `target`, or `low`.
    #[inline]
    fn search(&self, target: f32, mut low: usize, mut high: usize) -> usize {
        while high - low > 1 {
            let middle = low.midpoint(high);
            if self.node(middle).integral <= target { low = middle } else { high = middle }
        }
        low
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::mix_bits;

    /// In [0, 1), by number.
    fn uniform(k: usize) -> f32 {
        (mix_bits(k as u64) >> 40) as f32 / (1u64 << 24) as f32
    }

    /// Noise over many magnitudes, a sun, empty rows and columns, flat parts.
    fn tables() -> Vec<(usize, usize, Vec<f32>)> {
        let shapes = [(2, 2), (3, 5), (65, 9), (1025, 4), (70_000, 2)];
        let mut tables = Vec::new();
        for (w, h) in shapes {
            let noise: Vec<f32> = (0..w * h).map(|k| uniform(k).powi(20)).collect();
            let mut sun = vec![1e-3; w * h];
            sun[w + w / 2] = 1e6;
            let gap = |k: usize| k / w == 1 || (k % w) * 3 / w == 1;
            let gaps = (0..w * h).map(|k| if gap(k) { 0.0 } else { 1.0 + k as f32 }).collect();
            let steep = (0..w * h).map(|k| 1e-30f32.powf((k / w) as f32 / h as f32)).collect();
            tables.extend([noise, sun, gaps, steep, vec![1.0; w * h]].map(|t| (w, h, t)));
        }
        tables
    }

    #[test]
    fn the_bracket_changes_no_bit_and_rarely_misses() {
        for (w, h, values) in tables() {
            let d = Bilinear2D::new(&values, w, h).expect("valid");
            let mut missed = 0;
            for i in 0..4000 {
                let (u, v) = (uniform(2 * i), uniform(2 * i + 1));
                let x = if i % 4 == 0 { (u * w as f32).floor() / w as f32 } else { u };
                let y = d.rows.sample(v).0;
                let slice = d.slice(y);
                let target = x * slice.total;
                let (low, high) = d.guide.bracket(slice.row, x);
                assert!(low < high && (high < w || w > 1 << 16), "{w} x {h}");
                let whole = slice.search(target, 0, w - 1);
                missed += usize::from(slice.search(target, low, high.min(w - 1)) != whole);
                let column = d.column(&slice, x).0;
                assert_eq!(column, whole, "{w} x {h}: {x} {y}");
            }
            assert!(missed < 40, "{w} x {h}: {missed}");
        }
    }
}
