//! From described media to ready ones.

use super::cloud::Cloud;
use super::grid::Grid;
use super::majorant::MajorantGrid;
use super::matter::{Density, Field, Glow, KELVIN_STEP, KELVIN_STEPS, Matter, Source};
use super::{Medium, Phase, Sggx};
use crate::description::{
    CoefficientsDesc, DensityDesc, FieldDesc, GlowDesc, GlowSource, MediumDesc,
};
use kaustika_math::{Transform, Vec3};
use kaustika_spectra::{ColorMode, CompiledSpectrum, SpectrumDesc, SpectrumRole, Wavelengths};

/// Cells of the majorants along an axis at most.
const MOST_CELLS: u32 = 16;

impl Medium {
    /// Prepares a description.
    pub fn new(desc: &MediumDesc, mode: ColorMode) -> Medium {
        use SpectrumRole::{Albedo, Unbounded};
        let (first, second, has_albedo) = match &desc.coefficients {
            CoefficientsDesc::AbsorptionScattering(a, s) => {
                (field(a, Unbounded, mode), field(s, Unbounded, mode), false)
            }
            CoefficientsDesc::ExtinctionAlbedo(t, a) => {
                let role = if is_fraction(t) { Albedo } else { Unbounded };
                (field(t, role, mode), field(a, Albedo, mode), true)
            }
        };
        let density = desc.density.as_ref().map(|density| match density {
            DensityDesc::Grid(grid) => Density::Grid(Grid::new(grid)),
            DensityDesc::Cloud(cloud) => Density::Cloud(Box::new(Cloud::new(cloud))),
        });
        let matter = Matter { first, second, has_albedo, scale: desc.scale.max(0.0), density };
        let glow = desc.glow.as_ref().map(|g| glow(g, mode));
        let glow_varies = glow.as_ref().is_some_and(|g| match &g.source {
            Source::Radiance(Field::Constant(_)) => g.grid.is_some(),
            _ => true,
        });
        let phase = Phase::new(&desc.phase);
        let (flakes_vary, most_area) = match &phase {
            Phase::Sggx(sggx) => (matches!(sggx, Sggx::Grid(_)), sggx.most_area()),
            _ => (false, 1.0),
        };
        let varies = !matter.is_uniform() || glow_varies || flakes_vary;
        let bound = |corners: &[Vec3; 8]| matter.majorant(corners, mode).map(|v| v * most_area);
        // What varies without a box is a medium whose grids repeat their border forever.
        let majorants = varies.then(|| {
            let whole = Transform::IDENTITY;
            let Some(extent) = &desc.extent else {
                let everywhere = bound(&everywhere(&matter));
                return MajorantGrid::new(&whole, [1; 3], |_| everywhere);
            };
            let resolution = std::array::from_fn(|axis| {
                let finest = matter.grids().map(|g| g.desc().resolution[axis]).max();
                // Without grids it is a cloud that varies, or what glows.
                finest
                    .unwrap_or(if matter.is_uniform() { 1 } else { MOST_CELLS })
                    .clamp(1, MOST_CELLS)
            });
            MajorantGrid::new(extent, resolution, bound)
        });
        let scatters = match &matter.second {
            Field::Constant(spectrum) => !spectrum.is_black(),
            Field::Grid(grid, _) => grid.desc().values.iter().any(|v| *v > 0.0),
        };
        Medium {
            matter,
            glow,
            majorants,
            extent: desc.extent.as_ref().map(Transform::inverse),
            phase,
            scatters,
        }
    }
}

/// True for a colour within [0, 1]. As an extinction it has the spectrum of a reflectance, to be
/// scaled, as in Mitsuba 3.
fn is_fraction(desc: &FieldDesc) -> bool {
    let FieldDesc::Constant(SpectrumDesc::Rgb { rgb, .. }) = desc else { return false };
    rgb.iter().all(|c| (0.0..=1.0).contains(c))
}

/// The corners of a box that holds every grid's cube.
fn everywhere(matter: &Matter) -> [Vec3; 8] {
    let unit = kaustika_math::Bounds3 { min: Vec3::ZERO, max: Vec3::splat(1.0) };
    let all = matter.grids().fold(kaustika_math::Bounds3::EMPTY, |all, grid| {
        all.union(grid.desc().to_world.bounds(&unit))
    });
    std::array::from_fn(|k| all.corner(k))
}

fn field(desc: &FieldDesc, role: SpectrumRole, mode: ColorMode) -> Field {
    match desc {
        FieldDesc::Constant(spectrum) => {
            Field::Constant(CompiledSpectrum::new(spectrum, role, mode))
        }
        FieldDesc::Grid(grid) => Field::Grid(Grid::new(grid), role),
    }
}

fn glow(desc: &GlowDesc, mode: ColorMode) -> Glow {
    let source = match &desc.source {
        GlowSource::Radiance(volume) => {
            Source::Radiance(field(volume, SpectrumRole::Illuminant, mode))
        }
        GlowSource::Temperature { grid, offset, factor } => {
            let color = |i: usize| {
                let kelvin = (i as f32 * KELVIN_STEP).max(1.0);
                let desc = SpectrumDesc::Blackbody { kelvin, normalized: true };
                let spectrum = CompiledSpectrum::new(&desc, SpectrumRole::Illuminant, mode);
                spectrum.eval(&Wavelengths::rgb()).rgb()
            };
            let colors = match mode {
                ColorMode::Rgb => (0..=KELVIN_STEPS).map(color).collect(),
                ColorMode::Spectral => Vec::new(),
            };
            Source::Temperature { grid: Grid::new(grid), offset: *offset, factor: *factor, colors }
        }
    };
    Glow { source, scale: desc.scale, grid: desc.grid.as_ref().map(Grid::new) }
}
