//! What the photons of a map are found to be worth.
//!
//! ```text
//! X_p = Σ_px Σ_reads βᴱ f Φ_p w / (c π r²) / I_px                                         (1)
//! ```
//!
//! Every estimate that reaches a pixel credits its photons with their parts of it, over the pixel's
//! value: no density of importance has to be estimated, the photons' own reads are it.

use std::sync::atomic::{AtomicU64, Ordering};

/// X of the photons. Whole numbers, whose sums do not depend on the order of threads.
#[derive(Debug)]
pub(super) struct Credits(Vec<AtomicU64>);

/// What 1 is.
const ONE: f32 = (1u64 << 36) as f32;
/// The most that one read may bring.
const MOST: f32 = (1u64 << 10) as f32;

impl Credits {
    /// Nothing yet.
    pub(super) fn new(photons: usize) -> Credits {
        Credits((0..photons).map(|_| AtomicU64::new(0)).collect())
    }

    /// Adds a read's part; what is below 0 or no number counts as nothing.
    #[inline]
    pub(super) fn add(&self, photon: u32, part: f32) {
        let whole = (part.clamp(0.0, MOST) * ONE) as u64;
        self.0[photon as usize].fetch_add(whole, Ordering::Relaxed);
    }

    /// X, in the map's order.
    pub(super) fn iter(&self) -> impl Iterator<Item = f32> {
        self.0.iter().map(|x| x.load(Ordering::Relaxed) as f32 / ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_do_not_depend_on_the_order() {
        let parts = [0.1, 3e-9, 700.0, f32::NAN, -1.0, 1e-7];
        let sum = |order: &[usize]| {
            let credits = Credits::new(2);
            order.iter().for_each(|&i| credits.add(1, parts[i]));
            credits.iter().collect::<Vec<_>>()
        };
        let forth = sum(&[0, 1, 2, 3, 4, 5]);
        assert_eq!(forth, sum(&[5, 2, 4, 1, 3, 0]));
        assert_eq!(forth[0], 0.0);
        assert!((forth[1] - 700.1).abs() < 1e-4, "{}", forth[1]);
    }
}
