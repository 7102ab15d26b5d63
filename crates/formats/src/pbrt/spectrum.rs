//! Spectra as pbrt names and scales them.

use kaustika_spectra::{SpectrumDesc, cie, parse_spd, photometric_integral};

/// The spectrum of wavelength and value pairs.
///
/// # Errors
/// A one-line cause.
pub(super) fn from_pairs(pairs: &[f32]) -> Result<SpectrumDesc, String> {
    if !pairs.len().is_multiple_of(2) {
        return Err(format!(
            "a spectrum is pairs of wavelength and value, {} numbers given",
            pairs.len()
        ));
    }
    let lambda: Vec<f32> = pairs.iter().step_by(2).copied().collect();
    let values: Vec<f32> = pairs.iter().skip(1).step_by(2).copied().collect();
    SpectrumDesc::sampled(&lambda, &values).map_err(|e| format!("not a spectrum: {e}"))
}

/// The spectrum in the text of an `.spd` file.
///
/// # Errors
/// A one-line cause.
pub(super) fn from_spd(text: &str) -> Result<SpectrumDesc, String> {
    parse_spd(text).map_err(|e| e.to_string())
}

/// The factor that pbrt puts on a light's spectrum: one over its luminance, so that `scale` is in
/// photometric units (pbrt-v4, lights.cpp: division by SpectrumToPhotometric; its sensor does not
/// divide by ∫ ȳ dλ, ours does). An RGB light is such already: its colour times an illuminant of
/// unit luminance. A spectrum without luminance keeps its values.
pub(super) fn unit_luminance(spectrum: &SpectrumDesc) -> f32 {
    if matches!(spectrum, SpectrumDesc::Rgb { .. }) {
        return 1.0;
    }
    let integral = photometric_integral(spectrum);
    if integral > 0.0 && integral.is_finite() { cie::Y_INTEGRAL / integral } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_light_of_two_is_scaled_to_one() {
        let flat = from_pairs(&[300.0, 2.0, 900.0, 2.0]).unwrap();
        assert!((unit_luminance(&flat) - 0.5).abs() < 1e-4, "{}", unit_luminance(&flat));
        let black = from_pairs(&[300.0, 0.0, 900.0, 0.0]).unwrap();
        assert_eq!(unit_luminance(&black), 1.0);
        let rgb = SpectrumDesc::Rgb { rgb: [3.0, 2.0, 1.0], space: Default::default() };
        assert_eq!(unit_luminance(&rgb), 1.0);
    }

    #[test]
    fn broken_spectra_say_why() {
        assert_eq!(
            from_pairs(&[400.0, 1.0, 500.0]).unwrap_err(),
            "a spectrum is pairs of wavelength and value, 3 numbers given"
        );
        assert!(from_pairs(&[500.0, 1.0, 400.0, 1.0]).unwrap_err().starts_with("not a spectrum"));
        assert!(from_spd("400 1\nx").is_err());
    }
}
