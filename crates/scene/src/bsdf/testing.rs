//! What every scattering model must satisfy, in one call: [`check_model`].
//!
//! Random numbers are fixed. Statistical tests hold a family-wise significance of 1 % over all
//! the tests of a model (Šidák 1967): a correct model fails with that probability when its
//! sampling changes, and not at all while it stays.

mod faults;
mod mitsuba;
mod sphere;

use super::{BsdfSample, Lobes, Mode, Scatter};
use kaustika_math::{Vec2, Vec3, mix_bits, special};
use kaustika_spectra::Spectrum;
pub use sphere::Partition;

/// What to expect of a model beyond the contract of [`super`].
#[derive(Clone, Copy, Debug)]
pub struct Expect {
    /// Also look from below.
    pub both_sides: bool,
    /// f(wo, wi) = f(wi, wo) for directions on the same side, within a mode.
    pub reciprocal: bool,
    /// `pdf` is the density of `sample`; false for approximate densities (layered models), for
    /// which the chi-square test makes no sense.
    pub exact_pdf: bool,
    /// The directional albedo in importance mode, where it is known (1 for lossless models),
    /// and how far the quadrature may be from it.
    pub albedo: Option<(f32, f32)>,
    /// How far `albedo()` may be from the truth.
    pub albedo_error: f32,
    /// The directional albedo may not exceed this.
    pub albedo_max: f32,
    /// Relative error allowed where a value is computed in two ways (rounding of sharp lobes).
    pub rounding: f32,
    /// Samples a test.
    pub samples: usize,
}

impl Default for Expect {
    fn default() -> Self {
        Expect {
            both_sides: false,
            reciprocal: true,
            exact_pdf: true,
            albedo: None,
            albedo_error: 2e-3,
            albedo_max: 1.001,
            rounding: 5e-3,
            samples: 40_000,
        }
    }
}

/// Uniform random numbers by number, the same in every run.
pub struct Random {
    state: u64,
}

impl Random {
    /// The stream of a seed.
    pub fn new(seed: u64) -> Random {
        Random { state: mix_bits(seed ^ 0x9e37_79b9_7f4a_7c15) }
    }

    /// Uniform in [0, 1).
    pub fn next_1d(&mut self) -> f32 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (mix_bits(self.state) >> 40) as f32 * (1.0 / (1u64 << 24) as f32)
    }

    /// Uniform in [0, 1)².
    pub fn next_2d(&mut self) -> Vec2 {
        let x = self.next_1d();
        Vec2::new(x, self.next_1d())
    }
}

/// Cosines of the directions looked from, at an arbitrary azimuth each.
const COSINES: [f32; 5] = [1.0, 0.85, 0.5, 0.2, 0.05];

fn outgoing(expect: &Expect) -> Vec<Vec3> {
    let mut directions = Vec::new();
    for (i, z) in COSINES.into_iter().enumerate() {
        let r = (1.0 - z * z).sqrt();
        let (s, c) = (0.7 + 2.1 * i as f32).sin_cos();
        directions.push(Vec3::new(r * c, r * s, z));
        if expect.both_sides {
            directions.push(Vec3::new(-r * s, r * c, -z));
        }
    }
    directions
}

/// One situation of the family.
#[derive(Clone, Copy, Debug)]
struct Case {
    wo: Vec3,
    mode: Mode,
    mask: Lobes,
}

/// Runs every test on a model; panics with the numbers of the first that fails.
pub fn check_model(name: &str, model: &impl Scatter, expect: Expect) {
    let lobes = model.lobes();
    let roughness = model.roughness();
    assert!((0.0..=1.0).contains(&roughness), "{name}: roughness {roughness}");
    let mut cases = Vec::new();
    for wo in outgoing(&expect) {
        for mode in [Mode::Radiance, Mode::Importance] {
            cases.push(Case { wo, mode, mask: Lobes::ALL });
        }
        if lobes.classes().count() > 1 {
            cases.extend(lobes.classes().map(|mask| Case { wo, mode: Mode::Radiance, mask }));
        }
    }
    // One chi-square test and four lanes of the furnace for each case, and the delta classes.
    let tests = cases.len() * (5 + (lobes & Lobes::DELTA).classes().count());
    let p_least = 1.0 - 0.99f64.powf(1.0 / tests as f64);
    for (i, &case) in cases.iter().enumerate() {
        let run = Run { name, model, expect, case, p_least, seed: 1000 + i as u64 };
        run.check_directions();
        run.check_statistics();
    }
    if !expect.both_sides {
        check_one_sided(name, model);
    }
}

/// Reflecting models are black from below.
fn check_one_sided(name: &str, model: &impl Scatter) {
    let mut random = Random::new(7);
    for wo in outgoing(&Expect::default()) {
        for mode in [Mode::Radiance, Mode::Importance] {
            let below = -wo;
            let wi = kaustika_math::warp::uniform_sphere(random.next_2d());
            for (a, b) in [(below, wi), (wo, below), (below, wo), (below, below)] {
                assert!(model.eval(a, b, mode, Lobes::ALL).is_black(), "{name}: {a:?} {b:?}");
                assert_eq!(model.pdf(a, b, mode, Lobes::ALL), (0.0, 0.0), "{name}: {a:?} {b:?}");
            }
            let s = model.sample(below, random.next_1d(), random.next_2d(), mode, Lobes::ALL);
            assert!(s.is_none(), "{name}: samples from below: {s:?}");
        }
    }
}

struct Run<'a, M: Scatter> {
    name: &'a str,
    model: &'a M,
    expect: Expect,
    case: Case,
    p_least: f64,
    seed: u64,
}

impl<M: Scatter> Run<'_, M> {
    fn sample(&self, random: &mut Random) -> Option<BsdfSample> {
        let Case { wo, mode, mask } = self.case;
        let (uc, u2) = (random.next_1d(), random.next_2d());
        let s = self.model.sample(wo, uc, u2, mode, mask)?;
        let context = || format!("{} {:?} uc {uc} u2 {u2:?}: {s:?}", self.name, self.case);
        assert!(s.weight.is_finite() && s.pdf > 0.0 && s.pdf.is_finite(), "{}", context());
        assert!(s.pdf_rev >= 0.0 && s.pdf_rev.is_finite(), "{}", context());
        assert!((s.wi.length() - 1.0).abs() < 1e-4, "not unit: {}", context());
        assert!(s.lobe.0.count_ones() == 1, "one class: {}", context());
        assert!(mask.has(s.lobe) && self.model.lobes().has(s.lobe), "wrong class: {}", context());
        let reflects = s.wi.z * wo.z > 0.0;
        assert!(reflects == Lobes::REFLECTION.has(s.lobe), "wrong side: {}", context());
        assert!(!reflects || s.eta == 1.0, "eta of a reflection: {}", context());
        Some(s)
    }

    fn near(&self, a: f32, b: f32, floor: f32, what: &str, wi: Vec3) {
        let scale = a.abs().max(b.abs());
        assert!(
            (a - b).abs() <= self.expect.rounding * scale + floor,
            "{} {:?} wi {wi:?}: {what}: {a} and {b}",
            self.name,
            self.case
        );
    }

    fn near_spectrum(&self, a: Spectrum, b: Spectrum, floor: f32, what: &str, wi: Vec3) {
        (0..4).for_each(|i| self.near(a[i], b[i], floor, what, wi));
    }

    /// Identities between the methods at some directions, sampled and uniform ones.
    fn check_directions(&self) {
        let Case { wo, mode, mask } = self.case;
        let mut random = Random::new(self.seed);
        for i in 0..600 {
            let wi = if i % 3 == 0 {
                kaustika_math::warp::uniform_sphere(random.next_2d())
            } else {
                match self.sample(&mut random) {
                    Some(s) if Lobes::DELTA.has(s.lobe) => {
                        self.check_delta(&s, &mut random);
                        continue;
                    }
                    Some(s) => {
                        self.check_smooth(&s);
                        s.wi
                    }
                    None => continue,
                }
            };
            let value = self.model.eval(wo, wi, mode, mask);
            let (forward, reverse) = self.model.pdf(wo, wi, mode, mask);
            let lanes = value.0.iter().chain([&forward, &reverse]);
            assert!(
                lanes.clone().all(|v| *v >= 0.0 && v.is_finite()),
                "{} {:?} wi {wi:?}: {value:?} {forward} {reverse}",
                self.name,
                self.case
            );
            let back = self.model.pdf(wi, wo, mode.adjoint(), mask).0;
            self.near(reverse, back, 1e-6, "reverse density", wi);
            // f(wo, wi) in one mode is f(wi, wo) in the other.
            let f = value / wi.z.abs();
            let adjoint = self.model.eval(wi, wo, mode.adjoint(), mask) / wo.z.abs();
            self.near_spectrum(f, adjoint, 1e-5, "f and its adjoint", wi);
            if self.expect.reciprocal && wo.z * wi.z > 0.0 {
                let swapped = self.model.eval(wi, wo, mode, mask) / wo.z.abs();
                self.near_spectrum(f, swapped, 1e-5, "reciprocity", wi);
            }
            if mask == Lobes::ALL {
                let parts = self
                    .model
                    .lobes()
                    .classes()
                    .map(|c| self.model.eval(wo, wi, mode, c))
                    .fold(Spectrum::ZERO, |a, b| a + b);
                self.near_spectrum(value, parts, 1e-6, "sum over classes", wi);
            }
        }
    }

    fn check_smooth(&self, s: &BsdfSample) {
        let Case { wo, mode, mask } = self.case;
        let (forward, reverse) = self.model.pdf(wo, s.wi, mode, mask);
        self.near(s.pdf, forward, 1e-6, "sampled density and pdf()", s.wi);
        self.near(s.pdf_rev, reverse, 1e-6, "sampled reverse density and pdf()", s.wi);
        let value = self.model.eval(wo, s.wi, mode, mask);
        self.near_spectrum(s.weight * s.pdf, value, 1e-6, "weight pdf and eval()", s.wi);
    }

    fn check_delta(&self, s: &BsdfSample, random: &mut Random) {
        let Case { wo, mode, mask } = self.case;
        assert!(self.model.eval(wo, s.wi, mode, s.lobe).is_black(), "{}: eval of Dirac", self.name);
        // The way back exists and has the probability that was promised.
        let back = (0..1000).find_map(|_| {
            let (uc, u2) = (random.next_1d(), random.next_2d());
            let back = self.model.sample(s.wi, uc, u2, mode.adjoint(), mask)?;
            (back.lobe == s.lobe && (back.wi - wo).length() < 1e-3).then_some(back)
        });
        let Some(back) = back else {
            // A thousand trials miss what is as rare as this once in e¹⁰.
            assert!(s.pdf_rev < 0.01, "{} {:?}: no way back for {s:?}", self.name, self.case);
            return;
        };
        self.near(s.pdf_rev, back.pdf, 1e-5, "reverse probability", s.wi);
        // Radiance: value T/η²; importance, the other way: T.
        let (radiance, importance) = if mode == Mode::Radiance { (s, &back) } else { (&back, s) };
        self.near_spectrum(
            radiance.weight * radiance.pdf * (radiance.eta * radiance.eta),
            importance.weight * importance.pdf,
            1e-5,
            "Dirac value and its adjoint",
            s.wi,
        );
        self.near(s.eta * back.eta, 1.0, 1e-5, "eta there and back", s.wi);
    }

    /// Chi-square of `sample` against `pdf`, and the furnace.
    fn check_statistics(&self) {
        let Case { wo, mode, mask } = self.case;
        let n = self.expect.samples;
        let mut random = Random::new(self.seed ^ 0xabcd_0000);
        let pilot: Vec<_> = (0..n / 4)
            .filter_map(|_| self.sample(&mut random))
            .filter(|s| Lobes::SMOOTH.has(s.lobe))
            .map(|s| s.wi)
            .collect();
        let partition = Partition::new(&pilot, (n / 4 / 64).max(1));
        let integrand = |wi: Vec3| {
            let value = self.model.eval(wo, wi, mode, mask);
            let pdf = self.model.pdf(wo, wi, mode, mask).0;
            [pdf, value[0], value[1], value[2], value[3]].map(f64::from)
        };
        let integrals = partition.integrate(&integrand, 2e-6);
        let mut total = [0.0; 5];
        integrals.iter().for_each(|y| (0..5).for_each(|i| total[i] += y[i]));

        let mut counts = vec![0usize; partition.len()];
        let mut delta: Vec<(BsdfSample, usize)> = Vec::new();
        let mut sums = [[0f64; 2]; 4];
        for _ in 0..n {
            let Some(s) = self.sample(&mut random) else { continue };
            (0..4).for_each(|i| {
                sums[i][0] += s.weight[i] as f64;
                sums[i][1] += (s.weight[i] as f64).powi(2);
            });
            if Lobes::SMOOTH.has(s.lobe) {
                counts[partition.find(s.wi)] += 1;
            } else {
                match delta.iter_mut().find(|d| d.0.lobe == s.lobe) {
                    Some(d) => d.1 += 1,
                    None => delta.push((s, 1)),
                }
            }
        }
        let expected: Vec<_> = integrals.iter().map(|y| y[0] * n as f64).collect();
        if self.expect.exact_pdf {
            self.chi_square(&expected, &counts);
            self.check_probabilities(&delta);
        }
        self.furnace(&total, &delta, sums);
    }

    fn chi_square(&self, expected: &[f64], counts: &[usize]) {
        let n = self.expect.samples as f64;
        let mass: f64 = expected.iter().sum::<f64>() / n;
        assert!(mass < 1.0 + 1e-3, "{} {:?}: pdf integrates to {mass}", self.name, self.case);
        // What is not in a cell went nowhere or into Dirac lobes.
        let mut cells: Vec<(f64, f64)> =
            expected.iter().zip(counts).map(|(&e, &c)| (e, c as f64)).collect();
        let missing = n - counts.iter().sum::<usize>() as f64;
        cells.push(((1.0 - mass).max(0.0) * n, missing));
        cells.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Pool from the smallest until every cell is expected to hold five.
        let mut pooled: Vec<(f64, f64)> = Vec::new();
        for (e, c) in cells {
            match pooled.last_mut() {
                Some(last) if last.0 < 5.0 => *last = (last.0 + e, last.1 + c),
                _ => pooled.push((e, c)),
            }
        }
        if pooled.len() < 2 {
            return;
        }
        let statistic: f64 = pooled.iter().map(|(e, c)| (c - e).powi(2) / e).sum();
        let freedom = (pooled.len() - 1) as f64;
        let p = special::gamma_q(0.5 * freedom, 0.5 * statistic);
        let worst = pooled
            .iter()
            .max_by(|a, b| ((a.1 - a.0).powi(2) / a.0).total_cmp(&((b.1 - b.0).powi(2) / b.0)));
        assert!(
            p > self.p_least,
            "{} {:?}: chi-square {statistic:.1} on {freedom} degrees of freedom, p = {p:.2e} \
             (least {:.2e}); mass {mass:.5}, missing {missing}; worst cell (expected, found) \
             {worst:?}",
            self.name,
            self.case,
            self.p_least
        );
    }

    /// Dirac lobes are drawn as often as their probabilities say.
    fn check_probabilities(&self, delta: &[(BsdfSample, usize)]) {
        let n = self.expect.samples as f64;
        for (s, count) in delta {
            let q = (s.pdf as f64).min(1.0);
            let deviation = *count as f64 - n * q;
            // 1e-4 n stands for rounding, when the probability is one.
            let z = (deviation.abs() - 1e-4 * n).max(0.0) / (n * q * (1.0 - q)).sqrt().max(1.0);
            let p = special::p_two_sided(z);
            assert!(p > self.p_least, "{} {:?}: {count} of {n}: {s:?}", self.name, self.case);
        }
    }

    fn furnace(&self, total: &[f64; 5], delta: &[(BsdfSample, usize)], sums: [[f64; 2]; 4]) {
        let Case { wo, mode, mask } = self.case;
        let n = self.expect.samples as f64;
        let stated = self.model.albedo(wo);
        for i in 0..4 {
            let dirac: f64 = delta.iter().map(|(s, _)| (s.weight[i] * s.pdf) as f64).sum();
            let exact = total[i + 1] + dirac;
            let mean = sums[i][0] / n;
            let error = ((sums[i][1] / n - mean * mean).max(0.0) / n).sqrt();
            // 2e-4 stands for the quadrature and for rounding.
            let z = ((mean - exact).abs() - 2e-4 * (1.0 + exact)).max(0.0) / error.max(1e-9);
            assert!(
                special::p_two_sided(z) > self.p_least,
                "{} {:?} lane {i}: albedo by samples {mean:.5} ± {error:.5}, by quadrature {exact:.5}",
                self.name,
                self.case
            );
            if mode == Mode::Radiance || mask != Lobes::ALL {
                continue;
            }
            let context = format!("{} {wo:?} lane {i}", self.name);
            assert!(exact <= self.expect.albedo_max as f64, "{context}: albedo {exact:.5}");
            if let Some((albedo, tolerance)) = self.expect.albedo {
                assert!(
                    (exact - albedo as f64).abs() <= tolerance as f64,
                    "{context}: albedo {exact:.5}, not {albedo}"
                );
            }
            assert!(
                (stated[i] as f64 - exact).abs() <= self.expect.albedo_error as f64,
                "{context}: albedo() {:.5}, truth {exact:.5}",
                stated[i]
            );
        }
    }
}
