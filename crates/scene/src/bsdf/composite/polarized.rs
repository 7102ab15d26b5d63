//! The Mueller matrix of a hit, in the frames of [`stokes_basis`](crate::polarization::stokes_basis).
//!
//! ```text
//! M = Σ wᵢ fᵢ M̂ᵢ                                                                    (1)
//! ```

use super::{Bsdf, Part};
use crate::bsdf::{BsdfSample, Lobes, Mode, Scatter};
use crate::polarization::{Mueller, Oriented};
use kaustika_math::{Vec2, Vec3};
use kaustika_spectra::Spectrum;

impl Part<'_> {
    /// `value` M̂ in world space.
    #[inline]
    fn mueller(&self, wo: Vec3, wi: Vec3, value: Spectrum) -> Mueller {
        let (o, i) = (self.frame.to_local(wo), self.frame.to_local(wi));
        match self.model.polarization(o, i) {
            Some(local) => {
                let world = Oriented { x: self.frame.to_world(local.x), ..local };
                world.aligned(wo, wi) * value
            }
            None => Mueller::depolarizer(value),
        }
    }
}

impl Bsdf<'_> {
    /// [`Bsdf::eval_pdf`] with the matrix (1) for the value, for light that flows from `wi` to
    /// `wo`: m₀₀ is the value. The density is the forward one.
    pub fn eval_mueller(&self, wo: Vec3, wi: Vec3, lobes: Lobes) -> (Mueller, f32) {
        let (mut value, mut pdf) = (Mueller::default(), 0.0);
        for part in &self.parts {
            let (o, i) = (part.frame.to_local(wo), part.frame.to_local(wi));
            if part.passes_guard((o, wo), (i, wi), Mode::Radiance) {
                let k = part.weight * part.shadowing(wo, wi, Mode::Radiance);
                let (f, (forward, _)) = part.model.eval_pdf(o, i, Mode::Radiance, lobes);
                if !f.is_black() {
                    value += part.mueller(wo, wi, f * k);
                }
                pdf += part.weight * forward;
            }
        }
        (value, pdf / self.total)
    }

    /// [`Bsdf::sample`] with the matrix of its weight: m₀₀ is the weight.
    pub fn sample_mueller(
        &self,
        wo: Vec3,
        uc: f32,
        u2: Vec2,
        lobes: Lobes,
    ) -> Option<(BsdfSample, Mueller)> {
        let s = self.sample(wo, uc, u2, Mode::Radiance, lobes)?;
        let weight = if self.parts.len() == 1 || s.lobe.has(Lobes::DELTA) {
            let (chosen, _) = self.choose(uc)?;
            self.parts[chosen].mueller(wo, s.wi, s.weight)
        } else {
            let (value, pdf) = self.eval_mueller(wo, s.wi, lobes);
            value * Spectrum::splat(1.0 / pdf)
        };
        Some((s, weight))
    }
}
