//! Parameters of Metropolis light transport in primary sample space.

use crate::metropolis::Startup;
use crate::registry::Parameter;
use crate::roulette::{Roulette, Survival};
use crate::strategies::Settings;
use kaustika_sampling::Heuristic;
use serde::Deserialize;

/// What makes a path of the numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Over {
    /// Path tracing.
    Path,
    /// Bidirectional path tracing.
    #[default]
    Bdpt,
}

/// Where light of at most one bounce comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direct {
    /// From a sample of bidirectional path tracing for each pixel and pass; chains leave it out.
    #[default]
    Separate,
    /// From the chains.
    Together,
}

/// Everything that can be set with `-p KEY=VALUE`; `over`, `rr_depth` and `roulette` are `pssmlt`'s.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PrimaryParams {
    /// What makes a path of the numbers.
    pub over: Over,
    /// Longest path, counted as pbrt does; -1 no limit.
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub max_depth: i64,
    /// Only paths of exactly this many bounces; -1 all.
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub only_depth: i64,
    /// No Russian roulette before more than this many bounces of a subpath.
    pub rr_depth: u32,
    /// Survival rule.
    pub roulette: Survival,
    /// Lights are not seen directly.
    pub hide_emitters: bool,
    /// Where light of at most one bounce comes from.
    pub direct: Direct,
    /// Chains, at most one a pixel.
    #[serde(deserialize_with = "crate::registry::count")]
    pub chains: u32,
    /// Steps a pixel in each pass.
    #[serde(deserialize_with = "crate::registry::count")]
    pub steps: u32,
    /// Candidates for their starts.
    #[serde(deserialize_with = "crate::registry::count")]
    pub bootstrap: u32,
    /// Relative standard error of the picture's brightness for which more candidates are taken.
    #[serde(deserialize_with = "probability")]
    pub brightness_error: f64,
    /// Steps for each candidate after which chains start afresh, at candidates of their own; 0: never.
    pub renew: u32,
    /// How chains start.
    pub startup: Startup,
    /// Steps of each chain that are left out with `startup=discard`.
    pub discard: u32,
    /// True: subpaths from the eye look for caustics where paths from lights say they come from.
    pub guiding: bool,
    /// Probability of a large step, in (0, 1].
    #[serde(deserialize_with = "probability")]
    pub large_step: f64,
    /// Largest small step, in (0, 0.5]; where it is learned, what learning begins with.
    #[serde(deserialize_with = "step")]
    pub small_step: f64,
    /// True: the size of small steps is learned before the first pass.
    pub adapt: bool,
}

impl Default for PrimaryParams {
    fn default() -> Self {
        PrimaryParams {
            over: Over::Bdpt,
            max_depth: -1,
            only_depth: -1,
            rr_depth: 1,
            roulette: Survival::Throughput,
            hide_emitters: false,
            direct: Direct::Separate,
            chains: 4096,
            steps: 1,
            bootstrap: 1 << 16,
            brightness_error: 0.03,
            renew: 4,
            startup: Startup::Resample,
            discard: 0,
            guiding: true,
            large_step: 0.3,
            small_step: 1.0 / 64.0,
            adapt: true,
        }
    }
}

impl PrimaryParams {
    /// Bounces of the shortest and longest paths that are wanted.
    pub fn depths(&self) -> [u32; 2] {
        let only = u32::try_from(self.only_depth).ok();
        let most = u32::try_from(self.max_depth).unwrap_or(u32::MAX);
        [only.unwrap_or(0), only.map_or(most, |only| only.min(most))]
    }

    /// Those of the chains.
    pub fn depths_of_chains(&self) -> [u32; 2] {
        let [fewest, most] = self.depths();
        match self.direct {
            Direct::Separate => [fewest.max(2), most],
            Direct::Together => [fewest, most],
        }
    }

    /// Those that are not the chains', if any are left.
    pub fn depths_of_direct(&self) -> Option<[u32; 2]> {
        let [fewest, most] = self.depths();
        let depths = [fewest, most.min(1)];
        (self.direct == Direct::Separate && depths[0] <= depths[1]).then_some(depths)
    }

    /// What is asked of pairs of subpaths of so many bounces.
    pub fn settings(&self, depths: [u32; 2]) -> Settings {
        let roulette =
            Roulette { survival: self.roulette, rr_depth: self.rr_depth, threshold: 0.4 };
        Settings {
            depths,
            roulette,
            mis: Heuristic::default(),
            strategy: None,
            weighted: true,
            hide_emitters: self.hide_emitters,
        }
    }
}

/// A number in (0, most].
fn above_zero<'de, D: serde::Deserializer<'de>>(d: D, most: f64) -> Result<f64, D::Error> {
    let x = f64::deserialize(d)?;
    match x > 0.0 && x <= most {
        true => Ok(x),
        false => Err(serde::de::Error::custom(format!("{x} is not above 0 and at most {most}"))),
    }
}

/// A number in (0, 1].
pub fn probability<'de, D: serde::Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    above_zero(d, 1.0)
}

fn step<'de, D: serde::Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    above_zero(d, 0.5)
}

/// The parameters of `pssmlt` with their defaults and meanings.
pub fn parameters() -> Vec<Parameter> {
    let d = PrimaryParams::default();
    let mut list = vec![
        Parameter {
            key: "over",
            default: "bdpt".into(),
            help: "what makes a path of the numbers: path, bdpt",
        },
        Parameter {
            key: "rr_depth",
            default: d.rr_depth.to_string(),
            help: "no Russian roulette before more than this many bounces of a subpath",
        },
        Parameter {
            key: "roulette",
            default: "throughput".into(),
            help: "survival rule: none, throughput, albedo",
        },
    ];
    list.extend(common());
    list
}

/// Those of `mmlt`.
pub fn multiplexed_parameters() -> Vec<Parameter> {
    common()
}

/// Those of all methods in primary sample space.
pub fn common() -> Vec<Parameter> {
    let d = PrimaryParams::default();
    let p = |key, default: String, help| Parameter { key, default, help };
    vec![
        p(
            "max_depth",
            d.max_depth.to_string(),
            "longest path as pbrt counts (0 emission, 1 direct light; -1 no limit: 64 where chains keep to a length or to paths); a scene file's own value comes first",
        ),
        p(
            "only_depth",
            d.only_depth.to_string(),
            "only paths of exactly this many bounces; -1 all",
        ),
        p("hide_emitters", d.hide_emitters.to_string(), "lights are not seen directly"),
        p(
            "direct",
            "separate".into(),
            "light of at most one bounce: separate (a sample of bdpt for each pixel and pass), together (by the chains)",
        ),
        p("chains", d.chains.to_string(), "Markov chains, at most one a pixel"),
        p("steps", d.steps.to_string(), "steps of the chains for each pixel and pass"),
        p(
            "bootstrap",
            d.bootstrap.to_string(),
            "samples that tell the picture's brightness and where chains start, at least",
        ),
        p(
            "brightness_error",
            d.brightness_error.to_string(),
            "relative error of the brightness for which up to 16 times as many are taken",
        ),
        p(
            "renew",
            d.renew.to_string(),
            "steps for each of those after which chains start afresh from as many others; as long as they are too few, 1 and as many rays; 0: never",
        ),
        p(
            "startup",
            "resample".into(),
            "resample (no start-up bias), discard (biased: starts anywhere, leaves out first steps)",
        ),
        p("discard", d.discard.to_string(), "steps left out with startup=discard"),
        p(
            "guiding",
            d.guiding.to_string(),
            "true: where chains may start looks for caustics where paths from lights say they come from",
        ),
        p("large_step", d.large_step.to_string(), "probability of a step to anywhere"),
        p(
            "small_step",
            d.small_step.to_string(),
            "largest small step of a number, up to 0.5; where it is learned, the first guess",
        ),
        p(
            "adapt",
            d.adapt.to_string(),
            "true: the size of small steps is learned before the first pass, then kept",
        ),
    ]
}
