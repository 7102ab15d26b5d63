//! A distribution of directions as a quadtree over the sphere (Müller, Gross & Novák 2017, sec. 3.2).
//!
//! ```text
//! p(ω) = d(x, y) / (4 s³),   s = |ωₓ| + |ω_y| + |ω_z|                                       (1)
//! ```
//!
//! The sphere is laid out on the unit square as an octahedron unfolded, for which (1) makes a
//! density d on the square one per solid angle, without a transcendental function (the paper's
//! cylinder keeps areas, and needs two). A quadrant that holds more than a hundredth of all energy
//! is divided. Two trees are kept: one that answers, and one that learns, divided as the records
//! before it asked.

use super::octahedron;
use super::{Directions, LightRecord, LocalDirections};
use crate::saved::saved;
use kaustika_math::{ONE_MINUS_EPSILON, Vec2, Vec3};

/// Share of all energy above which a quadrant is divided (ρ of the paper).
const SHARE: f32 = 0.01;
/// Levels at most.
const DEPTH: usize = 20;

/// Energy by direction.
#[derive(Clone, Debug)]
pub struct Quadtree {
    known: Tree,
    learning: Tree,
}

#[derive(Clone, Debug)]
struct Tree {
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

saved!(Quadtree { known, learning });
saved!(Tree { nodes, records });
saved!(Node { energy, child });

impl Node {
    fn total(&self) -> f32 {
        (self.energy[0] + self.energy[1]) + (self.energy[2] + self.energy[3])
    }
}

impl Default for Quadtree {
    /// Nothing known; learns on a uniform grid of 16 quadrants.
    fn default() -> Self {
        let known = Tree { nodes: vec![Node::default()], records: 0.0 };
        let mut learning = known.clone();
        learning.nodes[0].child = [1, 2, 3, 4];
        learning.nodes.resize(5, Node::default());
        Quadtree { known, learning }
    }
}

impl Quadtree {
    /// Number of nodes of the tree that answers.
    pub fn size(&self) -> usize {
        self.known.nodes.len()
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

    fn add(&mut self, w: Vec3, energy: f32) {
        let mut p = octahedron::to_square(w);
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

    /// Density on the unit square.
    fn density(&self, mut p: Vec2) -> f32 {
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

    fn sample(&self, mut u: Vec2) -> (Vec2, f32) {
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
        let all = self.nodes[0].total();
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
    fn leaves(&self, mut f: impl FnMut(Vec2, f32, f32)) {
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

impl Directions for Quadtree {
    type Local<'a> = &'a Quadtree;

    fn at(&self, _: Vec3) -> Option<&Quadtree> {
        (self.known.nodes[0].total() > 0.0).then_some(self)
    }

    fn learn(&mut self, records: &[LightRecord]) {
        self.learning.records += records.len() as f64;
        for r in records {
            let energy = r.radiance / r.pdf;
            if energy > 0.0 && energy.is_finite() {
                self.learning.add(r.w, energy);
            }
        }
    }

    fn refine(&mut self) {
        if self.learning.nodes[0].total() > 0.0 {
            let next = self.learning.divided();
            self.known = std::mem::replace(&mut self.learning, next);
        }
    }
}

impl LocalDirections for &Quadtree {
    fn sample(&self, u: Vec2) -> (Vec3, f32) {
        let (p, density) = self.known.sample(u);
        let w = octahedron::from_square(p);
        (w, density * octahedron::density(w)) // (1)
    }

    fn pdf(&self, w: Vec3) -> f32 {
        self.known.density(octahedron::to_square(w)) * octahedron::density(w) // (1)
    }

    fn radiance(&self, w: Vec3) -> f32 {
        // Energy over records is ∫ L̄ᵢ dω.
        self.pdf(w) * self.known.nodes[0].total() / self.known.records as f32
    }

    fn irradiance(&self, n: Vec3) -> f32 {
        let mut sum = 0.0;
        self.known.leaves(|corner, size, energy| {
            // The cosine's mean by four points of the leaf.
            let at = |x, y| octahedron::from_square(corner + Vec2::new(x, y) * size);
            let cos = [at(0.25, 0.25), at(0.75, 0.25), at(0.25, 0.75), at(0.75, 0.75)];
            sum += energy * cos.map(|w| w.dot(n).max(0.0)).iter().sum::<f32>() * 0.25;
        });
        sum / self.known.records as f32
    }
}
