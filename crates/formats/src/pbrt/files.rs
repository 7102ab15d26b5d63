//! Finding and reading scene files.

use flate2::read::MultiGzDecoder;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Reads a scene file, unpacking it if it is gzipped (known by its first bytes). Text that is
/// not UTF-8 keeps its ASCII part.
///
/// # Errors
/// A one-line cause.
pub(super) fn read_text(path: &Path) -> Result<String, String> {
    let mut bytes = Vec::new();
    File::open(path).and_then(|mut f| f.read_to_end(&mut bytes)).map_err(|e| e.to_string())?;
    if bytes.starts_with(&[0x1f, 0x8b]) {
        let mut unpacked = Vec::new();
        let result = MultiGzDecoder::new(&bytes[..]).read_to_end(&mut unpacked);
        result.map_err(|e| format!("broken gzip file: {e}"))?;
        bytes = unpacked;
    }
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err("the file is UTF-16, expected UTF-8".to_string());
    }
    if bytes.contains(&0) {
        return Err("it is no text: it has zero bytes in it".to_string());
    }
    if bytes.len() > u32::MAX as usize {
        return Err("files of 4 GiB and more are not supported".to_string());
    }
    Ok(String::from_utf8(bytes)
        .unwrap_or_else(|e| String::from_utf8_lossy(e.as_bytes()).into_owned()))
}

/// Advice where a file is not found.
pub(super) const WHERE_LOOKED: &str =
    "relative names start at the folder of the main scene file or of the file that names it";

/// The file that `name` means: as pbrt-v4 has it, relative to the folder of the main scene file,
/// else to that of the file that names it, else to the working directory.
pub(super) fn resolve(name: &str, main: &Path, current: &Path) -> Option<PathBuf> {
    if name.is_empty() {
        return None;
    }
    let candidates = [main.join(name), current.join(name), PathBuf::from(name)];
    candidates.into_iter().find(|p| p.is_file())
}

/// A file in the folder where `name` should be whose name is like it.
pub(super) fn nearest_file(name: &str, main: &Path) -> Option<String> {
    let wanted = Path::new(name);
    let folder = main.join(wanted.parent().unwrap_or(Path::new("")));
    let wanted_name = wanted.file_name()?.to_str()?;
    let entries = std::fs::read_dir(folder).ok()?.take(10_000);
    let mut names: Vec<String> =
        entries.flatten().filter_map(|e| e.file_name().into_string().ok()).collect();
    names.sort_unstable();
    let known: Vec<&str> = names.iter().map(String::as_str).collect();
    let nearest = kaustika_scene::description::nearest_name(wanted_name, &known)?;
    Some(wanted.with_file_name(nearest).display().to_string())
}
