//! Parameters of Whitted's and of distributed ray tracing.

use crate::registry::Parameter;
use crate::roulette::{Roulette, Survival};
use serde::Deserialize;

/// What can be set of `whitted` with `-p KEY=VALUE`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WhittedParams {
    /// Shadow rays of a hit; 0: one to every light, if there are not too many.
    pub shadow_rays: u32,
    /// Most bounces of a ray; -1 no limit.
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub max_depth: i64,
    /// No Russian roulette before more than this many bounces of a ray.
    pub rr_depth: u32,
    /// Survival rule.
    pub roulette: Survival,
    /// Throughput below which the rule `throughput` plays, above 0.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub rr_threshold: f32,
    /// True: lights are not seen directly.
    pub hide_emitters: bool,
}

impl Default for WhittedParams {
    fn default() -> Self {
        WhittedParams {
            shadow_rays: 0,
            max_depth: -1,
            rr_depth: 1,
            roulette: Survival::Throughput,
            rr_threshold: 0.05,
            hide_emitters: false,
        }
    }
}

/// What can be set of `distributed` with `-p KEY=VALUE`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DistributedParams {
    /// Rays that leave a hit by its glossy, mirroring and clear parts.
    #[serde(deserialize_with = "crate::registry::count")]
    pub secondary_rays: u32,
    /// Shadow rays of a hit; 0: one to every light, if there are not too many.
    pub shadow_rays: u32,
    /// Most bounces of a ray; -1 no limit.
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub max_depth: i64,
    /// No Russian roulette before more than this many bounces of a ray.
    pub rr_depth: u32,
    /// Survival rule.
    pub roulette: Survival,
    /// Throughput below which the rule `throughput` plays, above 0.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub rr_threshold: f32,
    /// True: lights are not seen directly.
    pub hide_emitters: bool,
}

impl Default for DistributedParams {
    fn default() -> Self {
        DistributedParams {
            secondary_rays: 1,
            shadow_rays: 1,
            max_depth: -1,
            rr_depth: 1,
            roulette: Survival::Throughput,
            rr_threshold: 0.4,
            hide_emitters: false,
        }
    }
}

/// How rays go on from a hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Secondary {
    /// One ray by each ideal reflection and refraction (Whitted 1980).
    Each,
    /// So many rays, each drawn from all glossy and ideal scattering (Cook et al. 1984).
    Drawn(u32),
}

/// What both methods are made of.
#[derive(Clone, Debug)]
pub struct TreeParams {
    /// How rays go on.
    pub secondary: Secondary,
    /// Shadow rays of a hit; 0: one to every light.
    pub shadow_rays: u32,
    /// Most bounces of a ray.
    pub max_depth: u32,
    /// How rays end.
    pub roulette: Roulette,
    /// True: lights are not seen directly.
    pub hide_emitters: bool,
}

impl From<WhittedParams> for TreeParams {
    fn from(p: WhittedParams) -> TreeParams {
        TreeParams {
            secondary: Secondary::Each,
            shadow_rays: p.shadow_rays,
            max_depth: u32::try_from(p.max_depth).unwrap_or(u32::MAX),
            roulette: roulette(p.roulette, p.rr_depth, p.rr_threshold),
            hide_emitters: p.hide_emitters,
        }
    }
}

impl From<DistributedParams> for TreeParams {
    fn from(p: DistributedParams) -> TreeParams {
        TreeParams {
            secondary: Secondary::Drawn(p.secondary_rays),
            shadow_rays: p.shadow_rays,
            max_depth: u32::try_from(p.max_depth).unwrap_or(u32::MAX),
            roulette: roulette(p.roulette, p.rr_depth, p.rr_threshold),
            hide_emitters: p.hide_emitters,
        }
    }
}

fn roulette(survival: Survival, rr_depth: u32, threshold: f32) -> Roulette {
    Roulette { survival, rr_depth, threshold }
}

/// The parameters of `whitted` with their defaults and meanings.
pub fn whitted_parameters() -> Vec<Parameter> {
    let d = WhittedParams::default();
    common(d.shadow_rays, d.rr_depth, d.rr_threshold)
}

/// The parameters of `distributed` with their defaults and meanings.
pub fn distributed_parameters() -> Vec<Parameter> {
    let d = DistributedParams::default();
    let help = "rays that leave a hit by its glossy, mirroring and clear parts; their number grows \
                as the power of it with the bounces";
    let key = "secondary_rays";
    let mut all = vec![Parameter { key, default: d.secondary_rays.to_string(), help }];
    all.extend(common(d.shadow_rays, d.rr_depth, d.rr_threshold));
    all
}

fn common(shadow_rays: u32, rr_depth: u32, rr_threshold: f32) -> Vec<Parameter> {
    let p = |key, default: String, help| Parameter { key, default, help };
    vec![
        p(
            "shadow_rays",
            shadow_rays.to_string(),
            "shadow rays of a hit; 0: one to every light, of more than 16 to so many that are chosen",
        ),
        p(
            "max_depth",
            "-1".into(),
            "most bounces of a ray, its last surface included (-1 no limit); a scene file's own value comes first",
        ),
        p(
            "rr_depth",
            rr_depth.to_string(),
            "no Russian roulette before more than this many bounces",
        ),
        p("roulette", "throughput".into(), "survival rule: none, throughput, albedo"),
        p(
            "rr_threshold",
            rr_threshold.to_string(),
            "throughput below which the rule `throughput` plays",
        ),
        p("hide_emitters", "false".into(), "lights are not seen directly"),
    ]
}
