//! Walking the tree with one ray.

use crate::node::{ChildRef, Node, WIDTH};
use crate::ray::PreparedRay;
use crate::simd::{F32x8, Lanes};

/// Stack entries that suffice for a tree of this depth.
pub(crate) const fn stack_size(depth: usize) -> usize {
    depth * (WIDTH - 1) + 1
}

/// Entries of the small stack; a tree that may need more gets [`LARGE_STACK`].
pub(crate) const SMALL_STACK: usize = 96;
/// Enough for any tree of the builder.
pub(crate) const LARGE_STACK: usize = stack_size(crate::builder::MAX_DEPTH);

/// Visits leaves from near to far. `leaf(index, t)` tests what it holds up to distance `t` and
/// returns the distance beyond which nothing is of interest any more; leaves entered exactly
/// there are still visited. `prefetch` is told of children that will have to wait.
#[inline(always)]
pub(crate) fn closest<const STACK: usize>(
    nodes: &[Node],
    root: ChildRef,
    ray: &PreparedRay,
    t_max: f32,
    prefetch: impl Fn(ChildRef),
    mut leaf: impl FnMut(usize, f32) -> f32,
) {
    // An entry has the distance in its upper half: as the bits of a positive float, it sorts.
    let mut stack = [0u64; STACK];
    let mut size = 0;
    let mut nearest = t_max;
    let mut current = root;
    let lanes = ray.lanes();
    loop {
        'descend: while !current.is_leaf() {
            let node = &nodes[current.index()];
            let (mut hits, entry) = node.intersect(&lanes, ray.negative, F32x8::splat(nearest));
            if hits == 0 {
                break 'descend;
            }
            let entry = entry.to_array();
            let mut next = || {
                let slot = hits.trailing_zeros() as usize % WIDTH;
                hits &= hits - 1;
                let key = (u64::from(entry[slot].to_bits()) << 32) | u64::from(node.child(slot).0);
                (key, hits == 0)
            };
            let (first, last) = next();
            if last {
                current = ChildRef(first as u32);
                continue;
            }
            let (second, last) = next();
            if last {
                stack[size] = first.max(second);
                prefetch(ChildRef(stack[size] as u32));
                size += 1;
                current = ChildRef(first.min(second) as u32);
                continue;
            }
            let base = size;
            stack[size] = first.max(second);
            stack[size + 1] = first.min(second);
            prefetch(ChildRef(first as u32));
            prefetch(ChildRef(second as u32));
            size += 2;
            loop {
                // Insert: the nearest comes last.
                let (key, last) = next();
                prefetch(ChildRef(key as u32));
                let mut i = size;
                while i > base && stack[i - 1] < key {
                    stack[i] = stack[i - 1];
                    i -= 1;
                }
                stack[i] = key;
                size += 1;
                if last {
                    break;
                }
            }
            size -= 1;
            current = ChildRef(stack[size] as u32);
        }
        if current.is_leaf() {
            nearest = leaf(current.index(), nearest);
        }
        loop {
            if size == 0 {
                return;
            }
            size -= 1;
            let key = stack[size];
            if f32::from_bits((key >> 32) as u32) <= nearest {
                current = ChildRef(key as u32);
                break;
            }
        }
    }
}

/// Visits leaves that the ray meets before `t_max`, in no order, until `leaf` returns true, and
/// returns whether it did.
#[inline(always)]
pub(crate) fn any<const STACK: usize>(
    nodes: &[Node],
    root: ChildRef,
    ray: &PreparedRay,
    t_max: f32,
    prefetch: impl Fn(ChildRef),
    mut leaf: impl FnMut(usize) -> bool,
) -> bool {
    let mut stack = [0u32; STACK];
    let mut size = 0;
    let t_max = F32x8::splat(t_max);
    let mut current = root;
    let lanes = ray.lanes();
    loop {
        if current.is_leaf() {
            if leaf(current.index()) {
                return true;
            }
        } else {
            let node = &nodes[current.index()];
            let (mut hits, _) = node.intersect(&lanes, ray.negative, t_max);
            while hits != 0 {
                let child = node.child(hits.trailing_zeros() as usize);
                prefetch(child);
                stack[size] = child.0;
                size += 1;
                hits &= hits - 1;
            }
        }
        if size == 0 {
            return false;
        }
        size -= 1;
        current = ChildRef(stack[size]);
    }
}
