//! The basics of Monte Carlo quadrature, as the lecture tabulates them.

use crate::support::*;
use kaustika_sampling::SamplerKind;
use kaustika_sampling::estimator::{RunningMean, normal_quantile};
use kaustika_sampling::strata::Strata;
use kaustika_sampling::walk::{Fredholm, roulette, roulette_variance};

#[test]
fn running_means_merge() {
    let mut rng = Rng::new(1);
    let values: Vec<f64> = (0..1000).map(|_| 1e6 + rng.f64()).collect();
    let (mean, variance) = mean_variance(&values);
    let all: RunningMean = values.iter().copied().collect();
    let mut merged = RunningMean::new();
    for part in values.chunks(77) {
        merged.merge(&part.iter().copied().collect());
    }
    merged.merge(&RunningMean::new());
    for r in [all, merged] {
        assert_eq!(r.count(), 1000);
        assert!((r.mean() - mean).abs() < 1e-8);
        assert!((r.variance() / variance - 1.0).abs() < 1e-6);
        assert!((r.relative_error() * mean / r.standard_error() - 1.0).abs() < 1e-9);
    }
    assert!(RunningMean::new().variance().is_infinite());
    assert!((normal_quantile(0.95) - 1.959_964).abs() < 1e-5);
    assert!((normal_quantile(0.5) - 0.674_490).abs() < 1e-5);
}

#[test]
fn confidence_intervals_cover_the_truth() {
    // ∫ 3x² = 1 by 200 samples, 4000 runs: coverage within 3σ of 95 %, and of 50 %.
    let mut rng = Rng::new(2);
    let runs = 4000;
    for confidence in [0.95, 0.5] {
        let covered = (0..runs)
            .filter(|_| {
                let r: RunningMean = (0..200).map(|_| 3.0 * rng.f64().powi(2)).collect();
                let (low, high) = r.confidence_interval(confidence);
                (low..=high).contains(&1.0)
            })
            .count();
        let share = covered as f64 / f64::from(runs);
        let sigma = (confidence * (1.0 - confidence) / f64::from(runs)).sqrt();
        assert!((share - confidence).abs() < 3.0 * sigma + 0.003, "{confidence}: {share}");
    }
}

#[test]
fn random_sampling_converges_as_the_root_in_any_dimension() {
    // SLOPE: f = Π (1 + (x-½)/2), ∫f = 1, in 1, 5 and 20 dimensions.
    let rmse = |kind, dimensions: u32, n: u64| {
        let sum: f64 = (0..64)
            .map(|seed| {
                let plan = plan(kind, seed, n);
                let total: f64 = (0..n)
                    .map(|i| {
                        let mut s = plan.start([0, 0], i);
                        (0..dimensions)
                            .map(|_| 1.0 + 0.5 * (f64::from(s.get_1d()) - 0.5))
                            .product::<f64>()
                    })
                    .sum();
                (total / n as f64 - 1.0).powi(2)
            })
            .sum();
        (sum / 64.0).sqrt()
    };
    for dimensions in [1, 5, 20] {
        let fit = |kind| {
            slope(
                &[4, 6, 8, 10]
                    .map(|k| (f64::from(k) * 2f64.ln(), rmse(kind, dimensions, 1 << k).ln())),
            )
        };
        let random = fit(SamplerKind::Independent);
        assert!((random + 0.5).abs() < 0.08, "{dimensions}: {random}");
        // Padding keeps the one-dimensional parts' gain: a steeper start and a lower curve.
        let (s, r) = (
            rmse(SamplerKind::Sobol, dimensions, 256),
            rmse(SamplerKind::Independent, dimensions, 256),
        );
        assert!(s < 0.5 * r, "{dimensions}: sobol {s}, independent {r}");
        if dimensions == 1 {
            let sobol = fit(SamplerKind::Sobol);
            assert!(sobol < -1.3, "{sobol}");
        }
    }
}

#[test]
fn jittering_a_linear_integrand() {
    // Variances 1/(12N³) and 1/(12N); each estimated from 20 000 runs (σ about 1 %).
    let mut rng = Rng::new(3);
    for n in [4usize, 16] {
        let strata = Strata::equal(n);
        let jittered: Vec<f64> =
            (0..20_000).map(|_| strata.estimate(|x| x, || rng.f64())).collect();
        let random: Vec<f64> =
            (0..20_000).map(|_| (0..n).map(|_| rng.f64()).sum::<f64>() / n as f64).collect();
        let n = n as f64;
        assert!((mean_variance(&jittered).1 * 12.0 * n.powi(3) - 1.0).abs() < 0.05);
        assert!((mean_variance(&random).1 * 12.0 * n - 1.0).abs() < 0.05);
    }
    // The sampler's jittering does the same with N planned samples.
    let n = 16u64;
    let means: Vec<f64> = (0..5000)
        .map(|seed| {
            let plan = plan(SamplerKind::Stratified, seed, n);
            (0..n).map(|i| f64::from(plan.start([0, 0], i).get_1d())).sum::<f64>() / n as f64
        })
        .collect();
    assert!((mean_variance(&means).1 * 12.0 * 16f64.powi(3) - 1.0).abs() < 0.08);
}

#[test]
fn unequal_strata_are_unbiased_and_adapted_ones_better() {
    let mut rng = Rng::new(4);
    let step = |x: f64| if x < 0.3 { 1.0 } else { 10.0 + x };
    let truth = 0.3 + 7.0 + 0.5 * (1.0 - 0.09);
    let mut run = |strata: &Strata| -> Vec<f64> {
        (0..5000).map(|_| strata.estimate(step, || rng.f64())).collect()
    };
    let equal = run(&Strata::equal(4));
    let uneven = run(&Strata::new(vec![0.0, 0.01, 0.4, 0.5, 1.0]).expect("increasing"));
    let adapted = run(&Strata::new(vec![0.0, 0.3, 0.5, 0.75, 1.0]).expect("increasing"));
    for estimates in [&equal, &uneven, &adapted] {
        let p = p_mean(estimates, truth);
        assert!(p > sidak(3), "p {p}");
    }
    let random: Vec<f64> =
        (0..5000).map(|_| (0..4).map(|_| step(rng.f64())).sum::<f64>() / 4.0).collect();
    let variance = |v: &[f64]| mean_variance(v).1;
    assert!(variance(&equal) < variance(&random));
    assert!(variance(&adapted) < 0.05 * variance(&equal));
    assert!(Strata::new(vec![0.0, 0.0, 1.0]).is_err());
    assert!(Strata::new(vec![0.0]).is_err());
    assert_eq!(Strata::equal(0).len(), 1);
}

#[test]
fn importance_sampling_with_the_integrand_has_no_variance() {
    let f = |x: f64| 3.0 * x * x;
    let mut rng = Rng::new(5);
    let r: RunningMean = (0..1000)
        .map(|_| {
            let x = (1.0 - rng.f64()).cbrt();
            5.0 * f(x) / (3.0 * x * x)
        })
        .collect();
    assert!(r.variance() < 1e-28 && (r.mean() - 5.0).abs() < 1e-12);
}

#[test]
fn a_density_that_misses_part_of_the_integrand_is_caught() {
    // p = 0 on [0.9, 1], where f is not: 0.9 in the mean instead of 1.
    let mut rng = Rng::new(6);
    let biased: Vec<f64> = (0..10_000).map(|_| 2.0 * 0.9 * rng.f64() * 0.9).collect();
    assert!(p_mean(&biased, 1.0) < 1e-6);
    let whole: Vec<f64> = (0..10_000).map(|_| 2.0 * rng.f64()).collect();
    assert!(p_mean(&whole, 1.0) > sidak(1));
}

#[test]
fn fredholm_equations_are_solved_by_walks() {
    let uniform = |_: f64, u: f64| (u, 1.0);
    let mut rng = Rng::new(10);
    let n = 40_000;
    // K = λ, g = 1: f = 1/(1-λ), for any survival probability.
    for lambda in [0.3, 0.7] {
        for survival in [0.4, 0.7, 0.9] {
            let equation = Fredholm {
                kernel: |_, _| lambda,
                source: |_| 1.0,
                step: uniform,
                survival: |_| survival,
            };
            let values: Vec<f64> = (0..n).map(|_| equation.walk(0.2, || rng.f64()).value).collect();
            // The variance is finite for λ² < P only.
            if lambda * lambda < 0.9 * survival {
                let p = p_mean(&values, 1.0 / (1.0 - lambda));
                assert!(p > sidak(12), "λ {lambda} P {survival}: p {p}");
            }
        }
    }
    // With P = ∫K every weight is 1 and a walk has 1/(1-P) vertices in the mean.
    let equation =
        Fredholm { kernel: |_, _| 0.7, source: |_| 1.0, step: uniform, survival: |_| 0.7 };
    let vertices: Vec<f64> = (0..n)
        .map(|_| {
            let walk = equation.walk(0.0, || rng.f64());
            assert!((walk.value - f64::from(walk.vertices)).abs() < 1e-9);
            f64::from(walk.vertices)
        })
        .collect();
    assert!(p_mean(&vertices, 1.0 / 0.3) > sidak(12));
    // K = λxy, g = x: f = x/(1-λ/3); by uniform steps and by steps in proportion to y.
    let lambda = 2.0;
    for x in [0.25, 1.0] {
        let truth = x / (1.0 - lambda / 3.0);
        let even = Fredholm {
            kernel: |x: f64, y: f64| lambda * x * y,
            source: |x: f64| x,
            step: uniform,
            survival: |x: f64| 0.5 * lambda * x,
        };
        let importance = Fredholm {
            kernel: |x: f64, y: f64| lambda * x * y,
            source: |x: f64| x,
            step: |_: f64, u: f64| {
                let y = (1.0 - u).sqrt();
                (y, 2.0 * y)
            },
            survival: |_: f64| 0.8,
        };
        let a: Vec<f64> = (0..n).map(|_| even.walk(x, || rng.f64()).value).collect();
        let b: Vec<f64> = (0..n).map(|_| importance.walk(x, || rng.f64()).value).collect();
        assert!(p_mean(&a, truth) > sidak(12), "uniform from {x}");
        assert!(p_mean(&b, truth) > sidak(12), "importance from {x}");
    }
}

#[test]
fn roulette_keeps_the_mean_and_raises_the_variance_as_predicted() {
    let mut rng = Rng::new(11);
    let n = 200_000;
    // X = 1 + U: mean 3/2, variance 1/12.
    for p in [0.1f32, 0.5, 0.9, 1.0, 3.0] {
        let values: Vec<f64> = (0..n)
            .map(|_| {
                let x = 1.0 + rng.f64();
                roulette(p, rng.f32()).map_or(0.0, |w| f64::from(w) * x)
            })
            .collect();
        assert!(p_mean(&values, 1.5) > sidak(5), "{p}");
        let expected = roulette_variance(1.0 / 12.0, 1.5, f64::from(p.min(1.0)));
        let (_, variance) = mean_variance(&values);
        assert!((variance / expected - 1.0).abs() < 0.03, "{p}: {variance} {expected}");
    }
    assert_eq!(roulette(0.0, 0.0), None);
}
