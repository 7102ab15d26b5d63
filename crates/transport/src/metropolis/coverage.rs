//! Where chains have been: a chain that mixes visits every part where a good share of the light is.
//!
//! ```text
//! coverage = Σ p v / Σ p      over parts with p N ≥ 100                                 (1)
//! ```
//!
//! p is a part's share of the light, N the steps of a chain, v the share of the chains that were there. Chains
//! whose steps are worth a thirtieth of independent samples miss such a part with a probability of at most e⁻³. Parts are tiles of the
//! picture, or lengths of paths. Of several generations the mean is taken: chains that start afresh come to other parts
//! without moving there.

use crate::saved::saved;

/// Fewest visits expected.
const EXPECTED: f64 = 100.0;

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

/// What generations of chains have visited.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Visited {
    /// How many.
    generations: u64,
    /// Steps of a chain in each.
    pub steps: u64,
    /// Σ over generations, tile by tile, of the share of chains that were there.
    tiles: Vec<f64>,
    /// Σ of the steps with paths of each length, and of the share of chains that made them.
    lengths: Vec<[f64; 2]>,
}
saved!(Visited { generations, steps, tiles, lengths });

impl Visited {
    /// What these chains have visited in so many steps, of so many tiles.
    pub fn of<W: Visitor>(walks: &[W], steps: u64, tiles: usize) -> Visited {
        let share = |count: usize| count as f64 / walks.len().max(1) as f64;
        let seen = |t: usize| walks.iter().filter(|w| w.visits().seen(t)).count();
        let longest = walks.iter().map(|w| w.visits().lengths.len()).max().unwrap_or(0);
        let of_length = |n: usize| {
            let at = |w: &W| w.visits().lengths.get(n).copied().unwrap_or(0);
            let steps: u64 = walks.iter().map(at).sum();
            [steps as f64, share(walks.iter().filter(|w| at(w) > 0).count())]
        };
        Visited {
            generations: 1,
            steps,
            tiles: (0..tiles).map(|t| share(seen(t))).collect(),
            lengths: (0..longest).map(of_length).collect(),
        }
    }

    /// Those of a generation that is over.
    pub fn add(&mut self, o: Visited) {
        self.generations += o.generations;
        self.steps = o.steps;
        self.tiles.resize(o.tiles.len(), 0.0);
        self.tiles.iter_mut().zip(&o.tiles).for_each(|(a, b)| *a += b);
        self.lengths.resize(self.lengths.len().max(o.lengths.len()), [0.0; 2]);
        for (a, b) in self.lengths.iter_mut().zip(&o.lengths) {
            *a = [a[0] + b[0], a[1] + b[1]];
        }
    }

    /// How many generations are over.
    pub fn generations(&self) -> u64 {
        self.generations
    }

    /// Share of the chains that were in each tile.
    pub fn tiles(&self) -> impl Iterator<Item = f64> + Clone {
        self.tiles.iter().map(|v| v / self.generations as f64)
    }

    /// Steps with paths of each length, and the share of the chains that made them.
    pub fn lengths(&self) -> impl Iterator<Item = (f64, f64)> + Clone {
        self.lengths.iter().map(|[steps, v]| (*steps, v / self.generations as f64))
    }
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
        // The last part has a tenth of the light: 90 visits of 900 steps are not enough to ask for.
        assert_eq!(coverage(parts.into_iter(), 900), Some((6.0 + 1.5) / 9.0));
        assert_eq!(coverage(parts.into_iter(), 1000), Some((6.0 + 1.5) / 10.0));
        assert_eq!(coverage(parts.into_iter(), 100), None);
        let mut v = Visits::default();
        v.see(70);
        assert!(v.seen(70) && !v.seen(6) && !v.seen(700));
    }
}
