//! All strategies of bidirectional path tracing, for whoever makes pairs of subpaths: joins every
//! vertex of the one to every vertex of the other, and weighs each joint path against all ways to
//! have made it.

mod pairs;
mod pyramid;
mod weight;

pub use pairs::{Origin, Pairs, Piece};
pub use pyramid::{DEEPEST, Pyramid};
pub use weight::{Joint, Link, strategy_weight};

use crate::roulette::Roulette;
use kaustika_sampling::Heuristic;

/// Which paths are made, and how they are weighted.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Fewest and most bounces of a path.
    pub depths: [u32; 2],
    /// Where subpaths end.
    pub roulette: Roulette,
    /// How strategies are weighted.
    pub mis: Heuristic,
    /// One strategy alone: vertices from the light and from the eye.
    pub strategy: Option<(usize, usize)>,
    /// False: strategies are not weighted.
    pub weighted: bool,
    /// True: lights are not seen directly.
    pub hide_emitters: bool,
}
