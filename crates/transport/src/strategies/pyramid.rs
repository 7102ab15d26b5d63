//! Veach's pyramid (1997, fig. 10.2): a picture of every strategy, as it is and weighted.

/// Bounces of the longest paths that a pyramid may show.
pub const DEEPEST: usize = 10;

/// The layers of a pyramid.
#[derive(Clone, Debug)]
pub struct Pyramid {
    bounces: usize,
    /// Number of its first layer among those by path.
    first: usize,
    /// What each got of the last sample, linear RGB.
    found: Vec<[f32; 3]>,
}

impl Pyramid {
    /// Of paths of up to so many bounces, after `first` other layers.
    pub fn new(bounces: usize, first: usize) -> Pyramid {
        Pyramid { bounces, first, found: vec![[0.0; 3]; 2 * strategies(bounces)] }
    }

    /// Names of its layers: `weighted.sStT`, then `unweighted.sStT`, by length of path, then s.
    pub fn names(bounces: usize) -> Vec<String> {
        let name = |kind| {
            (0..=bounces).flat_map(move |depth| {
                (0..depth + 3).map(move |s| format!("{kind}.s{s}t{}", depth + 2 - s))
            })
        };
        name("weighted").chain(name("unweighted")).collect()
    }

    /// The layers of a strategy: weighted and not.
    fn layers(&self, s: usize, t: usize) -> Option<[usize; 2]> {
        let depth = s + t - 2;
        let at = |depth| if depth == 0 { 0 } else { strategies(depth - 1) } + s;
        (depth <= self.bounces).then(|| [at(depth), at(depth) + strategies(self.bounces)])
    }

    /// The same, numbered among the picture's layers by path.
    pub fn numbers(&self, s: usize, t: usize) -> Option<[usize; 2]> {
        self.layers(s, t).map(|layers| layers.map(|l| l + self.first))
    }

    /// Begins a sample.
    pub fn clear(&mut self) {
        self.found.fill([0.0; 3]);
    }

    /// Adds what a strategy found, weighted and not.
    pub fn add(&mut self, s: usize, t: usize, rgb: [[f32; 3]; 2]) {
        let Some(layers) = self.layers(s, t) else { return };
        for (layer, rgb) in layers.into_iter().zip(rgb) {
            self.found[layer].iter_mut().zip(rgb).for_each(|(sum, v)| *sum += v);
        }
    }

    /// What the layers got since [`Pyramid::clear`].
    pub fn found(&self) -> &[[f32; 3]] {
        &self.found
    }
}

/// Strategies of paths of up to so many bounces.
fn strategies(bounces: usize) -> usize {
    (0..=bounces).map(|depth| depth + 3).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_strategy_has_layers_of_its_own() {
        for bounces in [0, 1, 5] {
            let pyramid = Pyramid::new(bounces, 0);
            let names = Pyramid::names(bounces);
            assert_eq!(names.len(), pyramid.found.len());
            let mut seen = vec![false; names.len()];
            for s in 0..bounces + 3 {
                for t in 0..bounces + 3 {
                    let Some(layers) = (s + t >= 2).then(|| pyramid.layers(s, t)).flatten() else {
                        assert!(s + t < 2 || s + t > bounces + 2);
                        continue;
                    };
                    for (l, kind) in layers.into_iter().zip(["weighted", "unweighted"]) {
                        assert_eq!(names[l], format!("{kind}.s{s}t{t}"));
                        assert!(!std::mem::replace(&mut seen[l], true));
                    }
                }
            }
            assert!(seen.iter().all(|s| *s));
        }
    }
}
