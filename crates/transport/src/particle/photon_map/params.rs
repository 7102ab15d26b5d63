//! Parameters of photon mapping.

use crate::nearest::Layout;
use crate::registry::{Parameter, count};
use crate::roulette::{Roulette, Rule, Survival, window};
use serde::{Deserialize, Deserializer, de::Error};

/// How photons near a place are weighted by their distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Filter {
    /// All alike.
    Box,
    /// Less by distance (Jensen 1996).
    #[default]
    Cone,
    /// As a bell (Pavicic 1990, as Jensen has it).
    Gauss,
}

/// Everything that can be set with `-p KEY=VALUE`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PhotonMapParams {
    /// Photons emitted for the global map of a pass.
    #[serde(deserialize_with = "count")]
    pub photons: u32,
    /// Photons emitted for the caustic map of a pass.
    #[serde(deserialize_with = "count")]
    pub caustic_photons: u32,
    /// Photons of an estimate from the global map, at least 2.
    #[serde(deserialize_with = "crate::registry::at_least_two")]
    pub nearest: usize,
    /// Those of one from the caustic map, at least 2.
    #[serde(deserialize_with = "crate::registry::at_least_two")]
    pub caustic_nearest: usize,
    /// Farthest photon of an estimate from the global map, as a share of the scene's radius.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub radius: f32,
    /// That of one from the caustic map.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub caustic_radius: f32,
    /// How fast radii shrink over the passes: r² ~ iᵅ⁻¹, in (0, 1]; 1 keeps them.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub alpha: f32,
    /// Filter of estimates.
    pub filter: Filter,
    /// True: estimates end where farther photons only push them one way.
    pub checking: bool,
    /// Where photons are kept.
    pub search: Layout,
    /// Rays of a final gather; 0 reads the global map where it is seen.
    pub gather: u32,
    /// True: half of the gather's rays go where photons came from.
    pub guide: bool,
    /// Throughput below which a surface is not worth a gather and reads the global map.
    pub weak: f32,
    /// Glossy surfaces at least this rough count as matte: photons stay on them.
    pub matte: f32,
    /// Allowed error of the irradiance cache; 0 gathers at every sample.
    #[serde(deserialize_with = "not_negative")]
    pub cache: f32,
    /// Rays of a record of the cache.
    #[serde(deserialize_with = "count")]
    pub cache_rays: u32,
    /// Passes that share maps and cache; spectral pictures renew them in each.
    #[serde(deserialize_with = "count")]
    pub renew: u32,
    /// Longest path, counted as pbrt does: 0 emission only, 1 direct light; -1 no limit.
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub max_depth: i64,
    /// No Russian roulette before more than this many bounces of an eye path.
    pub rr_depth: u32,
    /// How paths end and split: eye paths by rules that look at their past alone, photons by the
    /// others, and by all if they are guided. Photons that nothing guides or splits always play so
    /// that their power stays.
    pub roulette: Rule,
    /// Throughput below which the rule `throughput` plays, above 0.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub rr_threshold: f32,
    /// True: lights are not seen directly.
    pub hide_emitters: bool,
    /// Only paths of exactly this many bounces; -1 all.
    #[serde(deserialize_with = "crate::registry::bounces")]
    pub only_depth: i64,
    /// True: photons leave the lights and scatter where earlier passes found that they are read.
    pub guiding: bool,
    /// Passes that are learned from.
    pub training: u64,
    /// False: photons are never split.
    pub splitting: bool,
    /// Size of the weight window of the rule `adjoint`, above 1.
    #[serde(deserialize_with = "crate::registry::positive")]
    pub window: f32,
}

impl Default for PhotonMapParams {
    fn default() -> Self {
        PhotonMapParams {
            photons: 100_000,
            caustic_photons: 100_000,
            nearest: 50,
            caustic_nearest: 30,
            radius: 0.1,
            caustic_radius: 0.02,
            alpha: 0.75,
            filter: Filter::Cone,
            checking: false,
            search: Layout::Buckets,
            gather: 4,
            guide: true,
            weak: 0.05,
            matte: 0.4,
            cache: 0.0,
            cache_rays: 512,
            renew: 1,
            max_depth: -1,
            rr_depth: 3,
            roulette: Rule::Throughput,
            rr_threshold: 0.4,
            hide_emitters: false,
            only_depth: -1,
            guiding: false,
            training: 31,
            splitting: true,
            window: window::SIZE,
        }
    }
}

fn not_negative<'de, D: Deserializer<'de>>(d: D) -> Result<f32, D::Error> {
    let x = f32::deserialize(d)?;
    match x >= 0.0 && x.is_finite() {
        true => Ok(x),
        false => Err(D::Error::custom(format!("{x} is not 0 or a number above it"))),
    }
}

impl PhotonMapParams {
    /// Bounces of the longest path that is wanted.
    pub fn max_bounces(&self) -> u32 {
        [self.max_depth, self.only_depth]
            .into_iter()
            .filter_map(|d| u32::try_from(d).ok())
            .fold(u32::MAX, u32::min)
    }

    /// Roulette after the bounce: the rule if it is of that kind, else by throughput.
    pub fn roulette(&self) -> Roulette {
        Roulette {
            survival: self.roulette.survival().unwrap_or(Survival::Throughput),
            rr_depth: self.rr_depth,
            threshold: self.rr_threshold,
        }
    }

    /// What the radii of a pass are to those of the first (Knaus & Zwicker 2011).
    pub fn shrink(&self, pass: u64) -> f32 {
        ((pass + 1) as f64).powf(0.5 * (f64::from(self.alpha.min(1.0)) - 1.0)) as f32
    }
}

/// The parameters with their defaults and meanings.
pub fn parameters() -> Vec<Parameter> {
    let d = PhotonMapParams::default();
    let p = |key, default: String, help| Parameter { key, default, help };
    vec![
        p("photons", d.photons.to_string(), "photons emitted for the global map of a pass"),
        p("caustic_photons", d.caustic_photons.to_string(), "those emitted for the caustic map"),
        p("nearest", d.nearest.to_string(), "photons of an estimate from the global map"),
        p("caustic_nearest", d.caustic_nearest.to_string(), "those of one from the caustic map"),
        p(
            "radius",
            d.radius.to_string(),
            "farthest photon of an estimate from the global map, as a share of the scene's radius",
        ),
        p("caustic_radius", d.caustic_radius.to_string(), "that of one from the caustic map"),
        p(
            "alpha",
            d.alpha.to_string(),
            "how fast radii shrink: r² falls as i^(alpha - 1) over the passes i; 1 keeps them",
        ),
        p("filter", "cone".into(), "filter of estimates: box, cone, gauss"),
        p(
            "checking",
            d.checking.to_string(),
            "estimates end where farther photons only push them one way (differential checking)",
        ),
        p("search", "buckets".into(), "where photons are kept: buckets, median, heap, grid"),
        p(
            "gather",
            d.gather.to_string(),
            "rays of a final gather; 0 reads the global map where it is seen",
        ),
        p("guide", d.guide.to_string(), "half of the gather's rays go where photons came from"),
        p(
            "weak",
            d.weak.to_string(),
            "throughput below which a surface reads the global map instead of gathering",
        ),
        p(
            "matte",
            d.matte.to_string(),
            "glossy surfaces at least this rough (0 to 1) count as matte",
        ),
        p(
            "cache",
            d.cache.to_string(),
            "allowed error of the irradiance cache, 0.05 to 0.5; 0 gathers at every sample",
        ),
        p("cache_rays", d.cache_rays.to_string(), "rays of a record of the irradiance cache"),
        p(
            "renew",
            d.renew.to_string(),
            "passes that share maps and cache; spectral pictures renew them in each",
        ),
        p(
            "max_depth",
            d.max_depth.to_string(),
            "longest path as pbrt counts (0 emission, 1 direct light; -1 no limit); a scene file's own value comes first",
        ),
        p(
            "rr_depth",
            d.rr_depth.to_string(),
            "no Russian roulette before more than this many bounces of an eye path",
        ),
        p(
            "roulette",
            "throughput".into(),
            "how eye paths end, and guided photons: none, throughput, albedo; how photons end and split: szirmay-kalos, adjoint, efficiency",
        ),
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
        p(
            "guiding",
            d.guiding.to_string(),
            "true: photons leave the lights and scatter where earlier passes found that they are read",
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
