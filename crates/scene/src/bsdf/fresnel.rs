//! Fresnel's reflectance of unpolarised light.
//!
//! ```text
//! sin θₜ = sin θᵢ / η                                                             (1)
//! r∥ = (η cos θᵢ - cos θₜ)/(η cos θᵢ + cos θₜ)                                    (2)
//! r⊥ = (cos θᵢ - η cos θₜ)/(cos θᵢ + η cos θₜ)                                    (3)
//! F  = (r∥² + r⊥²)/2                                                              (4)
//! F̄  = 2 ∫₀¹ F(μ) μ dμ                                                            (5)
//! ```
//!
//! η is the index behind the surface over the one in front; for conductors it is complex,
//! η + ik. Born & Wolf 1999, "Principles of Optics", sec. 1.5 and 14.2.

use kaustika_math::{Vec3, safe_sqrt, sqr};
use kaustika_spectra::Spectrum;

/// What a dielectric interface does to a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Reflectance (4) in [0, 1]; 1 under total internal reflection.
    pub reflectance: f32,
    /// |cos θₜ| of the refracted ray; 0 under total internal reflection.
    pub cos_t: f32,
    /// Index on the refracted side over that on the incident side.
    pub eta: f32,
}

/// Fresnel's equations at a dielectric, (1-4). `eta` is the index below the surface (where
/// cosines are negative) over that above; `cos_i` in [-1,1] is signed: a ray that comes from
/// below meets 1/`eta`.
#[inline]
pub fn fresnel_dielectric(cos_i: f32, eta: f32) -> Interface {
    let eta = if cos_i < 0.0 { 1.0 / eta } else { eta };
    let cos_i = cos_i.abs().min(1.0);
    let sin2_t = (1.0 - sqr(cos_i)) / sqr(eta); // (1)
    if sin2_t >= 1.0 {
        return Interface { reflectance: 1.0, cos_t: 0.0, eta };
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    Interface { reflectance: fresnel_of_cosines(cos_i, cos_t, eta), cos_t, eta }
}

/// Reflectance (2-4) where both cosines are known, each >= 0 and one positive, and obey (1) for
/// `eta`: keeps its digits near total reflection, where (1) loses them.
#[inline]
pub fn fresnel_of_cosines(cos_i: f32, cos_t: f32, eta: f32) -> f32 {
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t); // (2)
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t); // (3)
    0.5 * (sqr(parallel) + sqr(perpendicular)) // (4)
}

/// `w` mirrored at the normal `n`; both point away from the surface.
#[inline]
pub fn reflect(w: Vec3, n: Vec3) -> Vec3 {
    n * (2.0 * w.dot(n)) - w
}

/// The refraction of `w` at the normal `n` on its side: `cos_i` = w · n >= 0, `cos_t` and `eta`
/// as in [`Interface`].
#[inline]
pub fn refract(w: Vec3, n: Vec3, cos_i: f32, cos_t: f32, eta: f32) -> Vec3 {
    let inv = 1.0 / eta;
    n * (cos_i * inv - cos_t) - w * inv
}

/// Fresnel's equations at a conductor, lane by lane, for `cos_i` in [0, 1] (clamped) and the
/// complex index `eta` + i `k` relative to the outside.
#[inline]
pub fn fresnel_conductor(cos_i: f32, eta: Spectrum, k: Spectrum) -> Spectrum {
    let c2 = sqr(cos_i.clamp(0.0, 1.0));
    let s2 = 1.0 - c2;
    let cos = c2.sqrt();
    eta.zip(k, |eta, k| {
        // (a + ib)² = (η + ik)² - sin² θ, so that η cos θₜ = a + ib in (3).
        let re = eta * eta - k * k - s2;
        let norm = safe_sqrt(re * re + sqr(2.0 * eta * k)); // a² + b²
        let two_a_cos = 2.0 * cos * safe_sqrt(0.5 * (norm + re));
        let perpendicular = (norm + c2 - two_a_cos) / (norm + c2 + two_a_cos);
        let (p, q) = (norm * c2 + s2 * s2, two_a_cos * s2);
        // An unused lane, η = k = 0, would be 0/0 at normal incidence.
        let ratio = if p + q > 0.0 { (p - q) / (p + q) } else { 1.0 };
        0.5 * perpendicular * (1.0 + ratio)
    })
}

/// Schlick's approximation F₀ + (1 - F₀)(1 - cos θ)⁵ (Schlick 1994, eq. 15), for `cos_i` in
/// [0, 1].
#[inline]
pub fn fresnel_schlick(cos_i: f32, r0: Spectrum) -> Spectrum {
    let m = (1.0 - cos_i).clamp(0.0, 1.0);
    let weight = sqr(sqr(m)) * m;
    r0.map(|r| r + (1.0 - r) * weight)
}

/// Reflectance for diffuse light from above, F̄ of (5), exact (Walsh 1926; closed form after
/// Duntley 1942). `eta` > 0 is the index below over that above; for the light from below pass
/// 1/`eta`. Error below 1e-6.
pub fn fresnel_diffuse_reflectance(eta: f32) -> f32 {
    if eta < 1.0 {
        // What enters leaves by the same ways: η²(1 - F̄(1/η)) = 1 - F̄(η).
        let n = 1.0 / eta;
        return 1.0 - (1.0 - fresnel_diffuse_reflectance(n)) / sqr(n);
    }
    let n = eta as f64;
    // The terms below cancel near one, where the reflectance vanishes.
    if n - 1.0 < 1e-4 {
        return 0.0;
    }
    let n2 = n * n;
    let n4 = n2 * n2;
    let plus = n2 + 1.0;
    let minus = n4 - 1.0;
    let sum = 0.5
        + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0).powi(2))
        + n2 * (n2 - 1.0).powi(2) / plus.powi(3) * ((n - 1.0) / (n + 1.0)).ln()
        - 2.0 * n2 * n * (n2 + 2.0 * n - 1.0) / (plus * minus)
        + 8.0 * n4 * (n4 + 1.0) / (plus * minus * minus) * n.ln();
    sum as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Figures of an index of 1.5 and of total reflection, computed by hand.
    #[test]
    fn dielectric_has_its_known_values() {
        let near = |a: f32, b: f32| assert!((a - b).abs() < 2e-6, "{a} {b}");
        near(fresnel_dielectric(1.0, 1.5).reflectance, 0.04);
        near(fresnel_dielectric(-1.0, 1.5).reflectance, 0.04);
        let half = 0.5f32.sqrt();
        near(fresnel_dielectric(half, 1.5).reflectance, 0.5 * (0.092_013 + 0.008_466));
        let brewster = 1.5f32.atan();
        assert!((brewster.to_degrees() - 56.310).abs() < 1e-3);
        near(fresnel_dielectric(brewster.cos(), 1.5).reflectance, 0.5 * 0.147_929);
        near(fresnel_dielectric(0.0, 1.5).reflectance, 1.0);
        // From inside: total beyond arcsin(1/1.5) = 41.810°.
        let inside = |degrees: f32| fresnel_dielectric(-degrees.to_radians().cos(), 1.5);
        assert!(inside(41.7).reflectance < 1.0 && inside(41.9).reflectance == 1.0);
        assert_eq!(inside(50.0).cos_t, 0.0);
        near(inside(20.0).eta, 1.0 / 1.5);
        near(fresnel_dielectric(0.3, 1.0).reflectance, 0.0);
    }

    /// The reflectance is the same from both ends of a refracted ray.
    #[test]
    fn dielectric_is_reciprocal() {
        for i in 1..100 {
            let cos = i as f32 / 100.0;
            for eta in [1.1f32, 1.5, 2.4, 0.7] {
                let there = fresnel_dielectric(cos, eta);
                if there.cos_t > 0.0 {
                    let back = fresnel_dielectric(-there.cos_t, eta);
                    assert!((there.reflectance - back.reflectance).abs() < 1e-4, "{cos} {eta}");
                    assert!((back.cos_t - cos).abs() < 1e-4);
                }
            }
        }
    }

    #[test]
    fn refraction_obeys_snell() {
        let (n, w) = (Vec3::Z, Vec3::new(0.48, -0.64, 0.6));
        let f = fresnel_dielectric(w.z, 1.5);
        let t = refract(w, n, w.z, f.cos_t, f.eta);
        assert!((t + Vec3::new(0.32, -0.426_666_67, f.cos_t)).length() < 1e-6, "{t:?}");
        assert!((t.length() - 1.0).abs() < 1e-6);
        assert_eq!(reflect(w, n), Vec3::new(-0.48, 0.64, 0.6));
    }

    #[test]
    fn conductor_without_absorption_is_a_dielectric() {
        let unit = |v| Spectrum::splat(v);
        for i in 0..=50 {
            let cos = i as f32 / 50.0;
            let a = fresnel_conductor(cos, unit(1.5), unit(0.0))[0];
            let b = fresnel_dielectric(cos, 1.5).reflectance;
            assert!((a - b).abs() < 1e-5, "{cos}: {a} {b}");
        }
        // Normal incidence: ((η-1)² + k²)/((η+1)² + k²).
        let gold = fresnel_conductor(1.0, unit(0.2), unit(3.0))[0];
        assert!((gold - (0.64 + 9.0) / (1.44 + 9.0)).abs() < 1e-6, "{gold}");
        // By complex arithmetic at 60°: η = 0.2 + 3i.
        let re = 0.04f64 - 9.0 - 0.75;
        let im = 1.2f64;
        let norm = re.hypot(im);
        let (a, b) = ((0.5 * (norm + re)).sqrt(), (0.5 * (norm - re)).sqrt());
        let s = ((0.5 - a).powi(2) + b * b) / ((0.5 + a).powi(2) + b * b);
        // r∥ = (η² cos - (a+ib))/(η² cos + (a+ib)).
        let (x, y) = ((0.04 - 9.0) * 0.5, im * 0.5);
        let p = ((x - a).powi(2) + (y - b).powi(2)) / ((x + a).powi(2) + (y + b).powi(2));
        let f = fresnel_conductor(0.5, unit(0.2), unit(3.0))[0] as f64;
        assert!((f - 0.5 * (s + p)).abs() < 1e-6, "{f} {}", 0.5 * (s + p));
        for cos in [0.0, 0.3, 1.0] {
            assert!(fresnel_conductor(cos, unit(0.0), unit(0.0)).is_finite());
        }
    }

    #[test]
    fn diffuse_reflectance_is_the_integral() {
        for eta in [1.01f32, 1.1, 1.33, 1.49, 1.5, 2.4, 4.0, 0.9, 0.67, 0.4] {
            let n = 200_000;
            let sum: f64 = (0..n)
                .map(|i| {
                    let mu = (i as f64 + 0.5) / n as f64;
                    2.0 * mu * fresnel_dielectric(mu as f32, eta).reflectance as f64
                })
                .sum();
            let (exact, closed) = (sum / n as f64, fresnel_diffuse_reflectance(eta) as f64);
            assert!((exact - closed).abs() < 2e-6, "{eta}: {exact} {closed}");
        }
        assert_eq!(fresnel_diffuse_reflectance(1.0), 0.0);
    }

    #[test]
    fn schlick_has_its_ends() {
        let r = fresnel_schlick(1.0, Spectrum::splat(0.04));
        assert!((r[0] - 0.04).abs() < 1e-7);
        assert_eq!(fresnel_schlick(0.0, Spectrum::splat(0.04))[0], 1.0);
    }
}
