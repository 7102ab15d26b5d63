//! `timed_sunsky` of Mitsuba 3: the sun and the sky of some hours of each of some days, as long as
//! the shutter is open.
//!
//! A picture is the mean over that time, so that the light is one image around the scene:
//!
//! ```text
//! L = ∫ sky(sun(t)) dt / T,   E = ∫ Ω sun(t) dt / T                                        (1)
//! ```
//!
//! by the midpoint rule; E, light of the solid angle Ω of the sun's disc, is spread over the four
//! texels around it. The image is RGB, in spectral mode a smooth spectrum texel by texel.

use super::convert::Converter;
use super::daylight::{APERTURE, toward_sun};
use super::document::{Kind, Object};
use super::sun_position::Moment;
use kaustika_math::{Transform, Vec3, safe_acos};
use kaustika_scene::description::{
    Bitmap, Encoding, EnvironmentLayout, LightKind, SkyDesc, Texels,
};
use kaustika_spectra::{
    ColorMode, ColorSpace, CompiledSpectrum, HosekSky, SpectrumRole, Wavelengths, hosek_sun,
};
use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

/// Columns and rows of the image; its middle row is the horizon.
const SIZE: [usize; 2] = [1024, 513];
/// Times at which the sky is taken, and the sun.
const SKIES: usize = 256;
const SUNS: usize = 100_000;
/// Steps of the sun's elevation at which its radiance is known.
const ELEVATIONS: usize = 512;

/// The time that passes.
#[derive(Debug)]
pub(super) struct Course {
    /// Midnight of the first day.
    first: Moment,
    /// How many there are.
    days: i64,
    /// Hours of each day.
    window: [f64; 2],
    /// The part of all that while the shutter is open.
    part: [f64; 2],
}

impl<'a> Converter<'a> {
    /// When a `timed_sunsky` shines; `None`, with a message, where that is never.
    pub(super) fn course(&mut self, object: &'a Object) -> Option<Course> {
        let [latitude, longitude, timezone] =
            [("latitude", 35.6894), ("longitude", 139.6917), ("timezone", 9.0)]
                .map(|(name, default)| f64::from(self.number(object, name, default)));
        let window = [("window_start_time", 7.0), ("window_end_time", 19.0)]
            .map(|(name, default)| f64::from(self.number(object, name, default)));
        if !(0.0 <= window[0] && window[0] <= window[1] && window[1] <= 24.0) {
            let message = "the hours must rise, and lie between 0 and 24";
            self.out.diagnostics.error(object.span, message);
            return None;
        }
        let mut date = |names: [&'static str; 3], default: [i64; 3]| {
            let mut number = |i: usize| self.integer(object, names[i]).unwrap_or(default[i]);
            let (year, month, day) = (number(0), number(1), number(2));
            // Years in which the formula means something; far ones would overflow.
            let year = year.clamp(-4000, 10_000);
            let (month, day) = (month.clamp(1, 12), day.clamp(1, 31));
            Moment { latitude, longitude, timezone, year, month, day, hour: 0.0 }
        };
        let first = date(["start_year", "start_month", "start_day"], [2025, 1, 1]);
        let end =
            date(["end_year", "end_month", "end_day"], [first.year + 1, first.month, first.day]);
        let days = (end.days(0.0) - first.days(0.0)) as i64;
        if days < 1 {
            self.out.diagnostics.error(object.span, "the days end before they begin");
            return None;
        }
        let own = ["shutter_open", "shutter_close"].map(|name| self.optional_number(object, name));
        let own = [own[0].unwrap_or(0.0), own[1].unwrap_or(1.0)];
        if own[1] <= own[0] {
            self.out.diagnostics.error(object.span, "the shutter closes before it opens");
            return None;
        }
        let sensor = self.document.objects.iter().find(|o| o.kind == Kind::Sensor);
        let part = ["shutter_open", "shutter_close"].map(|name| {
            let time = sensor.and_then(|s| self.optional_number(s, name)).unwrap_or(0.0);
            f64::from(((time - own[0]) / (own[1] - own[0])).clamp(0.0, 1.0))
        });
        Some(Course { first, days, window, part })
    }
}

impl Course {
    /// True if no time passes.
    pub(super) fn is_moment(&self) -> bool {
        self.part[0] >= self.part[1]
    }

    /// The direction to the sun in light space when the share `t` of the time has passed.
    pub(super) fn sun(&self, t: f64) -> Vec3 {
        let whole = self.days as f64;
        let day = (self.part[0] + (self.part[1] - self.part[0]) * t) * whole;
        let day = day.min(whole * (1.0 - 1e-9));
        let [from, to] = self.window;
        let hour = from + (to - from) * day.fract();
        toward_sun(&Moment { day: self.first.day + day as i64, hour, ..self.first }, false)
    }

    /// (1): the light and its place.
    pub(super) fn mean(
        &self,
        sky: &SkyDesc,
        [sky_scale, sun_scale]: [f32; 2],
        to_world: Transform,
    ) -> (LightKind, Transform) {
        let mut texels = vec![[0f32; 3]; SIZE[0] * SIZE[1]];
        if sky_scale > 0.0 {
            self.add_skies(sky, sky_scale, &mut texels);
        }
        if sun_scale > 0.0 {
            self.add_suns(sky.turbidity, sun_scale, &mut texels);
        }
        let bitmap = Bitmap {
            width: SIZE[0] as u32,
            height: SIZE[1] as u32,
            channels: 3,
            texels: Texels::F32(texels.into_iter().flatten().collect()),
            encoding: Encoding::Linear,
        };
        let kind = LightKind::Image {
            bitmap: Arc::new(bitmap),
            space: ColorSpace::Srgb,
            layout: EnvironmentLayout::LatLong,
            scale: 1.0,
            illuminance: None,
        };
        (kind, to_world * y_up())
    }

    /// Mean radiance of the sky; every fourth texel along each axis is computed, the others are
    /// interpolated.
    fn add_skies(&self, desc: &SkyDesc, scale: f32, texels: &mut [[f32; 3]]) {
        const STEP: usize = 4;
        let [w, rows] = [SIZE[0] / STEP, SIZE[1] / (2 * STEP) + 1];
        let lambda = Wavelengths::rgb();
        let mut coarse = vec![[0f32; 3]; w * rows];
        for k in 0..SKIES {
            let sun = self.sun((k as f64 + 0.5) / SKIES as f64);
            if sun.z < 0.0 {
                continue;
            }
            let elevation = FRAC_PI_2 - safe_acos(sun.z);
            let sky = HosekSky::new(desc.turbidity, &desc.albedo, elevation, ColorMode::Rgb);
            for (i, texel) in coarse.iter_mut().enumerate() {
                let d = direction((i % w * STEP) as f32, (i / w * STEP) as f32);
                let l = sky.radiance(d.z.max(0.0), d.dot(sun), &lambda).rgb();
                (0..3).for_each(|c| texel[c] += l[c] * scale / SKIES as f32);
            }
        }
        for y in 0..=SIZE[1] / 2 {
            for x in 0..SIZE[0] {
                let (i, j) = (x / STEP, (y / STEP).min(rows - 2));
                let (s, t) = ((x % STEP) as f32, (y - j * STEP) as f32);
                let (s, t) = (s / STEP as f32, t / STEP as f32);
                let at = |i: usize, j: usize, c: usize| coarse[j * w + i % w][c];
                for (c, v) in texels[y * SIZE[0] + x].iter_mut().enumerate() {
                    let low = at(i, j, c) * (1.0 - s) + at(i + 1, j, c) * s;
                    let high = at(i, j + 1, c) * (1.0 - s) + at(i + 1, j + 1, c) * s;
                    *v += low * (1.0 - t) + high * t;
                }
            }
        }
    }

    /// Mean light of the sun.
    fn add_suns(&self, turbidity: f32, scale: f32, texels: &mut [[f32; 3]]) {
        let radius = (0.5 * APERTURE).to_radians();
        let solid_angle = 4.0 * PI * (0.5 * radius).sin().powi(2);
        let of_elevation: Vec<[f32; 3]> = (0..ELEVATIONS)
            .map(|i| {
                let elevation = FRAC_PI_2 * i as f32 / (ELEVATIONS - 1) as f32;
                let desc = hosek_sun(turbidity, elevation, radius);
                let light = CompiledSpectrum::new(&desc, SpectrumRole::Illuminant, ColorMode::Rgb);
                light.eval(&Wavelengths::rgb()).rgb()
            })
            .collect();
        let step = PI / (SIZE[1] - 1) as f32;
        for k in 0..SUNS {
            let sun = self.sun((k as f64 + 0.5) / SUNS as f64);
            if sun.z < 0.0 {
                continue;
            }
            let theta = safe_acos(sun.z);
            let e = (FRAC_PI_2 - theta) / FRAC_PI_2 * (ELEVATIONS - 1) as f32;
            let radiance = of_elevation[(e.round() as usize).min(ELEVATIONS - 1)];
            // Not at the pole itself, whose row has no width.
            let y = (theta / step).clamp(1.0, (SIZE[1] / 2) as f32);
            let x = sun.x.atan2(sun.y) / (2.0 * PI) * SIZE[0] as f32 - 0.5;
            let (i, j) = (x.floor(), (y as usize).min(SIZE[1] / 2 - 1));
            let (s, t) = (x - i, y - j as f32);
            let column = |i: f32| i.rem_euclid(SIZE[0] as f32) as usize % SIZE[0];
            for (row, share) in [(j, 1.0 - t), (j + 1, t)] {
                // ∫ of a texel's hat over its row, as images are interpolated.
                let size = 2.0 * PI / SIZE[0] as f32
                    * 2.0
                    * (step * row as f32).sin()
                    * (1.0 - step.cos())
                    / step;
                let light = scale * solid_angle * share / (size * SUNS as f32);
                for (column, share) in [(column(i), 1.0 - s), (column(i + 1.0), s)] {
                    let texel = &mut texels[row * SIZE[0] + column];
                    (0..3).for_each(|c| texel[c] += radiance[c] * light * share);
                }
            }
        }
    }
}

/// The direction of a texel in light space, +z up.
fn direction(x: f32, y: f32) -> Vec3 {
    let phi = 2.0 * PI * (x + 0.5) / SIZE[0] as f32;
    let (sin, cos) = (PI * y / (SIZE[1] - 1) as f32).sin_cos();
    Vec3::new(sin * phi.sin(), sin * phi.cos(), cos)
}

/// From the image's space, +y up, φ from -z toward +x, to light space, +z up, φ from +y toward +x.
fn y_up() -> Transform {
    let rows =
        [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    Transform::from_rows(rows).unwrap_or(Transform::IDENTITY)
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_spectra::SpectrumDesc;

    fn course(days: i64, window: [f64; 2], part: [f64; 2]) -> Course {
        let (latitude, longitude, timezone) = (35.6894, 139.6917, 9.0);
        let (year, month, day) = (2025, 6, 1);
        let first = Moment { latitude, longitude, timezone, year, month, day, hour: 0.0 };
        Course { first, days, window, part }
    }

    /// The irradiance of the ground, by quadrature over the image and over time.
    #[test]
    fn light_is_the_mean_over_time() {
        let course = course(20, [5.0, 12.0], [0.25, 1.0]);
        let albedo = SpectrumDesc::Constant(0.3);
        let desc = SkyDesc { turbidity: 3.0, albedo, sun: Vec3::Z, stretch: 1.0, extend: false };
        for scales in [[1.0, 0.0], [0.0, 1.0]] {
            let (LightKind::Image { bitmap, .. }, _) =
                course.mean(&desc, scales, Transform::IDENTITY)
            else {
                panic!("not an image")
            };
            let Texels::F32(values) = &bitmap.texels else { panic!("not floats") };
            let step = PI / (SIZE[1] - 1) as f32;
            let mut found = 0.0;
            for y in 0..=SIZE[1] / 2 {
                let theta = step * y as f32;
                let size = 2.0 * PI / SIZE[0] as f32 * step * theta.sin();
                let row = &values[3 * y * SIZE[0]..3 * (y + 1) * SIZE[0]];
                let green: f32 = row.chunks(3).map(|c| c[1]).sum();
                found += green * size * theta.cos();
            }
            let mut expected = 0.0;
            const TIMES: usize = 700;
            let lambda = Wavelengths::rgb();
            for k in 0..TIMES {
                let sun = course.sun((k as f64 + 0.5) / TIMES as f64);
                if sun.z <= 0.0 {
                    continue;
                }
                let elevation = sun.z.asin();
                let radius = (0.5 * APERTURE).to_radians();
                let sun_light = CompiledSpectrum::new(
                    &hosek_sun(3.0, elevation, radius),
                    SpectrumRole::Illuminant,
                    ColorMode::Rgb,
                );
                let of_sun = sun_light.eval(&lambda).rgb()[1] * PI * radius.sin().powi(2) * sun.z;
                let sky = HosekSky::new(3.0, &desc.albedo, elevation, ColorMode::Rgb);
                let mut of_sky = 0.0;
                const N: usize = 24;
                for i in 0..N * 2 * N {
                    // Uniform in the area of the disc below: dω cos θ.
                    let r2 = ((i % N) as f32 + 0.5) / N as f32;
                    let phi = PI * ((i / N) as f32 + 0.5) / N as f32;
                    let d =
                        Vec3::new(r2.sqrt() * phi.cos(), r2.sqrt() * phi.sin(), (1.0 - r2).sqrt());
                    of_sky += sky.radiance(d.z, d.dot(sun), &lambda).rgb()[1] * PI;
                }
                of_sky /= (2 * N * N) as f32;
                expected += (scales[0] * of_sky + scales[1] * of_sun) / TIMES as f32;
            }
            assert!((found / expected - 1.0).abs() < 0.01, "{scales:?}: {found} {expected}");
        }
    }

    #[test]
    fn days_and_hours_pass() {
        let course = course(10, [6.0, 18.0], [0.0, 1.0]);
        // Noon of the first day and of the last: the sun is highest, and in June climbs a little.
        let [first, last] = [0.05, 0.95].map(|t| course.sun(t));
        assert!(first.z > 0.95 && last.z > first.z, "{first:?} {last:?}");
        // The beginning of a day is its morning, its end the evening: from east to west, and x is
        // north.
        let [dawn, dusk] = [0.1001, 0.1999].map(|t| course.sun(t));
        assert!(dawn.y * dusk.y < 0.0 && dawn.z < 0.4 && dusk.z < 0.4, "{dawn:?} {dusk:?}");
    }
}
