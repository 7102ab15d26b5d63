//! Parameters of backward ray tracing.

use crate::registry::Parameter;
use crate::roulette::{Roulette, Survival};
use serde::Deserialize;

/// Everything that can be set with `-p KEY=VALUE`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BackwardParams {
    /// Light paths of a pass; 0: one for each pixel of the whole picture.
    pub photons: u32,
    /// Width of the first pass's texels, as a share of the scene's radius.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub texel: f32,
    /// How fast texels shrink: the area of those of pass i is iᵅ⁻¹ of the first, in (0, 1]; 1
    /// keeps it.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub alpha: f32,
    /// Most bounces of an eye path, its last surface included, and of a light path likewise; -1 no
    /// limit.
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub max_depth: i64,
    /// No Russian roulette before more than this many bounces of a path.
    pub rr_depth: u32,
    /// Survival rule, for both sides.
    pub roulette: Survival,
    /// Throughput below which the rule `throughput` plays, above 0.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub rr_threshold: f32,
    /// True: lights are not seen directly.
    pub hide_emitters: bool,
}

impl Default for BackwardParams {
    fn default() -> Self {
        BackwardParams {
            photons: 0,
            texel: 0.004,
            alpha: 0.75,
            max_depth: -1,
            rr_depth: 1,
            roulette: Survival::Throughput,
            rr_threshold: 0.4,
            hide_emitters: false,
        }
    }
}

impl BackwardParams {
    /// Most bounces of a path.
    pub fn max_bounces(&self) -> u32 {
        u32::try_from(self.max_depth).unwrap_or(u32::MAX)
    }

    /// The roulette these parameters ask for.
    pub fn roulette(&self) -> Roulette {
        Roulette { survival: self.roulette, rr_depth: self.rr_depth, threshold: self.rr_threshold }
    }

    /// Width of the texels of a pass, without what makes neighbours differ.
    pub fn width(&self, scene_radius: f32, pass: u64) -> f32 {
        let i = (pass + 1) as f64;
        let shrink = i.powf(0.5 * (f64::from(self.alpha.min(1.0)) - 1.0));
        self.texel * scene_radius * shrink as f32
    }
}

/// The parameters with their defaults and meanings.
pub fn parameters() -> Vec<Parameter> {
    let d = BackwardParams::default();
    let p = |key, default: String, help| Parameter { key, default, help };
    vec![
        p(
            "photons",
            d.photons.to_string(),
            "light paths of a pass; 0: one for each pixel of the whole picture",
        ),
        p(
            "texel",
            d.texel.to_string(),
            "width of the first pass's texels, as a share of the scene's radius",
        ),
        p(
            "alpha",
            d.alpha.to_string(),
            "how fast they shrink: their area falls as i^(alpha - 1) over the passes i; 1 keeps it",
        ),
        p(
            "max_depth",
            d.max_depth.to_string(),
            "most bounces of an eye path, and of a light path (-1 no limit); a scene file's own value comes first",
        ),
        p(
            "rr_depth",
            d.rr_depth.to_string(),
            "no Russian roulette before more than this many bounces of a path",
        ),
        p("roulette", "throughput".into(), "survival rule: none, throughput, albedo"),
        p(
            "rr_threshold",
            d.rr_threshold.to_string(),
            "throughput below which the rule `throughput` plays",
        ),
        p("hide_emitters", d.hide_emitters.to_string(), "lights are not seen directly"),
    ]
}
