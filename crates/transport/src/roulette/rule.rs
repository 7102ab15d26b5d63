//! The rules by name, and what they decide.

use super::efficiency::{self, Totals};
use super::{Survival, window, winners};
use crate::guiding::Expected;
use serde::{Deserialize, Serialize};

/// How paths end and split.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// Paths end only by depth or absorption.
    None,
    /// By the path's throughput (Arvo & Kirk 1990).
    #[default]
    Throughput,
    /// By the surface's albedo (Jensen 2001).
    Albedo,
    /// By albedo and roughness, with splitting (Szirmay-Kalos & Antal 2005).
    SzirmayKalos,
    /// By the light that is still to come (Vorba & Křivánek 2016).
    Adjoint,
    /// By its variance and cost (Rath et al. 2022).
    Efficiency,
}

impl Rule {
    /// The rule that plays after each bounce, where this is one.
    pub fn survival(self) -> Option<Survival> {
        match self {
            Rule::None => Some(Survival::None),
            Rule::Throughput => Some(Survival::Throughput),
            Rule::Albedo => Some(Survival::Albedo),
            Rule::SzirmayKalos | Rule::Adjoint | Rule::Efficiency => None,
        }
    }

    /// True if it asks what is still to come.
    pub fn learns(self) -> bool {
        matches!(self, Rule::Adjoint | Rule::Efficiency)
    }
}

/// A path where it arrives, as rules that split see it.
#[derive(Clone, Copy, Debug)]
pub struct Collision {
    /// Its weight ν.
    pub weight: f32,
    /// I, the value of what it contributes to.
    pub measurement: f32,
    /// What one continuation is expected to be worth; `None` if that is not known well enough.
    pub expected: Option<Expected>,
    /// Albedo of the surface.
    pub albedo: f32,
    /// Roughness of the surface.
    pub roughness: f32,
    /// Vertices before this one that scattered the path, mirrors and clear glass not counted.
    pub scattered: u32,
}

/// Decisions of the rules that split.
#[derive(Clone, Copy, Debug)]
pub struct Splitting {
    /// Which rule.
    pub rule: Rule,
    /// False: roulette alone (ADRR).
    pub splits: bool,
    /// Size of the weight window.
    pub window: f32,
    /// Of the picture, as far as it is known.
    pub totals: Option<Totals>,
}

/// What becomes of a path that arrives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Decision {
    /// ⌊q + ξ⌋ copies of weight ν/q.
    Copies(f32),
    /// The rule knows nothing here: roulette by throughput.
    Unknown,
}

/// Least q: whatever an estimate says, a contribution stays possible.
const LEAST: f32 = 0.05;
/// Most copies at a vertex.
const MOST: f32 = 20.0;

impl Splitting {
    /// Least q by efficiency: that of the weight window, for a path whose expected share is `z`. M
    /// and V are seldom known well: most records miss the bright light that makes them, and a rule
    /// that believes them ends the paths that would find it, and lets pass great weights.
    fn least(&self, z: f32, scattered: u32) -> f32 {
        if scattered == 0 { 1.0 } else { window::factor(z, self.window) }
    }

    /// q at a vertex.
    #[inline]
    pub fn decide(&self, c: &Collision) -> Decision {
        let q = match (self.rule, &c.expected) {
            (Rule::SzirmayKalos, _) => winners::factor(c.weight, c.albedo, c.roughness),
            // The first is what the pixel's value is made of: q = 1 but for errors.
            (Rule::Adjoint, _) if c.scattered == 0 => 1.0,
            (Rule::Adjoint, Some(e)) => {
                window::factor(c.weight * e.mean / c.measurement, self.window)
            }
            (Rule::Efficiency, Some(e)) => match &self.totals {
                Some(totals) => {
                    let t = c.weight / c.measurement;
                    efficiency::factor(t, e, totals).max(self.least(t * e.mean, c.scattered))
                }
                None => return Decision::Unknown,
            },
            _ => return Decision::Unknown,
        };
        if !q.is_finite() {
            return Decision::Unknown;
        }
        Decision::Copies(q.clamp(LEAST, if self.splits { MOST } else { 1.0 }))
    }
}
