//! From bounds of primitives to a wide tree: a binary tree by binned SAH ([`binary`]), for each
//! part of it the cheapest way to be a given number of children ([`forest`]), and the wide nodes
//! and leaves of the cheapest whole ([`wide`]).
//!
//! How a tree stores its nodes is its own affair: [`WideTree`] hands it all the children of a node
//! at once, and the primitives of a leaf.
//!
//! Deterministic: what happens to a range of primitives depends on that range alone, never on
//! which thread gets it.
//!
//! Memory, in bytes a primitive, for eight children: references 32, until the leaves are made;
//! the binary tree 16, until it is cut; what it is cut into up to 10, with the final tree.

mod binary;
mod binning;
mod boxes;
mod forest;
mod partition;
mod wide;

use kaustika_math::Bounds3;
use rayon::prelude::*;

use crate::pages::Array;

pub(crate) use binary::MAX_DEPTH;
pub(crate) use boxes::PrimRef;
pub(crate) use wide::{Child, WideTree};

/// Trade-offs of the builder. The default suits path tracing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildOptions {
    /// Candidate split planes an axis, 2..=32, in the binned surface area heuristic.
    pub bins: usize,
    /// Cost of testing a block of up to eight triangles, in tests of an eight-wide node; > 0.
    pub leaf_cost: f32,
}

impl Default for BuildOptions {
    fn default() -> Self {
        BuildOptions { bins: 16, leaf_cost: 1.0 }
    }
}

impl BuildOptions {
    /// With the nearest, or the default, in place of what makes no sense.
    fn in_range(&self) -> BuildOptions {
        let bins = self.bins.clamp(2, binning::MAX_BINS);
        let leaf_cost =
            if self.leaf_cost > 0.0 { self.leaf_cost } else { BuildOptions::default().leaf_cost };
        BuildOptions { bins, leaf_cost }
    }
}

/// What the surface area heuristic weighs.
#[derive(Clone, Copy, Debug)]
struct Costs {
    /// Most primitives in a leaf.
    leaf_size: usize,
    /// Of a leaf's test, in tests of a wide node.
    leaf: f32,
    /// Candidate planes an axis.
    bins: usize,
    /// Areas are measured with lengths times this, so that none overflows or vanishes.
    scale: f32,
}

impl Costs {
    /// With areas in proportion to that of `bounds`, which hold all primitives.
    fn new(leaf_size: usize, options: &BuildOptions, bounds: &Bounds3) -> Costs {
        let BuildOptions { bins, leaf_cost } = options.in_range();
        let extent = bounds.diagonal().max_component();
        let scale = if extent > 1e-36 { 1.0 / extent } else { 1.0 };
        Costs { leaf_size, leaf: leaf_cost, bins, scale }
    }
}

/// References to those of the primitives `0..count` that have bounds a tree can hold; in order.
pub(crate) fn references(
    count: usize,
    bounds: impl Fn(usize) -> Option<Bounds3> + Sync,
) -> Array<PrimRef> {
    // One that is left out is marked first, so that all can be written in place by many threads.
    let made = (0..count).into_par_iter().with_min_len(1 << 12).map(|i| {
        let made = bounds(i).and_then(|b| PrimRef::new(i as u32, &b));
        made.unwrap_or(PrimRef::NONE)
    });
    let mut refs = Array::collect(made);
    if refs.par_chunks(1 << 14).any(|c| c.iter().any(PrimRef::is_none)) {
        refs.retain(|r| !r.is_none());
    }
    refs
}
