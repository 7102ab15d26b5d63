//! Light path expressions: which paths a layer of the picture shows.
//!
//! Two grammars, told apart by how they begin. **OSL's** goes from the camera: `C<RD>.*<L.'key'>`
//! (`lpe:` before it is accepted, and so are Arnold's names of common ones, `diffuse_direct` and
//! its like). **Heckbert's** (1990), the lecture's, goes from the light: `LS+DS*E`. Both become
//! automata that can be run from either end of a path, or from both to where subpaths meet
//! ([`PathClasses`]).
//!
//! What goes straight through (cut-outs, boundaries of media) is no event.

mod automaton;
mod heckbert;
mod names;
mod osl;
mod regex;
mod series;
#[cfg(test)]
mod tests;
mod words;

pub use automaton::{Back, Front, PathClasses};
pub use words::Word;

use regex::Regex;
use std::fmt;

/// What light does at a vertex of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Event {
    /// Scatters at a surface.
    Surface(Way, Kind),
    /// Scatters in a medium: `V`.
    Volume,
}

/// To which side light scatters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Way {
    /// `R`.
    Reflection,
    /// `T`.
    Transmission,
}

/// Into how many directions light scatters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// `D`: diffuse.
    Diffuse,
    /// `G`: glossy.
    Glossy,
    /// `S`: one alone, as mirrors and clear glass.
    Singular,
}

/// What emits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// A point, a spot, a direction: `L`.
    Lamp,
    /// A surface: `L` and `O`.
    Surface,
    /// What surrounds the scene: `L` and `B`.
    Background,
    /// A medium: `L` and `O`.
    Medium,
}

/// A layer of the picture: the light of some paths.
#[derive(Clone, Debug, PartialEq)]
pub struct PathLayer {
    /// Its name, which its channels begin with.
    pub name: String,
    /// The expression as the user wrote it.
    pub text: String,
    regex: Regex,
}

/// What is wrong with an expression.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}\n  {text}\n  {:>1$}", "^", .at + 1)]
pub struct ExpressionError {
    /// What.
    pub message: String,
    /// The expression.
    pub text: String,
    /// The character at fault.
    pub at: usize,
}

impl PathLayer {
    /// Reads `NAME=EXPRESSION`, or one of Arnold's names alone.
    ///
    /// # Errors
    /// If there is no name or the expression is none.
    pub fn parse(argument: &str) -> Result<PathLayer, ExpressionError> {
        let error = |message: String| ExpressionError { message, text: argument.into(), at: 0 };
        let (name, text) = match argument.split_once('=') {
            Some((name, text)) => (name.trim(), text.trim()),
            None => match names::known(argument.trim()) {
                Some(text) => (argument.trim(), text),
                None => {
                    let known = names::all().collect::<Vec<_>>().join(", ");
                    let message = format!("expected NAME=EXPRESSION, or one of the names {known}");
                    return Err(error(message));
                }
            },
        };
        if name.is_empty() || !name.chars().all(|c| c.is_alphanumeric() || "_-".contains(c)) {
            let message = "a layer's name consists of letters, digits, `_` and `-`".into();
            return Err(error(message));
        }
        let regex = parse(names::known(text).unwrap_or(text))?;
        Ok(PathLayer { name: name.into(), text: text.into(), regex })
    }

    /// As [`PathLayer::parse`]; or `bounces:N` or `words:N`, which are several layers: the terms of the
    /// Neumann series, and its words of D and S.
    ///
    /// # Errors
    /// As [`PathLayer::parse`], or if N is too large.
    pub fn parse_all(argument: &str) -> Result<Vec<PathLayer>, ExpressionError> {
        match series::series(argument) {
            Some(layers) => layers,
            None => PathLayer::parse(argument).map(|layer| vec![layer]),
        }
    }

    /// The same paths by another name.
    pub fn named(&self, name: &str) -> PathLayer {
        PathLayer { name: name.into(), ..self.clone() }
    }

    /// EXR channel names.
    pub fn channels(&self) -> [String; 3] {
        ["R", "G", "B"].map(|c| format!("{}.{c}", self.name))
    }
}

impl fmt::Display for PathLayer {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}={}", self.name, self.text)
    }
}

/// The expression in whichever grammar it is.
fn parse(text: &str) -> Result<Regex, ExpressionError> {
    let osl = text.strip_prefix("lpe:").map(str::trim_start);
    match osl {
        Some(osl) => osl::parse(osl),
        None if text.starts_with('C') => osl::parse(text),
        None if text.starts_with('L') && text.ends_with('E') => heckbert::parse(text),
        None => Err(ExpressionError {
            message: "an expression begins with C and goes from the camera to the light, as \
                      `C<RD>.*L`, or begins with L and ends with E, as `LS+DS*E`"
                .into(),
            text: text.into(),
            at: 0,
        }),
    }
}
