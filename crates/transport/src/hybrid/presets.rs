//! Hybrids of the literature by name.
//!
//! ```text
//! Wallace, Cohen & Greenberg 1987   radiosity by way of one mirror, seen by way of any    L([S_M]D)*S_M*E
//! Sillion & Puech 1989              radiosity by way of any number of mirrors and glass   L(S_M*D)*S_M*E
//! Chen et al. 1991   A  L[D]S*E            path tracing
//!                    B  LS+DS*E            photons on the first diffuse surface
//!                    C  L(D|S)*DS*DS*E     radiosity on the second
//! ```
//!
//! Chen's picture has two previews, each replaced by the next, never added to it: all but the lights
//! themselves as radiosity shows it (`chen-preview`), and C so (`chen-direct`).

/// What is to be parted where nobody says.
const ALL: &str = "L(D|S)*E";

/// Name, terms, what they part.
const PRESETS: [(&str, &str, &str); 5] = [
    ("chen", "A=path:L[D]S*E; B=photons@1:LS+DS*E; C=radiosity@2:L(D|S)*DS*DS*E", ALL),
    ("chen-direct", "A=path:L[D]S*E; B=photons@1:LS+DS*E; C=radiosity@1:L(D|S)*DS*DS*E", ALL),
    ("chen-preview", "lights=path:LS*E; radiosity=radiosity@1:L(D|S)*DS*E", ALL),
    (
        "wallace",
        "lights=path:LS_M*E; radiosity=radiosity@1:L([S_M]D)*[S_M]DS_M*E",
        "L([S_M]D)*S_M*E",
    ),
    ("sillion-puech", "lights=path:LS_M*E; radiosity=radiosity@1:L(D|S_M)*DS_M*E", "L(D|S_M)*E"),
];

/// The terms of a preset or those given, and what they part.
///
/// # Errors
/// If there is no preset of the name.
pub(super) fn resolve(terms: &str, of: &str) -> Result<(String, String), String> {
    let or = |of: &str, default: &str| if of.is_empty() { default.into() } else { of.into() };
    if terms.contains(':') {
        return Ok((terms.into(), or(of, ALL)));
    }
    let preset = PRESETS.iter().find(|(name, ..)| *name == terms.trim());
    let (_, terms, parted) = preset.ok_or_else(|| {
        let known: Vec<&str> = PRESETS.iter().map(|(name, ..)| *name).collect();
        format!(
            "`{terms}` is neither a list of terms, such as `path:L[D]S*E; photons@1:LS+DS*E; ...`, \
             nor a preset; known: {}",
            known.join(", ")
        )
    })?;
    Ok((String::from(*terms), or(of, parted)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hybrid::{Hybrid, HybridParams, INFO};

    #[test]
    fn presets_part_what_they_say() {
        for (name, ..) in PRESETS {
            let terms = name.into();
            let params = HybridParams { terms, ..HybridParams::default() };
            Hybrid::new(&INFO, params).map(|_| ()).expect(name);
        }
        assert!(resolve("cheng", "").is_err_and(|e| e.contains("known: chen, chen-direct")));
    }
}
