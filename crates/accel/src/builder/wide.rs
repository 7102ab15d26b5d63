//! Cutting the binary tree into wide nodes and leaves.

use std::ops::Range;

use kaustika_math::Bounds3;
use rayon::prelude::*;

use super::binary::{BinaryTree, Part};
use super::boxes::Box8;
use super::{BuildOptions, PrimRef};
use crate::node::ChildRef;

/// Parts of more primitives are cut before those below, which are then cut in parallel.
const GRAIN: usize = 1 << 14;

/// One child of a wide node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Child {
    pub(crate) bounds: Bounds3,
    pub(crate) place: ChildRef,
}

/// Wide nodes and leaves in the order in which they should lie in memory.
///
/// A node is followed by what is below it, depth first, but the children of a node lie together:
/// its node children are consecutive, as are its leaf children, both in the order of the slots. So
/// a node may keep the number of its first child alone. (The first node is the root; nodes over
/// more than some 10⁴ primitives, and their children, come before all others.) Leaves that are
/// consecutive hold consecutive primitives only below one node.
pub(crate) struct WideTree<const WIDTH: usize> {
    chunks: Vec<Chunk<WIDTH>>,
    /// `None` for no primitives.
    pub(crate) root: Option<ChildRef>,
    /// Nodes on the longest way down.
    pub(crate) depth: usize,
    pub(crate) bounds: Bounds3,
}

impl<const WIDTH: usize> WideTree<WIDTH> {
    /// Builds with leaves of at most `leaf_size` primitives, and brings the primitives into the
    /// order of the leaves.
    pub(crate) fn build(
        refs: &mut [PrimRef],
        leaf_size: usize,
        options: &BuildOptions,
    ) -> WideTree<WIDTH> {
        const { assert!(WIDTH >= 2 && WIDTH <= 64) };
        if refs.is_empty() {
            let bounds = Bounds3::EMPTY;
            return WideTree { chunks: Vec::new(), root: None, depth: 0, bounds };
        }
        let tree = BinaryTree::<WIDTH>::build(refs, leaf_size, options);
        let root = tree.root();
        if tree.is_leaf(root) {
            let chunk = Chunk { leaves: vec![Leaf::of(root)], ..Chunk::default() };
            let bounds = chunk.leaves[0].bounds(refs).bounds();
            let root = Some(ChildRef::leaf(0));
            return WideTree { chunks: vec![chunk], root, depth: 0, bounds };
        }
        let chunks = cut(&tree, refs);
        let depth = chunks.iter().map(|c| c.depth).max().unwrap_or(0);
        let bounds = chunks[0].nodes[0].bounds().bounds();
        WideTree { chunks, root: Some(ChildRef::node(0)), depth, bounds }
    }

    pub(crate) fn node_count(&self) -> usize {
        self.chunks.last().map_or(0, |c| c.first_node + c.nodes.len() - c.roots)
    }

    pub(crate) fn leaf_count(&self) -> usize {
        self.chunks.last().map_or(0, |c| c.first_leaf + c.leaves.len())
    }

    /// All nodes in their order, each made by `node` of its at most `WIDTH` children; in parallel.
    pub(crate) fn nodes<N: Send>(&self, node: impl Fn(&[Child]) -> N + Sync) -> Vec<N> {
        (0..self.node_count())
            .into_par_iter()
            .with_min_len(1 << 8)
            .map(|i| {
                let chunk = self.chunk(i, |c| c.first_node);
                let slots = &chunk.nodes[i - chunk.first_node + chunk.roots];
                let mut children =
                    [Child { bounds: Bounds3::EMPTY, place: ChildRef::node(0) }; WIDTH];
                for (child, slot) in children.iter_mut().zip(slots.in_use()) {
                    *child = Child { bounds: slot.bounds.bounds(), place: chunk.place(slot.place) };
                }
                node(&children[..slots.count])
            })
            .collect()
    }

    /// All leaves in their order, each made by `leaf` of its place and its primitives; in parallel.
    /// `refs` are those that the tree was built from.
    pub(crate) fn leaves<L: Send>(
        &self,
        refs: &[PrimRef],
        leaf: impl Fn(usize, &[PrimRef]) -> L + Sync,
    ) -> Vec<L> {
        (0..self.leaf_count())
            .into_par_iter()
            .with_min_len(1 << 8)
            .map(|i| {
                let chunk = self.chunk(i, |c| c.first_leaf);
                leaf(i, &refs[chunk.leaves[i - chunk.first_leaf].range()])
            })
            .collect()
    }

    /// The chunk that holds item `i`, of chunks that begin at `first`.
    fn chunk(&self, i: usize, first: impl Fn(&Chunk<WIDTH>) -> usize) -> &Chunk<WIDTH> {
        &self.chunks[self.chunks.partition_point(|c| first(c) <= i) - 1]
    }
}

/// The primitives of a leaf.
#[derive(Clone, Copy, Debug)]
struct Leaf {
    first: u32,
    count: u32,
}

impl Leaf {
    fn of(part: Part) -> Leaf {
        Leaf { first: part.first as u32, count: part.count as u32 }
    }

    fn range(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    fn bounds(&self, refs: &[PrimRef]) -> Box8 {
        refs[self.range()].iter().fold(Box8::EMPTY, |b, r| b.union(*r.box8()))
    }
}

#[derive(Clone, Copy)]
struct Slot {
    bounds: Box8,
    /// Within the chunk.
    place: ChildRef,
}

struct Slots<const WIDTH: usize> {
    count: usize,
    slots: [Slot; WIDTH],
}

impl<const WIDTH: usize> Slots<WIDTH> {
    const EMPTY: Self =
        Slots { count: 0, slots: [Slot { bounds: Box8::EMPTY, place: ChildRef::node(0) }; WIDTH] };

    fn in_use(&self) -> &[Slot] {
        &self.slots[..self.count]
    }

    fn bounds(&self) -> Box8 {
        self.in_use().iter().fold(Box8::EMPTY, |b, s| b.union(s.bounds))
    }
}

/// A part of the wide tree, that counts its nodes and leaves for itself.
struct Chunk<const WIDTH: usize> {
    nodes: Vec<Slots<WIDTH>>,
    leaves: Vec<Leaf>,
    /// Nodes at the beginning that lie elsewhere: the root, in all chunks but the first.
    roots: usize,
    /// Where the others lie.
    first_node: usize,
    first_leaf: usize,
    depth: usize,
}

impl<const WIDTH: usize> Default for Chunk<WIDTH> {
    fn default() -> Self {
        Chunk {
            nodes: Vec::new(),
            leaves: Vec::new(),
            roots: 0,
            first_node: 0,
            first_leaf: 0,
            depth: 0,
        }
    }
}

impl<const WIDTH: usize> Chunk<WIDTH> {
    fn place(&self, child: ChildRef) -> ChildRef {
        if child.is_leaf() {
            ChildRef::leaf(child.index() + self.first_leaf)
        } else {
            ChildRef::node(child.index() + self.first_node - self.roots)
        }
    }

    /// Makes `part` the node at `index`, except that the parts below of at most `grain`
    /// primitives that are to be nodes become `pending`. Returns the box, for what it is worth
    /// with pending parts.
    fn cut(
        &mut self,
        tree: &BinaryTree<WIDTH>,
        refs: &[PrimRef],
        (part, index, depth): (Part, usize, usize),
        grain: usize,
        pending: &mut Vec<(Part, usize, usize)>,
    ) -> Box8 {
        if part.count <= grain {
            pending.push((part, index, depth));
            return Box8::EMPTY;
        }
        self.depth = self.depth.max(depth);
        let mut inner = [None; WIDTH];
        let mut slots = Slots::EMPTY;
        tree.children(part, &mut |child| {
            let slot = &mut slots.slots[slots.count];
            if tree.is_leaf(child) {
                let leaf = Leaf::of(child);
                *slot =
                    Slot { bounds: leaf.bounds(refs), place: ChildRef::leaf(self.leaves.len()) };
                self.leaves.push(leaf);
            } else {
                slot.place = ChildRef::node(self.nodes.len());
                self.nodes.push(Slots::EMPTY);
                inner[slots.count] = Some(child);
            }
            slots.count += 1;
        });
        for (slot, child) in slots.slots.iter_mut().zip(inner) {
            if let Some(child) = child {
                let place = slot.place.index();
                slot.bounds = self.cut(tree, refs, (child, place, depth + 1), grain, pending);
            }
        }
        let bounds = slots.bounds();
        self.nodes[index] = slots;
        bounds
    }
}

/// Cuts a tree whose root is to be a node: first what is above parts of `GRAIN` primitives, then
/// these, each a chunk.
fn cut<const WIDTH: usize>(tree: &BinaryTree<WIDTH>, refs: &[PrimRef]) -> Vec<Chunk<WIDTH>> {
    let mut top = Chunk { nodes: vec![Slots::EMPTY], ..Chunk::default() };
    let mut pending = Vec::new();
    top.cut(tree, refs, (tree.root(), 0, 1), GRAIN, &mut pending);
    let mut chunks: Vec<Chunk<WIDTH>> = pending
        .par_iter()
        .with_max_len(1)
        .map(|&(part, _, depth)| {
            let mut chunk = Chunk { nodes: vec![Slots::EMPTY], roots: 1, ..Chunk::default() };
            chunk.cut(tree, refs, (part, 0, depth), 0, &mut Vec::new());
            chunk
        })
        .collect();
    let (mut first_node, mut first_leaf) = (top.nodes.len(), top.leaves.len());
    for (chunk, (_, index, _)) in chunks.iter_mut().zip(pending) {
        (chunk.first_node, chunk.first_leaf) = (first_node, first_leaf);
        first_node += chunk.nodes.len() - 1;
        first_leaf += chunk.leaves.len();
        // The root goes to its place among its siblings.
        let mut root = std::mem::replace(&mut chunk.nodes[0], Slots::EMPTY);
        for slot in &mut root.slots {
            slot.place = chunk.place(slot.place);
        }
        top.nodes[index] = root;
    }
    // Parents lie before their children.
    for i in (0..top.nodes.len()).rev() {
        for k in 0..top.nodes[i].count {
            let place = top.nodes[i].slots[k].place;
            if !place.is_leaf() && place.index() < top.nodes.len() {
                top.nodes[i].slots[k].bounds = top.nodes[place.index()].bounds();
            }
        }
    }
    chunks.insert(0, top);
    chunks
}
