//! Parts of the scene that share what was learned: by the axis that the normal is closest to,
//! then by place, halved where the points are until few are left in each.

use super::ShadingPoint;
use kaustika_math::{Bounds3, Vec3};
use std::ops::Range;

/// Points of a cell at most, unless they cannot be told apart.
const FEW: usize = 160;

/// ±x, ±y, ±z.
const DIRECTIONS: usize = 6;

/// A tree for each direction of the normal. A node's children follow after it.
#[derive(Debug)]
pub(super) struct Cells {
    /// The first are the roots.
    nodes: Vec<Node>,
    /// Steps from each root to the deepest node under it.
    depths: [u32; DIRECTIONS],
}

/// Points below `at` along the axis are in the node `below`, the others in the next one. Below a
/// cell, where `at` is infinite, is the cell itself: every search may take as many steps as the
/// deepest needs, and no step has to be told from the last.
#[derive(Clone, Copy, Debug)]
struct Node {
    axis: u32,
    at: f32,
    below: u32,
    /// Number of the cell, if it is one.
    cell: u32,
}

impl Node {
    fn cell(node: usize, cell: usize) -> Node {
        Node { axis: 0, at: f32::INFINITY, below: node as u32, cell: cell as u32 }
    }
}

/// The nodes' family, for those who learn.
pub(super) struct Family {
    /// Parent of each node; `None` of the roots.
    pub parents: Vec<Option<usize>>,
    /// Node and points of each cell.
    pub cells: Vec<(usize, Range<usize>)>,
}

impl Cells {
    /// For these points, which are put in the cells' order.
    pub fn new(points: &mut [ShadingPoint]) -> (Cells, Family) {
        points.sort_by_key(|p| direction(p.n));
        let mut nodes: Vec<Node> = (0..DIRECTIONS).map(|root| Node::cell(root, 0)).collect();
        let mut depths = [0; DIRECTIONS];
        let mut family = Family { parents: vec![None; DIRECTIONS], cells: Vec::new() };
        let mut open = Vec::new();
        for root in (0..DIRECTIONS).rev() {
            let start = points.partition_point(|p| direction(p.n) < root);
            let end = points.partition_point(|p| direction(p.n) <= root);
            open.push((root, 0, root, start..end));
        }
        while let Some((node, depth, root, range)) = open.pop() {
            depths[root] = depths[root].max(depth);
            let part = &mut points[range.clone()];
            let Some((axis, at)) = split(part) else {
                nodes[node] = Node::cell(node, family.cells.len());
                family.cells.push((node, range));
                continue;
            };
            let (below, middle) = (nodes.len(), range.start + part.len() / 2);
            nodes[node] = Node { axis: axis as u32, at, below: below as u32, cell: 0 };
            nodes.extend([below, below + 1].map(|child| Node::cell(child, 0)));
            family.parents.extend([Some(node); 2]);
            let (first, second) = (range.start..middle, middle..range.end);
            open.push((below + 1, depth + 1, root, second));
            open.push((below, depth + 1, root, first));
        }
        (Cells { nodes, depths }, family)
    }

    /// The cell of a point with a normal, wherever it is.
    #[inline]
    pub fn find(&self, p: Vec3, n: Vec3) -> usize {
        let mut node = direction(n);
        for _ in 0..self.depths[node] {
            let Node { axis, at, below, .. } = self.nodes[node];
            node = below as usize + usize::from(p[axis as usize] >= at);
        }
        self.nodes[node].cell as usize
    }
}

/// The axis that the normal is closest to, and its sign.
#[inline]
fn direction(n: Vec3) -> usize {
    let a = n.abs();
    let axis = match (a.x >= a.y && a.x >= a.z, a.y >= a.z) {
        (true, _) => 0,
        (false, true) => 1,
        (false, false) => 2,
    };
    2 * axis + usize::from(n[axis] < 0.0)
}

/// Halves points at the middle one along their longest side; axis and place of the border.
/// `None` if they are few or all in one place.
fn split(points: &mut [ShadingPoint]) -> Option<(usize, f32)> {
    if points.len() <= FEW {
        return None;
    }
    let extents = Bounds3::of_points(points.iter().map(|p| p.p)).diagonal();
    let axis = (0..3).max_by(|&a, &b| extents[a].total_cmp(&extents[b]))?;
    let middle = points.len() / 2;
    let (_, at, _) = points.select_nth_unstable_by(middle, |a, b| a.p[axis].total_cmp(&b.p[axis]));
    (extents[axis] > 0.0).then_some((axis, at.p[axis]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::{Vec2, mix_bits, warp};

    #[test]
    fn cells_hold_their_points_and_few_of_them() {
        let u = |k: u64| (mix_bits(k) >> 40) as f32 / (1u64 << 24) as f32;
        let mut points: Vec<ShadingPoint> = (0..5000)
            .map(|k| ShadingPoint {
                p: Vec3::new(u(5 * k), u(5 * k + 1) * 7.0, if k % 3 == 0 { 1.0 } else { 2.0 }),
                p_error: Vec3::ZERO,
                n: warp::uniform_sphere(Vec2::new(u(5 * k + 2), u(5 * k + 3))),
                transmits: false,
            })
            .collect();
        let (cells, family) = Cells::new(&mut points);
        assert_eq!(family.cells.iter().map(|(_, range)| range.len()).sum::<usize>(), 5000);
        for (number, (node, range)) in family.cells.iter().enumerate() {
            assert!(range.len() <= FEW && range.len() > FEW / 3);
            for p in &points[range.clone()] {
                assert_eq!(cells.find(p.p, p.n), number);
            }
            let mut node = *node;
            while let Some(parent) = family.parents[node] {
                assert!(parent < node);
                node = parent;
            }
            assert_eq!(node, direction(points[range.start].n));
        }
        // Anywhere else there is a cell, too, and without points one for each direction.
        assert!(cells.find(Vec3::splat(-1e9), Vec3::ZERO) < family.cells.len());
        let (none, family) = Cells::new(&mut []);
        assert_eq!((none.nodes.len(), family.cells.len()), (6, 6));
        // Points in one place cannot be told apart.
        let mut same = vec![points[0]; 1000];
        assert_eq!(Cells::new(&mut same).1.cells.len(), 6);
    }
}
