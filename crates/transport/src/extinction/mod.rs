//! Light's way through participating media, for every method that walks or connects through them.
//!
//! ```text
//! T(t) = exp(-∫₀ᵗ σₜ)                                                              (1)
//! homogeneous: p(t) = σₜ T(t), f = σₛ T(t);  p(passing) = T(t)                      (2)
//! others, with a majorant σ̄ and its transmittance T̄: collisions with p = σ̄ T̄, of which
//!   real ones (σₜ/σ̄) scatter, f = σₛ T̄, and null ones go on, f = p = (σ̄ - σₜ) T̄      (3)
//! β ← β f / ⟨s p⟩,   s ← s p / ⟨s p⟩,   ℓ ← ℓ q / ⟨s p⟩                             (4)
//! ```
//!
//! The coefficients differ between the lanes of a spectrum, so each lane would choose distances
//! with a density of its own. One lane, the hero, chooses, and all lanes take the result with the
//! mean ⟨·⟩ of their densities (4): s is each lane's share in it, ⟨s⟩ = 1. That is multiple
//! importance sampling over the lanes by the balance heuristic, path by path (Wilkie et al. 2014,
//! "Hero wavelength spectral sampling"; Miller, Georgiev & Jarosz 2019, "A null-scattering path
//! integral formulation of light transport"). ℓ is the density with which another technique would
//! have made the way since the last vertex, over the same mean; q is its factor.

mod beam;
mod collisions;
mod shares;
mod stream;

pub use beam::Beam;
pub use collisions::{Collision, collide};
pub use shares::Shares;
pub use stream::{Stream, optical_distance};

use kaustika_spectra::{ColorMode, Spectrum};

/// T of (1) over `length` of constant extinction, also infinite.
#[inline]
pub fn transmittance(sigma_t: Spectrum, length: f32) -> Spectrum {
    sigma_t.map(|s| if s > 0.0 { (-s * length).exp() } else { 1.0 })
}

/// ∫₀ᵈ T(t) dt of constant extinction.
#[inline]
pub fn optical_length(sigma_t: Spectrum, d: f32) -> Spectrum {
    sigma_t.map(|s| {
        let x = s * d;
        if s > 0.0 && x > 1e-4 { -(-x).exp_m1() / s } else { d * (1.0 - 0.5 * x) }
    })
}

/// The mean over the lanes that paths begin with, whichever of them count later.
#[inline]
pub fn lane_mean(v: Spectrum, mode: ColorMode) -> f32 {
    match mode {
        ColorMode::Rgb => (v[0] + v[1] + v[2]) * (1.0 / 3.0),
        ColorMode::Spectral => v.average(),
    }
}
