//! Bringing the primitives of the left child before those of the right.

use rayon::prelude::*;

use super::PrimRef;
use super::binning::Split;
use super::boxes::{Box8, Extent};

/// From this many primitives on, the work is shared.
const PARALLEL: usize = 1 << 16;
/// Primitives a task then.
const CHUNK: usize = 1 << 14;

/// What the two sides span; the left one has `split.left_count` primitives.
pub(super) fn partition(refs: &mut [PrimRef], split: &Split) -> [Extent; 2] {
    let (_, [left, right]) = if refs.len() >= PARALLEL {
        partition_shared(refs, split)
    } else {
        partition_alone(refs, split)
    };
    let [l, r] = split.bounds;
    [Extent { bounds: l, centers: left }, Extent { bounds: r, centers: right }]
}

/// How many go left, and the boxes of the doubled centres of the two sides.
fn partition_alone(refs: &mut [PrimRef], split: &Split) -> (usize, [Box8; 2]) {
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
    (i, [left, right])
}

/// Each chunk alone; then the right ones that lie too far left change places with the left ones
/// that lie too far right.
fn partition_shared(refs: &mut [PrimRef], split: &Split) -> (usize, [Box8; 2]) {
    let chunks: Vec<(usize, [Box8; 2])> =
        refs.par_chunks_mut(CHUNK).map(|chunk| partition_alone(chunk, split)).collect();
    let left_count = chunks.iter().map(|c| c.0).sum();

    let (mut lower, mut upper) = refs.split_at_mut(left_count);
    let (mut rights, mut lefts) = (Vec::new(), Vec::new());
    for (left, _) in &chunks {
        let below = lower.len().min(CHUNK);
        let (chunk, rest) = lower.split_at_mut(below);
        lower = rest;
        rights.push(&mut chunk[(*left).min(below)..]);
        // The chunk may reach over into the upper part, and the last one is shorter.
        let above = upper.len().min(CHUNK - below);
        let (chunk, rest) = upper.split_at_mut(above);
        upper = rest;
        lefts.push(&mut chunk[..left.saturating_sub(below)]);
    }
    pairs(rights, lefts).into_par_iter().for_each(|(a, b)| a.swap_with_slice(b));
    let centers =
        chunks.iter().fold([Box8::EMPTY; 2], |a, (_, b)| [a[0].union(b[0]), a[1].union(b[1])]);
    (left_count, centers)
}

/// Cuts two lists of slices, equally long in all, into pairs of equally long slices.
fn pairs<'a, T>(a: Vec<&'a mut [T]>, b: Vec<&'a mut [T]>) -> Vec<(&'a mut [T], &'a mut [T])> {
    let mut pairs = Vec::with_capacity(a.len() + b.len());
    let mut b = b.into_iter();
    let mut other: &mut [T] = &mut [];
    for mut slice in a {
        while !slice.is_empty() {
            if other.is_empty() {
                match b.next() {
                    Some(next) => other = next,
                    None => return pairs,
                }
                continue;
            }
            let n = slice.len().min(other.len());
            let (x, x_rest) = slice.split_at_mut(n);
            let (y, y_rest) = other.split_at_mut(n);
            pairs.push((x, y));
            (slice, other) = (x_rest, y_rest);
        }
    }
    pairs
}
