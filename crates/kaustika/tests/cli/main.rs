//! The program as its users meet it: run, files compared, exit codes looked at.

mod commands;
mod errors;
mod kit;
mod shares;
