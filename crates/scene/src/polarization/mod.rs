//! Polarized light: Stokes vectors, Mueller matrices, and what Fresnel's equations do to them.
//!
//! A Stokes vector S = (S₀, S₁, S₂, S₃) describes light that travels along w, in a frame (x, y, w)
//! with x ⟂ w and y = w × x. Who faces the light, x to the right and y up, sees
//!
//! ```text
//! S₀  radiance
//! S₁  > 0: linear along x             < 0: along y
//! S₂  > 0: linear at +45°, x + y      < 0: at -45°
//! S₃  > 0: right circular, clockwise  < 0: left circular
//! ```
//!
//! so that with amplitudes E e^{-iωt}, S₁ = |Eₓ|² - |E_y|² and S₂ + i S₃ = 2 Eₓ E_y*. A Mueller matrix takes
//! the Stokes vector of the light that arrives to that of the light that leaves, each in its own
//! frame; matrices are multiplied in the order of the light, later ones on the left.
//!
//! Where no frame is named it is that of [`stokes_basis`]. Wolff & Kurlander 1990, "Ray Tracing with
//! Polarization Parameters" (who carry coherency matrices); Collett 2005, "Field Guide to Polarization".
//! Conventions as in Mitsuba 3's documentation.

mod elements;
mod fresnel;
mod mueller;

pub use elements::{circular_polarizer, linear_polarizer, linear_retarder};
pub use fresnel::{pane_reflection, pane_transmission, plane_normal, reflection, refraction};
pub use mueller::{Mueller, Stokes, Turn, stokes_basis};

use kaustika_math::Vec3;

/// A Mueller matrix whose frames, of the light that arrives and of the light that leaves, have
/// one axis in common: the normal of the plane of incidence, or an axis of a filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oriented {
    /// The matrix.
    pub mueller: Mueller,
    /// The x axis of both frames; unit, perpendicular to both directions.
    pub x: Vec3,
}

impl Oriented {
    /// The matrix for light that comes along -`wi` and leaves along `wo`, in the frames of
    /// [`stokes_basis`].
    #[inline]
    pub fn aligned(&self, wo: Vec3, wi: Vec3) -> Mueller {
        let leaving = Turn::between(wo, self.x, stokes_basis(wo));
        let arriving = Turn::between(-wi, self.x, stokes_basis(-wi));
        self.mueller.turned(leaving, arriving)
    }
}
