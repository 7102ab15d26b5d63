//! What clusters send and receive by direction, in nine spherical harmonics.
//!
//! ```text
//! max(n·w, 0) ≈ Σ_lm Â_l Y_lm(n) Y_lm(w),   Â = π, 2π/3, π/4                         (1)
//! ```
//!
//! (Ramamoorthi & Hanrahan 2001, eq. 8.) With (1) both a cluster's intensity, a sum of cosine lobes
//! around the normals of its elements, and the irradiance of its elements by normal are nine numbers.

use kaustika_math::Vec3;
use kaustika_spectra::Spectrum;
use std::f32::consts::PI;

/// Â of each of the nine.
const LOBE: [f32; 9] = {
    let (a, b, c) = (PI, 2.0 * PI / 3.0, PI / 4.0);
    [a, b, b, b, c, c, c, c, c]
};

/// Y_lm in the direction `w`, unit.
pub fn basis(w: Vec3) -> [f32; 9] {
    let Vec3 { x, y, z } = w;
    [
        0.282_094_8,
        0.488_602_5 * y,
        0.488_602_5 * z,
        0.488_602_5 * x,
        1.092_548_4 * x * y,
        1.092_548_4 * y * z,
        0.315_391_57 * (3.0 * z * z - 1.0),
        1.092_548_4 * x * z,
        0.546_274_2 * (x * x - y * y),
    ]
}

/// A function of direction.
#[derive(Clone, Copy, Debug)]
pub struct Lobes9([Spectrum; 9]);

impl Default for Lobes9 {
    fn default() -> Lobes9 {
        Lobes9([Spectrum::ZERO; 9])
    }
}

impl Lobes9 {
    /// Adds `k` in the direction `w` alone.
    pub fn add_direction(&mut self, w: Vec3, k: Spectrum) {
        self.0.iter_mut().zip(basis(w)).for_each(|(sum, y)| *sum += k * y);
    }

    /// (1): adds `k` times the cosine lobe around `n`.
    pub fn add_lobe(&mut self, n: Vec3, k: Spectrum) {
        let terms = basis(n).into_iter().zip(LOBE);
        self.0.iter_mut().zip(terms).for_each(|(sum, (y, a))| *sum += k * (y * a));
    }

    /// Adds another function.
    pub fn add(&mut self, other: &Lobes9) {
        self.0.iter_mut().zip(other.0).for_each(|(sum, k)| *sum += k);
    }

    /// The value in the direction `w`.
    pub fn value(&self, w: Vec3) -> Spectrum {
        let terms = self.0.iter().zip(basis(w));
        terms.fold(Spectrum::ZERO, |sum, (k, y)| sum + *k * y).clamp_zero()
    }

    /// The most that a sum of cosine lobes can be in any direction: were they all around one normal.
    pub fn most(&self) -> Spectrum {
        self.0[0] * (1.0 / (PI * 0.282_094_8))
    }

    /// (1): its integral against the cosine lobe around `n`.
    pub fn over_lobe(&self, n: Vec3) -> Spectrum {
        let terms = self.0.iter().zip(basis(n)).zip(LOBE);
        terms.fold(Spectrum::ZERO, |sum, ((k, y), a)| sum + *k * (y * a)).clamp_zero()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (1) is off by at most 0.13 of the lobe's height, and right on average.
    #[test]
    fn lobes_are_cosines() {
        let n = Vec3::new(0.3, -0.5, 0.8).normalize();
        let mut lobe = Lobes9::default();
        lobe.add_lobe(n, Spectrum::ONE);
        let (mut sum, count) = (0.0, 4096u32);
        for i in 0..count {
            let w = kaustika_math::warp::uniform_sphere(crate::radiosity::points::r2(i));
            let (found, truth) = (lobe.value(w).0[0], n.dot(w).max(0.0));
            assert!((found - truth).abs() < 0.13, "{w:?}: {found} {truth}");
            sum += (found - truth) / count as f32;
            let mut from = Lobes9::default();
            from.add_direction(w, Spectrum::ONE);
            assert!((from.over_lobe(n).0[0] - found).abs() < 1e-5);
        }
        assert!(sum.abs() < 0.01, "{sum}");
    }
}
