//! Participating media: what happens to light between surfaces.
//!
//! ```text
//! (ω·∇) L = -σₜ L + σₛ ∫ p(ω, ω') L(ω') dω' + σₐ Lₑ                                  (1)
//! σₜ = σₐ + σₛ
//! ```
//!
//! A homogeneous medium has the same coefficients everywhere, and its transmittance a closed
//! form. Of others a majorant σ̄ ≥ σₜ is known cell by cell ([`majorant`]), which is what null
//! collisions need.

mod build;
mod cloud;
pub(crate) mod grid;
mod majorant;
mod matter;
mod phase;
mod sggx;

pub use matter::Coefficients;
pub use phase::Phase;
pub use sggx::{Flakes, Sggx};

use kaustika_math::{Ray, Transform, Vec3};
use kaustika_spectra::{Spectrum, Wavelengths};
use majorant::{CellWalk, MajorantGrid};
use matter::{Glow, Matter};

/// A medium ready to be asked.
#[derive(Debug)]
pub struct Medium {
    matter: Matter,
    glow: Option<Glow>,
    /// Majorants, if the coefficients vary.
    majorants: Option<MajorantGrid>,
    /// World to the unit cube of the box it fills; `None`: everywhere.
    extent: Option<Transform>,
    /// Into which directions it scatters.
    pub phase: Phase,
    /// False if it only absorbs and emits.
    pub scatters: bool,
}

/// A part of a ray along which the extinction is at most `majorant`.
#[derive(Clone, Copy, Debug)]
pub struct Stretch {
    /// Where it begins along the ray.
    pub t0: f32,
    /// Where it ends.
    pub t1: f32,
    /// σ̄, per unit of length.
    pub majorant: Spectrum,
}

impl Medium {
    /// The part of a ray with t in [0, t_max] along which the medium is; the ray's direction is
    /// unit.
    #[inline]
    pub fn interval(&self, ray: &Ray, t_max: f32) -> Option<(f32, f32)> {
        let Some(extent) = &self.extent else { return Some((0.0, t_max)) };
        let local = extent.ray(ray);
        let unit = kaustika_math::Bounds3 { min: Vec3::ZERO, max: Vec3::splat(1.0) };
        unit.intersect(local.o, local.d, t_max)
    }

    /// True if the coefficients vary from place to place.
    pub fn varies(&self) -> bool {
        self.majorants.is_some()
    }

    /// The coefficients for light along `w`, if they are the same everywhere.
    #[inline]
    pub fn uniform(&self, w: Vec3, lambda: &Wavelengths) -> Option<Coefficients> {
        if self.majorants.is_some() {
            return None;
        }
        Some(self.at(Vec3::ZERO, w, lambda))
    }

    /// The coefficients at a point of the world for light along `w`, either way.
    pub fn at(&self, p: Vec3, w: Vec3, lambda: &Wavelengths) -> Coefficients {
        let (mut sigma_t, mut sigma_s) = self.matter.at(p, lambda);
        if let Phase::Sggx(sggx) = &self.phase {
            let area = sggx.at(p).area(w);
            (sigma_t, sigma_s) = (sigma_t * area, sigma_s * area);
        }
        let glow = match &self.glow {
            Some(glow) => (sigma_t - sigma_s).clamp_zero() * glow.radiance(p, lambda),
            None => Spectrum::ZERO,
        };
        Coefficients { sigma_t, sigma_s, glow }
    }

    /// The majorants along a ray from `t0` to `t1`, which lie in [`Medium::interval`]; none for
    /// a medium that is the same everywhere.
    pub fn stretches(&self, ray: &Ray, t0: f32, t1: f32, lambda: &Wavelengths) -> Stretches<'_> {
        let cells = self.majorants.as_ref().map(|grid| grid.walk(ray, t0, t1));
        Stretches { cells, constant: self.matter.constant_extinction(lambda) }
    }
}

/// The majorants along a ray; see [`Medium::stretches`].
#[derive(Clone, Debug)]
pub struct Stretches<'a> {
    cells: Option<CellWalk<'a>>,
    constant: Spectrum,
}

impl Iterator for Stretches<'_> {
    type Item = Stretch;

    #[inline]
    fn next(&mut self) -> Option<Stretch> {
        let span = self.cells.as_mut()?.next()?;
        let [a, b] = span.bound;
        let majorant = self.constant * a + Spectrum::splat(b);
        Some(Stretch { t0: span.t0, t1: span.t1, majorant })
    }
}
