//! Choosing a split: the binned surface area heuristic (Wald 2007, "On Fast Construction of
//! SAH-based Bounding Volume Hierarchies").

use rayon::prelude::*;

use super::boxes::{Box8, Extent};
use super::{Costs, PrimRef};

/// Most bins an axis.
pub(super) const MAX_BINS: usize = 32;
/// From this many primitives on, bins are filled in parallel.
const PARALLEL: usize = 1 << 16;
/// Primitives a task then.
const CHUNK: usize = 1 << 14;

/// The primitives whose bin along `axis` is below `bin` go left.
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
        let axis = self.axis % 3;
        self.map.bin(r.center(axis), axis) < self.bin
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
    last: i32,
}

impl BinMap {
    fn new(centers: &Box8, bins: usize) -> BinMap {
        let scale = std::array::from_fn(|i| {
            let extent = centers.extent(i);
            let scale = bins as f32 / extent;
            if i < 3 && extent > 0.0 && scale.is_finite() { scale } else { 0.0 }
        });
        BinMap { origin: centers.lower(), scale, last: bins as i32 - 1 }
    }

    /// The bin along `axis` of a primitive whose doubled centre is at `c` there.
    #[inline(always)]
    fn bin(&self, c: f32, axis: usize) -> u32 {
        // Adding 1.5·2²³ rounds to a whole number and leaves it in the low bits: cheaper than a
        // conversion, which has to saturate. Nonsense cannot occur, and would be clamped.
        const ROUND: f32 = 12_582_912.0;
        let x = (c - self.origin[axis]) * self.scale[axis] - 0.5;
        let whole = (x + ROUND).to_bits().wrapping_sub(ROUND.to_bits()) as i32;
        whole.clamp(0, self.last) as u32
    }

    #[inline(always)]
    fn bins(&self, r: &PrimRef) -> [u32; 4] {
        let c = r.centers();
        std::array::from_fn(|i| self.bin(c[i], i))
    }
}

/// Up to `N` bins along each axis.
struct Bins<const N: usize> {
    boxes: [[Box8; N]; 3],
    counts: [[u32; N]; 3],
}

impl<const N: usize> Bins<N> {
    const EMPTY: Self = Bins { boxes: [[Box8::EMPTY; N]; 3], counts: [[0; N]; 3] };

    #[inline(always)]
    fn fill(&mut self, refs: &[PrimRef], map: &BinMap) {
        for r in refs {
            let [x, y, z, _] = map.bins(r);
            for (axis, bin) in [x, y, z].into_iter().enumerate() {
                let k = bin as usize % N;
                self.boxes[axis][k].grow(r.box8());
                self.counts[axis][k] += 1;
            }
        }
    }

    fn merge(mut self, o: Self) -> Self {
        for axis in 0..3 {
            for k in 0..N {
                self.boxes[axis][k].grow(&o.boxes[axis][k]);
                self.counts[axis][k] += o.counts[axis][k];
            }
        }
        self
    }

    /// The cheapest of the planes between the first `count` bins of each axis.
    #[inline(always)]
    fn best_split(&self, count: usize, map: BinMap, costs: &Costs) -> Option<Split> {
        let mut best = (f32::INFINITY, 0, 0);
        for axis in 0..3 {
            if map.scale[axis] == 0.0 {
                continue;
            }
            let (boxes, counts) = (&self.boxes[axis][..count], &self.counts[axis][..count]);
            // Cost of the primitives right of each plane, then add what lies left of it.
            let mut right_costs = [f32::INFINITY; N];
            let (mut right, mut n) = (Box8::EMPTY, 0);
            for k in (1..count).rev() {
                right.grow(&boxes[k]);
                n += counts[k];
                if n > 0 {
                    right_costs[k] = right.half_area(costs.scale) * n as f32;
                }
            }
            let (mut left, mut n) = (Box8::EMPTY, 0);
            for (k, right_cost) in right_costs[..count].iter().enumerate().skip(1) {
                left.grow(&boxes[k - 1]);
                n += counts[k - 1];
                if n > 0 {
                    let cost = left.half_area(costs.scale) * n as f32 + right_cost;
                    if cost < best.0 {
                        best = (cost, axis, k);
                    }
                }
            }
        }
        let (cost, axis, bin) = best;
        if cost == f32::INFINITY {
            return None;
        }
        let (left, right) = self.boxes[axis][..count].split_at(bin);
        let bounds = [left, right].map(|b| b.iter().fold(Box8::EMPTY, |a, &b| a.union(b)));
        let left_count = self.counts[axis][..bin].iter().sum::<u32>() as usize;
        let areas = bounds[0].half_area(costs.scale) + bounds[1].half_area(costs.scale);
        Some(Split { axis, bin: bin as u32, map, left_count, bounds, areas })
    }
}

/// The cheapest split; `None` if all centres fall into one bin.
pub(super) fn find_split(refs: &[PrimRef], extent: &Extent, costs: &Costs) -> Option<Split> {
    // Few primitives need few bins.
    let count = costs.bins.min(4 + refs.len() / 8);
    match count {
        ..=8 => find_split_in::<8>(refs, extent, costs, count),
        9..=16 => find_split_in::<16>(refs, extent, costs, count),
        _ => find_split_in::<MAX_BINS>(refs, extent, costs, count),
    }
}

fn find_split_in<const N: usize>(
    refs: &[PrimRef],
    extent: &Extent,
    costs: &Costs,
    count: usize,
) -> Option<Split> {
    let map = BinMap::new(&extent.centers, count);
    if refs.len() >= PARALLEL {
        let bins = refs
            .par_chunks(CHUNK)
            .map(|chunk| {
                let mut bins = Bins::<N>::EMPTY;
                bins.fill(chunk, &map);
                bins
            })
            .reduce_with(Bins::merge)?;
        bins.best_split(count, map, costs)
    } else {
        let mut bins = Bins::<N>::EMPTY;
        bins.fill(refs, &map);
        bins.best_split(count, map, costs)
    }
}
