//! The guided path tracer's parameters.

use crate::guiding::FieldKind;
use crate::path::PathParams;
use crate::registry::Parameter;
use crate::roulette::{Rule, window};
use kaustika_sampling::MisHeuristic;
use serde::Deserialize;

/// Everything that can be set with `-p KEY=VALUE`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GuidedParams {
    /// Longest path, counted as pbrt does: 0 emission only, 1 direct light; -1 no limit.
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub max_depth: i64,
    /// No Russian roulette by throughput or albedo before more than this many bounces.
    pub rr_depth: u32,
    /// How paths end and split.
    pub roulette: Rule,
    /// Throughput below which the rule `throughput` plays, above 0.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub rr_threshold: f32,
    /// How light and other samples are weighted.
    #[serde(deserialize_with = "crate::path::params::heuristic")]
    pub mis: MisHeuristic,
    /// True: lights are not seen directly.
    pub hide_emitters: bool,
    /// Only paths of exactly this many bounces; -1 all.
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub only_depth: i64,
    /// How incident light is learned.
    pub field: FieldKind,
    /// Passes that are learned from.
    pub training: u64,
    /// Passes before a rule plays that learns.
    pub warmup: u64,
    /// True: plain paths go on where learning does not pay.
    pub fallback: bool,
    /// False: paths are never split.
    pub splitting: bool,
    /// Size of the weight window of the rule `adjoint`, above 1.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub window: f32,
}

impl Default for GuidedParams {
    fn default() -> Self {
        let path = PathParams::default();
        GuidedParams {
            max_depth: path.max_depth,
            rr_depth: path.rr_depth,
            roulette: Rule::Adjoint,
            rr_threshold: path.rr_threshold,
            mis: path.mis,
            hide_emitters: path.hide_emitters,
            only_depth: path.only_depth,
            field: FieldKind::default(),
            training: 127,
            warmup: 31,
            fallback: true,
            splitting: true,
            window: window::SIZE,
        }
    }
}

impl GuidedParams {
    /// As the path tracer takes them.
    pub(super) fn of_path(&self) -> PathParams {
        PathParams {
            max_depth: self.max_depth,
            rr_depth: self.rr_depth,
            roulette: self.roulette,
            rr_threshold: self.rr_threshold,
            mis: self.mis,
            hide_emitters: self.hide_emitters,
            only_depth: self.only_depth,
            polarized: false,
        }
    }
}

impl From<PathParams> for GuidedParams {
    /// A path tracer with a rule that splits: nothing guides it.
    fn from(p: PathParams) -> GuidedParams {
        GuidedParams {
            max_depth: p.max_depth,
            rr_depth: p.rr_depth,
            roulette: p.roulette,
            rr_threshold: p.rr_threshold,
            mis: p.mis,
            hide_emitters: p.hide_emitters,
            only_depth: p.only_depth,
            field: FieldKind::None,
            fallback: false,
            ..GuidedParams::default()
        }
    }
}

/// The parameters with their defaults and meanings.
pub fn parameters() -> Vec<Parameter> {
    let d = GuidedParams::default();
    let p = |key, default: String, help| Parameter { key, default, help };
    let mut all: Vec<Parameter> = crate::path::parameters()
        .into_iter()
        .filter(|p| p.key != "polarized")
        .map(|of_path| match of_path.key {
            "roulette" => Parameter { default: "adjoint".into(), ..of_path },
            _ => of_path,
        })
        .collect();
    all.extend([
        p(
            "field",
            "mixture".into(),
            "how incident light is learned: none (directions by the BSDF alone), quadtree, mixture",
        ),
        p(
            "training",
            d.training.to_string(),
            "passes that are learned from; they count as others do",
        ),
        p(
            "warmup",
            d.warmup.to_string(),
            "passes before `adjoint` or `efficiency` plays where directions are learned; there no path ends early",
        ),
        p(
            "fallback",
            d.fallback.to_string(),
            "true: if 3, 15, 31 or 127 passes show that learning does not pay, plain paths go on",
        ),
        p("splitting", d.splitting.to_string(), "false: rules that split play roulette alone"),
        p("window", d.window.to_string(), "size of the weight window of the rule `adjoint`"),
    ]);
    all
}
