//! Terms as they are written.
//!
//! ```text
//! terms  term; term; …
//! term   [name=]maker:expression
//! maker  method[(key=value, …)]  |  photons@N  |  radiosity@N  |  cache@N
//! ```
//!
//! `photons@N`, `radiosity@N` and `cache@N` are walks from the camera that end in a light field at their N-th
//! diffuse surface. The expression is Heckbert's or OSL's
//! ([`path_expression`](kaustika_film::path_expression)).

use crate::registry::scalar;
use kaustika_film::path_expression::PathLayer;
use serde_json::{Map, Value};

/// A class of paths and who makes it.
#[derive(Clone, Debug)]
pub struct Term {
    /// Its name and class.
    pub layer: PathLayer,
    /// Who makes it.
    pub maker: Maker,
    /// As it was written, for messages.
    pub text: String,
}

/// Who makes a class.
#[derive(Clone, Debug, PartialEq)]
pub enum Maker {
    /// A method by its name, with these parameters.
    Method {
        /// Its name.
        name: String,
        /// What was said in parentheses.
        given: Map<String, Value>,
    },
    /// A walk that ends in a field.
    Field {
        /// What the field is kept in.
        kind: FieldKind,
        /// At which diffuse surface, from 1.
        at: usize,
    },
}

/// What a field is kept in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldKind {
    /// A photon map, of each pass anew.
    Photons,
    /// Patches, solved before the first pass.
    Radiosity,
    /// An irradiance cache, of each pass anew.
    Cache,
}

/// Diffuse surfaces up to which a walk may go.
const FARTHEST: usize = 8;

/// Reads a list of terms.
///
/// # Errors
/// If one is none; the message quotes it.
pub fn parse(text: &str) -> Result<Vec<Term>, String> {
    let mut terms: Vec<Term> = Vec::new();
    for (i, text) in text.split(';').map(str::trim).filter(|t| !t.is_empty()).enumerate() {
        let term = one(text, i).map_err(|e| format!("the term `{text}`: {e}"))?;
        if terms.iter().any(|t| t.layer.name == term.layer.name) {
            let name = &term.layer.name;
            return Err(format!("the term `{text}`: there is another of the name `{name}`"));
        }
        terms.push(term);
    }
    Ok(terms)
}

fn one(text: &str, number: usize) -> Result<Term, String> {
    let (head, expression) = text
        .split_once(':')
        .ok_or("expected MAKER:EXPRESSION, such as `path:L[D]S*E` or `photons@1:LS+DS*E`")?;
    let (before, given) = match head.split_once('(') {
        Some((before, rest)) => {
            let inside = rest.trim_end().strip_suffix(')').ok_or("expected `)` before `:`")?;
            (before, parameters(inside)?)
        }
        None => (head, Map::new()),
    };
    let (name, maker) = match before.split_once('=') {
        Some((name, maker)) => (name.trim().to_string(), maker.trim()),
        None => (format!("term{}", number + 1), before.trim()),
    };
    let maker = match maker.split_once('@') {
        Some((field, at)) => {
            let kind = match field.trim() {
                "photons" => FieldKind::Photons,
                "radiosity" => FieldKind::Radiosity,
                "cache" => FieldKind::Cache,
                other => {
                    let message = format!("no light field is kept in `{other}`");
                    return Err(format!("{message}; known: photons, radiosity, cache"));
                }
            };
            if !given.is_empty() {
                return Err("parameters of fields are those of the hybrid: `-p photons=...`".into());
            }
            let at = at.trim().parse().ok().filter(|n| (1..=FARTHEST).contains(n));
            let at = at.ok_or("expected a number from 1 to 8 after `@`: which diffuse surface")?;
            Maker::Field { kind, at }
        }
        None => Maker::Method { name: maker.into(), given },
    };
    let layer = PathLayer::parse(&format!("{name}={expression}")).map_err(|e| e.to_string())?;
    Ok(Term { layer, maker, text: text.into() })
}

/// `key=value, …`.
fn parameters(text: &str) -> Result<Map<String, Value>, String> {
    let mut map = Map::new();
    for pair in text.split(',').filter(|p| !p.trim().is_empty()) {
        let (key, value) = pair
            .split_once('=')
            .ok_or_else(|| format!("expected KEY=VALUE in parentheses, found `{}`", pair.trim()))?;
        map.insert(key.trim().into(), scalar(value.trim()));
    }
    Ok(map)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_are_read() {
        let terms = parse(
            "A = path(max_depth=3, mis=balance) : L[D]S*E; photons@1:LS+DS*E ; C=radiosity@2:CD+L;",
        );
        let terms = terms.expect("sound");
        let names: Vec<&str> = terms.iter().map(|t| t.layer.name.as_str()).collect();
        assert_eq!(names, ["A", "term2", "C"]);
        let given = Map::from_iter([
            ("max_depth".into(), Value::from(3)),
            ("mis".into(), Value::from("balance")),
        ]);
        assert_eq!(terms[0].maker, Maker::Method { name: "path".into(), given });
        assert_eq!(terms[1].maker, Maker::Field { kind: FieldKind::Photons, at: 1 });
        assert_eq!(terms[2].maker, Maker::Field { kind: FieldKind::Radiosity, at: 2 });
    }

    #[test]
    fn what_is_no_term_is_told() {
        for (text, message) in [
            ("path", "expected MAKER:EXPRESSION"),
            ("path(a=1:LE", "expected `)`"),
            ("path(a):LE", "expected KEY=VALUE"),
            ("voxels@1:LDE", "no light field is kept in `voxels`"),
            ("photons@0:LDE", "from 1 to 8"),
            ("photons@1(photons=3):LDE", "parameters of fields"),
            ("path:LQE", "`Q` is no letter"),
            ("a=path:LE; a=path:LDE", "another of the name `a`"),
        ] {
            let error = parse(text).expect_err(text);
            assert!(error.contains(message), "{text}: {error}");
        }
    }
}
