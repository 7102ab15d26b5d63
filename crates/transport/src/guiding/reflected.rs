//! What is expected to be reflected back along a path that arrives somewhere: the adjoint of
//! roulette and splitting.
//!
//! A cell of space has sixteen bins of directions over the sphere (as Rath et al. 2022). Bins keep
//! mean, second moment and cost of one continuation, from estimates of paths that arrived there.
//! Light is kept over the surface's albedo, so that what is learned on one part of a picture on a
//! wall serves for all of it:
//!
//! ```text
//! L(y, ωₒ) ≈ ρ(y, ωₒ) ⟨L/ρ⟩                                                               (1)
//! ```
//!
//! Variance is that of continuations from one place, where paths have split; until they have, it is
//! that of all in the cell, which is greater by what light varies there.
//!
//! On matte surfaces this is irradiance times albedo over π (Vorba & Křivánek 2016, sec. 5.1).

use super::{Placed, octahedron};
use crate::saved::saved;
use kaustika_math::Vec3;

/// What one continuation of a path is expected to bring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// Mean L.
    pub mean: f32,
    /// Mean of its square.
    pub moment: f32,
    /// Variance about what is expected at that place.
    pub variance: f32,
    /// Cost, in rays.
    pub cost: f32,
}

/// What a path that arrived somewhere was found to be worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReflectedRecord {
    /// Where.
    pub p: Vec3,
    /// Direction that it came from, unit, away from the surface.
    pub wo: Vec3,
    /// Albedo there.
    pub albedo: f32,
    /// Estimate of the reflected light: the sum over the copies, over q.
    pub mean: f32,
    /// The sum of their squares over q.
    pub moment: f32,
    /// Variance of one copy, told by the others; `None` where there is only one.
    pub variance: Option<f32>,
    /// The sum of their costs over q.
    pub cost: f32,
}

impl Placed for ReflectedRecord {
    fn place(&self) -> Vec3 {
        self.p
    }
}

/// What is known of it in a cell.
#[derive(Clone, Debug, Default)]
pub struct Reflected {
    bins: [Bin; BINS],
    all: Bin,
    /// As they are asked.
    known: [Option<Expected>; BINS],
}

/// Sums over records.
#[derive(Clone, Copy, Debug, Default)]
struct Bin {
    count: f32,
    mean: f32,
    moment: f32,
    cost: f32,
    /// Records that tell a variance, and its sum.
    splits: f32,
    variance: f32,
}

saved!(Reflected { bins, all, known });
saved!(Bin { count, mean, moment, cost, splits, variance });
saved!(Expected { mean, moment, variance, cost });

/// Bins along either side of the square of directions.
const SIDE: usize = 4;
const BINS: usize = SIDE * SIDE;
/// Records that a bin, and a cell, must have seen to be asked.
const ENOUGH: f32 = 32.0;
/// Relative standard error of the mean up to which it is believed (Vorba & Křivánek 2016).
const BELIEVED: f32 = 0.3;
/// Albedo below which a surface counts as this dark.
const DARK: f32 = 0.01;
/// What is left of earlier sums when an iteration ends: they were made with other factors.
const KEPT: f32 = 0.25;

impl Bin {
    fn add(&mut self, r: &ReflectedRecord) {
        let albedo = r.albedo.max(DARK);
        let (mean, moment) = (r.mean / albedo, r.moment / (albedo * albedo));
        if mean.is_finite() && moment.is_finite() {
            self.count += 1.0;
            self.mean += mean;
            self.moment += moment;
            self.cost += r.cost;
            if let Some(variance) = r.variance.filter(|v| v.is_finite()) {
                self.splits += 1.0;
                self.variance += variance / (albedo * albedo);
            }
        }
    }

    fn scale(&mut self, k: f32) {
        self.count *= k;
        self.mean *= k;
        self.moment *= k;
        self.cost *= k;
        self.splits *= k;
        self.variance *= k;
    }

    /// Makes room for records of other factors; as long as those do not come, what there is stays:
    /// where a rule ends all paths nobody would know any more that it should.
    fn fade(&mut self) {
        self.scale(KEPT.max(4.0 * ENOUGH / self.count.max(4.0 * ENOUGH)));
    }

    fn expected(&self) -> Option<Expected> {
        if self.count < ENOUGH {
            return None;
        }
        let [mean, moment, cost] = [self.mean, self.moment, self.cost].map(|s| s / self.count);
        let of_cell = (moment - mean * mean).max(0.0);
        let believed = (of_cell / self.count).sqrt() <= BELIEVED * mean;
        let variance = match self.splits >= ENOUGH {
            true => (self.variance / self.splits).min(of_cell),
            false => of_cell,
        };
        believed.then_some(Expected { mean, moment, variance, cost })
    }
}

fn bin(w: Vec3) -> usize {
    let p = octahedron::to_square(w);
    let k = |x: f32| ((x * SIDE as f32) as usize).min(SIDE - 1);
    k(p.x) + SIDE * k(p.y)
}

impl Reflected {
    /// Light toward `wo`, where the albedo is `albedo`; `None` if not enough is known.
    #[inline]
    pub fn expected(&self, wo: Vec3, albedo: f32) -> Option<Expected> {
        let e = self.known[bin(wo)]?;
        let rho = albedo.max(DARK);
        let [moment, variance] = [e.moment, e.variance].map(|x| x * rho * rho);
        Some(Expected { mean: e.mean * rho, moment, variance, cost: e.cost })
    }

    /// Takes in records of its cell. What [`Reflected::expected`] says stays as it is.
    pub fn learn(&mut self, records: &[ReflectedRecord]) {
        for r in records {
            self.bins[bin(r.wo)].add(r);
            self.all.add(r);
        }
    }

    /// Takes over what was learned.
    pub fn refine(&mut self) {
        let all = self.all.expected();
        self.known = self.bins.map(|bin| bin.expected().or(all));
        self.bins.iter_mut().chain([&mut self.all]).for_each(Bin::fade);
    }

    /// Its cell is divided in two, and this is to be either's.
    pub fn halve(&mut self) {
        self.scale(0.5);
    }

    fn scale(&mut self, k: f32) {
        self.bins.iter_mut().chain([&mut self.all]).for_each(|bin| bin.scale(k));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::{Vec2, mix_bits, warp};

    #[test]
    fn light_is_known_by_direction_and_albedo() {
        let number = |i: u64, k: u64| (mix_bits(8 * i + k) >> 40) as f32 / (1u32 << 24) as f32;
        let mut cell = Reflected::default();
        assert!(cell.expected(Vec3::Z, 0.5).is_none());
        let light = |w: Vec3| if w.x > 0.0 { 8.0 } else { 1.0 };
        for pass in 0..3u64 {
            let record = |i: u64| {
                let i = pass * 40_000 + i;
                let w = warp::uniform_hemisphere(Vec2::new(number(i, 2), number(i, 3)));
                let albedo = 0.1 + 0.8 * number(i, 4);
                let copies = 2.0 * number(i, 5);
                let (p, mean) = (Vec3::ZERO, albedo * light(w) * copies);
                let variance = i.is_multiple_of(3).then_some(0.05 * albedo * albedo);
                let moment = mean * mean;
                ReflectedRecord { p, wo: w, albedo, mean, moment, variance, cost: 3.0 }
            };
            let records: Vec<_> = (0..40_000).map(record).collect();
            cell.learn(&records);
            cell.refine();
        }
        for w in [Vec3::new(0.5, 0.5, 0.7).normalize(), Vec3::new(-0.5, 0.2, 0.7).normalize()] {
            let e = cell.expected(w, 0.5).expect("known");
            assert!((e.mean / (0.5 * light(w)) - 1.0).abs() < 0.1, "{e:?}");
            // ∫ (2u)² du = 4/3.
            assert!((e.moment / (0.25 * light(w).powi(2)) - 4.0 / 3.0).abs() < 0.2, "{e:?}");
            assert!((e.variance / (0.25 * 0.05) - 1.0).abs() < 1e-3, "{e:?}");
            assert!((e.cost - 3.0).abs() < 1e-4);
        }
    }
}
