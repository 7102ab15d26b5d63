//! Where the files lie that a scene names.

use super::document::Document;
use kaustika_scene::description::SourceMap;
use std::path::{Path, PathBuf};

/// Advice where a file is not found.
pub(super) const WHERE_LOOKED: &str =
    "relative names start at the folder of the scene file or at that of a `<path>` element";

/// The first that exists of: the name in the folders of `<path>` elements (of the file it stands
/// in, then of the main file), beside the file it stands in, beside the main file, in the working
/// directory. Backslashes count as slashes.
pub(super) fn find(
    document: &Document,
    sources: &SourceMap,
    file: u32,
    name: &str,
) -> Option<PathBuf> {
    let relative = PathBuf::from(name.trim().replace('\\', "/"));
    if relative.as_os_str().is_empty() {
        return None;
    }
    let named = [file as usize, 0].into_iter().filter_map(|f| document.paths.get(f)).flatten();
    let beside = [file as usize, 0]
        .into_iter()
        .filter_map(|f| sources.files.get(f)?.path.parent().map(Path::to_path_buf));
    named
        .cloned()
        .chain(beside)
        .chain([PathBuf::new()])
        .map(|folder| folder.join(&relative))
        .find(|path| path.exists())
}
