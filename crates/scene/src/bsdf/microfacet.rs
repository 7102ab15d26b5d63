//! Microfacet surfaces: distributions of normals, masking, sampling of the visible normals.
//!
//! ```text
//! GGX        D(m) = 1 / (π αᵤ αᵥ (x²/αᵤ² + y²/αᵥ² + z²)²)                        (1)
//! Beckmann   D(m) = exp(-(x²/αᵤ² + y²/αᵥ²)/z²) / (π αᵤ αᵥ z⁴)                    (2)
//! GGX        Λ(ω) = (√(1 + 1/a²) - 1)/2,    1/a² = (αᵤ²x² + αᵥ²y²)/z²            (3)
//! Beckmann   Λ(ω) = exp(-a²)/(2a√π) - erfc(a)/2                                  (4)
//! masking    G₁(ω) = 1/(1 + Λ(ω))                                                (5)
//! separable  G₂ = G₁(ωₒ) G₁(ωᵢ)                                                  (6)
//! correlated G₂ = 1/(1 + Λ(ωₒ) + Λ(ωᵢ))                                          (7)
//! visible    D_ω(m) = G₁(ω) D(m) max(0, ω·m) / cos θ                             (8)
//! ```
//!
//! Sources: Walter, Marschner, Li & Torrance 2007 (1, 2); Heitz 2014, "Understanding the
//! masking-shadowing function" (3-8).

use crate::description::Distribution;
use kaustika_math::{Vec2, Vec3, safe_sqrt, special, sqr};
use std::f32::consts::PI;

/// 1/√π.
const INV_SQRT_PI: f32 = 0.564_189_6;
/// From this on Beckmann's Λ is below 1e-9 and taken as zero.
const BECKMANN_UNMASKED: f32 = 4.0;

/// How masking (towards `wo`) and shadowing (towards `wi`) combine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Masking {
    /// Eq. (7): both are likelier for low facets. pbrt-v4's choice.
    #[default]
    HeightCorrelated,
    /// Eq. (6): as if the two were independent; darker. Mitsuba's choice.
    Separable,
}

/// A distribution of microfacet normals in the shading frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Microfacet {
    kind: Distribution,
    masking: Masking,
    alpha_u: f32,
    alpha_v: f32,
}

impl Microfacet {
    /// Greatest roughness of a surface that counts as smooth (pbrt-v4's threshold).
    pub const SMOOTH: f32 = 1e-3;
    /// Least roughness along one axis when the other is rough (pbrt-v4's and Mitsuba 3's clamp):
    /// below it `f32` densities overflow.
    pub const ALPHA_MIN: f32 = 1e-4;

    /// Roughnesses along x and y (field's α, not remapped), height-correlated masking.
    /// Values below [`Microfacet::ALPHA_MIN`], NaN too, are raised to it.
    #[inline]
    pub fn new(kind: Distribution, alpha_u: f32, alpha_v: f32) -> Microfacet {
        Microfacet {
            kind,
            masking: Masking::default(),
            alpha_u: alpha_u.max(Self::ALPHA_MIN),
            alpha_v: alpha_v.max(Self::ALPHA_MIN),
        }
    }

    /// An ideal mirror's.
    #[inline]
    pub fn smooth() -> Microfacet {
        Microfacet::new(Distribution::Ggx, 0.0, 0.0)
    }

    /// The same surface with another combination of masking and shadowing.
    #[inline]
    pub fn with_masking(self, masking: Masking) -> Microfacet {
        Microfacet { masking, ..self }
    }

    /// Distribution of normals.
    #[inline]
    pub fn kind(&self) -> Distribution {
        self.kind
    }

    /// How masking and shadowing combine.
    #[inline]
    pub fn masking(&self) -> Masking {
        self.masking
    }

    /// True if models should treat the surface as ideally smooth.
    #[inline]
    pub fn is_smooth(&self) -> bool {
        self.alpha_u.max(self.alpha_v) < Self::SMOOTH
    }

    /// √(αᵤ αᵥ).
    #[inline]
    pub fn alpha(&self) -> f32 {
        (self.alpha_u * self.alpha_v).sqrt()
    }

    /// √(αᵤ αᵥ) in [0, 1]; 0 if smooth.
    #[inline]
    pub fn roughness(&self) -> f32 {
        if self.is_smooth() { 0.0 } else { self.alpha().min(1.0) }
    }

    /// Roughness of the isotropic surface that looks about as rough from `w`: the mean square
    /// of the roughness along the azimuth of `w` and of both axes.
    #[inline]
    pub fn isotropic_alpha(&self, w: Vec3) -> f32 {
        let axes = 0.5 * (sqr(self.alpha_u) + sqr(self.alpha_v));
        let sin2 = sqr(w.x) + sqr(w.y);
        if sin2 < 1e-6 {
            return axes.sqrt();
        }
        let along = (sqr(self.alpha_u * w.x) + sqr(self.alpha_v * w.y)) / sin2;
        (0.5 * (along + axes)).sqrt()
    }

    /// D(m) per solid angle, for `wm.z > 0`: (1), (2). ∫ D cos θ dω = 1.
    #[inline]
    pub fn d(&self, wm: Vec3) -> f32 {
        let slope2 = sqr(wm.x / self.alpha_u) + sqr(wm.y / self.alpha_v);
        let z2 = sqr(wm.z);
        let area = PI * self.alpha_u * self.alpha_v;
        match self.kind {
            Distribution::Ggx => 1.0 / (area * sqr(slope2 + z2)),
            // A horizontal facet has no density: exp(-∞)/0.
            Distribution::Beckmann if z2 < 1e-12 => 0.0,
            Distribution::Beckmann => (-slope2 / z2).exp() / (area * z2 * z2),
        }
    }

    /// Λ(ω), the same on both sides: (3), (4). Infinite at the horizon.
    #[inline]
    pub fn lambda(&self, w: Vec3) -> f32 {
        let inv_a2 = (sqr(self.alpha_u * w.x) + sqr(self.alpha_v * w.y)) / sqr(w.z);
        match self.kind {
            // (√(1+s) - 1)/2 without cancellation.
            Distribution::Ggx if inv_a2.is_finite() => 0.5 * inv_a2 / (1.0 + (1.0 + inv_a2).sqrt()),
            Distribution::Ggx => f32::INFINITY,
            Distribution::Beckmann => {
                let a = 1.0 / inv_a2.sqrt();
                if a >= BECKMANN_UNMASKED {
                    return 0.0;
                }
                (-a * a).exp() * (0.5 * INV_SQRT_PI / a - 0.5 * erfc_scaled(a))
            }
        }
    }

    /// Fraction of facets that `w` sees: (5).
    #[inline]
    pub fn g1(&self, w: Vec3) -> f32 {
        1.0 / (1.0 + self.lambda(w))
    }

    /// Fraction of facets that both directions see: (6), (7). The caller must have excluded
    /// facets that one of them sees from behind.
    #[inline]
    pub fn g2(&self, wo: Vec3, wi: Vec3) -> f32 {
        let (lo, li) = (self.lambda(wo), self.lambda(wi));
        match self.masking {
            Masking::HeightCorrelated => 1.0 / (1.0 + lo + li),
            Masking::Separable => 1.0 / ((1.0 + lo) * (1.0 + li)),
        }
    }

    /// G₂/G₁(wo): what is left of a sample of the visible normals.
    #[inline]
    pub fn g2_over_g1(&self, wo: Vec3, wi: Vec3) -> f32 {
        match self.masking {
            Masking::HeightCorrelated => {
                let lo = 1.0 + self.lambda(wo);
                lo / (lo + self.lambda(wi))
            }
            Masking::Separable => self.g1(wi),
        }
    }

    /// Density per solid angle of [`Microfacet::sample_visible`], for `wm.z > 0` facing `w`: (8).
    #[inline]
    pub fn pdf_visible(&self, w: Vec3, wm: Vec3) -> f32 {
        self.g1(w) * self.d(wm) * w.abs_dot(wm) / w.z.abs()
    }

    /// Densities of reflecting a visible normal: of `wi` given `wo` and of `wo` given `wi`, both
    /// above the surface, with half vector `wm`. D_ω(m)/(4 ω·m) = G₁(ω) D(m)/(4 cos θ).
    #[inline]
    pub fn pdf_reflection(&self, wo: Vec3, wi: Vec3, wm: Vec3) -> (f32, f32) {
        let d = 0.25 * self.d(wm);
        (d * self.g1(wo) / wo.z, d * self.g1(wi) / wi.z)
    }

    /// Draws one of the normals that `w` sees, `wm.z >= 0`, with density
    /// [`Microfacet::pdf_visible`]. From below, `w.z < 0`, it is a normal that -w sees, so that
    /// `w · wm < 0`.
    #[inline]
    pub fn sample_visible(&self, w: Vec3, u: Vec2) -> Vec3 {
        let w = if w.z < 0.0 { -w } else { w };
        // Stretch to the surface of unit roughness; the distributions are stretch-invariant.
        let v = Vec3::new(self.alpha_u * w.x, self.alpha_v * w.y, w.z).normalize();
        let m = match self.kind {
            Distribution::Ggx => ggx_visible_unit(v, u),
            Distribution::Beckmann => beckmann_visible_unit(v, u),
        };
        // The least z keeps the length positive where rounding leaves a horizontal normal.
        Vec3::new(self.alpha_u * m.x, self.alpha_v * m.y, m.z.max(1e-7)).normalize()
    }
}

/// A normal of the unit sphere that `v` sees, not normalised: the mean of `v` and a uniform
/// direction of the cap that it reflects from (Dupuy & Benyoub 2023, "Sampling visible GGX
/// normals with spherical caps").
#[inline]
fn ggx_visible_unit(v: Vec3, u: Vec2) -> Vec3 {
    let (s, c) = (2.0 * PI * u.x).sin_cos();
    // z in (-v.z, 1]; 1 - z and 1 + z are kept apart for their small values.
    let height = u.y * (1.0 + v.z);
    let z = 1.0 - height;
    let r = safe_sqrt(height * (2.0 - height));
    Vec3::new(r * c + v.x, r * s + v.y, z + v.z)
}

/// A normal (not normalised, z = 1) of the Beckmann surface of unit roughness that `v` sees.
/// The slope towards `v` by numerical inversion of its distribution, in the domain of erf, where
/// it is concave (after Jakob 2014, "An improved visible normal sampling routine for the Beckmann
/// distribution"); the slope across is independent and normal.
#[inline]
fn beckmann_visible_unit(v: Vec3, u: Vec2) -> Vec3 {
    let sin = safe_sqrt(sqr(v.x) + sqr(v.y));
    let across = special::erf_inv(2.0 * u.y - 1.0);
    let along = beckmann_slope(sin / v.z.max(1e-6), u.x);
    let (c, s) = if sin > 0.0 { (v.x / sin, v.y / sin) } else { (1.0, 0.0) };
    Vec3::new(-(c * along - s * across), -(s * along + c * across), 1.0)
}

/// The slope x <= cot θ with density ∝ (1 - x tan θ) exp(-x²), i.e. in b = erf x:
///
/// ```text
/// C(b) = 1 + b + tan θ/√π exp(-x²),   C' = 1 - x tan θ
/// ```
///
/// C grows from 0 at b = -1 to its maximum at b = erf cot θ and is concave, so that Newton's
/// steps approach the root from the left after the first; a bracket catches that one.
#[inline]
fn beckmann_slope(tan: f32, u: f32) -> f32 {
    let (mut low, mut high, mut edge) = (-1.0, 1.0, 0.0);
    if tan > 0.0 {
        let cot = 1.0 / tan;
        let e = (-cot * cot).exp();
        high = 1.0 - erfc_scaled(cot) * e;
        edge = INV_SQRT_PI * tan * e;
    }
    let total = 1.0 + high + edge;
    let target = u * total;
    // Between the exact solutions at θ = 0, uniform in b, and at θ = π/2, where exp(-x²) = u.
    let uniform = (1.0 + high) * u - 1.0;
    let grazing =
        high - (high + 1.0) * (1.0 - erfc_scaled((-u.max(1e-9).ln()).max(0.0).sqrt()) * u);
    let t = 1.0 / (1.0 + 1.5 * tan);
    let mut b = t * uniform + (1.0 - t) * grazing;
    // Two or three steps are usual; a bracket of 24 halvings is as fine as f32.
    for _ in 0..24 {
        let x = special::erf_inv(b);
        let e = (-x * x).exp();
        let error = 1.0 + b + INV_SQRT_PI * tan * e - target;
        let slope = 1.0 - x * tan;
        let step = error / slope;
        // Quadratic convergence: the step from here leaves nothing that f32 could hold, and
        // dx/db = √π/2 exp(x²) takes it to x. At the edge, where C is flat, x is as good.
        if error.abs() <= 3e-6 * total {
            let change = step / (2.0 * INV_SQRT_PI * e);
            return if change.abs() < 0.1 { x - change } else { x };
        }
        if error > 0.0 {
            high = b;
        } else {
            low = b;
        }
        b = if b - step > low && b - step < high { b - step } else { 0.5 * (low + high) };
    }
    special::erf_inv(b)
}

/// exp(x²) erfc(x) for x >= 0; times exp(-x²) it is within 1.5e-7 of erfc (Abramowitz & Stegun
/// 1964, eq. 7.1.26). Kept apart from the exponential, which its callers have anyway.
#[inline]
fn erfc_scaled(x: f32) -> f32 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x);
    let poly = 1.061_405_429f32;
    let poly = poly * t - 1.453_152_027;
    let poly = poly * t + 1.421_413_741;
    let poly = poly * t - 0.284_496_736;
    (poly * t + 0.254_829_592) * t
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Partition, Random};
    use super::*;
    use kaustika_math::special::{gamma_q, p_two_sided};

    fn surfaces() -> Vec<Microfacet> {
        let mut list = Vec::new();
        for kind in [Distribution::Ggx, Distribution::Beckmann] {
            for (u, v) in [(0.02, 0.02), (0.1, 0.3), (0.5, 0.5), (1.0, 0.4), (1.5, 1.5)] {
                list.push(Microfacet::new(kind, u, v));
            }
        }
        list
    }

    fn directions() -> impl Iterator<Item = Vec3> {
        [1.0f32, 0.9, 0.5, 0.1, 0.01].into_iter().enumerate().map(|(i, z)| {
            let (s, c) = (i as f32 * 1.3).sin_cos();
            let r = (1.0 - z * z).sqrt();
            Vec3::new(r * c, r * s, z)
        })
    }

    /// ∫ D cos θ = 1, ∫ D_ω = 1, and normals are drawn with density D_ω: chi-square, 1 % for all
    /// fifty situations together (Šidák).
    #[test]
    fn normals_integrate_and_are_drawn_with_their_density() {
        let n = 60_000;
        let p_least = 1.0 - 0.99f64.powf(1.0 / 50.0);
        for (k, surface) in surfaces().into_iter().enumerate() {
            for (j, w) in directions().enumerate() {
                let mut random = Random::new((5 * k + j) as u64);
                let mut draw = || surface.sample_visible(w, random.next_2d());
                let pilot: Vec<_> = (0..n / 4).map(|_| draw()).collect();
                let partition = Partition::new(&pilot, n / 256);
                let f = |m: Vec3| {
                    if m.z <= 0.0 {
                        return [0.0; 2];
                    }
                    let visible = if w.dot(m) > 0.0 { surface.pdf_visible(w, m) } else { 0.0 };
                    [visible as f64, (surface.d(m) * m.z) as f64]
                };
                let cells = partition.integrate(&f, 2e-6);
                let visible: f64 = cells.iter().map(|c| c[0]).sum();
                let projected: f64 = cells.iter().map(|c| c[1]).sum();
                assert!((visible - 1.0).abs() < 1e-3, "{surface:?} {w:?}: D_w: {visible}");
                assert!((projected - 1.0).abs() < 1e-3, "{surface:?} {w:?}: D: {projected}");
                let mut counts = vec![0.0; cells.len()];
                (0..n).for_each(|_| counts[partition.find(draw())] += 1.0);
                let (mut sum, mut freedom, mut rest) = (0.0, -1.0, (0.0, 0.0));
                for (cell, count) in cells.iter().zip(counts) {
                    let expected = cell[0] * n as f64;
                    if expected < 5.0 {
                        rest = (rest.0 + expected, rest.1 + count);
                    } else {
                        sum += sqr64(count - expected) / expected;
                        freedom += 1.0;
                    }
                }
                if rest.0 >= 5.0 {
                    sum += sqr64(rest.1 - rest.0) / rest.0;
                    freedom += 1.0;
                } else {
                    assert!(
                        rest.1 < 1e-4 * n as f64 + 5.0,
                        "{surface:?} {w:?}: {rest:?} where there is no density"
                    );
                }
                let p = gamma_q(0.5 * freedom, 0.5 * sum);
                assert!(p > p_least, "{surface:?} {w:?}: chi-square {sum:.1}/{freedom}, p {p:.1e}");
            }
        }
    }

    fn sqr64(x: f64) -> f64 {
        x * x
    }

    /// Across the plane of incidence Beckmann's slopes are normal with variance α²/2.
    #[test]
    fn beckmann_slope_across_is_normal() {
        let surface = Microfacet::new(Distribution::Beckmann, 0.3, 0.3);
        let w = Vec3::new(0.8, 0.0, 0.6);
        let mut random = Random::new(3);
        let n = 100_000;
        let (mut mean, mut square) = (0.0, 0.0);
        for _ in 0..n {
            let m = surface.sample_visible(w, random.next_2d());
            let y = (m.y / m.z) as f64 / 0.3 * std::f64::consts::SQRT_2;
            mean += y / n as f64;
            square += y * y / n as f64;
        }
        let root = (n as f64).sqrt();
        assert!(p_two_sided(mean * root) > 0.005, "{mean}");
        assert!(p_two_sided((square - 1.0) * root / std::f64::consts::SQRT_2) > 0.005, "{square}");
    }

    /// The slope is where its distribution, in `f64`, reaches u.
    #[test]
    fn beckmann_slope_inverts_its_distribution() {
        for tan in [0.0f32, 1e-3, 0.1, 0.5, 1.0, 3.0, 30.0, 1e4] {
            let t = tan as f64;
            let c = |x: f64| 1.0 + special::erf(x) + t * INV_SQRT_PI as f64 * (-x * x).exp();
            let total = c(if t > 0.0 { 1.0 / t } else { 10.0 });
            for i in 0..2000 {
                let u = (i as f32 + 0.5) / 2000.0;
                let x = beckmann_slope(tan, u);
                let got = c(x as f64) / total;
                assert!((got - u as f64).abs() < 2e-6, "tan {tan} u {u}: x {x}, C {got}");
            }
        }
    }

    /// Λ by its definition for a Gaussian surface, at a few angles; limits.
    #[test]
    fn lambda_has_its_known_values() {
        let beckmann = Microfacet::new(Distribution::Beckmann, 1.0, 1.0);
        // a = 1 at 45°: e⁻¹/(2√π) - erfc(1)/2.
        let w = Vec3::new(0.5f32.sqrt(), 0.0, 0.5f32.sqrt());
        assert!((beckmann.lambda(w) - 0.025_127_9).abs() < 1e-5, "{}", beckmann.lambda(w));
        let ggx = Microfacet::new(Distribution::Ggx, 1.0, 1.0);
        assert!((ggx.lambda(w) - 0.5 * (2f32.sqrt() - 1.0)).abs() < 1e-6);
        for s in surfaces() {
            assert_eq!(s.lambda(Vec3::Z), 0.0);
            assert_eq!(s.g1(Vec3::X), 0.0);
            let (a, b) = (Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, -0.8, 0.6));
            let separable = s.with_masking(Masking::Separable);
            assert!(separable.g2(a, b) <= s.g2(a, b) && s.g2(a, b) <= s.g1(a).min(s.g1(b)));
            for s in [s, separable] {
                assert!((s.g2_over_g1(a, b) - s.g2(a, b) / s.g1(a)).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn smooth_is_below_a_thousandth() {
        assert!(Microfacet::smooth().is_smooth() && Microfacet::smooth().roughness() == 0.0);
        assert!(Microfacet::new(Distribution::Ggx, 9e-4, 0.0).is_smooth());
        assert!(!Microfacet::new(Distribution::Ggx, 1e-3, 0.0).is_smooth());
        assert!(Microfacet::new(Distribution::Beckmann, f32::NAN, f32::NAN).is_smooth());
    }
}
