//! A kd-tree with points in its leaves alone.
//!
//! Nodes stand in preorder and hold a plane each; where their points begin and end follows from
//! their place, for every range is halved. Leaves are as even as can be, up to sixteen points:
//! one comparison of sixteen lanes. Coordinates stand apart, leaf by leaf: 12 bytes a point, and
//! 8 for each plane, of which there are one to two for sixteen points.

use super::found::Nearest;
use super::{Item, both, part};
use kaustika_math::Vec3;
use kaustika_math::lanes::{LANES, Lanes};

/// The tree.
#[derive(Clone, Debug)]
pub struct BucketTree {
    /// Coordinates by axis; a leaf's worth of infinities follows, so that all of a leaf can be
    /// loaded at once.
    pub(super) at: [Vec<f32>; 3],
    planes: Vec<Plane>,
    count: usize,
    leaves: usize,
}

/// Between the points of two branches.
#[derive(Clone, Copy, Debug, Default)]
struct Plane {
    at: f32,
    axis: u32,
}

/// A branch: its first plane, its leaves, its points, and how far it is from the query along
/// each axis.
#[derive(Clone, Copy)]
struct Branch {
    plane: usize,
    leaves: usize,
    low: usize,
    high: usize,
    off: Vec3,
    d2: f32,
}

impl BucketTree {
    pub(super) fn new(mut items: Vec<Item>) -> (BucketTree, Vec<u32>) {
        let count = items.len();
        let leaves = count.div_ceil(LANES).next_power_of_two();
        let mut planes = vec![Plane::default(); leaves - 1];
        build(&mut items, &mut planes);
        let axis = |k: usize| {
            let coordinates = items.iter().map(|i| i.p[k]);
            coordinates.chain([f32::INFINITY; LANES]).collect()
        };
        let order = items.iter().map(|i| i.index).collect();
        (BucketTree { at: [axis(0), axis(1), axis(2)], planes, count, leaves }, order)
    }

    fn root(&self) -> Branch {
        let (leaves, high) = (self.leaves, self.count);
        Branch { plane: 0, leaves, low: 0, high, off: Vec3::ZERO, d2: 0.0 }
    }

    pub(super) fn nearest(&self, q: Vec3, found: &mut Nearest) {
        self.walk(q, self.root(), found, &Nearest::bound, &mut Nearest::offer);
    }

    pub(super) fn within(&self, q: Vec3, r2: f32, each: &mut impl FnMut(u32, f32)) {
        self.walk(q, self.root(), each, &|_| r2, &mut |each, d2, i| each(i, d2));
    }

    /// Offers `to` every point nearer than `bound`, nearer branches first.
    fn walk<T>(
        &self,
        q: Vec3,
        mut b: Branch,
        to: &mut T,
        bound: &impl Fn(&T) -> f32,
        offer: &mut impl FnMut(&mut T, f32, u32),
    ) {
        while b.leaves > 1 {
            let plane = self.planes[b.plane];
            let axis = plane.axis as usize;
            let (middle, half) = ((b.low + b.high) / 2, b.leaves / 2);
            let left = Branch { plane: b.plane + 1, leaves: half, high: middle, ..b };
            let right = Branch { plane: b.plane + half, leaves: half, low: middle, ..b };
            let delta = q[axis] - plane.at;
            let (near, mut far) = if delta < 0.0 { (left, right) } else { (right, left) };
            // The far side's distance grows along this axis alone (Arya & Mount 1993).
            far.d2 += delta * delta - b.off[axis] * b.off[axis];
            far.off[axis] = delta;
            self.walk(q, near, to, bound, offer);
            if far.d2 >= bound(to) {
                return;
            }
            b = far;
        }
        let load = |axis: usize| {
            let row: [f32; LANES] = self.at[axis][b.low..b.low + LANES].try_into().expect("padded");
            Lanes::new(row) - Lanes::splat(q[axis])
        };
        let (x, y, z) = (load(0), load(1), load(2));
        let d2 = x * x + y * y + z * z;
        let nearer = d2.simd_lt(Lanes::splat(bound(to))).to_bitmask();
        let mut nearer = nearer & ((1u32 << (b.high - b.low)) - 1);
        let d2 = d2.to_array();
        while nearer != 0 {
            let i = nearer.trailing_zeros() as usize;
            nearer &= nearer - 1;
            offer(to, d2[i], (b.low + i) as u32);
        }
    }

    pub(super) fn memory_bytes(&self) -> usize {
        12 * (self.count + LANES) + size_of::<Plane>() * self.planes.len()
    }
}

fn build(items: &mut [Item], planes: &mut [Plane]) {
    let Some((plane, below)) = planes.split_first_mut() else { return };
    let middle = items.len() / 2;
    let axis = part(items, middle);
    *plane = Plane { at: items[middle].p[axis], axis: axis as u32 };
    let len = items.len();
    let (left, right) = items.split_at_mut(middle);
    let (planes_left, planes_right) = below.split_at_mut(below.len() / 2);
    both(len, || build(left, planes_left), || build(right, planes_right));
}
