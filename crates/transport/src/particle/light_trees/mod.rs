//! Light paths that learn from those before them from where, whereto and how often they should go:
//! trees, and what they learned. What they are for is left to the methods.

mod emission;
mod forest;
mod importance;

pub(super) use emission::{EmissionRecord, Start, Unguided, mislead};
pub(super) use forest::{Arriving, Forest, Grove, Grower, Onward, PATHS, Receiver};
pub(super) use importance::Importance;
