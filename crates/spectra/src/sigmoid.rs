//! Smooth reflectance spectra of three coefficients.

use crate::{Spectrum, Wavelengths};

/// A reflectance as the sigmoid of a quadratic (Jakob and Hanika 2019, "A Low-Dimensional
/// Function Space for Efficient Spectral Upsampling", eqs. 3 and 4):
///
/// ```text
/// S(λ) = 1/2 + x / (2 √(1 + x²)),   x = c₀ t² + c₁ t + c₂,   t = (λ - 595 nm) / 235 nm
/// ```
///
/// Always in [0, 1]. Here t covers [-1, 1] over the visible range, which conditions fits better
/// than the paper's wavelengths in nm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SigmoidPolynomial {
    /// c₀, c₁, c₂.
    pub c: [f32; 3],
}

impl SigmoidPolynomial {
    /// The flat spectrum of value `v`, clamped to [0, 1]; 0 and 1 come out exactly.
    pub fn constant(v: f32) -> SigmoidPolynomial {
        // The square of the largest coefficient must stay finite.
        const LIMIT: f32 = 1e9;
        let v = v.clamp(0.0, 1.0);
        let x = ((v - 0.5) / (v * (1.0 - v)).sqrt()).clamp(-LIMIT, LIMIT);
        SigmoidPolynomial { c: [0.0, 0.0, x] }
    }

    /// The value at `lambda` nm.
    #[inline]
    pub fn at(&self, lambda: f32) -> f32 {
        let t = sigmoid_t(lambda);
        let x = (self.c[0] * t + self.c[1]) * t + self.c[2];
        0.5 + 0.5 * x / (1.0 + x * x).sqrt()
    }

    /// The values at four wavelengths (of spectral mode).
    #[inline]
    pub fn eval(&self, w: &Wavelengths) -> Spectrum {
        Spectrum(w.lambda.map(|l| self.at(l)))
    }
}

/// The polynomial's variable, -1..=1 over 360..=830 nm.
#[inline]
pub(crate) fn sigmoid_t(lambda: f32) -> f32 {
    (lambda - 595.0) * (1.0 / 235.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants() {
        for v in [0.0, 1e-4, 0.18, 0.5, 0.9, 1.0] {
            let s = SigmoidPolynomial::constant(v);
            assert!((s.at(400.0) - v).abs() < 1e-6 && s.at(400.0) == s.at(700.0), "{v}");
        }
        assert_eq!(SigmoidPolynomial::constant(0.0).at(500.0), 0.0);
        assert_eq!(SigmoidPolynomial::constant(1.0).at(500.0), 1.0);
        assert_eq!(SigmoidPolynomial::constant(7.0).at(500.0), 1.0);
    }
}
