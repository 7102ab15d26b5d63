//! Special functions that the standard library lacks.

/// sin and cos of `q` eighths of a turn, q π/4, for |q| ≤ 1; errors below 1.2e-7.
///
/// Odd and even polynomials of degree 7 and 6 that interpolate at Chebyshev's points: neither
/// calls nor branches, where the C library has both.
#[inline]
pub fn sin_cos_eighth(q: f32) -> (f32, f32) {
    let x = q * q;
    let sin = SIN[3].mul_add(x, SIN[2]).mul_add(x, SIN[1]).mul_add(x, SIN[0]) * q;
    let cos = COS[3].mul_add(x, COS[2]).mul_add(x, COS[1]).mul_add(x, COS[0]);
    (sin, cos)
}

/// sin and cos of `u` turns, 2πu, for u in [0, 1]; errors below 2e-7. The reduction to an
/// eighth of a turn is exact.
#[inline]
pub fn sin_cos_turn(u: f32) -> (f32, f32) {
    let quarters = 4.0 * u;
    let nearest = (quarters + 0.5) as i32;
    let (s, c) = sin_cos_eighth(2.0 * (quarters - nearest as f32));
    let (s, c) = if nearest & 1 == 0 { (s, c) } else { (c, s) };
    let sin = if nearest & 2 == 0 { s } else { -s };
    let cos = if (nearest + 1) & 2 == 0 { c } else { -c };
    (sin, cos)
}

/// Coefficients of sin(q π/4)/q and cos(q π/4) in powers of q².
pub(crate) const SIN: [f32; 4] =
    [std::f32::consts::FRAC_PI_4, -0.080_745_435, 0.002_490_006_8, -3.595_429_1e-5];
pub(crate) const COS: [f32; 4] = [0.999_999_97, -0.308_424_25, 0.015_849_911, -3.188_774_7e-4];

/// The error function, accurate to 1.2e-7 (rational Chebyshev fit, Numerical Recipes' erfc).
pub fn erf(x: f64) -> f64 {
    1.0 - erfc(x)
}

/// The complementary error function 1 - erf(x), relative error below 1.2e-7 everywhere.
pub fn erfc(x: f64) -> f64 {
    let z = x.abs();
    let t = 2.0 / (2.0 + z);
    const C: [f64; 10] = [
        -1.26551223,
        1.00002368,
        0.37409196,
        0.09678418,
        -0.18628806,
        0.27886807,
        -1.13520398,
        1.48851587,
        -0.82215223,
        0.17087277,
    ];
    let poly = C.iter().rev().fold(0.0, |acc, c| acc * t + c);
    let r = t * (-z * z + poly).exp();
    if x >= 0.0 { r } else { 2.0 - r }
}

/// The inverse error function on (-1, 1) (Giles 2012, single-precision polynomial).
pub fn erf_inv(x: f32) -> f32 {
    let x = x.clamp(-0.999_999_9, 0.999_999_9);
    let mut w = -((1.0 - x) * (1.0 + x)).ln();
    let coefficients: [f32; 9];
    if w < 5.0 {
        w -= 2.5;
        coefficients = [
            2.81022636e-08,
            3.43273939e-07,
            -3.5233877e-06,
            -4.39150654e-06,
            0.00021858087,
            -0.00125372503,
            -0.00417768164,
            0.246640727,
            1.50140941,
        ];
    } else {
        w = w.sqrt() - 3.0;
        coefficients = [
            -0.000200214257,
            0.000100950558,
            0.00134934322,
            -0.00367342844,
            0.00573950773,
            -0.0076224613,
            0.00943887047,
            1.00167406,
            2.83297682,
        ];
    }
    coefficients.iter().fold(0.0, |acc, c| acc * w + c) * x
}

/// ln I₀(x), the modified Bessel function of the first kind of order 0, for x >= 0; relative
/// error of I₀ below 1e-6 (Abramowitz & Stegun 1964, 9.8.1 and 9.8.2).
pub fn ln_i0(x: f32) -> f32 {
    let x = x.max(0.0);
    let polynomial = |t: f32, c: &[f32]| c.iter().rev().fold(0.0, |sum, &c| sum * t + c);
    if x < 3.75 {
        let t = (x / 3.75) * (x / 3.75);
        return polynomial(t, &I0_NEAR).ln();
    }
    x - 0.5 * x.ln() + polynomial(3.75 / x, &I0_FAR).ln()
}

/// I₀(x) in powers of (x/3.75)².
const I0_NEAR: [f32; 7] =
    [1.0, 3.515_622_9, 3.089_942_4, 1.206_749_2, 0.265_973_2, 0.036_076_8, 0.004_581_3];

/// √x e⁻ˣ I₀(x) in powers of 3.75/x.
const I0_FAR: [f32; 9] = [
    0.398_942_28,
    0.013_285_92,
    0.002_253_19,
    -0.001_575_65,
    0.009_162_81,
    -0.020_577_06,
    0.026_355_37,
    -0.016_476_33,
    0.003_923_77,
];

/// Two-sided p-value of a standard normal deviate: P(|Z| > |z|).
pub fn p_two_sided(z: f64) -> f64 {
    erfc_precise(z.abs() / std::f64::consts::SQRT_2)
}

/// erfc to double precision: series for small arguments, continued fraction for large ones.
fn erfc_precise(x: f64) -> f64 {
    if x < 2.5 {
        // erf(x) = 2/√π e^{-x²} Σ 2ⁿ x^{2n+1} / (2n+1)!!
        let (mut term, mut sum) = (x, x);
        for n in 1..200 {
            term *= 2.0 * x * x / (2 * n + 1) as f64;
            sum += term;
            if term < sum * 1e-17 {
                break;
            }
        }
        1.0 - 2.0 / std::f64::consts::PI.sqrt() * (-x * x).exp() * sum
    } else {
        // Lentz-free backward evaluation of e^{-x²}/√π · 1/(x + (1/2)/(x + 1/(x + (3/2)/(x + …
        let mut f = x;
        for k in (1..=120).rev() {
            f = x + 0.5 * k as f64 / f;
        }
        (-x * x).exp() / (f * std::f64::consts::PI.sqrt())
    }
}

/// Regularised upper incomplete gamma function Q(a, x): the p-value of a chi-square statistic
/// `c` with `n` degrees of freedom is Q(n/2, c/2).
pub fn gamma_q(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let log_prefix = a * x.ln() - x - ln_gamma(a);
    if x < a + 1.0 {
        let (mut term, mut sum, mut k) = (1.0 / a, 1.0 / a, a);
        for _ in 0..10_000 {
            k += 1.0;
            term *= x / k;
            sum += term;
            if term < sum * 1e-15 {
                break;
            }
        }
        1.0 - sum * log_prefix.exp()
    } else {
        let mut b = x + 1.0 - a;
        let mut c = 1e300;
        let mut d = 1.0 / b;
        let mut h = d;
        for i in 1..10_000 {
            let an = -(i as f64) * (i as f64 - a);
            b += 2.0;
            d = 1.0 / (an * d + b);
            c = b + an / c;
            let delta = d * c;
            h *= delta;
            if (delta - 1.0).abs() < 1e-15 {
                break;
            }
        }
        h * log_prefix.exp()
    }
}

/// ln Γ(x) for x > 0 (Lanczos, g = 7).
pub fn ln_gamma(x: f64) -> f64 {
    const C: [f64; 9] = [
        0.999_999_999_999_809_93,
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_13,
        -176.615_029_162_140_59,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_571_6e-6,
        1.505_632_735_149_311_6e-7,
    ];
    if x < 0.5 {
        let pi = std::f64::consts::PI;
        return (pi / (pi * x).sin()).ln() - ln_gamma(1.0 - x);
    }
    let x = x - 1.0;
    let t = x + 7.5;
    let sum = C[0] + (1..9).map(|i| C[i] / (x + i as f64)).sum::<f64>();
    0.5 * (2.0 * std::f64::consts::PI).ln() + (x + 0.5) * t.ln() - t + sum.ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_and_cosines_are_within_their_bounds() {
        let n = 1 << 20;
        for i in 0..=n {
            let q = 2.0 * i as f32 / n as f32 - 1.0;
            let (s, c) = sin_cos_eighth(q);
            let exact = (f64::from(q) * std::f64::consts::FRAC_PI_4).sin_cos();
            assert!((f64::from(s) - exact.0).abs() < 1.2e-7, "sin {q}");
            assert!((f64::from(c) - exact.1).abs() < 1.2e-7, "cos {q}");
            let u = i as f32 / n as f32;
            let (s, c) = sin_cos_turn(u);
            let exact = (f64::from(u) * std::f64::consts::TAU).sin_cos();
            assert!((f64::from(s) - exact.0).abs() < 2e-7, "sin of {u} turns");
            assert!((f64::from(c) - exact.1).abs() < 2e-7, "cos of {u} turns");
        }
    }

    #[test]
    fn known_values() {
        assert!((erf(0.5) - 0.520_499_877_8).abs() < 2e-7);
        assert!((erf(-1.0) + 0.842_700_792_9).abs() < 2e-7);
        for x in [-0.95f32, -0.3, 0.0, 0.2, 0.7, 0.999] {
            assert!((erf(erf_inv(x) as f64) - x as f64).abs() < 1e-6);
        }
        assert!((p_two_sided(1.959_963_985) - 0.05).abs() < 1e-9);
        assert!((p_two_sided(5.0) / 5.733_031_437_583_866e-7 - 1.0).abs() < 1e-9);
        // Chi-square, 10 degrees of freedom: 18.307 is the 5 % point.
        assert!((gamma_q(5.0, 18.307_038_05 / 2.0) - 0.05).abs() < 1e-8);
        assert!((ln_gamma(10.5) - 13.940_625_219_403_763).abs() < 1e-10);
    }

    /// Against the integral 1/π ∫₀^π exp(x cos t) dt, whose trapezoids converge exponentially.
    #[test]
    fn bessel_is_its_integral() {
        for x in [0.0f64, 0.3, 1.0, 3.7, 3.8, 7.0, 12.0, 50.0, 300.0] {
            let n = 4000;
            let scaled =
                |k: u32| (x * ((std::f64::consts::PI * k as f64 / n as f64).cos() - 1.0)).exp();
            let sum: f64 = (1..n).map(scaled).sum::<f64>() + 0.5 * (scaled(0) + scaled(n));
            let exact = x + (sum / n as f64).ln();
            let error = ln_i0(x as f32) as f64 - exact;
            assert!(error.abs() < 1e-6 + 1e-7 * x, "{x}: {error:e}");
        }
    }
}
