//! The program as its users meet it: run, files compared, exit codes looked at.

mod agreement;
mod baking;
// The expected texts quote the system's own words for what it refuses.
#[cfg(unix)]
mod broken;
mod commands;
mod corpus;
mod denoise;
mod errors;
mod films;
mod kit;
mod plot;
mod references;
mod shares;
