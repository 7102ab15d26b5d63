//! A distribution over the unit square as a quadtree (Müller, Gross & Novák 2017, sec. 3.2), learned
//! from weighted points.
//!
//! ```text
//! d(x, y) = Πₗ 4 Eₗ/Σ E          E of the quadrant on level l that the point lies in         (1)
//! ```
//!
//! A quadrant that holds more than a hundredth of all energy is divided. Two trees are kept: one
//! that answers, and one that learns, divided as the points before it asked.

use crate::saved::saved;
use kaustika_math::{ONE_MINUS_EPSILON, Vec2};

/// Share of all energy above which a quadrant is divided (ρ of the paper).
const SHARE: f32 = 0.01;
/// Levels at most.
const DEPTH: usize = 20;

/// Energy by place, as known and as it is being learned.
#[derive(Clone, Debug)]
pub struct Square {
    known: Tree,
    learning: Tree,
}

/// A distribution over the unit square.
#[derive(Clone, Debug)]
pub struct Tree {
    nodes: Vec<Node>,
    /// Records seen, those without energy too.
    records: f64,
}

/// Four quadrants: 0 lower left, 1 lower right, 2 upper left, 3 upper right.
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    energy: [f32; 4],
    /// 0: the quadrant is a leaf.
    child: [u32; 4],
}

saved!(Square { known, learning });
saved!(Tree { nodes, records });
saved!(Node { energy, child });

impl Default for Square {
    /// Nothing known; learns on a uniform grid of 16 quadrants.
    fn default() -> Self {
        let known = Tree { nodes: vec![Node::default()], records: 0.0 };
        let mut learning = known.clone();
        learning.nodes[0].child = [1, 2, 3, 4];
        learning.nodes.resize(5, Node::default());
        Square { known, learning }
    }
}

impl Square {
    /// What is known; `None` as long as that is nothing.
    #[inline]
    pub fn known(&self) -> Option<&Tree> {
        (self.known.total() > 0.0).then_some(&self.known)
    }

    /// Takes in a point of [0, 1]² and its energy, which may be nothing. What [`Square::known`]
    /// says stays as it is.
    pub fn learn(&mut self, p: Vec2, energy: f32) {
        self.learning.records += 1.0;
        if energy > 0.0 && energy.is_finite() {
            self.learning.add(p, energy);
        }
    }

    /// Takes over what was learned, if there was any energy.
    pub fn refine(&mut self) {
        if self.learning.total() > 0.0 {
            let next = self.learning.divided();
            self.known = std::mem::replace(&mut self.learning, next);
        }
    }
}

impl Node {
    fn total(&self) -> f32 {
        (self.energy[0] + self.energy[1]) + (self.energy[2] + self.energy[3])
    }
}

impl Tree {
    /// The quadrant of a node that `p` lies in; `p` is then its place in the quadrant.
    #[inline]
    fn descend(p: &mut Vec2) -> usize {
        let (right, up) = (p.x >= 0.5, p.y >= 0.5);
        p.x = 2.0 * p.x - f32::from(u8::from(right));
        p.y = 2.0 * p.y - f32::from(u8::from(up));
        usize::from(right) + 2 * usize::from(up)
    }

    /// Energy of all points.
    #[inline]
    pub fn total(&self) -> f32 {
        self.nodes[0].total()
    }

    /// Energy of all points over their number.
    pub fn mean(&self) -> f32 {
        self.total() / self.records as f32
    }

    fn add(&mut self, mut p: Vec2, energy: f32) {
        let mut at = 0;
        loop {
            let q = Tree::descend(&mut p);
            let node = &mut self.nodes[at];
            node.energy[q] += energy;
            at = node.child[q] as usize;
            if at == 0 {
                return;
            }
        }
    }

    /// (1)
    #[inline]
    pub fn density(&self, mut p: Vec2) -> f32 {
        let (mut at, mut density) = (0, 1.0);
        loop {
            let node = &self.nodes[at];
            let q = Tree::descend(&mut p);
            let (energy, total) = (node.energy[q], node.total());
            if energy <= 0.0 {
                return 0.0;
            }
            density *= 4.0 * energy / total;
            at = node.child[q] as usize;
            if at == 0 {
                return density;
            }
        }
    }

    /// A point and its density, from uniform numbers.
    #[inline]
    pub fn sample(&self, mut u: Vec2) -> (Vec2, f32) {
        let (mut at, mut density) = (0, 1.0);
        let (mut corner, mut size) = (Vec2::ZERO, 1.0);
        loop {
            let node = &self.nodes[at];
            let (e, total) = (&node.energy, node.total());
            let right = choose(&mut u.x, (e[0] + e[2]) / total, e[1] + e[3] > 0.0);
            let column = e[usize::from(right)] + e[usize::from(right) + 2];
            let lower = e[usize::from(right)] / column;
            let up = choose(&mut u.y, lower, lower < 1.0);
            let q = usize::from(right) + 2 * usize::from(up);
            density *= 4.0 * e[q] / total;
            size *= 0.5;
            corner += Vec2::new(f32::from(u8::from(right)), f32::from(u8::from(up))) * size;
            at = node.child[q] as usize;
            if at == 0 {
                return (corner + u * size, density);
            }
        }
    }

    /// This tree's structure for the next records: divided by its energies, without any.
    fn divided(&self) -> Tree {
        let all = self.total();
        let mut nodes = vec![Node::default()];
        // A node of the new tree, the old one's if it goes so deep, its energy and depth.
        let mut open = vec![(0, Some(0), all, 1)];
        while let Some((new, old, energy, depth)) = open.pop() {
            let of_old = old.map(|i: usize| self.nodes[i]);
            for q in 0..4 {
                let part = of_old.map_or(0.25 * energy, |node| node.energy[q]);
                if part > SHARE * all && depth < DEPTH {
                    let child = of_old.map(|node| node.child[q] as usize).filter(|&c| c != 0);
                    nodes[new].child[q] = nodes.len() as u32;
                    open.push((nodes.len(), child, part, depth + 1));
                    nodes.push(Node::default());
                }
            }
        }
        Tree { nodes, records: 0.0 }
    }

    /// Calls `f` with place, size and energy of every leaf.
    pub fn leaves(&self, mut f: impl FnMut(Vec2, f32, f32)) {
        let mut open = vec![(0usize, Vec2::ZERO, 1.0)];
        while let Some((at, corner, size)) = open.pop() {
            let (node, half) = (&self.nodes[at], 0.5 * size);
            for q in 0..4 {
                let corner = corner + Vec2::new((q % 2) as f32, (q / 2) as f32) * half;
                match node.child[q] as usize {
                    0 => f(corner, half, node.energy[q]),
                    child => open.push((child, corner, half)),
                }
            }
        }
    }
}

/// True with probability 1 - `p`; `u` is uniform again. Never what has no probability.
#[inline]
fn choose(u: &mut f32, p: f32, possible: bool) -> bool {
    let second = possible && *u >= p;
    *u = if second { (*u - p) / (1.0 - p) } else { *u / p };
    *u = u.min(ONE_MINUS_EPSILON);
    second
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::mix_bits;

    #[test]
    fn squares_draw_what_they_learned() {
        let number = |i: u64, k: u64| (mix_bits(4 * i + k) >> 40) as f32 / (1u32 << 24) as f32;
        let mut square = Square::default();
        assert!(square.known().is_none());
        for pass in 0..4u64 {
            for i in 0..20_000 {
                let i = 20_000 * pass + i;
                let p = Vec2::new(number(i, 0), number(i, 1));
                // Nothing at all on the left.
                let energy = if p.x < 0.25 { 0.0 } else { 1.0 + 100.0 * p.y.powi(20) };
                square.learn(p, energy);
            }
            square.refine();
        }
        let tree = square.known().expect("learned");
        let n = 512;
        let at = |i: i32| (i as f32 + 0.5) / n as f32;
        let whole: f64 =
            (0..n * n).map(|i| f64::from(tree.density(Vec2::new(at(i % n), at(i / n))))).sum();
        assert!((whole / f64::from(n * n) - 1.0).abs() < 1e-3, "{whole}");
        // ∫ = 0.75 (1 + 100/21).
        assert!((tree.mean() / (0.75 * (1.0 + 100.0 / 21.0)) - 1.0).abs() < 0.05);
        let (mut differ, mut above) = (0, 0.0);
        for i in 0..20_000u64 {
            let (p, density) = tree.sample(Vec2::new(number(i, 2), number(i, 3)));
            assert!(p.x >= 0.25 && p.x <= 1.0 && density > 0.0);
            // Other than at the borders of quadrants, where rounding decides.
            differ += u32::from((tree.density(p) / density - 1.0).abs() > 1e-3);
            above += if p.y > 0.75 { 1.0 } else { 0.0 };
        }
        assert!(differ < 5, "{differ}");
        // A share of (0.25 + 100 (1 - 0.75²¹)/21)/(1 + 100/21) = 0.868; five standard errors of
        // the draws and of what was learned.
        assert!((above / 20_000.0 - 0.868f64).abs() < 0.02, "{above}");
    }
}
