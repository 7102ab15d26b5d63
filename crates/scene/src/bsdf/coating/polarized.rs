//! The polarization of Mitsuba 3's `pplastic` (Baek et al. 2018, "Simultaneous Acquisition of
//! Polarimetric SVBRDF and Normals"): light is refracted into the coat, depolarized by the base, and refracted
//! out of it. With s the coat's share of the value, R and T the matrices of reflection and refraction:
//!
//! ```text
//! M̂ = s R(ωₒ, ωᵢ) + (1 - s) T(ωₒ, -ωₒ') D T(-ωᵢ', ωᵢ),   D = diag(1, 0, 0, 0)          (1)
//! ```

use super::Coating;
use crate::bsdf::{Lobes, Mode, Scatter};
use crate::polarization::{Mueller, Oriented, Turn, reflection, refraction};
use kaustika_math::Vec3;
use kaustika_spectra::Spectrum;

impl Coating<'_> {
    /// M̂ of (1); `None` for the coats of Mitsuba 0.6, which depolarize.
    pub(in crate::bsdf) fn polarization(&self, wo: Vec3, wi: Vec3) -> Option<Oriented> {
        let layer = &self.layer;
        if layer.through.is_some() || layer.surface.is_smooth() {
            return None;
        }
        let coat = self.coat(wo, wi, Lobes::ALL);
        let value = self.eval(wo, wi, Mode::Radiance, Lobes::ALL);
        let share = (0..4).fold(Spectrum::ZERO, |mut s, lane| {
            s.0[lane] = if value[lane] > 0.0 { coat[lane] / value[lane] } else { 0.0 };
            s
        });
        let above = reflection(wo, wi, Spectrum::splat(layer.eta), Spectrum::ZERO);
        let mut mueller = above.mueller * share;
        if let (Some(o), Some(i)) =
            (Coating::refracted(wo, layer.eta), Coating::refracted(wi, layer.eta))
        {
            let (out, into) = (refraction(wo, -o), refraction(-i, wi));
            let below = out.mueller * Mueller::depolarizer(Spectrum::ONE) * into.mueller;
            // Each refraction has a plane of its own.
            let leaving = Turn::between(wo, out.x, above.x);
            let arriving = Turn::between(-wi, into.x, above.x);
            mueller += below.turned(leaving, arriving) * (Spectrum::ONE - share);
        }
        Some(Oriented { mueller, x: above.x })
    }
}
