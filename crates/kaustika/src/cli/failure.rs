//! How commands fail.

use std::fmt::Display;
use std::process::ExitCode;

/// Why a command did not do what it was asked.
#[derive(Debug)]
pub enum Failure {
    /// The input or the render failed: exit code 1.
    Input(String),
    /// As `Input`, and the user has been told already.
    Told,
    /// The command line asks for what does not exist: exit code 2.
    Usage(String),
}

impl Failure {
    /// From any error about the input.
    pub fn input(error: impl Display) -> Failure {
        Failure::Input(error.to_string())
    }

    /// From any error about the command line.
    pub fn usage(error: impl Display) -> Failure {
        Failure::Usage(error.to_string())
    }

    /// What is still to be said.
    pub fn message(&self) -> Option<&str> {
        match self {
            Failure::Input(m) | Failure::Usage(m) => Some(m),
            Failure::Told => None,
        }
    }

    /// The program's exit code.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Failure::Input(_) | Failure::Told => ExitCode::from(1),
            Failure::Usage(_) => ExitCode::from(2),
        }
    }
}
