//! Parameters of hybrids.

use crate::particle::photon_map::PhotonMapParams;
use crate::registry::{Parameter, at_least_two, count, positive};
use serde::Deserialize;

/// Everything that can be set with `-p KEY=VALUE`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HybridParams {
    /// The terms, or the name of a preset; see [`super::term`].
    pub terms: String,
    /// What they are to part; empty: what the preset says, or L(D|S)*E.
    pub of: String,
    /// Patches of fields by radiosity.
    #[serde(deserialize_with = "count")]
    pub patches: u32,
    /// Rays of a row of form factors.
    #[serde(deserialize_with = "count")]
    pub form_rays: u32,
    /// What shooting leaves, as a part of all.
    #[serde(deserialize_with = "positive")]
    pub tolerance: f32,
    /// Photons emitted: of a pass for fields by photons; sixteen times as many fall on patches by way
    /// of mirrors and glass.
    #[serde(deserialize_with = "count")]
    pub photons: u32,
    /// Photons of an estimate, at least 2.
    #[serde(deserialize_with = "at_least_two")]
    pub nearest: usize,
    /// The farthest of them, as a share of the scene's radius.
    #[serde(deserialize_with = "positive")]
    pub radius: f32,
    /// How fast radii shrink over the passes: r² ~ iᵅ⁻¹, in (0, 1]; 1 keeps them.
    #[serde(deserialize_with = "positive")]
    pub alpha: f32,
    /// Allowed error of irradiance caches.
    #[serde(deserialize_with = "positive")]
    pub cache: f32,
    /// Rays of a record of theirs.
    #[serde(deserialize_with = "count")]
    pub cache_rays: u32,
    /// True: lights are not seen directly.
    pub hide_emitters: bool,
}

impl Default for HybridParams {
    fn default() -> Self {
        HybridParams {
            terms: "chen".into(),
            of: String::new(),
            patches: 5_000,
            form_rays: 1024,
            tolerance: 1e-3,
            photons: 100_000,
            nearest: 30,
            radius: 0.02,
            alpha: 0.75,
            cache: 0.2,
            cache_rays: 512,
            hide_emitters: false,
        }
    }
}

impl HybridParams {
    /// How photons are read.
    pub fn reading(&self) -> PhotonMapParams {
        PhotonMapParams {
            nearest: self.nearest,
            radius: self.radius,
            alpha: self.alpha,
            ..PhotonMapParams::default()
        }
    }

    /// How irradiance is cached.
    pub fn caching(&self) -> PhotonMapParams {
        PhotonMapParams {
            photons: self.photons,
            cache: self.cache,
            cache_rays: self.cache_rays,
            ..self.reading()
        }
    }
}

/// The parameters with their defaults and meanings.
pub fn parameters() -> Vec<Parameter> {
    let d = HybridParams::default();
    let p = |key, default: String, help| Parameter { key, default, help };
    vec![
        p(
            "terms",
            d.terms,
            "NAME=METHOD(KEY=VALUE,...):CLASS;... or photons@N:CLASS, radiosity@N:CLASS, cache@N:CLASS, fields at the N-th diffuse surface; or chen, chen-preview, chen-direct, wallace, sillion-puech",
        ),
        p("of", "L(D|S)*E".into(), "the paths that the terms part among them"),
        p("patches", d.patches.to_string(), "patches of radiosity@N"),
        p("form_rays", d.form_rays.to_string(), "rays of a row of form factors"),
        p("tolerance", d.tolerance.to_string(), "what shooting leaves, as a part of all light"),
        p(
            "photons",
            d.photons.to_string(),
            "photons emitted for photons@N and cache@N in a pass; 16 times as many for the caustics of radiosity@N",
        ),
        p("nearest", d.nearest.to_string(), "photons of an estimate, at least 2"),
        p("radius", d.radius.to_string(), "the farthest of them, as a share of the scene's radius"),
        p(
            "alpha",
            d.alpha.to_string(),
            "how fast radii shrink: r² falls as i^(alpha - 1) over the passes i; 1 keeps them",
        ),
        p("cache", d.cache.to_string(), "allowed error of cache@N, 0.05 to 0.5"),
        p("cache_rays", d.cache_rays.to_string(), "rays of a record of cache@N"),
        p("hide_emitters", d.hide_emitters.to_string(), "lights are not seen directly"),
    ]
}
