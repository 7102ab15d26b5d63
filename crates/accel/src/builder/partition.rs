//! Bringing the primitives of the left child before those of the right.

use rayon::prelude::*;

use super::PrimRef;
use super::binning::Split;
use super::boxes::{Box8, Extent};

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
    let [left, right] = if refs.len() >= PARALLEL {
        partition_shared(refs, scratch, split)
    } else {
        partition_alone(refs, split)
    };
    let [l, r] = split.bounds;
    (split.left_count, Extent { bounds: l, centers: left }, Extent { bounds: r, centers: right })
}

/// The boxes of the doubled centres of the two sides.
fn partition_alone(refs: &mut [PrimRef], split: &Split) -> [Box8; 2] {
    let (mut left, mut right) = (Box8::EMPTY, Box8::EMPTY);
    let (mut i, mut j) = (0, refs.len());
    while i < j {
        if split.is_left(&refs[i]) {
            left.grow(&refs[i].center_box());
            i += 1;
        } else {
            right.grow(&refs[i].center_box());
            j -= 1;
            refs.swap(i, j);
        }
    }
    [left, right]
}

/// Stable, chunk by chunk: each chunk counts its left ones, and the counts say where in `scratch`
/// it has to write.
fn partition_shared(refs: &mut [PrimRef], scratch: &mut [PrimRef], split: &Split) -> [Box8; 2] {
    let lefts: Vec<usize> =
        refs.par_chunks(CHUNK).map(|c| c.iter().filter(|r| split.is_left(r)).count()).collect();
    let (mut left_rest, mut right_rest) = scratch.split_at_mut(split.left_count);
    let mut tasks = Vec::with_capacity(lefts.len());
    for (chunk, &n) in refs.chunks(CHUNK).zip(&lefts) {
        let (left, rest) = left_rest.split_at_mut(n);
        left_rest = rest;
        let (right, rest) = right_rest.split_at_mut(chunk.len() - n);
        right_rest = rest;
        tasks.push((chunk, left, right));
    }
    let centers = tasks
        .into_par_iter()
        .map(|(chunk, left, right)| {
            let mut centers = [Box8::EMPTY; 2];
            let (mut i, mut j) = (0, 0);
            for r in chunk {
                if split.is_left(r) {
                    centers[0].grow(&r.center_box());
                    left[i] = *r;
                    i += 1;
                } else {
                    centers[1].grow(&r.center_box());
                    right[j] = *r;
                    j += 1;
                }
            }
            centers
        })
        .reduce(|| [Box8::EMPTY; 2], |a, b| [a[0].union(b[0]), a[1].union(b[1])]);
    refs.par_chunks_mut(CHUNK)
        .zip(scratch.par_chunks(CHUNK))
        .for_each(|(to, from)| to.copy_from_slice(from));
    centers
}
