//! Light from everywhere: constant, an image around the scene, a clear sky; and the sun.

use super::daylight::Daylight;
use super::portal::Portal;
use super::sky::Sky;
use super::sun::Sun;
use super::{EmittedRay, Escaped, LightSample};
use crate::Scene;
use crate::description::{EnvironmentLayout, SkyDesc};
use crate::texture::{ImageMap, uplift};
use kaustika_math::{INV_PI, Ray, Transform, Vec2, Vec3, warp};
use kaustika_sampling::distribution::TiledSample;
use kaustika_spectra::{ColorMode, CompiledSpectrum, Spectrum, SpectrumRole, Wavelengths};
use std::f32::consts::PI;

/// Light that surrounds the scene.
#[derive(Debug)]
pub struct Environment {
    scale: f32,
    source: Source,
}

#[derive(Debug)]
enum Source {
    Constant(CompiledSpectrum),
    Image(Box<Sky>),
    Daylight(Box<Daylight>),
    Sun(Sun),
    Portal(Box<Portal>),
}

/// Regions of a constant environment along cos θ and φ, of the same solid angle.
const REGIONS: [f32; 2] = [16.0, 32.0];

/// Numbers with which [`warp::uniform_sphere`] gives a direction of a region.
fn in_region(region: u32, u: Vec2) -> Vec2 {
    let columns = REGIONS[1] as u32;
    let (i, j) = ((region / columns) as f32, (region % columns) as f32);
    Vec2::new((i + u.x) / REGIONS[0], (j + u.y) / REGIONS[1])
}

/// The region of a direction: the numbers that [`warp::uniform_sphere`] would have needed.
fn region_of_sphere(d: Vec3) -> u32 {
    let turns = d.y.atan2(d.x) / (2.0 * PI);
    let cell = |u: f32, n: f32| (u * n).clamp(0.0, n - 1.0) as u32;
    let i = cell(0.5 * (1.0 - d.z), REGIONS[0]);
    i * REGIONS[1] as u32 + cell(turns - turns.floor(), REGIONS[1])
}

impl Environment {
    /// The same radiance from everywhere.
    pub fn constant(radiance: CompiledSpectrum, scale: f32) -> Environment {
        Environment { scale, source: Source::Constant(radiance) }
    }

    /// Radiance from an image; only the rotation of `to_world` matters.
    pub fn image(
        image: &ImageMap,
        layout: EnvironmentLayout,
        scale: f32,
        to_world: Transform,
    ) -> Environment {
        Environment { scale, source: Source::Image(Box::new(Sky::new(image, layout, to_world))) }
    }

    /// A clear sky; only the rotation of `to_world` matters.
    pub fn clear_sky(
        desc: &SkyDesc,
        scale: f32,
        to_world: Transform,
        mode: ColorMode,
    ) -> Environment {
        let daylight = Daylight::new(desc, to_world, mode);
        Environment { scale, source: Source::Daylight(Box::new(daylight)) }
    }

    /// A disc about the unit direction `center`, of angular radius `radius`, radians.
    pub fn sun(center: Vec3, radius: f32, radiance: CompiledSpectrum, scale: f32) -> Environment {
        Environment { scale, source: Source::Sun(Sun::new(center, radius, radiance)) }
    }

    /// Radiance from an image that comes in through a rectangle only, by its corners in world space
    /// (see [`Portal::new`]); `None` if they span no area.
    pub fn portal(
        image: &ImageMap,
        layout: EnvironmentLayout,
        scale: f32,
        to_world: Transform,
        corners: [Vec3; 4],
    ) -> Option<Environment> {
        let portal = Portal::new(Sky::new(image, layout, to_world), corners)?;
        Some(Environment { scale, source: Source::Portal(Box::new(portal)) })
    }

    /// Multiplies all radiance.
    pub fn rescale(&mut self, k: f32) {
        self.scale *= k;
    }

    /// Luminous illuminance of a surface facing +z of light space (pbrt's upper hemisphere).
    pub fn upper_illuminance(&self) -> f32 {
        const N: usize = 256;
        let lambda = Wavelengths::rgb();
        let Source::Image(sky) = &self.source else { return 0.0 };
        let mut sum = 0.0;
        for i in 0..N * N {
            let u = Vec2::new((i % N) as f32 + 0.5, (i / N) as f32 + 0.5) / N as f32;
            let d = warp::cosine_hemisphere(u);
            let rgb = sky.radiance(d);
            sum += Spectrum::from_rgb(rgb).luminance(&lambda);
        }
        self.scale * PI * sum / (N * N) as f32
    }

    /// What a ray from `from` along `wi` that met nothing finds.
    #[inline]
    pub fn escaped(&self, from: Vec3, wi: Vec3, lambda: &Wavelengths) -> Escaped {
        let (le, pdf_li, region) = match &self.source {
            Source::Constant(l) => {
                (l.eval(lambda), warp::UNIFORM_SPHERE_PDF_W, region_of_sphere(wi))
            }
            Source::Image(sky) => {
                let (rgb, pdf_w, region) = sky.escaped(wi);
                (uplift(SpectrumRole::Illuminant, rgb, lambda), pdf_w, region)
            }
            Source::Daylight(d) => {
                let (_, pdf_w, region) = d.density.escaped(wi);
                (d.radiance(wi, lambda), pdf_w, region)
            }
            Source::Sun(sun) => match sun.pdf_w(wi) {
                Some(pdf_w) => (sun.radiance.eval(lambda), pdf_w, 0),
                None => (Spectrum::ZERO, 0.0, 0),
            },
            Source::Portal(portal) => match portal.escaped(from, wi) {
                Some((rgb, pdf_w)) => (uplift(SpectrumRole::Illuminant, rgb, lambda), pdf_w, 0),
                None => (Spectrum::ZERO, 0.0, 0),
            },
        };
        Escaped { le: le * self.scale, pdf_li, region }
    }

    /// Columns and rows of regions, parts of the sphere that can be sampled alone; they are
    /// numbered row by row, and the last of a row is beside the first.
    pub fn regions(&self) -> [u32; 2] {
        match &self.source {
            Source::Constant(_) => [REGIONS[1] as u32, REGIONS[0] as u32],
            Source::Image(sky) => sky.regions().map(|n| n as u32),
            Source::Daylight(d) => d.density.regions().map(|n| n as u32),
            Source::Sun(_) | Source::Portal(_) => [1, 1],
        }
    }

    /// Probability of [`Environment::sample_li`] choosing a direction of a region.
    #[inline]
    pub fn region_pmf(&self, region: u32) -> f32 {
        match &self.source {
            Source::Constant(_) => 1.0 / (REGIONS[0] * REGIONS[1]),
            Source::Image(sky) => sky.region_pmf(region),
            Source::Daylight(d) => d.density.region_pmf(region),
            Source::Sun(_) | Source::Portal(_) => 1.0,
        }
    }

    /// A direction from a point, of one region if that is given, its density (within the region)
    /// and the radiance from there.
    fn sample(
        &self,
        from: Vec3,
        region: Option<u32>,
        u: Vec2,
        lambda: &Wavelengths,
    ) -> Option<(Vec3, f32, Spectrum)> {
        let (wi, pdf_w, le) = match &self.source {
            Source::Constant(l) => {
                let (u, pdf_w) = match region {
                    Some(region) => {
                        (in_region(region, u), REGIONS[0] * REGIONS[1] * warp::UNIFORM_SPHERE_PDF_W)
                    }
                    None => (u, warp::UNIFORM_SPHERE_PDF_W),
                };
                (warp::uniform_sphere(u), pdf_w, l.eval(lambda))
            }
            Source::Image(sky) => {
                let (wi, pdf_w, rgb) = sky.sample(region, u)?;
                (wi, pdf_w, uplift(SpectrumRole::Illuminant, rgb, lambda))
            }
            Source::Daylight(d) => {
                let (wi, pdf_w, _) = d.density.sample(region, u)?;
                (wi, pdf_w, d.radiance(wi, lambda))
            }
            Source::Sun(sun) => {
                let (wi, pdf_w) = sun.sample(u);
                (wi, pdf_w, sun.radiance.eval(lambda))
            }
            Source::Portal(portal) => {
                let (wi, pdf_w, rgb) = portal.sample(from, u)?;
                (wi, pdf_w, uplift(SpectrumRole::Illuminant, rgb, lambda))
            }
        };
        Some((wi, pdf_w, le * self.scale))
    }

    pub(super) fn sample_li(
        &self,
        scene: &Scene,
        from: Vec3,
        region: Option<u32>,
        u: Vec2,
        lambda: &Wavelengths,
    ) -> Option<LightSample> {
        let (wi, pdf_w, le) = self.sample(from, region, u, lambda)?;
        Some(self.seen(scene, from, wi, pdf_w, le))
    }

    /// The image that directions are chosen by, for samples that are drawn step by step.
    #[inline]
    pub(super) fn sky(&self) -> Option<&Sky> {
        match &self.source {
            Source::Constant(_) | Source::Sun(_) | Source::Portal(_) => None,
            Source::Image(sky) => Some(sky),
            Source::Daylight(d) => Some(&d.density),
        }
    }

    /// The last step of [`Environment::sample_li`].
    #[inline]
    pub(super) fn sample_li_of_cell(
        &self,
        scene: &Scene,
        from: Vec3,
        cell: &TiledSample,
        lambda: &Wavelengths,
    ) -> Option<LightSample> {
        let (wi, pdf_w, rgb) = self.sky()?.sample_cell(cell)?;
        let le = match &self.source {
            Source::Daylight(d) => d.radiance(wi, lambda),
            _ => uplift(SpectrumRole::Illuminant, rgb, lambda),
        };
        Some(self.seen(scene, from, wi, pdf_w, le * self.scale))
    }

    /// The sample of a direction as a point sees it.
    #[inline]
    fn seen(&self, scene: &Scene, from: Vec3, wi: Vec3, pdf_w: f32, le: Spectrum) -> LightSample {
        LightSample {
            wi,
            p: from + wi * (2.0 * scene.radius + (from - scene.center).length()),
            p_error: Vec3::ZERO,
            n: Vec3::ZERO,
            pdf_w,
            le,
            delta: false,
        }
    }

    /// A ray into the scene: its direction as [`Environment::sample_li`], its origin uniform on
    /// the disk of the scene's radius across it.
    pub(super) fn sample_le(
        &self,
        scene: &Scene,
        u: Vec2,
        v: Vec2,
        lambda: &Wavelengths,
    ) -> Option<EmittedRay> {
        if let Source::Portal(portal) = &self.source {
            let (p, w, pdf_w, rgb) = portal.sample_inward(u, v)?;
            let le = uplift(SpectrumRole::Illuminant, rgb, lambda) * self.scale;
            // From before whatever stands outside.
            let ray = Ray::new(p - w * (2.0 * scene.radius), w);
            let pdf_a = portal.pdf_across(w);
            return Some(EmittedRay { ray, le, n: w, pdf_a, pdf_w, cos: 1.0 });
        }
        let (from, pdf_w, le) = self.sample(scene.center, None, v, lambda)?;
        let w = -from;
        let (s, t) = w.coordinate_system();
        let d = warp::disk(u) * scene.radius;
        let o = scene.center + s * d.x + t * d.y - w * scene.radius;
        let pdf_a = INV_PI / (scene.radius * scene.radius);
        Some(EmittedRay { ray: Ray::new(o, w), le, n: w, pdf_a, pdf_w, cos: 1.0 })
    }

    pub(super) fn pdf_le(&self, scene: &Scene, _: Vec3, _: Vec3, w: Vec3) -> (f32, f32) {
        if let Source::Portal(portal) = &self.source {
            return (portal.pdf_across(w), portal.pdf_inward(w));
        }
        let found = self.escaped(scene.center, -w, &Wavelengths::rgb());
        (INV_PI / (scene.radius * scene.radius), found.pdf_li)
    }

    pub(super) fn power(&self, scene: &Scene, lambda: &Wavelengths) -> Spectrum {
        let disk = PI * scene.radius * scene.radius;
        match &self.source {
            Source::Constant(l) => l.eval(lambda) * (4.0 * PI * disk * self.scale),
            Source::Image(sky) => {
                let mean = uplift(SpectrumRole::Illuminant, sky.mean(), lambda);
                mean * (4.0 * PI * disk * self.scale)
            }
            Source::Daylight(d) => d.mean(lambda) * (4.0 * PI * disk * self.scale),
            Source::Portal(portal) => {
                let e = uplift(SpectrumRole::Illuminant, portal.irradiance(), lambda);
                e * (portal.area() * self.scale)
            }
            Source::Sun(sun) => {
                sun.radiance.eval(lambda) * (sun.share() * 4.0 * PI * disk * self.scale)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(w: u32, h: u32) -> ImageMap {
        let texels = (0..w * h)
            .map(|k| {
                let v = 0.1 + (kaustika_math::mix_bits(k as u64 + 9) % 1000) as f32 / 100.0;
                [v, 0.5 * v, if k == 7 { 300.0 } else { 1.0 }]
            })
            .collect();
        ImageMap { width: w, height: h, texels }
    }

    #[test]
    fn densities_integrate_to_one_and_match_samples() {
        for (layout, w, h) in
            [(EnvironmentLayout::LatLong, 12, 7), (EnvironmentLayout::EqualArea, 9, 9)]
        {
            let t = Transform::rotate(33.0, Vec3::new(1.0, 2.0, 3.0)).unwrap();
            let light = Environment::image(&image(w, h), layout, 2.0, t);
            let n = 700;
            let (mut integral, mut direct, mut sampled) = (0.0f64, 0.0f64, 0.0f64);
            let lambda = Wavelengths::rgb();
            for i in 0..n * n {
                let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                let d = warp::uniform_sphere(u);
                let escaped = light.escaped(Vec3::ZERO, d, &lambda);
                integral += (escaped.pdf_li * 4.0 * PI) as f64;
                direct += (escaped.le.0[0] * 4.0 * PI) as f64;
                if let Some((d, pdf, le)) = light.sample(Vec3::ZERO, None, u, &lambda) {
                    let Escaped { le: found, pdf_li, .. } = light.escaped(Vec3::ZERO, d, &lambda);
                    assert!((pdf_li / pdf - 1.0).abs() < 2e-2 || pdf < 1e-3, "{u:?}");
                    assert!((le.0[0] / found.0[0] - 1.0).abs() < 1e-3, "{u:?} {le:?} {found:?}");
                    sampled += (le.0[0] / pdf) as f64;
                }
            }
            let k = (n * n) as f64;
            assert!((integral / k - 1.0).abs() < 5e-3, "{layout:?} {}", integral / k);
            assert!((sampled / direct - 1.0).abs() < 5e-3, "{layout:?} {}", sampled / direct);
        }
    }
}
