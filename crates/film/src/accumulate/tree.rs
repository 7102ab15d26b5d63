//! The aligned binary tree over pass indices.
//!
//! A node of level k holds the passes [m 2ᵏ, (m+1) 2ᵏ); two complete siblings become their
//! parent at once. A range of passes is thus always held by the same few nodes, and every sum
//! is formed in the same order. Beside the sum a node keeps M2 = Σ (x - mean)² of the colour,
//! combined by Chan, Golub & LeVeque 1983:
//!
//! ```text
//! M2 = M2ₐ + M2_b + (mean_b - meanₐ)² wₐ w_b / (wₐ + w_b)                         (1)
//! ```
//!
//! w is the number of passes, or the sum of their weights where a method weighs them.

use super::total::Total;
use super::{Layers, PassImage};
use rayon::prelude::*;
use thiserror::Error;

/// The sum of an aligned power of two of passes.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// First pass.
    pub start: u64,
    /// log2 of the number of passes.
    pub level: u32,
    /// Sum of the passes' weights.
    pub weight: f32,
    /// Sums of all numbers of all pixels.
    pub sum: Vec<f32>,
    /// M2 of weighted r, g, b of all pixels.
    pub m2: Vec<f32>,
}

/// Passes summed so far.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTree {
    width: u32,
    height: u32,
    layers: Layers,
    /// Rising in `start`.
    nodes: Vec<Node>,
    spare: Spare,
}

/// Memory of nodes that were joined to others, for passes to come: fresh memory costs more than
/// the sums. No part of the tree's value.
#[derive(Debug, Default)]
struct Spare {
    sums: Vec<Vec<f32>>,
    m2s: Vec<Vec<f32>>,
}

impl Spare {
    /// Kept of each: enough for most passes, and little beside the nodes of a longer render.
    const KEPT: usize = 2;

    fn keep(&mut self, node: Node) {
        if self.sums.len() < Spare::KEPT {
            self.sums.push(node.sum);
        }
        if self.m2s.len() < Spare::KEPT {
            self.m2s.push(node.m2);
        }
    }
}

impl Clone for Spare {
    fn clone(&self) -> Spare {
        Spare::default()
    }
}

impl PartialEq for Spare {
    fn eq(&self, _: &Spare) -> bool {
        true
    }
}

/// Why two sums can't be joined.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum MergeError {
    /// A pass is in both.
    #[error("pass {0} is in more than one part")]
    Overlap(u64),
    /// Their pixels differ in number or layout.
    #[error("the parts differ in size or layers")]
    Layout,
}

impl Node {
    fn end(&self) -> u64 {
        self.start + (1 << self.level)
    }
}

impl PassTree {
    /// No passes yet.
    pub fn new(width: u32, height: u32, layers: Layers) -> PassTree {
        PassTree { width, height, layers, nodes: Vec::new(), spare: Spare::default() }
    }

    /// From stored nodes, in any order.
    pub fn from_nodes(
        width: u32,
        height: u32,
        layers: Layers,
        nodes: Vec<Node>,
    ) -> Result<PassTree, MergeError> {
        let pixels = width as usize * height as usize;
        let fits = |n: &Node| n.sum.len() == pixels * layers.stride() && n.m2.len() == 3 * pixels;
        if !nodes.iter().all(fits) {
            return Err(MergeError::Layout);
        }
        let mut tree = PassTree { width, height, layers, nodes, spare: Spare::default() };
        tree.tidy()?;
        Ok(tree)
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The layout of a pixel.
    pub fn layers(&self) -> &Layers {
        &self.layers
    }

    /// The nodes, rising in pass index.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Number of passes.
    pub fn passes(&self) -> u64 {
        self.nodes.iter().map(|n| 1u64 << n.level).sum()
    }

    /// The first missing pass from `start` on.
    pub fn next_missing(&self, start: u64) -> u64 {
        let inside = |p: u64| self.nodes.iter().find(|n| n.start <= p && p < n.end());
        let mut p = start;
        while let Some(n) = inside(p) {
            p = n.end();
        }
        p
    }

    /// Passes held, as ranges [a, b) that do not touch.
    pub fn ranges(&self) -> Vec<[u64; 2]> {
        let mut out: Vec<[u64; 2]> = Vec::new();
        for n in &self.nodes {
            match out.last_mut() {
                Some(last) if last[1] == n.start => last[1] = n.end(),
                _ => out.push([n.start, n.end()]),
            }
        }
        out
    }

    /// A black image of this tree's size and layers for the next pass.
    pub fn blank(&mut self) -> PassImage {
        let sum = self.spare.sums.pop().unwrap_or_default();
        PassImage::reusing(sum, self.width, self.height, self.layers.clone())
    }

    /// Adds a pass. Its image must have this tree's size and layers.
    pub fn push(&mut self, pass: u64, image: PassImage) -> Result<(), MergeError> {
        self.push_weighted(pass, image, 1.0)
    }

    /// As [`PassTree::push`], of a pass that counts as `weight` passes, above 0.
    pub fn push_weighted(
        &mut self,
        pass: u64,
        mut image: PassImage,
        weight: f32,
    ) -> Result<(), MergeError> {
        if (image.width(), image.height()) != (self.width, self.height)
            || image.layers() != &self.layers
        {
            return Err(MergeError::Layout);
        }
        if weight != 1.0 {
            image.scale(weight, &ids(&self.layers));
        }
        let mut m2 = self.spare.m2s.pop().unwrap_or_default();
        m2.clear();
        m2.resize(3 * self.width as usize * self.height as usize, 0.0);
        self.nodes.push(Node { start: pass, level: 0, weight, sum: image.into_data(), m2 });
        self.tidy()
    }

    /// Adds the passes of another tree.
    pub fn merge(&mut self, other: PassTree) -> Result<(), MergeError> {
        if (other.width, other.height) != (self.width, self.height) || other.layers != self.layers {
            return Err(MergeError::Layout);
        }
        self.nodes.extend(other.nodes);
        self.tidy()
    }

    /// Restores order and joins siblings.
    fn tidy(&mut self) -> Result<(), MergeError> {
        self.nodes.sort_by_key(|n| n.start);
        if let Some(w) = self.nodes.windows(2).find(|w| w[0].end() > w[1].start) {
            return Err(MergeError::Overlap(w[1].start));
        }
        let mut joined: Vec<Node> = Vec::with_capacity(self.nodes.len());
        for node in self.nodes.drain(..) {
            joined.push(node);
            let chain = chain_at_end(&joined);
            if chain > 1 {
                let mut nodes = joined.split_off(joined.len() - chain);
                join(&mut nodes, &self.layers);
                let mut nodes = nodes.into_iter();
                joined.extend(nodes.next());
                nodes.for_each(|n| self.spare.keep(n));
            }
        }
        self.nodes = joined;
        Ok(())
    }

    /// The sum over all passes held, nodes taken from left to right; `None` without passes.
    pub fn total(&self) -> Option<Total> {
        let mut nodes = self.nodes.iter();
        let first = nodes.next()?;
        let mut total = Total {
            passes: 1 << first.level,
            weight: first.weight,
            sum: first.sum.clone(),
            m2: first.m2.clone(),
            layers: self.layers.clone(),
        };
        let ids = ids(&self.layers);
        for n in nodes {
            let count = 1u64 << n.level;
            let stride = PIXELS * self.layers.stride();
            let parts = total.sum.par_chunks_mut(stride).zip(total.m2.par_chunks_mut(PIXELS * 3));
            let others = n.sum.par_chunks(stride).zip(n.m2.par_chunks(PIXELS * 3));
            let weight = total.weight;
            parts.zip(others).for_each(|((sum, m2), other)| {
                add(&mut Part { sum, m2 }, weight, other, n.weight, &ids);
            });
            total.passes += count;
            total.weight += n.weight;
        }
        Some(total)
    }
}

/// How many of the last nodes become one: the last and its left sibling their parent, that and
/// its left sibling theirs, and so on.
fn chain_at_end(nodes: &[Node]) -> usize {
    let Some(last) = nodes.last() else { return 0 };
    let (mut start, mut level, mut count) = (last.start, last.level, 1);
    for left in nodes.iter().rev().skip(1) {
        let paired =
            left.level == level && left.end() == start && left.start.is_multiple_of(2 << level);
        if !paired {
            break;
        }
        (start, level, count) = (left.start, level + 1, count + 1);
    }
    count
}

/// Joins a chain of [`chain_at_end`] from right to left into its first node. All of it is done
/// for some pixels before the next ones, so that what is between the ends stays in the cache.
fn join(chain: &mut [Node], layers: &Layers) {
    let pixels = chain.first().map_or(0, |n| n.m2.len() / 3);
    let weights: Vec<f32> = chain.iter().map(|n| n.weight).collect();
    let mut columns: Vec<Vec<Part>> = Vec::new();
    columns.resize_with(pixels.div_ceil(PIXELS), Vec::new);
    for node in chain.iter_mut() {
        let parts =
            node.sum.chunks_mut(PIXELS * layers.stride()).zip(node.m2.chunks_mut(PIXELS * 3));
        for (column, (sum, m2)) in columns.iter_mut().zip(parts) {
            column.push(Part { sum, m2 });
        }
    }
    let ids = ids(layers);
    columns.into_par_iter().for_each(|mut column| {
        let mut weights = weights.clone();
        let Some(mut right) = column.pop() else { return };
        let mut of_right = weights.pop().unwrap_or_default();
        while let (Some(mut left), Some(weight)) = (column.pop(), weights.pop()) {
            add(&mut left, weight, (&*right.sum, &*right.m2), of_right, &ids);
            of_right += weight;
            right = left;
        }
    });
    chain[0].weight = weights.iter().rev().copied().reduce(|a, b| a + b).unwrap_or_default();
    chain[0].level += 1;
}

/// Pixels that are summed together.
const PIXELS: usize = 1024;

/// Some pixels of a node.
struct Part<'a> {
    sum: &'a mut [f32],
    m2: &'a mut [f32],
}

/// For each number of a pixel whether it names something.
fn ids(layers: &Layers) -> Vec<bool> {
    let mut ids = vec![false; layers.stride()];
    for f in layers.features().iter().filter(|f| f.is_id()) {
        if let Some(at) = layers.offset(*f) {
            ids[at] = true;
        }
    }
    ids
}

/// a += b, of passes of weights `na` and `nb`, pixel by pixel; numbers that name something stay.
fn add(a: &mut Part, na: f32, b: (&[f32], &[f32]), nb: f32, ids: &[bool]) {
    let k = na * nb / (na + nb);
    let (inv_a, inv_b) = (1.0 / na, 1.0 / nb);
    let stride = ids.len();
    let pixels = a.sum.chunks_exact_mut(stride).zip(a.m2.chunks_exact_mut(3));
    let others = b.0.chunks_exact(stride).zip(b.1.chunks_exact(3));
    for ((pa, qa), (pb, qb)) in pixels.zip(others) {
        for c in 0..3 {
            let delta = pb[c] * inv_b - pa[c] * inv_a;
            qa[c] += qb[c] + delta * delta * k; // (1)
        }
        for c in 0..4 {
            pa[c] += pb[c];
        }
        for c in 4..stride {
            if !ids[c] {
                pa[c] += pb[c];
            }
        }
    }
}

#[cfg(test)]
mod tests;
