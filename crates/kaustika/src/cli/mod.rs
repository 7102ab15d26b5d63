//! The command line: one file a command, thin over the library.

mod args;
mod bake;
mod compare;
mod counted;
mod denoise;
mod diagnostics;
mod duration;
mod failure;
mod fly;
mod info;
mod interrupt;
mod job;
mod merge;
mod methods;
mod picture;
mod plot;
mod progress;
mod rays;
mod render;
mod stdout;
mod values;
mod viewer;

use args::{Args, Command};
use clap::Parser;
use std::process::ExitCode;

/// Runs the command that the program was started with.
pub fn main() -> ExitCode {
    // Wrong usage ends inside `parse`, with exit code 2.
    let done = match &Args::parse().command {
        Command::Render(args) => render::run(args),
        Command::Merge(args) => merge::run(args),
        Command::Denoise(args) => denoise::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Methods(args) => methods::run(args),
        Command::Info(args) => info::run(args),
        Command::Rays(args) => rays::run(args),
        Command::Fly(args) => fly::run(args),
        Command::Plot(args) => plot::run(args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if let Some(message) = failure.message() {
                eprintln!("error: {message}");
            }
            failure.exit_code()
        }
    }
}
