//! The light tracer's parameters.

use crate::registry::Parameter;
use crate::roulette::{Roulette, Rule, Survival, window};
use serde::Deserialize;

/// Everything that can be set with `-p KEY=VALUE`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LightParams {
    /// Longest path, counted as pbrt does: 1 direct light; -1 no limit.
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub max_depth: i64,
    /// No Russian roulette by throughput or albedo before more than this many bounces.
    pub rr_depth: u32,
    /// How paths end and split.
    pub roulette: Rule,
    /// Throughput below which the rule `throughput` plays, above 0.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub rr_threshold: f32,
    /// False: paths must meet the lens by themselves.
    pub nee: bool,
    /// Only paths of exactly this many bounces; -1 all.
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub only_depth: i64,
    /// True: emission and scattering are guided by the importance that was learned.
    pub guiding: bool,
    /// Passes that are learned from.
    pub training: u64,
    /// False: paths are never split.
    pub splitting: bool,
    /// Size of the weight window of the rule `adjoint`, above 1.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub window: f32,
}

impl Default for LightParams {
    fn default() -> Self {
        LightParams {
            max_depth: -1,
            rr_depth: 1,
            roulette: Rule::Throughput,
            rr_threshold: 0.4,
            nee: true,
            only_depth: -1,
            guiding: false,
            training: 127,
            splitting: true,
            window: window::SIZE,
        }
    }
}

impl LightParams {
    /// Most surfaces that a path meets.
    pub(super) fn max_bounces(&self) -> usize {
        let most = usize::try_from(self.max_depth).ok();
        [most, self.only_bounces()].into_iter().flatten().min().unwrap_or(usize::MAX)
    }

    /// The number of surfaces of all paths that show, if only such are to.
    pub(super) fn only_bounces(&self) -> Option<usize> {
        usize::try_from(self.only_depth).ok()
    }

    /// Roulette after the bounce: the rule if it is of that kind, else by throughput.
    pub(super) fn roulette(&self) -> Roulette {
        Roulette {
            survival: self.roulette.survival().unwrap_or(Survival::Throughput),
            rr_depth: self.rr_depth,
            threshold: self.rr_threshold,
        }
    }
}

/// The parameters with their defaults and meanings.
pub fn parameters() -> Vec<Parameter> {
    let d = LightParams::default();
    let p = |key, default: String, help| Parameter { key, default, help };
    vec![
        p(
            "max_depth",
            d.max_depth.to_string(),
            "longest path as pbrt counts (1 direct light; -1 no limit); a scene file's own value comes first",
        ),
        p(
            "rr_depth",
            d.rr_depth.to_string(),
            "no Russian roulette by throughput or albedo before more than this many bounces",
        ),
        p(
            "roulette",
            "throughput".into(),
            "how paths end and split: none, throughput, albedo, szirmay-kalos, adjoint, efficiency",
        ),
        p(
            "rr_threshold",
            d.rr_threshold.to_string(),
            "throughput below which the rule `throughput` plays",
        ),
        p(
            "nee",
            d.nee.to_string(),
            "false: paths are not connected to the lens but must meet it, which needs a lens with an area",
        ),
        p(
            "only_depth",
            d.only_depth.to_string(),
            "only paths of exactly this many bounces; -1 all",
        ),
        p(
            "guiding",
            d.guiding.to_string(),
            "true: light leaves its sources and scatters where earlier passes found that it shows",
        ),
        p(
            "training",
            d.training.to_string(),
            "passes that are learned from, with a guide or a rule that splits; they count as others do",
        ),
        p("splitting", d.splitting.to_string(), "false: rules that split play roulette alone"),
        p("window", d.window.to_string(), "size of the weight window of the rule `adjoint`"),
    ]
}
