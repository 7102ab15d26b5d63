//! Sums that stand for integrals.

use std::f64::consts::PI;

/// Nodes and weights of Gauss and Legendre's rule of `n` points on [0, 1], exact for polynomials of degree
/// 2n - 1: Newton's iteration on the polynomial's roots from Tricomi's approximation.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let node = |i: usize| {
        let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..20 {
            let (mut p, mut before) = (x, 1.0);
            for k in 2..=n {
                let k = k as f64;
                (p, before) = (((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k, p);
            }
            slope = n as f64 * (x * p - before) / (x * x - 1.0);
            let step = p / slope;
            x -= step;
            if step.abs() < 1e-15 {
                break;
            }
        }
        (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..n).map(node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_legendre_is_exact_for_polynomials() {
        for n in [1, 2, 5, 32, 128] {
            let rule = gauss_legendre(n);
            for power in 0..(2 * n).min(9) as i32 {
                let sum: f64 = rule.iter().map(|&(x, w)| w * x.powi(power)).sum();
                assert!((sum - 1.0 / (power + 1) as f64).abs() < 1e-12, "{n} {power}: {sum}");
            }
        }
    }
}
