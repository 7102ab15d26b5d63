//! One von Mises-Fisher lobe, the normal distribution of the sphere, about the unit vector μ.
//!
//! ```text
//! v(ω; μ, κ) = c(κ) e^{κ(μ·ω - 1)},    c(κ) = κ / (2π (1 - e^{-2κ}))                     (1)
//! ∫ v ω dω = R(κ) μ,                   R(κ) = coth κ - 1/κ                               (2)
//! κ ≈ R (3 - R²)/(1 - R²),   then   κ ← κ - (R(κ) - R)/(1 - R(κ)² - 2 R(κ)/κ)            (3)
//! ∫ v |n·ω| dω = I₁(κ)/sinh κ   for   n ⟂ μ                                              (4)
//! ```
//!
//! (1), (2): Mardia & Jupp 2000, "Directional Statistics", sec. 9.3. (3): Banerjee et al. 2005,
//! "Clustering on the Unit Hypersphere using von Mises-Fisher Distributions", eq. 4.4, and the
//! steps of Newton that Sra 2012 adds to it.

use std::f64::consts::PI;

/// κ is kept between these: what is nearly uniform is as good as uniform, and a lobe of 0.4° as
/// good as a direction.
pub const LEAST_KAPPA: f64 = 1e-2;
pub const MOST_KAPPA: f64 = 3.2e4;

/// c(κ), per solid angle. (1)
pub fn normalization(kappa: f64) -> f64 {
    -kappa / (2.0 * PI * (-2.0 * kappa).exp_m1())
}

/// R(κ), the mean cosine. (2)
pub fn mean_cosine(kappa: f64) -> f64 {
    if kappa < 0.02 {
        return kappa / 3.0 - kappa.powi(3) / 45.0;
    }
    1.0 / kappa.tanh() - 1.0 / kappa
}

/// κ of the mean cosine R. (3)
pub fn concentration(r: f64) -> f64 {
    let r = r.clamp(0.0, 1.0 - 1.0 / MOST_KAPPA);
    // coth κ is 1 to 17 digits.
    if r > 0.95 {
        return 1.0 / (1.0 - r);
    }
    let mut kappa = r * (3.0 - r * r) / (1.0 - r * r);
    for _ in 0..2 {
        if kappa > LEAST_KAPPA {
            let a = mean_cosine(kappa);
            kappa -= (a - r) / (1.0 - a * a - 2.0 * a / kappa);
        }
    }
    kappa.max(LEAST_KAPPA)
}

/// (4), by the polynomials of Abramowitz & Stegun 1964, 9.8.3 and 9.8.4, to 10⁻⁶.
pub fn mean_abs_cosine(kappa: f64) -> f64 {
    let horner = |t: f64, c: &[f64]| c.iter().rev().fold(0.0, |sum, c| sum * t + c);
    if kappa < 3.75 {
        let t = (kappa / 3.75).powi(2);
        let i1 = horner(
            t,
            &[0.5, 0.87890594, 0.51498869, 0.15084934, 0.02658733, 0.00301532, 0.00032411],
        );
        return i1 * if kappa > 1e-3 { kappa / kappa.sinh() } else { 1.0 };
    }
    let i1 = horner(
        3.75 / kappa,
        &[
            0.39894228,
            -0.03988024,
            -0.00362018,
            0.00163801,
            -0.01031555,
            0.02282967,
            -0.02895312,
            0.01787654,
            -0.00420059,
        ],
    );
    2.0 * i1 / (kappa.sqrt() * (1.0 - (-2.0 * kappa).exp()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ v f(ω) dω for f of cos θ about μ and, if `across`, about an axis perpendicular to it.
    fn integral(kappa: f64, across: bool, f: impl Fn(f64) -> f64) -> f64 {
        let n = 1500;
        let mut sum = 0.0;
        for i in 0..n {
            // cos θ by the inverse of its distribution: evenly in probability.
            let u = (f64::from(i) + 0.5) / f64::from(n);
            let z = 1.0 + (u + (1.0 - u) * (-2.0 * kappa).exp()).ln() / kappa;
            let r = (1.0 - z * z).max(0.0).sqrt();
            let m = if across { 400 } else { 1 };
            for j in 0..m {
                let phi = 2.0 * PI * (f64::from(j) + 0.5) / f64::from(m);
                sum += f(if across { r * phi.cos() } else { z }) / f64::from(n * m);
            }
        }
        sum
    }

    #[test]
    fn means_are_those_of_the_density() {
        for kappa in [0.01, 0.1, 1.0, 3.7, 3.8, 20.0, 400.0, 3e4] {
            let r = integral(kappa, false, |z| z);
            // What a mean over 1500 strata misses falls with the spread of cos θ.
            let tolerance = 1e-3 / kappa.max(1.0);
            assert!((mean_cosine(kappa) - r).abs() < tolerance, "{kappa} {r}");
            let across = integral(kappa, true, f64::abs);
            let ours = mean_abs_cosine(kappa);
            assert!((ours / across - 1.0).abs() < 1e-3, "{kappa} {across} {ours}");
        }
    }

    #[test]
    fn concentrations_are_found_again() {
        for i in 0..=100 {
            let kappa = LEAST_KAPPA * (MOST_KAPPA / LEAST_KAPPA).powf(f64::from(i) / 100.0);
            let again = concentration(mean_cosine(kappa));
            assert!((again / kappa - 1.0).abs() < 1e-3, "{kappa} {again}");
        }
        assert_eq!(concentration(0.0), LEAST_KAPPA);
        assert!((concentration(1.0) / MOST_KAPPA - 1.0).abs() < 1e-9);
    }
}
