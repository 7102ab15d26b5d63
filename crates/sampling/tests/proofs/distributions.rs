//! Every distribution: chi-square of samples against the integrated density, the density
//! returned against the density asked for, inverses, edge cases.

use crate::support::*;
use kaustika_math::Vec2;
use kaustika_sampling::distribution::*;

/// Tables with zeros at both ends and inside, spikes and one entry.
fn tables() -> Vec<Vec<f32>> {
    let mut rng = Rng::new(8);
    vec![
        vec![3.0],
        vec![1.0, 1.0],
        vec![0.0, 2.0, 0.0, 0.0, 5.0, 1.0, 0.0],
        vec![1e-20, 1e20, 1e-20, 5e19],
        (0..37).map(|_| rng.f32()).collect(),
        (0..257).map(|i| if i % 5 == 0 { 0.0 } else { rng.f32().powi(6) }).collect(),
    ]
}

#[test]
fn invalid_weights_are_errors() {
    assert_eq!(Discrete::new(&[]).unwrap_err(), InvalidWeights::Shape { expected: 1, found: 0 });
    assert_eq!(Discrete::new(&[0.0, 0.0]).unwrap_err(), InvalidWeights::Zero);
    assert_eq!(Discrete::new(&[1.0, -1.0]).unwrap_err(), InvalidWeights::Value { index: 1 });
    let nan = [1.0, f32::NAN];
    assert_eq!(PiecewiseConstant1D::new(&nan).unwrap_err(), InvalidWeights::Value { index: 1 });
    assert_eq!(PiecewiseConstant1D::new(&[0.0]).unwrap_err(), InvalidWeights::Zero);
    let infinite = [f32::INFINITY; 4];
    assert_eq!(
        PiecewiseConstant2D::new(&infinite, 2, 2).unwrap_err().to_string(),
        "weight 0 is negative, infinite or not a number"
    );
    assert!(PiecewiseConstant2D::new(&[1.0; 5], 2, 3).is_err());
    assert!(PiecewiseLinear1D::new(&[1.0]).is_err());
}

#[test]
fn discrete_matches_its_weights_and_leaves_a_uniform_number() {
    let mut rng = Rng::new(1);
    let n = 200_000;
    let tests = 2 * tables().len();
    for weights in tables().into_iter().chain([vec![0.1; 10]]) {
        let d = Discrete::new(&weights).expect("valid");
        let sum: f64 = weights.iter().map(|&w| f64::from(w)).sum();
        let mut counts = vec![0.0; weights.len()];
        let mut rest = [0.0; 16];
        for _ in 0..n {
            let s = d.sample(rng.f32());
            assert_eq!(s.pmf, d.pmf(s.index));
            assert!((f64::from(s.pmf) - f64::from(weights[s.index]) / sum).abs() < 1e-6);
            counts[s.index] += 1.0;
            rest[(s.u * 16.0) as usize] += 1.0;
        }
        if weights.iter().filter(|w| f64::from(**w) > sum * 1e-4).count() > 1 {
            let expected: Vec<f64> =
                weights.iter().map(|&w| f64::from(w) / sum * f64::from(n)).collect();
            let p = chi_square(&counts, &expected);
            assert!(p > sidak(tests), "{weights:?}: p {p}");
        }
        let p = chi_square(&rest, &[f64::from(n) / 16.0; 16]);
        assert!(p > sidak(tests), "rest of {weights:?}: p {p}");
    }
    assert_eq!(Discrete::new(&[1.0, 2.0]).expect("valid").pmf(2), 0.0);
}

#[test]
fn alias_tables_of_any_size_hold_their_weights_exactly() {
    // The probability of each entry, summed over the bins by sampling a fine regular grid.
    for n in [3usize, 10, 63] {
        let mut rng = Rng::new(n as u64);
        let weights: Vec<f32> = (0..n).map(|_| rng.f32().powi(3)).collect();
        let d = Discrete::new(&weights).expect("valid");
        let grid = 1 << 20;
        let mut counts = vec![0.0; n];
        (0..grid).for_each(|i| counts[d.sample((i as f32 + 0.5) / grid as f32).index] += 1.0);
        for (i, c) in counts.iter().enumerate() {
            let share = c / f64::from(grid);
            assert!((share - f64::from(d.pmf(i))).abs() < 1e-4, "{n} {i}: {share} {}", d.pmf(i));
        }
    }
}

/// Chi-square of a 1D sampler against the differences of its own cumulative function, and of
/// that function against the midpoint integral of the density.
fn check_1d(
    what: &str,
    tests: usize,
    mut sample: impl FnMut(f32) -> (f32, f32),
    pdf: impl Fn(f32) -> f32,
    invert: impl Fn(f32) -> f32,
) {
    const CELLS: usize = 50;
    const FINE: usize = 1000;
    let mut rng = Rng::new(77);
    let n = 100_000;
    let mut counts = vec![0.0; CELLS];
    for _ in 0..n {
        let u = rng.f32();
        let (x, p) = sample(u);
        assert!((0.0..1.0).contains(&x), "{what}: {x}");
        assert!(p > 0.0 && p == pdf(x), "{what}: sample({u}) = {x} with {p}, pdf {}", pdf(x));
        assert!((invert(x) - u).abs() < 3e-6 * p.max(1.0), "{what}: {u} {x} {}", invert(x));
        counts[(x * CELLS as f32) as usize] += 1.0;
    }
    let expected: Vec<f64> = (0..CELLS)
        .map(|c| {
            let sum: f64 = (0..FINE)
                .map(|i| f64::from(pdf((c as f32 + (i as f32 + 0.5) / FINE as f32) / CELLS as f32)))
                .sum();
            sum / (FINE * CELLS) as f64 * f64::from(n)
        })
        .collect();
    let total: f64 = expected.iter().sum::<f64>() / f64::from(n);
    assert!((total - 1.0).abs() < 2e-3, "{what}: the density integrates to {total}");
    let p = chi_square(&counts, &expected);
    assert!(p > sidak(tests), "{what}: p {p}");
    assert_eq!(pdf(-0.1), 0.0);
    assert_eq!(pdf(1.1), 0.0);
}

#[test]
fn one_dimensional_densities() {
    let tables = tables();
    for weights in &tables {
        let what = format!("constant {weights:?}");
        let d = PiecewiseConstant1D::new(weights).expect("valid");
        check_1d(&what, 20, |u| (d.sample(u).0, d.sample(u).1), |x| d.pdf(x), |x| d.invert(x));
        let (_, _, last) = d.sample(0.999_999_94);
        assert!(weights[last] > 0.0);
        assert!(weights[d.sample(0.0).2] > 0.0);
        let mean = weights.iter().map(|&w| f64::from(w)).sum::<f64>() / weights.len() as f64;
        assert!((f64::from(d.integral()) / mean - 1.0).abs() < 1e-6);
        if weights.len() > 1 {
            let what = format!("linear {weights:?}");
            let d = PiecewiseLinear1D::new(weights).expect("valid");
            check_1d(&what, 20, |u| d.sample(u), |x| d.pdf(x), |x| d.invert(x));
        }
    }
    for (a, b) in [(1.0, 1.0), (0.0, 2.0), (5.0, 0.0), (1e-30, 3e-30), (1e30, 1e29), (1.0, 1.1)] {
        check_1d(
            &format!("linear {a} {b}"),
            20,
            |u| {
                let x = sample_linear(u, a, b);
                (x, linear_pdf(x, a, b).max(f32::MIN_POSITIVE))
            },
            |x| {
                linear_pdf(x, a, b).max(if (0.0..=1.0).contains(&x) {
                    f32::MIN_POSITIVE
                } else {
                    0.0
                })
            },
            |x| linear_inverse(x, a, b),
        );
    }
    // The exponential, mapped to the unit interval by 1 - e^(-2x), which 2 halves.
    let a = 2.0;
    check_1d(
        "exponential",
        20,
        |u| {
            let x = sample_exponential(u, a);
            let y = 1.0 - (-0.5 * a * x).exp();
            (y, 2.0 * (1.0 - y))
        },
        |y| if (0.0..1.0).contains(&y) { 2.0 * (1.0 - y) } else { 0.0 },
        |y| exponential_inverse(-(1.0 - y).ln() / (0.5 * a), a),
    );
    assert!((exponential_pdf(0.5, 2.0) - 2.0 * (-1f32).exp()).abs() < 1e-6);
    assert_eq!(exponential_pdf(-1.0, 2.0), 0.0);
    // Small numbers keep their relative precision.
    assert!((sample_exponential(1e-6, 1.0) / 1e-6 - 1.0).abs() < 1e-5);
}

/// Like [`check_1d`] on the unit square.
fn check_2d(
    what: &str,
    tests: usize,
    mut sample: impl FnMut(Vec2) -> (Vec2, f32),
    pdf: impl Fn(Vec2) -> f32,
    invert: impl Fn(Vec2) -> Vec2,
) {
    const CELLS: usize = 12;
    const FINE: usize = 50;
    let mut rng = Rng::new(78);
    let n = 100_000;
    let mut counts = vec![0.0; CELLS * CELLS];
    for _ in 0..n {
        let u = Vec2::new(rng.f32(), rng.f32());
        let (p, density) = sample(u);
        assert!((0.0..1.0).contains(&p.x) && (0.0..1.0).contains(&p.y), "{what}: {p:?}");
        assert!(density > 0.0 && density == pdf(p), "{what}: {p:?} {density} {}", pdf(p));
        let d = invert(p) - u;
        assert!(d.length() < 1e-4, "{what}: {u:?} {p:?} {:?}", invert(p));
        counts[(p.y * CELLS as f32) as usize * CELLS + (p.x * CELLS as f32) as usize] += 1.0;
    }
    let side = (CELLS * FINE) as f32;
    let mut expected = vec![0.0; CELLS * CELLS];
    for j in 0..CELLS * FINE {
        for i in 0..CELLS * FINE {
            let p = Vec2::new((i as f32 + 0.5) / side, (j as f32 + 0.5) / side);
            expected[j / FINE * CELLS + i / FINE] +=
                f64::from(pdf(p)) / f64::from(side * side) * f64::from(n);
        }
    }
    let total: f64 = expected.iter().sum::<f64>() / f64::from(n);
    assert!((total - 1.0).abs() < 2e-3, "{what}: the density integrates to {total}");
    let p = chi_square(&counts, &expected);
    assert!(p > sidak(tests), "{what}: p {p}");
}

#[test]
fn two_dimensional_densities() {
    let mut rng = Rng::new(3);
    let mut random = |n: usize, power: i32| -> Vec<f32> {
        (0..n).map(|i| if i % 7 == 3 { 0.0 } else { rng.f32().powi(power) }).collect()
    };
    // A row and a column of zeros; one bright texel; one cell each way.
    let mut gaps = random(8 * 6, 1);
    (0..8).for_each(|i| gaps[2 * 8 + i] = 0.0);
    (0..6).for_each(|j| gaps[j * 8] = 0.0);
    let mut spike = vec![1e-3; 10 * 10];
    spike[57] = 50.0;
    let grids = [
        (random(12 * 6, 1), 12, 6),
        (random(20 * 30, 5), 20, 30),
        (gaps, 8, 6),
        (spike, 10, 10),
        (vec![1.0, 2.0, 0.0, 4.0], 2, 2),
    ];
    for (values, width, height) in &grids {
        let d = PiecewiseConstant2D::new(values, *width, *height).expect("valid");
        let what = format!("constant {width} x {height}");
        check_2d(&what, 20, |u| d.sample(u), |p| d.pdf(p), |p| d.invert(p));
        assert_eq!(d.pdf(Vec2::new(0.5, 1.5)), 0.0);
    }
    for corners in [[1.0, 2.0, 3.0, 4.0], [0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 0.0, 7.0], [1.0; 4]] {
        check_2d(
            &format!("corners {corners:?}"),
            20,
            |u| {
                let p = sample_bilinear(u, corners);
                (p, bilinear_pdf(p, corners))
            },
            |p| bilinear_pdf(p, corners),
            |p| bilinear_inverse(p, corners),
        );
    }
}

#[test]
fn large_tables_keep_sample_and_pdf_together() {
    // 4096 columns: positions have few bits left within a cell.
    let mut rng = Rng::new(5);
    let (w, h) = (4096, 64);
    let values: Vec<f32> =
        (0..w * h).map(|i| if i % 3 == 0 { 0.0 } else { rng.f32().powi(8) }).collect();
    let c = PiecewiseConstant2D::new(&values, w, h).expect("valid");
    let mut inverse_c = 0.0;
    let n = 20_000;
    for i in 0..n {
        let edge = if i % 10 == 0 { 0.999_999_94 } else { rng.f32() };
        let u = Vec2::new(edge, rng.f32());
        let (p, pdf) = c.sample(u);
        assert!(pdf > 0.0 && pdf == c.pdf(p));
        inverse_c += 1.0 / f64::from(pdf);
    }
    assert!(inverse_c.is_finite());
}

#[test]
fn rejection_has_the_density_the_rate_and_the_power() {
    // f(x) = sin²(3x) + 0.1 on [0, 1], max 1.1: density f/∫f, rate ∫f/1.1, power ∫f.
    let f = |x: f32| (3.0 * x).sin().powi(2) + 0.1;
    let integral = 0.6 - 6f64.sin() / 12.0;
    let mut rng = Rng::new(6);
    let mut stats = Rejection::default();
    let n = 100_000;
    let mut counts = [0.0; 40];
    for _ in 0..n {
        let x = rejection(&mut stats, 1000, || rng.f32(), |r| r(), |&x| f(x) / 1.1)
            .expect("a rate near 1/2 does not fail a thousand times");
        counts[(x * 40.0) as usize] += 1.0;
    }
    let expected: Vec<f64> = (0..40)
        .map(|c| {
            let sum: f64 =
                (0..100).map(|i| f64::from(f((c as f32 + (i as f32 + 0.5) / 100.0) / 40.0))).sum();
            sum / 4000.0 / integral * f64::from(n)
        })
        .collect();
    let p = chi_square(&counts, &expected);
    assert!(p > sidak(1), "p {p}");
    let rate = integral / 1.1;
    let sigma = (rate * (1.0 - rate) / stats.proposed as f64).sqrt();
    assert!((stats.acceptance() - rate).abs() < 3.0 * sigma, "{} {rate}", stats.acceptance());
    assert_eq!(stats.accepted, n as u64);
    assert_eq!(stats.out_of_bounds, 0);
    // A wrong bound is noticed, an impossible density does not hang.
    let mut wrong = Rejection::default();
    rejection(&mut wrong, 100, || 0.5, |r| r(), |_| 1.5);
    assert_eq!(wrong.out_of_bounds, 1);
    assert_eq!(rejection(&mut wrong, 100, || rng.f32(), |r| r(), |_| 0.0), None);
}

#[test]
fn reservoirs_keep_in_proportion_to_weight() {
    let weights = [1.0, 0.0, 4.0, 0.5, 2.5, f64::NAN];
    let mut rng = Rng::new(4);
    let n = 50_000;
    let (mut streamed, mut merged) = ([0.0; 6], [0.0; 6]);
    for _ in 0..n {
        let mut all = WeightedReservoir::new();
        let (mut a, mut b) = (WeightedReservoir::new(), WeightedReservoir::new());
        for (i, &w) in weights.iter().enumerate() {
            all.add(i, w, rng.f32());
            (if i < 3 { &mut a } else { &mut b }).add(i, w, rng.f32());
        }
        let (&i, p) = all.sample().expect("weights are positive");
        assert!((p - weights[i] / 8.0).abs() < 1e-12);
        streamed[i] += 1.0;
        a.merge(b, rng.f32());
        let (&i, p) = a.sample().expect("weights are positive");
        assert!((p - weights[i] / 8.0).abs() < 1e-12);
        merged[i] += 1.0;
    }
    let expected = [1.0, 0.0, 4.0, 0.5, 2.5, 0.0].map(|w| w / 8.0 * f64::from(n));
    for counts in [streamed, merged] {
        let p = chi_square(&counts, &expected);
        assert!(p > sidak(2), "p {p}");
    }
    assert!(WeightedReservoir::<u32>::new().sample().is_none());
}
