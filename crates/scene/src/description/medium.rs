//! Participating media.

use super::Span;
use kaustika_math::Transform;
use kaustika_spectra::SpectrumDesc;
use std::sync::Arc;

/// Index into [`super::SceneDescription::media`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MediumId(pub u32);

/// Matter that absorbs, scatters and emits in space.
#[derive(Clone, Debug, PartialEq)]
pub struct MediumDesc {
    /// Name or id; may be empty.
    pub name: String,
    /// Kind in the file, such as `homogeneous`.
    pub kind: String,
    /// What happens to light on its way, per unit of length.
    pub coefficients: CoefficientsDesc,
    /// Multiplies the coefficients (not an albedo).
    pub scale: f32,
    /// Multiplies the coefficients at each point.
    pub density: Option<DensityDesc>,
    /// Light of its own.
    pub glow: Option<GlowDesc>,
    /// Into which directions it scatters.
    pub phase: PhaseDesc,
    /// The unit cube to the box it fills; `None`: all that its boundaries enclose.
    pub extent: Option<Transform>,
    /// Where it was written.
    pub span: Option<Span>,
}

/// The two numbers that describe an absorbing and scattering medium, in either form.
#[derive(Clone, Debug, PartialEq)]
pub enum CoefficientsDesc {
    /// Absorption σₐ and scattering σₛ.
    AbsorptionScattering(FieldDesc, FieldDesc),
    /// Extinction σₜ = σₐ + σₛ and single-scattering albedo σₛ/σₜ.
    ExtinctionAlbedo(FieldDesc, FieldDesc),
}

/// A number that varies over space.
#[derive(Clone, Debug, PartialEq)]
pub enum DensityDesc {
    /// Sampled.
    Grid(Arc<GridDesc>),
    /// Made from noise.
    Cloud(CloudDesc),
}

/// pbrt-v4's procedural cloud.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloudDesc {
    /// Multiplies the noise.
    pub density: f32,
    /// How strongly the noise is distorted, 0 not at all.
    pub wispiness: f32,
    /// Lattice cells of the noise per unit of its own space.
    pub frequency: f32,
    /// Own space, in which it thins out along y from 0 to 1, to world.
    pub to_world: Transform,
}

/// A colour that may vary over space.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldDesc {
    /// The same everywhere.
    Constant(SpectrumDesc),
    /// Sampled.
    Grid(Arc<GridDesc>),
}

/// Samples on a regular grid.
#[derive(Clone, PartialEq)]
pub struct GridDesc {
    /// Samples along x, y and z, each at least 1.
    pub resolution: [u32; 3],
    /// 1 (a number), 3 (linear sRGB) or 6 (microflakes).
    pub channels: u32,
    /// x fastest, then y, then z; the channels of a sample side by side.
    pub values: Vec<f32>,
    /// The unit cube, which the samples fill, to world.
    pub to_world: Transform,
    /// Where in the cube they lie.
    pub layout: GridLayout,
    /// Between them.
    pub filter: GridFilter,
}

impl std::fmt::Debug for GridDesc {
    /// With a hash in place of the samples.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mix = |h, v: &f32| kaustika_math::mix_bits(h ^ u64::from(v.to_bits()));
        f.debug_struct("GridDesc")
            .field("resolution", &self.resolution)
            .field("channels", &self.channels)
            .field("values", &self.values.iter().fold(0, mix))
            .field("to_world", &self.to_world)
            .field("layout", &self.layout)
            .field("filter", &self.filter)
            .finish()
    }
}

/// Where the samples of a grid lie, and what is beyond the outermost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GridLayout {
    /// In the centres of cells; the border's value beyond (Mitsuba 3).
    CellsClamped,
    /// In the centres of cells; they repeat.
    CellsRepeated,
    /// In the centres of cells; they repeat mirrored.
    CellsMirrored,
    /// In the centres of cells; nothing beyond (pbrt).
    CellsFading,
    /// On the corners of cells, from face to face of the cube (Mitsuba 0.6).
    Corners,
}

/// What lies between the samples of a grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GridFilter {
    /// Trilinear interpolation.
    #[default]
    Trilinear,
    /// The nearest sample's value.
    Nearest,
}

/// Emission: the radiance that absorption gives back, Lₑ in σₐ Lₑ.
#[derive(Clone, Debug, PartialEq)]
pub struct GlowDesc {
    /// Lₑ, W/(m² sr).
    pub source: GlowSource,
    /// Multiplies it.
    pub scale: f32,
    /// Multiplies it at each point.
    pub grid: Option<Arc<GridDesc>>,
}

/// Where the spectrum of a glow comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum GlowSource {
    /// A spectrum, with the role of an illuminant.
    Radiance(FieldDesc),
    /// A black body, normalised to a maximum of 1, of (value - offset) · factor kelvin; dark up to
    /// 100 K (pbrt).
    Temperature {
        /// The values.
        grid: Arc<GridDesc>,
        /// Subtracted from them.
        offset: f32,
        /// Multiplies the difference.
        factor: f32,
    },
}

/// How a medium scatters; θ is the angle between the directions of flight before and after.
#[derive(Clone, Debug, PartialEq)]
pub enum PhaseDesc {
    /// Alike in all directions.
    Isotropic,
    /// Henyey & Greenstein 1941, mean cosine g in (-1, 1): forward where positive.
    HenyeyGreenstein {
        /// Mean cosine.
        g: f32,
    },
    /// Particles much smaller than the wavelength (Rayleigh 1871).
    Rayleigh,
    /// A sum of two.
    Blend {
        /// Share of the second, in [0, 1].
        weight: f32,
        /// First.
        a: Box<PhaseDesc>,
        /// Second.
        b: Box<PhaseDesc>,
    },
    /// Values at even steps of cos θ from -1 (back) to 1 (forward), linear between; of any scale.
    Tabulated {
        /// At least two, none negative, not all zero.
        values: Vec<f32>,
    },
    /// Mirroring microflakes. As the phase function of a medium it multiplies the extinction by
    /// the flakes' projected area; within a blend it does not (Mitsuba 3).
    Sggx(SggxDesc),
}

/// S of microflakes (Heitz et al. 2015), symmetric and positive definite: xx, yy, zz, xy, xz, yz,
/// in world space.
#[derive(Clone, Debug, PartialEq)]
pub enum SggxDesc {
    /// The same everywhere.
    Constant([f32; 6]),
    /// A grid of six channels.
    Grid(Arc<GridDesc>),
}
