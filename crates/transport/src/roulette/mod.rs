//! Russian roulette and splitting: which paths go on, in how many copies, and how their weight
//! makes up for it.
//!
//! ```text
//! E[ n L/q ] = L     for n = ⌊q + ξ⌋ copies, any q > 0                                  (1)
//! ```
//!
//! q < 1 is the probability to survive, q > 1 the mean number of copies (Kahn; Arvo & Kirk 1990).
//! [`Rule`] names how q is found. [`Survival`] rules look at a path's past after each bounce; all
//! methods know them. The others decide where a path arrives, before it is scattered, and may
//! split it: [`winners`] by what the surface is, [`window`] by the light that is still to come
//! (adjoint-driven, ADRRS), [`efficiency`] by that light's variance and cost, too (EARS). What is
//! still to come is asked of [`crate::guiding::Reflected`], which earlier passes filled.

pub mod efficiency;
mod rule;
mod rules;
#[cfg(test)]
mod tests;
pub mod window;
pub mod winners;

pub use rule::{Collision, Decision, Rule, Splitting};
pub use rules::{Roulette, Survival, WalkState, WalkStates};
