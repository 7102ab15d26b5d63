//! The aligned binary tree over pass indices.
//!
//! A node of level k holds the passes [m 2ᵏ, (m+1) 2ᵏ); two complete siblings become their
//! parent at once. A range of passes is thus always held by the same few nodes, and every sum
//! is formed in the same order. Beside the sum a node keeps M2 = Σ (x - mean)² of the colour,
//! combined by Chan, Golub & LeVeque 1983:
//!
//! ```text
//! M2 = M2ₐ + M2_b + (mean_b - meanₐ)² nₐ n_b / (nₐ + n_b)                         (1)
//! ```

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

    /// True if `next` is this node's right sibling.
    fn pairs_with(&self, next: &Node) -> bool {
        self.level == next.level
            && self.end() == next.start
            && self.start.is_multiple_of(2 << self.level)
    }
}

impl PassTree {
    /// No passes yet.
    pub fn new(width: u32, height: u32, layers: Layers) -> PassTree {
        PassTree { width, height, layers, nodes: Vec::new() }
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
        let mut tree = PassTree { width, height, layers, nodes };
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

    /// Adds a pass. Its image must have this tree's size and layers.
    pub fn push(&mut self, pass: u64, image: PassImage) -> Result<(), MergeError> {
        if (image.width(), image.height()) != (self.width, self.height)
            || image.layers() != &self.layers
        {
            return Err(MergeError::Layout);
        }
        let m2 = vec![0.0; 3 * self.width as usize * self.height as usize];
        self.nodes.push(Node { start: pass, level: 0, sum: image.into_data(), m2 });
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
            while let [.., a, b] = &joined[..] {
                if !a.pairs_with(b) {
                    break;
                }
                let (Some(b), Some(a)) = (joined.pop(), joined.pop()) else { break };
                joined.push(join(a, b, &self.layers));
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
            sum: first.sum.clone(),
            m2: first.m2.clone(),
            layers: self.layers.clone(),
        };
        for n in nodes {
            let count = 1u64 << n.level;
            add(
                (&mut total.sum, &mut total.m2, total.passes),
                (&n.sum, &n.m2, count),
                &self.layers,
            );
            total.passes += count;
        }
        Some(total)
    }
}

/// The sum of some passes.
#[derive(Clone, Debug)]
pub struct Total {
    /// How many.
    pub passes: u64,
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

    /// Variance of one pass's colour at pixel `i`; zero for fewer than two passes.
    #[inline]
    pub fn variance(&self, i: usize) -> [f32; 3] {
        let n = self.passes.max(2) as f32;
        std::array::from_fn(|c| self.m2[3 * i + c] / (n - 1.0))
    }

    /// Σ of the filter weights, or the number of passes where nothing carries a weight.
    fn weight(&self, i: usize) -> f32 {
        let w = self.sum[i * self.layers.stride() + 3];
        if w == 0.0 { self.passes as f32 } else { w }
    }
}

fn join(mut a: Node, b: Node, layers: &Layers) -> Node {
    let count = 1u64 << a.level;
    add((&mut a.sum, &mut a.m2, count), (&b.sum, &b.m2, count), layers);
    a.level += 1;
    a
}

/// a += b, pixel by pixel: the same operations in the same order on any number of threads.
fn add(a: (&mut [f32], &mut [f32], u64), b: (&[f32], &[f32], u64), layers: &Layers) {
    const PIXELS: usize = 4096;
    let stride = layers.stride();
    let (na, nb) = (a.2 as f32, b.2 as f32);
    let k = na * nb / (na + nb);
    let (inv_a, inv_b) = (1.0 / na, 1.0 / nb);
    let mut ids = vec![false; stride];
    for f in layers.features().iter().filter(|f| f.is_id()) {
        if let Some(at) = layers.offset(*f) {
            ids[at] = true;
        }
    }
    a.0.par_chunks_mut(PIXELS * stride)
        .zip(a.1.par_chunks_mut(PIXELS * 3))
        .zip(b.0.par_chunks(PIXELS * stride).zip(b.1.par_chunks(PIXELS * 3)))
        .for_each(|((sum_a, m2_a), (sum_b, m2_b))| {
            let pixels = sum_a.chunks_exact_mut(stride).zip(m2_a.chunks_exact_mut(3));
            let others = sum_b.chunks_exact(stride).zip(m2_b.chunks_exact(3));
            for ((pa, qa), (pb, qb)) in pixels.zip(others) {
                for c in 0..3 {
                    let delta = pb[c] * inv_b - pa[c] * inv_a;
                    qa[c] += qb[c] + delta * delta * k; // (1)
                }
                for (i, (x, y)) in pa.iter_mut().zip(pb).enumerate() {
                    if !ids[i] {
                        *x += y;
                    }
                }
            }
        });
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
