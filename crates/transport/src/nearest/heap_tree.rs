//! A left-balanced kd-tree laid out as a heap (Jensen 2001, sec. 6.2; Bærentzen 2003): the
//! children of node i are 2i and 2i + 1, counted from 1, and no pointer is kept.
//!
//! Searched best first: a heap holds the branches not entered yet, by the distance of the plane
//! that parts them from the query; the search ends when the nearest of them is too far.

use super::found::{Nearest, keyed, unkeyed};
use super::{Item, part};
use kaustika_math::Vec3;
use std::cmp::Reverse;

/// The tree: 13 bytes a point. Node i stands at place i - 1.
#[derive(Clone, Debug)]
pub struct HeapTree {
    pub(super) points: Vec<Vec3>,
    /// Along which axis the node parts its points.
    axes: Vec<u8>,
}

impl HeapTree {
    pub(super) fn new(mut items: Vec<Item>) -> (HeapTree, Vec<u32>) {
        let count = items.len();
        let mut nodes = vec![(Item { p: Vec3::ZERO, index: 0 }, 0); count];
        build(&mut items, 1, &mut nodes);
        let points = nodes.iter().map(|(item, _)| item.p).collect();
        let axes = nodes.iter().map(|&(_, axis)| axis).collect();
        (HeapTree { points, axes }, nodes.iter().map(|(item, _)| item.index).collect())
    }

    pub(super) fn nearest(&self, q: Vec3, found: &mut Nearest) {
        found.branches.push(Reverse(keyed(0.0, 1)));
        while let Some(Reverse(branch)) = found.branches.pop() {
            let (d2, mut node) = unkeyed(branch);
            if d2 >= found.bound() {
                return;
            }
            while let Some(&p) = self.points.get(node as usize - 1) {
                let own_d2 = (p - q).length_squared();
                if own_d2 < found.bound() {
                    found.offer(own_d2, node - 1);
                }
                let (near, far, plane2) = self.children(q, p, node);
                let far_d2 = plane2.max(d2);
                if far_d2 < found.bound() && (far as usize) <= self.points.len() {
                    found.branches.push(Reverse(keyed(far_d2, far)));
                }
                node = near;
            }
        }
    }

    pub(super) fn within(&self, q: Vec3, r2: f32, each: &mut impl FnMut(u32, f32)) {
        let mut stack = vec![1];
        while let Some(mut node) = stack.pop() {
            while let Some(&p) = self.points.get(node as usize - 1) {
                let d2 = (p - q).length_squared();
                if d2 < r2 {
                    each(node - 1, d2);
                }
                let (near, far, plane2) = self.children(q, p, node);
                if plane2 < r2 {
                    stack.push(far);
                }
                node = near;
            }
        }
    }

    /// The child on the query's side of the node's point `p`, the other, and d² of the plane.
    #[inline]
    fn children(&self, q: Vec3, p: Vec3, node: u32) -> (u32, u32, f32) {
        let axis = usize::from(self.axes[node as usize - 1]);
        let delta = q[axis] - p[axis];
        let near = 2 * node + u32::from(delta >= 0.0);
        (near, near ^ 1, delta * delta)
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.points.len() * (size_of::<Vec3>() + 1)
    }
}

/// How many of `count` points lie left of the root of a left-balanced tree: those of a full tree
/// of one level less, and what the last level has on the left.
fn left_of(count: usize) -> usize {
    let level = count.ilog2();
    if level == 0 {
        return 0;
    }
    let last = count - ((1 << level) - 1);
    let half = 1 << (level - 1);
    half - 1 + last.min(half)
}

fn build(items: &mut [Item], node: usize, nodes: &mut [(Item, u8)]) {
    if items.is_empty() {
        return;
    }
    let at = left_of(items.len());
    let axis = part(items, at);
    nodes[node - 1] = (items[at], axis as u8);
    let (left, right) = items.split_at_mut(at);
    build(left, 2 * node, nodes);
    build(&mut right[1..], 2 * node + 1, nodes);
}

#[cfg(test)]
impl HeapTree {
    /// Fails unless every node parts the points below it.
    pub(super) fn check(&self) {
        let axis_of = |node: usize| usize::from(self.axes[node - 1]);
        for leaf in 1..=self.points.len() {
            let mut node = leaf;
            while node > 1 {
                let (parent, axis) = (node / 2, axis_of(node / 2));
                let (p, plane) = (self.points[leaf - 1][axis], self.points[parent - 1][axis]);
                assert!(if node.is_multiple_of(2) { p <= plane } else { p >= plane });
                node = parent;
            }
        }
    }
}
