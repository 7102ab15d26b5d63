//! A kd-tree in place: the node of a range is the point in its middle, and the halves beside it
//! are its children (Hooley; Pharr & Humphreys 2004, sec. 16.5). Subtrees are contiguous in memory.
//!
//! Searched depth first, the near side before the far one.

use super::found::Nearest;
use super::{Item, both, part};
use kaustika_math::Vec3;

/// The tree: 13 bytes a point.
#[derive(Clone, Debug)]
pub struct MedianTree {
    pub(super) points: Vec<Vec3>,
    /// Along which axis the point parts its range.
    axes: Vec<u8>,
}

impl MedianTree {
    pub(super) fn new(mut items: Vec<Item>) -> (MedianTree, Vec<u32>) {
        let mut axes = vec![0; items.len()];
        build(&mut items, &mut axes);
        let points = items.iter().map(|i| i.p).collect();
        (MedianTree { points, axes }, items.iter().map(|i| i.index).collect())
    }

    pub(super) fn nearest(&self, q: Vec3, found: &mut Nearest) {
        self.walk(q, (0, self.points.len()), found, &Nearest::bound, &mut Nearest::offer);
    }

    pub(super) fn within(&self, q: Vec3, r2: f32, each: &mut impl FnMut(u32, f32)) {
        self.walk(q, (0, self.points.len()), each, &|_| r2, &mut |each, d2, i| each(i, d2));
    }

    fn walk<T>(
        &self,
        q: Vec3,
        (mut low, mut high): (usize, usize),
        to: &mut T,
        bound: &impl Fn(&T) -> f32,
        offer: &mut impl FnMut(&mut T, f32, u32),
    ) {
        while low < high {
            let middle = (low + high) / 2;
            let p = self.points[middle];
            let d2 = (p - q).length_squared();
            if d2 < bound(to) {
                offer(to, d2, middle as u32);
            }
            let axis = usize::from(self.axes[middle]);
            let delta = q[axis] - p[axis];
            let (left, right) = ((low, middle), (middle + 1, high));
            let (near, far) = if delta < 0.0 { (left, right) } else { (right, left) };
            self.walk(q, near, to, bound, offer);
            if delta * delta >= bound(to) {
                return;
            }
            (low, high) = far;
        }
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.points.len() * (size_of::<Vec3>() + 1)
    }
}

fn build(items: &mut [Item], axes: &mut [u8]) {
    if items.len() < 2 {
        return;
    }
    let middle = items.len() / 2;
    axes[middle] = part(items, middle) as u8;
    let len = items.len();
    let (left, right) = items.split_at_mut(middle);
    let (axes_left, axes_right) = axes.split_at_mut(middle);
    both(len, || build(left, axes_left), || build(&mut right[1..], &mut axes_right[1..]));
}
