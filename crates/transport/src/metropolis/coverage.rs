//! Where chains have been: a chain that mixes visits every part where a good share of the light is.
//!
//! ```text
//! coverage = Σ p v / Σ p      over parts with p N ≥ 3                                   (1)
//! ```
//!
//! p is a part's share of the light, N the steps of a chain, v the share of the chains that were there. N
//! independent samples would miss such a part with a probability of at most e⁻³. Parts are tiles of the
//! picture, or lengths of paths.

use crate::saved::saved;

/// Fewest visits expected.
const EXPECTED: f64 = 3.0;

/// Where a chain has been.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Visits {
    /// A bit for each tile.
    tiles: Vec<u64>,
    /// Steps by the number of bounces; empty where chains keep to one.
    pub lengths: Vec<u64>,
}
saved!(Visits { tiles, lengths });

impl Visits {
    /// A state that shows in this tile.
    pub fn see(&mut self, tile: usize) {
        if self.tiles.len() <= tile / 64 {
            self.tiles.resize(tile / 64 + 1, 0);
        }
        self.tiles[tile / 64] |= 1 << (tile % 64);
    }

    /// True if it was there.
    pub fn seen(&self, tile: usize) -> bool {
        self.tiles.get(tile / 64).is_some_and(|bits| bits >> (tile % 64) & 1 == 1)
    }

    /// A step with a path of so many bounces.
    pub fn count(&mut self, bounces: usize) {
        if self.lengths.len() <= bounces {
            self.lengths.resize(bounces + 1, 0);
        }
        self.lengths[bounces] += 1;
    }
}

/// Something that keeps [`Visits`].
pub trait Visitor {
    /// Where it has been.
    fn visits(&self) -> &Visits;
}

/// (1), from the light and the share of visitors of each part; `None` if no part has light enough.
pub fn coverage(parts: impl Iterator<Item = (f64, f64)> + Clone, steps: u64) -> Option<f64> {
    let light: f64 = parts.clone().map(|(p, _)| p).sum();
    let bright = parts.filter(|(p, _)| p / light * steps as f64 >= EXPECTED);
    let (sum, all) = bright.fold((0.0, 0.0), |(sum, all), (p, v)| (sum + p * v, all + p));
    (all > 0.0).then_some(sum / all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coverage_is_of_the_light() {
        let parts = [(6.0, 1.0), (3.0, 0.5), (1.0, 0.0)];
        // The last part has a tenth of the light: 2 visits of 20 steps are not enough to ask for.
        assert_eq!(coverage(parts.into_iter(), 20), Some((6.0 + 1.5) / 9.0));
        assert_eq!(coverage(parts.into_iter(), 30), Some((6.0 + 1.5) / 10.0));
        assert_eq!(coverage(parts.into_iter(), 1), None);
        let mut v = Visits::default();
        v.see(70);
        assert!(v.seen(70) && !v.seen(6) && !v.seen(700));
    }
}
