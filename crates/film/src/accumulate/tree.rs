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

/// The sum of some passes.
#[derive(Clone, Debug)]
pub struct Total {
    /// How many.
    pub passes: u64,
    /// Sum of their weights.
    weight: f32,
    sum: Vec<f32>,
    m2: Vec<f32>,
    layers: Layers,
}

impl Total {
    /// Mean colour of pixel `i`: Σ w x / Σ w.
    #[inline]
    pub fn rgb(&self, i: usize) -> [f32; 3] {
        let at = i * self.layers.stride();
        let inv = 1.0 / self.weight(i);
        std::array::from_fn(|c| self.sum[at + c] * inv)
    }

    /// Mean of the numbers at `offset` of pixel `i`.
    #[inline]
    pub fn value(&self, i: usize, offset: usize) -> f32 {
        self.sum[i * self.layers.stride() + offset] / self.weight(i)
    }

    /// The number at `offset` of pixel `i` that names something.
    #[inline]
    pub fn id(&self, i: usize, offset: usize) -> f32 {
        self.sum[i * self.layers.stride() + offset]
    }

    /// Variance of one pass's colour at pixel `i`, or of one of the passes' mean weight; zero for
    /// fewer than two passes.
    #[inline]
    pub fn variance(&self, i: usize) -> [f32; 3] {
        let n = self.passes.max(2) as f32;
        let mean_weight = self.weight / self.passes as f32;
        std::array::from_fn(|c| self.m2[3 * i + c] / ((n - 1.0) * mean_weight))
    }

    /// Σ of the filter weights, or of the passes' weights where nothing carries one.
    fn weight(&self, i: usize) -> f32 {
        let w = self.sum[i * self.layers.stride() + 3];
        if w == 0.0 { self.weight } else { w }
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
mod tests {
    use super::*;
    use crate::accumulate::{Feature, PixelRecord};

    fn pass(i: u64) -> PassImage {
        let mut image = PassImage::new(5, 3, Layers::new(&[Feature::Depth, Feature::ShapeId]));
        for band in &mut image.bands(2) {
            for y in 0..band.height() {
                for x in 0..band.width() {
                    let h = kaustika_math::mix_bits(i * 100 + (band.y + y) as u64 * 10 + x as u64);
                    let v = (h % 1_000_003) as f32 / 7919.0;
                    let r = PixelRecord {
                        rgb: [v, v * v, 1.0 / (v + 1.0)],
                        weight: 1.0,
                        depth: v,
                        shape: (h % 5) as u32,
                        ..PixelRecord::default()
                    };
                    band.add(x, y, &r);
                }
            }
        }
        image
    }

    fn tree(passes: impl IntoIterator<Item = u64>) -> PassTree {
        let mut t = PassTree::new(5, 3, Layers::new(&[Feature::Depth, Feature::ShapeId]));
        for p in passes {
            t.push(p, pass(p)).unwrap();
        }
        t
    }

    #[test]
    fn shares_merge_to_the_single_run_bit_for_bit() {
        let whole = tree(0..13);
        for cuts in [[3u64, 8], [1, 2], [5, 12]] {
            let mut merged = tree(cuts[1]..13);
            merged.merge(tree(0..cuts[0])).unwrap();
            merged.merge(tree(cuts[0]..cuts[1])).unwrap();
            assert_eq!(merged, whole);
        }
        assert_eq!(whole.ranges(), vec![[0, 13]]);
        assert_eq!((whole.passes(), whole.next_missing(0)), (13, 13));
    }

    #[test]
    fn chains_give_the_bits_of_one_join_after_another() {
        // Sums and M2 of 8 passes by definition: pairs of pairs of pairs, left before right.
        let layers = Layers::new(&[Feature::Depth, Feature::ShapeId]);
        let (stride, ids) = (layers.stride(), ids(&layers));
        let mut nodes: Vec<(Vec<f32>, Vec<f32>)> =
            (0..8).map(|i| (pass(i).data().to_vec(), vec![0.0; 45])).collect();
        for level in 0..3 {
            let pairs = nodes.chunks(2).map(|pair| {
                let [(mut sum, mut m2), (s, m)] = [pair[0].clone(), pair[1].clone()];
                let mut left = Part { sum: &mut sum, m2: &mut m2 };
                add(&mut left, (1 << level) as f32, (&s, &m), (1 << level) as f32, &ids);
                (sum, m2)
            });
            nodes = pairs.collect();
        }
        let whole = tree(0..8);
        assert_eq!(whole.nodes().len(), 1);
        assert_eq!((whole.nodes()[0].sum.len(), whole.nodes()[0].level), (15 * stride, 3));
        assert!(whole.nodes()[0].sum == nodes[0].0 && whole.nodes()[0].m2 == nodes[0].1);
    }

    #[test]
    fn blank_images_are_black_whatever_their_memory_held() {
        let mut t = tree(0..6);
        for p in 6..9 {
            let image = t.blank();
            assert_eq!((image.width(), image.height()), (5, 3));
            assert!(image.data().len() == pass(0).data().len());
            assert!(image.data().iter().all(|v| *v == 0.0));
            t.push(p, pass(p)).unwrap();
        }
        assert_eq!(t, tree(0..9));
    }

    #[test]
    fn order_of_arrival_does_not_matter() {
        assert_eq!(tree([4, 0, 2, 1, 3, 6, 5]), tree(0..7));
    }

    #[test]
    fn overlaps_and_other_sizes_are_refused() {
        let mut t = tree(0..4);
        assert_eq!(t.merge(tree(3..5)), Err(MergeError::Overlap(3)));
        let other = PassTree::new(4, 3, Layers::new(&[]));
        assert_eq!(tree(0..2).merge(other), Err(MergeError::Layout));
    }

    #[test]
    fn passes_count_by_their_weights() {
        // Weights 1 and 3 by turns: as if every second pass had come three times.
        let weight = |p: u64| if p.is_multiple_of(2) { 1.0 } else { 3.0 };
        let layers = Layers::new(&[Feature::Depth, Feature::ShapeId]);
        let mut t = PassTree::new(5, 3, layers);
        for p in 0..11 {
            t.push_weighted(p, pass(p), weight(p)).unwrap();
        }
        let total = t.total().unwrap();
        let stride = total.layers.stride();
        for pixel in 0..15 {
            let x = |p: u64| f64::from(pass(p).data()[pixel * stride]);
            let w = |p: u64| f64::from(weight(p));
            let all: f64 = (0..11).map(w).sum();
            let mean = (0..11).map(|p| w(p) * x(p)).sum::<f64>() / all;
            let m2 = (0..11).map(|p| w(p) * (x(p) - mean).powi(2)).sum::<f64>();
            assert!((f64::from(total.rgb(pixel)[0]) / mean - 1.0).abs() < 1e-5);
            let variance = m2 / 10.0 / (all / 11.0);
            assert!((f64::from(total.variance(pixel)[0]) / variance - 1.0).abs() < 1e-4);
            let depth = total.value(pixel, total.layers.offset(Feature::Depth).unwrap());
            assert!((f64::from(depth) / mean - 1.0).abs() < 1e-5);
            let shape = total.layers.offset(Feature::ShapeId).unwrap();
            assert_eq!(total.id(pixel, shape), pass(0).data()[pixel * stride + shape]);
        }
    }

    #[test]
    fn mean_and_variance_are_those_of_the_samples() {
        let n = 37u64;
        let total = tree(0..n).total().unwrap();
        let stride = total.layers.stride();
        for pixel in 0..15 {
            let samples: Vec<f64> = (0..n).map(|p| pass(p).data()[pixel * stride] as f64).collect();
            let mean = samples.iter().sum::<f64>() / n as f64;
            let var = samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1) as f64;
            assert!((total.rgb(pixel)[0] as f64 / mean - 1.0).abs() < 1e-5);
            assert!((total.variance(pixel)[0] as f64 / var - 1.0).abs() < 1e-4);
        }
    }
}
