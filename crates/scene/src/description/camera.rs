//! Cameras, film, sampler and method as files ask for them.

use super::{LensDesc, MediumId, MotionKey, Span};
use kaustika_math::{Transform, Vec3};
use kaustika_spectra::SpectrumDesc;

/// A camera and its film. Camera space: +x right in the picture, +y up, +z forward.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraDesc {
    /// Name or id; may be empty.
    pub name: String,
    /// Kind and optics.
    pub kind: CameraKind,
    /// Camera to world; may mirror.
    pub transform: Transform,
    /// How it moves, at rising times; empty where it stands still.
    pub motion: Vec<MotionKey>,
    /// Opening and closing of the shutter.
    pub shutter: [f32; 2],
    /// Medium it stands in.
    pub medium: Option<MediumId>,
    /// Its film.
    pub film: FilmDesc,
    /// Sampler kind as in `--sampler`; `None`: the default.
    pub sampler: Option<String>,
    /// Samples a pixel the file asks for.
    pub spp: Option<u64>,
    /// Seed.
    pub seed: u64,
    /// Where it was written.
    pub span: Option<Span>,
}

impl CameraDesc {
    /// A camera that stands still in no medium; everything else is left to defaults.
    pub fn new(kind: CameraKind, transform: Transform, film: FilmDesc) -> CameraDesc {
        CameraDesc {
            name: String::new(),
            kind,
            transform,
            motion: Vec::new(),
            shutter: [0.0; 2],
            medium: None,
            film,
            sampler: None,
            spp: None,
            seed: 0,
            span: None,
        }
    }
}

/// Optics.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraKind {
    /// Pinhole or thin lens.
    Perspective {
        /// Field of view, degrees.
        fov: f32,
        /// What it spans.
        fov_axis: FovAxis,
        /// Principal point offset in fractions of the picture (Mitsuba).
        principal_point: [f32; 2],
        /// Screen window x0, x1, y0, y1 at distance 1/tan(fov/2) (pbrt); overrides the aspect.
        screen_window: Option<[f32; 4]>,
        /// Radius of the lens; 0 is a pinhole.
        lens_radius: f32,
        /// Distance of the plane in focus, along z.
        focus_distance: f32,
        /// Points nearer than this (along z) are not seen.
        near_clip: f32,
        /// Points farther than this are not seen.
        far_clip: f32,
    },
    /// Parallel projection: the picture spans [-1,1] times the aspect in camera space.
    Orthographic {
        /// Screen window x0, x1, y0, y1; `None`: [-1,1] along the axis in `unit_axis`.
        screen_window: Option<[f32; 4]>,
        /// The axis along which the picture spans [-1,1]: pbrt the shorter, Mitsuba x.
        unit_axis: FovAxis,
        /// Radius of the lens; 0 is a pinhole.
        lens_radius: f32,
        /// Distance of the plane in focus.
        focus_distance: f32,
        /// Points nearer than this (along z) are not seen.
        near_clip: f32,
        /// Points farther than this are not seen.
        far_clip: f32,
    },
    /// All directions (pbrt's spherical camera; its camera space has +y up).
    Spherical {
        /// True: equal-area octahedral; false: latitude-longitude.
        equal_area: bool,
    },
    /// A film at the origin behind a lens of many surfaces, which ends along +z; units are metres.
    Realistic(LensDesc),
    /// Radiance along +z.
    Radiance,
    /// Irradiance on the front of a shape, W/m².
    Irradiance {
        /// Number of the shape in the description.
        shape: usize,
        /// True: times the shape's area, the flux that it receives, W.
        flux: bool,
    },
    /// Radiance arriving along +z from beyond the scene, averaged over what it is aimed at.
    Distant {
        /// What it is aimed at.
        target: MeterTarget,
    },
    /// Sensors side by side, each with the same number of columns of the film.
    Batch {
        /// From left to right; their films count for nothing.
        cameras: Vec<CameraDesc>,
    },
}

impl CameraKind {
    /// A pinhole that sees everything in front of it. `fov` is in degrees.
    pub fn pinhole(fov: f32, fov_axis: FovAxis) -> CameraKind {
        CameraKind::Perspective {
            fov,
            fov_axis,
            principal_point: [0.0; 2],
            screen_window: None,
            lens_radius: 0.0,
            focus_distance: 1.0,
            near_clip: 0.0,
            far_clip: f32::INFINITY,
        }
    }
}

/// What a distant sensor is aimed at.
#[derive(Clone, Debug, PartialEq)]
pub enum MeterTarget {
    /// The disc across its direction that holds the scene.
    Scene,
    /// A point of the world.
    Point(Vec3),
    /// The square [-1,1]² in the plane z = 0 of a space, which need not be there to be seen.
    Rectangle(Transform),
}

/// What a field of view spans.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FovAxis {
    /// Width.
    X,
    /// Height.
    Y,
    /// The shorter side (pbrt).
    Smaller,
    /// The longer side.
    Larger,
    /// The diagonal.
    Diagonal,
}

impl FovAxis {
    /// Half extents of a picture of w x h pixels where the axis spans [-1, 1].
    pub fn half_extents(self, [w, h]: [u32; 2]) -> [f32; 2] {
        let aspect = w as f32 / h as f32;
        let unit = match self {
            FovAxis::X => 1.0,
            FovAxis::Y => aspect,
            FovAxis::Smaller => aspect.max(1.0),
            FovAxis::Larger => aspect.min(1.0),
            FovAxis::Diagonal => aspect / (1.0 + aspect * aspect).sqrt(),
        };
        [unit, unit / aspect]
    }
}

/// The film of a camera.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmDesc {
    /// Width and height in pixels, before cropping.
    pub resolution: [u32; 2],
    /// Pixels rendered: x0, y0, x1, y1, end exclusive.
    pub crop: Option<[u32; 4]>,
    /// Reconstruction filter: name as `--filter` takes it, with its parameters.
    pub filter: FilterChoice,
    /// File name the scene asks for.
    pub filename: Option<String>,
    /// Multiplies radiance: pbrt's exposure time x ISO / 100.
    pub imaging_ratio: f32,
    /// White point for white balance as correlated colour temperature, K; `None`: off.
    pub white_balance: Option<f32>,
    /// Components above this are clamped (pbrt's maxcomponentvalue); `None`: never.
    pub max_component: Option<f32>,
    /// Feature layers asked for (pbrt's gbuffer, Mitsuba's aov): names as `--aov` takes them.
    pub aovs: Vec<String>,
    /// Channels by wavelength to keep beside the colour.
    pub bands: Option<BandsDesc>,
    /// pbrt's gbuffer film, and the space of its positions and normals.
    pub gbuffer: Option<GBufferSpace>,
}

impl FilmDesc {
    /// A whole film that leaves radiance as it is.
    pub fn new(resolution: [u32; 2], filter: FilterChoice) -> FilmDesc {
        FilmDesc {
            resolution,
            crop: None,
            filter,
            filename: None,
            imaging_ratio: 1.0,
            white_balance: None,
            max_component: None,
            aovs: Vec::new(),
            bands: None,
            gbuffer: None,
        }
    }
}

/// The space in which positions and normals are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GBufferSpace {
    /// The camera's: +x right, +y up, +z forward.
    Camera,
    /// The world's.
    World,
}

/// Channels of a spectral film.
#[derive(Clone, Debug, PartialEq)]
pub enum BandsDesc {
    /// Even parts of a range of wavelengths (pbrt's `spectral`): the mean radiance of each.
    Bins {
        /// At least 1.
        count: u32,
        /// From and to, nm, rising.
        range: [f32; 2],
    },
    /// Named responses (Mitsuba 3's `specfilm`): the integral of radiance times response over
    /// wavelengths in nm.
    Responses(Vec<(String, SpectrumDesc)>),
}

/// A reconstruction filter and the radii the file gives.
#[derive(Clone, Debug, PartialEq)]
pub enum FilterChoice {
    /// pbrt: 0.5; Mitsuba: 0.5.
    Box {
        /// Radii in x and y, pixels.
        radius: [f32; 2],
    },
    /// Tent.
    Triangle {
        /// Radii in x and y, pixels.
        radius: [f32; 2],
    },
    /// exp(-x²/2σ²) less its value at the border.
    Gaussian {
        /// Radii in x and y, pixels.
        radius: [f32; 2],
        /// Standard deviation, pixels.
        sigma: f32,
    },
    /// Mitchell & Netravali 1988.
    Mitchell {
        /// Radii in x and y, pixels.
        radius: [f32; 2],
        /// B.
        b: f32,
        /// C.
        c: f32,
    },
    /// Windowed sinc.
    LanczosSinc {
        /// Radii in x and y, pixels.
        radius: [f32; 2],
        /// Lobes of the window.
        tau: f32,
    },
}

/// The method a file asks for. Depths count as pbrt's: 0 emission only, 1 direct light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IntegratorDesc {
    /// Name in the file, as written.
    pub name: String,
    /// Longest path; `None`: no limit.
    pub max_depth: Option<u32>,
    /// Scattering events before Russian roulette starts; `None`: the method's default.
    pub rr_depth: Option<u32>,
    /// True: light sources are not seen directly by the camera.
    pub hide_emitters: bool,
    /// True: light's polarization is tracked and written (Mitsuba's `stokes`).
    pub polarized: bool,
    /// True: strictly geometric-normal consistent paths only (Mitsuba 0.6 `strictNormals`).
    pub strict_normals: bool,
    /// pbrt's lightsampler: uniform, power, bvh; `None`: the default.
    pub light_sampler: Option<String>,
    /// Where it was written.
    pub span: Option<Span>,
}
