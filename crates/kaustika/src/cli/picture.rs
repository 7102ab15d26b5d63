//! Writing pictures, and finding out before the render that it would fail.

use super::args::LookArgs;
use super::failure::Failure;
use kaustika::film::{Picture, WriteOptions, write_picture};
use kaustika::pyramid;
use std::path::{Path, PathBuf};

/// Extensions that can be written.
const EXTENSIONS: [&str; 8] = ["exr", "png", "jpg", "jpeg", "hdr", "rgbe", "pic", "pfm"];

/// Refuses outputs that could not be written in the end.
///
/// # Errors
/// An unknown extension is wrong usage, a missing folder wrong input.
pub fn check_outputs(outputs: &[PathBuf]) -> Result<(), Failure> {
    for path in outputs {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        if !extension.is_some_and(|e| EXTENSIONS.contains(&e.as_str())) {
            let known = "only exr, png, jpg, hdr and pfm can be written";
            return Err(Failure::Usage(format!("{}: {known}", path.display())));
        }
        check_place(path)?;
    }
    Ok(())
}

/// Refuses a file that could not be written: a folder itself, or in none.
///
/// # Errors
/// If so.
pub fn check_place(path: &Path) -> Result<(), Failure> {
    if path.is_dir() {
        return Err(Failure::Input(format!("{}: is a folder", path.display())));
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|p| !p.is_dir()) {
        let (path, folder) = (path.display(), folder.display());
        return Err(Failure::Input(format!("{path}: there is no folder {folder}")));
    }
    Ok(())
}

/// Writes one picture to all outputs. All are tried; the first error is returned.
///
/// # Errors
/// If one can't be written.
pub fn write(outputs: &[PathBuf], picture: &Picture, look: &LookArgs) -> Result<(), Failure> {
    let tone = |rgb| look.tonemap.apply(rgb, 0.0);
    let options =
        WriteOptions { exposure: look.exposure, tone: Some(&tone), ..WriteOptions::default() };
    let mut first_error = Ok(());
    for path in outputs {
        if let Err(e) = write_picture(path, picture, &options) {
            first_error = first_error.and(Err(Failure::input(e)));
        }
    }
    if let (Some(path), Some(sheet)) = (sheet_beside(outputs), pyramid::sheet(picture))
        && let Err(e) = write_picture(&path, &sheet, &options)
    {
        first_error = first_error.and(Err(Failure::input(e)));
    }
    first_error
}

/// Where the sheet of a pyramid goes.
fn sheet_beside(outputs: &[PathBuf]) -> Option<PathBuf> {
    outputs.first().map(|path| path.with_extension("pyramid.png"))
}

/// Says what was written.
pub fn tell(outputs: &[PathBuf]) {
    let names: Vec<String> = outputs.iter().map(|p| p.display().to_string()).collect();
    eprintln!("wrote {}", names.join(", "));
}
