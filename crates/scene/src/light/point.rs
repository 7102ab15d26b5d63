//! Lights without extent: points, cones, parallel light, projected and goniometric ones.

use super::{EmittedRay, LightSample};
use crate::Scene;
use crate::description::{SpotFalloff, TextureId};
use crate::texture::{ImageMap, TexturePoint, uplift};
use kaustika_math::{INV_PI, Ray, Transform, Vec2, Vec3, sqr, warp};
use kaustika_spectra::{CompiledSpectrum, Spectrum, SpectrumRole, Wavelengths};
use std::f32::consts::PI;

/// The same radiant intensity in every direction.
#[derive(Clone, Debug)]
pub struct Point {
    /// Position.
    pub p: Vec3,
    /// Radiant intensity, W/sr.
    pub intensity: CompiledSpectrum,
    /// Multiplies it.
    pub scale: f32,
}

/// A connection to a position: intensity over distance squared.
pub(super) fn toward(
    p: Vec3,
    from: Vec3,
    intensity: impl FnOnce(Vec3) -> Spectrum,
) -> Option<LightSample> {
    let to_light = p - from;
    let d2 = to_light.length_squared();
    let wi = to_light.try_normalize()?;
    Some(LightSample {
        wi,
        p,
        p_error: Vec3::ZERO,
        n: Vec3::ZERO,
        pdf_w: 1.0,
        le: intensity(-wi) / d2,
        delta: true,
    })
}

pub(super) fn emitted(p: Vec3, w: Vec3, pdf_w: f32, le: Spectrum) -> EmittedRay {
    EmittedRay { ray: Ray::new(p, w), le, n: w, pdf_a: 1.0, pdf_w, cos: 1.0 }
}

impl Point {
    pub(super) fn sample_li(
        &self,
        _: &Scene,
        from: Vec3,
        _: Vec2,
        lambda: &Wavelengths,
    ) -> Option<LightSample> {
        toward(self.p, from, |_| self.intensity.eval(lambda) * self.scale)
    }

    pub(super) fn sample_le(
        &self,
        _: &Scene,
        _: Vec2,
        v: Vec2,
        lambda: &Wavelengths,
    ) -> Option<EmittedRay> {
        let le = self.intensity.eval(lambda) * self.scale;
        Some(emitted(self.p, warp::uniform_sphere(v), warp::UNIFORM_SPHERE_PDF_W, le))
    }

    pub(super) fn pdf_le(&self, _: &Scene, _: Vec3, _: Vec3, _: Vec3) -> (f32, f32) {
        (0.0, warp::UNIFORM_SPHERE_PDF_W)
    }

    pub(super) fn power(&self, _: &Scene, lambda: &Wavelengths) -> Spectrum {
        self.intensity.eval(lambda) * (4.0 * PI * self.scale)
    }
}

/// A cone of light with a soft border, optionally with a slide in it.
#[derive(Clone, Debug)]
pub struct Spot {
    /// Light to world; the axis is +z.
    pub to_world: Transform,
    /// Radiant intensity on the axis, W/sr.
    pub intensity: CompiledSpectrum,
    /// Multiplies it.
    pub scale: f32,
    /// Half-angle of the cone, radians.
    pub cutoff: f32,
    /// Half-angle without falloff, radians.
    pub beam_width: f32,
    /// Shape of the falloff.
    pub falloff: SpotFalloff,
    /// Slide over the square that bounds the cone.
    pub texture: Option<TextureId>,
}

impl Spot {
    /// Fraction of the intensity at cos θ from the axis.
    fn smooth(&self, cos: f32) -> f32 {
        let (cos_cut, cos_beam) = (self.cutoff.cos(), self.beam_width.cos());
        if cos <= cos_cut {
            return 0.0;
        }
        if cos >= cos_beam {
            return 1.0;
        }
        match self.falloff {
            SpotFalloff::LinearAngle => {
                (self.cutoff - cos.acos()) / (self.cutoff - self.beam_width)
            }
            SpotFalloff::SmoothstepCosine => {
                let t = (cos - cos_cut) / (cos_beam - cos_cut);
                t * t * (3.0 - 2.0 * t)
            }
            SpotFalloff::SquaredLinearCosine => sqr((cos - cos_cut) / (cos_beam - cos_cut)),
        }
    }

    /// Radiant intensity along the world direction `w`.
    fn along(&self, scene: &Scene, w: Vec3, lambda: &Wavelengths) -> Spectrum {
        let d = self.to_world.inverse().vector(w).normalize();
        let f = self.smooth(d.z);
        if f <= 0.0 {
            return Spectrum::ZERO;
        }
        let i = self.intensity.eval(lambda) * (self.scale * f);
        match self.texture {
            Some(texture) => {
                let k = 0.5 / (d.z * self.cutoff.tan());
                let uv = Vec2::new(0.5 + k * d.x, 0.5 + k * d.y);
                i * scene.textures.spectrum(texture, &slide_point(uv), lambda)
            }
            None => i,
        }
    }

    pub(super) fn sample_li(
        &self,
        scene: &Scene,
        from: Vec3,
        _: Vec2,
        lambda: &Wavelengths,
    ) -> Option<LightSample> {
        let p = self.to_world.point(Vec3::ZERO);
        toward(p, from, |w| self.along(scene, w, lambda)).filter(|s| !s.le.is_black())
    }

    pub(super) fn sample_le(
        &self,
        scene: &Scene,
        _: Vec2,
        v: Vec2,
        lambda: &Wavelengths,
    ) -> Option<EmittedRay> {
        let one_minus_cos = 1.0 - self.cutoff.cos();
        let w = self.to_world.vector(warp::uniform_cone(v, one_minus_cos)).normalize();
        let pdf_w = warp::uniform_cone_pdf_w(one_minus_cos);
        let le = self.along(scene, w, lambda);
        Some(emitted(self.to_world.point(Vec3::ZERO), w, pdf_w, le))
    }

    pub(super) fn pdf_le(&self, _: &Scene, _: Vec3, _: Vec3, w: Vec3) -> (f32, f32) {
        let d = self.to_world.inverse().vector(w).normalize();
        let inside = d.z > self.cutoff.cos();
        (0.0, if inside { warp::uniform_cone_pdf_w(1.0 - self.cutoff.cos()) } else { 0.0 })
    }

    pub(super) fn power(&self, scene: &Scene, lambda: &Wavelengths) -> Spectrum {
        if self.texture.is_none() {
            return self.intensity.eval(lambda) * (self.scale * self.solid_angle());
        }
        // Through a slide, by the midpoint rule over the cone.
        const N: usize = 32;
        let one_minus_cos = 1.0 - self.cutoff.cos();
        let mut sum = Spectrum::ZERO;
        for i in 0..N * N {
            let u = Vec2::new((i % N) as f32 + 0.5, (i / N) as f32 + 0.5) / N as f32;
            let w = self.to_world.vector(warp::uniform_cone(u, one_minus_cos));
            sum += self.along(scene, w, lambda);
        }
        sum / (warp::uniform_cone_pdf_w(one_minus_cos) * (N * N) as f32)
    }

    /// ∫ falloff dω. With c cutoff, b beam width:
    ///
    /// ```text
    /// ∫ (c - θ)/(c - b) sin θ dθ over [b, c] = cos b - (sin c - sin b)/(c - b)
    /// ```
    ///
    /// and the smoothstep has the mean ½ over its range of cosines, the square ⅓.
    pub fn solid_angle(&self) -> f32 {
        let (cut, beam) = (self.cutoff.cos(), self.beam_width.cos());
        let width = self.cutoff - self.beam_width;
        let border = match self.falloff {
            SpotFalloff::LinearAngle if width > 1e-3 => {
                beam - (self.cutoff.sin() - self.beam_width.sin()) / width
            }
            SpotFalloff::SquaredLinearCosine => (beam - cut) / 3.0,
            _ => 0.5 * (beam - cut),
        };
        2.0 * PI * ((1.0 - beam) + border)
    }
}

pub(super) fn slide_point(uv: Vec2) -> TexturePoint {
    TexturePoint {
        p: Vec3::ZERO,
        n: Vec3::Z,
        uv,
        uv_width: 0.0,
        triangle: u32::MAX,
        barycentrics: Vec2::ZERO,
    }
}

/// Parallel light, as from the sun.
#[derive(Clone, Debug)]
pub struct Directional {
    /// Unit direction in which the light travels.
    pub direction: Vec3,
    /// Irradiance on a surface facing it, W/m².
    pub irradiance: CompiledSpectrum,
    /// Multiplies it.
    pub scale: f32,
}

impl Directional {
    pub(super) fn sample_li(
        &self,
        scene: &Scene,
        from: Vec3,
        _: Vec2,
        lambda: &Wavelengths,
    ) -> Option<LightSample> {
        Some(LightSample {
            wi: -self.direction,
            p: from - self.direction * (2.0 * scene.radius + (from - scene.center).length()),
            p_error: Vec3::ZERO,
            n: Vec3::ZERO,
            pdf_w: 1.0,
            le: self.irradiance.eval(lambda) * self.scale,
            delta: true,
        })
    }

    pub(super) fn sample_le(
        &self,
        scene: &Scene,
        u: Vec2,
        _: Vec2,
        lambda: &Wavelengths,
    ) -> Option<EmittedRay> {
        let (s, t) = self.direction.coordinate_system();
        let d = warp::disk(u) * scene.radius;
        let o = scene.center + s * d.x + t * d.y - self.direction * scene.radius;
        Some(EmittedRay {
            ray: Ray::new(o, self.direction),
            le: self.irradiance.eval(lambda) * self.scale,
            n: self.direction,
            pdf_a: INV_PI / (scene.radius * scene.radius),
            pdf_w: 1.0,
            cos: 1.0,
        })
    }

    pub(super) fn pdf_le(&self, scene: &Scene, _: Vec3, _: Vec3, _: Vec3) -> (f32, f32) {
        (INV_PI / (scene.radius * scene.radius), 0.0)
    }

    pub(super) fn power(&self, scene: &Scene, lambda: &Wavelengths) -> Spectrum {
        self.irradiance.eval(lambda) * (self.scale * PI * scene.radius * scene.radius)
    }
}

/// A picture thrown along +z.
#[derive(Debug)]
pub struct Projection {
    /// Light to world.
    pub to_world: Transform,
    /// The picture: radiant intensity at the middle of each pixel's direction.
    pub image: ImageMap,
    /// tan of half the horizontal field of view.
    pub tan_x: f32,
    /// tan of half the vertical field of view.
    pub tan_y: f32,
    /// Multiplies it.
    pub scale: f32,
}

impl Projection {
    fn along(&self, w: Vec3, lambda: &Wavelengths) -> Spectrum {
        let d = self.to_world.inverse().vector(w).normalize();
        if d.z <= 0.0 {
            return Spectrum::ZERO;
        }
        let (x, y) = (d.x / (d.z * self.tan_x), d.y / (d.z * self.tan_y));
        if x.abs() > 1.0 || y.abs() > 1.0 {
            return Spectrum::ZERO;
        }
        let rgb = self.image.bilinear(Vec2::new(0.5 * (x + 1.0), 0.5 * (1.0 - y)));
        uplift(SpectrumRole::Illuminant, rgb, lambda) * self.scale
    }

    pub(super) fn sample_li(
        &self,
        _: &Scene,
        from: Vec3,
        _: Vec2,
        lambda: &Wavelengths,
    ) -> Option<LightSample> {
        let p = self.to_world.point(Vec3::ZERO);
        toward(p, from, |w| self.along(w, lambda)).filter(|s| !s.le.is_black())
    }

    /// Uniform over the picture's plane z = 1.
    pub(super) fn sample_le(
        &self,
        _: &Scene,
        _: Vec2,
        v: Vec2,
        lambda: &Wavelengths,
    ) -> Option<EmittedRay> {
        let d = Vec3::new((2.0 * v.x - 1.0) * self.tan_x, (2.0 * v.y - 1.0) * self.tan_y, 1.0);
        let cos = 1.0 / d.length();
        let w = self.to_world.vector(d).normalize();
        let pdf_w = 1.0 / (4.0 * self.tan_x * self.tan_y * cos * cos * cos);
        Some(emitted(self.to_world.point(Vec3::ZERO), w, pdf_w, self.along(w, lambda)))
    }

    pub(super) fn pdf_le(&self, _: &Scene, _: Vec3, _: Vec3, w: Vec3) -> (f32, f32) {
        let d = self.to_world.inverse().vector(w).normalize();
        let inside =
            d.z > 0.0 && (d.x / d.z).abs() <= self.tan_x && (d.y / d.z).abs() <= self.tan_y;
        let pdf_w = 1.0 / (4.0 * self.tan_x * self.tan_y * d.z * d.z * d.z);
        (0.0, if inside { pdf_w } else { 0.0 })
    }

    pub(super) fn power(&self, _: &Scene, lambda: &Wavelengths) -> Spectrum {
        self.integrate(|w| self.along(w, lambda))
    }

    /// Luminous flux at scale 1.
    pub(super) fn mean_intensity_integral(&self) -> f32 {
        let lambda = Wavelengths::rgb();
        self.integrate(|w| self.along(w, &lambda)).luminance(&lambda) / self.scale
    }

    /// ∫ f dω over the picture, by the midpoint rule.
    fn integrate(&self, f: impl Fn(Vec3) -> Spectrum) -> Spectrum {
        const N: usize = 32;
        let mut sum = Spectrum::ZERO;
        for i in 0..N * N {
            let at = |k: usize| 2.0 * (k as f32 + 0.5) / N as f32 - 1.0;
            let d = Vec3::new(at(i % N) * self.tan_x, at(i / N) * self.tan_y, 1.0);
            let cos = 1.0 / d.length();
            sum += f(self.to_world.vector(d)) * (cos * cos * cos);
        }
        sum * (4.0 * self.tan_x * self.tan_y / (N * N) as f32)
    }
}

/// A point light whose intensity is painted on the sphere (equal-area octahedral, +z up).
#[derive(Debug)]
pub struct Goniometric {
    /// Light to world.
    pub to_world: Transform,
    /// Base intensity, W/sr.
    pub intensity: CompiledSpectrum,
    /// Factor over directions.
    pub image: ImageMap,
    /// Multiplies it.
    pub scale: f32,
}

impl Goniometric {
    fn along(&self, w: Vec3, lambda: &Wavelengths) -> Spectrum {
        let d = self.to_world.inverse().vector(w).normalize();
        let [r, g, b] = self.image.bilinear(warp::equal_area_sphere_to_square(d));
        self.intensity.eval(lambda) * (self.scale * (r + g + b) / 3.0)
    }

    pub(super) fn sample_li(
        &self,
        _: &Scene,
        from: Vec3,
        _: Vec2,
        lambda: &Wavelengths,
    ) -> Option<LightSample> {
        toward(self.to_world.point(Vec3::ZERO), from, |w| self.along(w, lambda))
    }

    pub(super) fn sample_le(
        &self,
        _: &Scene,
        _: Vec2,
        v: Vec2,
        lambda: &Wavelengths,
    ) -> Option<EmittedRay> {
        let w = warp::uniform_sphere(v);
        let p = self.to_world.point(Vec3::ZERO);
        Some(emitted(p, w, warp::UNIFORM_SPHERE_PDF_W, self.along(w, lambda)))
    }

    pub(super) fn pdf_le(&self, _: &Scene, _: Vec3, _: Vec3, _: Vec3) -> (f32, f32) {
        (0.0, warp::UNIFORM_SPHERE_PDF_W)
    }

    pub(super) fn power(&self, _: &Scene, lambda: &Wavelengths) -> Spectrum {
        self.intensity.eval(lambda) * (4.0 * PI * self.scale * self.image.mean())
    }
}
