//! What a pixel sees of the solution.
//!
//! ```text
//! L = Lₑ + L_d + f_D(ωₒ,ωᵢ) H(x),   ωᵢ by its cosine                                (1)
//! L_d ≈ f_D |cos| Lₑ V / p                                                          (2)
//! L ≈ Lₑ + L_d + π/n Σ f_D(ωₒ,ωᵢ) (ρ H)(y_i)/π                                      (3)
//! ```
//!
//! (1) reads the irradiance H between vertices or of the patch; the colour, and how it scatters, are
//! those of the surface at the pixel. With direct light by rays, (2), H is indirect light alone. (3)
//! gathers from the points y_i that cosine-distributed rays meet; there H is all light, without what
//! is emitted, which (2) has asked for (final gathering; Reichert 1992).

use super::params::{DirectLight, Display, RadiosityParams};
use super::solution::Solution;
use super::sources::outside;
use crate::features::describe;
use crate::frame::Frame;
use crate::method::PassStats;
use crate::path_space::MAX_PASSAGES;
use kaustika_film::accumulate::PixelRecord;
use kaustika_math::{Frame as Axes, Vec2, Vec3, warp};
use kaustika_sampling::Sampler;
use kaustika_scene::bsdf::{Bsdf, Lobes, Mode};
use kaustika_scene::{LightSelection, Scene, Surface};
use kaustika_spectra::{Spectrum, Wavelengths};

/// Reads a solution.
pub(super) struct Estimator<'a> {
    pub(super) scene: &'a Scene,
    pub(super) frame: &'a Frame,
    pub(super) lights: &'a LightSelection,
    pub(super) solution: &'a Solution,
    pub(super) params: &'a RadiosityParams,
}

impl<'a> Estimator<'a> {
    /// One sample of one pixel.
    pub(super) fn sample(
        &self,
        pixel: [u32; 2],
        index: u64,
        features: bool,
        bsdf: &mut Bsdf<'a>,
        stats: &mut PassStats,
    ) -> PixelRecord {
        let (scene, frame) = (self.scene, self.frame);
        let mut sampler = frame.sampler.start(pixel, index);
        let u = sampler.get_vertex();
        let film = frame.film_sample(pixel, Vec2::new(u[0], u[1]));
        let camera = scene.camera.sample_we(film.film, Vec2::new(u[2], u[3]), u[4]);
        let mut lambda = Wavelengths::rgb();
        let mut record = PixelRecord { weight: film.weight, ..PixelRecord::default() };
        let (mut ray, mut t_max) = (camera.ray, camera.t_max);
        let mut footprint = camera.width * scene.footprint_scale;
        let mut l = Spectrum::ZERO;
        for _ in 0..MAX_PASSAGES {
            stats.closest_rays += 1;
            let Some(hit) = scene.hit(&ray, t_max) else {
                if !self.params.hide_emitters {
                    l += outside(scene, &ray);
                }
                break;
            };
            let mut s = scene.geometry.surface(&hit, &ray);
            footprint += camera.spread * scene.footprint_scale * s.t;
            s.footprint = footprint;
            let wo = -ray.d;
            if !self.params.hide_emitters {
                l += scene.le(&s, wo, &lambda);
            }
            if scene.bsdf_into(&s, wo, &mut lambda, bsdf) {
                if features {
                    describe(scene, &s, bsdf, wo, &lambda, &mut record);
                }
                l += self.reflected(&s, bsdf, wo, &mut sampler, stats);
                l += self.glossy(&s, wo).unwrap_or(Spectrum::ZERO);
                break;
            }
            (ray, t_max) = (s.spawn(ray.d), f32::INFINITY);
        }
        record.rgb = frame.rgb(l * camera.weight, &lambda, stats);
        record
    }

    /// (1) or (3), without Lₑ.
    fn reflected(
        &self,
        s: &Surface,
        bsdf: &Bsdf,
        wo: Vec3,
        sampler: &mut Sampler,
        stats: &mut PassStats,
    ) -> Spectrum {
        if !bsdf.lobes().has(Lobes::DIFFUSE_REFLECTION) {
            return Spectrum::ZERO;
        }
        let u = sampler.get_vertex();
        let gathers = self.params.display == Display::Gather;
        let mut l = Spectrum::ZERO;
        if gathers || self.params.direct == DirectLight::Rays {
            l += self.direct(s, bsdf, wo, (u[4], Vec2::new(u[0], u[1])), stats);
        }
        let up = Axes::from_normal(bsdf.shading_normal().face_forward(s.facing(wo)));
        // f_D of a direction by its cosine: the same for all of Lambert's.
        let scattered = |u: Vec2| {
            let wi = up.to_world(warp::cosine_hemisphere(u));
            let f = bsdf.eval(wo, wi, Mode::Radiance, Lobes::DIFFUSE_REFLECTION);
            (wi, f / up.n.abs_dot(wi).max(1e-4))
        };
        if !gathers {
            let (_, f) = scattered(Vec2::new(u[2], u[3]));
            return l + f * self.irradiance(s, wo).unwrap_or(Spectrum::ZERO); // (1)
        }
        let n = self.params.gather;
        for k in 0..n {
            let u = match k {
                0 => Vec2::new(u[2], u[3]),
                _ => sampler.get_2d(),
            };
            let (wi, f) = scattered(u);
            if f.is_black() {
                continue;
            }
            stats.closest_rays += 1;
            if let Some(y) = self.scene.intersect(&s.spawn(wi), f32::INFINITY) {
                l += f * self.radiosity(&y, -wi) / n as f32; // (3)
            }
        }
        l
    }

    /// What is reflected by direction.
    fn glossy(&self, s: &Surface, wo: Vec3) -> Option<Spectrum> {
        let glossy = self.solution.glossy.as_ref()?;
        let (leaf, b) = self.solution.mesh.locate(self.scene, s, wo)?;
        Some(glossy.radiance(&self.solution.shading, leaf, b, wo))
    }

    /// H at what is seen.
    fn irradiance(&self, s: &Surface, wo: Vec3) -> Option<Spectrum> {
        let solution = self.solution;
        let [indirect, direct] = match self.params.display {
            Display::Constant => {
                let (leaf, _) = solution.mesh.locate(self.scene, s, wo)?;
                let even = |values| solution.shading.even(values, leaf);
                [even(&solution.indirect), even(&solution.direct)]
            }
            _ => solution.irradiance(self.scene, s, wo)?,
        };
        let by_rays = self.params.direct == DirectLight::Rays;
        Some(if by_rays { indirect } else { indirect + direct })
    }

    /// ρ H at what a gathering ray meets, light that is emitted not included.
    fn radiosity(&self, y: &Surface, wo: Vec3) -> Spectrum {
        let solution = self.solution;
        let Some((leaf, b)) = solution.mesh.locate(self.scene, y, wo) else {
            return Spectrum::ZERO;
        };
        let read = |values| solution.shading.smooth(values, leaf, b);
        solution.mesh.elements[leaf as usize].albedo
            * (read(&solution.indirect) + read(&solution.direct))
    }

    /// (2).
    fn direct(
        &self,
        s: &Surface,
        bsdf: &Bsdf,
        wo: Vec3,
        (u, u2): (f32, Vec2),
        stats: &mut PassStats,
    ) -> Spectrum {
        let (scene, lambda) = (self.scene, Wavelengths::rgb());
        let Some(c) = self.lights.sample(s.p, s.facing(wo), u, u2) else { return Spectrum::ZERO };
        let sample = scene.light(c.light).sample_li_in(scene, s.p, c.region, c.u, &lambda);
        let Some(l) = sample else { return Spectrum::ZERO };
        let f = bsdf.eval(wo, l.wi, Mode::Radiance, Lobes::DIFFUSE_REFLECTION);
        if f.is_black() || l.le.is_black() {
            return Spectrum::ZERO;
        }
        stats.shadow_rays += 1;
        match scene.occluded(&scene.shadow_ray(s, &l)) {
            true => Spectrum::ZERO,
            false => f * l.le / (c.p * l.pdf_w),
        }
    }
}
