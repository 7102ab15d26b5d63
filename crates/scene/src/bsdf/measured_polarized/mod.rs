//! A measured isotropic material with its polarization: Mueller matrices in Rusinkiewicz's angles.
//!
//! With the half vector h = (ωₒ + ωᵢ)/|ωₒ + ωᵢ|, its polar axis' tangents b = n×h/|n×h| and t = b×h:
//!
//! ```text
//! cos θ_h = n·h,   cos θ_d = h·ωᵢ,   φ_d = atan2(b·ωᵢ, t·ωᵢ)                             (1)
//! f cos θᵢ M̂ = M(φ_d, θ_d, θ_h, λ) cos θᵢ                                              (2)
//! pdf = 0.9 D_v(h; ωₒ)/(4 ωₒ·h) + 0.1 cos θᵢ/π                                          (3)
//! ```
//!
//! M lies on a grid, linear between its nodes, in frames whose x axis is the normal of the plane of both
//! directions. Baek et al. 2020, "Image-Based Acquisition and Modeling of Polarimetric Reflectance";
//! Rusinkiewicz 1998, "A New Change of Variables for Efficient BRDF Representation"; Mitsuba 3's
//! `measured_polarized`, whose (3) it is. D_v is the density of visible normals of GGX.

mod data;
#[cfg(test)]
mod tests;

use super::fresnel::reflect;
use super::{BsdfSample, Lobes, Mode, Polarize, Scatter};
use crate::polarization::{Mueller, Oriented, plane_normal};
use data::Corners;
pub use data::MuellerData;
use kaustika_math::{ONE_MINUS_EPSILON, Vec2, Vec3, safe_acos, warp};
use kaustika_spectra::{Spectrum, Wavelengths};
use std::f32::consts::FRAC_1_PI;

/// Share of the cosine in (3).
const DIFFUSE: f32 = 0.1;

/// A measured material that polarizes, one-sided.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredPolarized<'a> {
    /// Its tables.
    pub data: &'a MuellerData,
    /// The path's.
    pub lambda: Wavelengths,
}

impl MeasuredPolarized<'_> {
    /// (1), for two directions above the surface.
    fn corners(&self, wo: Vec3, wi: Vec3) -> Option<Corners> {
        let h = (wo + wi).try_normalize()?;
        // About the normal itself no azimuth differs from another.
        let b = Vec3::Z.cross(h).try_normalize().unwrap_or(Vec3::Y);
        let t = b.cross(h);
        let phi_d = b.dot(wi).atan2(t.dot(wi));
        Some(self.data.corners(phi_d, safe_acos(h.dot(wi)), safe_acos(h.z)))
    }

    /// m₀₀ cos θᵢ of (2); nothing where it was not measured.
    fn value(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        let Some(corners) = self.corners(wo, wi) else { return Spectrum::ZERO };
        let m00 = self.data.element(&corners, 0, &self.lambda);
        if m00.is_finite() { m00.clamp_zero() * wi.z } else { Spectrum::ZERO }
    }

    /// (3).
    fn density(&self, wo: Vec3, wi: Vec3) -> (f32, f32) {
        let (forward, reverse) = self.data.surface.pdf_reflection(wo, wi, (wo + wi).normalize());
        let mixed = |facets: f32, cos: f32| (1.0 - DIFFUSE) * facets + DIFFUSE * FRAC_1_PI * cos;
        (mixed(forward, wi.z), mixed(reverse, wo.z))
    }

    /// A direction above the surface.
    fn drawn(&self, wo: Vec3, uc: f32, u2: Vec2) -> Option<Vec3> {
        let wi = match uc < DIFFUSE {
            true => warp::cosine_hemisphere(u2),
            false => reflect(wo, self.data.surface.sample_visible(wo, u2)),
        };
        (wi.z > 0.0).then_some(wi)
    }
}

impl Scatter for MeasuredPolarized<'_> {
    fn eval(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> Spectrum {
        if wo.z <= 0.0 || wi.z <= 0.0 || !lobes.has(Lobes::GLOSSY_REFLECTION) {
            return Spectrum::ZERO;
        }
        match mode {
            Mode::Radiance => self.value(wo, wi),
            // Measurements are not quite reciprocal: the adjoint is f(ωᵢ, ωₒ) |cos θᵢ|.
            Mode::Importance => self.value(wi, wo) * (wi.z / wo.z),
        }
    }

    fn pdf(&self, wo: Vec3, wi: Vec3, _: Mode, lobes: Lobes) -> (f32, f32) {
        if wo.z <= 0.0 || wi.z <= 0.0 || !lobes.has(Lobes::GLOSSY_REFLECTION) {
            return (0.0, 0.0);
        }
        self.density(wo, wi)
    }

    fn sample(&self, wo: Vec3, uc: f32, u2: Vec2, mode: Mode, lobes: Lobes) -> Option<BsdfSample> {
        if wo.z <= 0.0 || !lobes.has(Lobes::GLOSSY_REFLECTION) {
            return None;
        }
        let wi = self.drawn(wo, uc.min(ONE_MINUS_EPSILON), u2)?;
        let (pdf, pdf_rev) = self.density(wo, wi);
        if !(pdf > 0.0 && pdf.is_finite() && pdf_rev.is_finite()) {
            return None;
        }
        let weight = self.eval(wo, wi, mode, lobes) / pdf;
        let lobe = Lobes::GLOSSY_REFLECTION;
        Some(BsdfSample { wi, weight, pdf, pdf_rev, eta: 1.0, lobe })
    }

    /// Of radiance, interpolated between sixteen angles.
    fn albedo(&self, wo: Vec3) -> Spectrum {
        if wo.z <= 0.0 { Spectrum::ZERO } else { self.data.albedo(wo.z, &self.lambda) }
    }

    fn roughness(&self) -> f32 {
        self.data.surface.roughness()
    }

    fn lobes(&self) -> Lobes {
        Lobes::GLOSSY_REFLECTION
    }
}

impl Polarize for MeasuredPolarized<'_> {
    fn polarization(&self, wo: Vec3, wi: Vec3) -> Oriented {
        let x = plane_normal(wo, wi);
        let Some(corners) = self.corners(wo, wi) else {
            return Oriented { mueller: Mueller::depolarizer(Spectrum::ONE), x };
        };
        let m00 = self.data.element(&corners, 0, &self.lambda);
        let scale = m00.map(|v| if v > 0.0 { 1.0 / v } else { 0.0 });
        let mut mueller = Mueller::depolarizer(Spectrum::ONE);
        for k in 1..16 {
            let m = self.data.element(&corners, k, &self.lambda);
            // Where the value is known, so is the rest.
            mueller.0[k / 4][k % 4] = if m.is_finite() { m * scale } else { Spectrum::ZERO };
        }
        Oriented { mueller, x }
    }
}
