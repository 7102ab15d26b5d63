//! Spectra ready for evaluation during a render.

use crate::photometry::{luminance_of, rec709_luminance, spectral_dense, xyz_of};
use crate::rgb_fit::Fitter;
use crate::{
    ColorMode, ColorSpace, DenseSpectrum, SigmoidPolynomial, Spectrum, SpectrumDesc, Wavelengths,
};

/// What a spectrum describes, which decides how RGB colours become spectra and spectra RGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SpectrumRole {
    /// A fraction: reflectance, transmittance, single-scattering albedo.
    Albedo,
    /// A non-negative quantity without bound: index of refraction, absorption, a scale.
    Unbounded,
    /// Light: radiance, intensity, power.
    Illuminant,
}

/// A [`SpectrumDesc`] in a role and a colour mode, fast to evaluate. Cheap to clone.
///
/// **RGB mode** holds one linear sRGB colour. Spectra are projected as Mitsuba 3's `*_rgb`
/// variants do (`Properties::get_texture_impl`, `spectrum_list_to_srgb`):
///
/// ```text
/// XYZ = ∫ s(λ) e(λ) (x̄, ȳ, z̄)(λ) dλ / ∫ ȳ dλ,   e = 1 for illuminants, else D65 of Y = 1
/// ```
///
/// then converted to linear sRGB, of which negative components become 0 and, for albedos only,
/// those above 1 become 1. The n and k of [`conductor`](crate::conductor) presets take e = 1,
/// again as Mitsuba. (Mitsuba's quadrature loses 0.1 % for e = D65; ours does not.) `Constant(c)`
/// is (c, c, c) in every role.
///
/// **Spectral mode** holds a sigmoid polynomial for an RGB albedo (Jakob and Hanika 2019), and a
/// table of 1 nm steps for everything that is not constant; RGB colours of the other roles follow
/// pbrt-v4's RGBUnboundedSpectrum and RGBIlluminantSpectrum.
#[derive(Clone, Debug, PartialEq)]
pub struct CompiledSpectrum {
    values: Values,
    luminance: f32,
    max: f32,
}

#[derive(Clone, Debug, PartialEq)]
enum Values {
    /// The lanes, whatever the wavelengths.
    Lanes(Spectrum),
    Sigmoid(SigmoidPolynomial),
    Dense(DenseSpectrum),
}

impl CompiledSpectrum {
    /// Compiles a description. Never fails: NaN and infinities pass through, broken tables count
    /// as black.
    pub fn new(desc: &SpectrumDesc, role: SpectrumRole, mode: ColorMode) -> CompiledSpectrum {
        match mode {
            ColorMode::Rgb => CompiledSpectrum::from_srgb(project(desc, role)),
            ColorMode::Spectral => spectral(desc, role),
        }
    }

    /// The value `c` in every lane that counts.
    pub fn constant(c: f32, mode: ColorMode) -> CompiledSpectrum {
        match mode {
            ColorMode::Rgb => CompiledSpectrum::from_srgb([c; 3]),
            ColorMode::Spectral => {
                CompiledSpectrum { values: Values::Lanes(Spectrum::splat(c)), luminance: c, max: c }
            }
        }
    }

    fn from_srgb(rgb: [f32; 3]) -> CompiledSpectrum {
        CompiledSpectrum {
            values: Values::Lanes(Spectrum::from_rgb(rgb)),
            luminance: rec709_luminance(rgb),
            max: rgb[0].max(rgb[1]).max(rgb[2]),
        }
    }

    /// The lanes at these wavelengths, which must be of the mode it was compiled for.
    #[inline]
    pub fn eval(&self, w: &Wavelengths) -> Spectrum {
        match &self.values {
            Values::Lanes(lanes) => *lanes,
            Values::Sigmoid(s) => s.eval(w),
            Values::Dense(d) => d.eval(w),
        }
    }

    /// Luminance Y: of an illuminant itself, of anything else as lit by D65; 1 for a flat
    /// spectrum of 1.
    pub fn luminance(&self) -> f32 {
        self.luminance
    }

    /// Largest value over the spectrum (360..830 nm) or the components.
    pub fn max(&self) -> f32 {
        self.max
    }

    /// True if it has no value above zero.
    pub fn is_black(&self) -> bool {
        self.max <= 0.0
    }

    /// True if all lanes that count are equal whatever the wavelengths, so that an index of
    /// refraction with these values does not disperse.
    pub fn is_constant(&self) -> bool {
        match &self.values {
            Values::Lanes(s) => s.0[0] == s.0[1] && s.0[1] == s.0[2],
            _ => false,
        }
    }

    /// All values times `scale`.
    pub fn scaled(&self, scale: f32) -> CompiledSpectrum {
        let dense = match &self.values {
            Values::Lanes(s) => {
                let lanes = *s * scale;
                let max = lanes.0[0].max(lanes.0[1]).max(lanes.0[2]);
                let luminance = scale * self.luminance;
                return CompiledSpectrum { values: Values::Lanes(lanes), luminance, max };
            }
            Values::Sigmoid(s) => DenseSpectrum::from_fn(|l| scale * s.at(l)),
            Values::Dense(d) => d.map(|_, v| scale * v),
        };
        let (max, luminance) = (dense.max(), scale * self.luminance);
        CompiledSpectrum { values: Values::Dense(dense), luminance, max }
    }
}

/// Linear sRGB of a description in RGB mode.
fn project(desc: &SpectrumDesc, role: SpectrumRole) -> [f32; 3] {
    let rgb = match desc {
        SpectrumDesc::Constant(c) => return [*c; 3],
        SpectrumDesc::EqualEnergy(c) if role != SpectrumRole::Illuminant => return [*c; 3],
        SpectrumDesc::D65 { scale } if role == SpectrumRole::Illuminant => return [*scale; 3],
        SpectrumDesc::Rgb { rgb, space } => space.to_srgb(*rgb),
        _ => ColorSpace::Srgb.from_xyz().apply(xyz_of(desc, role)),
    };
    match role {
        SpectrumRole::Albedo => rgb.map(|v| v.clamp(0.0, 1.0)),
        _ => rgb.map(|v| v.max(0.0)),
    }
}

fn spectral(desc: &SpectrumDesc, role: SpectrumRole) -> CompiledSpectrum {
    match desc {
        SpectrumDesc::Constant(c) | SpectrumDesc::EqualEnergy(c) => {
            CompiledSpectrum::constant(*c, ColorMode::Spectral)
        }
        // Greys are flat unless they are light.
        SpectrumDesc::Rgb { rgb: [r, g, b], .. }
            if r == g && g == b && role != SpectrumRole::Illuminant =>
        {
            let top = if role == SpectrumRole::Albedo { 1.0 } else { f32::MAX };
            CompiledSpectrum::constant(r.clamp(0.0, top), ColorMode::Spectral)
        }
        SpectrumDesc::Rgb { rgb, space } if role == SpectrumRole::Albedo => {
            let s = Fitter::exact(*space).fit(*rgb);
            CompiledSpectrum {
                values: Values::Sigmoid(s),
                luminance: luminance_of(desc, role),
                max: DenseSpectrum::from_fn(|l| s.at(l)).max(),
            }
        }
        _ => {
            let dense = spectral_dense(desc, role);
            let max = dense.max();
            CompiledSpectrum {
                values: Values::Dense(dense),
                luminance: luminance_of(desc, role),
                max,
            }
        }
    }
}

#[cfg(test)]
mod tests;
