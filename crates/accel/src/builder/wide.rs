//! Cutting the binary tree into wide nodes and leaves.

use kaustika_math::Bounds3;

use super::binary::{BinaryTree, leaf_cost, share};
use super::{Costs, PrimRef};
use crate::node::{ChildRef, Node, WIDTH};

/// Wide nodes over ranges of primitives.
pub(crate) struct WideTree {
    /// The root first, each node before what is below it, depth first.
    pub(crate) nodes: Vec<Node>,
    /// `None` for no primitives.
    pub(crate) root: Option<ChildRef>,
    /// Nodes on the longest way down.
    pub(crate) depth: usize,
    pub(crate) bounds: Bounds3,
}

/// A node of the binary tree: its place, and its primitives `first .. first + count`.
#[derive(Clone, Copy)]
struct Part {
    place: usize,
    first: usize,
    count: usize,
}

struct Cutter<'a, F> {
    tree: BinaryTree,
    costs: &'a Costs,
    leaf: F,
    nodes: Vec<Node>,
    depth: usize,
}

impl WideTree {
    /// `leaf` is told the ranges of the leaves in depth-first order, and numbers them; ranges are
    /// of `refs` in the order that `build` leaves them in.
    pub(crate) fn build(
        refs: &mut [PrimRef],
        costs: &Costs,
        leaf: impl FnMut(&[PrimRef], usize) -> usize,
    ) -> WideTree {
        if refs.is_empty() {
            return WideTree { nodes: Vec::new(), root: None, depth: 0, bounds: Bounds3::EMPTY };
        }
        let tree = BinaryTree::build(refs, costs);
        let bounds = tree.bounds(0).bounds();
        let mut cutter = Cutter { tree, costs, leaf, nodes: Vec::new(), depth: 0 };
        let all = Part { place: 0, first: 0, count: refs.len() };
        let root = cutter.cut(all, refs, 1);
        WideTree { nodes: cutter.nodes, root: Some(root), depth: cutter.depth, bounds }
    }
}

impl<F: FnMut(&[PrimRef], usize) -> usize> Cutter<'_, F> {
    /// Makes `part` a leaf or a wide node, whichever is cheaper.
    fn cut(&mut self, part: Part, refs: &[PrimRef], depth: usize) -> ChildRef {
        let area = self.tree.bounds(part.place).half_area(self.costs.scale);
        let as_leaf = leaf_cost(area, part.count, self.costs);
        if part.count == 1
            || part.count <= self.costs.leaf_size && as_leaf <= self.tree.costs[part.place][0]
        {
            let range = &refs[part.first..part.first + part.count];
            return ChildRef::leaf((self.leaf)(range, part.first));
        }
        let index = self.nodes.len();
        self.nodes.push(Node::EMPTY);
        self.depth = self.depth.max(depth);
        let mut children = Vec::with_capacity(WIDTH);
        self.divide(part, WIDTH, &mut children);
        for (slot, &child) in children.iter().enumerate() {
            let bounds = self.tree.bounds(child.place).bounds();
            let made = self.cut(child, refs, depth + 1);
            self.nodes[index].set(slot, &bounds, made);
        }
        ChildRef::node(index)
    }

    /// The two sides of `part` as at most `roots` children.
    fn divide(&self, part: Part, roots: usize, children: &mut Vec<Part>) {
        let [left, right] = self.sides(part);
        let (_, k) = share(&self.tree.costs[left.place], &self.tree.costs[right.place], roots);
        self.gather(left, k, children);
        self.gather(right, roots - k, children);
    }

    /// `part` as at most `roots` children, of the least cost.
    fn gather(&self, part: Part, mut roots: usize, children: &mut Vec<Part>) {
        let costs = &self.tree.costs[part.place];
        while roots > 1 && costs[roots - 2] <= costs[roots - 1] {
            roots -= 1;
        }
        if roots == 1 {
            children.push(part);
        } else {
            self.divide(part, roots, children);
        }
    }

    fn sides(&self, part: Part) -> [Part; 2] {
        let left_count = self.tree.left_counts[part.place] as usize;
        let left = Part { place: part.place + 1, first: part.first, count: left_count };
        let right = Part {
            place: part.place + 2 * left_count,
            first: part.first + left_count,
            count: part.count - left_count,
        };
        [left, right]
    }
}
