//! The density of a height field's slopes.
//!
//! ```text
//! P(s) by the share of the field's area (seen from above) that slopes by s                 (1)
//! σ(ω) = ∫ P(s) max(0, ω·(-s_x, -s_y, 1)) ds                                                (2)
//! α = √2 root mean square slope, along u and v                                             (3)
//! ```
//!
//! Between the nodes of a square of slopes P is bilinear. (2) is the area of all facets that face ω,
//! projected that way (Smith 1967); were none hidden by others, more than cos θ.

use super::Heights;
use crate::bsdf::measured::{Densities, Node};
use crate::description::SquareTable;
use kaustika_math::{Vec2, Vec3};

/// Nodes along each side of the square.
const NODES: usize = 65;
/// Places of each cell of the field at which it is asked, along each side.
const PLACES: usize = 2;
/// Slopes that are told apart at most, however flat: half the side of the square.
const FLATTEST: f32 = 0.02;

/// P.
#[derive(Debug)]
pub(super) struct Slopes {
    densities: Densities,
    /// Half the sides of the square.
    most: Vec2,
    /// Slopes of the nodes, and their part of (1), but of those without any.
    nodes: Vec<(Vec2, f32)>,
    roughness: f32,
}

/// The one table that there is.
fn node() -> Node {
    Node::at((&[0.0], 0.0), (&[0.0], 0.0))
}

impl Slopes {
    pub(super) fn new(heights: &Heights) -> Slopes {
        let across = heights.n * PLACES;
        let all = (0..across * across).map(|k| {
            let at = |k: usize| (k as f32 + 0.5) / across as f32;
            heights.look(Vec2::new(at(k % across), at(k / across))).1
        });
        let all: Vec<Vec2> = all.collect();
        let most = all
            .iter()
            .fold(Vec2::splat(FLATTEST), |m, s| Vec2::new(m.x.max(s.x.abs()), m.y.max(s.y.abs())));
        let mut values = vec![0.0; NODES * NODES];
        let share = 1.0 / all.len() as f32;
        let (mut x2, mut y2) = (0.0, 0.0);
        for s in &all {
            (x2, y2) = (x2 + s.x * s.x * share, y2 + s.y * s.y * share);
            // To the four nodes around it.
            let along = |s: f32, most: f32| {
                let x = 0.5 * (s / most + 1.0) * (NODES - 1) as f32;
                let i = (x as usize).min(NODES - 2);
                (i, x - i as f32)
            };
            let ((i, x), (j, y)) = (along(s.x, most.x), along(s.y, most.y));
            for (di, wx) in [(0, 1.0 - x), (1, x)] {
                for (dj, wy) in [(0, 1.0 - y), (1, y)] {
                    values[(j + dj) * NODES + i + di] += wx * wy * share; // (1)
                }
            }
        }
        let slope = |k: usize| {
            let at = |k: usize, most: f32| (2.0 * k as f32 / (NODES - 1) as f32 - 1.0) * most;
            Vec2::new(at(k % NODES, most.x), at(k / NODES, most.y))
        };
        let nodes = values.iter().enumerate().filter(|(_, v)| **v > 0.0);
        let nodes = nodes.map(|(k, v)| (slope(k), *v)).collect();
        // A node at the border of the square stands for half a cell.
        let border = |k: usize| if k == 0 || k == NODES - 1 { 2.0 } else { 1.0 };
        for (k, v) in values.iter_mut().enumerate() {
            *v *= border(k % NODES) * border(k / NODES);
        }
        let table = SquareTable { width: NODES, height: NODES, values };
        let roughness = (2.0 * (x2 * y2).sqrt()).sqrt().min(1.0); // (3)
        Slopes { densities: Densities::new(&table), most, nodes, roughness }
    }

    /// P at `s`; nothing outside the square.
    pub(super) fn density(&self, s: Vec2) -> f32 {
        if s.x.abs() > self.most.x || s.y.abs() > self.most.y {
            return 0.0;
        }
        let p = Vec2::new(0.5 * (s.x / self.most.x + 1.0), 0.5 * (s.y / self.most.y + 1.0));
        self.densities.pdf(&node(), p) / (4.0 * self.most.x * self.most.y)
    }

    /// Slopes by P.
    pub(super) fn sample(&self, u: Vec2) -> Vec2 {
        let p = self.densities.sample(&node(), u);
        Vec2::new((2.0 * p.x - 1.0) * self.most.x, (2.0 * p.y - 1.0) * self.most.y)
    }

    /// ∫ P(s) f(s) ds, by the nodes.
    pub(super) fn mean(&self, f: impl Fn(Vec2) -> f32) -> f32 {
        self.nodes.iter().map(|(s, p)| p * f(*s)).sum()
    }

    /// (2).
    pub(super) fn facing(&self, w: Vec3) -> f32 {
        self.mean(|s| (w.z - s.x * w.x - s.y * w.y).max(0.0))
    }

    /// The geometric mean of (3).
    pub(super) fn roughness(&self) -> f32 {
        self.roughness
    }
}
