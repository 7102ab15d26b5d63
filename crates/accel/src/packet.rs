//! Eight rays of nearly one way, through the tree together.
//!
//! Lanes are rays. At a node the bundle as a whole is held against the eight children first
//! ([`Bundle`]), in one test that lets too many pass; then each child that is left against the
//! eight rays, with the operations of the test of one ray. At a leaf lanes are rays or triangles,
//! whichever there are fewer of the other.
//!
//! Rays that seek any hit do not go this way. They stop at different places, so that soon few are
//! left, and there is no nearest child that all would want first: no gain was measured.
//!
//! Results are the bits of one ray at a time: the same boxes and triangles are met, and a traversal
//! gives one answer in any order.

use kaustika_math::{Bounds3, Ray};

use crate::node::{ChildRef, Node, WIDTH};
use crate::ray::{LATER, PreparedRay, RayLanes, widened};
use crate::simd::{F32x8, LANES, Lanes};
use crate::stream::{Segment, Tree};
use crate::triangle::{Hits, TriangleBlock};
use crate::triangle_bvh::TriangleHit;

/// Least cosine between directions of a packet.
const MIN_COSINE: f32 = 0.995;
/// Largest distance between origins of a packet, in diagonals of the tree's bounds.
const MAX_DISTANCE: f32 = 1.0 / 64.0;

/// Rays that share the signs of their directions and the order of axes in the triangle test.
pub(crate) struct Packet {
    lanes: RayLanes<F32x8>,
    axes: [u8; 3],
    negative: [u8; 3],
    bundle: Bundle,
    t_max: [f32; LANES],
}

impl Packet {
    /// `None` if the rays part too soon to be worth it, or if one needs special care. Rays in all
    /// directions are told after two.
    #[inline(always)]
    pub(crate) fn new(segments: &[Segment; LANES], bounds: &Bounds3) -> Option<Packet> {
        let first = segments[0].ray;
        let reach = (bounds.max - bounds.min).length() * MAX_DISTANCE;
        let similar = |s: &Segment| {
            let (d, e) = (first.d, s.ray.d);
            let dot = d.dot(e);
            let least = MIN_COSINE * MIN_COSINE * d.length_squared() * e.length_squared();
            dot > 0.0 && dot * dot >= least && (s.ray.o - first.o).length_squared() <= reach * reach
        };
        if !segments[1..].iter().all(similar) {
            return None;
        }
        Packet::prepare(segments, bounds)
    }

    #[inline(never)]
    fn prepare(segments: &[Segment; LANES], bounds: &Bounds3) -> Option<Packet> {
        let mut numbers = [[0.0; LANES]; 7];
        for (lane, Segment { ray: Ray { o, d, .. }, t_max }) in segments.iter().enumerate() {
            let all = [o.x, o.y, o.z, d.x, d.y, d.z, *t_max];
            numbers.iter_mut().zip(all).for_each(|(row, v)| row[lane] = v);
        }
        let [ox, oy, oz, dx, dy, dz, t_max] = numbers;
        let [o, d] = [[ox, oy, oz], [dx, dy, dz]].map(|v| v.map(|v| F32x8::load(&v)));
        let (lanes, axes, negative) = RayLanes::alike(o, d, bounds)?;
        let bundle = Bundle::new(o, &lanes, negative, bounds);
        Some(Packet { lanes, axes, negative, bundle, t_max })
    }
}

/// For each axis a line under the distances at which the rays meet a plane first, and one above
/// those at which they meet it last: distances as functions of the plane's place.
///
/// A ray's distance is a rising (or falling) affine function of the place. The least of eight such
/// is concave, so its chord between two places is below it between them; the greatest is convex,
/// and its chord above. One of the places is the end of the tree's bounds that the rays leave by.
/// The other is the end they enter by, or a little before all origins if these are beyond: planes
/// before that are behind all rays, for which entries count as 0 and exits let nothing pass,
/// so that the lines only have to be negative there.
struct Bundle {
    near: [(f32, f32); 3],
    far: [(f32, f32); 3],
}

impl Bundle {
    fn new(o: [F32x8; 3], lanes: &RayLanes<F32x8>, negative: [u8; 3], bounds: &Bounds3) -> Bundle {
        let bounds = widened(bounds);
        let size = bounds.min.abs().max(bounds.max.abs()).max_component();
        let mut bundle = Bundle { near: [(0.0, 0.0); 3], far: [(0.0, 0.0); 3] };
        for axis in 0..3 {
            let (lo, hi) = (bounds.min[axis], bounds.max[axis]);
            let (from, to) = if negative[axis] != 0 {
                (before(o[axis].greatest(), size, 1.0).clamp(lo, hi), lo)
            } else {
                (before(o[axis].least(), size, -1.0).clamp(lo, hi), hi)
            };
            let at = |plane: f32, c: F32x8| F32x8::splat(plane).mul_add(lanes.inv_d[axis], c);
            let near = [from, to].map(|plane| at(plane, lanes.near_c[axis]).least());
            let far = [from, to].map(|plane| at(plane, lanes.far_c[axis]).greatest());
            bundle.near[axis] = line([from, to], near, -1.0);
            bundle.far[axis] = line([from, to], far, 1.0);
        }
        bundle
    }

    /// The children that any of the rays may meet before or at `t_max`, and maybe some more.
    #[inline(always)]
    fn intersect(&self, node: &Node, negative: [u8; 3], t_max: f32) -> u32 {
        let (mut entry, mut exit) = (F32x8::splat(0.0), F32x8::splat(t_max));
        for axis in 0..3 {
            let [near, far] = node.near_and_far(axis, negative);
            let ((a, b), (c, d)) = (self.near[axis], self.far[axis]);
            entry = near.mul_add(F32x8::splat(a), F32x8::splat(b)).max(entry);
            exit = far.mul_add(F32x8::splat(c), F32x8::splat(d)).min(exit);
        }
        entry.le(exit * F32x8::splat(LATER))
    }
}

/// A place where the distances of all rays from `o` on are negative, even as `near_c` and `far_c`
/// have them.
fn before(o: f32, size: f32, direction: f32) -> f32 {
    o + direction * (o.abs() + size) * (1.0 / (1 << 20) as f32)
}

/// Slope and offset of the line through two points, moved up or down by more than is lost to
/// rounding here and when it is evaluated.
fn line(x: [f32; 2], y: [f32; 2], direction: f64) -> (f32, f32) {
    let ([x0, x1], [y0, y1]) = (x.map(f64::from), y.map(f64::from));
    let slope = if x0 == x1 { 0.0 } else { (y1 - y0) / (x1 - x0) };
    let offset = y0 - slope * x0;
    let size = slope.abs() * x0.abs().max(x1.abs()) + y0.abs() + y1.abs() + offset.abs();
    (slope as f32, (offset + direction * size * (1.0 / f64::from(1 << 20))) as f32)
}

/// A child on the stack, and where each ray enters it: infinity if it does not.
#[derive(Clone, Copy)]
struct Entry {
    at: F32x8,
    child: ChildRef,
}

/// Kept from packet to packet.
pub(crate) struct PacketStack<const STACK: usize>([Entry; STACK]);

impl<const STACK: usize> PacketStack<STACK> {
    pub(crate) fn new() -> Self {
        PacketStack([Entry { at: F32x8::splat(0.0), child: ChildRef::node(0) }; STACK])
    }
}

/// What the rays have found.
struct Found {
    /// The nearest hits so far; without one, the end of the segment.
    t: [f32; LANES],
    hits: [Option<(u32, [f32; 3])>; LANES],
}

/// Traces the rays to the nearest hits that are accepted.
/// `accept` is told the lane. Returns the hits. The packet was made of `segments`.
#[inline(always)]
pub(crate) fn trace<const STACK: usize>(
    tree: &Tree,
    packet: &Packet,
    segments: &[Segment; LANES],
    stack: &mut PacketStack<STACK>,
    mut accept: impl FnMut(usize, &TriangleHit) -> bool,
) -> [Option<TriangleHit>; LANES] {
    let stack = &mut stack.0;
    let negative = packet.negative;
    // For doubtful hits; `Packet::new` has seen that there is one.
    let alone = |lane: usize| {
        PreparedRay::new(&segments[lane].ray, tree.bounds).unwrap_or(PreparedRay::NONE)
    };
    let mut found = Found { t: packet.t_max, hits: [None; LANES] };
    let mut size = 0;
    let mut current = tree.root;
    // The rays that meet what is current.
    let mut mask = 0xff;
    'walk: loop {
        if current.is_leaf() {
            let block = &tree.blocks[current.index()];
            found.leaf(packet, block, mask, &alone, &mut accept);
        } else {
            let node = &tree.nodes[current.index()];
            let far = found.t.into_iter().fold(f32::NEG_INFINITY, f32::max);
            let t = F32x8::load(&found.t);
            let mut candidates = packet.bundle.intersect(node, negative, far);
            let base = size;
            let mut keys = [0u32; WIDTH];
            while candidates != 0 {
                let slot = candidates.trailing_zeros() as usize % WIDTH;
                candidates &= candidates - 1;
                let (hit, at) = node.intersect_child(slot, &packet.lanes, negative, t);
                let hit = hit & mask;
                if hit == 0 {
                    continue;
                }
                // Far ones first, by the first ray.
                let at = at.select(!hit, F32x8::splat(f32::INFINITY));
                let key = at.to_array()[hit.trailing_zeros() as usize % LANES].to_bits();
                let mut i = size;
                while i > base && keys[(i - base - 1) % WIDTH] < key {
                    keys[(i - base) % WIDTH] = keys[(i - base - 1) % WIDTH];
                    stack[i] = stack[i - 1];
                    i -= 1;
                }
                keys[(i - base) % WIDTH] = key;
                stack[i] = Entry { at, child: node.child(slot) };
                size += 1;
            }
        }
        loop {
            if size == 0 {
                break 'walk;
            }
            size -= 1;
            let entry = stack[size];
            mask = entry.at.le(F32x8::load(&found.t));
            if mask != 0 {
                current = entry.child;
                break;
            }
        }
    }
    std::array::from_fn(|lane| {
        let (prim, b) = found.hits[lane]?;
        Some(TriangleHit { t: found.t[lane], prim, b })
    })
}

impl Found {
    #[inline(always)]
    fn leaf(
        &mut self,
        packet: &Packet,
        block: &TriangleBlock,
        mask: u32,
        alone: &impl Fn(usize) -> PreparedRay,
        accept: &mut impl FnMut(usize, &TriangleHit) -> bool,
    ) {
        let triangles = block.count();
        if (mask.count_ones() as usize) < triangles {
            for lane in (0..LANES).filter(|lane| mask >> lane & 1 != 0) {
                let ray = packet.lanes.map(|v| v.broadcast(lane));
                let hits = block.intersect(&ray, packet.axes, self.t[lane], || alone(lane));
                if let Some(mut hits) = hits {
                    while let Some(triangle) = hits.pop() {
                        let Some(prim) = block.prim(triangle) else { break };
                        self.hit(lane, prim, &hits, triangle, accept);
                    }
                }
            }
            return;
        }
        let slabs = block.slabs(packet.negative);
        for triangle in 0..triangles {
            let Some(prim) = block.prim(triangle) else { break };
            let t = F32x8::load(&self.t);
            let rays = &packet.lanes;
            let hits = block.intersect_one(triangle, &slabs, rays, packet.axes, mask, t, alone);
            if let Some(mut hits) = hits.map(Hits::from) {
                while let Some(lane) = hits.pop() {
                    self.hit(lane, prim, &hits, lane, accept);
                }
            }
        }
    }

    /// Takes note of the hit of ray `lane` at `place` of `hits`.
    #[inline(always)]
    fn hit(
        &mut self,
        lane: usize,
        prim: u32,
        hits: &Hits,
        place: usize,
        accept: &mut impl FnMut(usize, &TriangleHit) -> bool,
    ) {
        let (t, b) = (hits.t(place), hits.b(place));
        let tie = t == self.t[lane] && self.hits[lane].is_some_and(|(nearest, _)| prim < nearest);
        if (t < self.t[lane] || tie) && accept(lane, &TriangleHit { t, prim, b }) {
            (self.t[lane], self.hits[lane]) = (t, Some((prim, b)));
        }
    }
}
