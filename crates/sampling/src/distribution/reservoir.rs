//! Choice from a stream of unknown length.

/// One item out of a stream, kept with probability proportional to its weight (weighted
/// reservoir sampling, Chao 1982; Wyman, "Weighted Reservoir Sampling", 2021).
#[derive(Clone, Debug)]
pub struct WeightedReservoir<T> {
    kept: Option<(T, f64)>,
    total: f64,
}

impl<T> Default for WeightedReservoir<T> {
    fn default() -> Self {
        WeightedReservoir { kept: None, total: 0.0 }
    }
}

impl<T> WeightedReservoir<T> {
    /// An empty reservoir.
    pub fn new() -> Self {
        Self::default()
    }

    /// Offers an item; it replaces the kept one with probability weight/total, decided by `u` in
    /// [0, 1). Weights that are not positive and finite are ignored. Returns whether it was
    /// taken.
    pub fn add(&mut self, item: T, weight: f64, u: f32) -> bool {
        if !(weight > 0.0 && weight.is_finite()) {
            return false;
        }
        self.total += weight;
        let taken = f64::from(u) * self.total < weight;
        if taken {
            self.kept = Some((item, weight));
        }
        taken
    }

    /// Joins another reservoir, as if its stream had followed.
    pub fn merge(&mut self, other: Self, u: f32) {
        if other.total > 0.0 {
            self.total += other.total;
            if f64::from(u) * self.total < other.total {
                self.kept = other.kept;
            }
        }
    }

    /// The kept item and the probability that it would be kept; `None` if nothing was offered.
    pub fn sample(&self) -> Option<(&T, f64)> {
        self.kept.as_ref().map(|(item, weight)| (item, weight / self.total))
    }

    /// The sum of the weights offered.
    pub fn total(&self) -> f64 {
        self.total
    }
}
