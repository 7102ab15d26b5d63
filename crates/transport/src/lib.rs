//! The light transport methods, one family a folder, behind one interface.
//!
//! [`method`] says what a method is; [`session`] runs passes of any method until a budget is
//! met. A method knows the scene, the sampler, the film and the shared floors (`path_space`, `strategies`, `extinction`, `roulette`), and
//! no other method's insides; only `hybrid` puts methods together.

pub mod bidirectional;
pub mod extinction;
pub mod features;
pub mod frame;
pub mod guiding;
pub mod hybrid;
pub mod lights;
pub mod method;
pub mod metropolis;
pub mod nearest;
pub mod particle;
pub mod path;
pub mod path_space;
pub mod radiosity;
pub mod ray_tracing;
pub mod registry;
pub mod roulette;
mod saved;
pub mod session;
pub mod strategies;
pub mod trees;
pub mod workers;
pub mod zbuffer;

pub use frame::Frame;
pub use method::{Commit, CommitKind, Method, MethodInfo, PassStats, RenderError, Schedule, Trust};
pub use session::{Budget, Observer, Outcome, Progress, Session};
pub use workers::Workers;

// The stages that the proofs build their scenes with, for tests of what is private here.
#[cfg(test)]
extern crate self as kaustika_transport;
#[cfg(test)]
#[allow(dead_code, reason = "the proofs use the rest")]
#[path = "../tests/proofs/scenes.rs"]
mod test_scenes;
