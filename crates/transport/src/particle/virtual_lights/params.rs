//! Parameters of rendering with virtual lights.

use crate::registry::Parameter;
use crate::roulette::{Roulette, Survival};
use serde::Deserialize;

/// Everything that can be set with `-p KEY=VALUE`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VplParams {
    /// Light paths of a pass, whose vertices are the virtual lights.
    #[serde(deserialize_with = "crate::registry::count")]
    pub paths: u32,
    /// Bound of |cos| |cos| / d² between two vertices, times the square of the scene's radius.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub clamp: f32,
    /// True: what the bound cuts off is found by going on from the eye.
    pub compensate: bool,
    /// Surfaces less rough than this light nothing, and are lit by no virtual light: paths go on.
    pub roughness: f32,
    /// Longest path, counted as pbrt does: 0 emission only, 1 direct light; -1 no limit.
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub max_depth: i64,
    /// No Russian roulette before more than this many bounces of a subpath.
    pub rr_depth: u32,
    /// Survival rule, for both subpaths.
    pub roulette: Survival,
    /// Throughput below which the rule `throughput` plays, above 0.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub rr_threshold: f32,
    /// True: lights are not seen directly.
    pub hide_emitters: bool,
    /// Only paths of exactly this many bounces; -1 all.
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub only_depth: i64,
}

impl Default for VplParams {
    fn default() -> Self {
        VplParams {
            paths: 32,
            clamp: 20.0,
            compensate: true,
            roughness: 0.3,
            max_depth: -1,
            rr_depth: 1,
            roulette: Survival::Throughput,
            rr_threshold: 0.4,
            hide_emitters: false,
            only_depth: -1,
        }
    }
}

impl VplParams {
    /// Bounces of the longest path that is wanted.
    pub fn max_bounces(&self) -> u32 {
        [self.max_depth, self.only_depth]
            .into_iter()
            .filter_map(|d| u32::try_from(d).ok())
            .fold(u32::MAX, u32::min)
    }

    /// The roulette these parameters ask for.
    pub fn roulette(&self) -> Roulette {
        Roulette { survival: self.roulette, rr_depth: self.rr_depth, threshold: self.rr_threshold }
    }
}

/// The parameters with their defaults and meanings.
pub fn parameters() -> Vec<Parameter> {
    let d = VplParams::default();
    let p = |key, default: String, help| Parameter { key, default, help };
    vec![
        p(
            "paths",
            d.paths.to_string(),
            "light paths of a pass; their vertices are its virtual lights",
        ),
        p(
            "clamp",
            d.clamp.to_string(),
            "bound of cos cos / d² between two surfaces, times the square of the scene's radius",
        ),
        p(
            "compensate",
            d.compensate.to_string(),
            "false: what the bound cuts off is lost, as in classic instant radiosity: biased, dark corners",
        ),
        p(
            "roughness",
            d.roughness.to_string(),
            "surfaces less rough (0 mirror, 1 diffuse) take no part: paths go on there",
        ),
        p(
            "max_depth",
            d.max_depth.to_string(),
            "longest path as pbrt counts (0 emission, 1 direct light; -1 no limit); a scene file's own value comes first",
        ),
        p(
            "rr_depth",
            d.rr_depth.to_string(),
            "no Russian roulette before more than this many bounces of a subpath",
        ),
        p("roulette", "throughput".into(), "survival rule: none, throughput, albedo"),
        p(
            "rr_threshold",
            d.rr_threshold.to_string(),
            "throughput below which the rule `throughput` plays",
        ),
        p("hide_emitters", d.hide_emitters.to_string(), "lights are not seen directly"),
        p(
            "only_depth",
            d.only_depth.to_string(),
            "only paths of exactly this many bounces; -1 all",
        ),
    ]
}
