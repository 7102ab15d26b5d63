//! Layers that part the picture by its bounces, or by words of D and S.
//!
//! ```text
//! L = e + T e + T² e + …                                          bounces:N               (1)
//! T = D + S,   L = e + De + Se + DDe + DSe + SDe + SSe + …         words:N                 (2)
//! ```
//!
//! (1) is the Neumann series of the rendering equation (Kajiya 1986), (2) the same by the parts of
//! the BSDF. Letters of names go from the light to the eye, as Heckbert writes paths. What has more than
//! N bounces is one layer.

use super::{ExpressionError, PathLayer};

/// Most bounces of (1): with the rest as many layers as there may be.
const MOST_BOUNCES: u32 = 30;
/// Longest words of (2): 1 + 2 + 4 + 8, and the rest.
const MOST_LETTERS: u32 = 3;

/// The layers of `bounces:N` or `words:N`; `None` if the argument is neither.
pub(super) fn series(argument: &str) -> Option<Result<Vec<PathLayer>, ExpressionError>> {
    let (kind, number) = argument.split_once(':')?;
    let most = match kind.trim() {
        "bounces" => MOST_BOUNCES,
        "words" => MOST_LETTERS,
        _ => return None,
    };
    let Some(n) = number.trim().parse().ok().filter(|n| *n <= most) else {
        let message = format!("expected a number from 0 to {most} after `{kind}:`");
        let at = kind.chars().count() + 1;
        return Some(Err(ExpressionError { message, text: argument.into(), at }));
    };
    let all = match kind.trim() {
        "bounces" => bounces(n),
        _ => words(n),
    };
    Some(all.iter().map(|layer| PathLayer::parse(layer)).collect())
}

/// (1)
fn bounces(n: u32) -> Vec<String> {
    let one = |k: u32| format!("bounces{k}=C.{{{k}}}[LOB]");
    (0..=n).map(one).chain([format!("more_bounces=C.{{{},}}[LOB]", n + 1)]).collect()
}

/// (2)
fn words(n: u32) -> Vec<String> {
    let (mut all, mut longest) = (Vec::new(), vec![String::new()]);
    for length in 0..=n {
        all.extend(longest.iter().map(|word| format!("L{word}E=L{word}E")));
        if length < n {
            let longer = |w: &String| [format!("{w}D"), format!("{w}S")];
            longest = longest.iter().flat_map(longer).collect();
        }
    }
    all.push(format!("more_words=L(D|S){{{},}}E", n + 1));
    all
}
