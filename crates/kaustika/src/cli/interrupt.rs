//! Ctrl-C: the first press ends the render in good order, a later one ends the program.

use super::failure::Failure;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The exit code of a program ended by Ctrl-C, as shells have it: 128 + SIGINT.
const ABORTED: i32 = 130;
/// Requests that come so soon after the first are the same one: `timeout`, shells and containers pass a signal on to a
/// program and to its whole group.
const SAME: Duration = Duration::from_secs(1);

/// Listens from now on; the flag rises at the first Ctrl-C or request to terminate.
///
/// # Errors
/// If the system does not let it.
pub fn install() -> Result<Arc<AtomicBool>, Failure> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&flag);
    let mut first = None;
    ctrlc::set_handler(move || match answer(&mut first, Instant::now()) {
        Answer::Stop => {
            raised.store(true, Ordering::Relaxed);
            eprintln!("\nstopping; once more to end at once without writing anything");
        }
        Answer::Same => {}
        Answer::Abort => std::process::exit(ABORTED),
    })
    .map_err(|e| Failure::Input(format!("can't listen for Ctrl-C: {e}")))?;
    Ok(flag)
}

/// What a request to stop asks for.
#[derive(Debug, PartialEq)]
enum Answer {
    /// To stop in good order.
    Stop,
    /// What was asked for already.
    Same,
    /// To end at once.
    Abort,
}

/// To a request that comes `now`; keeps when the first one came.
fn answer(first: &mut Option<Instant>, now: Instant) -> Answer {
    match *first {
        None => {
            *first = Some(now);
            Answer::Stop
        }
        Some(first) if now.duration_since(first) < SAME => Answer::Same,
        Some(_) => Answer::Abort,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_at_once_are_one() {
        let (mut first, start) = (None, Instant::now());
        let at = |ms| start + Duration::from_millis(ms);
        assert_eq!(answer(&mut first, at(0)), Answer::Stop);
        assert_eq!(answer(&mut first, at(0)), Answer::Same);
        assert_eq!(answer(&mut first, at(999)), Answer::Same);
        assert_eq!(answer(&mut first, at(1000)), Answer::Abort);
    }
}
