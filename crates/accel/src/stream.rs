//! Many rays under way at once, each a step at a time.
//!
//! A ray alone waits: for nodes and triangles that are not in the cache, and after each
//! mispredicted branch (is there a hit, is this a leaf, which child is nearest) for a long chain of
//! dependent operations. Here sixteen rays are in flight side by side. A round takes each one step
//! on, the test of a node or of a leaf, and ends with asking for what the next step needs, which
//! then has the steps of fifteen others to arrive.
//!
//! What a ray does next sorts it into a list without a branch, and the loops over the lists are
//! kept apart by what they decide: all nodes; all leaves, but only whether the ray may hit anything
//! there; those it may hit; and last, what comes next from the stack. So no branch that is hard to
//! predict stands behind a long computation.
//!
//! Which rays share a call does not matter to their results: each keeps to itself, and a traversal
//! gives one answer in any order.

use kaustika_math::{Bounds3, Ray};

use crate::node::{ChildRef, Node};
use crate::ray::PreparedRay;
use crate::simd::{self, F32x8, LANES, Lanes};
use crate::traverse::stack_size;
use crate::triangle::TriangleBlock;
use crate::triangle_bvh::TriangleHit;

/// A ray and where it ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Any ray; one that is not finite, or has no direction, hits nothing.
    pub ray: Ray,
    /// In lengths of the ray's direction; hits are before it. May be infinite.
    pub t_max: f32,
}

/// What is traversed.
#[derive(Clone, Copy)]
pub(crate) struct Tree<'a> {
    pub(crate) nodes: &'a [Node],
    pub(crate) blocks: &'a [TriangleBlock],
    pub(crate) root: ChildRef,
    pub(crate) bounds: &'a Bounds3,
}

/// Rays under way at once. With 8 all is slower, by 5 to 20 %, and 24 are no faster.
const IN_FLIGHT: usize = 16;

/// Stack entries that suffice for a tree of this depth: also one at the bottom that stands for the
/// end, and the unused ones of the eight that are written at a time.
pub(crate) const fn stream_stack_size(depth: usize) -> usize {
    (1 + stack_size(depth) + LANES).next_multiple_of(LANES)
}

/// At the bottom of each stack. Neither a leaf, nor the number of any node.
const END: ChildRef = ChildRef(1 << 30);
/// Nodes and blocks have to be fewer.
pub(crate) const MAX_ITEMS: usize = 1 << 30;

/// What a ray does next: the two top bits of a reference.
fn kind(next: ChildRef) -> usize {
    (next.0 >> 30) as usize
}
const INNER: usize = 0;
const DONE: usize = 1;
const LEAF: usize = 2;

/// A ray under way.
#[repr(C, align(64))]
struct Flight<const STACK: usize> {
    ray: PreparedRay,
    /// A node or a leaf to be tested.
    current: ChildRef,
    /// Entries on the stack.
    size: u32,
    /// The nearest hit so far; without one, `t` is the end of the segment.
    best: TriangleHit,
    found: bool,
    /// Which segment this is.
    index: usize,
    /// Bits of the distance at which each entry of the stack is entered, if rays seek the nearest
    /// hit: falling from the bottom on, but for an entry's siblings and what is above them.
    keys: [u32; STACK],
    refs: [ChildRef; STACK],
}

/// Flights by what they do next.
#[derive(Clone, Copy)]
struct Lists {
    places: [[u8; IN_FLIGHT]; 3],
    counts: [usize; 3],
}

impl Lists {
    const EMPTY: Lists = Lists { places: [[0; IN_FLIGHT]; 3], counts: [0; 3] };

    #[inline(always)]
    fn push(&mut self, kind: usize, place: u8) {
        let kind = kind.min(2);
        let count = &mut self.counts[kind];
        self.places[kind][*count % IN_FLIGHT] = place;
        *count += 1;
    }

    #[inline(always)]
    fn of(&self, kind: usize) -> impl Iterator<Item = u8> {
        (0..self.counts[kind]).map(move |i| self.places[kind][i % IN_FLIGHT])
    }
}

/// Traces `segments`: to the nearest hit that is accepted, or with `ANY` to the first that comes.
/// `accept` and `done` are told the number of the segment; `done` hears of each once, in any order.
pub(crate) fn trace<const STACK: usize, const ANY: bool>(
    tree: &Tree,
    mut segments: impl Iterator<Item = (usize, Segment)>,
    mut accept: impl FnMut(usize, &TriangleHit) -> bool,
    mut done: impl FnMut(usize, Option<TriangleHit>),
) {
    const { assert!(STACK.is_multiple_of(LANES)) };
    let mut flights: [Flight<STACK>; IN_FLIGHT] = std::array::from_fn(|_| Flight::EMPTY);
    let mut free: [u8; IN_FLIGHT] = std::array::from_fn(|i| i as u8);
    let mut free_count = IN_FLIGHT;
    let mut now = Lists::EMPTY;
    loop {
        while free_count > 0
            && let Some((index, segment)) = segments.next()
        {
            let Some(ray) = PreparedRay::new(&segment.ray, tree.bounds) else {
                done(index, None);
                continue;
            };
            free_count -= 1;
            let place = free[free_count];
            flights[usize::from(place) % IN_FLIGHT].start(ray, segment.t_max, index, tree.root);
            now.push(kind(tree.root), place);
        }
        if now.counts[INNER] + now.counts[LEAF] == 0 {
            return;
        }

        for place in now.of(INNER) {
            flights[usize::from(place) % IN_FLIGHT].enter::<ANY>(tree);
        }
        let mut candidates = [0u8; IN_FLIGHT];
        let mut candidate_count = 0;
        for place in now.of(LEAF) {
            let flight = &flights[usize::from(place) % IN_FLIGHT];
            candidates[candidate_count % IN_FLIGHT] = place;
            candidate_count += usize::from(flight.may_hit(tree));
        }
        for i in 0..candidate_count {
            let place = candidates[i % IN_FLIGHT];
            flights[usize::from(place) % IN_FLIGHT].hit::<ANY>(tree, &mut accept);
        }

        let mut then = Lists::EMPTY;
        for list in [INNER, LEAF] {
            for place in now.of(list) {
                let next = flights[usize::from(place) % IN_FLIGHT].pop();
                let index = (next.0 & (END.0 - 1)) as usize;
                simd::prefetch_either(tree.nodes, tree.blocks, next.is_leaf(), index);
                then.push(kind(next), place);
            }
        }
        for place in then.of(DONE) {
            let flight = &flights[usize::from(place) % IN_FLIGHT];
            let mut hit = flight.best;
            hit.t *= flight.ray.scale;
            done(flight.index, flight.found.then_some(hit));
            free[free_count % IN_FLIGHT] = place;
            free_count += 1;
        }
        then.counts[DONE] = 0;
        now = then;
    }
}

impl<const STACK: usize> Flight<STACK> {
    const EMPTY: Self = Flight {
        ray: PreparedRay::NONE,
        current: END,
        size: 0,
        best: TriangleHit { t: 0.0, prim: 0, b: [0.0; 3] },
        found: false,
        index: 0,
        keys: [0; STACK],
        refs: [END; STACK],
    };

    #[inline(always)]
    fn start(&mut self, ray: PreparedRay, t_max: f32, index: usize, root: ChildRef) {
        self.best = TriangleHit { t: t_max / ray.scale, prim: 0, b: [0.0; 3] };
        (self.ray, self.found, self.index) = (ray, false, index);
        // What is at the bottom stays there: no key is below its 0.
        (self.current, self.size) = (root, 1);
    }

    /// Tests a node, and puts the children that are hit on the stack.
    #[inline(always)]
    fn enter<const ANY: bool>(&mut self, tree: &Tree) {
        let node = &tree.nodes[self.current.index()];
        let lanes = self.ray.lanes();
        let (mask, entry) = node.intersect(&lanes, self.ray.negative, F32x8::splat(self.best.t));
        let at = (self.size as usize).min(STACK - LANES);
        let refs = (&mut self.refs[at..at + LANES]).try_into().expect("eight lanes");
        if ANY {
            simd::push_hits(mask, node.refs(), refs);
        } else {
            let keys = (&mut self.keys[at..at + LANES]).try_into().expect("eight lanes");
            simd::push_sorted(mask, entry, node.refs(), keys, refs);
        }
        self.size += mask.count_ones();
    }

    #[inline(always)]
    fn may_hit(&self, tree: &Tree) -> bool {
        tree.blocks[self.current.index()].may_intersect(&self.ray.lanes(), self.ray.axes)
    }

    /// Tests a leaf, and takes off the stack what lies beyond the hit.
    #[inline(always)]
    fn hit<const ANY: bool>(
        &mut self,
        tree: &Tree,
        accept: &mut impl FnMut(usize, &TriangleHit) -> bool,
    ) {
        let block = &tree.blocks[self.current.index()];
        let lanes = self.ray.lanes();
        let Some(mut hits) = block.intersect(&lanes, self.ray.axes, self.best.t, || self.ray)
        else {
            return;
        };
        let mut better = false;
        while let Some(lane) = hits.pop() {
            let Some(prim) = block.prim(lane) else { break };
            let t = hits.t(lane);
            let tie = !ANY && self.found && t == self.best.t && prim < self.best.prim;
            if t < self.best.t || tie {
                let b = hits.b(lane);
                if accept(self.index, &TriangleHit { t: t * self.ray.scale, prim, b }) {
                    self.best = TriangleHit { t, prim, b };
                    (self.found, better) = (true, true);
                    if ANY {
                        break;
                    }
                }
            }
        }
        if better {
            self.size = if ANY {
                1
            } else {
                let (size, limit) = (self.size as usize, self.best.t.to_bits());
                simd::keep_below(&mut self.keys, &mut self.refs, size, limit) as u32
            };
        }
    }

    #[inline(always)]
    fn pop(&mut self) -> ChildRef {
        self.size = self.size.wrapping_sub(1);
        self.current = self.refs[(self.size as usize).min(STACK - 1)];
        self.current
    }
}
