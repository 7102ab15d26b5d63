//! Metropolis sampling, and light transport by it.
//!
//! [`Chain`], [`acceptance`] and [`StepSize`] know no light: they sample any function. What carries
//! light is a state of a chain, whose f is its brightness on the film; [`seeds`] finds where chains
//! start, and how bright the picture is.

mod chain;
mod chains;
mod convergence;
mod coordinates;
mod coverage;
mod draws;
mod film;
mod groups;
pub mod paths;
pub mod primary;
pub mod seeds;
mod separate;
mod step_size;
mod tally;
mod tiles;

pub use chain::{Chain, Recording, acceptance};
pub use draws::Draws;
pub use seeds::Startup;
pub use step_size::StepSize;
pub use tally::{Count, Tally};
