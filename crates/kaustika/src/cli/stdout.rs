//! Results on stdout.

use super::failure::Failure;
use std::io::{ErrorKind, Write, stdout};

/// Writes text. A reader that has gone away, such as `head`, has read enough.
///
/// # Errors
/// If stdout can't be written.
pub fn write(text: &str) -> Result<(), Failure> {
    let mut out = stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Failure::input(e)),
        _ => Ok(()),
    }
}

/// Writes JSON, indented.
///
/// # Errors
/// If stdout can't be written.
pub fn write_json(value: &serde_json::Value) -> Result<(), Failure> {
    write(&format!("{value:#}\n"))
}
