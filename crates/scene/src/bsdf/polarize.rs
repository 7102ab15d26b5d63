//! How models change polarization: the twin of [`Scatter`](super::Scatter).
//!
//! A Mueller matrix is the scalar value times a matrix whose m₀₀ is 1:
//!
//! ```text
//! M(ωₒ, ωᵢ) = f(ωₒ, ωᵢ) M̂(ωₒ, ωᵢ)                                                  (1)
//! ```
//!
//! Values, densities and sampling stay those of `Scatter`; a model that polarizes adds M̂, all others
//! depolarize. Light flows from `wi` to `wo`, as in [`Mode::Radiance`](super::Mode). At facets M̂ is
//! Fresnel's at the facet between the two directions: light seen between facets is lost, as in `Scatter`.

use super::{Conductor, ConductorFresnel, Dielectric, Model, Null, ThinDielectric};
use crate::polarization::{
    Mueller, Oriented, pane_reflection, pane_transmission, reflection, refraction, stokes_basis,
};
use kaustika_math::Vec3;
use kaustika_spectra::Spectrum;

/// What polarizing models answer, in their local frame.
pub trait Polarize {
    /// M̂ of (1) between two directions that the model scatters between.
    fn polarization(&self, wo: Vec3, wi: Vec3) -> Oriented;
}

impl Polarize for Conductor {
    #[inline]
    fn polarization(&self, wo: Vec3, wi: Vec3) -> Oriented {
        let (eta, k) = match self.fresnel {
            ConductorFresnel::EtaK { eta, k } => (eta, k),
            // Reflectance 1 at every angle: Mitsuba's `none` has these phases.
            ConductorFresnel::Mirror => (Spectrum::ZERO, Spectrum::ONE),
        };
        reflection(wo, wi, eta, k)
    }
}

impl Polarize for Dielectric {
    #[inline]
    fn polarization(&self, wo: Vec3, wi: Vec3) -> Oriented {
        if wo.z * wi.z < 0.0 {
            return refraction(wo, wi);
        }
        let eta = if wo.z > 0.0 { self.eta } else { 1.0 / self.eta };
        reflection(wo, wi, Spectrum::splat(eta), Spectrum::ZERO)
    }
}

impl Polarize for ThinDielectric {
    #[inline]
    fn polarization(&self, wo: Vec3, wi: Vec3) -> Oriented {
        match wo.z * wi.z < 0.0 {
            true => pane_transmission(wo, Vec3::Z, self.eta),
            false => pane_reflection(wo, wi, self.eta),
        }
    }
}

impl Polarize for Null {
    #[inline]
    fn polarization(&self, wo: Vec3, _: Vec3) -> Oriented {
        Oriented { mueller: Mueller::IDENTITY, x: stokes_basis(wo) }
    }
}

impl Model<'_> {
    /// M̂ of (1), `None` where the model depolarizes.
    #[inline]
    pub fn polarization(&self, wo: Vec3, wi: Vec3) -> Option<Oriented> {
        let model: &dyn Polarize = match self {
            Model::Conductor(m) => m,
            Model::Dielectric(m) => m,
            Model::ThinDielectric(m) => m,
            Model::PolarizingFilter(m) => m,
            Model::Null(m) => m,
            Model::MeasuredPolarized(m) => m,
            Model::Coating(m) => return m.polarization(wo, wi),
            _ => return None,
        };
        Some(model.polarization(wo, wi))
    }
}

#[cfg(test)]
mod tests;
