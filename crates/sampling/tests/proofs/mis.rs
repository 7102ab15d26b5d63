//! Multiple importance sampling: weights, unbiasedness, Veach's bound, names.

use crate::support::*;
use kaustika_sampling::{Heuristic, MisHeuristic};

const HEURISTICS: [Heuristic; 6] = [
    Heuristic::Balance,
    Heuristic::Power(0.0),
    Heuristic::Power(0.5),
    Heuristic::Power(2.0),
    Heuristic::Power(7.3),
    Heuristic::Maximum,
];

#[test]
fn weights_sum_to_one_for_all_densities() {
    let extremes =
        [0.0, f32::MIN_POSITIVE, 1e-30, 0.3, 0.3, 1.0, 17.0, 1e30, f32::MAX, f32::INFINITY];
    let infinite_power = Heuristic::Power(f32::INFINITY);
    for h in HEURISTICS.into_iter().chain([infinite_power]) {
        for q0 in extremes {
            for q1 in extremes {
                let (a, b) = h.pair(q0, q1);
                let expected = if q0 > 0.0 || q1 > 0.0 { 1.0 } else { 0.0 };
                assert!((a + b - expected).abs() < 1e-6, "{h:?} {q0} {q1}: {a} + {b}");
                assert!((q0 > 0.0 || a == 0.0) && (q1 > 0.0 || b == 0.0), "{h:?} {q0} {q1}");
                assert!((h.weight(0, &[q0, q1]) - a).abs() < 1e-5, "{h:?} {q0} {q1}");
                assert!((h.weight(1, &[q0, q1]) - b).abs() < 1e-5, "{h:?} {q0} {q1}");
                for q2 in extremes {
                    let q = [q0, q1, q2];
                    let sum: f32 = (0..3).map(|i| h.weight(i, &q)).sum();
                    let expected = if q.iter().any(|q| *q > 0.0) { 1.0 } else { 0.0 };
                    assert!((sum - expected).abs() < 1e-6, "{h:?} {q:?}: {sum}");
                }
            }
        }
        assert_eq!(h.pair(f32::NAN, 1.0), (0.0, 1.0), "{h:?}");
        assert_eq!(h.pair(1.0, f32::NAN), (1.0, 0.0), "{h:?}");
    }
    assert_eq!(Heuristic::Maximum.pair(2.0, 2.0), (1.0, 0.0));
    for m in [MisHeuristic::OnlyLight, MisHeuristic::OnlyBsdf, MisHeuristic::default()] {
        for q0 in extremes {
            for q1 in extremes {
                let expected = if q0 > 0.0 || q1 > 0.0 { 1.0 } else { 0.0 };
                assert!(
                    (m.light(q0, q1) + m.bsdf(q0, q1) - expected).abs() < 1e-6,
                    "{m} {q0} {q1}"
                );
            }
        }
    }
    assert_eq!(MisHeuristic::OnlyLight.light(1.0, 5.0), 1.0);
    assert_eq!(MisHeuristic::OnlyLight.bsdf(0.0, 5.0), 1.0);
    assert_eq!(MisHeuristic::OnlyBsdf.light(1.0, 5.0), 0.0);
    assert_eq!(MisHeuristic::OnlyBsdf.light(1.0, 0.0), 1.0);
}

/// MIS of three techniques for ∫ f on [0, 1]: uniform, linear, and constant on the upper half;
/// two samples of the second. Where x is in the upper half the first and the third tie if
/// `tie` scales the third to the same n·p.
fn mis_estimate(h: Heuristic, rng: &mut Rng) -> f64 {
    let f = |x: f64| x * x * (1.0 + (8.0 * x).sin());
    let q = |x: f64| {
        // n·p: uniform 1; linear 2 × 2x; upper half: 2, taken with probability ½ as n = ½.
        [1.0, 4.0 * x as f32, if x >= 0.5 { 1.0 } else { 0.0 }]
    };
    let mut sum = 0.0;
    let mut add = |i: usize, x: f64| {
        let q = q(x);
        sum += f64::from(h.weight(i, &q)) * f(x) / f64::from(q[i]);
    };
    add(0, rng.f64());
    add(1, rng.f64().sqrt());
    add(1, rng.f64().sqrt());
    if rng.f64() < 0.5 {
        add(2, 0.5 + 0.5 * rng.f64());
    }
    sum
}

#[test]
fn all_heuristics_are_unbiased_ties_included() {
    // ∫ x² + x² sin 8x.
    let truth = 1.0 / 3.0 + (-62.0 * 8f64.cos() + 16.0 * 8f64.sin() - 2.0) / 512.0;
    let mut rng = Rng::new(7);
    for h in HEURISTICS {
        let estimates: Vec<f64> = (0..60_000).map(|_| mis_estimate(h, &mut rng)).collect();
        let p = p_mean(&estimates, truth);
        assert!(p > sidak(6), "{h:?}: p {p}");
    }
}

#[test]
fn the_power_heuristic_is_continuous_in_its_power() {
    for (q0, q1) in [(1.0, 2.0), (3.0, 0.1), (5.0, 5.0)] {
        let w = |beta| Heuristic::Power(beta).first(q0, q1);
        assert_eq!(w(1.0), Heuristic::Balance.first(q0, q1));
        for i in 0..400 {
            let beta = i as f32 * 0.01;
            assert!((w(beta + 0.01) - w(beta)).abs() < 0.02, "{q0} {q1} at {beta}");
        }
        if q0 != q1 {
            assert!((w(500.0) - Heuristic::Maximum.first(q0, q1)).abs() < 1e-6);
        }
    }
    // The same walk of random numbers estimates alike for close powers.
    let mean = |beta| {
        let mut rng = Rng::new(8);
        (0..1000).map(|_| mis_estimate(Heuristic::Power(beta), &mut rng)).sum::<f64>() / 1000.0
    };
    for beta in [0.0f32, 0.99, 1.99, 4.0] {
        assert!((mean(beta) - mean(beta + 0.01)).abs() < 1e-3, "{beta}");
    }
}

#[test]
fn balance_is_within_veachs_bound() {
    // Var(balance) ≤ Var(any) + (1/min n - 1/Σn) μ² (Veach 1997, theorem 9.2) for two
    // techniques with one sample each, against each of the other heuristics.
    let truth = 0.75;
    let f = |x: f64| x + 0.75 * x * x;
    let mut rng = Rng::new(9);
    let mut variance = |h: Heuristic| {
        let estimates: Vec<f64> = (0..50_000)
            .map(|_| {
                let (x, y) = (rng.f64(), rng.f64().sqrt());
                let (a, _) = h.pair(1.0, 2.0 * x as f32);
                let (_, b) = h.pair(1.0, 2.0 * y as f32);
                f64::from(a) * f(x) + f64::from(b) * f(y) / (2.0 * y)
            })
            .collect();
        let p = p_mean(&estimates, truth);
        assert!(p > sidak(6), "{h:?} p {p}");
        mean_variance(&estimates).1
    };
    let balance = variance(Heuristic::Balance);
    for h in HEURISTICS {
        let other = variance(h);
        assert!(balance <= 1.05 * other + 0.5 * truth * truth, "{h:?}: {balance} {other}");
    }
}

#[test]
fn heuristics_parse() {
    for (name, h) in [
        ("balance", MisHeuristic::Both(Heuristic::Balance)),
        ("power", MisHeuristic::Both(Heuristic::Power(2.0))),
        ("power:3", MisHeuristic::Both(Heuristic::Power(3.0))),
        ("power:0.5", MisHeuristic::Both(Heuristic::Power(0.5))),
        ("max", MisHeuristic::Both(Heuristic::Maximum)),
        ("light", MisHeuristic::OnlyLight),
        ("bsdf", MisHeuristic::OnlyBsdf),
    ] {
        assert_eq!(name.parse(), Ok(h));
        assert_eq!(h.to_string(), name);
    }
    assert_eq!("maximum".parse(), Ok(Heuristic::Maximum));
    for name in ["power:-1", "power:nan", "power:", "Balance", ""] {
        assert!(name.parse::<MisHeuristic>().is_err(), "{name}");
    }
    assert!("light".parse::<Heuristic>().unwrap_err().to_string().contains("known are balance"));
}
