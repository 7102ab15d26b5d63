//! What a rough dielectric coat lets through, in tables: the part of [`super::RoughPlastic`] that
//! is computed once per material.
//!
//! ```text
//! T(μ) = ∫∫ (1 - F(ωₒ·m)) G₁(ωₜ)  du            m drawn from the visible normals by u      (1)
//! R(μ) = ∫∫ F(ωₒ·m) G₁(ωᵣ)  du                  seen from inside, index 1/η                (2)
//! R̄    = 2/64 Σ R(μₖ) μₖ,   μₖ = k/63                                                    (3)
//! ```
//!
//! These are Mitsuba 3's definitions (facts read in its `roughplastic` and `microfacet.h`): 64
//! values of μ, quadrature of Gauss and Legendre in u with 32² points for T and 128² for R. The
//! mean (3) is not the trapezoid's and lies 1.5 % below the integral 2 ∫ R μ dμ at an index of
//! 1.5; a base of the same colour as Mitsuba's needs the same number, so it is kept.

use super::Microfacet;
use super::fresnel::{fresnel_dielectric, reflect, refract};
use crate::description::Distribution;
use kaustika_math::quadrature::gauss_legendre;
use kaustika_math::{Vec2, Vec3};
use rayon::prelude::*;

/// Values of μ = cos θ, uniform on [0, 1].
const NODES: usize = 64;
/// Roughnesses of a textured coat, uniform in √α.
const ALPHAS: usize = 16;

/// Tables of one coat.
#[derive(Clone, Debug)]
pub struct RoughTransmittance {
    eta: f32,
    /// √α of the first row and rows per unit of √α; 0 if there is one row.
    first: f32,
    scale: f32,
    rows: Vec<Row>,
}

#[derive(Clone, Debug)]
struct Row {
    /// T(μₖ), (1).
    transmittance: [f32; NODES],
    /// 2 ∫ T μ dμ.
    mean_transmittance: f32,
    /// R̄, (3).
    internal: f32,
}

/// Place of a roughness in the tables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlphaIndex {
    row: usize,
    next: usize,
    fraction: f32,
}

impl RoughTransmittance {
    /// A coat of index `eta` > 0 relative to the outside, the same roughness `alpha` everywhere.
    pub fn new(kind: Distribution, alpha: f32, eta: f32) -> RoughTransmittance {
        let rows = vec![Row::new(kind, alpha, eta, 128)];
        RoughTransmittance { eta, first: 0.0, scale: 0.0, rows }
    }

    /// A coat of textured roughness between `alpha_min` and `alpha_max`; others are clamped.
    pub fn with_range(
        kind: Distribution,
        alpha_min: f32,
        alpha_max: f32,
        eta: f32,
    ) -> RoughTransmittance {
        let (first, last) = (alpha_min.max(0.0).sqrt(), alpha_max.max(0.0).sqrt());
        if last - first < 1e-3 {
            return RoughTransmittance::new(kind, alpha_min, eta);
        }
        let step = (last - first) / (ALPHAS - 1) as f32;
        let rows = (0..ALPHAS)
            .into_par_iter()
            .map(|i| {
                let root = first + i as f32 * step;
                Row::new(kind, root * root, eta, 48)
            })
            .collect();
        RoughTransmittance { eta, first, scale: 1.0 / step, rows }
    }

    /// The coat's index relative to the outside.
    #[inline]
    pub fn eta(&self) -> f32 {
        self.eta
    }

    /// Where the tables hold roughness `alpha`.
    #[inline]
    pub fn index(&self, alpha: f32) -> AlphaIndex {
        let x = ((alpha.max(0.0).sqrt() - self.first) * self.scale).max(0.0);
        let row = (x as usize).min(self.rows.len() - 1);
        let next = (row + 1).min(self.rows.len() - 1);
        AlphaIndex { row, next, fraction: (x - row as f32).clamp(0.0, 1.0) }
    }

    #[inline]
    fn interpolate(&self, at: AlphaIndex, value: impl Fn(&Row) -> f32) -> f32 {
        let a = value(&self.rows[at.row]);
        a + at.fraction * (value(&self.rows[at.next]) - a)
    }

    /// T(μ) for light that comes from outside at `cos` in [0, 1].
    #[inline]
    pub fn transmittance(&self, at: AlphaIndex, cos: f32) -> f32 {
        let x = cos.clamp(0.0, 1.0) * (NODES - 1) as f32;
        let k = (x as usize).min(NODES - 2);
        let t = x - k as f32;
        self.interpolate(at, |r| r.transmittance[k] * (1.0 - t) + r.transmittance[k + 1] * t)
    }

    /// 2 ∫ T(μ) μ dμ: what of diffuse light gets in.
    #[inline]
    pub fn mean_transmittance(&self, at: AlphaIndex) -> f32 {
        self.interpolate(at, |r| r.mean_transmittance)
    }

    /// R̄ of (3), for diffuse light from inside.
    #[inline]
    pub fn internal_reflectance(&self, at: AlphaIndex) -> f32 {
        self.interpolate(at, |r| r.internal)
    }
}

impl Row {
    /// `points`: of the quadrature from the denser side, whose integrand has an edge (total
    /// reflection); the other side is smooth.
    fn new(kind: Distribution, alpha: f32, eta: f32, points: usize) -> Row {
        let surface = Microfacet::new(kind, alpha, alpha);
        let (coarse, fine) = (rule(32), rule(points));
        let rule = |eta: f32| if eta > 1.0 { &coarse } else { &fine };
        let mu = |k: usize| k as f32 / (NODES - 1) as f32;
        let mut row = Row { transmittance: [0.0; NODES], mean_transmittance: 0.0, internal: 0.0 };
        let wo = |k: usize| {
            let mu = mu(k).max(1e-6);
            Vec3::new((1.0 - mu * mu).sqrt(), 0.0, mu)
        };
        for k in 0..NODES {
            row.transmittance[k] = integrate(rule(eta), |u| transmitted(&surface, wo(k), eta, u));
        }
        let inner: Vec<f32> = (0..NODES)
            .into_par_iter()
            .map(|k| {
                integrate(rule(1.0 / eta), |u| reflected(&surface, wo(k), 1.0 / eta, u)) * mu(k)
            })
            .collect();
        row.internal = 2.0 / NODES as f32 * inner.iter().sum::<f32>(); // (3)
        // T is linear between nodes and T μ a parabola, for which Simpson's rule is exact.
        let t = &row.transmittance;
        row.mean_transmittance = (0..NODES - 1)
            .map(|k| {
                let middle = 0.5 * (t[k] + t[k + 1]) * 0.5 * (mu(k) + mu(k + 1));
                (t[k] * mu(k) + 4.0 * middle + t[k + 1] * mu(k + 1)) / (3.0 * (NODES - 1) as f32)
            })
            .sum();
        row
    }
}

/// The integrand of (1).
fn transmitted(surface: &Microfacet, wo: Vec3, eta: f32, u: Vec2) -> f32 {
    let m = surface.sample_visible(wo, u);
    let f = fresnel_dielectric(wo.dot(m), eta);
    let wt = refract(wo, m, wo.dot(m), f.cos_t, f.eta);
    if wt.z >= 0.0 { 0.0 } else { (1.0 - f.reflectance) * surface.g1(wt) }
}

/// The integrand of (2).
fn reflected(surface: &Microfacet, wo: Vec3, eta: f32, u: Vec2) -> f32 {
    let m = surface.sample_visible(wo, u);
    let wr = reflect(wo, m);
    if wr.z <= 0.0 { 0.0 } else { fresnel_dielectric(wo.dot(m), eta).reflectance * surface.g1(wr) }
}

/// ∫∫ f over the unit square by the product of a rule with itself.
fn integrate(rule: &[(f32, f32)], f: impl Fn(Vec2) -> f32) -> f32 {
    let mut sum = 0.0;
    for &(x, wx) in rule {
        let line: f32 = rule.iter().map(|&(y, wy)| wy * f(Vec2::new(x, y))).sum();
        sum += wx * line;
    }
    sum
}

/// Gauss and Legendre's rule of `n` points on [0, 1].
fn rule(n: usize) -> Vec<(f32, f32)> {
    gauss_legendre(n).into_iter().map(|(x, w)| (x as f32, w as f32)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::fresnel::fresnel_diffuse_reflectance;
    use super::super::testing::Random;
    use super::*;

    /// A nearly smooth coat is Fresnel's; its R̄ is (3) of Fresnel's reflectance, 1.5 % below the
    /// integral.
    #[test]
    fn smooth_limit_is_fresnels() {
        let table = RoughTransmittance::new(Distribution::Beckmann, 1e-3, 1.49);
        let at = table.index(1e-3);
        for cos in [0.2f32, 0.5, 0.9, 1.0] {
            let k = (cos * 63.0).round() / 63.0;
            let exact = 1.0 - fresnel_dielectric(k, 1.49).reflectance;
            let got = table.transmittance(at, k);
            assert!((got - exact).abs() < 5e-4, "{cos}: {got} {exact}");
        }
        let inside = |k: usize| {
            let mu = k as f32 / 63.0;
            fresnel_dielectric(mu, 1.0 / 1.49).reflectance * mu
        };
        let mean = 2.0 / 64.0 * (0..64).map(inside).sum::<f32>();
        let got = table.internal_reflectance(at);
        assert!((got - mean).abs() < 2e-3, "{got} {mean}");
        let integral = fresnel_diffuse_reflectance(1.0 / 1.49);
        assert!(got < 0.99 * integral && got > 0.975 * integral, "{got} {integral}");
        let entering = 1.0 - fresnel_diffuse_reflectance(1.49);
        assert!((table.mean_transmittance(at) - entering).abs() < 3e-3);
    }

    /// (1) and (2) by Monte Carlo, within four standard errors, at a rough surface.
    #[test]
    fn quadrature_agrees_with_sampling() {
        let (alpha, eta) = (0.3, 1.49);
        for kind in [Distribution::Ggx, Distribution::Beckmann] {
            let table = RoughTransmittance::new(kind, alpha, eta);
            let surface = Microfacet::new(kind, alpha, alpha);
            let mut random = Random::new(5);
            for k in [6, 30, 63] {
                let mu = k as f32 / 63.0;
                let wo = Vec3::new((1.0 - mu * mu).sqrt(), 0.0, mu);
                let n = 100_000;
                let (mut sum, mut square) = (0f64, 0f64);
                for _ in 0..n {
                    let t = transmitted(&surface, wo, eta, random.next_2d()) as f64;
                    sum += t;
                    square += t * t;
                }
                let mean = sum / n as f64;
                let error = ((square / n as f64 - mean * mean) / n as f64).sqrt();
                let got = table.transmittance(table.index(alpha), mu) as f64;
                assert!((got - mean).abs() < 4.0 * error + 2e-4, "{kind:?} {mu}: {got} {mean}");
            }
        }
    }

    /// Between rows the tables are as good as a table made for the roughness.
    #[test]
    fn rows_interpolate() {
        let range = RoughTransmittance::with_range(Distribution::Ggx, 0.02, 0.6, 1.5);
        for alpha in [0.05, 0.17, 0.5] {
            let own = RoughTransmittance::new(Distribution::Ggx, alpha, 1.5);
            let (a, b) = (range.index(alpha), own.index(alpha));
            for cos in [0.1, 0.4, 0.95] {
                let (x, y) = (range.transmittance(a, cos), own.transmittance(b, cos));
                assert!((x - y).abs() < 3e-3, "{alpha} {cos}: {x} {y}");
            }
            let (x, y) = (range.internal_reflectance(a), own.internal_reflectance(b));
            assert!((x - y).abs() < 2e-3, "{alpha}: {x} {y}");
        }
        assert_eq!(range.index(0.0), range.index(0.02));
        assert_eq!(range.index(2.0).row, ALPHAS - 1);
    }
}
