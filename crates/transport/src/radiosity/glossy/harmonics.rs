//! Real spherical harmonics up to a band.
//!
//! ```text
//! Y_lm = K_lm √2 cos(mφ) P_lm(z),   Y_l0 = K_l0 P_l0(z),   Y_l-m = K_lm √2 sin(mφ) P_lm(z)     (1)
//! K_lm = √((2l+1)/4π (l-m)!/(l+m)!)
//! P_mm = (2m-1)!! (sin θ)^m,   (l-m) P_lm = (2l-1) z P_l-1,m - (l+m-1) P_l-2,m                  (2)
//! ```
//!
//! Orthonormal over the sphere. (2) are Legendre's associated functions without the sign (-1)^m; powers of
//! sin θ go with cos mφ and sin mφ, so that nothing is divided by it (Sloan 2013).

use kaustika_math::Vec3;
use kaustika_spectra::Spectrum;

/// Harmonics of bands 0 to `bands` - 1.
#[derive(Clone, Debug)]
pub struct Harmonics {
    bands: usize,
    /// K_lm √2, or K_l0, at l(l+1)/2 + m.
    factors: Vec<f32>,
}

impl Harmonics {
    /// Of so many bands.
    pub fn new(bands: u32) -> Harmonics {
        let bands = bands as usize;
        let mut factors = Vec::new();
        for l in 0..bands {
            for m in 0..=l {
                // (l-m)!/(l+m)!
                let ratio: f64 = (l - m + 1..=l + m).map(|k| 1.0 / k as f64).product();
                let k = ((2 * l + 1) as f64 / (4.0 * std::f64::consts::PI) * ratio).sqrt();
                factors.push((k * if m > 0 { 2f64.sqrt() } else { 1.0 }) as f32);
            }
        }
        Harmonics { bands, factors }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.bands * self.bands
    }

    /// (1) in the direction `w`, unit: `f` is told the place l² + l + m and the value of each.
    fn each(&self, w: Vec3, mut f: impl FnMut(usize, f32)) {
        // sinᵐθ cos mφ and sinᵐθ sin mφ, and P_mm without its sines.
        let (mut cos, mut sin, mut diagonal) = (1.0f32, 0.0f32, 1.0f32);
        for m in 0..self.bands {
            let (mut before, mut p) = (0.0, diagonal);
            for l in m..self.bands {
                if l > m {
                    let (l, m) = (l as f32, m as f32);
                    let next = ((2.0 * l - 1.0) * w.z * p - (l + m - 1.0) * before) / (l - m); // (2)
                    (before, p) = (p, next);
                }
                let value = self.factors[l * (l + 1) / 2 + m] * p;
                f(l * l + l + m, value * cos);
                if m > 0 {
                    f(l * l + l - m, value * sin);
                }
            }
            (cos, sin) = (w.x * cos - w.y * sin, w.x * sin + w.y * cos);
            diagonal *= (2 * m + 1) as f32;
        }
    }

    /// Σ c Y.
    pub fn value(&self, c: &[Spectrum], w: Vec3) -> Spectrum {
        let mut sum = Spectrum::ZERO;
        self.each(w, |k, y| sum += c[k] * y);
        sum
    }

    /// Adds `light` in the direction `w` alone.
    pub fn add(&self, c: &mut [Spectrum], w: Vec3, light: Spectrum) {
        self.each(w, |k, y| c[k] += light * y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::{Vec2, warp};

    /// ∫ Y_a Y_b = δ_ab, by a grid of the sphere: exact in φ, and in z within h²/24 of the difference of
    /// slopes at the poles, 3·10⁻⁴ of the steepest.
    #[test]
    fn they_are_orthonormal() {
        let harmonics = Harmonics::new(6);
        let n = harmonics.count();
        let mut products = vec![0.0f64; n * n];
        let (rows, columns) = (512u32, 16u32);
        for i in 0..rows * columns {
            let u = Vec2::new(
                (i % rows) as f32 / rows as f32 + 0.5 / rows as f32,
                (i / rows) as f32 / columns as f32 + 0.5 / columns as f32,
            );
            let w = warp::uniform_sphere(u);
            let mut y = vec![0.0; n];
            harmonics.each(w, |k, v| y[k] = v);
            for a in 0..n {
                for b in 0..n {
                    products[a * n + b] += f64::from(y[a] * y[b] * 4.0 * std::f32::consts::PI)
                        / f64::from(rows * columns);
                }
            }
        }
        for a in 0..n {
            for b in 0..n {
                let truth = f64::from(u8::from(a == b));
                assert!(
                    (products[a * n + b] - truth).abs() < 2e-3,
                    "{a} {b}: {}",
                    products[a * n + b]
                );
            }
        }
    }
}
