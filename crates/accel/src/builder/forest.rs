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

use bytemuck::{Pod, Zeroable};

use super::Costs;

/// C(v, r) at place r - 1.
pub(super) type ForestCosts<const WIDTH: usize> = [f32; WIDTH];

/// How the minima were attained; and where the two sides are split in turn. All zeros where nothing
/// was.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Cut {
    /// Four bits each: at place r - 1 the k of equation (3), or 0 for fewer roots. Place 0: whether
    /// it is a leaf.
    shares: u64,
    /// Primitives in the left part of the left side and of the right side; 0 for a side that is
    /// not split.
    pub(super) left_counts: [u32; 2],
}

impl Cut {
    /// Most roots.
    pub(super) const MAX_WIDTH: usize = 16;

    pub(super) fn is_leaf(&self) -> bool {
        self.place(0) != 0
    }

    fn place(&self, i: usize) -> usize {
        (self.shares >> (4 * i)) as usize & 15
    }

    /// How the two sides share at most `roots` >= 2 roots; `None` for a single root.
    pub(super) fn share(&self, roots: usize) -> Option<[usize; 2]> {
        (2..=roots).rev().find_map(|r| {
            let k = self.place(r - 1);
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
) -> (ForestCosts<WIDTH>, Cut) {
    let mut best = [f32::INFINITY; WIDTH];
    let mut shares = [0u8; WIDTH];
    for k in 1..WIDTH {
        for r in k + 1..=WIDTH {
            let cost = left[k - 1] + right[r - k - 1];
            let better = cost < best[r - 1];
            best[r - 1] = if better { cost } else { best[r - 1] };
            shares[r - 1] = if better { k as u8 } else { shares[r - 1] };
        }
    }
    let as_leaf = if count <= costs.leaf_size { area * costs.leaf } else { f32::INFINITY };
    let as_node = best[WIDTH - 1] + area;
    shares[0] = u8::from(as_leaf <= as_node);
    best[0] = as_leaf.min(as_node);
    // A wide node takes all its roots; elsewhere fewer may be cheaper.
    for r in 2..WIDTH {
        if best[r - 2] <= best[r - 1] {
            best[r - 1] = best[r - 2];
            shares[r - 1] = 0;
        }
    }
    let places = shares.iter().enumerate();
    let shares = places.fold(0, |all, (i, share)| all | u64::from(*share) << (4 * i));
    (best, Cut { shares, left_counts: [0; 2] })
}
