//! The binary tree, down to single primitives, and what each part of it costs as 1..=7 children
//! of a wide node.

use rayon::prelude::*;

use super::binning::find_split;
use super::partition::partition;
use super::{Box4, Costs, Extent, PrimRef};
use crate::node::WIDTH;

/// Below this depth splits halve the number of primitives, so that no tree is too deep.
const MAX_SAH_DEPTH: usize = 48;
/// No tree is deeper: 31 halvings leave one of 2³¹ primitives.
pub(crate) const MAX_DEPTH: usize = MAX_SAH_DEPTH + 32;
/// From this many primitives on, the two sides are built in parallel.
const PARALLEL: usize = 1 << 10;

/// Costs of a subtree as a forest of at most 1..=7 roots.
pub(super) type ForestCosts = [f32; WIDTH - 1];

/// The nodes in depth-first order. That of `n` primitives has room for `2n - 1` nodes: itself,
/// then its left part, then its right part. So the place of a node is known before anything is
/// built, and threads write to slices of their own.
pub(super) struct BinaryTree {
    pub(super) boxes: Vec<[f32; 8]>,
    /// Primitives in the left part; 0 for a single primitive.
    pub(super) left_counts: Vec<u32>,
    pub(super) costs: Vec<ForestCosts>,
}

struct Slots<'a> {
    boxes: &'a mut [[f32; 8]],
    left_counts: &'a mut [u32],
    costs: &'a mut [ForestCosts],
}

impl<'a> Slots<'a> {
    fn split_at(self, at: usize) -> (Slots<'a>, Slots<'a>) {
        let (b0, b1) = self.boxes.split_at_mut(at);
        let (l0, l1) = self.left_counts.split_at_mut(at);
        let (c0, c1) = self.costs.split_at_mut(at);
        (
            Slots { boxes: b0, left_counts: l0, costs: c0 },
            Slots { boxes: b1, left_counts: l1, costs: c1 },
        )
    }
}

impl Slots<'_> {
    fn reborrow(&mut self) -> Slots<'_> {
        Slots {
            boxes: &mut *self.boxes,
            left_counts: &mut *self.left_counts,
            costs: &mut *self.costs,
        }
    }
}

impl BinaryTree {
    /// Builds over at least one primitive, and brings the primitives into the order of the leaves.
    pub(super) fn build(refs: &mut [PrimRef], costs: &Costs) -> BinaryTree {
        let size = 2 * refs.len() - 1;
        let mut tree = BinaryTree {
            boxes: vec![[0.0; 8]; size],
            left_counts: vec![0; size],
            costs: vec![[0.0; WIDTH - 1]; size],
        };
        let extent = refs
            .par_chunks(1 << 14)
            .map(|c| {
                c.iter().fold(Extent::EMPTY, |mut e, r| {
                    e.add(r);
                    e
                })
            })
            .reduce(|| Extent::EMPTY, Extent::merge);
        let mut scratch = refs.to_vec();
        let slots = Slots {
            boxes: &mut tree.boxes,
            left_counts: &mut tree.left_counts,
            costs: &mut tree.costs,
        };
        build_node(refs, &mut scratch, slots, &extent, 0, costs);
        tree
    }

    pub(super) fn bounds(&self, node: usize) -> Box4 {
        let [lo, hi] = [0, 4].map(|k| std::array::from_fn(|i| self.boxes[node][k + i]));
        Box4 { lo, hi }
    }
}

fn build_node(
    refs: &mut [PrimRef],
    scratch: &mut [PrimRef],
    slots: Slots,
    extent: &Extent,
    depth: usize,
    costs: &Costs,
) {
    let (node, rest) = slots.split_at(1);
    node.boxes[0] =
        std::array::from_fn(|i| if i < 4 { extent.bounds.lo[i] } else { extent.bounds.hi[i - 4] });
    let area = extent.bounds.half_area(costs.scale);
    if refs.len() == 1 {
        node.costs[0] = [area * costs.leaf; WIDTH - 1];
        return;
    }
    // Two primitives part in one way only.
    let by_cost = refs.len() > 2 && depth < MAX_SAH_DEPTH;
    let split = if by_cost { find_split(refs, extent, costs) } else { None };
    let (left_count, left, right) = match split {
        Some(split) => partition(refs, scratch, &split),
        None => halve(refs, extent),
    };
    node.left_counts[0] = left_count as u32;

    let count = refs.len();
    let (l_refs, r_refs) = refs.split_at_mut(left_count);
    let (l_scratch, r_scratch) = scratch.split_at_mut(left_count);
    let (mut l_slots, mut r_slots) = rest.split_at(2 * left_count - 1);
    {
        let (l, r) = (l_slots.reborrow(), r_slots.reborrow());
        let build_left = || build_node(l_refs, l_scratch, l, &left, depth + 1, costs);
        let build_right = || build_node(r_refs, r_scratch, r, &right, depth + 1, costs);
        if count >= PARALLEL {
            rayon::join(build_left, build_right);
        } else {
            build_left();
            build_right();
        }
    }
    node.costs[0] = forest_costs(&l_slots.costs[0], &r_slots.costs[0], area, count, costs);
}

/// Two halves along the axis on which the centres spread most: for centres that all coincide, and
/// for parts of the tree that are too deep.
fn halve(refs: &mut [PrimRef], extent: &Extent) -> (usize, Extent, Extent) {
    let middle = refs.len() / 2;
    let spread: [f32; 4] = std::array::from_fn(|i| extent.centroids.hi[i] - extent.centroids.lo[i]);
    let axis = (0..3).fold(0, |a, b| if spread[b] > spread[a] { b } else { a });
    if refs.len() > 2 && spread[axis] > 0.0 {
        refs.select_nth_unstable_by(middle, |a, b| {
            let key = |r: &PrimRef| r.centroid()[axis];
            key(a).total_cmp(&key(b)).then(a.prim().cmp(&b.prim()))
        });
    }
    let extent_of = |refs: &[PrimRef]| {
        let mut e = Extent::EMPTY;
        refs.iter().for_each(|r| e.add(r));
        e
    };
    (middle, extent_of(&refs[..middle]), extent_of(&refs[middle..]))
}

/// The cost of being one leaf; infinite for too many primitives.
pub(super) fn leaf_cost(area: f32, count: usize, costs: &Costs) -> f32 {
    if count <= costs.leaf_size { area * costs.leaf } else { f32::INFINITY }
}

/// The cheapest way to share `roots` >= 2 between two subtrees: cost, and roots of the left one.
pub(super) fn share(left: &ForestCosts, right: &ForestCosts, roots: usize) -> (f32, usize) {
    let mut best = (f32::INFINITY, 1);
    for k in roots.saturating_sub(WIDTH - 1).max(1)..=(roots - 1).min(WIDTH - 1) {
        let cost = left[k - 1] + right[roots - k - 1];
        if cost < best.0 {
            best = (cost, k);
        }
    }
    best
}

/// The recurrence of Ylitie et al. (2017, sec. 3): one root is a leaf or a wide node over a forest
/// of eight; more roots are shared between the two sides, or not all used.
fn forest_costs(
    left: &ForestCosts,
    right: &ForestCosts,
    area: f32,
    count: usize,
    costs: &Costs,
) -> ForestCosts {
    let inner = share(left, right, WIDTH).0 + area;
    let mut forest = [leaf_cost(area, count, costs).min(inner); WIDTH - 1];
    for roots in 2..WIDTH {
        forest[roots - 1] = forest[roots - 2].min(share(left, right, roots).0);
    }
    forest
}
