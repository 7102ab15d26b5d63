//! Points and the ways to find those near a place: the k nearest, or all within a radius.
//!
//! Four structures answer alike; which is the fastest is measured (docs/photonmap.md):
//!
//! * [`HeapTree`]: a kd-tree with a point in every node, left-balanced and laid out as a heap
//!   (Jensen 2001, sec. 6.2); searched best first, by a heap of branches not entered yet.
//! * [`MedianTree`]: the same tree, its medians left in place (Hooley, pbrt's photon map).
//! * [`BucketTree`]: points only in leaves of up to sixteen, which one instruction compares;
//!   the default.
//! * [`CellGrid`]: a hash of cubic cells, searched shell by shell.
//!
//! Each is built from points and leaves them in an order of its own, which it tells, so that
//! what belongs to the points can follow. Distances are compared as d² < r², in single precision.

mod bucket_tree;
mod cell_grid;
mod found;
mod heap_tree;
mod median_tree;
#[cfg(test)]
mod tests;

pub use bucket_tree::BucketTree;
pub use cell_grid::CellGrid;
pub use found::Nearest;
pub use heap_tree::HeapTree;
pub use median_tree::MedianTree;

use kaustika_math::Vec3;
use serde::Deserialize;

/// Which structure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Layout {
    /// [`HeapTree`].
    Heap,
    /// [`MedianTree`].
    Median,
    /// [`BucketTree`].
    #[default]
    Buckets,
    /// [`CellGrid`].
    Grid,
}

impl Layout {
    /// All of them.
    pub const ALL: [Layout; 4] = [Layout::Heap, Layout::Median, Layout::Buckets, Layout::Grid];
}

/// Points that can be searched.
#[derive(Clone, Debug)]
pub enum Points {
    /// As a left-balanced heap.
    Heap(HeapTree),
    /// With medians in place.
    Median(MedianTree),
    /// In the leaves of a tree.
    Buckets(BucketTree),
    /// In cells.
    Grid(CellGrid),
}

/// A point on its way into a structure.
#[derive(Clone, Copy, Debug)]
struct Item {
    p: Vec3,
    /// Its number before.
    index: u32,
}

/// Below this many points a range is not worth another thread.
const PARALLEL: usize = 1 << 14;

/// Runs both, on two threads if they are worth it.
fn both(len: usize, a: impl FnOnce() + Send, b: impl FnOnce() + Send) {
    if len < PARALLEL {
        a();
        b();
    } else {
        rayon::join(a, b);
    }
}

/// Puts the median of `items`, at `at`, in its place along their widest axis, which is returned.
fn part(items: &mut [Item], at: usize) -> usize {
    let (mut low, mut high) = (items[0].p, items[0].p);
    for item in items.iter() {
        (low, high) = (low.min(item.p), high.max(item.p));
    }
    let axis = (high - low).max_axis();
    items.select_nth_unstable_by(at, |a, b| a.p[axis].total_cmp(&b.p[axis]));
    axis
}

impl Points {
    /// Builds it; also returns which of `points` stands at each place of the new order.
    ///
    /// The points must be finite. The same points give the same order on any number of threads.
    pub fn new(layout: Layout, points: &[Vec3]) -> (Points, Vec<u32>) {
        debug_assert!(points.iter().all(|p| p.is_finite()));
        let items = points.iter().enumerate().map(|(i, &p)| Item { p, index: i as u32 }).collect();
        match layout {
            Layout::Heap => {
                let (tree, order) = HeapTree::new(items);
                (Points::Heap(tree), order)
            }
            Layout::Median => {
                let (tree, order) = MedianTree::new(items);
                (Points::Median(tree), order)
            }
            Layout::Buckets => {
                let (tree, order) = BucketTree::new(items);
                (Points::Buckets(tree), order)
            }
            Layout::Grid => {
                let (grid, order) = CellGrid::new(items);
                (Points::Grid(grid), order)
            }
        }
    }

    /// Finds the points nearest to `q`, as many as `found` asks for and not beyond its limit.
    #[inline]
    pub fn nearest(&self, q: Vec3, found: &mut Nearest) {
        match self {
            Points::Heap(t) => t.nearest(q, found),
            Points::Median(t) => t.nearest(q, found),
            Points::Buckets(t) => t.nearest(q, found),
            Points::Grid(g) => g.nearest(q, found),
        }
        found.settle();
    }

    /// Calls `each` with the place and d² of every point with d² < `r2` from `q`, in no order.
    #[inline]
    pub fn within(&self, q: Vec3, r2: f32, mut each: impl FnMut(u32, f32)) {
        match self {
            Points::Heap(t) => t.within(q, r2, &mut each),
            Points::Median(t) => t.within(q, r2, &mut each),
            Points::Buckets(t) => t.within(q, r2, &mut each),
            Points::Grid(g) => g.within(q, r2, &mut each),
        }
    }

    /// The point at a place of the new order.
    #[inline]
    pub fn at(&self, i: u32) -> Vec3 {
        let i = i as usize;
        match self {
            Points::Heap(t) => t.points[i],
            Points::Median(t) => t.points[i],
            Points::Buckets(t) => Vec3::new(t.at[0][i], t.at[1][i], t.at[2][i]),
            Points::Grid(g) => g.points[i],
        }
    }

    /// Bytes that the points and the structure take.
    pub fn memory_bytes(&self) -> usize {
        match self {
            Points::Heap(t) => t.memory_bytes(),
            Points::Median(t) => t.memory_bytes(),
            Points::Buckets(t) => t.memory_bytes(),
            Points::Grid(g) => g.memory_bytes(),
        }
    }
}
