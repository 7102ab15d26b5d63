//! The path tracer's parameters.

use crate::registry::Parameter;
use crate::roulette::{Roulette, Rule, Survival};
use kaustika_sampling::MisHeuristic;
use serde::Deserialize;

/// Everything that can be set with `-p KEY=VALUE`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PathParams {
    /// Longest path, counted as pbrt does: 0 emission only, 1 direct light; -1 no limit.
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub max_depth: i64,
    /// No Russian roulette before more than this many bounces.
    pub rr_depth: u32,
    /// How paths end and split.
    pub roulette: Rule,
    /// Throughput below which the rule `throughput` plays, above 0.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub rr_threshold: f32,
    /// How light and BSDF samples are weighted.
    #[serde(deserialize_with = "heuristic")]
    pub mis: MisHeuristic,
    /// True: lights are not seen directly.
    pub hide_emitters: bool,
    /// Only paths of exactly this many bounces, for looking at single terms of the Neumann
    /// series; -1 all.
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub only_depth: i64,
    /// True: light's polarization is tracked.
    pub polarized: bool,
}

impl Default for PathParams {
    fn default() -> Self {
        PathParams {
            max_depth: -1,
            rr_depth: 1,
            roulette: Rule::Throughput,
            rr_threshold: 0.4,
            mis: MisHeuristic::default(),
            hide_emitters: false,
            only_depth: -1,
            polarized: false,
        }
    }
}

impl PathParams {
    /// Bounces of the longest path that is wanted.
    pub fn max_bounces(&self) -> u32 {
        // Nothing longer than the one length that is wanted.
        [self.max_depth, self.only_depth]
            .into_iter()
            .filter_map(|d| u32::try_from(d).ok())
            .fold(u32::MAX, u32::min)
    }

    /// The roulette these parameters ask for; of rules that split, what plays where they know
    /// nothing.
    pub fn roulette(&self) -> Roulette {
        let survival = self.roulette.survival().unwrap_or(Survival::Throughput);
        Roulette { survival, rr_depth: self.rr_depth, threshold: self.rr_threshold }
    }
}

pub(super) fn heuristic<'de, D: serde::Deserializer<'de>>(d: D) -> Result<MisHeuristic, D::Error> {
    let name = String::deserialize(d)?;
    name.parse().map_err(|e| serde::de::Error::custom(format!("{e}")))
}

/// The parameters with their defaults and meanings.
pub fn parameters() -> Vec<Parameter> {
    let d = PathParams::default();
    let p = |key, default: String, help| Parameter { key, default, help };
    vec![
        p(
            "max_depth",
            d.max_depth.to_string(),
            "longest path as pbrt counts (0 emission, 1 direct light; -1 no limit); a scene file's own value comes first",
        ),
        p(
            "rr_depth",
            d.rr_depth.to_string(),
            "no Russian roulette before more than this many bounces",
        ),
        p(
            "roulette",
            "throughput".into(),
            "how paths end: none, throughput (Arvo & Kirk), albedo (Jensen); and split: szirmay-kalos, adjoint (Vorba & Křivánek), efficiency (Rath et al.)",
        ),
        p(
            "rr_threshold",
            d.rr_threshold.to_string(),
            "throughput below which the rule `throughput` plays; surviving paths go on with it",
        ),
        p(
            "mis",
            "power".into(),
            "balance, power, power:BETA, max, light (light samples alone), bsdf (BSDF samples alone)",
        ),
        p("hide_emitters", d.hide_emitters.to_string(), "lights are not seen directly"),
        p(
            "only_depth",
            d.only_depth.to_string(),
            "only paths of exactly this many bounces; -1 all",
        ),
        p(
            "polarized",
            d.polarized.to_string(),
            "light's polarization is tracked: layers S0 to S3 (Stokes vectors) and DoP",
        ),
    ]
}
