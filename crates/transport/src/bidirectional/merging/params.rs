//! Parameters of vertex connection and merging.

use crate::registry::Parameter;
use crate::roulette::{Roulette, Survival};
use serde::Deserialize;

/// Which strategies take part; names as in SmallVCM.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mode {
    /// All.
    #[default]
    Vcm,
    /// Connections alone: bidirectional path tracing.
    Bpt,
    /// Merges alone, at every vertex: bidirectional photon mapping.
    Bpm,
    /// Merges alone, at the first vertex of the eye path that is no mirror: progressive photon
    /// mapping.
    Ppm,
}

impl Mode {
    /// True if vertices are connected.
    pub fn connects(self) -> bool {
        matches!(self, Mode::Vcm | Mode::Bpt)
    }

    /// True if vertices are merged.
    pub fn merges(self) -> bool {
        self != Mode::Bpt
    }
}

/// The weights' heuristic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Heuristic {
    /// In proportion to the densities.
    Balance,
    /// To their squares.
    Power,
}

/// Everything that can be set with `-p KEY=VALUE`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VcmParams {
    /// Which strategies take part.
    pub mode: Mode,
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
    pub mis: Heuristic,
    /// Radius of the first pass's merges, as a share of the scene's radius.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub radius: f32,
    /// How fast it shrinks: pass i has radius · iᵅ⁻¹ᐟ² of the first, in (0, 1]; 1 keeps it.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub alpha: f32,
    /// True: lights are not seen directly.
    pub hide_emitters: bool,
    /// Only paths of exactly this many bounces; -1 all.
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub only_depth: i64,
}

impl Default for VcmParams {
    fn default() -> Self {
        VcmParams {
            mode: Mode::Vcm,
            max_depth: -1,
            rr_depth: 1,
            roulette: Survival::Throughput,
            rr_threshold: 0.4,
            mis: Heuristic::Balance,
            radius: 0.003,
            alpha: 0.75,
            hide_emitters: false,
            only_depth: -1,
        }
    }
}

impl VcmParams {
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

    /// Radius of the merges of a pass (Knaus & Zwicker 2011, with r² ~ iᵅ⁻¹).
    pub fn radius(&self, scene_radius: f32, pass: u64) -> f32 {
        let i = (pass + 1) as f64;
        let shrink = i.powf(0.5 * (f64::from(self.alpha.min(1.0)) - 1.0));
        self.radius * scene_radius * shrink as f32
    }
}

/// The parameters with their defaults and meanings.
pub fn parameters() -> Vec<Parameter> {
    let mode = Parameter {
        key: "mode",
        default: "vcm".into(),
        help: "vcm; bpt: connections alone; bpm: merges alone; ppm: merges alone, at the first vertex that is no mirror",
    };
    let mis = Parameter { key: "mis", default: "balance".into(), help: "balance, power" };
    let mut all = vec![mode, mis];
    all.extend(ppm_parameters());
    all
}

/// Those that progressive photon mapping shares.
pub fn ppm_parameters() -> Vec<Parameter> {
    let d = VcmParams::default();
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
        p(
            "radius",
            d.radius.to_string(),
            "radius of the first pass's merges, as a share of the scene's radius",
        ),
        p(
            "alpha",
            d.alpha.to_string(),
            "how fast it shrinks: r² falls as i^(alpha - 1) over the passes i; 1 keeps it",
        ),
        p("hide_emitters", d.hide_emitters.to_string(), "lights are not seen directly"),
        p(
            "only_depth",
            d.only_depth.to_string(),
            "only paths of exactly this many bounces; -1 all",
        ),
    ]
}
