//! What a mutation proposes.

use super::path::Path;

/// A proposed path, with f(x) T(x→y) and f(y) T(y→x) up to a common factor.
pub(super) struct Proposal<'a> {
    pub(super) path: Path<'a>,
    pub(super) there: f64,
    pub(super) back: f64,
}
