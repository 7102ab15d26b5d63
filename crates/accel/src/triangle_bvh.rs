//! The tree over a triangle soup.

use kaustika_math::{Bounds3, Ray, Vec3};

use crate::accept::{Accept, Everything};
use crate::batch::{self, Way};
use crate::builder::{self, BuildOptions, MAX_DEPTH, WideTree};
use crate::node::{ChildRef, Node, TreeStats, WIDTH};
use crate::pages::Array;
use crate::ray::PreparedRay;
use crate::stream::{MAX_ITEMS, Segment, Tree, stream_stack_size};
use crate::traverse::{self, LARGE_STACK, SMALL_STACK, stack_size};
use crate::triangle::{BLOCK, TriangleBlock};

/// Up to so many triangles leaves have at most [`FEW_IN_LEAF`]. Crowds hold every triangle of a leaf
/// against all their rays, so that boxes pay sooner; and there is memory enough.
const FEW: usize = 4096;
const FEW_IN_LEAF: usize = 4;

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Distance in lengths of the ray's direction, > 0.
    pub t: f32,
    /// The triangle: its place among the indices given to [`TriangleBvh::build`].
    pub prim: u32,
    /// Barycentric weights of its three vertices, >= 0; their sum is one up to rounding.
    pub b: [f32; 3],
}

/// A tree over the triangles of a soup, with a copy of their corners.
#[derive(Clone, Debug)]
pub struct TriangleBvh {
    nodes: Array<Node>,
    blocks: Array<TriangleBlock>,
    root: Option<ChildRef>,
    depth: usize,
    bounds: Bounds3,
    triangles: usize,
}

impl TriangleBvh {
    /// Builds in the current rayon pool; the tree is the same whatever its number of threads.
    ///
    /// A triangle is left out, and never hit, if an index is out of range, if a coordinate is not
    /// finite or beyond 2⁶⁰ ≈ 1.15e18, or if it has no area. Triangles are two-sided.
    ///
    /// # Panics
    /// With more than 2³⁰ triangles.
    pub fn build(positions: &[Vec3], indices: &[[u32; 3]], options: &BuildOptions) -> TriangleBvh {
        assert!(indices.len() <= MAX_ITEMS, "more than 2^30 triangles in one mesh");
        let mut refs = builder::references(indices.len(), |prim| {
            let [a, b, c] = indices[prim].map(|i| i as usize);
            let p = [*positions.get(a)?, *positions.get(b)?, *positions.get(c)?];
            // A NaN would vanish in the bounds.
            let finite = p.iter().all(|p| p.is_finite());
            (finite && has_area(p)).then(|| Bounds3::new(p[0], p[1]).with_point(p[2]))
        });
        let leaf_size = if refs.len() <= FEW { FEW_IN_LEAF } else { BLOCK };
        let tree = WideTree::<WIDTH>::build(&mut refs, leaf_size, options);
        let nodes = Array::collect(tree.nodes.map(Node::new));
        let blocks = Array::collect(tree.leaves.map(&refs, |leaf| {
            TriangleBlock::new(leaf.iter().map(|r| {
                let [a, b, c] = indices[r.prim() as usize].map(|i| positions[i as usize].into());
                (r.prim(), [a, b, c])
            }))
        }));
        TriangleBvh {
            nodes,
            blocks,
            root: tree.root,
            depth: tree.depth,
            bounds: tree.bounds,
            triangles: refs.len(),
        }
    }

    /// The box of all triangles; empty without triangles.
    pub fn bounds(&self) -> Bounds3 {
        self.bounds
    }

    /// Triangles that a ray can hit.
    pub fn triangle_count(&self) -> usize {
        self.triangles
    }

    /// Bytes of nodes and triangles.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.blocks)
    }

    /// Counts and expected costs.
    pub fn stats(&self) -> TreeStats {
        let mut stats = TreeStats::of_nodes(&self.nodes, &self.bounds, self.depth);
        stats.leaves = self.blocks.len();
        stats.primitives = self.blocks.iter().map(TriangleBlock::count).sum();
        stats
    }

    /// The hit with the least `t` in (0, t_max), of several the one with the least `prim`.
    pub fn intersect(&self, ray: &Ray, t_max: f32) -> Option<TriangleHit> {
        self.intersect_filtered(ray, t_max, |_| true)
    }

    /// As [`intersect`](Self::intersect), among the hits that `accept` accepts. It may be asked
    /// about hits that turn out not to be the nearest, and in any order.
    pub fn intersect_filtered(
        &self,
        ray: &Ray,
        t_max: f32,
        accept: impl FnMut(&TriangleHit) -> bool,
    ) -> Option<TriangleHit> {
        if stack_size(self.depth) <= SMALL_STACK {
            self.closest::<SMALL_STACK>(ray, t_max, accept)
        } else {
            self.closest::<LARGE_STACK>(ray, t_max, accept)
        }
    }

    /// Whether there is a hit with `t` in (0, t_max).
    pub fn occluded(&self, ray: &Ray, t_max: f32) -> bool {
        self.occluded_filtered(ray, t_max, |_| true)
    }

    /// Whether `accept` accepts a hit with `t` in (0, t_max). Hits come in any order, each
    /// triangle at most once, until one is accepted.
    pub fn occluded_filtered(
        &self,
        ray: &Ray,
        t_max: f32,
        accept: impl FnMut(&TriangleHit) -> bool,
    ) -> bool {
        if stack_size(self.depth) <= SMALL_STACK {
            self.any::<SMALL_STACK>(ray, t_max, accept)
        } else {
            self.any::<LARGE_STACK>(ray, t_max, accept)
        }
    }

    /// [`intersect`](Self::intersect) for each segment; `hits[i]` is that of `segments[i]`. Faster
    /// than one at a time, the more so with hundreds of segments a call; results are the same bits.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn intersect_all(&self, segments: &[Segment], hits: &mut [Option<TriangleHit>]) {
        assert_eq!(segments.len(), hits.len(), "one place for each hit");
        self.trace::<false>(None, segments, Everything, |i, hit| hits[i] = hit);
    }

    /// [`intersect_filtered`](Self::intersect_filtered) for each segment; `accept` is also told
    /// the place of the segment. It is asked about the segments in any order, by turns.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn intersect_all_filtered(
        &self,
        segments: &[Segment],
        hits: &mut [Option<TriangleHit>],
        accept: impl FnMut(usize, &TriangleHit) -> bool,
    ) {
        assert_eq!(segments.len(), hits.len(), "one place for each hit");
        self.trace::<false>(None, segments, accept, |i, hit| hits[i] = hit);
    }

    /// [`occluded`](Self::occluded) for each segment; `occluded[i]` is that of `segments[i]`.
    /// Faster than one at a time, the more so with hundreds of segments a call.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn occluded_all(&self, segments: &[Segment], occluded: &mut [bool]) {
        assert_eq!(segments.len(), occluded.len(), "one place for each answer");
        self.trace::<true>(None, segments, Everything, |i, hit| occluded[i] = hit.is_some());
    }

    /// [`occluded_filtered`](Self::occluded_filtered) for each segment; `accept` is also told the
    /// place of the segment. It is asked about the segments in any order, by turns.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn occluded_all_filtered(
        &self,
        segments: &[Segment],
        occluded: &mut [bool],
        accept: impl FnMut(usize, &TriangleHit) -> bool,
    ) {
        assert_eq!(segments.len(), occluded.len(), "one place for each answer");
        self.trace::<true>(None, segments, accept, |i, hit| occluded[i] = hit.is_some());
    }

    /// Traces a batch on the way that is asked for, or else the fastest.
    pub(crate) fn trace<const ANY: bool>(
        &self,
        way: Option<Way>,
        segments: &[Segment],
        accept: impl Accept,
        mut done: impl FnMut(usize, Option<TriangleHit>),
    ) {
        const SMALL: usize = stream_stack_size(12);
        const LARGE: usize = stream_stack_size(MAX_DEPTH);
        let Some(root) = self.root else {
            (0..segments.len()).for_each(|i| done(i, None));
            return;
        };
        let tree = Tree { nodes: &self.nodes, blocks: &self.blocks, root, bounds: &self.bounds };
        let way = way.unwrap_or(Way::of::<ANY>(self.blocks.len()));
        if stream_stack_size(self.depth) <= SMALL {
            batch::trace::<SMALL, ANY>(&tree, way, segments, accept, done);
        } else {
            batch::trace::<LARGE, ANY>(&tree, way, segments, accept, done);
        }
    }

    /// Pays once the tree is larger than the caches.
    #[inline(always)]
    fn prefetch(&self, child: ChildRef) {
        if child.is_leaf() {
            crate::simd::prefetch(&self.blocks, child.index())
        } else {
            crate::simd::prefetch(&self.nodes, child.index())
        }
    }

    /// How batches of rays go that seek the nearest hit, and any.
    #[cfg(test)]
    pub(crate) fn ways(&self) -> (Way, Way) {
        (Way::of::<false>(self.blocks.len()), Way::of::<true>(self.blocks.len()))
    }

    #[cfg(test)]
    pub(crate) fn is_same_tree(&self, o: &TriangleBvh) -> bool {
        *self.nodes == *o.nodes && *self.blocks == *o.blocks && self.root == o.root
    }

    #[inline(always)]
    fn closest<const STACK: usize>(
        &self,
        ray: &Ray,
        t_max: f32,
        mut accept: impl FnMut(&TriangleHit) -> bool,
    ) -> Option<TriangleHit> {
        let root = self.root?;
        let prepared = PreparedRay::new(ray, &self.bounds)?;
        let (lanes, scale) = (prepared.lanes(), prepared.scale);
        let t_max = t_max / scale;
        let mut best = TriangleHit { t: t_max, prim: 0, b: [0.0; 3] };
        let mut found = false;
        traverse::closest::<STACK>(
            &self.nodes,
            root,
            &prepared,
            t_max,
            |c| self.prefetch(c),
            |leaf, nearest| {
                let block = &self.blocks[leaf];
                let Some(mut hits) = block.intersect(&lanes, prepared.axes, nearest, || prepared)
                else {
                    return nearest;
                };
                while let Some(lane) = hits.pop() {
                    let Some(prim) = block.prim(lane) else { break };
                    let t = hits.t(lane);
                    if t < best.t || found && t == best.t && prim < best.prim {
                        let b = hits.b(lane);
                        if accept(&TriangleHit { t: t * scale, prim, b }) {
                            best = TriangleHit { t, prim, b };
                            found = true;
                        }
                    }
                }
                best.t
            },
        );
        best.t *= scale;
        found.then_some(best)
    }

    #[inline(always)]
    fn any<const STACK: usize>(
        &self,
        ray: &Ray,
        t_max: f32,
        mut accept: impl FnMut(&TriangleHit) -> bool,
    ) -> bool {
        let Some(root) = self.root else { return false };
        let Some(prepared) = PreparedRay::new(ray, &self.bounds) else { return false };
        let (lanes, scale) = (prepared.lanes(), prepared.scale);
        let t_max = t_max / scale;
        traverse::any::<STACK>(
            &self.nodes,
            root,
            &prepared,
            t_max,
            |c| self.prefetch(c),
            |leaf| {
                let block = &self.blocks[leaf];
                let Some(mut hits) = block.intersect(&lanes, prepared.axes, t_max, || prepared)
                else {
                    return false;
                };
                while let Some(lane) = hits.pop() {
                    let Some(prim) = block.prim(lane) else { break };
                    let t = hits.t(lane);
                    if t < t_max {
                        let hit = TriangleHit { t: t * scale, prim, b: hits.b(lane) };
                        if accept(&hit) {
                            return true;
                        }
                    }
                }
                false
            },
        )
    }
}

/// Whether the corners span a plane. Mostly told in single precision; else in double, where the
/// products of a thin triangle's edges do not underflow.
fn has_area(p: [Vec3; 3]) -> bool {
    let (e, f) = (p[1] - p[0], p[2] - p[0]);
    let clearly = |i: usize| {
        let j = (i + 1) % 3;
        let (a, b) = (e[i] * f[j], e[j] * f[i]);
        let size = a.abs() + b.abs();
        // Each product is off by less than 2⁻²² of it, edges being differences.
        size > 1e-30 && size < f32::INFINITY && (a - b).abs() > size * (1.0 / (1 << 20) as f32)
    };
    clearly(0) || clearly(1) || clearly(2) || has_area_in_double(p)
}

#[cold]
fn has_area_in_double(p: [Vec3; 3]) -> bool {
    let edge = |a: Vec3, b: Vec3| [0, 1, 2].map(|i| f64::from(b[i]) - f64::from(a[i]));
    let (e, f) = (edge(p[0], p[1]), edge(p[0], p[2]));
    (0..3).any(|i| {
        let j = (i + 1) % 3;
        e[i] * f[j] != e[j] * f[i]
    })
}
