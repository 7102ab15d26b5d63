//! Spectra tabulated at 1 nm steps: what evaluation at run time reads.

use std::sync::Arc;

use crate::cie::{LAMBDA_MAX, LAMBDA_MIN, NODES, node_lambda, xyz_of_nodes};
use crate::{Spectrum, Wavelengths};

/// A spectrum at 360, 361, ..., 830 nm, linear in between. Cheap to clone.
#[derive(Clone, Debug, PartialEq)]
pub struct DenseSpectrum {
    /// The last value is repeated, so that interpolation may read one past it.
    values: Arc<[f32; NODES + 1]>,
}

impl DenseSpectrum {
    /// Tabulates `f` (of the wavelength in nm).
    pub fn from_fn(f: impl Fn(f32) -> f32) -> DenseSpectrum {
        let values = std::array::from_fn(|i| f(node_lambda(i.min(NODES - 1))));
        DenseSpectrum { values: Arc::new(values) }
    }

    /// Resamples a piecewise linear spectrum, zero outside its wavelengths.
    ///
    /// Each node takes the mean over the 1 nm around it (half a nm at the ends of the range)
    /// rather than the value, so that the integral is kept exactly and lines narrower than 1 nm
    /// are not lost. Segments whose wavelengths do not increase count for nothing.
    pub fn from_samples(lambda: &[f32], values: &[f32]) -> DenseSpectrum {
        let mut sum = [0.0f64; NODES];
        let cell_start = |i: usize| (node_lambda(i) as f64 - 0.5).max(LAMBDA_MIN as f64);
        let cell_end = |i: usize| (node_lambda(i) as f64 + 0.5).min(LAMBDA_MAX as f64);
        let points = || lambda.iter().map(|&l| l as f64).zip(values.iter().map(|&v| v as f64));
        for ((l0, v0), (l1, v1)) in points().zip(points().skip(1)) {
            let (a, b) = (l0.max(LAMBDA_MIN as f64), l1.min(LAMBDA_MAX as f64));
            let at = |l: f64| v0 + (l - l0) / (l1 - l0) * (v1 - v0);
            // False for NaN, too.
            let increasing = l1 > l0 && b > a;
            if !increasing {
                continue;
            }
            let first = (a - LAMBDA_MIN as f64).round() as usize;
            let last = ((b - LAMBDA_MIN as f64).round() as usize).min(NODES - 1);
            for (i, s) in sum.iter_mut().enumerate().take(last + 1).skip(first) {
                let (from, to) = (a.max(cell_start(i)), b.min(cell_end(i)));
                if to > from {
                    *s += (to - from) * 0.5 * (at(from) + at(to));
                }
            }
        }
        DenseSpectrum {
            values: Arc::new(std::array::from_fn(|i| {
                let i = i.min(NODES - 1);
                (sum[i] / (cell_end(i) - cell_start(i))) as f32
            })),
        }
    }

    /// The value at `lambda` nm; beyond 360..=830 nm the value at that end.
    #[inline]
    pub fn at(&self, lambda: f32) -> f32 {
        let x = (lambda - LAMBDA_MIN).clamp(0.0, LAMBDA_MAX - LAMBDA_MIN);
        // Through i32, which the machine converts faster.
        let i = (x as i32 as usize).min(NODES - 1);
        let (a, b) = (self.values[i], self.values[i + 1]);
        a + (x - i as f32) * (b - a)
    }

    /// The values at four wavelengths (of spectral mode).
    #[inline]
    pub fn eval(&self, w: &Wavelengths) -> Spectrum {
        Spectrum(w.lambda.map(|l| self.at(l)))
    }

    /// Value at node `i`, the wavelength 360 + `i` nm.
    #[inline]
    pub(crate) fn node(&self, i: usize) -> f32 {
        self.values[i]
    }

    /// ∫ s (x̄, ȳ, z̄) dλ / ∫ ȳ dλ.
    pub fn xyz(&self) -> [f32; 3] {
        xyz_of_nodes(|i| self.values[i] as f64).map(|v| v as f32)
    }

    /// Largest value.
    pub fn max(&self) -> f32 {
        self.values.iter().copied().fold(f32::MIN, f32::max)
    }

    /// Every value changed by `f`, which is given the wavelength (nm) and the value.
    pub fn map(&self, f: impl Fn(f32, f32) -> f32) -> DenseSpectrum {
        let values = std::array::from_fn(|i| f(node_lambda(i.min(NODES - 1)), self.values[i]));
        DenseSpectrum { values: Arc::new(values) }
    }

    /// The same spectrum scaled to Y = 1; unchanged if it has no luminance.
    pub fn normalized(&self) -> DenseSpectrum {
        let y = self.xyz()[1];
        if y > 0.0 { self.map(|_, v| v / y) } else { self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn piecewise_linear_is_reproduced_between_knots() {
        let (lambda, values) = ([300.0, 500.0, 900.0], [1.0, 3.0, 1.0]);
        let d = DenseSpectrum::from_samples(&lambda, &values);
        for (l, want) in [(360.0, 1.6), (400.5, 2.005), (700.25, 1.99875), (830.0, 1.35)] {
            // At the ends of the range half a cell is shifted by a quarter of a nm.
            assert!((d.at(l) - want).abs() < 3e-3, "{l}: {} {want}", d.at(l));
        }
    }

    #[test]
    fn narrow_lines_keep_their_energy() {
        // A triangle of half width 0.1 nm around 532.3 nm: integral 0.1 · 50.
        let d = DenseSpectrum::from_samples(&[532.2, 532.3, 532.4], &[0.0, 50.0, 0.0]);
        let sum: f64 = (0..NODES).map(|i| d.node(i) as f64).sum();
        assert!((sum - 5.0).abs() < 1e-3, "{sum}");
    }

    #[test]
    fn ends_of_the_range_are_not_halved() {
        let d = DenseSpectrum::from_samples(&[360.0, 830.0], &[2.0, 2.0]);
        assert!((0..NODES).all(|i| (d.node(i) - 2.0).abs() < 1e-6));
    }

    #[test]
    fn zero_outside_the_samples_and_for_broken_ones() {
        let d = DenseSpectrum::from_samples(&[500.0, 600.0], &[1.0, 1.0]);
        assert_eq!((d.at(498.0), d.at(602.0), d.at(550.0)), (0.0, 0.0, 1.0));
        for (l, v) in [
            (&[][..], &[][..]),
            (&[500.0][..], &[1.0][..]),
            (&[600.0, 500.0][..], &[1.0, 1.0][..]),
            (&[f32::NAN, 500.0][..], &[1.0, 1.0][..]),
        ] {
            assert_eq!(DenseSpectrum::from_samples(l, v).max(), 0.0);
        }
    }
}
