//! Measured reflectance in an adaptive parameterisation: tables that are fine where a material's
//! reflection is.
//!
//! With the half vector m = (ωₒ + ωᵢ)/|ωₒ + ωᵢ| and its square u_m = (√(2θ_m/π), φ_m/2π + 1/2),
//! for isotropic materials φ_m - φₒ for φ_m:
//!
//! ```text
//! s = V⁻¹(u_m; ωₒ)            V warps the unit square to the visible normals                (1)
//! f |cos θᵢ| = M(s; ωₒ) D(u_m) / (4 σ(ωₒ))                                                   (2)
//! pdf = L(s; ωₒ) V'(u_m; ωₒ) / (4 ωₒ·m · 2π² √(2θ_m/π) sin θ_m)                              (3)
//! ```
//!
//! L is the density of the samples s. Dupuy & Jakob 2018, "An Adaptive Parameterization for
//! Efficient Material Acquisition and Rendering"; pbrt-v4's and Mitsuba 3's `measured`.

mod data;
mod squares;
#[cfg(test)]
mod tests;

use super::fresnel::reflect;
use super::{BsdfSample, Lobes, Mode, Scatter};
pub use data::MeasuredData;
pub(super) use data::rgb_of_nodes;
use kaustika_math::{Vec2, Vec3, sqr};
use kaustika_spectra::{Spectrum, Wavelengths};
use squares::bilinear;
pub(super) use squares::interval;
pub(super) use squares::{Densities, Node};
use std::f32::consts::PI;

/// A measured material, one-sided.
#[derive(Clone, Copy, Debug)]
pub struct Measured<'a> {
    /// Its tables.
    pub data: &'a MeasuredData,
    /// The path's.
    pub lambda: Wavelengths,
}

/// A pair of directions in the tables.
struct Place {
    /// Which tables.
    node: Node,
    /// The square of `wo`.
    u_wo: Vec2,
    /// That of the half vector.
    u_m: Vec2,
    /// s of (1).
    sample: Vec2,
    /// V' of (3).
    visible: f32,
    /// ωₒ·m and sin θ_m.
    cos_om: f32,
    sin_m: f32,
}

/// Angle from the normal, with all its digits.
fn elevation(w: Vec3) -> f32 {
    2.0 * (0.5 * (w - Vec3::Z).length()).min(1.0).asin()
}

fn theta_to_u(theta: f32) -> f32 {
    (theta * (2.0 / PI)).sqrt()
}

/// An azimuth's place in [0, 1).
fn phi_to_u(phi: f32) -> f32 {
    let u = phi / (2.0 * PI) + 0.5;
    u - u.floor()
}

impl<'a> Measured<'a> {
    /// Signs that take `wo` into the sector that was measured.
    fn signs(&self, wo: Vec3) -> (f32, f32) {
        let away = |v: f32| if v >= 0.0 { -1.0 } else { 1.0 };
        match self.data.sectors {
            4 => (away(wo.x), away(wo.y)),
            2 => (away(wo.y), away(wo.y)),
            _ => (1.0, 1.0),
        }
    }

    /// (1), for two directions above the surface.
    fn place(&self, wo: Vec3, wi: Vec3) -> Option<Place> {
        let (sx, sy) = self.signs(wo);
        let into = |w: Vec3| Vec3::new(w.x * sx, w.y * sy, w.z);
        let (wo, wi) = (into(wo), into(wi));
        let m = (wo + wi).try_normalize()?;
        let (theta_o, phi_o) = (elevation(wo), wo.y.atan2(wo.x));
        let (theta_m, phi_m) = (elevation(m), m.y.atan2(m.x));
        let turn = if self.data.isotropic { phi_o } else { 0.0 };
        let u_m = Vec2::new(theta_to_u(theta_m), phi_to_u(phi_m - turn));
        let node = self.data.node(phi_o, theta_o);
        let (sample, visible) = self.data.vndf.invert(&node, u_m);
        let u_wo = Vec2::new(theta_to_u(theta_o), phi_to_u(phi_o));
        let (cos_om, sin_m) = (wo.dot(m), m.x.hypot(m.y));
        Some(Place { node, u_wo, u_m, sample, visible, cos_om, sin_m })
    }

    /// D/(4σ) of (2).
    fn scale(&self, p: &Place) -> f32 {
        if !self.data.jacobian {
            return 1.0;
        }
        let sigma = bilinear(&self.data.sigma, 0, p.u_wo);
        let d = bilinear(&self.data.ndf, 0, p.u_m).max(0.0);
        if sigma > 0.0 { d / (4.0 * sigma) } else { 0.0 }
    }

    /// (3).
    fn density(&self, p: &Place) -> f32 {
        let jacobian = 4.0 * p.cos_om * (2.0 * sqr(PI) * p.u_m.x * p.sin_m).max(1e-6);
        if jacobian <= 0.0 {
            return 0.0;
        }
        p.visible * self.data.luminance.pdf(&p.node, p.sample) / jacobian
    }

    /// (2) and (3).
    fn value_and_density(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        let Some(p) = self.place(wo, wi) else { return (Spectrum::ZERO, 0.0) };
        let m = self.data.reflectance(&p.node, p.sample, &self.lambda);
        (m * self.scale(&p), self.density(&p))
    }

    /// A direction above the surface for `u` in [0, 1)², and where it is in the tables.
    fn drawn(&self, wo: Vec3, u: Vec2) -> Option<(Vec3, Place)> {
        let (sx, sy) = self.signs(wo);
        let o = Vec3::new(wo.x * sx, wo.y * sy, wo.z);
        let phi_o = o.y.atan2(o.x);
        let node = self.data.node(phi_o, elevation(o));
        let u_m = self.data.vndf.sample(&node, self.data.luminance.sample(&node, u));
        let turn = if self.data.isotropic { phi_o } else { 0.0 };
        let (sin_phi, cos_phi) = ((2.0 * u_m.y - 1.0) * PI + turn).sin_cos();
        let (sin, cos) = (sqr(u_m.x) * (0.5 * PI)).sin_cos();
        let m = Vec3::new(sin * cos_phi, sin * sin_phi, cos);
        let i = reflect(o, m);
        let wi = Vec3::new(i.x * sx, i.y * sy, i.z);
        if i.z <= 0.0 || o.dot(m) <= 0.0 {
            return None;
        }
        Some((wi, self.place(wo, wi)?))
    }
}

impl Scatter for Measured<'_> {
    fn eval(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> Spectrum {
        self.eval_pdf(wo, wi, mode, lobes).0
    }

    fn pdf(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> (f32, f32) {
        self.eval_pdf(wo, wi, mode, lobes).1
    }

    fn eval_pdf(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> (Spectrum, (f32, f32)) {
        if wo.z <= 0.0 || wi.z <= 0.0 || !lobes.has(Lobes::GLOSSY_REFLECTION) {
            return (Spectrum::ZERO, (0.0, 0.0));
        }
        let (there, forward) = self.value_and_density(wo, wi);
        let (back, reverse) = self.value_and_density(wi, wo);
        let value = match mode {
            Mode::Radiance => there,
            // Measurements are not quite reciprocal: the adjoint is f(ωᵢ, ωₒ) |cos θᵢ|.
            Mode::Importance => back * (wi.z / wo.z),
        };
        (value, (forward, reverse))
    }

    fn sample(&self, wo: Vec3, _: f32, u2: Vec2, mode: Mode, lobes: Lobes) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let (wi, _) = self.drawn(wo, u2)?;
        let (value, (pdf, pdf_rev)) = self.eval_pdf(wo, wi, mode, lobes);
        if !(pdf > 0.0 && pdf.is_finite() && pdf_rev.is_finite()) {
            return None;
        }
        let lobe = Lobes::GLOSSY_REFLECTION;
        Some(BsdfSample { wi, weight: value / pdf, pdf, pdf_rev, eta: 1.0, lobe })
    }

    /// Of radiance, interpolated between the directions that were measured.
    fn albedo(&self, wo: Vec3) -> Spectrum {
        if wo.z <= 0.0 {
            return Spectrum::ZERO;
        }
        let (sx, sy) = self.signs(wo);
        let node = self.data.node((wo.y * sy).atan2(wo.x * sx), elevation(wo));
        self.data.albedo(&node, &self.lambda)
    }

    fn roughness(&self) -> f32 {
        self.data.roughness
    }

    fn lobes(&self) -> Lobes {
        Lobes::GLOSSY_REFLECTION
    }
}
