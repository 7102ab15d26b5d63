//! Traversal stacks in plain Rust: the fallback, and the twin the intrinsics are tested against.
//! What the functions do is said in `stack_avx2`.

use super::portable::F32x8;
use super::{LANES, Lanes};
use crate::node::ChildRef;

pub(crate) fn push_hits(mask: u32, children: &[ChildRef; LANES], refs: &mut [ChildRef; LANES]) {
    let hits = (0..LANES).filter(|slot| mask >> slot & 1 != 0);
    for (to, slot) in hits.enumerate() {
        refs[to] = children[slot];
    }
}

pub(crate) fn push_sorted(
    mask: u32,
    entry: F32x8,
    children: &[ChildRef; LANES],
    keys: &mut [u32; LANES],
    refs: &mut [ChildRef; LANES],
) {
    let entry = entry.to_array();
    let hits = (0..LANES).filter(|slot| mask >> slot & 1 != 0);
    for (count, slot) in hits.enumerate() {
        let key = entry[slot].to_bits() & !7;
        let mut at = count;
        while at > 0 && keys[at - 1] <= key {
            (keys[at], refs[at]) = (keys[at - 1], refs[at - 1]);
            at -= 1;
        }
        (keys[at], refs[at]) = (key, children[slot]);
    }
}

pub(crate) fn keep_below<const N: usize>(
    keys: &mut [u32; N],
    refs: &mut [ChildRef; N],
    size: usize,
    limit: u32,
) -> usize {
    let mut kept = 0;
    for at in 0..size.min(N) {
        if keys[at] <= limit {
            (keys[kept], refs[kept]) = (keys[at], refs[at]);
            kept += 1;
        }
    }
    kept
}
