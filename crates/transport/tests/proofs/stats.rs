//! Statistical decisions at one family-wise level.

use kaustika_math::special::{gamma_q, p_two_sided};
use kaustika_sampling::estimator::RunningMean;

/// No more comparisons than this are made by the whole binary; together they reject a correct
/// program with probability at most 1 %.
const COMPARISONS: f64 = 4096.0;

/// Level of one comparison (Šidák 1967).
pub fn level() -> f64 {
    -(0.99f64.ln() / COMPARISONS).exp_m1()
}

/// Rounding that no test counts as an error: relative, in single precision over some bounces.
const ROUNDING: f64 = 2e-5;

/// Fails unless the estimate agrees with the truth.
#[track_caller]
pub fn agrees(what: &str, estimate: &RunningMean, truth: f64) {
    let (mean, error) = (estimate.mean(), estimate.standard_error());
    let difference = ((mean - truth).abs() - ROUNDING * truth.abs()).max(0.0);
    let p = if difference == 0.0 { 1.0 } else { p_two_sided(difference / error.max(1e-300)) };
    assert!(p > level(), "{what}: {mean:.6} ± {error:.6}, expected {truth:.6}");
}

/// Fails unless two independent estimates agree.
#[track_caller]
pub fn same(what: &str, a: &RunningMean, b: &RunningMean) {
    let error = a.standard_error().hypot(b.standard_error());
    let size = a.mean().abs().max(b.mean().abs());
    let difference = ((a.mean() - b.mean()).abs() - ROUNDING * size).max(0.0);
    let p = if difference == 0.0 { 1.0 } else { p_two_sided(difference / error.max(1e-300)) };
    assert!(
        p > level(),
        "{what}: {:.6} ± {:.6} against {:.6} ± {:.6}",
        a.mean(),
        a.standard_error(),
        b.mean(),
        b.standard_error()
    );
}

/// Fails unless the values are equal up to `tolerance`, relative.
#[track_caller]
pub fn close(what: &str, value: f64, truth: f64, tolerance: f64) {
    let error = (value - truth).abs();
    assert!(error <= tolerance * truth.abs(), "{what}: {value:.7}, expected {truth:.7}");
}

/// Fails unless counts follow the expected ones; cells that expect fewer than 5 are pooled.
#[track_caller]
pub fn follows(what: &str, observed: &[f64], expected: &[f64]) {
    let (mut chi2, mut cells, mut rest) = (0.0, 0, (0.0, 0.0));
    for (&o, &e) in observed.iter().zip(expected) {
        assert!(e > 0.0 || o == 0.0, "{what}: {o} where nothing is expected");
        if e < 5.0 {
            rest = (rest.0 + o, rest.1 + e);
        } else {
            chi2 += (o - e) * (o - e) / e;
            cells += 1;
        }
    }
    if rest.1 > 0.0 {
        chi2 += (rest.0 - rest.1) * (rest.0 - rest.1) / rest.1;
        cells += 1;
    }
    if cells > 1 {
        let p = gamma_q(0.5 * (cells - 1) as f64, 0.5 * chi2);
        assert!(p > level(), "{what}: chi² = {chi2:.1} over {cells} cells");
    }
}

/// A small generator for test points (SplitMix64), in [0, 1).
pub struct Random(u64);

impl Random {
    /// From a seed.
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    /// The next number.
    pub fn f(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (kaustika_math::mix_bits(self.0) >> 40) as f32 / (1u64 << 24) as f32
    }

    /// The next two.
    pub fn v2(&mut self) -> kaustika_math::Vec2 {
        kaustika_math::Vec2::new(self.f(), self.f())
    }

    /// A point of the cube [-1, 1]³.
    pub fn v3(&mut self) -> kaustika_math::Vec3 {
        let mut c = || 2.0 * self.f() - 1.0;
        kaustika_math::Vec3::new(c(), c(), c())
    }
}
