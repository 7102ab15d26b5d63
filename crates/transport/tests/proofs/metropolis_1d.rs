//! Metropolis sampling of f(x) = (x - ½)² on [0, 1], where all is known: ∫f = 1/12, ∫f x = 1/24,
//! ∫f x² = 1/30.
//!
//! Steps of one chain depend on each other; chains do not. Every figure is a mean over chains that
//! start from f itself, x = ½ ± ½ u^⅓, so that each is right from its first step.

use crate::stats::{agrees, level, same};
use kaustika_math::special::p_two_sided;
use kaustika_sampling::estimator::RunningMean;
use kaustika_transport::metropolis::{Chain, Draws, Recording, StepSize, acceptance};

fn f(x: f64) -> f64 {
    if (0.0..=1.0).contains(&x) { (x - 0.5).powi(2) } else { 0.0 }
}

/// ∫f.
const INTEGRAL: f64 = 1.0 / 12.0;

const BINS: usize = 20;

/// The share of f in a bin: 12 ∫ (x - ½)² dx.
fn share(bin: usize) -> f64 {
    let cube = |i: usize| 4.0 * (i as f64 / BINS as f64 - 0.5).powi(3);
    cube(bin + 1) - cube(bin)
}

/// A proposal, with T(x→y) and T(y→x).
type Mutate = fn(f64, &mut Draws) -> (f64, f64, f64);

fn mutate_1(_: f64, r: &mut Draws) -> (f64, f64, f64) {
    (r.f64(), 1.0, 1.0)
}

fn mutate_2(x: f64, r: &mut Draws) -> (f64, f64, f64) {
    (x + 0.1 * (r.f64() - 0.5), 10.0, 10.0)
}

/// 10 % of the one and 90 % of the other; both are symmetric.
fn mixture(x: f64, r: &mut Draws) -> (f64, f64, f64) {
    if r.f64() < 0.1 { mutate_1(x, r) } else { mutate_2(x, r) }
}

/// Prefers large y: T(x→y) = 2y.
fn skewed(x: f64, r: &mut Draws) -> (f64, f64, f64) {
    let y = (1.0 - r.f64()).sqrt();
    (y, 2.0 * y, 2.0 * x)
}

/// As [`skewed`], by one who forgets T.
fn careless(x: f64, r: &mut Draws) -> (f64, f64, f64) {
    (skewed(x, r).0, 1.0, 1.0)
}

/// A start in proportion to f.
fn start(r: &mut Draws) -> f64 {
    let (side, u) = (r.f64(), r.f64());
    0.5 + 0.5 * u.cbrt().copysign(side - 0.5)
}

/// What chains have seen, means over chains.
#[derive(Clone)]
struct Seen {
    acceptance: RunningMean,
    /// Steps that led from one branch of f to the other.
    changes: RunningMean,
    histogram: Vec<RunningMean>,
    /// Σ weights.
    total: f64,
    /// Of x and x².
    moments: [RunningMean; 2],
}

/// Runs `chains` of `steps` each.
fn run(
    mutate: Mutate,
    recording: Recording,
    start: impl Fn(&mut Draws) -> f64,
    length: (u64, usize),
    seed: u64,
) -> Seen {
    run_in(BINS, mutate, recording, start, length, seed)
}

/// The same, with a histogram of so many bins.
fn run_in(
    cells: usize,
    mutate: Mutate,
    recording: Recording,
    start: impl Fn(&mut Draws) -> f64,
    (chains, steps): (u64, usize),
    seed: u64,
) -> Seen {
    let none = RunningMean::new();
    let mut seen = Seen {
        acceptance: none,
        changes: none,
        histogram: vec![none; cells],
        total: 0.0,
        moments: [none; 2],
    };
    for number in 0..chains {
        let mut r = Draws::new(seed, number);
        let mut chain = Chain::new(start(&mut r), recording);
        let (mut accepted, mut changes) = (0.0, 0.0);
        let (mut bins, mut moments) = (vec![0.0; cells], [0.0; 2]);
        let mut record = |x: &f64, w: f64| {
            bins[((x * cells as f64) as usize).min(cells - 1)] += w;
            moments[0] += w * x;
            moments[1] += w * x * x;
        };
        for _ in 0..steps {
            let x = *chain.state();
            let (mut y, t, t_back) = mutate(x, &mut r);
            let a = acceptance(f(x) * t, f(y) * t_back).unwrap_or(0.0);
            accepted += a;
            if chain.step(&mut y, a, r.f64(), &mut record) {
                changes += f64::from(u8::from((x < 0.5) != (*chain.state() < 0.5)));
            }
        }
        chain.record(&mut record);
        let n = steps as f64;
        seen.total += bins.iter().sum::<f64>();
        seen.acceptance.push(accepted / n);
        seen.changes.push(changes / n);
        seen.histogram.iter_mut().zip(bins).for_each(|(m, b)| m.push(b / n));
        seen.moments.iter_mut().zip(moments).for_each(|(m, v)| m.push(v / n));
    }
    seen
}

/// The smallest p-value of the bins.
fn smallest_p(seen: &Seen) -> f64 {
    let p = seen.histogram.iter().enumerate().map(|(i, bin)| {
        p_two_sided((bin.mean() - share(i)).abs() / bin.standard_error().max(1e-300))
    });
    p.fold(1.0, f64::min)
}

/// Fails unless every bin has its share.
#[track_caller]
fn right(what: &str, seen: &Seen) {
    for (i, bin) in seen.histogram.iter().enumerate() {
        agrees(&format!("{what}, bin {i}"), bin, share(i));
    }
}

/// The mean acceptance of `mutate_2`, by quadrature.
fn acceptance_of_small_steps() -> f64 {
    let (n, m) = (4000, 400);
    let mut sum = 0.0;
    for i in 0..n {
        let x = (i as f64 + 0.5) / f64::from(n);
        for j in 0..m {
            let y = x + 0.1 * ((j as f64 + 0.5) / f64::from(m) - 0.5);
            sum += f(x).min(f(y));
        }
    }
    sum / (f64::from(n) * f64::from(m) * INTEGRAL)
}

#[test]
fn acceptance_and_changes_of_branch_are_the_known_ones() {
    let small = acceptance_of_small_steps();
    assert!((small - 0.860).abs() < 5e-4, "{small}");
    assert!((0.1 * 0.5 + 0.9 * small - 0.824).abs() < 5e-4);
    // Exactly 5 · 0.05⁴ for small steps; a fourth of the proposals anywhere lead across.
    let across = 5.0 * 0.05f64.powi(4);
    let cases: [(&str, Mutate, f64, f64); 3] = [
        ("anywhere", mutate_1, 0.5, 0.25),
        ("small", mutate_2, small, across),
        ("mixture", mixture, 0.1 * 0.5 + 0.9 * small, 0.1 * 0.25 + 0.9 * across),
    ];
    for (i, (what, mutate, accepted, changes)) in cases.into_iter().enumerate() {
        let seen = run(mutate, Recording::Visited, start, (4000, 500), 10 + i as u64);
        agrees(&format!("{what}: acceptance"), &seen.acceptance, accepted);
        agrees(&format!("{what}: changes"), &seen.changes, changes);
    }
}

#[test]
fn chains_come_to_be_distributed_as_f() {
    let cases: [(&str, Mutate); 4] =
        [("anywhere", mutate_1), ("small", mutate_2), ("mixture", mixture), ("skewed", skewed)];
    for (i, (what, mutate)) in cases.into_iter().enumerate() {
        for (j, recording) in [Recording::Visited, Recording::Expected].into_iter().enumerate() {
            let seed = 20 + (2 * i + j) as u64;
            let seen = run(mutate, recording, start, (3000, 200), seed);
            right(&format!("{what}, {recording:?}"), &seen);
            agrees(what, &seen.moments[0], 0.5);
            agrees(what, &seen.moments[1], 0.4);
            // Each step weighs one, however it is recorded.
            assert!((seen.total - 600_000.0).abs() < 1e-6, "{}", seen.total);
        }
    }
}

#[test]
fn a_proposal_whose_density_is_forgotten_is_found_out() {
    let seen = run(careless, Recording::Expected, start, (3000, 200), 30);
    assert!(smallest_p(&seen) < level());
}

#[test]
fn expected_values_see_low_regions_better() {
    let visited = run(mutate_1, Recording::Visited, start, (4000, 100), 40);
    let expected = run(mutate_1, Recording::Expected, start, (4000, 100), 41);
    // The two bins in the middle, where f is less than a hundredth of its largest value.
    for bin in [BINS / 2 - 1, BINS / 2] {
        let (v, e) = (&visited.histogram[bin], &expected.histogram[bin]);
        same("the mean", v, e);
        assert!(e.variance() < 0.5 * v.variance(), "{} {}", e.variance(), v.variance());
    }
}

#[test]
fn the_mixture_converges_fastest_by_samples() {
    // By the variance of histograms, all bins together. In fine ones what counts is that states do
    // not repeat; in coarse ones that both branches get their share, where proposals anywhere
    // are better still.
    let variance = |cells: usize, mutate: Mutate, seed| {
        let seen = run_in(cells, mutate, Recording::Visited, start, (400, 4000), seed);
        seen.histogram.iter().map(RunningMean::variance).sum::<f64>()
    };
    let all = |cells: usize, seed| {
        [mutate_1, mutate_2, mixture].map(|mutate| variance(cells, mutate, seed))
    };
    let [any, small, mixed] = all(2000, 50);
    assert!(mixed < any && any < small, "fine: {any} {small} {mixed}");
    let [any, small, mixed] = all(BINS, 51);
    assert!(any < mixed && mixed < 0.1 * small, "coarse: {any} {small} {mixed}");
}

#[test]
fn restarts_need_starts_in_proportion_to_f() {
    let short = (20_000, 4);
    let fair = run(mutate_2, Recording::Expected, start, short, 60);
    right("restarted in proportion to f", &fair);
    // Half of the chains of ten steps that begin anywhere are still where f is small.
    let anywhere = |r: &mut Draws| r.f64();
    let unfair = run(mutate_2, Recording::Expected, anywhere, short, 61);
    assert!(smallest_p(&unfair) < level());
}

#[test]
fn quadrature_finds_the_known_integrals() {
    // ∫ f g = (1/N) Σ f g / p of independent samples, and ∫f · mean g over a chain.
    let mut r = Draws::new(70, 0);
    let mut plain = [RunningMean::new(); 2];
    for _ in 0..200_000 {
        let x = r.f64();
        plain[0].push(f(x) * x);
        plain[1].push(f(x) * x * x);
    }
    let seen = run(mixture, Recording::Expected, start, (3000, 200), 71);
    for (i, truth) in [1.0 / 24.0, 1.0 / 30.0].into_iter().enumerate() {
        agrees("samples", &plain[i], truth);
        let m = &seen.moments[i];
        let scaled = [1.0, -1.0].map(|s| INTEGRAL * (m.mean() + s * m.standard_error()));
        agrees("chain", &scaled.into_iter().collect(), truth);
    }
}

#[test]
fn a_filter_is_a_function_to_sample_too() {
    // A picture under a tent of integral 1, (1 - |x|) on [-1, 1]: of g(x) = x² it is 1/6.
    let tent = |x: f64| (1.0 - x.abs()).max(0.0);
    let mut filtered = RunningMean::new();
    for number in 0..4000 {
        let mut r = Draws::new(72, number);
        let mut chain = Chain::new(r.f64() - r.f64(), Recording::Expected);
        let mut sum = 0.0;
        let mut record = |x: &f64, w: f64| sum += w * x * x;
        for _ in 0..100 {
            let mut y = chain.state() + r.f64() - 0.5;
            let a = acceptance(tent(*chain.state()), tent(y)).unwrap_or(0.0);
            chain.step(&mut y, a, r.f64(), &mut record);
        }
        chain.record(&mut record);
        filtered.push(sum / 100.0);
    }
    agrees("tent", &filtered, 1.0 / 6.0);
}

#[test]
fn a_step_size_learns_and_then_stays() {
    // Random walks of any width: it learns an acceptance of 0.6, and then the chain is right.
    let target = 0.6;
    let mut size = StepSize::new(0.01, (1e-4, 2.0), target);
    let mut r = Draws::new(80, 0);
    let step = |x: f64, width: f64, r: &mut Draws| x + width * (r.f64() - 0.5);
    let measure = |width: f64, (chains, steps): (u64, usize), seed: u64| {
        let mut means = (RunningMean::new(), vec![RunningMean::new(); BINS]);
        for number in 0..chains {
            let mut r = Draws::new(seed, number);
            let mut chain = Chain::new(start(&mut r), Recording::Expected);
            let (mut accepted, mut bins) = (0.0, [0.0; BINS]);
            let mut record =
                |x: &f64, w: f64| bins[((x * BINS as f64) as usize).min(BINS - 1)] += w;
            for _ in 0..steps {
                let mut y = step(*chain.state(), width, &mut r);
                let a = acceptance(f(*chain.state()), f(y)).unwrap_or(0.0);
                accepted += a;
                chain.step(&mut y, a, r.f64(), &mut record);
            }
            chain.record(&mut record);
            means.0.push(accepted / steps as f64);
            means.1.iter_mut().zip(bins).for_each(|(m, b)| m.push(b / steps as f64));
        }
        means
    };
    let mut x = start(&mut r);
    for _ in 0..2000 {
        let y = step(x, size.size(), &mut r);
        let a = acceptance(f(x), f(y)).unwrap_or(0.0);
        size.learn(a);
        if r.f64() < a {
            x = y;
        }
    }
    let (reached, histogram) = measure(size.size(), (3000, 100), 81);
    assert!((reached.mean() - target).abs() < 0.05, "{}", reached.mean());
    for (i, bin) in histogram.iter().enumerate() {
        agrees(&format!("bin {i}"), bin, share(i));
    }
}

#[test]
fn what_is_no_number_is_never_accepted() {
    assert_eq!(acceptance(1.0, f64::NAN), None);
    assert_eq!(acceptance(f64::NAN, 1.0), None);
    assert_eq!(acceptance(1.0, f64::INFINITY), None);
    assert_eq!(acceptance(0.0, 0.0), None);
    assert_eq!(acceptance(0.0, 1.0), Some(1.0));
    assert_eq!(acceptance(4.0, 1.0), Some(0.25));
    assert_eq!(acceptance(1.0, 0.0), Some(0.0));
}
