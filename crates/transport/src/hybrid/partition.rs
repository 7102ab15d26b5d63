//! The proof that terms part a class of paths: every path of it belongs to one of them, and no other
//! path to any.

use super::term::Term;
use kaustika_film::path_expression::{PathClasses, PathLayer, Word};
use std::collections::BTreeMap;

/// Proves that the terms part the paths `of`.
///
/// # Errors
/// Says what is wrong with a shortest path that is made twice, or never, or is none of those.
pub fn check(terms: &[Term], of: &str) -> Result<(), String> {
    if terms.is_empty() {
        return Err("there are no terms: `path:L(D|S)*E` is the least".into());
    }
    let whole = PathLayer::parse(&format!("of={of}")).map_err(|e| format!("`of`: {e}"))?;
    let named = |(i, t): (usize, &Term)| t.layer.named(&format!("t{i}"));
    let layers = terms.iter().enumerate().map(named).chain([whole]).collect();
    let sets = sets(layers)?;
    let whole = 1u32 << terms.len();
    let shortest = |wrong: &dyn Fn(u32) -> bool| {
        let found = sets.iter().filter(|(set, _)| wrong(**set));
        found.min_by_key(|(_, word)| word.events.len())
    };
    let made = |set: u32| (set & (whole - 1)).count_ones();
    if let Some((set, word)) = shortest(&|set| made(set) > 1) {
        let both = terms.iter().enumerate().filter(|(i, _)| set >> i & 1 != 0);
        let both: Vec<String> = both.map(|(_, t)| format!("`{}`", t.text)).collect();
        return Err(format!(
            "light would be counted twice: {} make {word}; take it out of all but one",
            both.join(" and ")
        ));
    }
    if let Some((_, word)) = shortest(&|set| set & whole != 0 && made(set) == 0) {
        return Err(format!(
            "light would be lost: no term makes {word}; add a term for it, or say with `of` which \
             paths are wanted"
        ));
    }
    if let Some((set, word)) = shortest(&|set| set & whole == 0 && made(set) != 0) {
        let term = &terms[set.trailing_zeros() as usize].text;
        return Err(format!("`{term}` makes {word}, which is none of `{of}`; take it out"));
    }
    Ok(())
}

/// As [`PathClasses::sets`] of these layers.
///
/// # Errors
/// If they are too many or too intricate.
pub(super) fn sets(layers: Vec<PathLayer>) -> Result<BTreeMap<u32, Word>, String> {
    Ok(PathClasses::new(layers).map_err(|e| e.to_string())?.sets())
}

#[cfg(test)]
mod tests {
    use super::super::term::parse;
    use super::*;

    fn checked(terms: &str, of: &str) -> Result<(), String> {
        check(&parse(terms).expect(terms), of)
    }

    #[test]
    fn partitions_are_accepted() {
        let all = "L(D|S)*E";
        for terms in [
            "path:L(D|S)*E",
            "path:L[D]S*E; photons@1:LS+DS*E; radiosity@2:L(D|S)*DS*DS*E",
            "radiosity:LD*E; path:LD*S(D|S)*E",
            "path:LE; path:LS+E; path:L(D|S)*DE; path:L(D|S)*DS+E",
            // OSL's, by name of the light.
            "path:C.*<L.'key'>; path:C.*[^<L.'key'>]",
            "path:C<R.>.*L; path:C<T.>.*L; path:CL",
        ] {
            checked(terms, all).expect(terms);
        }
        checked("path:LS*E; path:LDE", "L[D]E|LS*E").expect("with `of`");
    }

    /// What is wrong, and the shortest path that shows it.
    #[test]
    fn others_are_not_and_a_shortest_path_says_why() {
        let all = "L(D|S)*E";
        for (terms, of, expected) in [
            ("path:L[D]S*E; photons@1:LS+DS*E", all, "no term makes `LDDE`"),
            ("path:L[D]S*E; radiosity@2:L(D|S)*DS*DS*E", all, "no term makes `LSDE`"),
            ("path:LS+DS*E; path:L(D|S)*DS*DS*E; path:LS+E", all, "no term makes `LE`"),
            // Chen's traps: a gather that meets a light, a caustic twice.
            ("path:L[D]S*E; b=path:LS*DS*E; c=path:L(D|S)*DS*DS*E", all, "make `LDE`"),
            ("path:L[D]S*E; b=path:LS+DS*E; c=path:L(D|S)*DS*E", all, "make `LDE`"),
            ("path:L(D|S)*E; b=path:LDDDSSE", all, "make `LDDDSSE`"),
            ("path:L[D]S*E", "L[D]S_M*E", "makes `LSE`"),
            ("path:C<R.>.*L; path:CL", all, "no term makes `LDE` (from the camera `C<TD>O`)"),
            ("path:CO; path:CB; path:C.+L", all, "no term makes `LE` (from the camera `CL`)"),
            ("path:C.*<L.'key'>", all, "no term makes `LE` (from the camera `CO`)"),
        ] {
            let error = checked(terms, of).expect_err(terms);
            assert!(error.contains(expected), "{terms}: {error}");
        }
    }
}
