//! Textures: trees of nodes that give a number or a spectrum at a surface point.

use super::{Bitmap, GridDesc, Span};
use kaustika_math::{Affine2, Transform};
use kaustika_spectra::{ColorSpace, SpectrumDesc};
use std::sync::Arc;

/// Index into [`super::SceneDescription::textures`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TextureId(pub u32);

/// A texture with its place in the source.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureDesc {
    /// What it computes.
    pub node: TextureNode,
    /// Where it was written.
    pub span: Option<Span>,
}

/// One node of a texture tree. Any node can be asked for a number (the mean of a colour) or for
/// a spectrum (a number is grey); what a colour means (albedo,
/// unbounded, illuminant) is decided by the parameter it is used for.
#[derive(Clone, Debug, PartialEq)]
pub enum TextureNode {
    /// A number; as a spectrum the same everywhere.
    Float(f32),
    /// A spectrum.
    Spectrum(SpectrumDesc),
    /// An image.
    Bitmap(BitmapTexture),
    /// Two textures in squares of side 1/2 in the mapped uv (Mitsuba: lower left is `a`;
    /// pbrt's unit squares: the reader scales the mapping).
    Checkerboard {
        /// Where (floor(2u) + floor(2v)) is even.
        a: TextureId,
        /// Elsewhere.
        b: TextureId,
        /// Mapping of uv.
        mapping: TextureMapping,
    },
    /// pbrt's 3D checkerboard: unit cells of the mapped position.
    Checkerboard3d {
        /// Where the sum of the cell numbers is even.
        a: TextureId,
        /// Elsewhere.
        b: TextureId,
        /// World to texture space.
        to_texture: Transform,
    },
    /// pbrt's dots: random discs in unit cells of the mapped uv.
    Dots {
        /// Inside a dot.
        inside: TextureId,
        /// Outside.
        outside: TextureId,
        /// Mapping of uv.
        mapping: TextureMapping,
    },
    /// Product.
    Scale {
        /// One factor.
        texture: TextureId,
        /// The other.
        scale: TextureId,
    },
    /// (1 - amount) a + amount b.
    Mix {
        /// At amount 0.
        a: TextureId,
        /// At amount 1.
        b: TextureId,
        /// Weight of `b`.
        amount: TextureId,
    },
    /// pbrt's directionmix: `a` where the normal faces `dir`, blending to `b`.
    DirectionMix {
        /// Along `dir`.
        a: TextureId,
        /// Across it.
        b: TextureId,
        /// World-space direction, unit.
        dir: [f32; 3],
    },
    /// Bilinear interpolation of four values over uv in [0,1]².
    Bilerp {
        /// v00, v01, v10, v11 (first index u).
        corners: [TextureId; 4],
        /// Mapping of uv.
        mapping: TextureMapping,
    },
    /// Perlin noise: fractional Brownian motion, turbulence or pbrt's marble, windy, wrinkled.
    Noise {
        /// Which.
        kind: NoiseKind,
        /// Number of octaves.
        octaves: u32,
        /// Falloff a octave, pbrt's `roughness`.
        roughness: f32,
        /// Input scale, pbrt's marble.
        scale: f32,
        /// Perturbation, pbrt's marble.
        variation: f32,
        /// World to texture space.
        to_texture: Transform,
    },
    /// Lines along u = 0 and v = 0 modulo 1 (Mitsuba 0.6's gridtexture).
    LineGrid {
        /// Between the lines.
        between: TextureId,
        /// On them.
        lines: TextureId,
        /// Half their width, in uv.
        half_width: f32,
        /// Mapping of uv.
        mapping: TextureMapping,
    },
    /// What a grid in space has at the surface's point: a number or a colour.
    Grid(Arc<GridDesc>),
    /// A value stored on the vertices or faces of the mesh, by name.
    MeshAttribute {
        /// Attribute name.
        name: String,
        /// Multiplies it.
        scale: f32,
    },
    /// 1 where another texture, as a number, is at least `threshold`, else 0.
    Step {
        /// What is compared.
        texture: TextureId,
        /// Least value that gives 1.
        threshold: f32,
    },
    /// A texture at other surface parameters, which the mesh stores as an attribute of two
    /// numbers (and an unused third).
    WithUv {
        /// What is looked up.
        texture: TextureId,
        /// The attribute's name.
        attribute: String,
    },
}

/// Procedural noises of pbrt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseKind {
    /// Fractional Brownian motion.
    Fbm,
    /// Turbulence (absolute values).
    Wrinkled,
    /// Two fBm, as waves under wind.
    Windy,
    /// A colour spline along a perturbed axis.
    Marble,
}

/// An image as a texture.
#[derive(Clone, Debug, PartialEq)]
pub struct BitmapTexture {
    /// The texels.
    pub bitmap: Arc<Bitmap>,
    /// Which channels are used.
    pub channels: BitmapChannels,
    /// Between texels.
    pub filter: BitmapFilter,
    /// Beyond [0,1] along u and v.
    pub wrap: [Wrap; 2],
    /// Mapping of uv. v runs up: v = 0 is the bottom row of the image.
    pub mapping: TextureMapping,
    /// Multiplies the value.
    pub scale: f32,
    /// True: value becomes 1 - value (before `scale`), clamped at 0.
    pub invert: bool,
    /// True: numbers are data, not colours; no spectral uplift (normal maps).
    pub raw: bool,
    /// Colour space of RGB texels.
    pub space: ColorSpace,
}

/// Which channels of a bitmap a texture reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BitmapChannels {
    /// Colour (grey images repeat).
    Color,
    /// Mean of the colour channels.
    Mean,
    /// Rec. 709 luminance of the colour channels.
    Luminance,
    /// The alpha channel; 1 if the image has none.
    Alpha,
    /// One channel by number.
    Channel(u32),
}

/// How texels are interpolated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BitmapFilter {
    /// The nearest texel.
    Nearest,
    /// Linear between four.
    Bilinear,
    /// Bilinear in the nearest level of a pyramid, linear between levels, by ray footprint.
    Trilinear,
    /// Elliptically weighted average over the ray footprint.
    Ewa,
}

/// What an image shows beyond its borders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// It repeats.
    Repeat,
    /// Its border goes on.
    Clamp,
    /// Black.
    Black,
    /// It repeats mirrored.
    Mirror,
}

/// Where on the texture a surface point lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TextureMapping {
    /// An affine map of the surface's uv.
    Uv(Affine2),
    /// Spherical coordinates of the position (pbrt).
    Spherical(Transform),
    /// Cylindrical coordinates of the position (pbrt).
    Cylindrical(Transform),
    /// (vs·p + ds, vt·p + dt) in texture space (pbrt).
    Planar {
        /// World to texture space.
        to_texture: Transform,
        /// First axis.
        vs: [f32; 3],
        /// Second axis.
        vt: [f32; 3],
        /// Offset of the first coordinate.
        ds: f32,
        /// Offset of the second coordinate.
        dt: f32,
    },
}

impl Default for TextureMapping {
    fn default() -> Self {
        TextureMapping::Uv(Affine2::IDENTITY)
    }
}
