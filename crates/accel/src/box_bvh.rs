//! The tree over primitives of any kind.

use kaustika_math::{Bounds3, Ray};
use rayon::prelude::*;

use crate::builder::{self, BuildOptions, Child, WideTree};
use crate::node::{ChildRef, Node, TreeStats, WIDTH};
use crate::ray::PreparedRay;
use crate::traverse::{self, LARGE_STACK, SMALL_STACK, stack_size};

/// A tree over primitives known by their bounds, each a leaf of its own; the caller's closures test
/// them.
///
/// What a closure may hit must lie within the bounds, but for a relative error of some 10⁻⁶ in `t`:
/// box tests have that much slack.
#[derive(Clone, Debug)]
pub struct BoxBvh {
    nodes: Vec<Node>,
    root: Option<ChildRef>,
    depth: usize,
    bounds: Bounds3,
    primitives: usize,
}

impl BoxBvh {
    /// Builds in the current rayon pool; the tree is the same whatever its number of threads.
    /// Primitives whose bounds are empty, not finite or beyond 2⁶⁰ are left out.
    ///
    /// # Panics
    /// With more than 2³¹ primitives.
    pub fn build(bounds: &[Bounds3]) -> BoxBvh {
        assert!(bounds.len() <= 1 << 31, "more than 2^31 primitives in one tree");
        let mut refs = builder::references(bounds.len(), |prim| Some(bounds[prim]));
        let tree = WideTree::<WIDTH>::build(&mut refs, 1, &BuildOptions::default());
        let (mut root, mut depth) = (tree.root, tree.depth);
        let prims: Vec<u32> = tree.leaves.map(&refs, |leaf| leaf[0].prim()).collect();
        let leaf = |c: &Child| match c.place.is_leaf() {
            true => ChildRef::leaf(prims[c.place.index()] as usize),
            false => c.place,
        };
        let made = tree.nodes.map(|children| {
            let mut node = Node::EMPTY;
            for (slot, child) in children.iter().enumerate() {
                node.set(slot, &child.bounds, leaf(child));
            }
            node
        });
        let mut nodes: Vec<Node> = made.collect();
        if root.is_some_and(|r| r.is_leaf()) {
            // A node for it, lest the closure be bothered with rays that pass the box by.
            let mut node = Node::EMPTY;
            node.set(0, &tree.bounds, ChildRef::leaf(prims[0] as usize));
            nodes.push(node);
            (root, depth) = (Some(ChildRef::node(0)), 1);
        }
        BoxBvh { nodes, root, depth, bounds: tree.bounds, primitives: refs.len() }
    }

    /// The box of all primitives; empty without primitives.
    pub fn bounds(&self) -> Bounds3 {
        self.bounds
    }

    /// Primitives in the tree.
    pub fn primitive_count(&self) -> usize {
        self.primitives
    }

    /// Bytes of nodes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.nodes)
    }

    /// Counts and expected costs.
    pub fn stats(&self) -> TreeStats {
        let mut stats = TreeStats::of_nodes(&self.nodes, &self.bounds, self.depth);
        stats.leaves = self.primitives;
        stats.primitives = self.primitives;
        stats
    }

    /// The nearest hit: its distance, its primitive, and what the test made of it.
    ///
    /// `test(prim, t_max)` returns the nearest hit of that primitive with `t` in (0, t_max), if
    /// there is one. Of primitives hit at the same `t` the least wins.
    pub fn intersect<H>(
        &self,
        ray: &Ray,
        t_max: f32,
        test: impl FnMut(u32, f32) -> Option<(f32, H)>,
    ) -> Option<(f32, u32, H)> {
        if self.is_out_of_the_way(ray, t_max) {
            None
        } else if stack_size(self.depth) <= SMALL_STACK {
            self.closest::<SMALL_STACK, H>(ray, t_max, test)
        } else {
            self.closest::<LARGE_STACK, H>(ray, t_max, test)
        }
    }

    /// Whether `test(prim, t_max)` is true of a primitive whose bounds the ray meets before
    /// `t_max`. Primitives come in any order, each at most once.
    pub fn any(&self, ray: &Ray, t_max: f32, test: impl FnMut(u32, f32) -> bool) -> bool {
        if self.is_out_of_the_way(ray, t_max) {
            false
        } else if stack_size(self.depth) <= SMALL_STACK {
            self.any_of::<SMALL_STACK>(ray, t_max, test)
        } else {
            self.any_of::<LARGE_STACK>(ray, t_max, test)
        }
    }

    /// True if the ray surely passes by all primitives: what costs least to be told, and is
    /// frequent where a few things stand in a scene of many triangles.
    #[inline]
    fn is_out_of_the_way(&self, ray: &Ray, t_max: f32) -> bool {
        // More than is lost to rounding, here and in the boxes' own tests.
        const MORE: f32 = 1.0 / (1 << 16) as f32;
        let more = self.bounds.diagonal().max_component() * MORE;
        let (mut entry, mut exit) = (0f32, t_max);
        for axis in 0..3 {
            let (o, d) = (ray.o[axis], ray.d[axis]);
            let (lo, hi) = (self.bounds.min[axis] - more, self.bounds.max[axis] + more);
            if d == 0.0 {
                if o < lo || o > hi {
                    return true;
                }
                continue;
            }
            let inv = 1.0 / d;
            let (a, b) = ((lo - o) * inv, (hi - o) * inv);
            entry = entry.max(a.min(b));
            exit = exit.min(a.max(b));
        }
        entry > exit + (entry.abs() + exit.abs()) * MORE
    }

    #[inline(always)]
    fn closest<const STACK: usize, H>(
        &self,
        ray: &Ray,
        t_max: f32,
        mut test: impl FnMut(u32, f32) -> Option<(f32, H)>,
    ) -> Option<(f32, u32, H)> {
        let root = self.root?;
        let prepared = PreparedRay::new(ray, &self.bounds)?;
        let to_tree = 1.0 / prepared.scale;
        let mut best: Option<(f32, u32, H)> = None;
        traverse::closest::<STACK>(
            &self.nodes,
            root,
            &prepared,
            slack(t_max * to_tree),
            |_| (),
            |leaf, nearest| {
                let prim = leaf as u32;
                // A hit exactly at the best so far counts for a lesser primitive.
                let limit = match &best {
                    None => t_max,
                    Some((t, p, _)) if prim < *p => t.next_up(),
                    Some((t, ..)) => *t,
                };
                match test(prim, limit) {
                    Some((t, h)) if t > 0.0 && t < limit => {
                        best = Some((t, prim, h));
                        slack(t * to_tree)
                    }
                    _ => nearest,
                }
            },
        );
        best
    }

    #[inline(always)]
    fn any_of<const STACK: usize>(
        &self,
        ray: &Ray,
        t_max: f32,
        mut test: impl FnMut(u32, f32) -> bool,
    ) -> bool {
        let Some(root) = self.root else { return false };
        let Some(prepared) = PreparedRay::new(ray, &self.bounds) else { return false };
        let limit = slack(t_max / prepared.scale);
        traverse::any::<STACK>(
            &self.nodes,
            root,
            &prepared,
            limit,
            |_| (),
            |leaf| test(leaf as u32, t_max),
        )
    }
}

/// Later by what a closure's own rounding may bring a hit forward.
fn slack(t: f32) -> f32 {
    t * (1.0 + 1.0 / (1 << 20) as f32)
}
