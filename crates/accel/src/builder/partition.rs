//! Bringing the primitives of the left child before those of the right.

use rayon::prelude::*;

use super::binning::Split;
use super::{Extent, PrimRef};

/// From this many primitives on, the work is shared.
const PARALLEL: usize = 1 << 16;
/// Primitives a task then.
const CHUNK: usize = 1 << 14;

/// How many go left, and what the two sides span. `scratch` is as long as `refs`.
pub(super) fn partition(
    refs: &mut [PrimRef],
    scratch: &mut [PrimRef],
    split: &Split,
) -> (usize, Extent, Extent) {
    if refs.len() >= PARALLEL {
        return partition_shared(refs, scratch, split);
    }
    let (mut left, mut right) = (Extent::EMPTY, Extent::EMPTY);
    let (mut i, mut j) = (0, refs.len());
    while i < j {
        if split.is_left(&refs[i]) {
            left.add(&refs[i]);
            i += 1;
        } else {
            right.add(&refs[i]);
            j -= 1;
            refs.swap(i, j);
        }
    }
    (i, left, right)
}

/// Stable, chunk by chunk: each chunk counts its left ones, and the counts say where in `scratch`
/// it has to write.
fn partition_shared(
    refs: &mut [PrimRef],
    scratch: &mut [PrimRef],
    split: &Split,
) -> (usize, Extent, Extent) {
    let lefts: Vec<usize> =
        refs.par_chunks(CHUNK).map(|c| c.iter().filter(|r| split.is_left(r)).count()).collect();
    let left_count = lefts.iter().sum();
    let (mut left_rest, mut right_rest) = scratch.split_at_mut(left_count);
    let mut tasks = Vec::with_capacity(lefts.len());
    for (chunk, &n) in refs.chunks(CHUNK).zip(&lefts) {
        let (left, rest) = left_rest.split_at_mut(n);
        left_rest = rest;
        let (right, rest) = right_rest.split_at_mut(chunk.len() - n);
        right_rest = rest;
        tasks.push((chunk, left, right));
    }
    let (left, right) = tasks
        .into_par_iter()
        .map(|(chunk, left, right)| {
            let mut extents = (Extent::EMPTY, Extent::EMPTY);
            let (mut i, mut j) = (0, 0);
            for r in chunk {
                if split.is_left(r) {
                    extents.0.add(r);
                    left[i] = *r;
                    i += 1;
                } else {
                    extents.1.add(r);
                    right[j] = *r;
                    j += 1;
                }
            }
            extents
        })
        .reduce(|| (Extent::EMPTY, Extent::EMPTY), |a, b| (a.0.merge(b.0), a.1.merge(b.1)));
    refs.par_chunks_mut(CHUNK)
        .zip(scratch.par_chunks(CHUNK))
        .for_each(|(to, from)| to.copy_from_slice(from));
    (left_count, left, right)
}
