//! A clear sky by its formula ([`HosekSky`]).
//!
//! Radiance is that of the formula at the path's wavelengths, in either colour mode; an image of
//! its luminance serves to choose directions, and the horizon lies between two rows of it, so
//! that next to none are chosen below.
//!
//! ```text
//! θ' = θ / stretch                                                                        (1)
//! below the horizon: L(θ' = π/2) s(2 - 2θ/π),  s(t) = 3t² - 2t³                            (2)
//! ```
//!
//! (1) and (2) are what Mitsuba 0.6 does to skies of scenes that need some light from below.

use super::sky::Sky;
use crate::description::{EnvironmentLayout, SkyDesc};
use crate::texture::ImageMap;
use kaustika_math::{Transform, Vec2, Vec3, safe_acos, warp};
use kaustika_spectra::{ColorMode, HosekSky, Spectrum, Wavelengths};
use std::f32::consts::{FRAC_PI_2, PI};

/// Columns and rows of cells of the image that directions are chosen by.
const CELLS: [u32; 2] = [512, 256];

/// Radiance of a clear sky, the sun aside.
#[derive(Debug)]
pub(super) struct Daylight {
    pub density: Sky,
    model: Model,
    from_world: Transform,
}

/// What a direction of light space is asked of.
#[derive(Debug)]
struct Model {
    sky: HosekSky,
    /// Unit, light space.
    sun: Vec3,
    stretch: f32,
    extend: bool,
}

impl Daylight {
    /// With +z of light space straight above; only the rotation of `to_world` matters.
    pub fn new(desc: &SkyDesc, to_world: Transform, mode: ColorMode) -> Daylight {
        let sun = desc.sun.try_normalize().unwrap_or(Vec3::Z);
        let elevation = FRAC_PI_2 - safe_acos(sun.z);
        let sky = |mode| HosekSky::new(desc.turbidity, &desc.albedo, elevation, mode);
        let model =
            |mode| Model { sky: sky(mode), sun, stretch: desc.stretch, extend: desc.extend };
        let density = Sky::new(
            &model(ColorMode::Rgb).luminance_image(),
            EnvironmentLayout::LatLong,
            to_world * z_to_y(),
        );
        Daylight { density, model: model(mode), from_world: to_world.inverse() }
    }

    /// Radiance along a ray that left the scene along `wi`.
    #[inline]
    pub fn radiance(&self, wi: Vec3, lambda: &Wavelengths) -> Spectrum {
        self.model.radiance(self.from_world.vector(wi).normalize(), lambda)
    }

    /// Mean radiance over the sphere, by the midpoint rule.
    pub fn mean(&self, lambda: &Wavelengths) -> Spectrum {
        const N: usize = 32;
        let mut sum = Spectrum::ZERO;
        for k in 0..N * 2 * N {
            let u = Vec2::new((k % N) as f32 + 0.5, (k / N) as f32 * 0.5 + 0.25) / N as f32;
            sum += self.model.radiance(warp::uniform_sphere(u), lambda);
        }
        sum / (2 * N * N) as f32
    }
}

impl Model {
    fn radiance(&self, d: Vec3, lambda: &Wavelengths) -> Spectrum {
        if self.stretch == 1.0 && !self.extend {
            return match d.z >= 0.0 {
                true => self.sky.radiance(d.z, d.dot(self.sun), lambda),
                false => Spectrum::ZERO,
            };
        }
        let theta = safe_acos(d.z);
        let stretched = theta / self.stretch; // (1)
        if stretched > FRAC_PI_2 && !self.extend {
            return Spectrum::ZERO;
        }
        let (sin, cos) = stretched.min(FRAC_PI_2).sin_cos();
        let around = Vec3::new(d.x, d.y, 0.0).try_normalize().unwrap_or(Vec3::X);
        let seen = around * sin + Vec3::Z * cos.max(0.0);
        let t = (2.0 - 2.0 * theta / PI).clamp(0.0, 1.0);
        let fade = if self.extend { t * t * (3.0 - 2.0 * t) } else { 1.0 }; // (2)
        self.sky.radiance(seen.z, seen.dot(self.sun), lambda) * fade
    }

    /// Luminance by latitude and longitude, +y up; the row between the halves is of the sky.
    fn luminance_image(&self) -> ImageMap {
        let lambda = Wavelengths::rgb();
        let [width, rows] = CELLS;
        let height = rows + 1;
        let texel = |x: u32, y: u32| {
            let theta = PI * y as f32 / rows as f32;
            let phi = 2.0 * PI * (x as f32 + 0.5) / width as f32;
            let z = if 2 * y == rows { 0.0 } else { theta.cos() };
            let d = Vec3::new(theta.sin() * phi.sin(), theta.sin() * phi.cos(), z);
            [self.radiance(d, &lambda).luminance(&lambda).max(0.0); 3]
        };
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| texel(x, y))).collect();
        ImageMap { width, height, texels }
    }
}

/// From the image's space, +y up, φ from -z toward +x, to light space, +z up, φ from +y toward +x.
fn z_to_y() -> Transform {
    let rows =
        [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    Transform::from_rows(rows).unwrap_or(Transform::IDENTITY)
}
