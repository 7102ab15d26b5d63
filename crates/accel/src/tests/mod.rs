//! Whole trees against brute force, oracles and closed meshes.

mod batches;
mod boxes;
mod brute_force;
mod build;
mod meshes;
mod oracle;
mod semantics;
mod watertight;
