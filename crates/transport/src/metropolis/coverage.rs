//! Where chains have been: a chain that mixes comes to other parts than the one it starts in.
//!
//! ```text
//! coverage = Σ p (v - p) / Σ p (e - p),   e = 1 - (1 - p)^(N/30)                        (1)
//! ```
//!
//! p is a part's share of the light, and of the starts, v the share of the chains that were there, N the steps of a chain. e is the share of
//! those that would be there if thirty steps were worth one independent sample; chains that keep to where they start have a coverage
//! of 0. Parts are tiles of the picture, or lengths of paths. Of several generations the mean is taken, for those that make less than 60 steps
//! can come nowhere.

use crate::saved::saved;

/// Steps that are worth an independent sample.
const WORTH: f64 = 30.0;
/// Fewest steps of chains that are expected to come somewhere.
const FEWEST: u64 = 60;

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
    /// How many are over.
    generations: u64,
    /// Steps of a chain in each of those that are told of here.
    steps: Vec<u64>,
    /// Σ over these generations, tile by tile, of the share of chains that were there.
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
            steps: vec![steps],
            tiles: (0..tiles).map(|t| share(seen(t))).collect(),
            lengths: (0..longest).map(of_length).collect(),
        }
    }

    /// Those of a generation that is over. What short ones have visited is not told beside what others have.
    pub fn add(&mut self, o: Visited) {
        let generations = self.generations + o.generations;
        let long = |v: &Visited| v.steps.iter().any(|n| *n >= FEWEST);
        match (long(self), long(&o)) {
            (false, true) => *self = o,
            (true, false) => {}
            (false, false) | (true, true) => self.join(o),
        }
        self.generations = generations;
    }

    fn join(&mut self, o: Visited) {
        self.steps.extend(o.steps);
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
        self.tiles.iter().map(|v| v / self.steps.len() as f64)
    }

    /// Steps with paths of each length, and the share of the chains that made them.
    fn lengths(&self) -> impl Iterator<Item = (f64, f64)> + Clone {
        self.lengths.iter().map(|[steps, v]| (*steps, v / self.steps.len() as f64))
    }

    /// (1) of tiles with this light, and of lengths of paths.
    pub fn coverage(&self, light: &[f64]) -> [Option<f64>; 2] {
        let tiles = light.iter().copied().zip(self.tiles());
        [coverage(tiles, &self.steps), coverage(self.lengths(), &self.steps)]
    }
}

/// (1), from the light and the share of visitors of each part, and the steps of generations; `None` if these are too short, or if all light is
/// in one part.
fn coverage(parts: impl Iterator<Item = (f64, f64)> + Clone, steps: &[u64]) -> Option<f64> {
    let light: f64 = parts.clone().map(|(p, _)| p).sum();
    if light <= 0.0 || steps.iter().any(|n| *n < FEWEST) {
        return None;
    }
    let expected = |p: f64| {
        let of = |n: &u64| 1.0 - (1.0 - p).powf(*n as f64 / WORTH);
        steps.iter().map(of).sum::<f64>() / steps.len() as f64
    };
    let (came, asked) = parts.fold((0.0, 0.0), |(came, asked), (l, v)| {
        let p = l / light;
        (came + p * (v - p), asked + p * (expected(p) - p))
    });
    (asked > 1e-3).then_some(came / asked)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_that_keep_to_their_starts_cover_nothing() {
        let still = [(6.0, 0.6), (3.0, 0.3), (1.0, 0.1)];
        let told = coverage(still.into_iter(), &[300]).expect("a number");
        assert!(told.abs() < 1e-12, "{told}");
        // Of 300 steps, ten samples: each part is met with a probability of 1 - (1 - p)¹⁰.
        let mixed = still.map(|(l, p)| (l, 1.0 - f64::powi(1.0 - p, 10)));
        let told = coverage(mixed.into_iter(), &[300, 300]).expect("a number");
        assert!((told - 1.0).abs() < 1e-12, "{told}");
        assert_eq!(coverage(mixed.into_iter(), &[59]), None);
        assert_eq!(coverage([(1.0, 1.0)].into_iter(), &[300]), None);
    }

    #[test]
    fn short_generations_are_not_told_of_beside_others() {
        let of = |steps, v| Visited {
            generations: 1,
            steps: vec![steps],
            tiles: vec![v],
            lengths: vec![],
        };
        let mut all = Visited::default();
        [(16, 0.1), (16, 0.3)].into_iter().for_each(|(n, v)| all.add(of(n, v)));
        assert_eq!((all.generations(), all.tiles().next()), (2, Some(0.2)));
        [(64, 0.5), (16, 0.1), (64, 0.7)].into_iter().for_each(|(n, v)| all.add(of(n, v)));
        assert_eq!((all.generations(), all.tiles().next()), (5, Some(0.6)));
    }

    #[test]
    fn tiles_that_were_visited_are_known() {
        let mut v = Visits::default();
        v.see(70);
        assert!(v.seen(70) && !v.seen(6) && !v.seen(700));
    }
}
