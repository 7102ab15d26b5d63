//! What every sampler promises: range, determinism, uniformity, independence of dimensions,
//! unbiasedness, no end.

use crate::support::*;
use kaustika_math::{ONE_MINUS_EPSILON, Vec2};
use kaustika_sampling::sampler::VERTEX_NUMBERS;
use kaustika_sampling::{PrimarySample, Sampler, SamplerKind};

/// Pixels, indices and dimensions at which a long render may arrive.
const INDICES: [u64; 7] = [0, 1, 1000, (1 << 32) - 8, (1 << 32) + 5, 1 << 40, u64::MAX - (1 << 20)];
const DIMENSIONS: [u32; 5] = [0, 7, 127, 5000, 1_000_000];

#[test]
fn names_parse_and_print() {
    for kind in SamplerKind::ALL {
        assert_eq!(kind.to_string().parse::<SamplerKind>(), Ok(kind));
    }
    assert_eq!("pmj02bn".parse(), Ok(SamplerKind::Pmj02));
    assert_eq!(
        "sobel".parse::<SamplerKind>().unwrap_err().to_string(),
        "unknown sampler \"sobel\"; known are independent, stratified, halton, sobol, zsobol, pmj02"
    );
}

#[test]
fn values_are_in_range_and_repeat() {
    for kind in SamplerKind::ALL {
        for spp in [0, 1, 5, 64, 1 << 20, u64::MAX] {
            let plan = plan(kind, 3, spp);
            for index in INDICES {
                for d in DIMENSIONS {
                    for pixel in [[0, 0], [63, 17], [u32::MAX, 1 << 20]] {
                        let draw = || {
                            let mut s = plan.start(pixel, index);
                            s.seek(d);
                            let a = s.get_1d();
                            let b = s.get_2d();
                            let c = s.get_2d();
                            assert_eq!(s.dimension(), d + 5);
                            let v = s.get_vertex();
                            assert_eq!(s.dimension(), d + 5 + VERTEX_NUMBERS as u32);
                            let f = s.fork(1).get_1d();
                            let mut u = vec![a, b.x, b.y, c.x, c.y, f];
                            u.extend(v);
                            u
                        };
                        let u = draw();
                        assert_eq!(u, draw());
                        assert!(
                            u.iter().all(|v| (0.0..=ONE_MINUS_EPSILON).contains(v)),
                            "{kind} {spp} {index} {d} {pixel:?} {u:?}"
                        );
                    }
                }
            }
        }
    }
}

/// Sixteen vertices drawn at once have the numbers they have one by one.
#[test]
fn vertices_together_are_vertices_alone() {
    for kind in SamplerKind::ALL {
        let plan = plan(kind, 3, 64);
        for index in INDICES {
            for (wanted, count) in [(0xffff, 16), (0b1001_0110_0100, 12), (1, 1)] {
                let paths = |i: usize| {
                    let mut s = plan.start([i as u32 * 7, 5], index.wrapping_add(i as u64 / 3));
                    s.seek(DIMENSIONS[i % DIMENSIONS.len()]);
                    s
                };
                let mut together: Vec<Sampler> = (0..count).map(paths).collect();
                let mut alone: Vec<Sampler> = (0..count).map(paths).collect();
                for _ in 0..3 {
                    let mut rows = [[-1.0; 16]; VERTEX_NUMBERS];
                    Sampler::get_vertices(&mut together, wanted, &mut rows);
                    for i in (0..count).filter(|i| wanted >> i & 1 != 0) {
                        assert_eq!(rows.map(|row| row[i]), alone[i].get_vertex(), "{kind} {i}");
                    }
                }
                for (a, b) in together.iter_mut().zip(&mut alone) {
                    assert_eq!(a.get_2d(), b.get_2d(), "{kind}");
                }
            }
        }
    }
}

#[test]
fn seed_pixel_index_and_branch_all_matter() {
    for kind in SamplerKind::ALL {
        let first = |seed, pixel, index| plan(kind, seed, 16).start(pixel, index).get_2d();
        let u = first(0, [3, 4], 5);
        assert_ne!(u, first(1, [3, 4], 5), "{kind}");
        assert_ne!(u, first(0, [4, 3], 5), "{kind}");
        assert_ne!(u, first(0, [3, 4], 6), "{kind}");
        assert_ne!(u, first(0, [3, 4], 5 + (1 << 32)), "{kind}");
        let plan = plan(kind, 0, 16);
        let mut s = plan.start([3, 4], 5);
        s.get_2d();
        let (a, b) = (s.fork(0).get_2d(), s.fork(1).get_2d());
        let c = s.get_2d();
        assert!(a != b && a != c && b != c, "{kind}");
    }
}

/// Counts of a 2D draw in an 8 × 8 grid. One sample a pixel over many pixels is independent
/// for all kinds but `ZSobol`, which is independent over seeds only.
fn grid_p(
    kind: SamplerKind,
    spp: u64,
    index: u64,
    dimension: u32,
    draw: fn(&mut Sampler) -> Vec2,
) -> f64 {
    let mut counts = [0f64; 64];
    let n = 3200;
    let shared = plan(kind, 11, spp);
    for i in 0..n {
        let u = if kind == SamplerKind::ZSobol {
            let own = plan(kind, u64::from(i), spp);
            let mut s = own.start([9, 5], index);
            s.seek(dimension);
            draw(&mut s)
        } else {
            let mut s = shared.start([i % 60, i / 60], index);
            s.seek(dimension);
            draw(&mut s)
        };
        counts[(u.y * 8.0) as usize * 8 + (u.x * 8.0) as usize] += 1.0;
    }
    chi_square(&counts, &[f64::from(n) / 64.0; 64])
}

/// Two of a vertex's numbers.
fn pair(s: &mut Sampler, i: usize, j: usize) -> Vec2 {
    let u = s.get_vertex();
    Vec2::new(u[i], u[j])
}

#[test]
fn each_draw_is_uniform_whatever_its_index_and_dimension() {
    let kinds = SamplerKind::ALL;
    // Two numbers drawn together, one after the other, and two draws after one another.
    let draws: [fn(&mut Sampler) -> Vec2; 8] = [
        |s| s.get_2d(),
        |s| Vec2::new(s.get_1d(), s.get_1d()),
        |s| Vec2::new(s.get_2d().x, s.get_2d().y),
        |s| Vec2::new(s.fork(3).get_1d(), s.fork(4).get_1d()),
        // Numbers of a vertex: of one group, of two, and of two vertices.
        |s| pair(s, 0, 1),
        |s| pair(s, 2, 4),
        |s| pair(s, 5, 6),
        |s| Vec2::new(s.get_vertex()[0], s.get_vertex()[0]),
    ];
    let tests = kinds.len() * INDICES.len() * DIMENSIONS.len() * draws.len();
    for kind in kinds {
        // pmj02 builds tables for each plan; the others are made over seeds cheaply.
        for index in INDICES {
            for d in DIMENSIONS {
                for (i, draw) in draws.iter().enumerate() {
                    let p = grid_p(kind, 16, index, d, *draw);
                    assert!(p > sidak(tests), "{kind} index {index} dimension {d} draw {i}: p {p}");
                }
            }
        }
    }
}

#[test]
fn projections_on_dimension_pairs_fill_the_square() {
    // 4096 samples of one pixel: in every pair of dimensions each of the 16 cells must hold its
    // share. It finds pairs whose leading digits are functions of each other. Two independent
    // nested shuffles are less random than two permutations: their first digits agree for both
    // or for neither of two neighbours, so that counts have twice the variance of independent
    // points (an exact Owen scrambling with a strong hash per node shows the same). Hence half
    // counts.
    let pairs = [(0, 1), (0, 2), (0, 4), (1, 3), (2, 5), (3, 11), (0, 40), (6, 44), (20, 45)];
    let tests = SamplerKind::ALL.len() * pairs.len() * 6;
    for kind in SamplerKind::ALL {
        for (mode, first) in
            [(0, 0u64), (1, 0), (2, 0), (0, (1 << 32) - 2048), (1, 1 << 33), (2, 1 << 33)]
        {
            let plan = plan(kind, 5, 4096);
            let mut counts = vec![[0f64; 16]; pairs.len()];
            for i in 0..4096 {
                let mut s = plan.start([1, 2], first + i);
                let u: Vec<f32> = match mode {
                    0 => (0..46).map(|_| s.get_1d()).collect(),
                    1 => (0..23).map(|_| s.get_2d()).flat_map(|v| [v.x, v.y]).collect(),
                    _ => (0..6).flat_map(|_| s.get_vertex()).collect(),
                };
                for (pair, counts) in pairs.iter().zip(&mut counts) {
                    counts[(u[pair.0] * 4.0) as usize * 4 + (u[pair.1] * 4.0) as usize] += 0.5;
                }
            }
            for (pair, counts) in pairs.iter().zip(&counts) {
                let p = chi_square(counts, &[128.0; 16]);
                assert!(p > sidak(tests), "{kind} mode {mode} from {first} pair {pair:?}: p {p}");
            }
        }
    }
}

#[test]
fn means_are_unbiased_for_any_number_of_samples() {
    // f has a discontinuity and an interaction of four dimensions; ∫f = 1/4 + 1/16.
    let f = |s: &mut Sampler| {
        let (a, b) = (s.get_2d(), s.get_2d());
        let inside = if a.x + a.y * a.y < b.x { 1.0 } else { 0.0 };
        f64::from(inside + a.x * a.y * b.x * b.y)
    };
    // P(x + y² < z) = ∫∫ max(0, 1 - x - y²) dx dy = ∫ (1-y²)²/2 dy = 4/15.
    let truth = 4.0 / 15.0 + 1.0 / 16.0;
    let counts = [1u64, 3, 7, 16, 50];
    for kind in SamplerKind::ALL {
        for n in counts {
            let estimates: Vec<f64> = (0..400u64)
                .map(|seed| {
                    let plan = plan(kind, seed, 16);
                    (0..n).map(|i| f(&mut plan.start([2, 3], i))).sum::<f64>() / n as f64
                })
                .collect();
            let p = p_mean(&estimates, truth);
            assert!(p > sidak(counts.len() * 6), "{kind} n {n}: p {p}");
        }
    }
}

#[test]
fn forks_estimate_the_same_integral() {
    // Splitting after two draws: the mean over three branches of g(prefix, branch).
    let truth = 0.125;
    for kind in SamplerKind::ALL {
        let estimates: Vec<f64> = (0..300u64)
            .map(|seed| {
                let plan = plan(kind, seed, 64);
                let sum: f32 = (0..64)
                    .map(|i| {
                        let mut s = plan.start([2, 3], i);
                        let u = s.get_2d();
                        let branches: f32 = (0..3)
                            .map(|b| {
                                let mut fork = s.fork(b);
                                if fork.get_2d().x < u.x { u.y * fork.get_1d() } else { 0.0 }
                            })
                            .sum();
                        branches / 3.0
                    })
                    .sum();
                f64::from(sum) / 64.0
            })
            .collect();
        let p = p_mean(&estimates, truth);
        assert!(p > sidak(6), "{kind}: p {p}");
        let (_, variance) = mean_variance(&estimates);
        // One pixel converges to the truth, too: a fork that repeats its prefix would not.
        assert!(variance.sqrt() < 0.03, "{kind}: σ {}", variance.sqrt());
    }
}

#[test]
fn a_chain_replaces_the_point_set() {
    struct Counter(u32);
    impl PrimarySample for Counter {
        fn get_1d(&mut self) -> f32 {
            self.0 += 1;
            self.0 as f32 / 16.0
        }
    }
    let mut chain = Counter(0);
    let mut s = Sampler::from_primary(&mut chain);
    assert_eq!(s.get_1d(), 1.0 / 16.0);
    assert_eq!(s.get_2d(), Vec2::new(2.0 / 16.0, 3.0 / 16.0));
    assert_eq!(s.fork(7).get_1d(), 4.0 / 16.0);
    assert_eq!(s.get_1d(), 5.0 / 16.0);
}
