//! The binary tree, and how it is best cut.

use rayon::prelude::*;

use super::binning::find_split;
use super::boxes::Extent;
use super::forest::{self, Cut, ForestCosts};
use super::partition::partition;
use super::{BuildOptions, Costs, PrimRef};
use crate::pages::Array;

/// Below this depth splits halve the number of primitives, so that no tree is too deep.
const MAX_SAH_DEPTH: usize = 48;
/// No tree is deeper: 31 halvings leave one of 2³¹ primitives.
pub(crate) const MAX_DEPTH: usize = MAX_SAH_DEPTH + 32;
/// From this many primitives on, the two sides are built in parallel.
const PARALLEL: usize = 1 << 12;

/// Half the surface area of a box, in squares of the longest edge of the box of all.
const RARELY_MET: f32 = 1e-3;

/// A binary tree over primitives `0..n`, of which each part is a range.
///
/// A split lies between two neighbours, no two splits at the same place, so what is known of a
/// part is kept under the place of its split. Places are thus known before anything is built, and
/// the two sides of a part write to slices of their own.
pub(super) struct BinaryTree<const WIDTH: usize> {
    /// That of the split before primitive `i` at place `i - 1`.
    cuts: Array<Cut>,
    /// Primitives left of the first split; 0 if there is none.
    left_count: u32,
}

/// A part of the binary tree: primitives `first .. first + count`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) first: usize,
    pub(super) count: usize,
    /// Primitives in its left side; 0 if it is not split.
    left_count: usize,
}

struct Built<const WIDTH: usize> {
    costs: ForestCosts<WIDTH>,
    left_count: u32,
}

impl<const WIDTH: usize> BinaryTree<WIDTH> {
    /// Builds over at least one primitive, and brings the primitives into the order of the leaves.
    pub(super) fn build(
        refs: &mut [PrimRef],
        leaf_size: usize,
        options: &BuildOptions,
    ) -> BinaryTree<WIDTH> {
        const { assert!(WIDTH <= Cut::MAX_WIDTH) };
        let mut cuts = Array::zeros(refs.len() - 1);
        let extent =
            refs.par_chunks(1 << 14).map(Extent::of).reduce(|| Extent::EMPTY, Extent::union);
        let costs = Costs::new(leaf_size, options, &extent.bounds.bounds());
        let root = build_part::<WIDTH>(refs, &mut cuts, &extent, 0, &costs);
        BinaryTree { cuts, left_count: root.left_count }
    }

    pub(super) fn root(&self) -> Part {
        Part { first: 0, count: self.cuts.len() + 1, left_count: self.left_count as usize }
    }

    pub(super) fn is_leaf(&self, part: Part) -> bool {
        part.left_count == 0 || self.cut(part).is_leaf()
    }

    /// Calls `child` with the children of `part` as a wide node, from first to last.
    pub(super) fn children(&self, part: Part, child: &mut impl FnMut(Part)) {
        self.divide(part, WIDTH, child);
    }

    /// `part` as at most `roots` children, of the least cost.
    fn divide(&self, part: Part, roots: usize, child: &mut impl FnMut(Part)) {
        let share = if part.left_count == 0 { None } else { self.cut(part).share(roots) };
        match share {
            None => child(part),
            Some(roots) => {
                let sides = self.sides(part);
                for (side, roots) in sides.into_iter().zip(roots) {
                    self.divide(side, roots, child);
                }
            }
        }
    }

    fn cut(&self, part: Part) -> &Cut {
        &self.cuts[part.first + part.left_count - 1]
    }

    fn sides(&self, part: Part) -> [Part; 2] {
        let [l, r] = self.cut(part).left_counts.map(|n| n as usize);
        let (first, count) = (part.first + part.left_count, part.count - part.left_count);
        [
            Part { first: part.first, count: part.left_count, left_count: l },
            Part { first, count, left_count: r },
        ]
    }
}

fn build_part<const WIDTH: usize>(
    refs: &mut [PrimRef],
    cuts: &mut [Cut],
    extent: &Extent,
    depth: usize,
    costs: &Costs,
) -> Built<WIDTH> {
    let area = extent.bounds.half_area(costs.scale);
    let count = refs.len();
    let unsplit = || Built { costs: forest::leaf(area, costs), left_count: 0 };
    // What one leaf can hold is worth a split only if two boxes are much smaller than one, which
    // is rare; to look for it pays where many rays come by.
    let fits = count <= costs.leaf_size;
    if count == 1 || fits && area < RARELY_MET {
        return unsplit();
    }
    let split = if depth < MAX_SAH_DEPTH { find_split(refs, extent, costs) } else { None };
    let (left_count, [left, right]) = match split {
        Some(split) if fits && split.areas() >= area => return unsplit(),
        Some(split) => (split.left_count, partition(refs, &split)),
        None if fits => return unsplit(),
        None => halve(refs, extent),
    };

    let (l_refs, r_refs) = refs.split_at_mut(left_count);
    let (l_cuts, rest) = cuts.split_at_mut(left_count - 1);
    let (own, r_cuts) = rest.split_at_mut(1);
    let mut build_left = || build_part(l_refs, l_cuts, &left, depth + 1, costs);
    let mut build_right = || build_part(r_refs, r_cuts, &right, depth + 1, costs);
    let (left, right) = if count >= PARALLEL {
        rayon::join(build_left, build_right)
    } else {
        (build_left(), build_right())
    };
    let (joined, cut) = forest::join(&left.costs, &right.costs, area, count, costs);
    own[0] = cut;
    own[0].left_counts = [left.left_count, right.left_count];
    Built { costs: joined, left_count: left_count as u32 }
}

/// Two halves along the axis on which the centres spread most: for centres that all coincide, and
/// for parts of the tree that are too deep.
fn halve(refs: &mut [PrimRef], extent: &Extent) -> (usize, [Extent; 2]) {
    let middle = refs.len() / 2;
    let spread = [0, 1, 2].map(|axis| extent.centers.extent(axis));
    let axis = (0..3).fold(0, |a, b| if spread[b] > spread[a] { b } else { a });
    if spread[axis] > 0.0 {
        refs.select_nth_unstable_by(middle, |a, b| {
            let key = |r: &PrimRef| r.center(axis);
            key(a).total_cmp(&key(b)).then(a.prim().cmp(&b.prim()))
        });
    }
    (middle, [Extent::of(&refs[..middle]), Extent::of(&refs[middle..])])
}
