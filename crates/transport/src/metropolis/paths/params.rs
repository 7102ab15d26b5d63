//! Parameters of Metropolis light transport in path space.

use super::bidirectional::Lengths;
use crate::metropolis::Startup;
use crate::metropolis::primary::{Direct, common};
use crate::registry::Parameter;
use crate::roulette::{Roulette, Survival};
use crate::strategies::Settings;
use kaustika_sampling::Heuristic;
use serde::Deserialize;

/// A kind of mutation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mutation {
    /// A part is deleted and grown anew.
    Bidirectional,
    /// The eye's end moves on the film.
    Lens,
    /// The light's end moves.
    Caustic,
    /// The eye's end moves, and at each D before an S the direction.
    MultiChain,
    /// The eye's end is made anew, from anywhere on the film.
    LensSubpath,
    /// A vertex moves, and what is clear or mirrors beside it follows.
    Manifold,
}

impl Mutation {
    /// All of them.
    pub const ALL: [Mutation; 6] = [
        Mutation::Bidirectional,
        Mutation::Lens,
        Mutation::Caustic,
        Mutation::MultiChain,
        Mutation::LensSubpath,
        Mutation::Manifold,
    ];

    /// As parameters name it.
    pub fn name(self) -> &'static str {
        match self {
            Mutation::Bidirectional => "bidirectional",
            Mutation::Lens => "lens",
            Mutation::Caustic => "caustic",
            Mutation::MultiChain => "multichain",
            Mutation::LensSubpath => "subpath",
            Mutation::Manifold => "manifold",
        }
    }
}

/// Bounces of the longest paths: longer ones carry next to nothing.
const LONGEST: u32 = 64;

/// Everything that can be set with `-p KEY=VALUE`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PathParams {
    /// Longest path, counted as pbrt does; -1 no limit (64).
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub max_depth: i64,
    /// Only paths of exactly this many bounces; -1 all.
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub only_depth: i64,
    /// Lights are not seen directly.
    pub hide_emitters: bool,
    /// Where light of one bounce comes from; what is seen directly is always separate.
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
    #[serde(deserialize_with = "crate::metropolis::primary::probability")]
    pub brightness_error: f64,
    /// Steps for each candidate after which chains start afresh, at candidates of their own; 0: never.
    pub renew: u32,
    /// How chains start.
    pub startup: Startup,
    /// Steps of each chain that are left out with `startup=discard`.
    pub discard: u32,
    /// True: every other candidate looks for caustics where paths from lights say they come from.
    pub guiding: bool,
    /// The kinds of mutations, equally likely.
    #[serde(deserialize_with = "mutations")]
    pub mutations: Vec<Mutation>,
}

/// Everything that can be set of energy redistribution.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Erpt {
    /// As [`PathParams::max_depth`].
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub max_depth: i64,
    /// As [`PathParams::only_depth`].
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub only_depth: i64,
    /// As [`PathParams::hide_emitters`].
    pub hide_emitters: bool,
    /// As [`PathParams::direct`].
    pub direct: Direct,
    /// Paths that tell what light a chain has.
    #[serde(deserialize_with = "crate::registry::count")]
    pub bootstrap: u32,
    /// Steps of a chain.
    #[serde(deserialize_with = "crate::registry::count")]
    pub chain_length: u32,
    /// As [`PathParams::guiding`].
    pub guiding: bool,
    /// As [`PathParams::mutations`].
    #[serde(deserialize_with = "mutations")]
    pub mutations: Vec<Mutation>,
}

impl Default for Erpt {
    fn default() -> Self {
        let PathParams { max_depth, only_depth, hide_emitters, direct, bootstrap, guiding, .. } =
            PathParams::default();
        Erpt {
            max_depth,
            only_depth,
            hide_emitters,
            direct,
            bootstrap,
            chain_length: 100,
            guiding,
            mutations: vec![Mutation::Lens, Mutation::Caustic, Mutation::MultiChain],
        }
    }
}

impl Erpt {
    /// Those of the paths.
    pub(super) fn paths(&self) -> PathParams {
        PathParams {
            max_depth: self.max_depth,
            only_depth: self.only_depth,
            hide_emitters: self.hide_emitters,
            direct: self.direct,
            bootstrap: self.bootstrap,
            guiding: self.guiding,
            mutations: self.mutations.clone(),
            ..PathParams::default()
        }
    }
}

impl Default for PathParams {
    fn default() -> Self {
        PathParams {
            max_depth: -1,
            only_depth: -1,
            hide_emitters: false,
            direct: Direct::Separate,
            chains: 4096,
            steps: 4,
            bootstrap: 1 << 16,
            brightness_error: 0.03,
            renew: 4,
            startup: Startup::Resample,
            discard: 0,
            guiding: true,
            mutations: Mutation::ALL.to_vec(),
        }
    }
}

impl PathParams {
    fn depths(&self) -> [u32; 2] {
        let only = u32::try_from(self.only_depth).ok();
        let most = u32::try_from(self.max_depth).unwrap_or(LONGEST).min(LONGEST);
        [only.unwrap_or(0), only.map_or(most, |only| only.min(most))]
    }

    /// Bounces of the longest path.
    pub fn max_bounces(&self) -> u32 {
        self.depths()[1]
    }

    /// Inner vertices of the chains' paths; none if there are no such paths.
    pub(super) fn lengths(&self) -> Option<Lengths> {
        let [fewest, most] = self.depths().map(|d| d as usize);
        let fewest = fewest.max(if self.direct == Direct::Separate { 2 } else { 1 });
        (fewest <= most).then_some(Lengths { fewest, most })
    }

    /// What chains leave to bidirectional path tracing.
    pub fn settings_of_direct(&self) -> Option<Settings> {
        let [fewest, most] = self.depths();
        let most = most.min(if self.direct == Direct::Separate { 1 } else { 0 });
        (fewest <= most).then(|| Settings {
            depths: [fewest, most],
            roulette: Roulette { survival: Survival::None, rr_depth: 1, threshold: 1.0 },
            mis: Heuristic::default(),
            strategy: None,
            weighted: true,
            hide_emitters: self.hide_emitters,
        })
    }
}

/// Names with + between them, or `all`.
fn mutations<'de, D: serde::Deserializer<'de>>(d: D) -> Result<Vec<Mutation>, D::Error> {
    let text = String::deserialize(d)?;
    if text == "all" {
        return Ok(Mutation::ALL.to_vec());
    }
    let one = |name: &str| {
        let found = Mutation::ALL.into_iter().find(|m| m.name() == name);
        found.ok_or_else(|| {
            let known = Mutation::ALL.map(Mutation::name).join(", ");
            serde::de::Error::custom(format!(
                "`{name}` is no mutation; known: {known}, with + between them, or all"
            ))
        })
    };
    text.split('+').map(|name| one(name.trim())).collect()
}

/// The parameters with their defaults and meanings.
pub fn parameters() -> Vec<Parameter> {
    let only_primary = ["large_step", "small_step", "adapt"];
    let mut list = common();
    list.retain(|p| !only_primary.contains(&p.key));
    let own = PathParams::default();
    list.iter_mut().filter(|p| p.key == "steps").for_each(|p| p.default = own.steps.to_string());
    list.push(Parameter {
        key: "mutations",
        default: "all".into(),
        help: "kinds of mutations: bidirectional, lens, caustic, multichain, subpath, manifold, with + between them, or all; without bidirectional parts may be left out",
    });
    list
}

/// Those of energy redistribution.
pub fn erpt_parameters() -> Vec<Parameter> {
    let kept = ["max_depth", "only_depth", "hide_emitters", "direct", "bootstrap", "guiding"];
    let mut list = common();
    list.retain(|p| kept.contains(&p.key));
    list.push(Parameter {
        key: "chain_length",
        default: Erpt::default().chain_length.to_string(),
        help: "steps of the chains that start where a path was found",
    });
    list.push(Parameter {
        key: "mutations",
        default: "lens+caustic+multichain".into(),
        help: "kinds of mutations: bidirectional, lens, caustic, multichain, subpath, manifold, with + between them, or all",
    });
    list
}
