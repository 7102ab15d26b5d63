//! Tristimulus values and luminance of what scene files describe.

use crate::compiled::SpectrumRole;
use crate::rgb_fit::Fitter;
use crate::{ColorMode, DenseSpectrum, Spectrum, SpectrumDesc, Wavelengths, cie, illuminant};

/// Luminance weights of linear sRGB (Rec. ITU-R BT.709).
const REC709: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// The tristimulus values (Y of a flat spectrum of 1 is 1) that RGB mode projects a description
/// to: of an illuminant itself, of anything else as lit by D65. The n and k of Mitsuba's
/// conductor presets ([`conductor`](crate::conductor)) are never lit.
pub fn xyz_of(desc: &SpectrumDesc, role: SpectrumRole) -> [f32; 3] {
    let lit = match desc {
        SpectrumDesc::Rgb { rgb, space } => return space.to_xyz().apply(*rgb),
        SpectrumDesc::Named(named) if named.equal_energy_projection() => false,
        _ => role != SpectrumRole::Illuminant,
    };
    let dense = desc.dense();
    if lit {
        let light = illuminant::d65();
        dense.map(|l, v| v * light.at(l)).xyz()
    } else {
        dense.xyz()
    }
}

/// Luminance Y of a description, 1 for a flat spectrum of 1: the Y of [`xyz_of`].
pub fn luminance_of(desc: &SpectrumDesc, role: SpectrumRole) -> f32 {
    match desc {
        SpectrumDesc::Constant(c) | SpectrumDesc::EqualEnergy(c) => *c,
        _ => xyz_of(desc, role)[1],
    }
}

/// ∫ s ȳ dλ in nm, pbrt-v4's SpectrumToPhotometric: an RGB colour counts as the illuminant of its
/// space, whatever its components.
///
/// pbrt divides the spectra of its lights by this, and its sensor does not divide by ∫ ȳ dλ; ours
/// does, so the same pictures come from scaling by `cie::Y_INTEGRAL / photometric_integral(desc)`.
pub fn photometric_integral(desc: &SpectrumDesc) -> f32 {
    cie::Y_INTEGRAL
        * match desc {
            SpectrumDesc::Rgb { space, .. } => space.illuminant().xyz()[1],
            _ => luminance_of(desc, SpectrumRole::Illuminant),
        }
}

/// The spectrum a description stands for in spectral mode, at 1 nm steps.
pub(crate) fn spectral_dense(desc: &SpectrumDesc, role: SpectrumRole) -> DenseSpectrum {
    let SpectrumDesc::Rgb { rgb, space } = desc else { return desc.dense() };
    let fitter = Fitter::exact(*space);
    if role == SpectrumRole::Albedo {
        let s = fitter.fit(*rgb);
        return DenseSpectrum::from_fn(|l| s.at(l));
    }
    let m = 2.0 * rgb[0].max(rgb[1]).max(rgb[2]);
    if m.is_nan() || m <= 0.0 {
        return DenseSpectrum::from_fn(|_| 0.0);
    }
    let s = fitter.fit(rgb.map(|v| v / m));
    match role {
        SpectrumRole::Illuminant => space.illuminant().map(|l, v| m * s.at(l) * v),
        _ => DenseSpectrum::from_fn(|l| m * s.at(l)),
    }
}

impl Spectrum {
    /// XYZ of light with these lanes. In spectral mode an estimate from four wavelengths,
    /// unbiased over [`Wavelengths::sample`]: (1/4) Σ sᵢ (x̄, ȳ, z̄)(λᵢ) / (pᵢ ∫ ȳ dλ).
    #[inline]
    pub fn xyz(&self, w: &Wavelengths) -> [f32; 3] {
        match w.mode {
            ColorMode::Rgb => crate::ColorSpace::Srgb.to_xyz().apply(self.rgb()),
            ColorMode::Spectral => {
                let mut xyz = [0.0; 3];
                for i in 0..4 {
                    if w.pdf[i] != 0.0 {
                        let row = cie::matching(w.lambda[i]);
                        let s = self.0[i] / w.pdf[i];
                        for k in 0..3 {
                            xyz[k] += s * row[k];
                        }
                    }
                }
                xyz.map(|v| v * (0.25 / cie::Y_INTEGRAL))
            }
        }
    }

    /// Luminance Y of light with these lanes: by Rec.709 weights in RGB mode, an estimate in
    /// spectral mode.
    #[inline]
    pub fn luminance(&self, w: &Wavelengths) -> f32 {
        match w.mode {
            ColorMode::Rgb => rec709_luminance(self.rgb()),
            ColorMode::Spectral => self.xyz(w)[1],
        }
    }
}

/// Luminance of linear sRGB.
#[inline]
pub fn rec709_luminance(rgb: [f32; 3]) -> f32 {
    REC709[0] * rgb[0] + REC709[1] * rgb[1] + REC709[2] * rgb[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ColorSpace, named};

    #[test]
    fn luminances() {
        let role = SpectrumRole::Illuminant;
        for (desc, want) in [
            (SpectrumDesc::Constant(3.0), 3.0),
            (SpectrumDesc::D65 { scale: 2.0 }, 2.0),
            (named("stdillum-F7").expect("known"), 1.0),
            (SpectrumDesc::Rgb { rgb: [1.0, 0.0, 0.0], space: ColorSpace::Srgb }, 0.2126),
        ] {
            assert!((luminance_of(&desc, role) / want - 1.0).abs() < 5e-4, "{desc:?}");
        }
        let rgb = SpectrumDesc::Rgb { rgb: [5.0, 0.0, 0.0], space: ColorSpace::Srgb };
        assert!((photometric_integral(&rgb) - cie::Y_INTEGRAL).abs() < 1e-3);
    }

    #[test]
    fn luminance_estimates_a_flat_spectrum_without_bias() {
        // 65536 stratified sets of four wavelengths integrate nearly exactly.
        let n = 1 << 16;
        let (mut all, mut hero) = ([0.0f64; 3], 0.0f64);
        for i in 0..n {
            let mut w = Wavelengths::sample((i as f32 + 0.5) / n as f32);
            let xyz = Spectrum::ONE.xyz(&w);
            for k in 0..3 {
                all[k] += xyz[k] as f64 / n as f64;
            }
            w.terminate_secondary();
            hero += Spectrum([1.0, f32::NAN, 7.0, 7.0]).luminance(&w) as f64 / n as f64;
        }
        assert!((all[1] - 1.0).abs() < 1e-4 && (hero - 1.0).abs() < 1e-4, "{all:?} {hero}");
        assert!((all[0] - 1.0).abs() < 1e-3 && (all[2] - 1.0).abs() < 1e-3, "{all:?}");
    }
}
