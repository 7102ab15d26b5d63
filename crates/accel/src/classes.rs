//! Rays sorted by how they lie: the axis along which a direction is longest, and its signs.
//!
//! Rays of one class meet the planes of boxes in one order and see triangles along one axis, so
//! that lanes of a vector can be rays wherever they start and however far they part. In each class
//! they are sorted by where they start, so that neighbours want more of the same boxes.

use kaustika_math::Bounds3;

use crate::ray::{AXES, PlainRays};
use crate::simd::{F32x8, LANES, Lanes};
use crate::stream::Segment;

/// Rays that are sorted at a time.
pub(crate) const MAX_RAYS: usize = 4096;

/// Three axes times eight octants of directions.
const PLAIN: usize = 24;
/// Those that need special care follow.
const CLASSES: usize = PLAIN + 8;
/// Where rays start: octants about the middle of the tree.
const CELLS: usize = 8;
const BINS: usize = CLASSES * CELLS;

/// The axes and signs that the rays of a class share.
#[derive(Clone, Copy)]
pub(crate) struct Class {
    pub(crate) axes: [u8; 3],
    pub(crate) negative: [u8; 3],
}

/// Up to [`MAX_RAYS`] rays by their classes.
pub(crate) struct Classes {
    /// Places of the rays among all segments, bin by bin.
    order: [u32; MAX_RAYS],
    /// Where in `order` each bin ends. A class has `CELLS` bins, one after the other.
    ends: [usize; BINS],
}

impl Classes {
    /// The segments from `first` on. `bounds` are those of a tree that
    /// [is moderate](crate::ray::is_moderate).
    pub(crate) fn new(segments: &[Segment], first: usize, bounds: &Bounds3) -> Classes {
        let count = (segments.len() - first).min(MAX_RAYS);
        let segments = &segments[first..first + count];
        let middle = (bounds.min + bounds.max) * 0.5;
        let middle = [middle.x, middle.y, middle.z].map(F32x8::splat);
        let mut bins = [[0; LANES]; MAX_RAYS / LANES];
        for (bins, start) in bins.iter_mut().zip((0..count).step_by(LANES)) {
            *bins = bins_of(|lane| segments[(start + lane).min(count - 1)], middle);
        }
        let bins = &bins.as_flattened()[..count];

        let mut counts = [0; BINS];
        for bin in bins {
            counts[usize::from(*bin)] += 1;
        }
        // At first where each bin starts.
        let mut ends = [0; BINS];
        for bin in 1..BINS {
            ends[bin] = ends[bin - 1] + counts[bin - 1];
        }
        let mut order = [0; MAX_RAYS];
        for (i, bin) in (first as u32..).zip(bins) {
            let end = &mut ends[usize::from(*bin)];
            order[*end % MAX_RAYS] = i;
            *end += 1;
        }
        Classes { order, ends }
    }

    /// The rays that need no special care.
    pub(crate) fn plain(&self) -> impl Iterator<Item = (Class, &[u32])> {
        (0..PLAIN).map(|class| {
            let negative = [0, 1, 2].map(|axis| (class >> axis & 1) as u8);
            let rays = &self.order[self.start(class)..self.start(class + 1)];
            (Class { axes: AXES[class / 8], negative }, rays)
        })
    }

    /// All others.
    pub(crate) fn special(&self) -> &[u32] {
        &self.order[self.start(PLAIN)..self.start(CLASSES)]
    }

    fn start(&self, class: usize) -> usize {
        if class == 0 { 0 } else { self.ends[class * CELLS - 1] }
    }
}

/// The numbers of eight rays: origins, directions, and where they end.
#[inline(always)]
pub(crate) fn columns(segment: impl Fn(usize) -> Segment) -> ([F32x8; 3], [F32x8; 3], F32x8) {
    let rows = std::array::from_fn(|lane| {
        let Segment { ray, t_max } = segment(lane);
        let (o, d) = (ray.o, ray.d);
        // In the order they have in memory, so that this is one load.
        F32x8::load(&[o.x, o.y, o.z, d.x, d.y, d.z, ray.time, t_max])
    });
    let [ox, oy, oz, dx, dy, dz, _, t_max] = F32x8::transpose(rows);
    ([ox, oy, oz], [dx, dy, dz], t_max)
}

/// Bins of eight rays: three bits for the cell, three of signs, two for the axis, which are both
/// set for special rays.
#[inline(always)]
fn bins_of(segment: impl Fn(usize) -> Segment, middle: [F32x8; 3]) -> [u8; LANES] {
    let (o, d, _) = columns(segment);
    let PlainRays { longest: [x, y, z], negative: [nx, ny, nz] } = PlainRays::new(o, d);
    let special = !(x | y | z);
    let [cx, cy, cz] = [0, 1, 2].map(|axis| middle[axis].lt(o[axis]));
    let bits = [cx, cy, cz, nx, ny, nz, y | special, z | special];
    let bins = bits.iter().enumerate().fold(0, |bins, (i, mask)| bins | bytes(*mask) << i);
    bins.to_le_bytes()
}

/// The low eight bits, each as a byte of 0 or 1.
fn bytes(mask: u32) -> u64 {
    const EACH: u64 = 0x0101_0101_0101_0101;
    let bits = (u64::from(mask & 0xff) * EACH) & 0x8040_2010_0804_0201;
    // The top bit of a byte is set where there was one; none carries into the next.
    (bits + 0x7f * EACH) >> 7 & EACH
}
