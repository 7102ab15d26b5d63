//! Checkpoints: everything a render needs to go on, in one file that appears complete or not at
//! all. A checkpoint is also a share of a render; [`merge`] puts shares together.

mod format;
mod merge;

pub use merge::{MergeError, merge};

use crate::record::Record;
use kaustika_film::accumulate::PassTree;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The state of a render between two passes.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// What is being rendered.
    pub record: Record,
    /// The passes so far.
    pub tree: PassTree,
    /// What the method saved of itself.
    pub method_state: Vec<u8>,
    /// Time spent rendering, seconds.
    pub seconds: f64,
}

/// Why a checkpoint can't be used.
#[derive(Debug, Error)]
pub enum CheckpointError {
    /// The file can't be opened, read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// It holds something else, or not all of it.
    #[error("{}: {cause}", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        cause: String,
    },
}

impl Checkpoint {
    /// Reads a checkpoint. Nothing is believed that the checksum does not confirm.
    ///
    /// # Errors
    /// If the file can't be read, is not a checkpoint, is cut short or damaged.
    pub fn read(path: &Path) -> Result<Checkpoint, CheckpointError> {
        let bytes =
            fs::read(path).map_err(|source| CheckpointError::Io { path: path.into(), source })?;
        format::decode(&bytes).map_err(|cause| CheckpointError::Broken { path: path.into(), cause })
    }

    /// Writes the checkpoint; a file of this name is replaced only by a complete one.
    ///
    /// # Errors
    /// If the file can't be written.
    pub fn write(&self, path: &Path) -> Result<(), CheckpointError> {
        write(path, &self.record, &self.tree, &self.method_state, self.seconds)
    }
}

/// As [`Checkpoint::write`], of parts that need not be put together first.
///
/// # Errors
/// If the file can't be written.
pub fn write(
    path: &Path,
    record: &Record,
    tree: &PassTree,
    method_state: &[u8],
    seconds: f64,
) -> Result<(), CheckpointError> {
    format::encode(record, tree, method_state, seconds)
        .and_then(|bytes| kaustika_film::files::replace(path, &bytes))
        .map_err(|source| CheckpointError::Io { path: path.into(), source })
}

/// Where the checkpoint of a render lies whose first output is `image`.
pub fn beside(image: &Path) -> PathBuf {
    image.with_extension("ckpt")
}
