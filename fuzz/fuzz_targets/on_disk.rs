//! Bytes as a file, for readers that want one.

use std::path::{Path, PathBuf};
use std::sync::Once;

/// Calls `read` with a file of these bytes, one for the whole process.
pub fn with(bytes: &[u8], extension: &str, read: impl FnOnce(&Path)) {
    let folder: PathBuf = std::env::temp_dir().join(format!("kaustika-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("room for a file");
    let path = folder.join("input").with_extension(extension);
    std::fs::write(&path, bytes).expect("room for a file");
    read(&path);
}

/// Lets panics unwind that the program catches by itself (of libraries that read images); those
/// that it does not catch still end the run.
#[allow(dead_code, reason = "not every target needs it")]
pub fn catch_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| std::panic::set_hook(Box::new(|_| {})));
}
