//! Choosing a split: the binned surface area heuristic (Wald 2007, "On Fast Construction of
//! SAH-based Bounding Volume Hierarchies").

use rayon::prelude::*;

use super::{Box4, Costs, Extent, PrimRef};

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
}

impl Split {
    #[inline(always)]
    pub(super) fn is_left(&self, r: &PrimRef) -> bool {
        self.map.bins(r)[self.axis] < self.bin
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
    fn new(centroids: &Box4, bins: usize) -> BinMap {
        let scale = std::array::from_fn(|i| {
            let extent = centroids.hi[i] - centroids.lo[i];
            let scale = bins as f32 / extent;
            if i < 3 && extent > 0.0 && scale.is_finite() { scale } else { 0.0 }
        });
        BinMap { origin: centroids.lo, scale, last: bins as i32 - 1 }
    }

    #[inline(always)]
    fn bins(&self, r: &PrimRef) -> [u32; 4] {
        let c = r.centroid();
        std::array::from_fn(|i| {
            (((c[i] - self.origin[i]) * self.scale[i]) as i32).clamp(0, self.last) as u32
        })
    }
}

struct Bins {
    boxes: [[Box4; MAX_BINS]; 3],
    counts: [[u32; MAX_BINS]; 3],
}

impl Bins {
    fn fill(refs: &[PrimRef], map: &BinMap) -> Bins {
        let mut bins = Bins { boxes: [[Box4::EMPTY; MAX_BINS]; 3], counts: [[0; MAX_BINS]; 3] };
        for r in refs {
            let b = map.bins(r);
            for axis in 0..3 {
                let k = b[axis] as usize % MAX_BINS;
                bins.boxes[axis][k].grow(&r.lo, &r.hi);
                bins.counts[axis][k] += 1;
            }
        }
        bins
    }

    fn merge(mut self, o: Bins) -> Bins {
        for axis in 0..3 {
            for k in 0..MAX_BINS {
                self.boxes[axis][k].merge(&o.boxes[axis][k]);
                self.counts[axis][k] += o.counts[axis][k];
            }
        }
        self
    }
}

/// The cheapest split; `None` if all centres fall into one bin.
pub(super) fn find_split(refs: &[PrimRef], extent: &Extent, costs: &Costs) -> Option<Split> {
    // Few primitives need few bins.
    let count = costs.bins.min(4 + refs.len() / 8);
    let map = BinMap::new(&extent.centroids, count);
    let bins = if refs.len() >= PARALLEL {
        refs.par_chunks(CHUNK).map(|c| Bins::fill(c, &map)).reduce_with(Bins::merge)?
    } else {
        Bins::fill(refs, &map)
    };
    let mut best = (f32::INFINITY, 0, 0);
    for axis in 0..3 {
        if map.scale[axis] == 0.0 {
            continue;
        }
        // Cost of the primitives right of each plane, then add what lies left of it.
        let mut right_costs = [0f32; MAX_BINS];
        let (mut right, mut n) = (Box4::EMPTY, 0);
        for k in (1..count).rev() {
            right.merge(&bins.boxes[axis][k]);
            n += bins.counts[axis][k];
            right_costs[k] =
                if n > 0 { right.half_area(costs.scale) * n as f32 } else { f32::INFINITY };
        }
        let (mut left, mut n) = (Box4::EMPTY, 0);
        for k in 1..count {
            left.merge(&bins.boxes[axis][k - 1]);
            n += bins.counts[axis][k - 1];
            if n > 0 {
                let cost = left.half_area(costs.scale) * n as f32 + right_costs[k];
                if cost < best.0 {
                    best = (cost, axis, k);
                }
            }
        }
    }
    (best.0 < f32::INFINITY).then_some(Split { axis: best.1, bin: best.2 as u32, map })
}
