//! Weights of multiple importance sampling (Veach & Guibas, "Optimally Combining Sampling
//! Techniques for Monte Carlo Rendering", 1995).
//!
//! ```text
//! ∫f ≈ Σᵢ 1/nᵢ Σⱼ wᵢ(xᵢⱼ) f(xᵢⱼ)/pᵢ(xᵢⱼ),    Σᵢ wᵢ(x) = 1,  wᵢ(x) = 0 where pᵢ(x) = 0
//! balance  wᵢ = nᵢpᵢ / Σₖ nₖpₖ
//! power    wᵢ = (nᵢpᵢ)ᵝ / Σₖ (nₖpₖ)ᵝ        β = 1 balance, β = ∞ maximum
//! maximum  wᵢ = 1 where nᵢpᵢ is the greatest, the first of equals
//! ```
//!
//! All functions take the products q = np, in one measure. The weights sum to 1 up to rounding
//! wherever a q is positive and vanish with it, for any q in [0, ∞], as extreme as they come; if
//! all are 0, so are all weights. NaN counts as 0.

use kaustika_math::lanes::Lanes;
use std::fmt;
use std::str::FromStr;

/// How techniques share what each of them could have sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Heuristic {
    /// In proportion to the densities: never much worse than any other choice (Veach's
    /// theorem 9.2).
    Balance,
    /// In proportion to a power β ≥ 0 of the densities: better where one technique is nearly
    /// perfect. The power 2 is usual; 0 shares equally, infinity is the maximum.
    Power(f32),
    /// All to the greatest density; equals go to the technique of lower index.
    Maximum,
}

impl Default for Heuristic {
    fn default() -> Self {
        Heuristic::Power(2.0)
    }
}

/// NaN and negative densities count as none.
#[inline]
fn clean(q: f32) -> f32 {
    if q > 0.0 { q } else { 0.0 }
}

/// The weight of a technique that has no rival: 1 where it is possible.
#[inline]
fn alone(q: f32) -> f32 {
    if q > 0.0 { 1.0 } else { 0.0 }
}

/// The share of the density `q` against `other`, both in [0, ∞].
#[inline]
fn share(q: f32, other: f32, beta: f32) -> f32 {
    let other = clean(other);
    if clean(q) == 0.0 || other == 0.0 {
        return alone(q);
    }
    // Of two infinite densities neither wins.
    let ratio = if q == other { 1.0 } else { other / q };
    let power = if beta == 1.0 {
        ratio
    } else if beta == 2.0 {
        ratio * ratio
    } else {
        ratio.powf(beta)
    };
    1.0 / (1.0 + power)
}

impl Heuristic {
    /// The weights of two techniques with n·p of `q0` and `q1` at the same point.
    #[inline]
    pub fn pair(self, q0: f32, q1: f32) -> (f32, f32) {
        (self.first(q0, q1), self.second(q0, q1))
    }

    /// The weight of the first of two techniques.
    #[inline]
    pub fn first(self, q0: f32, q1: f32) -> f32 {
        match self {
            Heuristic::Balance => share(q0, q1, 1.0),
            Heuristic::Power(beta) if beta < f32::INFINITY => share(q0, q1, beta),
            _ if clean(q1) > clean(q0) => 0.0,
            _ => alone(q0),
        }
    }

    /// The weight of the second of two techniques.
    #[inline]
    pub fn second(self, q0: f32, q1: f32) -> f32 {
        match self {
            Heuristic::Balance => share(q1, q0, 1.0),
            Heuristic::Power(beta) if beta < f32::INFINITY => share(q1, q0, beta),
            _ if clean(q0) >= clean(q1) => 0.0,
            _ => 1.0,
        }
    }

    /// The weight of technique `i` of several, `q[k]` being n·p of technique k.
    ///
    /// # Panics
    /// If `i` is out of range.
    pub fn weight(self, i: usize, q: &[f32]) -> f32 {
        if clean(q[i]) == 0.0 {
            return 0.0;
        }
        match self {
            Heuristic::Balance => power_share(i, q, 1.0),
            Heuristic::Power(beta) if beta < f32::INFINITY => power_share(i, q, beta),
            _ => {
                let beaten = q[..i].iter().any(|&o| o >= q[i]) || q[i..].iter().any(|&o| o > q[i]);
                if beaten { 0.0 } else { 1.0 }
            }
        }
    }
}

/// q[i]ᵝ / Σ q[k]ᵝ over positive densities, with the greatest scaled to 1.
fn power_share(i: usize, q: &[f32], beta: f32) -> f32 {
    let greatest = q.iter().fold(0.0f32, |m, &v| m.max(v));
    let relative = |v: f32| {
        if clean(v) == 0.0 {
            0.0
        } else if v == greatest {
            1.0
        } else {
            (v / greatest).powf(beta)
        }
    };
    relative(q[i]) / q.iter().map(|&v| relative(v)).sum::<f32>()
}

/// How light sampling and BSDF sampling are combined at a path vertex.
///
/// A sample that only one of them can make always counts in full: a point light has no
/// density for the BSDF, a mirror none for the light. So each choice stays unbiased.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MisHeuristic {
    /// Both, weighted.
    Both(Heuristic),
    /// Light samples alone, wherever they are possible.
    OnlyLight,
    /// BSDF samples alone, wherever they are possible.
    OnlyBsdf,
}

impl Default for MisHeuristic {
    fn default() -> Self {
        MisHeuristic::Both(Heuristic::default())
    }
}

impl MisHeuristic {
    /// The weight of a light sample; n·p of both techniques per solid angle.
    #[inline]
    pub fn light(self, q_light: f32, q_bsdf: f32) -> f32 {
        match self {
            MisHeuristic::Both(h) => h.first(q_light, q_bsdf),
            MisHeuristic::OnlyLight => alone(q_light),
            MisHeuristic::OnlyBsdf if q_bsdf > 0.0 => 0.0,
            MisHeuristic::OnlyBsdf => alone(q_light),
        }
    }

    /// The weight of a BSDF sample that hits a light; n·p of both techniques per solid angle.
    #[inline]
    pub fn bsdf(self, q_light: f32, q_bsdf: f32) -> f32 {
        match self {
            MisHeuristic::Both(h) => h.second(q_light, q_bsdf),
            MisHeuristic::OnlyBsdf => alone(q_bsdf),
            MisHeuristic::OnlyLight if q_light > 0.0 => 0.0,
            MisHeuristic::OnlyLight => alone(q_bsdf),
        }
    }

    /// As [`MisHeuristic::light`] of sixteen samples whose `q_light` is positive and finite.
    #[inline(always)]
    pub fn light_lanes(self, q_light: Lanes, q_bsdf: Lanes) -> Lanes {
        let one = Lanes::splat(1.0);
        let ratio = q_bsdf / q_light;
        match self {
            MisHeuristic::Both(Heuristic::Balance) => one / (one + ratio),
            MisHeuristic::Both(Heuristic::Power(2.0)) => one / ratio.mul_add(ratio, one),
            _ => {
                let (q_light, q_bsdf) = (q_light.to_array(), q_bsdf.to_array());
                Lanes::new(std::array::from_fn(|i| self.light(q_light[i], q_bsdf[i])))
            }
        }
    }

    /// Whether light samples are ever needed where both techniques are possible.
    pub fn samples_lights(self) -> bool {
        self != MisHeuristic::OnlyBsdf
    }
}

impl fmt::Display for Heuristic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Heuristic::Balance => f.write_str("balance"),
            Heuristic::Power(2.0) => f.write_str("power"),
            Heuristic::Power(beta) => write!(f, "power:{beta}"),
            Heuristic::Maximum => f.write_str("max"),
        }
    }
}

impl fmt::Display for MisHeuristic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MisHeuristic::Both(h) => h.fmt(f),
            MisHeuristic::OnlyLight => f.write_str("light"),
            MisHeuristic::OnlyBsdf => f.write_str("bsdf"),
        }
    }
}

/// A name that is no heuristic's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownHeuristic(pub String);

impl fmt::Display for UnknownHeuristic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "unknown heuristic \"{}\"; known are balance, power, power:BETA (BETA ≥ 0), max, and \
             where lights meet BSDFs light and bsdf",
            self.0
        )
    }
}

impl std::error::Error for UnknownHeuristic {}

impl FromStr for Heuristic {
    type Err = UnknownHeuristic;

    /// `balance`, `power` (β = 2), `power:BETA`, `max` or `maximum`.
    fn from_str(s: &str) -> Result<Self, UnknownHeuristic> {
        match s {
            "balance" => Ok(Heuristic::Balance),
            "power" => Ok(Heuristic::default()),
            "max" | "maximum" => Ok(Heuristic::Maximum),
            _ => s
                .strip_prefix("power:")
                .and_then(|beta| beta.parse().ok())
                .filter(|beta: &f32| *beta >= 0.0)
                .map(Heuristic::Power)
                .ok_or_else(|| UnknownHeuristic(s.to_owned())),
        }
    }
}

impl FromStr for MisHeuristic {
    type Err = UnknownHeuristic;

    /// The names of [`Heuristic`], `light` or `bsdf`.
    fn from_str(s: &str) -> Result<Self, UnknownHeuristic> {
        match s {
            "light" => Ok(MisHeuristic::OnlyLight),
            "bsdf" => Ok(MisHeuristic::OnlyBsdf),
            _ => s.parse().map(MisHeuristic::Both),
        }
    }
}
