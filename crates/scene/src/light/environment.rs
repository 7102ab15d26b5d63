//! Light from everywhere: constant, or an image around the scene.
//!
//! Latitude-longitude images are interpolated between columns periodically and between rows
//! that span pole to pole (row 0 at +y, the last at -y), as Mitsuba does; octahedral ones
//! between texel centres with their borders folded, as pbrt-v4 does. Both are sampled in
//! proportion to luminance: latitude-longitude images to the interpolated luminance times sin θ
//! (again interpolated), octahedral ones to the mean over each texel.

use super::{EmittedRay, LightSample};
use crate::Scene;
use crate::description::EnvironmentLayout;
use crate::texture::{ImageMap, blend, uplift};
use kaustika_math::{INV_PI, Ray, Transform, Vec2, Vec3, safe_acos, warp};
use kaustika_sampling::distribution::{Bilinear2D, PiecewiseConstant2D};
use kaustika_spectra::{CompiledSpectrum, Spectrum, SpectrumRole, Wavelengths};
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
    Image(Box<ImageSource>),
}

#[derive(Debug)]
struct ImageSource {
    image: ImageMap,
    layout: EnvironmentLayout,
    to_world: Transform,
    from_world: Transform,
    distribution: Distribution,
}

/// Densities over the unit square of the layout's parameters.
#[derive(Debug)]
enum Distribution {
    /// Nodes at texel centres; the first column stands at both ends.
    LatLong(Bilinear2D),
    EqualArea(PiecewiseConstant2D),
    /// Black or unusable: directions uniform over the sphere.
    Uniform,
}

impl Environment {
    /// The same radiance from everywhere.
    pub fn constant(radiance: CompiledSpectrum, scale: f32) -> Environment {
        Environment { scale, source: Source::Constant(radiance) }
    }

    /// Radiance from an image; only the rotation of `to_world` matters.
    pub fn image(
        image: ImageMap,
        layout: EnvironmentLayout,
        scale: f32,
        to_world: Transform,
    ) -> Environment {
        let distribution = match layout {
            EnvironmentLayout::LatLong => lat_long_distribution(&image),
            EnvironmentLayout::EqualArea => octahedral_distribution(&image),
        }
        .unwrap_or(Distribution::Uniform);
        let from_world = to_world.inverse();
        let source = ImageSource { image, layout, to_world, from_world, distribution };
        Environment { scale, source: Source::Image(Box::new(source)) }
    }

    /// Multiplies all radiance.
    pub fn rescale(&mut self, k: f32) {
        self.scale *= k;
    }

    /// Luminous illuminance of a surface facing +z of light space (pbrt's upper hemisphere).
    pub fn upper_illuminance(&self) -> f32 {
        const N: usize = 256;
        let lambda = Wavelengths::rgb();
        let Source::Image(image) = &self.source else { return 0.0 };
        let mut sum = 0.0;
        for i in 0..N * N {
            let u = Vec2::new((i % N) as f32 + 0.5, (i / N) as f32 + 0.5) / N as f32;
            let d = warp::cosine_hemisphere(u);
            let rgb = image.radiance(d);
            sum += Spectrum::from_rgb(rgb).luminance(&lambda);
        }
        self.scale * PI * sum / (N * N) as f32
    }

    /// Radiance arriving along a ray of direction `d` that met nothing.
    #[inline]
    pub fn le(&self, d: Vec3, lambda: &Wavelengths) -> Spectrum {
        match &self.source {
            Source::Constant(l) => l.eval(lambda) * self.scale,
            Source::Image(image) => {
                let local = image.from_world.vector(d).normalize();
                uplift(SpectrumRole::Illuminant, image.radiance(local), lambda) * self.scale
            }
        }
    }

    /// Density per solid angle of choosing the direction `wi`.
    #[inline]
    pub fn pdf_w(&self, wi: Vec3) -> f32 {
        match &self.source {
            Source::Constant(_) => warp::UNIFORM_SPHERE_PDF_W,
            Source::Image(image) => image.pdf_w(image.from_world.vector(wi).normalize()),
        }
    }

    /// A direction, its density and the radiance from there.
    fn sample(&self, u: Vec2, lambda: &Wavelengths) -> Option<(Vec3, f32, Spectrum)> {
        let (wi, pdf_w, le) = match &self.source {
            Source::Constant(l) => {
                (warp::uniform_sphere(u), warp::UNIFORM_SPHERE_PDF_W, l.eval(lambda))
            }
            Source::Image(image) => {
                let (d, pdf_w, rgb) = image.sample(u)?;
                let wi = image.to_world.vector(d).normalize();
                (wi, pdf_w, uplift(SpectrumRole::Illuminant, rgb, lambda))
            }
        };
        Some((wi, pdf_w, le * self.scale))
    }

    pub(super) fn sample_li(
        &self,
        scene: &Scene,
        from: Vec3,
        u: Vec2,
        lambda: &Wavelengths,
    ) -> Option<LightSample> {
        let (wi, pdf_w, le) = self.sample(u, lambda)?;
        Some(LightSample {
            wi,
            p: from + wi * (2.0 * scene.radius + (from - scene.center).length()),
            p_error: Vec3::ZERO,
            n: Vec3::ZERO,
            pdf_w,
            le,
            delta: false,
        })
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
        let (from, pdf_w, le) = self.sample(v, lambda)?;
        let w = -from;
        let (s, t) = w.coordinate_system();
        let d = warp::disk(u) * scene.radius;
        let o = scene.center + s * d.x + t * d.y - w * scene.radius;
        let pdf_a = INV_PI / (scene.radius * scene.radius);
        Some(EmittedRay { ray: Ray::new(o, w), le, n: w, pdf_a, pdf_w, cos: 1.0 })
    }

    pub(super) fn pdf_le(&self, scene: &Scene, _: Vec3, _: Vec3, w: Vec3) -> (f32, f32) {
        (INV_PI / (scene.radius * scene.radius), self.pdf_w(-w))
    }

    pub(super) fn power(&self, scene: &Scene, lambda: &Wavelengths) -> Spectrum {
        let disk = PI * scene.radius * scene.radius;
        match &self.source {
            Source::Constant(l) => l.eval(lambda) * (4.0 * PI * disk * self.scale),
            Source::Image(image) => {
                const N: usize = 64;
                let mut sum = Spectrum::ZERO;
                for i in 0..N * N {
                    let u = Vec2::new((i % N) as f32 + 0.5, (i / N) as f32 + 0.5) / N as f32;
                    let rgb = image.radiance(warp::uniform_sphere(u));
                    sum += uplift(SpectrumRole::Illuminant, rgb, lambda);
                }
                sum * (4.0 * PI * disk * self.scale / (N * N) as f32)
            }
        }
    }
}

impl ImageSource {
    /// RGB from the light-space direction `d`, unit.
    fn radiance(&self, d: Vec3) -> [f32; 3] {
        match self.layout {
            EnvironmentLayout::LatLong => {
                lat_long_lookup(&self.image, to_nodes(lat_long_square(d), &self.image))
            }
            EnvironmentLayout::EqualArea => {
                octahedral_lookup(&self.image, warp::equal_area_sphere_to_square(d))
            }
        }
    }

    fn pdf_w(&self, d: Vec3) -> f32 {
        match &self.distribution {
            Distribution::LatLong(nodes) => {
                let sin = (d.x * d.x + d.z * d.z).sqrt();
                if sin <= 0.0 {
                    return 0.0;
                }
                nodes.pdf(to_nodes(lat_long_square(d), &self.image)) / (2.0 * PI * PI * sin)
            }
            Distribution::EqualArea(cells) => {
                cells.pdf(warp::equal_area_sphere_to_square(d)) * warp::UNIFORM_SPHERE_PDF_W
            }
            Distribution::Uniform => warp::UNIFORM_SPHERE_PDF_W,
        }
    }

    /// A light-space direction, its density and the RGB from there. A place of the image is
    /// looked up as it was chosen, not by way of its direction.
    fn sample(&self, u: Vec2) -> Option<(Vec3, f32, [f32; 3])> {
        let (d, pdf_w, rgb) = match &self.distribution {
            Distribution::LatLong(nodes) => {
                let (p, pdf) = nodes.sample(u);
                let rgb = lat_long_lookup(&self.image, p);
                // Nodes are texel centres: shift by half a texel.
                let phi = 2.0 * PI * (p.x + 0.5 / self.image.width as f32);
                let ((st, ct), (sp, cp)) = ((PI * p.y).sin_cos(), phi.sin_cos());
                (Vec3::new(sp * st, ct, -cp * st), pdf / (2.0 * PI * PI * st), rgb)
            }
            Distribution::EqualArea(cells) => {
                let (p, pdf) = cells.sample(u);
                let d = warp::equal_area_square_to_sphere(p);
                (d, pdf * warp::UNIFORM_SPHERE_PDF_W, octahedral_lookup(&self.image, p))
            }
            Distribution::Uniform => {
                let d = warp::uniform_sphere(u);
                (d, warp::UNIFORM_SPHERE_PDF_W, self.radiance(d))
            }
        };
        (pdf_w > 0.0 && pdf_w.is_finite()).then_some((d, pdf_w, rgb))
    }
}

/// (u, v) of a direction: u = atan2(x, -z)/2π in [0,1), v = acos(y)/π.
fn lat_long_square(d: Vec3) -> Vec2 {
    let u = d.x.atan2(-d.z) / (2.0 * PI);
    Vec2::new(u - u.floor(), safe_acos(d.y) * INV_PI)
}

/// The distribution's nodes start at the first texel's centre.
fn to_nodes(uv: Vec2, image: &ImageMap) -> Vec2 {
    let u = uv.x - 0.5 / image.width as f32;
    Vec2::new(u - u.floor(), uv.y)
}

/// RGB at a place given as to the distribution's nodes.
fn lat_long_lookup(image: &ImageMap, p: Vec2) -> [f32; 3] {
    let (w, h) = (image.width, image.height);
    let (x, y) = (p.x * w as f32, p.y * (h - 1) as f32);
    let x0 = (x as u32).min(w - 1);
    let y0 = (y as u32).min(h.saturating_sub(2));
    let x1 = if x0 + 1 < w { x0 + 1 } else { 0 };
    let y1 = (y0 + 1).min(h - 1);
    let corners =
        [image.texel(x0, y0), image.texel(x1, y0), image.texel(x0, y1), image.texel(x1, y1)];
    blend(corners, x - x0 as f32, y - y0 as f32)
}

fn octahedral_lookup(image: &ImageMap, uv: Vec2) -> [f32; 3] {
    let n = [image.width as i64, image.height as i64];
    let (x, y) = (uv.x * n[0] as f32 - 0.5, uv.y * n[1] as f32 - 0.5);
    let at = |dx: i64, dy: i64| {
        let [i, j] = fold(x.floor() as i64 + dx, y.floor() as i64 + dy, n);
        image.texel(i as u32, j as u32)
    };
    blend([at(0, 0), at(1, 0), at(0, 1), at(1, 1)], x - x.floor(), y - y.floor())
}

/// Texels beyond a border of an octahedral map continue where the border is folded: mirrored
/// along the border.
fn fold(mut x: i64, mut y: i64, n: [i64; 2]) -> [i64; 2] {
    if x < 0 {
        x = -1 - x;
        y = n[1] - 1 - y;
    } else if x >= n[0] {
        x = 2 * n[0] - 1 - x;
        y = n[1] - 1 - y;
    }
    if y < 0 {
        x = n[0] - 1 - x;
        y = -1 - y;
    } else if y >= n[1] {
        x = n[0] - 1 - x;
        y = 2 * n[1] - 1 - y;
    }
    [x.clamp(0, n[0] - 1), y.clamp(0, n[1] - 1)]
}

fn luminance(rgb: [f32; 3]) -> f32 {
    Spectrum::from_rgb(rgb).luminance(&Wavelengths::rgb())
}

fn lat_long_distribution(image: &ImageMap) -> Option<Distribution> {
    let (w, h) = (image.width, image.height);
    if h < 2 {
        return None;
    }
    let mut nodes = Vec::with_capacity((w as usize + 1) * h as usize);
    for j in 0..h {
        let sin = (PI * j as f32 / (h - 1) as f32).sin().max(0.0);
        nodes.extend((0..=w).map(|i| sin * luminance(image.texel(i % w, j))));
    }
    Bilinear2D::new(&nodes, w as usize + 1, h as usize).ok().map(Distribution::LatLong)
}

fn octahedral_distribution(image: &ImageMap) -> Option<Distribution> {
    let (w, h) = (image.width, image.height);
    let mut cells = Vec::with_capacity((w * h) as usize);
    for j in 0..h {
        for i in 0..w {
            // A bilinear function's mean over a texel: weights 1/8, 3/4, 1/8 each way.
            let mut sum = 0.0;
            for (dy, wy) in [(-1i64, 0.125), (0, 0.75), (1, 0.125)] {
                for (dx, wx) in [(-1i64, 0.125), (0, 0.75), (1, 0.125)] {
                    let [x, y] = fold(i as i64 + dx, j as i64 + dy, [w as i64, h as i64]);
                    sum += wx * wy * luminance(image.texel(x as u32, y as u32));
                }
            }
            cells.push(sum);
        }
    }
    PiecewiseConstant2D::new(&cells, w as usize, h as usize).ok().map(Distribution::EqualArea)
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
            let light = Environment::image(image(w, h), layout, 2.0, t);
            let n = 700;
            let (mut integral, mut direct, mut sampled) = (0.0f64, 0.0f64, 0.0f64);
            let lambda = Wavelengths::rgb();
            for i in 0..n * n {
                let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                let d = warp::uniform_sphere(u);
                integral += (light.pdf_w(d) * 4.0 * PI) as f64;
                direct += (light.le(d, &lambda).0[0] * 4.0 * PI) as f64;
                if let Some((d, pdf, le)) = light.sample(u, &lambda) {
                    assert!((light.pdf_w(d) / pdf - 1.0).abs() < 2e-2 || pdf < 1e-3, "{u:?}");
                    let found = light.le(d, &lambda).0;
                    assert!((le.0[0] / found[0] - 1.0).abs() < 1e-3, "{u:?} {le:?} {found:?}");
                    sampled += (le.0[0] / pdf) as f64;
                }
            }
            let k = (n * n) as f64;
            assert!((integral / k - 1.0).abs() < 5e-3, "{layout:?} {}", integral / k);
            assert!((sampled / direct - 1.0).abs() < 5e-3, "{layout:?} {}", sampled / direct);
        }
    }

    #[test]
    fn the_picture_has_the_field_s_orientation() {
        // Mitsuba: u = 1/4 looks along +x, u = 1/2 along +z, v = 0 along +y.
        assert!((lat_long_square(Vec3::X) - Vec2::new(0.25, 0.5)).length() < 1e-6);
        assert!((lat_long_square(Vec3::Z) - Vec2::new(0.5, 0.5)).length() < 1e-6);
        assert!(lat_long_square(Vec3::Y).y < 1e-6);
        // Octahedral borders fold onto themselves.
        assert_eq!(fold(-1, 2, [8, 8]), [0, 5]);
        assert_eq!(fold(3, 8, [8, 8]), [4, 7]);
        assert_eq!(fold(-1, -1, [8, 8]), [7, 7]);
    }
}
