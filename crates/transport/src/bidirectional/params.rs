//! Parameters of bidirectional path tracing.

use crate::registry::Parameter;
use crate::roulette::{Roulette, Survival};
use crate::strategies::Settings;
use kaustika_sampling::Heuristic;
use serde::Deserialize;

/// Everything that can be set with `-p KEY=VALUE`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BdptParams {
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
    /// How strategies are weighted.
    #[serde(deserialize_with = "heuristic")]
    pub mis: Heuristic,
    /// One strategy alone: vertices from the light and from the eye.
    #[serde(deserialize_with = "strategy")]
    pub strategy: Option<(usize, usize)>,
    /// False: strategies are not weighted; with more than one, paths are counted several times.
    pub weighted: bool,
    /// True: a layer for each strategy, weighted and not.
    pub pyramid: bool,
    /// True: subpaths from the eye look for caustics where paths from lights say they come from.
    pub guiding: bool,
    /// True: lights are not seen directly.
    pub hide_emitters: bool,
    /// Only paths of exactly this many bounces; -1 all.
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub only_depth: i64,
}

impl Default for BdptParams {
    fn default() -> Self {
        BdptParams {
            max_depth: -1,
            rr_depth: 1,
            roulette: Survival::Throughput,
            rr_threshold: 0.4,
            mis: Heuristic::default(),
            strategy: None,
            weighted: true,
            pyramid: false,
            guiding: false,
            hide_emitters: false,
            only_depth: -1,
        }
    }
}

impl BdptParams {
    /// Bounces of the longest path that is wanted.
    pub fn max_bounces(&self) -> u32 {
        [self.max_depth, self.only_depth]
            .into_iter()
            .filter_map(|d| u32::try_from(d).ok())
            .fold(u32::MAX, u32::min)
    }

    /// What is asked of pairs of subpaths.
    pub fn settings(&self) -> Settings {
        let roulette = Roulette {
            survival: self.roulette,
            rr_depth: self.rr_depth,
            threshold: self.rr_threshold,
        };
        Settings {
            depths: [u32::try_from(self.only_depth).unwrap_or(0), self.max_bounces()],
            roulette,
            mis: self.mis,
            strategy: self.strategy,
            weighted: self.weighted,
            hide_emitters: self.hide_emitters,
        }
    }
}

fn heuristic<'de, D: serde::Deserializer<'de>>(d: D) -> Result<Heuristic, D::Error> {
    let name = String::deserialize(d)?;
    name.parse().map_err(|e| serde::de::Error::custom(format!("{e}")))
}

/// `S,T`, or `all`.
fn strategy<'de, D: serde::Deserializer<'de>>(d: D) -> Result<Option<(usize, usize)>, D::Error> {
    let text = String::deserialize(d)?;
    if text == "all" {
        return Ok(None);
    }
    let parsed = text.split_once(',').and_then(|(s, t)| {
        let (s, t): (usize, usize) = (s.trim().parse().ok()?, t.trim().parse().ok()?);
        (s + t >= 2).then_some((s, t))
    });
    parsed.map(Some).ok_or_else(|| {
        let message = format!("`{text}` is no strategy; give S,T (vertices from the light and from the eye, 2 or more together) or `all`");
        serde::de::Error::custom(message)
    })
}

/// The parameters with their defaults and meanings.
pub fn parameters() -> Vec<Parameter> {
    let d = BdptParams::default();
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
            "no Russian roulette before more than this many bounces of a subpath",
        ),
        p("roulette", "throughput".into(), "survival rule: none, throughput, albedo"),
        p(
            "rr_threshold",
            d.rr_threshold.to_string(),
            "throughput below which the rule `throughput` plays",
        ),
        p("mis", "power".into(), "balance, power, power:BETA, max"),
        p(
            "strategy",
            "all".into(),
            "S,T: only paths of S vertices from the light and T from the eye",
        ),
        p("weighted", d.weighted.to_string(), "false: strategies are not weighted"),
        p(
            "pyramid",
            d.pyramid.to_string(),
            "true: a layer for each strategy, weighted and not, and a sheet of them; needs max_depth",
        ),
        p(
            "guiding",
            d.guiding.to_string(),
            "true: subpaths from the eye look for caustics where paths from lights say they come from",
        ),
        p("hide_emitters", d.hide_emitters.to_string(), "lights are not seen directly"),
        p(
            "only_depth",
            d.only_depth.to_string(),
            "only paths of exactly this many bounces; -1 all",
        ),
    ]
}
