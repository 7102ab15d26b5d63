//! The k nearest points seen so far.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Collects the k nearest points of those it is offered.
///
/// A bounded heap would sift each point that it takes; here points are gathered in a buffer of
/// 2k and the k nearest of them selected when it is full, which costs as much once for k points.
/// A point is one number, its d² above its place: floats that are not negative are ordered as
/// their bits are. Of points at the same distance those that stand first are taken.
#[derive(Clone, Debug, Default)]
pub struct Nearest {
    k: usize,
    /// Only points nearer than this matter, d².
    bound: f32,
    found: Vec<u64>,
    /// Branches not entered yet, for those who search best first.
    pub(super) branches: BinaryHeap<Reverse<u64>>,
}

/// d² and a number, ordered by d².
#[inline]
pub(super) fn keyed(d2: f32, number: u32) -> u64 {
    u64::from(d2.to_bits()) << 32 | u64::from(number)
}

/// What [`keyed`] put together.
#[inline]
pub(super) fn unkeyed(key: u64) -> (f32, u32) {
    (f32::from_bits((key >> 32) as u32), key as u32)
}

impl Nearest {
    /// Begins again, for `k` points with d² < `limit`.
    #[inline]
    pub fn begin(&mut self, k: usize, limit: f32) {
        self.k = k;
        self.bound = if k == 0 { 0.0 } else { limit };
        self.found.clear();
        self.branches.clear();
    }

    /// d² that a point must stay below to matter.
    #[inline]
    pub(super) fn bound(&self) -> f32 {
        self.bound
    }

    /// Takes the point `index`, whose d² is below the bound.
    #[inline]
    pub(super) fn offer(&mut self, d2: f32, index: u32) {
        self.found.push(keyed(d2, index));
        if self.found.len() >= 2 * self.k {
            self.select();
        }
    }

    /// Draws the bound as near as it can be.
    pub(super) fn settle(&mut self) {
        if self.k > 0 && self.found.len() >= self.k {
            self.select();
        }
    }

    /// Leaves the k nearest.
    #[inline(never)]
    fn select(&mut self) {
        let (_, &mut last, _) = self.found.select_nth_unstable(self.k - 1);
        self.found.truncate(self.k);
        self.bound = unkeyed(last).0;
    }

    /// How many were found, at most k.
    #[inline]
    pub fn len(&self) -> usize {
        self.found.len()
    }

    /// True if none was found.
    pub fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// Places and d² of the points found, in no order.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = (u32, f32)> + '_ {
        self.found.iter().map(|&key| {
            let (d2, index) = unkeyed(key);
            (index, d2)
        })
    }

    /// d² of the farthest of them; 0 if there are none.
    pub fn farthest(&self) -> f32 {
        self.found.iter().max().map_or(0.0, |&key| unkeyed(key).0)
    }

    /// Puts them in the order of their distance.
    pub fn sort(&mut self) {
        self.found.sort_unstable();
    }
}
