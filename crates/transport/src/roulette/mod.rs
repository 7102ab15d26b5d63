//! Russian roulette: which paths go on, and how their weight makes up for those that do not.
//!
//! ```text
//! E[ L / q if ξ < q, else 0 ] = L     for any q in (0, 1]                       (1)
//! ```

mod rules;

pub use rules::{Roulette, Survival, WalkState, WalkStates};
