//! Replacing a file as one step.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU32, Ordering};

/// Writes `bytes` to a new file beside `path`, then renames it to `path`. If anything fails the
/// new file is removed and the old one stays. Data is handed to the system, not forced to disk.
///
/// # Errors
/// As the system's: no folder, no right, no room.
pub fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let temporary = Temporary(beside(path)?);
    let mut file = File::options().write(true).create_new(true).open(&temporary.0)?;
    file.write_all(bytes)?;
    drop(file);
    fs::rename(&temporary.0, path)
}

/// A name in the same folder that no other writer uses.
fn beside(path: &Path) -> io::Result<PathBuf> {
    static COUNTER: AtomicU32 = AtomicU32::new(0);
    let no_name = || io::Error::new(io::ErrorKind::InvalidInput, "the path names no file");
    let mut name = OsString::from(".");
    name.push(path.file_name().ok_or_else(no_name)?);
    let unique = COUNTER.fetch_add(1, Ordering::Relaxed);
    name.push(format!(".{}-{unique}.tmp", process::id()));
    Ok(path.with_file_name(name))
}

/// Removes the file when dropped; after the rename there is nothing left to remove.
struct Temporary(PathBuf);

impl Drop for Temporary {
    fn drop(&mut self) {
        // Failure is the normal case (renamed, or never created) and has no remedy otherwise.
        let _ = fs::remove_file(&self.0);
    }
}
