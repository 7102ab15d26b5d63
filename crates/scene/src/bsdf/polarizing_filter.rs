//! Ideal filters in the way of light: linear polarizer, retarder, circular polarizer. Light passes
//! straight through, as with [`Null`](super::Null), and is changed.
//!
//! ```text
//! linear polarizer at θ:  absorbs along a = (sin θ, cos θ, 0), made perpendicular to ω;
//!                         passes along ω × a;  m₀₀ = τ/2                                  (1)
//! retarder at θ:          fast along (cos θ, sin θ, 0), made perpendicular to ω;
//!                         retards by δ |cos θ_ω|;  m₀₀ = τ                                 (2)
//! circular polarizer:     passes one handedness;  m₀₀ = τ/2                               (3)
//! ```
//!
//! The x axis is ∂p/∂u. (1): Korger et al. 2013, "The polarization properties of a tilted polarizer". The
//! meaning of the parameters is that of Mitsuba 3's `polarizer`, `retarder` and `circular` (facts read in its
//! source; at oblique incidence its retarder turns the frame by an angle to the axis itself, not to its
//! projection).

use super::polarize::Polarize;
use super::{BsdfSample, Lobes, Mode, Scatter};
use crate::polarization::{
    Mueller, Oriented, circular_polarizer, linear_polarizer, linear_retarder, stokes_basis,
};
use kaustika_math::{Vec2, Vec3};
use kaustika_spectra::Spectrum;

/// What a filter does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FilterElement {
    /// (1)
    Linear {
        /// θ, radians.
        theta: f32,
    },
    /// (2)
    Retarder {
        /// θ, radians.
        theta: f32,
        /// δ, radians.
        delta: Spectrum,
    },
    /// (3)
    Circular {
        /// True: passes left circular light.
        left_handed: bool,
    },
    /// Absorbs half of the light whatever its polarization.
    Grey,
}

/// A filter without thickness, the same from both sides; one Dirac lobe, [`Lobes::NULL`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolarizingFilter {
    /// What it does.
    pub element: FilterElement,
    /// τ: multiplies what passes, in [0, 1].
    pub transmittance: Spectrum,
}

impl PolarizingFilter {
    /// What passes of unpolarized light.
    #[inline]
    fn value(&self) -> Spectrum {
        match self.element {
            FilterElement::Retarder { .. } => self.transmittance,
            _ => self.transmittance * 0.5,
        }
    }
}

impl Polarize for PolarizingFilter {
    #[inline]
    fn polarization(&self, wo: Vec3, _: Vec3) -> Oriented {
        let perpendicular = |axis: Vec3| {
            let seen = axis - wo * axis.dot(wo);
            seen.try_normalize().unwrap_or_else(|| stokes_basis(wo))
        };
        match self.element {
            FilterElement::Linear { theta } => {
                let (sin, cos) = theta.sin_cos();
                let absorbing = perpendicular(Vec3::new(sin, cos, 0.0));
                Oriented { mueller: linear_polarizer(), x: wo.cross(absorbing) } // (1)
            }
            FilterElement::Retarder { theta, delta } => {
                let (sin, cos) = theta.sin_cos();
                let x = perpendicular(Vec3::new(cos, sin, 0.0));
                Oriented { mueller: linear_retarder(delta * wo.z.abs()), x } // (2)
            }
            FilterElement::Circular { left_handed } => {
                Oriented { mueller: circular_polarizer(left_handed), x: stokes_basis(wo) } // (3)
            }
            FilterElement::Grey => Oriented { mueller: Mueller::IDENTITY, x: stokes_basis(wo) },
        }
    }
}

impl Scatter for PolarizingFilter {
    #[inline]
    fn eval(&self, _: Vec3, _: Vec3, _: Mode, _: Lobes) -> Spectrum {
        Spectrum::ZERO
    }

    #[inline]
    fn pdf(&self, _: Vec3, _: Vec3, _: Mode, _: Lobes) -> (f32, f32) {
        (0.0, 0.0)
    }

    #[inline]
    fn sample(&self, wo: Vec3, _: f32, _: Vec2, _: Mode, lobes: Lobes) -> Option<BsdfSample> {
        lobes.has(Lobes::NULL).then(|| BsdfSample {
            wi: -wo,
            weight: self.value(),
            pdf: 1.0,
            pdf_rev: 1.0,
            eta: 1.0,
            lobe: Lobes::NULL,
        })
    }

    /// Exact for unpolarized light.
    #[inline]
    fn albedo(&self, _: Vec3) -> Spectrum {
        self.value()
    }

    #[inline]
    fn roughness(&self) -> f32 {
        0.0
    }

    #[inline]
    fn lobes(&self) -> Lobes {
        Lobes::NULL
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Expect, check_model};
    use super::*;

    #[test]
    fn filters_hold_the_contract() {
        let both = Expect { both_sides: true, ..Expect::default() };
        let delta = Spectrum::splat(1.0);
        for (element, passes) in [
            (FilterElement::Linear { theta: 0.3 }, 0.5),
            (FilterElement::Retarder { theta: 0.3, delta }, 1.0),
            (FilterElement::Circular { left_handed: true }, 0.5),
            (FilterElement::Grey, 0.5),
        ] {
            let filter = PolarizingFilter { element, transmittance: Spectrum::ONE };
            let name = format!("{element:?}");
            check_model(&name, &filter, Expect { albedo: Some((passes, 1e-6)), ..both });
            let transmittance = Spectrum([0.2, 0.8, 1.0, 0.3]);
            check_model(&name, &PolarizingFilter { transmittance, ..filter }, both);
        }
    }
}
