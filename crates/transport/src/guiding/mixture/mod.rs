//! A distribution of directions as a mixture of von Mises-Fisher lobes, fitted to weighted records.
//!
//! ```text
//! πₖ = (n sₖ/S + v)/(n + K v),    R̄ₖ = nₖ/(nₖ + ρ) |rₖ|/sₖ,    μₖ = rₖ/|rₖ|,    1/dₖ = hₖ/sₖ   (1)
//! n = S²/Σ w²,    nₖ = sₖ²/qₖ                                                            (2)
//! ```
//!
//! Ruppert, Herholz & Lensch 2020, "Robust Fitting of Parallax-Aware Mixtures for Path Guiding",
//! after Vorba et al. 2014, "On-line Learning of Parametric Mixture Models for Light Transport
//! Simulation". The E-step is in [`expectation`], (1) the M-step: the most probable parameters, v
//! and ρ the strength of priors that hold weights alike and lobes wide. n and nₖ are not numbers
//! of records, but of records of equal energy: a few bright ones among many are few.
//!
//! Sums are kept from one batch to the next and count less with every refinement; lobes are
//! divided and merged then ([`split`]). All refer to the pivot, the mean place of the records,
//! from which the same light is seen in other directions. More: docs/guiding.md.

mod expectation;
mod lobes;
mod saving;
mod split;
#[cfg(test)]
mod tests;
mod vmf;

use super::{Directions, LightRecord, LocalDirections};
use expectation::{Expectation, Misfit, Sample, Sums};
use kaustika_math::{Vec2, Vec3, mix_bits};
use lobes::{Known, Lobe, Lobes};
use split::Component;

/// Lobes to begin with, all over the sphere, and their κ.
const FIRST: usize = 16;
const FIRST_KAPPA: f32 = 5.0;
/// v and ρ of (1), in records.
const WEIGHT_PRIOR: f64 = 0.1;
const WIDE_PRIOR: f64 = 0.1;
/// EM ends when the mean log-likelihood gains less, or after so many steps: in the first batch, later.
const CONVERGED: f64 = 0.0025;
const FIRST_STEPS: usize = 30;
const STEPS: usize = 4;
/// How often lobes are divided within the first batch.
const FIRST_SPLITS: usize = 2;
/// Records of a batch that lobes are fitted to, at most.
const MOST_SAMPLES: usize = 1 << 15;
/// What was learned before counts this much after a refinement, and as so many records at most.
const KEPT: f64 = 0.5;
const MOST_KEPT: f64 = 8192.0;

/// Energy of a record from which on it is taken for a fault: fluence must be a number.
const BRIGHTEST: f64 = 1e30;

/// Incident radiance as lobes.
#[derive(Clone, Debug, Default)]
pub struct Mixture {
    known: Option<Box<Known>>,
    components: Vec<Component>,
    /// Records, those without energy too, and their energy; both fade.
    records: f64,
    energy: f64,
    /// Σ w², of what the components were fitted to.
    squares: f64,
    /// Records since lobes were divided last.
    since_split: f64,
    /// Their mean place.
    pivot: Vec3,
}

/// A [`Mixture`] at a point.
#[derive(Clone, Copy, Debug)]
pub struct LocalMixture<'a> {
    known: &'a Known,
    p: Vec3,
    lobes: Lobes,
    /// `lobes` are multiplied by a cosine.
    towards: bool,
}

impl Mixture {
    /// Number of lobes of the mixture that answers.
    pub fn size(&self) -> usize {
        self.known.as_ref().map_or(0, |known| known.count())
    }

    /// Samples of a batch in units of their mean energy, that unit, and how many records each
    /// stands for.
    fn samples(&mut self, records: &[LightRecord]) -> (Vec<Sample>, f64, f64) {
        let radius = self.follow(records);
        let mut samples = Vec::new();
        let mut energy = 0.0;
        for r in records {
            let e = f64::from(r.radiance) / f64::from(r.pdf);
            if !(e > 0.0 && e < BRIGHTEST && r.w.is_finite() && r.p.is_finite()) {
                continue;
            }
            energy += e;
            let seen = (r.p - self.pivot) + r.w * r.distance;
            let (w, nearness) = match seen.try_normalize() {
                // What is nearer than the cell is wide has no one direction there.
                Some(w) => (w, 1.0 / seen.length().max(radius)),
                None => (r.w, 0.0),
            };
            samples.push((w, e, r.pdf, nearness));
        }
        self.energy += energy;
        let step = samples.len().div_ceil(MOST_SAMPLES).max(1);
        let unit = energy / samples.len().max(1) as f64;
        let sample = |&(w, e, pdf, nearness): &(Vec3, f64, f32, f32)| Sample {
            w,
            energy: (e / unit) as f32,
            pdf,
            nearness,
        };
        // Any one of each few: records that follow one another are not of one kind.
        let thinned = samples.chunks(step).enumerate();
        let one = |(i, few): (usize, &[_])| sample(&few[mix_bits(i as u64) as usize % few.len()]);
        (thinned.map(one).collect(), unit, step as f64)
    }

    /// Counts records, and moves the pivot along with their mean. How far they are from it (the
    /// root of the mean square).
    fn follow(&mut self, records: &[LightRecord]) -> f32 {
        let n = records.len() as f64;
        let before = self.records;
        self.records += n;
        let mean = |of: &dyn Fn(usize) -> f64| (0..records.len()).map(of).sum::<f64>() / n;
        let means: [f64; 3] = std::array::from_fn(|c| mean(&|i| f64::from(records[i].p[c])));
        let means = Vec3::new(means[0] as f32, means[1] as f32, means[2] as f32);
        if !means.is_finite() {
            return 0.0;
        }
        let pivot = self.pivot.lerp(means, (n / (before + n)) as f32);
        let shift = self.pivot - pivot;
        self.pivot = pivot;
        self.components.iter_mut().for_each(|c| c.moved(shift));
        mean(&|i| f64::from((records[i].p - pivot).length_squared())).sqrt() as f32
    }

    /// EM on a batch, on top of what was learned before.
    fn fit(&mut self, samples: &[Sample], unit: f64, steps: usize) {
        let squares: f64 = samples.iter().map(|s| f64::from(s.energy).powi(2)).sum();
        self.squares += unit * unit * squares;
        let mut likelihood = f64::NEG_INFINITY;
        let mut batch = Vec::new();
        for _ in 0..steps {
            let lobes: Vec<Lobe> = self.components.iter().map(|c| c.lobe).collect();
            let (sums, next) = Expectation::new(&lobes).sums(samples);
            batch = sums;
            self.maximize(&batch, unit);
            let next = next / samples.len() as f64;
            if next - likelihood < CONVERGED {
                break;
            }
            likelihood = next;
        }
        for (c, batch) in self.components.iter_mut().zip(&batch) {
            c.sums = c.sums.plus(batch, unit);
        }
    }

    /// (1).
    fn maximize(&mut self, batch: &[Sums], unit: f64) {
        let k = self.components.len() as f64;
        let sums = |(c, batch): (&Component, &Sums)| c.sums.plus(batch, unit);
        let all: Vec<Sums> = self.components.iter().zip(batch).map(sums).collect();
        let energy: f64 = all.iter().map(|s| s.energy).sum();
        let n = energy * energy / self.squares;
        for (c, sums) in self.components.iter_mut().zip(&all) {
            let share = n * sums.energy / energy;
            c.lobe.weight = ((share + WEIGHT_PRIOR) / (n + k * WEIGHT_PRIOR)) as f32;
            let (length, records) = (sums.length(), sums.records());
            if length <= 0.0 || records <= 0.0 {
                c.lobe.kappa = vmf::LEAST_KAPPA as f32;
                continue;
            }
            let r = sums.direction.map(|r| (r / length) as f32);
            c.lobe.mean = Vec3::from(r);
            let mean_cosine = length / sums.energy * records / (records + WIDE_PRIOR);
            c.lobe.kappa = vmf::concentration(mean_cosine) as f32;
            c.lobe.nearness = (sums.nearness / sums.energy) as f32;
        }
    }

    /// Adds up how well lobes fit a batch.
    fn examine(&mut self, samples: &[Sample], unit: f64) {
        let lobes: Vec<Lobe> = self.components.iter().map(|c| c.lobe).collect();
        let misfits = Expectation::new(&lobes).misfits(samples);
        for (c, batch) in self.components.iter_mut().zip(misfits) {
            c.misfit = c.misfit.plus(&batch, unit);
        }
    }

    /// Only the lobes stay, without what they were learned from.
    fn forget(&mut self) {
        self.squares = 0.0;
        for c in &mut self.components {
            (c.sums, c.misfit) = (Sums::default(), Misfit::default());
        }
    }

    /// What was learned counts less from now on.
    fn fade(&mut self) {
        self.scale(KEPT.min(MOST_KEPT / self.records));
        self.components.iter_mut().for_each(|c| c.misfit = Misfit::default());
        self.since_split = 0.0;
    }

    /// What was learned counts `times` as much.
    fn scale(&mut self, times: f64) {
        for c in &mut self.components {
            c.sums = Sums::default().plus(&c.sums, times);
        }
        self.records *= times;
        self.energy *= times;
        self.squares *= times * times;
    }
}

impl Component {
    /// A lobe about which nothing is known.
    fn new(mean: Vec3) -> Component {
        let lobe = Lobe { mean, kappa: FIRST_KAPPA, weight: 1.0 / FIRST as f32, nearness: 0.0 };
        Component { lobe, sums: Sums::default(), misfit: Misfit::default() }
    }

    /// As seen from elsewhere: the pivot moved by -`shift`.
    fn moved(&mut self, shift: Vec3) {
        let v = self.lobe.mean + shift * self.lobe.nearness;
        let Some(mean) = v.try_normalize() else { return };
        let (length, nearer) = (self.sums.length(), 1.0 / v.length());
        self.lobe.mean = mean;
        self.lobe.nearness *= nearer;
        self.sums.nearness *= f64::from(nearer);
        self.sums.direction = <[f32; 3]>::from(mean).map(|x| length * f64::from(x));
    }
}

/// Spread over the sphere in a spiral.
fn spiral(i: usize, n: usize) -> Vec3 {
    let z = 1.0 - (2 * i + 1) as f32 / n as f32;
    let (sin, cos) = (i as f32 * 2.399_963).sin_cos();
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * cos, r * sin, z)
}

impl Directions for Mixture {
    type Local<'a> = LocalMixture<'a>;

    fn at(&self, p: Vec3) -> Option<LocalMixture<'_>> {
        let known = self.known.as_deref()?;
        Some(LocalMixture { known, p, lobes: known.at(p), towards: false })
    }

    #[inline]
    fn towards(&self, p: Vec3, n: Vec3) -> Option<LocalMixture<'_>> {
        let known = self.known.as_deref()?;
        Some(LocalMixture { known, p, lobes: known.at(p).with_cosine(n), towards: true })
    }

    fn learn(&mut self, records: &[LightRecord]) {
        if records.is_empty() {
            return;
        }
        let (samples, unit, thinned) = self.samples(records);
        let counted = records.len() as f64 / thinned;
        self.since_split += counted;
        if samples.is_empty() {
            return;
        }
        let first = self.components.is_empty();
        if first {
            self.components = (0..FIRST).map(|i| Component::new(spiral(i, FIRST))).collect();
        }
        self.fit(&samples, unit, if first { FIRST_STEPS } else { STEPS });
        if first {
            for _ in 0..FIRST_SPLITS {
                self.examine(&samples, unit);
                if !split::split(&mut self.components, counted) {
                    break;
                }
                self.forget();
                self.fit(&samples, unit, FIRST_STEPS);
            }
            self.components.iter_mut().for_each(|c| c.misfit = Misfit::default());
        }
        self.examine(&samples, unit);
    }

    fn refine(&mut self) {
        if self.components.is_empty() {
            return;
        }
        split::merge(&mut self.components);
        split::split(&mut self.components, self.since_split);
        let lobes: Vec<Lobe> = self.components.iter().map(|c| c.lobe).collect();
        let fluence = (self.energy / self.records) as f32;
        self.known = Some(Box::new(Known::new(&lobes, self.pivot, fluence)));
        self.fade();
    }

    fn halve(&mut self) {
        self.scale(0.5);
    }
}

impl LocalDirections for LocalMixture<'_> {
    #[inline]
    fn sample(&self, u: Vec2) -> (Vec3, f32) {
        let w = self.lobes.sample(u);
        (w, self.lobes.pdf(w))
    }

    #[inline]
    fn pdf(&self, w: Vec3) -> f32 {
        self.lobes.pdf(w)
    }

    fn radiance(&self, w: Vec3) -> f32 {
        self.known.fluence() * self.incident().pdf(w)
    }

    fn irradiance(&self, n: Vec3) -> f32 {
        self.known.irradiance(&self.incident(), n)
    }

    #[inline]
    fn towards(mut self, n: Vec3) -> Self {
        self.lobes = self.incident().with_cosine(n);
        self.towards = true;
        self
    }
}

impl LocalMixture<'_> {
    /// Lobes of the radiance, without any cosine.
    #[inline]
    fn incident(&self) -> Lobes {
        if self.towards { self.known.at(self.p) } else { self.lobes }
    }
}
