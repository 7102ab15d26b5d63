//! Lights that are not surfaces.

use super::{Bitmap, FovAxis, MediumId, Span, TextureId};
use kaustika_math::{Transform, Vec3};
use kaustika_spectra::{ColorSpace, SpectrumDesc};
use std::sync::Arc;

/// A light without a surface, in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct LightDesc {
    /// Name or id in the file; may be empty.
    pub name: String,
    /// Its kind.
    pub kind: LightKind,
    /// Light to world.
    pub transform: Transform,
    /// Medium it stands in.
    pub medium: Option<MediumId>,
    /// Where it was written.
    pub span: Option<Span>,
}

/// Kinds of lights. Every spectrum has the role of an illuminant and is multiplied by `scale`.
#[derive(Clone, Debug, PartialEq)]
pub enum LightKind {
    /// At the origin of its space, the same in every direction.
    Point {
        /// Radiant intensity, W/sr.
        intensity: SpectrumDesc,
        /// Multiplies it.
        scale: f32,
        /// Total power instead of `scale`, W.
        power: Option<f32>,
    },
    /// At the origin, along +z.
    Spot {
        /// Radiant intensity on the axis, W/sr.
        intensity: SpectrumDesc,
        /// Multiplies it.
        scale: f32,
        /// Total power instead of `scale`, W.
        power: Option<f32>,
        /// Half-angle of the cone, degrees.
        cutoff: f32,
        /// Half-angle inside which there is no falloff, degrees.
        beam_width: f32,
        /// Shape of the falloff between the two.
        falloff: SpotFalloff,
        /// Projected slide, over the square that bounds the cone (Mitsuba's `texture`).
        texture: Option<TextureId>,
    },
    /// Parallel light along +z of its space.
    Directional {
        /// Irradiance on a surface facing it, W/m².
        irradiance: SpectrumDesc,
        /// Multiplies it.
        scale: f32,
        /// Illuminance of a facing surface instead of `scale` (pbrt's `illuminance`).
        illuminance: Option<f32>,
    },
    /// All light on one ray, from the origin along +z (Mitsuba 0.6's `collimated`).
    Beam {
        /// Power, W.
        power: SpectrumDesc,
        /// Multiplies it.
        scale: f32,
    },
    /// The same radiance from everywhere.
    Constant {
        /// Radiance, W/(m² sr).
        radiance: SpectrumDesc,
        /// Multiplies it.
        scale: f32,
        /// Illuminance of a surface under the upper hemisphere instead of `scale`.
        illuminance: Option<f32>,
    },
    /// Radiance from an image around the scene.
    Image {
        /// RGB radiance.
        bitmap: Arc<Bitmap>,
        /// Colour space of the image.
        space: ColorSpace,
        /// How directions map to it, in light space.
        layout: EnvironmentLayout,
        /// Multiplies it.
        scale: f32,
        /// Illuminance of a surface under the upper hemisphere instead of `scale`.
        illuminance: Option<f32>,
    },
    /// Radiance from an image that comes in through a rectangle only (pbrt's portal).
    Portal {
        /// RGB radiance.
        bitmap: Arc<Bitmap>,
        /// Colour space of the image.
        space: ColorSpace,
        /// How directions map to it, in light space.
        layout: EnvironmentLayout,
        /// Multiplies it.
        scale: f32,
        /// Around the rectangle, in world space. Outside is where the cross product of the sides
        /// from the first corner to the fourth and to the second points.
        corners: [Vec3; 4],
    },
    /// A clear sky around the scene, +z straight up; the sun itself is another light.
    Sky {
        /// The atmosphere and where the sun stands.
        sky: SkyDesc,
        /// Multiplies its radiance.
        scale: f32,
    },
    /// A disc at infinity, of the same radiance all over, around +z of its space.
    Sun {
        /// Radiance, W/(m² sr).
        radiance: SpectrumDesc,
        /// Multiplies it.
        scale: f32,
        /// Angular radius, degrees in (0, 180].
        radius: f32,
    },
    /// An image projected from the origin along +z (pbrt's `projection`).
    Projection {
        /// RGB intensity.
        bitmap: Arc<Bitmap>,
        /// Colour space.
        space: ColorSpace,
        /// Horizontal field of view, degrees.
        fov_x: f32,
        /// Multiplies it.
        scale: f32,
        /// Total power instead of `scale`, W.
        power: Option<f32>,
    },
    /// A texture projected from the origin along +z, the reverse of a perspective camera: even
    /// light on planes across (Mitsuba 3's `projector`).
    Projector {
        /// π⁻¹ times the irradiance of the plane z = 1; u runs along -x, v along -y.
        texture: TextureId,
        /// Multiplies it.
        scale: f32,
        /// Field of view, degrees.
        fov: f32,
        /// Which side of the bitmap it spans; other textures are square.
        fov_axis: FovAxis,
    },
    /// A point light whose intensity is an image over directions, equal-area octahedral (pbrt).
    Goniometric {
        /// Base intensity.
        intensity: SpectrumDesc,
        /// Factor over directions.
        bitmap: Arc<Bitmap>,
        /// Multiplies it.
        scale: f32,
        /// Total power instead of `scale`, W.
        power: Option<f32>,
    },
}

/// A clear sky after Hosek and Wilkie (2012).
#[derive(Clone, Debug, PartialEq)]
pub struct SkyDesc {
    /// Turbidity of the atmosphere, in [1, 10].
    pub turbidity: f32,
    /// Reflectance of the ground.
    pub albedo: SpectrumDesc,
    /// Direction to the sun in light space, above the horizon.
    pub sun: Vec3,
    /// Polar angles are divided by it, so that the sky reaches below the horizon: in [1, 2];
    /// 1 for a sky as it is.
    pub stretch: f32,
    /// Whether the horizon's radiance goes on below it, fading out toward -z.
    pub extend: bool,
}

/// Falloff of a spot light between beam width and cutoff.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpotFalloff {
    /// Linear in the angle (Mitsuba).
    LinearAngle,
    /// Smoothstep in the cosine (pbrt-v4).
    SmoothstepCosine,
    /// The square of what is linear in the cosine (glTF's recommendation).
    SquaredLinearCosine,
}

/// How an environment image covers the sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnvironmentLayout {
    /// Latitude-longitude as Mitsuba has it: +y up in light space; direction
    /// (sin φ sin θ, cos θ, -cos φ sin θ) at (u, v) = (φ/2π, θ/π), bilinear between texel
    /// centres.
    LatLong,
    /// Equal-area octahedral, +z up (pbrt-v4).
    EqualArea,
}
