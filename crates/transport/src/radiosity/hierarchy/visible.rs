//! What is seen of one node from another.
//!
//! ```text
//! δ = 4V(1 - V), at least 1/2(n+1) after n rays                                      (6)
//! ```

use super::{Hierarchy, Node};
use crate::radiosity::mesh::Point;
use crate::radiosity::points::{r2, rotated};
use kaustika_math::{Vec2, Vec3, mix_bits};
use kaustika_sampling::hash::{combine, halves, unit};
use kaustika_scene::RayBatch;
use std::f32::consts::PI;

/// Attempts to find points that face each other, for each ray.
const ATTEMPTS: u32 = 4;

/// What rays between two nodes have found.
pub(super) struct Seen {
    /// V.
    pub v: f32,
    /// δ over p alone.
    pub over_p: f32,
    /// How many there were.
    pub rays: u32,
}

impl Seen {
    /// (6): of p alone, and of both.
    pub fn in_doubt(&self) -> [f32; 2] {
        let least = 0.5 / (self.rays + 1) as f32;
        [self.over_p.max(least), (4.0 * self.v * (1.0 - self.v)).max(least)]
    }

    /// True if all rays agree.
    pub fn agrees(&self) -> bool {
        self.v == 0.0 || self.v == 1.0
    }
}

impl Hierarchy<'_, '_> {
    /// V, by `n` rays between points that face each other, weighted as the kernel is.
    pub(super) fn visible(&self, p: Node, q: Node, n: u32) -> Seen {
        let name = |node: Node| match node {
            Node::Element(e) => u64::from(e),
            Node::Cluster(c) => u64::from(c) | 1 << 32,
        };
        let (low, high) = (name(p).min(name(q)), name(p).max(name(q)));
        let key = mix_bits(mix_bits(low) ^ high);
        let disk = self.area(q) / n as f32;
        let (mut segments, mut weights) = (Vec::with_capacity(n as usize), Vec::new());
        let mut places = Vec::with_capacity(n as usize);
        for i in 0..n * ATTEMPTS {
            let pick = |node, k: u64| {
                let u = rotated(r2(i), combine(key, k));
                self.pick(node, combine(combine(key, k + 2), u64::from(i)), u)
            };
            let (x, y) = (pick(p, 0), pick(q, 1));
            let d = y.p - x.p;
            let (cos_x, cos_y, r2) = (x.n.dot(d), -y.n.dot(d), d.length_squared());
            if cos_x > 0.0 && cos_y > 0.0 {
                segments.push(x.sight(&y));
                weights.push(cos_x * cos_y / (r2 * (PI * r2 + disk)));
                places.push(x.p);
            }
            if segments.len() as u32 == n {
                break;
            }
        }
        let mut batch = RayBatch::default();
        self.scene.occluded_all(&segments, &mut batch);
        let all: f32 = weights.iter().sum();
        let open = weights.iter().zip(&batch.occluded).filter(|(_, hidden)| !**hidden);
        let v = (open.map(|(w, _)| w).sum::<f32>() / all.max(f32::MIN_POSITIVE)).min(1.0);
        let over_p = match p {
            Node::Element(e) if v > 0.0 && v < 1.0 => {
                let corners = &self.mesh.elements[e as usize].corners;
                change(corners, places.iter().copied().zip(batch.occluded.iter().map(|h| !h)))
            }
            _ => 4.0 * v * (1.0 - v),
        };
        Seen { v, over_p, rays: segments.len() as u32 }
    }

    /// A point of a node, uniform over its area.
    fn pick(&self, mut node: Node, mut key: u64, u: Vec2) -> Point {
        while let Node::Cluster(c) = node {
            let [a, b] = self.clusters[c as usize].children;
            let share = self.area(a) / self.clusters[c as usize].area;
            key = mix_bits(key);
            node = if unit(halves(key).0) < share { a } else { b };
        }
        match node {
            Node::Element(e) => self.mesh.sample(self.scene, e, u),
            Node::Cluster(_) => unreachable!("clusters end in elements"),
        }
    }
}

/// How much what is seen of places on a triangle changes between its corners, from 0 to 1: the standard deviation of
/// the parts V_k that are seen near each, twice, without what is chance.
///
/// ```text
/// 4 (1/2 Σ_k (V_k - V)² - V(1 - V)/3 Σ_k 1/n_k)                                      (9)
/// ```
fn change(corners: &[Vec3; 3], seen: impl Iterator<Item = (Vec3, bool)>) -> f32 {
    let (mut open, mut all) = ([0.0f32; 3], [0.0f32; 3]);
    for (x, is_open) in seen {
        let far = |k: usize| (corners[k] - x).length_squared();
        let k = (1..3).fold(0, |best, k| if far(k) < far(best) { k } else { best });
        all[k] += 1.0;
        open[k] += f32::from(is_open);
    }
    if all.contains(&0.0) {
        return 1.0;
    }
    let v = open.iter().sum::<f32>() / all.iter().sum::<f32>();
    let between: f32 = (0..3).map(|k| (open[k] / all[k] - v).powi(2)).sum();
    let chance: f32 = all.iter().map(|n| v * (1.0 - v) / n).sum();
    (4.0 * (0.5 * between - chance / 3.0)).clamp(0.0, 1.0).sqrt() // (9)
}
