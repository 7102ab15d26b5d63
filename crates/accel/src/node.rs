//! Wide nodes and what they refer to.

use bytemuck::{Pod, Zeroable};
use kaustika_math::{Bounds3, Vec3};

use crate::builder::Child;
use crate::ray::{LATER, RayLanes, widened};
use crate::simd::{F32x8, LANES, Lanes};

/// Children of a node.
pub(crate) const WIDTH: usize = LANES;

/// A child: a node, or with the top bit set a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub(crate) struct ChildRef(pub(crate) u32);

impl ChildRef {
    const LEAF: u32 = 1 << 31;

    pub(crate) const fn node(index: usize) -> ChildRef {
        debug_assert!(index < Self::LEAF as usize);
        ChildRef(index as u32)
    }

    pub(crate) const fn leaf(index: usize) -> ChildRef {
        debug_assert!(index < Self::LEAF as usize);
        ChildRef(index as u32 | Self::LEAF)
    }

    #[inline(always)]
    pub(crate) fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    #[inline(always)]
    pub(crate) fn index(self) -> usize {
        (self.0 & !Self::LEAF) as usize
    }
}

/// Eight boxes side by side. An unused one is empty (min > max) and no ray hits it.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
pub(crate) struct Node {
    /// Of each axis the lower planes, then the upper.
    planes: [[[f32; WIDTH]; 2]; 3],
    children: [ChildRef; WIDTH],
}

impl Node {
    pub(crate) const EMPTY: Node = Node {
        planes: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3],
        children: [ChildRef(0); WIDTH],
    };

    /// Of at most eight children.
    pub(crate) fn new(children: &[Child]) -> Node {
        let mut node = Node::EMPTY;
        for (slot, child) in children.iter().enumerate() {
            node.set(slot, &child.bounds, child.place);
        }
        node
    }

    /// The box is stored [`widened`].
    pub(crate) fn set(&mut self, slot: usize, bounds: &Bounds3, child: ChildRef) {
        let bounds = widened(bounds);
        for axis in 0..3 {
            self.planes[axis][0][slot] = bounds.min[axis];
            self.planes[axis][1][slot] = bounds.max[axis];
        }
        self.children[slot] = child;
    }

    /// The children in use.
    fn children(&self) -> impl Iterator<Item = (Bounds3, ChildRef)> {
        (0..WIDTH).filter_map(|slot| {
            let corner = |k: usize| {
                let [x, y, z] = [0, 1, 2].map(|axis| self.planes[axis][k][slot]);
                Vec3::new(x, y, z)
            };
            let bounds = Bounds3 { min: corner(0), max: corner(1) };
            (!bounds.is_empty()).then_some((bounds, self.children[slot]))
        })
    }

    #[inline(always)]
    pub(crate) fn child(&self, slot: usize) -> ChildRef {
        self.children[slot % WIDTH]
    }

    /// All slots, used or not.
    #[inline(always)]
    pub(crate) fn refs(&self) -> &[ChildRef; WIDTH] {
        &self.children
    }

    /// Which boxes the ray may meet before or at `t_max`, one bit each, and where it enters them.
    /// Equation (1) of the module `ray`. No entry is -0, so that its bits sort.
    #[inline(always)]
    pub(crate) fn intersect(
        &self,
        ray: &RayLanes<F32x8>,
        negative: [u8; 3],
        t_max: F32x8,
    ) -> (u32, F32x8) {
        // min and max give their argument where they can't tell: 0 rather than -0, a NaN in t_max.
        let (mut entry, mut exit) = (F32x8::splat(0.0), t_max);
        for axis in 0..3 {
            let [near, far] = self.near_and_far(axis, negative);
            entry = near.mul_add(ray.inv_d[axis], ray.near_c[axis]).max(entry);
            exit = far.mul_add(ray.inv_d[axis], ray.far_c[axis]).min(exit);
        }
        (entry.le(exit * F32x8::splat(LATER)), entry)
    }

    /// Which rays may meet the box in `slot` before or at `t_max`, and where they enter it: bits and
    /// lanes are rays. Each is answered as by [`intersect`](Self::intersect).
    #[inline(always)]
    pub(crate) fn intersect_child<V: Lanes>(
        &self,
        slot: usize,
        rays: &RayLanes<V>,
        negative: [u8; 3],
        t_max: V,
    ) -> (u32, V) {
        let (mut entry, mut exit) = (V::splat(0.0), t_max);
        for axis in 0..3 {
            let upper_first = usize::from(negative[axis] & 1);
            let near = V::splat(self.planes[axis][upper_first][slot % WIDTH]);
            let far = V::splat(self.planes[axis][upper_first ^ 1][slot % WIDTH]);
            entry = near.mul_add(rays.inv_d[axis], rays.near_c[axis]).max(entry);
            exit = far.mul_add(rays.inv_d[axis], rays.far_c[axis]).min(exit);
        }
        (entry.le(exit * V::splat(LATER)), entry)
    }

    /// Along an axis the planes that a ray meets first, and those that it meets last.
    #[inline(always)]
    pub(crate) fn near_and_far(&self, axis: usize, negative: [u8; 3]) -> [F32x8; 2] {
        let upper_first = usize::from(negative[axis] & 1);
        [upper_first, upper_first ^ 1].map(|side| F32x8::load(&self.planes[axis][side]))
    }
}

/// What a tree is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TreeStats {
    /// Eight-wide inner nodes.
    pub nodes: usize,
    /// Boxes in use, over all nodes.
    pub children: usize,
    /// Leaves: blocks of up to eight triangles, or single primitives.
    pub leaves: usize,
    /// Primitives in the leaves.
    pub primitives: usize,
    /// Nodes on the longest way from the root to a leaf.
    pub depth: usize,
    /// Expected node tests and leaf tests of a random line through the bounds (the surface area
    /// heuristic).
    pub expected_tests: [f32; 2],
}

impl TreeStats {
    /// What the nodes tell; leaves and primitives are for the tree to fill in.
    pub(crate) fn of_nodes(nodes: &[Node], bounds: &Bounds3, depth: usize) -> TreeStats {
        let total = f64::from(bounds.half_area()).max(f64::MIN_POSITIVE);
        let root_tests = if nodes.is_empty() { [0.0, 1.0] } else { [1.0, 0.0] };
        let mut stats = TreeStats { nodes: nodes.len(), depth, ..TreeStats::default() };
        let mut tests: [f64; 2] = root_tests;
        for (bounds, child) in nodes.iter().flat_map(Node::children) {
            stats.children += 1;
            tests[usize::from(child.is_leaf())] += f64::from(bounds.half_area()) / total;
        }
        stats.expected_tests = tests.map(|v| v as f32);
        stats
    }
}
