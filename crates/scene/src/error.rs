//! Why a described scene can't be built.

use crate::description::{Diagnostics, SceneDescription, Span};

/// A fault found while building; the message names what and the span where.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{message}")]
pub struct BuildError {
    /// What is wrong: lower case, no full stop.
    pub message: String,
    /// Where it was described.
    pub span: Option<Span>,
}

impl BuildError {
    pub(crate) fn new(span: Option<Span>, message: impl Into<String>) -> BuildError {
        BuildError { message: message.into(), span }
    }

    /// As diagnostics, to be shown beside the readers' own.
    pub fn into_diagnostics(self, description: &SceneDescription) -> Diagnostics {
        let mut d = description.diagnostics.clone();
        d.error(self.span, self.message);
        d
    }
}
