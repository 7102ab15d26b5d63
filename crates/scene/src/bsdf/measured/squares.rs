//! Bilinear functions over the unit square that depend on a direction, and warps by them.
//!
//! Between the nodes of a table a function is bilinear; between the directions that tables were
//! measured for, it is the mean of four tables. A density's integrals along rows and over rows
//! are means of those of the tables, so that drawing is exact for the mean, too:
//!
//! ```text
//! R(y) = ∫ p(x, y) dx,   P(y) = ∫₀^y R,   C(x; y) = ∫₀^x p(x', y) dx'                     (1)
//! y = P⁻¹(u_y),   x = C⁻¹(u_x R(y); y)                                                    (2)
//! ```

use crate::description::SquareTable;
use kaustika_math::{Vec2, lerp};
use kaustika_sampling::distribution::{linear_inverse, sample_linear};

/// Four tables and what each counts.
#[derive(Clone, Copy, Debug)]
pub(in crate::bsdf) struct Node {
    pub(super) tables: [usize; 4],
    pub(super) weights: [f32; 4],
}

impl Node {
    /// Around a direction on a grid of azimuths and angles (the second runs faster).
    pub(in crate::bsdf) fn at(phi: (&[f32], f32), theta: (&[f32], f32)) -> Node {
        let (p, tp) = interval(phi.0, phi.1);
        let (t, tt) = interval(theta.0, theta.1);
        let next = |i: usize, n: usize| (i + 1).min(n - 1);
        let (p1, t1) = (next(p, phi.0.len()), next(t, theta.0.len()));
        let columns = theta.0.len();
        Node {
            tables: [p * columns + t, p * columns + t1, p1 * columns + t, p1 * columns + t1],
            weights: [(1.0 - tp) * (1.0 - tt), (1.0 - tp) * tt, tp * (1.0 - tt), tp * tt],
        }
    }

    /// Σ weight · f(table).
    #[inline]
    pub(super) fn mean(&self, f: impl Fn(usize) -> f32) -> f32 {
        (0..4).map(|k| self.weights[k] * f(self.tables[k])).sum()
    }
}

/// The last of increasing `nodes` (at least one) that is not above `x` and has a next, and how far
/// `x` is on the way to that, in [0, 1].
pub(in crate::bsdf) fn interval(nodes: &[f32], x: f32) -> (usize, f32) {
    if nodes.len() < 2 {
        return (0, 0.0);
    }
    let i = nodes.partition_point(|&n| n <= x).clamp(1, nodes.len() - 1) - 1;
    (i, ((x - nodes[i]) / (nodes[i + 1] - nodes[i])).clamp(0.0, 1.0))
}

/// Where a point of the square is among the nodes: of the cell's corner, and within it.
fn cell(table: &SquareTable, p: Vec2) -> ([usize; 2], Vec2) {
    let along = |x: f32, n: usize| {
        let scaled = x.clamp(0.0, 1.0) * (n - 1) as f32;
        let i = (scaled as usize).min(n - 2);
        (i, scaled - i as f32)
    };
    let ((i, x), (j, y)) = (along(p.x, table.width), along(p.y, table.height));
    ([i, j], Vec2::new(x, y))
}

/// The value at a point of grid number `grid`.
#[inline]
pub(super) fn bilinear(table: &SquareTable, grid: usize, p: Vec2) -> f32 {
    let ([i, j], t) = cell(table, p);
    let at = grid * table.width * table.height + j * table.width + i;
    let v = &table.values;
    let low = lerp(t.x, v[at], v[at + 1]);
    lerp(t.y, low, lerp(t.x, v[at + table.width], v[at + table.width + 1]))
}

/// Densities over the square, one for each direction of a grid.
#[derive(Debug)]
pub(in crate::bsdf) struct Densities {
    /// Each integrates to 1.
    table: SquareTable,
    /// C of (1) at the nodes of each row.
    along: Vec<f32>,
    /// P of (1) at each row.
    rows: Vec<f32>,
}

impl Densities {
    /// Proportional to the tables, whose negative values count as zero; uniform where a table has
    /// nothing else.
    pub(in crate::bsdf) fn new(table: &SquareTable) -> Densities {
        let (w, h) = (table.width, table.height);
        let (dx, dy) = (1.0 / (w - 1) as f64, 1.0 / (h - 1) as f64);
        let mut out = Densities {
            table: SquareTable { width: w, height: h, values: Vec::new() },
            along: Vec::new(),
            rows: Vec::new(),
        };
        for grid in table.values.chunks_exact(w * h) {
            let positive = grid.iter().any(|v| *v > 0.0);
            let value = |i: usize| if positive { grid[i].max(0.0) as f64 } else { 1.0 };
            let mut along = vec![0f64; w * h];
            for j in 0..h {
                for i in 1..w {
                    let at = j * w + i;
                    along[at] = along[at - 1] + 0.5 * dx * (value(at - 1) + value(at));
                }
            }
            let end = |j: usize| along[j * w + w - 1];
            let mut rows = vec![0f64; h];
            for j in 1..h {
                rows[j] = rows[j - 1] + 0.5 * dy * (end(j - 1) + end(j));
            }
            // A lone positive value at a corner still gives mass: rows[h - 1] > 0.
            let norm = 1.0 / rows[h - 1];
            out.table.values.extend((0..w * h).map(|i| (value(i) * norm) as f32));
            out.along.extend(along.iter().map(|v| (v * norm) as f32));
            out.rows.extend(rows.iter().map(|v| (v * norm) as f32));
        }
        out
    }

    /// Value, C and P at a node.
    fn value(&self, node: &Node, at: usize) -> f32 {
        let size = self.table.width * self.table.height;
        node.mean(|g| self.table.values[g * size + at])
    }

    fn along(&self, node: &Node, at: usize) -> f32 {
        let size = self.table.width * self.table.height;
        node.mean(|g| self.along[g * size + at])
    }

    fn rows(&self, node: &Node, row: usize) -> f32 {
        node.mean(|g| self.rows[g * self.table.height + row])
    }

    /// C at node `i` between rows `j` and `j + 1`.
    fn between(&self, node: &Node, i: usize, j: usize, y: f32) -> f32 {
        let at = j * self.table.width + i;
        lerp(y, self.along(node, at), self.along(node, at + self.table.width))
    }

    /// Densities at both sides of cell (i, j), `y` of its height.
    fn sides(&self, node: &Node, i: usize, j: usize, y: f32) -> [f32; 2] {
        [i, i + 1].map(|i| {
            let at = j * self.table.width + i;
            lerp(y, self.value(node, at), self.value(node, at + self.table.width))
        })
    }

    /// A point for `u` in [0, 1)²: (2). Its density follows from [`Densities::pdf`].
    pub(in crate::bsdf) fn sample(&self, node: &Node, u: Vec2) -> Vec2 {
        let (w, h) = (self.table.width, self.table.height);
        let j = last_not_above(h - 1, u.y, |j| self.rows(node, j));
        let (low, high) = (self.rows(node, j), self.rows(node, j + 1));
        let [r0, r1] = [j, j + 1].map(|j| self.along(node, j * w + w - 1));
        let y = sample_linear(share(u.y, low, high), r0, r1);
        let target = u.x * lerp(y, r0, r1);
        let i = last_not_above(w - 1, target, |i| self.between(node, i, j, y));
        let (low, high) = (self.between(node, i, j, y), self.between(node, i + 1, j, y));
        let [c0, c1] = self.sides(node, i, j, y);
        let x = sample_linear(share(target, low, high), c0, c1);
        Vec2::new((i as f32 + x) / (w - 1) as f32, (j as f32 + y) / (h - 1) as f32)
    }

    /// The number that [`Densities::sample`] makes `p` of, and the density at `p`.
    pub(super) fn invert(&self, node: &Node, p: Vec2) -> (Vec2, f32) {
        let w = self.table.width;
        let ([i, j], t) = cell(&self.table, p);
        let [c0, c1] = self.sides(node, i, j, t.y);
        let [r0, r1] = [j, j + 1].map(|j| self.along(node, j * w + w - 1));
        let (low, high) = (self.between(node, i, j, t.y), self.between(node, i + 1, j, t.y));
        let x = lerp(linear_inverse(t.x, c0, c1), low, high);
        let row = lerp(t.y, r0, r1);
        let (low, high) = (self.rows(node, j), self.rows(node, j + 1));
        let y = lerp(linear_inverse(t.y, r0, r1), low, high);
        let x = if row > 0.0 { (x / row).min(1.0) } else { t.x };
        (Vec2::new(x, y), lerp(t.x, c0, c1))
    }

    /// The density at `p`.
    pub(in crate::bsdf) fn pdf(&self, node: &Node, p: Vec2) -> f32 {
        node.mean(|grid| bilinear(&self.table, grid, p))
    }
}

/// The last i below `n` with f(i) <= x, for increasing f with f(0) = 0.
fn last_not_above(n: usize, x: f32, f: impl Fn(usize) -> f32) -> usize {
    let (mut low, mut high) = (0, n);
    while high - low > 1 {
        let middle = (low + high) / 2;
        if f(middle) <= x { low = middle } else { high = middle }
    }
    low
}

/// How far `x` is between `low` and `high`.
fn share(x: f32, low: f32, high: f32) -> f32 {
    if high > low { ((x - low) / (high - low)).clamp(0.0, 1.0) } else { 0.5 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Warps have their inverse and their density: that of the inverse's area.
    #[test]
    fn warps_invert() {
        let values = (0..4 * 20).map(|i| ((i * 37) % 11) as f32).collect();
        let table = SquareTable { width: 5, height: 4, values };
        let densities = Densities::new(&table);
        let node = Node::at((&[0.0, 1.0], 0.3), (&[0.0, 2.0], 0.5));
        for i in 0..400 {
            let u = Vec2::new((i % 20) as f32 + 0.5, (i / 20) as f32 + 0.5) * (1.0 / 20.0);
            let p = densities.sample(&node, u);
            let (back, pdf) = densities.invert(&node, p);
            assert!((back - u).length() < 1e-5, "{u:?} {p:?} {back:?}");
            assert!((pdf - densities.pdf(&node, p)).abs() < 1e-5 * pdf);
            // By finite differences.
            let d = 2e-3;
            let at = |dx: f32, dy: f32| densities.invert(&node, p + Vec2::new(dx, dy)).0;
            let (x, y) =
                ((at(d, 0.0) - at(-d, 0.0)) * (0.5 / d), (at(0.0, d) - at(0.0, -d)) * (0.5 / d));
            let area = x.x * y.y - x.y * y.x;
            assert!((area - pdf).abs() < 0.02 * (1.0 + pdf), "{p:?}: {area} {pdf}");
        }
    }
}
