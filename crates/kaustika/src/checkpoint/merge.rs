//! Shares of one render, put together.

use super::Checkpoint;
use kaustika_film::accumulate::PassTree;
use thiserror::Error;

/// Why shares don't make one render. Parts are named as the caller named them.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum MergeError {
    /// There is nothing to merge.
    #[error("no parts to merge")]
    Empty,
    /// Parts of different renders.
    #[error("{first} and {second} are not of one render: {difference}")]
    Different {
        /// One part.
        first: String,
        /// Another.
        second: String,
        /// In what they differ.
        difference: String,
    },
    /// Passes rendered twice.
    #[error("{first} and {second} both hold pass {pass}")]
    Overlap {
        /// One part.
        first: String,
        /// Another.
        second: String,
        /// First pass in both.
        pass: u64,
    },
    /// Passes that no part holds.
    #[error("the parts leave a gap: passes {start}..{end} are in none of them")]
    Gap {
        /// First pass missing.
        start: u64,
        /// First pass after the gap.
        end: u64,
    },
    /// A method's passes build on each other.
    #[error("the method of these parts learns from pass to pass; its shares can't be joined")]
    Sequential,
}

/// Puts shares of one render together, in any order. The result has the bits of a single run.
///
/// # Errors
/// If the parts are of different renders, overlap, or don't hold every pass from 0 on.
pub fn merge(parts: Vec<(String, Checkpoint)>) -> Result<Checkpoint, MergeError> {
    let Some((name, first)) = parts.first() else { return Err(MergeError::Empty) };
    let one = |(part, c): &(String, Checkpoint)| match first.record.difference(&c.record) {
        None => Ok(()),
        Some(difference) => {
            Err(MergeError::Different { first: name.clone(), second: part.clone(), difference })
        }
    };
    parts.iter().try_for_each(one)?;
    if parts.len() > 1 && parts.iter().any(|(_, c)| !c.method_state.is_empty()) {
        return Err(MergeError::Sequential);
    }
    check_ranges(&parts)?;

    let record = first.record.clone();
    let seconds = parts.iter().map(|(_, c)| c.seconds).sum();
    let (width, height) = (first.tree.width(), first.tree.height());
    let mut tree = PassTree::new(width, height, first.tree.layers().clone());
    let mut method_state = Vec::new();
    for (part, c) in parts {
        let different = |e: kaustika_film::accumulate::MergeError| MergeError::Different {
            first: "the parts before".into(),
            second: part.clone(),
            difference: e.to_string(),
        };
        tree.merge(c.tree).map_err(different)?;
        method_state = c.method_state;
    }
    Ok(Checkpoint { record, tree, method_state, seconds })
}

/// Every pass from 0 to the last exactly once.
fn check_ranges(parts: &[(String, Checkpoint)]) -> Result<(), MergeError> {
    let of_part = |(name, c): &(String, Checkpoint)| {
        c.tree.ranges().into_iter().map(|r| (r, name.clone())).collect::<Vec<_>>()
    };
    let mut ranges: Vec<([u64; 2], String)> = parts.iter().flat_map(of_part).collect();
    ranges.sort();
    let mut end = 0;
    let mut before = "";
    for ([a, b], name) in &ranges {
        if *a < end {
            let (first, second) = (before.to_string(), name.clone());
            return Err(MergeError::Overlap { first, second, pass: *a });
        }
        if *a > end {
            return Err(MergeError::Gap { start: end, end: *a });
        }
        (end, before) = (*b, name);
    }
    Ok(())
}
