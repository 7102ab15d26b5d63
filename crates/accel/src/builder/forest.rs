//! What each part of the binary tree costs as up to `WIDTH` children of a wide node: the dynamic
//! program of Ylitie, Karras & Laine (2017, "Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs", sec. 3).
//!
//! ```text
//! C(v, 1) = A(v) min(c_leaf,  1 + C'(v, WIDTH) / A(v))                               (1)
//! C(v, r) = min(C(v, r-1), C'(v, r))                                                 (2)
//! C'(v, r) = min over 0 < k < r of C(left, k) + C(right, r - k)                      (3)
//! ```
//!
//! with A the surface area and a leaf only where there are few enough primitives.

use super::Costs;

/// C(v, r) at place r - 1.
pub(super) type ForestCosts<const WIDTH: usize> = [f32; WIDTH];

/// How the minima were attained; and where the two sides are split in turn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut<const WIDTH: usize> {
    /// At place r - 1 the k of equation (3), or 0 for fewer roots. Place 0: whether it is a leaf.
    shares: [u8; WIDTH],
    /// Primitives in the left part of the left side and of the right side; 0 for a side that is
    /// not split.
    pub(super) left_counts: [u32; 2],
}

impl<const WIDTH: usize> Cut<WIDTH> {
    pub(super) const NONE: Self = Cut { shares: [0; WIDTH], left_counts: [0; 2] };

    pub(super) fn is_leaf(&self) -> bool {
        self.shares[0] != 0
    }

    /// How the two sides share at most `roots` >= 2 roots; `None` for a single root.
    pub(super) fn share(&self, roots: usize) -> Option<[usize; 2]> {
        (2..=roots).rev().find_map(|r| {
            let k = usize::from(self.shares[r - 1]);
            (k > 0).then(|| [k, r - k])
        })
    }
}

/// Costs of a part that is not split.
pub(super) fn leaf<const WIDTH: usize>(area: f32, costs: &Costs) -> ForestCosts<WIDTH> {
    [area * costs.leaf; WIDTH]
}

/// Costs of a part of `count` primitives that is split into these two.
pub(super) fn join<const WIDTH: usize>(
    left: &ForestCosts<WIDTH>,
    right: &ForestCosts<WIDTH>,
    area: f32,
    count: usize,
    costs: &Costs,
) -> (ForestCosts<WIDTH>, Cut<WIDTH>) {
    let mut best = [f32::INFINITY; WIDTH];
    let mut cut = Cut::NONE;
    for k in 1..WIDTH {
        for r in k + 1..=WIDTH {
            let cost = left[k - 1] + right[r - k - 1];
            let better = cost < best[r - 1];
            best[r - 1] = if better { cost } else { best[r - 1] };
            cut.shares[r - 1] = if better { k as u8 } else { cut.shares[r - 1] };
        }
    }
    let as_leaf = if count <= costs.leaf_size { area * costs.leaf } else { f32::INFINITY };
    let as_node = best[WIDTH - 1] + area;
    cut.shares[0] = u8::from(as_leaf <= as_node);
    best[0] = as_leaf.min(as_node);
    // A wide node takes all its roots; elsewhere fewer may be cheaper.
    for r in 2..WIDTH {
        if best[r - 2] <= best[r - 1] {
            best[r - 1] = best[r - 2];
            cut.shares[r - 1] = 0;
        }
    }
    (best, cut)
}
