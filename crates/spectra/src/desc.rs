//! Spectra as scene files name them.

use std::sync::Arc;

/// RGB colour spaces that files may name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ColorSpace {
    /// sRGB / Rec. 709 primaries, D65.
    #[default]
    Srgb,
    /// DCI-P3 primaries with D65 white.
    DciP3,
    /// Rec. 2020, D65.
    Rec2020,
    /// ACES 2065-1.
    Aces2065_1,
}

/// A spectrum as a file gives it; what it means also depends on its role.
#[derive(Clone, Debug, PartialEq)]
pub enum SpectrumDesc {
    /// The same at every wavelength.
    Constant(f32),
    /// A colour.
    Rgb {
        /// Linear components.
        rgb: [f32; 3],
        /// Their space.
        space: ColorSpace,
    },
    /// Piecewise linear in the wavelength.
    Sampled {
        /// Wavelengths, nm, strictly increasing.
        lambda: Arc<[f32]>,
        /// One value a wavelength.
        values: Arc<[f32]>,
    },
    /// A black body.
    Blackbody {
        /// Temperature.
        kelvin: f32,
        /// True: scaled to a maximum of 1, as pbrt does.
        normalized: bool,
    },
}
