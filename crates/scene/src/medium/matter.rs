//! Coefficients and emission of a medium, point by point.

use super::cloud::Cloud;
use super::grid::Grid;
use kaustika_math::Vec3;
use kaustika_spectra::{
    ColorMode, CompiledSpectrum, Spectrum, SpectrumRole, Wavelengths, blackbody, wien_peak,
};

/// What a medium does at a point, per unit of length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// Extinction.
    pub sigma_t: Spectrum,
    /// Scattering.
    pub sigma_s: Spectrum,
    /// Emitted radiance, σₐ Lₑ.
    pub glow: Spectrum,
}

/// A colour that may vary over space.
#[derive(Debug)]
pub(super) enum Field {
    /// The same everywhere.
    Constant(CompiledSpectrum),
    /// A number or an RGB colour of this role at each point.
    Grid(Grid, SpectrumRole),
}

impl Field {
    pub(super) fn at(&self, p: Vec3, lambda: &Wavelengths) -> Spectrum {
        match self {
            Field::Constant(spectrum) => spectrum.eval(lambda),
            Field::Grid(grid, role) => grid.spectrum(p, *role, lambda),
        }
    }

    /// The constant part: all of it or nothing.
    fn constant(&self, lambda: &Wavelengths) -> Spectrum {
        match self {
            Field::Constant(spectrum) => spectrum.eval(lambda),
            Field::Grid(..) => Spectrum::ZERO,
        }
    }

    /// No less than the varying part at any wavelength and point of the box.
    fn bound(&self, corners: &[Vec3; 8], mode: ColorMode) -> f32 {
        match self {
            Field::Constant(_) => 0.0,
            Field::Grid(grid, _) => {
                // The spectrum of a colour may be twice its greatest component somewhere.
                let coloured = mode == ColorMode::Spectral && grid.desc().channels == 3;
                let room = if coloured { 2.0 } else { 1.0 };
                grid.bound(corners.iter().copied()) * room
            }
        }
    }
}

/// A number that varies over space.
#[derive(Debug)]
pub(super) enum Density {
    Grid(Grid),
    Cloud(Box<Cloud>),
}

impl Density {
    fn number(&self, p: Vec3) -> f32 {
        match self {
            Density::Grid(grid) => grid.number(p),
            Density::Cloud(cloud) => cloud.number(p),
        }
    }

    fn bound(&self, corners: impl Iterator<Item = Vec3>) -> f32 {
        match self {
            Density::Grid(grid) => grid.bound(corners),
            Density::Cloud(cloud) => cloud.bound(corners),
        }
    }
}

/// σₐ and σₛ, or σₜ and the albedo, times a density.
#[derive(Debug)]
pub(super) struct Matter {
    /// σₐ or σₜ.
    pub(super) first: Field,
    /// σₛ or the albedo.
    pub(super) second: Field,
    /// True if they are σₜ and the albedo.
    pub(super) has_albedo: bool,
    /// Multiplies the coefficients.
    pub(super) scale: f32,
    /// Multiplies them at each point.
    pub(super) density: Option<Density>,
}

impl Matter {
    /// σₜ and σₛ.
    pub(super) fn at(&self, p: Vec3, lambda: &Wavelengths) -> (Spectrum, Spectrum) {
        let scale = self.scale * self.density.as_ref().map_or(1.0, |d| d.number(p).max(0.0));
        let (a, b) = (self.first.at(p, lambda), self.second.at(p, lambda));
        match self.has_albedo {
            true => (a * scale, a * b.clamp(0.0, 1.0) * scale),
            false => ((a + b) * scale, b * scale),
        }
    }

    /// The part of σₜ that does not vary, before the density and the scale.
    pub(super) fn constant_extinction(&self, lambda: &Wavelengths) -> Spectrum {
        match self.has_albedo {
            true => self.first.constant(lambda),
            false => self.first.constant(lambda) + self.second.constant(lambda),
        }
    }

    /// a and b of the majorant a C(λ) + b in a box, C being
    /// [`Matter::constant_extinction`].
    pub(super) fn majorant(&self, corners: &[Vec3; 8], mode: ColorMode) -> [f32; 2] {
        let density = self.density.as_ref().map_or(1.0, |d| d.bound(corners.iter().copied()));
        let mut varying = self.first.bound(corners, mode);
        if !self.has_albedo {
            varying += self.second.bound(corners, mode);
        }
        let a = self.scale * density;
        // The last bits belong to rounding: a majorant below the extinction would be a bias.
        [a * 1.0001, a * varying * 1.0001]
    }

    /// True if the coefficients are the same everywhere.
    pub(super) fn is_uniform(&self) -> bool {
        self.density.is_none() && self.grids().next().is_none()
    }

    /// The grids that decide how fine majorants are.
    pub(super) fn grids(&self) -> impl Iterator<Item = &Grid> {
        let fields = [&self.first, &self.second].into_iter().filter_map(|field| match field {
            Field::Grid(grid, _) => Some(grid),
            Field::Constant(_) => None,
        });
        fields.chain(self.density.as_ref().and_then(|density| match density {
            Density::Grid(grid) => Some(grid),
            Density::Cloud(_) => None,
        }))
    }
}

/// Lₑ.
#[derive(Debug)]
pub(super) struct Glow {
    pub(super) source: Source,
    pub(super) scale: f32,
    pub(super) grid: Option<Grid>,
}

/// Where its spectrum comes from.
#[derive(Debug)]
pub(super) enum Source {
    Radiance(Field),
    /// Black bodies of (value - offset) · factor kelvin.
    Temperature {
        grid: Grid,
        offset: f32,
        factor: f32,
        colors: Vec<[f32; 3]>,
    },
}

/// Black bodies that are tabulated in RGB mode: one every so many kelvin.
pub(super) const KELVIN_STEP: f32 = 50.0;
/// How many.
pub(super) const KELVIN_STEPS: usize = 400;

impl Glow {
    /// Lₑ at a point.
    pub(super) fn radiance(&self, p: Vec3, lambda: &Wavelengths) -> Spectrum {
        let scale = self.scale * self.grid.as_ref().map_or(1.0, |g| g.number(p).max(0.0));
        if scale <= 0.0 {
            return Spectrum::ZERO;
        }
        let le = match &self.source {
            Source::Radiance(field) => field.at(p, lambda),
            Source::Temperature { grid, offset, factor, colors } => {
                let kelvin = (grid.number(p) - offset) * factor;
                if kelvin <= 100.0 {
                    return Spectrum::ZERO;
                }
                match lambda.mode {
                    ColorMode::Spectral => {
                        let peak = blackbody(wien_peak(kelvin), kelvin);
                        Spectrum(lambda.lambda.map(|l| blackbody(l, kelvin) / peak))
                    }
                    ColorMode::Rgb => {
                        let at = kelvin / KELVIN_STEP;
                        let i = (at as usize).min(colors.len().saturating_sub(2));
                        let t = (at - i as f32).min(1.0);
                        let [a, b] = [i, i + 1].map(|i| Spectrum::from_rgb(colors[i]));
                        a.lerp(b, t)
                    }
                }
            }
        };
        le * scale
    }
}
