//! Which light to sample: uniformly, by power, or by a hierarchy over position and direction.

use super::Light;
use crate::Scene;
use crate::surface::LightId;
use kaustika_math::Vec3;
use kaustika_sampling::distribution::Discrete;
use kaustika_spectra::{ColorMode, Wavelengths};
use std::str::FromStr;

/// The ways to choose a light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightSelectionKind {
    /// Each with the same probability.
    Uniform,
    /// In proportion to power.
    #[default]
    Power,
}

impl FromStr for LightSelectionKind {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        match s {
            "uniform" => Ok(LightSelectionKind::Uniform),
            "power" => Ok(LightSelectionKind::Power),
            _ => Err(format!("unknown light sampler `{s}`; known: uniform, power")),
        }
    }
}

/// Chooses lights; built once a scene.
#[derive(Debug, Default)]
pub struct LightSelection {
    /// Probabilities of the lights; `None` without lights.
    table: Option<Discrete>,
}

impl LightSelection {
    /// Builds the tables over all lights of the scene.
    pub fn new(kind: LightSelectionKind, scene: &Scene) -> LightSelection {
        if scene.lights.is_empty() {
            return LightSelection { table: None };
        }
        let weights: Vec<f32> = match kind {
            LightSelectionKind::Uniform => vec![1.0; scene.lights.len()],
            LightSelectionKind::Power => {
                scene.lights.iter().map(|l| mean_power(l, scene)).collect()
            }
        };
        // All dark or not to be summed: any of them may as well be asked.
        let table =
            Discrete::new(&weights).or_else(|_| Discrete::new(&vec![1.0; weights.len()])).ok();
        LightSelection { table }
    }

    /// A light for the scene point `p` with normal `n` (zero where there is none), with its
    /// probability and what is left of `u`; `None` if there is no light.
    #[inline]
    pub fn sample(&self, _p: Vec3, _n: Vec3, u: f32) -> Option<(LightId, f32)> {
        let s = self.table.as_ref()?.sample(u);
        (s.pmf > 0.0).then_some((LightId(s.index as u32), s.pmf))
    }

    /// Probability of [`LightSelection::sample`] choosing `light` for the same point.
    #[inline]
    pub fn pmf(&self, _p: Vec3, _n: Vec3, light: LightId) -> f32 {
        self.table.as_ref().map_or(0.0, |t| t.pmf(light.0 as usize))
    }
}

/// Luminous power, averaged over wavelengths in spectral mode.
pub fn mean_power(light: &Light, scene: &Scene) -> f32 {
    let count = if scene.mode == ColorMode::Spectral { 8 } else { 1 };
    let power: f32 = (0..count)
        .map(|i| {
            let lambda =
                Wavelengths::sample_for(scene.mode, (i as f32 + 0.5) / (4.0 * count as f32));
            light.power(scene, &lambda).luminance(&lambda)
        })
        .sum();
    (power / count as f32).max(0.0)
}
