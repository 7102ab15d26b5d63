//! Russian roulette and the random walk that solves a Fredholm equation of the second kind:
//! path tracing without geometry.
//!
//! ```text
//! f(x) = g(x) + ∫₀¹ K(x, y) f(y) dy                                              (1)
//! ⟨f(x)⟩ = Σᵢ₌₀..ₖ [ Πⱼ₌₁..ᵢ K(ξⱼ₋₁, ξⱼ) / (Pⱼ p(ξⱼ)) ] g(ξᵢ),    ξ₀ = x         (2)
//! ```
//!
//! The walk goes on from ξⱼ₋₁ with probability Pⱼ and picks ξⱼ with density p. Any P in (0, 1]
//! is unbiased if the series converges; P ∝ ∫K(x, y)dy keeps the weights near 1, and with
//! P = ∫K the walk has 1/(1-P) vertices in the mean.

/// Russian roulette: `Some(1/p)`, the factor of the surviving value, with probability `p`,
/// else `None`. p ≥ 1 always survives, unchanged; p ≤ 0 never does, which is unbiased only if
/// the value is 0.
///
/// The mean is kept; the variance of a value with variance V and mean m becomes
/// [`roulette_variance`].
#[inline]
pub fn roulette(p: f32, u: f32) -> Option<f32> {
    if p >= 1.0 {
        Some(1.0)
    } else if u < p {
        Some(1.0 / p)
    } else {
        None
    }
}

/// The variance after roulette of a value with the given variance and mean that survives with
/// probability `p`: V/p + (1/p - 1)m².
pub fn roulette_variance(variance: f64, mean: f64, p: f64) -> f64 {
    variance / p + (1.0 / p - 1.0) * mean * mean
}

/// One run of the estimator (2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walk {
    /// The estimate of f(x).
    pub value: f64,
    /// The number of vertices, ξ₀ included.
    pub vertices: u32,
}

/// The equation (1) and how its walks are sampled.
pub struct Fredholm<K, G, S, P> {
    /// The kernel K(x, y).
    pub kernel: K,
    /// The source g(x).
    pub source: G,
    /// From x and a uniform number the next point and its density; the density must be
    /// positive wherever K(x, ·) is not zero.
    pub step: S,
    /// The probability to go on from x, in [0, 1]; below 1 somewhere on every walk, or walks
    /// do not end.
    pub survival: P,
}

impl<K, G, S, P> Fredholm<K, G, S, P>
where
    K: Fn(f64, f64) -> f64,
    G: Fn(f64) -> f64,
    S: Fn(f64, f64) -> (f64, f64),
    P: Fn(f64) -> f64,
{
    /// Estimates f(x) by one walk; `random` gives numbers in [0, 1).
    pub fn walk(&self, x: f64, mut random: impl FnMut() -> f64) -> Walk {
        let (mut x, mut weight) = (x, 1.0);
        let mut walk = Walk { value: (self.source)(x), vertices: 1 };
        loop {
            let p = (self.survival)(x).min(1.0);
            if random() >= p {
                return walk;
            }
            let (y, pdf) = (self.step)(x, random());
            weight *= (self.kernel)(x, y) / (p * pdf);
            if weight == 0.0 {
                return walk;
            }
            x = y;
            walk.value += weight * (self.source)(x);
            walk.vertices += 1;
        }
    }
}
