//! Lambert's diffuse reflection: the radiance leaving is the same in every direction.
//!
//! ```text
//! f = ρ/π                                                            (1)
//! pdf(wi) = cos θᵢ / π,   weight = f cos θᵢ / pdf = ρ                (2)
//! ```

use super::{BsdfSample, Lobes, Mode, Scatter};
use kaustika_math::{INV_PI, Vec2, Vec3, warp};
use kaustika_spectra::Spectrum;

/// A matte, one-sided surface.
#[derive(Clone, Copy, Debug)]
pub struct Diffuse {
    /// Albedo ρ in [0,1].
    pub reflectance: Spectrum,
}

impl Scatter for Diffuse {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> Spectrum {
        if wo.z <= 0.0 || wi.z <= 0.0 || !lobes.has(Lobes::DIFFUSE_REFLECTION) {
            return Spectrum::ZERO;
        }
        self.reflectance * (INV_PI * wi.z) // (1)
    }

    #[inline]
    fn pdf(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> (f32, f32) {
        if wo.z <= 0.0 || wi.z <= 0.0 || !lobes.has(Lobes::DIFFUSE_REFLECTION) {
            return (0.0, 0.0);
        }
        (warp::cosine_hemisphere_pdf_w(wi.z), warp::cosine_hemisphere_pdf_w(wo.z)) // (2)
    }

    #[inline]
    fn sample(&self, wo: Vec3, _: f32, u2: Vec2, _: Mode, lobes: Lobes) -> Option<BsdfSample> {
        if wo.z <= 0.0 || !lobes.has(Lobes::DIFFUSE_REFLECTION) {
            return None;
        }
        let wi = warp::cosine_hemisphere(u2);
        let pdf = warp::cosine_hemisphere_pdf_w(wi.z);
        (pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: self.reflectance, // (2)
            pdf,
            pdf_rev: warp::cosine_hemisphere_pdf_w(wo.z),
            eta: 1.0,
            lobe: Lobes::DIFFUSE_REFLECTION,
        })
    }

    #[inline]
    fn albedo(&self, _: Vec3) -> Spectrum {
        self.reflectance
    }

    #[inline]
    fn roughness(&self) -> f32 {
        1.0
    }

    #[inline]
    fn lobes(&self) -> Lobes {
        if self.reflectance.is_black() { Lobes::NONE } else { Lobes::DIFFUSE_REFLECTION }
    }
}
