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

impl Child {
    const NONE: Child = Child { bounds: Bounds3::EMPTY, place: ChildRef::node(0) };
}

/// Wide nodes and leaves in the order in which they should lie in memory.
///
/// A node is followed by what is below it, depth first, but the children of a node lie together:
/// its node children are consecutive, as are its leaf children, both in the order of the slots. So
/// a node may keep the numbers of its first node and its first leaf alone. (The first node is the
/// root; nodes over more than some 10⁴ primitives, and their children, come before all others.)
/// The primitives of the leaves below a node are a range, which the leaves divide up in an order
/// of their own.
pub(crate) struct WideTree<const WIDTH: usize> {
    pub(crate) nodes: WideNodes<WIDTH>,
    pub(crate) leaves: Leaves,
    /// `None` for no primitives.
    pub(crate) root: Option<ChildRef>,
    /// Nodes on the longest way down.
    pub(crate) depth: usize,
    pub(crate) bounds: Bounds3,
}

impl<const WIDTH: usize> WideTree<WIDTH> {
    /// Builds with leaves of at most `leaf_size` primitives, and brings the primitives into the
    /// order of the binary tree.
    pub(crate) fn build(
        refs: &mut [PrimRef],
        leaf_size: usize,
        options: &BuildOptions,
    ) -> WideTree<WIDTH> {
        const { assert!(WIDTH >= 2 && WIDTH <= 64) };
        if refs.is_empty() {
            return WideTree::of_chunks(Vec::new(), None, Bounds3::EMPTY);
        }
        let tree = BinaryTree::<WIDTH>::build(refs, leaf_size, options);
        let root = tree.root();
        if tree.is_leaf(root) {
            let leaf = Leaf::of(root);
            let chunk = Chunk { leaves: vec![leaf], ..Chunk::default() };
            return WideTree::of_chunks(vec![chunk], Some(ChildRef::leaf(0)), leaf.bounds(refs));
        }
        let chunks = cut(&tree, refs);
        let bounds = chunks[0].nodes[0].bounds();
        WideTree::of_chunks(chunks, Some(ChildRef::node(0)), bounds)
    }

    fn of_chunks(chunks: Vec<Chunk<WIDTH>>, root: Option<ChildRef>, bounds: Bounds3) -> Self {
        let depth = chunks.iter().map(|c| c.depth).max().unwrap_or(0);
        let (nodes, leaves) = chunks
            .into_iter()
            .map(|c| {
                let nodes = NodeChunk {
                    first: c.first_node,
                    first_leaf: c.first_leaf,
                    roots: c.roots,
                    nodes: c.nodes,
                };
                (nodes, (c.first_leaf, c.leaves))
            })
            .unzip();
        let (nodes, leaves) = (WideNodes { chunks: nodes }, Leaves { chunks: leaves });
        WideTree { nodes, leaves, root, depth, bounds }
    }
}

/// The nodes of a [`WideTree`].
pub(crate) struct WideNodes<const WIDTH: usize> {
    chunks: Vec<NodeChunk<WIDTH>>,
}

struct NodeChunk<const WIDTH: usize> {
    nodes: Vec<Slots<WIDTH>>,
    /// Nodes at the beginning that lie elsewhere: the root, in all chunks but the first.
    roots: usize,
    /// Where the others lie.
    first: usize,
    /// Where the leaves of this chunk lie.
    first_leaf: usize,
}

impl<const WIDTH: usize> WideNodes<WIDTH> {
    pub(crate) fn len(&self) -> usize {
        self.chunks.last().map_or(0, |c| c.first + c.nodes.len() - c.roots)
    }

    /// All nodes in their order, each made by `make` of its at most `WIDTH` children.
    pub(crate) fn map<N: Send>(
        self,
        make: impl Fn(&[Child]) -> N + Send + Sync,
    ) -> impl IndexedParallelIterator<Item = N> {
        (0..self.len()).into_par_iter().with_min_len(1 << 8).map(move |i| {
            let chunk = &self.chunks[self.chunks.partition_point(|c| c.first <= i) - 1];
            let slots = &chunk.nodes[i - chunk.first + chunk.roots];
            let mut children = slots.children;
            for child in &mut children[..slots.count] {
                child.place = place(child.place, chunk.first - chunk.roots, chunk.first_leaf);
            }
            make(&children[..slots.count])
        })
    }
}

/// The leaves of a [`WideTree`].
pub(crate) struct Leaves {
    /// Each with the number of its first leaf.
    chunks: Vec<(usize, Vec<Leaf>)>,
}

impl Leaves {
    pub(crate) fn len(&self) -> usize {
        self.chunks.last().map_or(0, |(first, leaves)| first + leaves.len())
    }

    /// All leaves in their order, each made by `make` of its primitives. `refs` are
    /// those that the tree was built from.
    pub(crate) fn map<L: Send>(
        self,
        refs: &[PrimRef],
        make: impl Fn(&[PrimRef]) -> L + Send + Sync,
    ) -> impl IndexedParallelIterator<Item = L> {
        (0..self.len()).into_par_iter().with_min_len(1 << 8).map(move |i| {
            let chunk = self.chunks.partition_point(|(first, _)| *first <= i) - 1;
            let (first, leaves) = &self.chunks[chunk];
            make(&refs[leaves[i - first].range()])
        })
    }
}

/// Where a child of a chunk lies whose nodes and leaves begin there.
fn place(child: ChildRef, first_node: usize, first_leaf: usize) -> ChildRef {
    if child.is_leaf() {
        ChildRef::leaf(child.index() + first_leaf)
    } else {
        ChildRef::node(child.index() + first_node)
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

    fn bounds(&self, refs: &[PrimRef]) -> Bounds3 {
        let all = refs[self.range()].iter().fold(Box8::EMPTY, |b, r| b.union(*r.box8()));
        all.bounds()
    }
}

/// The children of a node; their places are within the chunk.
struct Slots<const WIDTH: usize> {
    count: usize,
    children: [Child; WIDTH],
}

impl<const WIDTH: usize> Slots<WIDTH> {
    const EMPTY: Self = Slots { count: 0, children: [Child::NONE; WIDTH] };

    fn bounds(&self) -> Bounds3 {
        let children = self.children[..self.count].iter();
        children.fold(Bounds3::EMPTY, |all, child| all.union(child.bounds))
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
    ) -> Bounds3 {
        if part.count <= grain {
            pending.push((part, index, depth));
            return Bounds3::EMPTY;
        }
        self.depth = self.depth.max(depth);
        let mut inner = [None; WIDTH];
        let mut slots = Slots::EMPTY;
        tree.children(part, &mut |child| {
            let slot = &mut slots.children[slots.count];
            if tree.is_leaf(child) {
                let leaf = Leaf::of(child);
                *slot =
                    Child { bounds: leaf.bounds(refs), place: ChildRef::leaf(self.leaves.len()) };
                self.leaves.push(leaf);
            } else {
                slot.place = ChildRef::node(self.nodes.len());
                self.nodes.push(Slots::EMPTY);
                inner[slots.count] = Some(child);
            }
            slots.count += 1;
        });
        for (slot, child) in slots.children.iter_mut().zip(inner) {
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
        for child in &mut root.children[..root.count] {
            child.place = place(child.place, chunk.first_node - 1, chunk.first_leaf);
        }
        top.nodes[index] = root;
    }
    // Parents lie before their children.
    for i in (0..top.nodes.len()).rev() {
        for k in 0..top.nodes[i].count {
            let place = top.nodes[i].children[k].place;
            if !place.is_leaf() && place.index() < top.nodes.len() {
                top.nodes[i].children[k].bounds = top.nodes[place.index()].bounds();
            }
        }
    }
    chunks.insert(0, top);
    chunks
}
