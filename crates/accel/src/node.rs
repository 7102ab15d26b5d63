//! Wide nodes and what they refer to.

use kaustika_math::{Bounds3, Vec3};

use crate::builder::Child;
use crate::ray::{PreparedRay, SLACK};
use crate::simd::{F32x8, LANES};

/// Children of a node.
pub(crate) const WIDTH: usize = LANES;

/// A child: a node, or with the top bit set a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
#[derive(Clone, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Node {
    /// Row `2 * axis` holds the lower planes, the next one the upper.
    planes: [[f32; WIDTH]; 6],
    children: [ChildRef; WIDTH],
}

impl Node {
    pub(crate) const EMPTY: Node = Node {
        planes: {
            let (lo, hi) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
            [lo, hi, lo, hi, lo, hi]
        },
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

    pub(crate) fn set(&mut self, slot: usize, bounds: &Bounds3, child: ChildRef) {
        for axis in 0..3 {
            self.planes[2 * axis][slot] = bounds.min[axis];
            self.planes[2 * axis + 1][slot] = bounds.max[axis];
        }
        self.children[slot] = child;
    }

    /// The children in use.
    fn children(&self) -> impl Iterator<Item = (Bounds3, ChildRef)> {
        (0..WIDTH).filter_map(|slot| {
            let corner = |k: usize| {
                Vec3::new(self.planes[k][slot], self.planes[2 + k][slot], self.planes[4 + k][slot])
            };
            let bounds = Bounds3 { min: corner(0), max: corner(1) };
            (!bounds.is_empty()).then_some((bounds, self.children[slot]))
        })
    }

    #[inline(always)]
    pub(crate) fn child(&self, slot: usize) -> ChildRef {
        self.children[slot % WIDTH]
    }

    /// Which boxes the ray may meet before or at `t_max`, one bit each, and where it enters them.
    /// Equation (1) of the module `ray`.
    #[inline(always)]
    pub(crate) fn intersect(&self, ray: &PreparedRay, t_max: F32x8) -> (u32, F32x8) {
        let plane = |i: usize, upper: bool| {
            F32x8::load(&self.planes[(2 * ray.axes[i] + usize::from(upper)).min(5)])
        };
        let near = |i: usize| plane(i, ray.negative[i]).mul_add(ray.inv_d[i], ray.near_c[i]);
        let far = |i: usize| plane(i, !ray.negative[i]).mul_add(ray.inv_d[i], ray.far_c[i]);
        let zero = F32x8::splat(0.0);
        let near_z = near(2);
        let entry = near(0).max(near(1)).max(near_z.max(zero));
        let exit = far(0).min(far(1)).min(far(2).min(t_max));
        let behind = near_z.min(zero);
        let slack = F32x8::splat(SLACK);
        let exit = behind.neg_mul_add(slack, exit.mul_add(slack, exit));
        (entry.le(exit), entry)
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
