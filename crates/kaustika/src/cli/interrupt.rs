//! Ctrl-C: the first press ends the render in good order, the second ends the program.

use super::failure::Failure;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The exit code of a program ended by Ctrl-C, as shells have it: 128 + SIGINT.
const ABORTED: i32 = 130;

/// Listens from now on; the flag rises at the first Ctrl-C or request to terminate.
///
/// # Errors
/// If the system does not let it.
pub fn install() -> Result<Arc<AtomicBool>, Failure> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&flag);
    ctrlc::set_handler(move || {
        if raised.swap(true, Ordering::Relaxed) {
            std::process::exit(ABORTED);
        }
        eprintln!("\nstopping; once more to end at once without writing anything");
    })
    .map_err(|e| Failure::Input(format!("can't listen for Ctrl-C: {e}")))?;
    Ok(flag)
}
