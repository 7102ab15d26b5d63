//! Spectra as scene files say them.

use std::fmt;
use std::sync::Arc;

use crate::named::NamedSpectrum;
use crate::{ColorSpace, DenseSpectrum, blackbody, illuminant, wien_peak};

/// A colour or spectrum as a file gives it, before anyone knows whether the render is spectral.
///
/// Units are those of the quantity described; wavelengths are in nm.
#[derive(Clone, Debug, PartialEq)]
pub enum SpectrumDesc {
    /// The same value at every wavelength; in RGB mode (c, c, c) whatever it describes, also
    /// where that is not what the equal-energy spectrum looks like.
    Constant(f32),
    /// The same value at every wavelength, and honest about it: as an illuminant in RGB mode it
    /// is the slightly pink colour of the equal-energy spectrum, as Mitsuba's `<spectrum
    /// value="...">` in an emitter; elsewhere as `Constant`.
    EqualEnergy(f32),
    /// D65 of luminance `scale`: in RGB mode (scale, scale, scale). What Mitsuba makes of a
    /// number in an emitter.
    D65 {
        /// Luminance Y.
        scale: f32,
    },
    /// Linear RGB.
    Rgb {
        /// Components; a colour of a surface lies in [0, 1].
        rgb: [f32; 3],
        /// Whose primaries.
        space: ColorSpace,
    },
    /// Piecewise linear, zero outside; made by [`SpectrumDesc::sampled`].
    Sampled {
        /// Wavelengths, increasing.
        lambda: Arc<[f32]>,
        /// Values at them.
        values: Arc<[f32]>,
    },
    /// A black body's radiance in W/(m² sr nm), or, normalised, with a maximum of 1.
    Blackbody {
        /// Temperature.
        kelvin: f32,
        /// True for a maximum (over all wavelengths, also invisible ones) of 1.
        normalized: bool,
    },
    /// The index of refraction of a glass by Sellmeier's equation (1871),
    /// n² = 1 + Σ bᵢ λ² / (λ² - cᵢ) with λ in µm.
    Sellmeier {
        /// Strengths of the three resonances.
        b: [f32; 3],
        /// Squared wavelengths of the resonances, µm².
        c: [f32; 3],
    },
    /// One of the spectra we have by name.
    Named(&'static NamedSpectrum),
}

impl SpectrumDesc {
    /// A piecewise linear spectrum.
    ///
    /// # Errors
    /// If the lists differ in length or are empty, a number is NaN or infinite, or wavelengths
    /// are negative or do not increase.
    pub fn sampled(lambda: &[f32], values: &[f32]) -> Result<SpectrumDesc, SampledError> {
        if lambda.len() != values.len() {
            return Err(SampledError::Lengths(lambda.len(), values.len()));
        }
        if lambda.is_empty() {
            return Err(SampledError::Empty);
        }
        for (i, (&l, &v)) in lambda.iter().zip(values).enumerate() {
            if !l.is_finite() || !v.is_finite() {
                return Err(SampledError::NotFinite(i));
            }
            if l < 0.0 {
                return Err(SampledError::Negative(i));
            }
            if i > 0 && l <= lambda[i - 1] {
                return Err(SampledError::NotIncreasing(i));
            }
        }
        Ok(SpectrumDesc::Sampled { lambda: lambda.into(), values: values.into() })
    }

    /// The value at `lambda` nm: for scalar indices of refraction, for printing. `None` for RGB,
    /// whose spectrum depends on its role. D65 is normalised to Y = `scale`.
    pub fn value_at(&self, lambda: f32) -> Option<f32> {
        Some(match self {
            SpectrumDesc::Constant(c) | SpectrumDesc::EqualEnergy(c) => *c,
            SpectrumDesc::D65 { scale } => scale * illuminant::d65().at(lambda),
            SpectrumDesc::Rgb { .. } => return None,
            SpectrumDesc::Sampled { lambda: l, values } => piecewise_linear(l, values, lambda),
            SpectrumDesc::Blackbody { kelvin, normalized: false } => blackbody(lambda, *kelvin),
            SpectrumDesc::Blackbody { kelvin, normalized: true } => {
                let peak = blackbody(wien_peak(*kelvin), *kelvin);
                if peak > 0.0 { blackbody(lambda, *kelvin) / peak } else { 0.0 }
            }
            SpectrumDesc::Sellmeier { b, c } => sellmeier(b, c, lambda),
            SpectrumDesc::Named(named) => named.desc().value_at(lambda)?,
        })
    }

    /// The spectrum at 1 nm steps; an RGB colour (which has none before its role is known) gives
    /// zero.
    pub(crate) fn dense(&self) -> DenseSpectrum {
        match self {
            SpectrumDesc::Sampled { lambda, values } => DenseSpectrum::from_samples(lambda, values),
            SpectrumDesc::Named(named) => named.desc().dense(),
            _ => DenseSpectrum::from_fn(|l| self.value_at(l).unwrap_or(0.0)),
        }
    }
}

/// Sellmeier's equation; 1 where it has no real solution.
fn sellmeier(b: &[f32; 3], c: &[f32; 3], lambda_nm: f32) -> f32 {
    let l2 = (lambda_nm as f64 * 1e-3).powi(2);
    let n2 = 1.0 + (0..3).map(|i| b[i] as f64 * l2 / (l2 - c[i] as f64)).sum::<f64>();
    if n2.is_finite() && n2 > 0.0 { n2.sqrt() as f32 } else { 1.0 }
}

/// The piecewise linear function through the points, zero outside.
fn piecewise_linear(lambda: &[f32], values: &[f32], x: f32) -> f32 {
    let n = lambda.len().min(values.len());
    // First point beyond x.
    let i = lambda[..n].partition_point(|&l| l <= x);
    match i {
        0 => 0.0,
        i if i == n => {
            if lambda[n - 1] == x {
                values[n - 1]
            } else {
                0.0
            }
        }
        i => {
            let t = (x - lambda[i - 1]) / (lambda[i] - lambda[i - 1]);
            values[i - 1] + t * (values[i] - values[i - 1])
        }
    }
}

/// Why a list of samples is not a spectrum. Positions count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SampledError {
    /// This many wavelengths, that many values.
    Lengths(usize, usize),
    /// No samples at all.
    Empty,
    /// The sample has a NaN or infinity.
    NotFinite(usize),
    /// The sample's wavelength is negative.
    Negative(usize),
    /// The sample's wavelength is not greater than the one before.
    NotIncreasing(usize),
}

impl fmt::Display for SampledError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SampledError::Lengths(l, v) => write!(f, "{l} wavelengths but {v} values"),
            SampledError::Empty => write!(f, "a spectrum needs at least one sample"),
            SampledError::NotFinite(i) => write!(f, "sample {i} is not a finite number"),
            SampledError::Negative(i) => write!(f, "wavelength of sample {i} is negative"),
            SampledError::NotIncreasing(i) => {
                write!(f, "wavelength of sample {i} is not greater than the one before")
            }
        }
    }
}

impl std::error::Error for SampledError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_by_wavelength() {
        let s = SpectrumDesc::sampled(&[400.0, 500.0, 700.0], &[1.0, 2.0, 0.0]).expect("valid");
        for (l, want) in [(399.0, 0.0), (400.0, 1.0), (450.0, 1.5), (600.0, 1.0), (701.0, 0.0)] {
            assert_eq!(s.value_at(l), Some(want));
        }
        let b = SpectrumDesc::Blackbody { kelvin: 5000.0, normalized: true };
        assert!((b.value_at(wien_peak(5000.0)).expect("has values") - 1.0).abs() < 1e-6);
        let cold = SpectrumDesc::Blackbody { kelvin: 0.0, normalized: true };
        assert_eq!(cold.value_at(500.0), Some(0.0));
        let rgb = SpectrumDesc::Rgb { rgb: [1.0; 3], space: ColorSpace::Srgb };
        assert_eq!(rgb.value_at(500.0), None);
    }

    #[test]
    fn refused_samples() {
        let err = |l: &[f32], v: &[f32]| SpectrumDesc::sampled(l, v).expect_err("must be refused");
        assert_eq!(err(&[1.0], &[]), SampledError::Lengths(1, 0));
        assert_eq!(err(&[], &[]), SampledError::Empty);
        assert_eq!(err(&[1.0, 1.0], &[0.0, 0.0]), SampledError::NotIncreasing(1));
        assert_eq!(err(&[-1.0], &[0.0]), SampledError::Negative(0));
        assert_eq!(err(&[1.0], &[f32::NAN]), SampledError::NotFinite(0));
    }
}
