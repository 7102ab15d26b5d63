//! Statistics that the tests share. Levels are family-wise 1 % (Šidák) and seeds fixed, so a
//! correct implementation passes always; one that is changed in kind fails.

use kaustika_math::special::{gamma_q, p_two_sided};
use kaustika_sampling::{SamplerConfig, SamplerKind, SamplerPlan};

/// The level of one of `tests` tests for a family-wise level of 1 %.
pub fn sidak(tests: usize) -> f64 {
    1.0 - 0.99f64.powf(1.0 / tests as f64)
}

/// The p-value of a chi-square test of `observed` against `expected` counts, cells with an
/// expectation below 5 pooled. An observation where nothing is expected gives 0.
pub fn chi_square(observed: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(observed.len(), expected.len());
    let (mut chi2, mut cells) = (0.0, 0usize);
    let (mut pooled_o, mut pooled_e) = (0.0, 0.0);
    for (&o, &e) in observed.iter().zip(expected) {
        if e == 0.0 && o > 0.0 {
            return 0.0;
        }
        if e < 5.0 {
            pooled_o += o;
            pooled_e += e;
        } else {
            chi2 += (o - e) * (o - e) / e;
            cells += 1;
        }
    }
    if pooled_e > 0.0 {
        chi2 += (pooled_o - pooled_e) * (pooled_o - pooled_e) / pooled_e;
        cells += 1;
    }
    assert!(cells > 1, "nothing to test");
    gamma_q((cells - 1) as f64 / 2.0, chi2 / 2.0)
}

/// The two-sided p-value of the mean of `values` against `truth`, by the normal approximation.
pub fn p_mean(values: &[f64], truth: f64) -> f64 {
    let (mean, variance) = mean_variance(values);
    p_two_sided((mean - truth) / (variance / values.len() as f64).sqrt().max(1e-300))
}

/// Mean and unbiased variance.
pub fn mean_variance(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0))
}

/// Least-squares slope of y over x.
pub fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (mx, my) = points.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (sxy, sxx) = points
        .iter()
        .fold((0.0, 0.0), |(a, b), (x, y)| (a + (x - mx) * (y - my), b + (x - mx) * (x - mx)));
    sxy / sxx
}

/// A plan for a 64 × 64 image.
pub fn plan(kind: SamplerKind, seed: u64, spp: u64) -> SamplerPlan {
    SamplerPlan::new(SamplerConfig { kind, seed, spp, resolution: [64, 64] })
}

/// A generator that shares nothing with the crate (PCG-XSH-RR 64/32, O'Neill 2014).
pub struct Rng(u64);

impl Rng {
    pub fn new(seed: u64) -> Self {
        let mut rng = Rng(seed.wrapping_mul(0x2545_f491_4f6c_dd1d).wrapping_add(0x1234_5678_9abc));
        (0..4).for_each(|_| {
            rng.next_u32();
        });
        rng
    }

    fn next_u32(&mut self) -> u32 {
        let old = self.0;
        self.0 =
            old.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((((old >> 18) ^ old) >> 27) as u32).rotate_right((old >> 59) as u32)
    }

    pub fn f32(&mut self) -> f32 {
        (self.next_u32() >> 8) as f32 / 16_777_216.0
    }

    pub fn f64(&mut self) -> f64 {
        f64::from(self.next_u32()) / 4_294_967_296.0
    }
}
