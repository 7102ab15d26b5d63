//! What can go wrong with an image file.

use std::io;
use std::path::{Path, PathBuf};

/// Why an image file could not be read or written. Each message is one line that names the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The file could not be opened, read or written.
    #[error("{}: {}", path.display(), io_cause(source))]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// Neither the first bytes nor the extension belong to a format known here.
    #[error("{}: not an image format known here (png, jpg, tga, bmp, exr, hdr, pfm)", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The file ends early.
    #[error("{}: the {format} data ends early (truncated file)", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// Name of the format.
        format: &'static str,
    },
    /// The contents contradict the format.
    #[error("{}: broken {format} data: {cause}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Name of the format.
        format: &'static str,
        /// What is wrong, one line.
        cause: String,
    },
    /// The contents are valid but use a feature that is not handled.
    #[error("{}: {format}: {cause}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// Name of the format.
        format: &'static str,
        /// What is not handled, one line.
        cause: String,
    },
    /// The header asks for more pixels than are allowed, or than the file can hold.
    #[error("{}: the header claims {width} x {height} pixels, {cause}", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Claimed columns.
        width: u64,
        /// Claimed rows.
        height: u64,
        /// Which limit is exceeded.
        cause: &'static str,
    },
    /// The picture lacks what the format needs.
    #[error("{}: {cause}", path.display())]
    CannotStore {
        /// The file.
        path: PathBuf,
        /// What is missing or inconsistent.
        cause: String,
    },
}

impl ImageError {
    pub(crate) fn io(path: &Path, source: io::Error) -> Self {
        ImageError::Io { path: path.into(), source }
    }

    pub(crate) fn truncated(path: &Path, format: &'static str) -> Self {
        ImageError::Truncated { path: path.into(), format }
    }

    pub(crate) fn malformed(path: &Path, format: &'static str, cause: impl ToString) -> Self {
        ImageError::Malformed { path: path.into(), format, cause: one_line(&cause.to_string()) }
    }

    pub(crate) fn unsupported(path: &Path, format: &'static str, cause: impl ToString) -> Self {
        ImageError::Unsupported { path: path.into(), format, cause: one_line(&cause.to_string()) }
    }

    pub(crate) fn cannot_store(path: &Path, cause: impl ToString) -> Self {
        ImageError::CannotStore { path: path.into(), cause: one_line(&cause.to_string()) }
    }
}

/// The commonest causes without the operating system's error numbers.
fn io_cause(source: &io::Error) -> String {
    match source.kind() {
        io::ErrorKind::NotFound => "no such file".into(),
        io::ErrorKind::PermissionDenied => "permission denied".into(),
        io::ErrorKind::IsADirectory => "is a folder".into(),
        _ => one_line(&source.to_string()),
    }
}

/// Foreign messages come with line breaks, capitals and full stops; ours do not.
fn one_line(message: &str) -> String {
    let joined = message.split_whitespace().collect::<Vec<_>>().join(" ");
    let trimmed = joined.trim_end_matches('.');
    let mut chars = trimmed.chars();
    match (chars.next(), chars.next()) {
        (Some(first), Some(second)) if first.is_uppercase() && second.is_lowercase() => {
            first.to_lowercase().chain(trimmed.chars().skip(1)).collect()
        }
        _ => trimmed.to_owned(),
    }
}
