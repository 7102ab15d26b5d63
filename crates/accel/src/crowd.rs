//! Sixteen rays of one class through a small tree together, wherever they start and go.
//!
//! Lanes are rays, and each child of a node is held against all of them. That is more work than
//! each ray needs, since they want different children, but work that waits for nothing: what a
//! node leaves on the stack is decided without a branch. So it pays in small trees, of which
//! sixteen rays soon want most. In leaves lanes are rays or triangles, whichever there are fewer of
//! the other.
//!
//! Children are visited in no order, for rays that start in different places have none in common,
//! and in small trees none was found that pays for the sorting.
//!
//! Results are the bits of one ray at a time: the same boxes and triangles are met, and a traversal
//! gives one answer in any order.

use crate::accept::Accept;
use crate::classes::{self, Class};
use crate::node::{ChildRef, WIDTH};
use crate::ray::{PreparedRay, RayLanes};
use crate::simd::{F32x16, LANES, Lanes, WIDE};
use crate::stream::{Segment, Tree};
use crate::triangle::TriangleBlock;
use crate::triangle_bvh::TriangleHit;

/// Rays of a crowd.
pub(crate) const RAYS: usize = WIDE;

/// A child that waits, and the rays that meet it.
#[derive(Clone, Copy)]
struct Entry {
    rays: u32,
    child: ChildRef,
}

/// Kept from crowd to crowd.
pub(crate) struct CrowdStack<const STACK: usize> {
    entries: [Entry; STACK],
    /// Where each ray enters the child of an entry, if rays seek the nearest hit.
    at: [F32x16; STACK],
}

impl<const STACK: usize> CrowdStack<STACK> {
    pub(crate) fn new() -> Self {
        let entries = [Entry { rays: 0, child: ChildRef::node(0) }; STACK];
        CrowdStack { entries, at: [F32x16::splat(0.0); STACK] }
    }
}

/// Rays of one class.
struct Crowd<'a> {
    tree: &'a Tree<'a>,
    segments: &'a [Segment],
    /// Places of the rays among the segments; the last lanes may repeat the first.
    places: [u32; RAYS],
    class: Class,
    lanes: RayLanes<F32x16>,
}

/// What the rays have found. Passed by value: hits that are written to memory under a mask are slow
/// to read back.
#[derive(Clone, Copy)]
struct Found {
    /// The rays that have hit something.
    rays: u32,
    /// The nearest hits so far; without one, the end of the segment.
    t: F32x16,
    b: [F32x16; 3],
    /// Triangles as [numbers that compare](number); 0, below which there is none, without a hit.
    prim: F32x16,
}

/// Traces rays of one class, at least one and at most [`RAYS`]: to the nearest hit that is
/// accepted, or with `ANY` to the first that comes. `places` says which of the segments they are;
/// `accept` and `done` are told it.
#[inline(never)]
pub(crate) fn trace<const STACK: usize, const ANY: bool>(
    tree: &Tree,
    segments: &[Segment],
    class: Class,
    places: &[u32],
    stack: &mut CrowdStack<STACK>,
    accept: &mut impl Accept,
    done: &mut impl FnMut(usize, Option<TriangleHit>),
) {
    let mut all = [places[0]; RAYS];
    all[..places.len()].copy_from_slice(places);
    let (o, d, t) = classes::columns(|lane| segments[all[lane] as usize]);
    let (p, e, u) = classes::columns(|lane| segments[all[LANES + lane] as usize]);
    let o = [F32x16::join(o[0], p[0]), F32x16::join(o[1], p[1]), F32x16::join(o[2], p[2])];
    let d = [F32x16::join(d[0], e[0]), F32x16::join(d[1], e[1]), F32x16::join(d[2], e[2])];
    let lanes = RayLanes::plain(o, d, class.axes);
    let none = F32x16::splat(0.0);
    let found = Found { rays: 0, t: F32x16::join(t, u), b: [none; 3], prim: none };
    let crowd = Crowd { tree, segments, places: all, class, lanes };
    let active = (1 << places.len()) - 1;
    let found = crowd.walk::<STACK, ANY>(active, found, stack, accept);

    let (t, prim) = (found.t.to_array(), found.prim.to_array());
    let b = found.b.map(F32x16::to_array);
    for lane in Lane::of(found.rays) {
        let b = [b[0][lane], b[1][lane], b[2][lane]];
        let hit = TriangleHit { t: t[lane], prim: prim[lane].to_bits(), b };
        done(all[lane] as usize, Some(hit));
    }
    for lane in Lane::of(active & !found.rays) {
        done(all[lane] as usize, None);
    }
}

impl Crowd<'_> {
    #[inline(always)]
    fn walk<const STACK: usize, const ANY: bool>(
        &self,
        all: u32,
        mut found: Found,
        stack: &mut CrowdStack<STACK>,
        accept: &mut impl Accept,
    ) -> Found {
        let mut size = 0;
        // What is next, and the rays that meet it.
        let mut current = self.tree.root;
        let mut rays = all;
        loop {
            if current.is_leaf() {
                let block = &self.tree.blocks[current.index()];
                found = self.leaf::<ANY, _>(block, rays, found, accept);
                if ANY && found.rays == all {
                    return found;
                }
            } else {
                let node = &self.tree.nodes[current.index()];
                for slot in 0..WIDTH {
                    let (met, at) =
                        node.intersect_child(slot, &self.lanes, self.class.negative, found.t);
                    let entry = Entry { rays: met & rays, child: node.child(slot) };
                    // Written in any case, counted if any ray meets it.
                    let top = size.min(STACK - 1);
                    stack.entries[top] = entry;
                    if !ANY {
                        stack.at[top] = at;
                    }
                    size += usize::from(entry.rays != 0);
                }
            }
            loop {
                if size == 0 {
                    return found;
                }
                size -= 1;
                let top = size.min(STACK - 1);
                let entry = stack.entries[top];
                let left = if ANY { !found.rays } else { stack.at[top].le(found.t) };
                rays = entry.rays & left;
                if rays != 0 {
                    current = entry.child;
                    break;
                }
            }
        }
    }

    #[inline(always)]
    fn leaf<const ANY: bool, A: Accept>(
        &self,
        block: &TriangleBlock,
        rays: u32,
        mut found: Found,
        accept: &mut A,
    ) -> Found {
        if (rays.count_ones() as usize) >= block.count() {
            return self.triangles_of_leaf::<ANY, A>(block, rays, found, accept);
        }
        for lane in Lane::of(rays) {
            found = self.ray_of_leaf::<ANY>(lane, block, found, accept);
        }
        found
    }

    /// Holds each triangle against all rays.
    #[inline(always)]
    fn triangles_of_leaf<const ANY: bool, A: Accept>(
        &self,
        block: &TriangleBlock,
        mut rays: u32,
        mut found: Found,
        accept: &mut A,
    ) -> Found {
        let slabs = block.slabs(self.class.negative);
        for triangle in 0..block.count() {
            let Some(prim) = block.prim(triangle) else { break };
            let (lanes, axes) = (&self.lanes, self.class.axes);
            let hits = block.intersect_one(triangle, &slabs, lanes, axes, rays, found.t, |lane| {
                self.prepared(lane)
            });
            let Some(hits) = hits else { continue };
            let number = F32x16::splat(number(prim));
            let mut better = hits.t.lt(found.t);
            if !ANY {
                better |= hits.t.le(found.t) & number.lt(found.prim);
            }
            better &= hits.lanes;
            if !A::ALL {
                let (t, b) = (hits.t.to_array(), hits.b.map(F32x16::to_array));
                for lane in Lane::of(better) {
                    let hit = TriangleHit { t: t[lane], prim, b: b.map(|b| b[lane]) };
                    let accepted = accept.accept(self.places[lane] as usize, &hit);
                    better &= !(u32::from(!accepted) << lane);
                }
            }
            found.rays |= better;
            if !ANY {
                found = found.with(better, hits.t, number, hits.b);
                continue;
            }
            rays &= !better;
            if rays == 0 {
                break;
            }
        }
        found
    }

    /// Holds one ray against all triangles.
    #[inline(always)]
    fn ray_of_leaf<const ANY: bool>(
        &self,
        lane: usize,
        block: &TriangleBlock,
        mut found: Found,
        accept: &mut impl Accept,
    ) -> Found {
        let ray = self.lanes.map(|v| v.broadcast(lane));
        let mut nearest = found.t.to_array()[lane];
        let hits = block.intersect(&ray, self.class.axes, nearest, || self.prepared(lane));
        let Some(mut hits) = hits else { return found };
        let bit = 1 << lane;
        while let Some(triangle) = hits.pop() {
            let Some(prim) = block.prim(triangle) else { break };
            let (t, b) = (hits.t(triangle), hits.b(triangle));
            let tie = !ANY && t == nearest && number(prim) < found.prim.to_array()[lane];
            if (t < nearest || tie)
                && accept.accept(self.places[lane] as usize, &TriangleHit { t, prim, b })
            {
                found.rays |= bit;
                if ANY {
                    break;
                }
                nearest = t;
                let number = F32x16::splat(number(prim));
                found = found.with(bit, F32x16::splat(t), number, b.map(F32x16::splat));
            }
        }
        found
    }

    /// The ray of a lane again, for doubtful hits. There is one, or it would be in no class.
    #[cold]
    fn prepared(&self, lane: usize) -> PreparedRay {
        let ray = &self.segments[self.places[lane % RAYS] as usize].ray;
        PreparedRay::new(ray, self.tree.bounds).unwrap_or(PreparedRay::NONE)
    }
}

impl Found {
    /// With these hits for some rays.
    #[inline(always)]
    fn with(self, rays: u32, t: F32x16, prim: F32x16, b: [F32x16; 3]) -> Found {
        let ([b0, b1, b2], [c0, c1, c2]) = (self.b, b);
        Found {
            rays: self.rays,
            t: self.t.select(rays, t),
            b: [b0.select(rays, c0), b1.select(rays, c1), b2.select(rays, c2)],
            prim: self.prim.select(rays, prim),
        }
    }
}

/// The number of a triangle as a float of the same bits. All are below 2³⁰, so that these are
/// floats below 2 which compare as the numbers do.
#[inline(always)]
fn number(prim: u32) -> f32 {
    f32::from_bits(prim)
}

/// The lanes of a mask, from the lowest.
struct Lane(u32);

impl Lane {
    #[inline(always)]
    fn of(mask: u32) -> Lane {
        Lane(mask)
    }
}

impl Iterator for Lane {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros() as usize;
        self.0 &= self.0.wrapping_sub(1);
        (lane < RAYS).then_some(lane)
    }
}
