//! Choosing a split: the binned surface area heuristic (Wald 2007, "On Fast Construction of
//! SAH-based Bounding Volume Hierarchies"), with two changes.
//!
//! A side of area A and n primitives is not taken to cost A n, but
//!
//! ```text
//! A √(b ⌈n / b⌉)                                                                    (1)
//! ```
//!
//! where b primitives fit into a leaf. A n is what n primitives in one leaf cost; they will be in
//! a subtree, of which a line sees little: through n primitives of a surface a line that lies in
//! it meets about √n, others fewer. Leaves, on the other hand, cost the same full or not.
//!
//! Many primitives are also split by their size, as if that was a fourth coordinate. The few walls
//! around a room full of small things would otherwise stay among these for many levels, where
//! their boxes are as large as the room.

use rayon::prelude::*;

use super::boxes::{Box8, Extent};
use super::{Costs, PrimRef};

/// Most bins an axis.
pub(super) const MAX_BINS: usize = 32;
/// From this many primitives on, bins are filled in parallel.
const PARALLEL: usize = 1 << 16;
/// Primitives a task then.
const CHUNK: usize = 1 << 14;
/// From this many primitives on, splits by size are looked at.
const BY_SIZE: usize = 1 << 12;
/// The coordinate that stands for it.
const SIZE: usize = 3;

/// The primitives whose bin along `axis` (or by size) is below `bin` go left.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    axis: usize,
    bin: u32,
    map: BinMap,
    /// Primitives on the left side.
    pub(super) left_count: usize,
    /// What the two sides span.
    pub(super) bounds: [Box8; 2],
    areas: f32,
}

impl Split {
    #[inline(always)]
    pub(super) fn is_left(&self, r: &PrimRef) -> bool {
        let bin = match self.axis {
            SIZE => self.map.size_bin(r),
            axis => self.map.bin(r.center(axis), axis % 3),
        };
        bin < self.bin
    }

    /// The half areas of the two sides together.
    pub(super) fn areas(&self) -> f32 {
        self.areas
    }
}

/// From centres to bins. What matters is that it is the same for filling and for splitting.
#[derive(Clone, Copy, Debug)]
struct BinMap {
    origin: [f32; 4],
    scale: [f32; 4],
    last: u32,
    /// The class of the largest size that a primitive can have.
    largest: u32,
}

impl BinMap {
    fn new(extent: &Extent, bins: usize) -> BinMap {
        let centers = &extent.centers;
        let scale = std::array::from_fn(|i| {
            let extent = centers.extent(i);
            // A little less, so that the last centre does not come to lie behind the last bin.
            let scale = bins as f32 * (1.0 - 1.0 / (1 << 20) as f32) / extent;
            if i < 3 && extent > 0.0 && scale.is_finite() { scale } else { 0.0 }
        });
        let (origin, last) = (centers.lower(), bins as u32 - 1);
        BinMap { origin, scale, last, largest: size_class(&extent.bounds) }
    }

    /// The bin along `axis` of a primitive whose doubled centre is at `c` there.
    #[inline(always)]
    fn bin(&self, c: f32, axis: usize) -> u32 {
        // Adding 1.5·2²³ rounds to a whole number and leaves it in the low bits: cheaper than a
        // conversion, which has to saturate.
        const ROUND: f32 = 12_582_912.0;
        let x = (c - self.origin[axis]) * self.scale[axis] - 0.5;
        (x + ROUND).to_bits() & (MAX_BINS as u32 - 1)
    }

    /// The bin by size: the last is for the largest class, the first for all from some size down.
    #[inline(always)]
    fn size_bin(&self, r: &PrimRef) -> u32 {
        let smaller = self.largest.saturating_sub(size_class(r.box8()));
        self.last.saturating_sub(smaller)
    }

    /// The bins along three axes, and for `AXES` = 4 that by size.
    #[inline(always)]
    fn bins<const AXES: usize>(&self, r: &PrimRef) -> [u32; AXES] {
        let c = r.centers();
        let along: [u32; 4] = std::array::from_fn(|i| self.bin(c[i], i));
        std::array::from_fn(|i| if i == SIZE { self.size_bin(r) } else { along[i] })
    }
}

/// Two classes for each doubling of the longest edge: the exponent and a bit of the fraction.
#[inline(always)]
fn size_class(b: &Box8) -> u32 {
    let longest = (0..3).map(|axis| b.extent(axis)).fold(0.0, |a, b| if b > a { b } else { a });
    longest.to_bits() >> 22
}

/// Up to `N` bins along each of `AXES` coordinates: three axes and perhaps the size.
struct Bins<const N: usize, const AXES: usize> {
    boxes: [[Box8; AXES]; N],
    /// Always four, for the vector unit.
    counts: [[u32; 4]; N],
}

/// What lies on one side of a plane, for each coordinate.
type Side<const AXES: usize> = ([Box8; AXES], [u32; 4]);

impl<const N: usize, const AXES: usize> Bins<N, AXES> {
    const EMPTY: Self = Bins { boxes: [[Box8::EMPTY; AXES]; N], counts: [[0; 4]; N] };

    #[inline(always)]
    fn fill(&mut self, refs: &[PrimRef], map: &BinMap) {
        for r in refs {
            let bins = map.bins::<AXES>(r);
            for axis in 0..AXES {
                let k = bins[axis] as usize % N;
                self.boxes[k][axis].grow(r.box8());
                self.counts[k][axis] += 1;
            }
        }
    }

    fn merge(mut self, o: Self) -> Self {
        for k in 0..N {
            for axis in 0..AXES {
                self.boxes[k][axis].grow(&o.boxes[k][axis]);
                self.counts[k][axis] += o.counts[k][axis];
            }
        }
        self
    }

    /// The cheapest of the planes between the first `count` bins of each coordinate.
    #[inline(always)]
    fn best_split(&self, count: usize, map: BinMap, costs: &Costs) -> Option<Split> {
        // Adds one bin of each coordinate to what is on one side of a plane, and says what that
        // costs: (1). Nothing on one side costs ∞·0, which is NaN and not less than anything.
        let block = costs.leaf_size.next_power_of_two() as u32;
        let add = |side: &mut Side<AXES>, k: usize| -> [f32; 4] {
            let mut areas = [f32::NAN; 4];
            for axis in 0..AXES {
                side.0[axis].grow(&self.boxes[k][axis]);
                areas[axis] = side.0[axis].half_area(costs.scale);
            }
            side.1 = std::array::from_fn(|axis| side.1[axis] + self.counts[k][axis]);
            let whole = side.1.map(|n| (n + (block - 1)) & !(block - 1));
            std::array::from_fn(|axis| areas[axis] * (whole[axis] as f32).sqrt())
        };
        let nothing: Side<AXES> = ([Box8::EMPTY; AXES], [0; 4]);
        let mut right_costs = [[0.0; 4]; N];
        let mut right = nothing;
        for k in (1..count).rev() {
            right_costs[k % N] = add(&mut right, k % N);
        }
        let mut left = nothing;
        let (mut best, mut best_bin) = ([f32::INFINITY; 4], [0; 4]);
        for k in 1..count {
            let left_costs = add(&mut left, (k - 1) % N);
            for axis in 0..4 {
                let cost = left_costs[axis] + right_costs[k % N][axis];
                let better = cost < best[axis];
                best[axis] = if better { cost } else { best[axis] };
                best_bin[axis] = if better { k as u32 } else { best_bin[axis] };
            }
        }
        let axis = (1..AXES).fold(0, |a, b| if best[b] < best[a] { b } else { a });
        if best[axis] == f32::INFINITY {
            return None;
        }
        let bin = best_bin[axis];
        let (left, right) = self.boxes[..count].split_at(bin as usize);
        let bounds = [left, right].map(|s| s.iter().fold(Box8::EMPTY, |a, b| a.union(b[axis])));
        let left_count = self.counts[..bin as usize].iter().map(|c| c[axis]).sum::<u32>() as usize;
        let areas = bounds[0].half_area(costs.scale) + bounds[1].half_area(costs.scale);
        Some(Split { axis, bin, map, left_count, bounds, areas })
    }
}

/// The cheapest split; `None` if all centres fall into one bin.
pub(super) fn find_split(refs: &[PrimRef], extent: &Extent, costs: &Costs) -> Option<Split> {
    // Few primitives need few bins.
    let count = costs.bins.min(4 + refs.len() / 8);
    match count {
        _ if refs.len() >= BY_SIZE => find_split_in::<MAX_BINS, 4>(refs, extent, costs, count),
        ..=8 => find_split_in::<8, 3>(refs, extent, costs, count),
        9..=16 => find_split_in::<16, 3>(refs, extent, costs, count),
        _ => find_split_in::<MAX_BINS, 3>(refs, extent, costs, count),
    }
}

fn find_split_in<const N: usize, const AXES: usize>(
    refs: &[PrimRef],
    extent: &Extent,
    costs: &Costs,
    count: usize,
) -> Option<Split> {
    let map = BinMap::new(extent, count);
    if refs.len() >= PARALLEL {
        let bins = refs
            .par_chunks(CHUNK)
            .map(|chunk| {
                let mut bins = Bins::<N, AXES>::EMPTY;
                bins.fill(chunk, &map);
                bins
            })
            .reduce_with(Bins::merge)?;
        bins.best_split(count, map, costs)
    } else {
        let mut bins = Bins::<N, AXES>::EMPTY;
        bins.fill(refs, &map);
        bins.best_split(count, map, costs)
    }
}
