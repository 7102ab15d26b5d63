//! `kaustika merge`.

use super::args::MergeArgs;
use super::failure::Failure;
use super::{counted, picture};
use kaustika::checkpoint::{self, Checkpoint};
use kaustika::output;
use std::path::{Path, PathBuf};

/// Puts shares together, and writes the picture and the checkpoint of the whole.
///
/// # Errors
/// If a part can't be read or the parts don't make one render.
pub fn run(args: &MergeArgs) -> Result<(), Failure> {
    picture::check_outputs(&args.output)?;
    let mut parts = Vec::new();
    for part in &args.parts {
        let path = checkpoint_of(part)?;
        let share = Checkpoint::read(&path).map_err(Failure::input)?;
        parts.push((path.display().to_string(), share));
    }
    let whole = checkpoint::merge(parts).map_err(Failure::input)?;
    let passes = whole.tree.passes();
    if passes == 0 {
        return Err(Failure::input("the parts hold no passes"));
    }
    let merged = output::picture(&whole.tree, None, &whole.record, whole.seconds);
    picture::write(&args.output, &merged, &args.look)?;
    if let Some(first) = args.output.first() {
        whole.write(&checkpoint::beside(first)).map_err(Failure::input)?;
    }
    eprintln!("merged {} of {} parts", counted::passes(passes), args.parts.len());
    picture::tell(&args.output);
    Ok(())
}

/// The checkpoint that a part of the command line stands for.
fn checkpoint_of(part: &Path) -> Result<PathBuf, Failure> {
    if part.extension().is_some_and(|e| e == "ckpt") {
        return Ok(part.into());
    }
    let path = checkpoint::beside(part);
    if path.exists() {
        return Ok(path);
    }
    let (part, path) = (part.display(), path.display());
    Err(Failure::Input(format!(
        "{part}: its share {path} is not there; render with --passes to keep one"
    )))
}
