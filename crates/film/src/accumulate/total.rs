//! The sum of some passes, and what it says of each pixel.

use super::Layers;

/// The sum of some passes.
#[derive(Clone, Debug)]
pub struct Total {
    /// How many.
    pub passes: u64,
    /// Sum of their weights.
    pub(super) weight: f32,
    /// Sums of the numbers of each pixel.
    pub(super) sum: Vec<f32>,
    /// M2 of the tree's (1), three numbers a pixel.
    pub(super) m2: Vec<f32>,
    pub(super) layers: Layers,
}

impl Total {
    /// Mean colour of pixel `i`: Σ w x / Σ w.
    #[inline]
    pub fn rgb(&self, i: usize) -> [f32; 3] {
        let at = i * self.layers.stride();
        let inv = 1.0 / self.weight(i);
        std::array::from_fn(|c| self.sum[at + c] * inv)
    }

    /// Mean of the numbers at `offset` of pixel `i`.
    #[inline]
    pub fn value(&self, i: usize, offset: usize) -> f32 {
        self.sum[i * self.layers.stride() + offset] / self.weight(i)
    }

    /// The number at `offset` of pixel `i` that names something.
    #[inline]
    pub fn id(&self, i: usize, offset: usize) -> f32 {
        self.sum[i * self.layers.stride() + offset]
    }

    /// Variance of one pass's colour at pixel `i`, or of one of the passes' mean weight; zero for
    /// fewer than two passes.
    #[inline]
    pub fn variance(&self, i: usize) -> [f32; 3] {
        let n = self.passes.max(2) as f32;
        let mean_weight = self.weight / self.passes as f32;
        std::array::from_fn(|c| self.m2[3 * i + c] / ((n - 1.0) * mean_weight))
    }

    /// Σ of the filter weights, or of the passes' weights where nothing carries one.
    #[inline]
    fn weight(&self, i: usize) -> f32 {
        let w = self.sum[i * self.layers.stride() + 3];
        if w == 0.0 { self.weight } else { w }
    }
}
