//! The E-step: which lobe a record belongs to, and what each lobe's records add up to.
//!
//! ```text
//! γₖ(ω) = πₖ v(ω; μₖ, κₖ) / p(ω)                                                         (1)
//! sₖ = Σ w γₖ,   rₖ = Σ w γₖ ω,   qₖ = Σ (w γₖ)²,   hₖ = Σ w γₖ/d                        (2)
//! Mₖ = Σ w γₖ (ω - μₖ)(ω - μₖ)ᵀ,   Fₖ = Σ w² γₖ q/p                                      (3)
//! ```
//!
//! w is a record's energy, radiance over q, the density with which it was drawn. (3) is for lobes
//! that may have to be divided ([`super::split`]).
//!
//! Sixteen lobes go side by side. Differences from μₖ are summed in place of directions, which
//! leaves narrow lobes their digits, and every 64 records in `f64`.

use super::lobes::{Lobe, MOST, row};
use super::vmf;
use kaustika_math::Vec3;
use kaustika_math::lanes::{LANES, Lanes, Vec3s};
use std::array::from_fn;

/// A record with energy.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Where light comes from, as seen from the pivot.
    pub w: Vec3,
    /// w, in units of the batch.
    pub energy: f32,
    /// q.
    pub pdf: f32,
    /// 1/distance from the pivot.
    pub nearness: f32,
}

/// (2) of one lobe.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    /// s.
    pub energy: f64,
    /// r.
    pub direction: [f64; 3],
    /// q.
    pub squares: f64,
    /// h.
    pub nearness: f64,
}

impl Sums {
    /// Both together, the second `scale` times.
    pub fn plus(&self, o: &Sums, scale: f64) -> Sums {
        Sums {
            energy: self.energy + scale * o.energy,
            direction: from_fn(|i| self.direction[i] + scale * o.direction[i]),
            squares: self.squares + scale * scale * o.squares,
            nearness: self.nearness + scale * o.nearness,
        }
    }

    /// |r|.
    pub fn length(&self) -> f64 {
        self.direction.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// s²/q: as many equal records would be as uncertain (Kish 1965).
    pub fn records(&self) -> f64 {
        if self.squares > 0.0 { self.energy * self.energy / self.squares } else { 0.0 }
    }
}

/// (3) of one lobe.
#[derive(Clone, Copy, Debug, Default)]
pub struct Misfit {
    /// Σ w γ of the same records.
    pub energy: f64,
    /// M: xx, yy, zz, xy, yz, zx.
    pub moments: [f64; 6],
    /// F.
    pub squares: f64,
}

impl Misfit {
    /// Both together, the second `scale` times.
    pub fn plus(&self, o: &Misfit, scale: f64) -> Misfit {
        Misfit {
            energy: self.energy + scale * o.energy,
            moments: from_fn(|i| self.moments[i] + scale * o.moments[i]),
            squares: self.squares + scale * scale * o.squares,
        }
    }
}

/// Records between two additions in `f64`.
const RUN: usize = 64;
/// p in F at least: a BSDF sees to it that nothing is drawn much less often.
const LEAST_DENSITY: f32 = 0.1 / (4.0 * std::f32::consts::PI);

/// Sixteen lobes of a mixture.
struct Block {
    mean: Vec3s,
    /// -κ/2.
    rate: Lanes,
    /// ln(π c(κ)).
    ln_peak: Lanes,
    peak: Lanes,
}

/// A mixture, as the E-step wants it.
pub struct Expectation {
    blocks: Vec<Block>,
    count: usize,
}

/// What a record is to sixteen lobes.
#[derive(Clone, Copy)]
struct Share {
    /// ω - μ.
    d: Vec3s,
    /// γ.
    gamma: Lanes,
}

impl Expectation {
    /// Of these lobes.
    pub fn new(lobes: &[Lobe]) -> Expectation {
        let block = |lobes: &[Lobe]| {
            let peak = |l: &Lobe| l.weight * vmf::normalization(f64::from(l.kappa)) as f32;
            Block {
                mean: Vec3s {
                    x: row(lobes, 0.0, |l| l.mean.x),
                    y: row(lobes, 0.0, |l| l.mean.y),
                    z: row(lobes, 1.0, |l| l.mean.z),
                },
                rate: row(lobes, 0.0, |l| -0.5 * l.kappa),
                ln_peak: row(lobes, -1e30, |l| peak(l).ln()),
                peak: row(lobes, 0.0, peak),
            }
        };
        Expectation { blocks: lobes.chunks(LANES).map(block).collect(), count: lobes.len() }
    }

    /// (1) for every lobe, and ln p.
    #[inline(always)]
    fn shares(&self, w: Vec3, shares: &mut [Share; MOST / LANES]) -> f32 {
        let w = Vec3s { x: Lanes::splat(w.x), y: Lanes::splat(w.y), z: Lanes::splat(w.z) };
        let mut sum = Lanes::splat(0.0);
        for (b, share) in self.blocks.iter().zip(shares.iter_mut()) {
            let d = w - b.mean;
            let part = b.peak * (d.dot(d) * b.rate).exp();
            *share = Share { d, gamma: part };
            sum += part;
        }
        let mut p = sum.reduce_add();
        let mut greatest = 0.0;
        if p < 1e-30 {
            // Far from all: relative to the nearest.
            let exponent =
                |i: usize, d: Vec3s| d.dot(d).mul_add(self.blocks[i].rate, self.blocks[i].ln_peak);
            let used = &mut shares[..self.blocks.len()];
            greatest = f32::NEG_INFINITY;
            for (i, share) in used.iter().enumerate() {
                greatest = exponent(i, share.d).to_array().into_iter().fold(greatest, f32::max);
            }
            sum = Lanes::splat(0.0);
            for (i, share) in used.iter_mut().enumerate() {
                share.gamma = (exponent(i, share.d) - Lanes::splat(greatest)).exp();
                sum += share.gamma;
            }
            p = sum.reduce_add();
        }
        let inverse = Lanes::splat(1.0 / p);
        for share in &mut shares[..self.blocks.len()] {
            share.gamma *= inverse;
        }
        greatest + p.ln()
    }

    /// (2) of every lobe, and Σ w ln p.
    pub fn sums(&self, samples: &[Sample]) -> (Vec<Sums>, f64) {
        let mut all = vec![Sums::default(); self.count];
        let mut likelihood = 0.0;
        let zero = Lanes::splat(0.0);
        let none = Vec3s { x: zero, y: zero, z: zero };
        let mut shares = [Share { d: none, gamma: zero }; MOST / LANES];
        for run in samples.chunks(RUN) {
            let mut sums = [(zero, none, zero, zero); MOST / LANES];
            for sample in run {
                let ln_p = self.shares(sample.w, &mut shares);
                likelihood += f64::from(sample.energy * ln_p);
                let (energy, nearness) =
                    (Lanes::splat(sample.energy), Lanes::splat(sample.nearness));
                for (sum, share) in sums.iter_mut().zip(&shares).take(self.blocks.len()) {
                    let e = share.gamma * energy;
                    sum.0 += e;
                    sum.1 = sum.1.plus(share.d, e);
                    sum.2 = e.mul_add(e, sum.2);
                    sum.3 = e.mul_add(nearness, sum.3);
                }
            }
            for (k, all) in all.iter_mut().enumerate() {
                let (b, i) = (k / LANES, k % LANES);
                let (s, d, q, h) = &sums[b];
                let at = |row: &Lanes| f64::from(row.as_array()[i]);
                let mean = [&self.blocks[b].mean.x, &self.blocks[b].mean.y, &self.blocks[b].mean.z];
                let direction = [&d.x, &d.y, &d.z];
                all.energy += at(s);
                for c in 0..3 {
                    all.direction[c] += at(s) * at(mean[c]) + at(direction[c]);
                }
                all.squares += at(q);
                all.nearness += at(h);
            }
        }
        (all, likelihood)
    }

    /// (3) of every lobe.
    pub fn misfits(&self, samples: &[Sample]) -> Vec<Misfit> {
        let mut all = vec![Misfit::default(); self.count];
        let zero = Lanes::splat(0.0);
        let none = Vec3s { x: zero, y: zero, z: zero };
        let mut shares = [Share { d: none, gamma: zero }; MOST / LANES];
        for run in samples.chunks(RUN) {
            let mut sums = [[zero; 8]; MOST / LANES];
            for sample in run {
                let p = self.shares(sample.w, &mut shares).exp().max(LEAST_DENSITY);
                let energy = Lanes::splat(sample.energy);
                let ratio = Lanes::splat(sample.energy * sample.pdf / p);
                for (sum, Share { d, gamma }) in
                    sums.iter_mut().zip(&shares).take(self.blocks.len())
                {
                    let e = *gamma * energy;
                    sum[0] += e;
                    let [x, y, z] = [d.x * e, d.y * e, d.z * e];
                    sum[1] = x.mul_add(d.x, sum[1]);
                    sum[2] = y.mul_add(d.y, sum[2]);
                    sum[3] = z.mul_add(d.z, sum[3]);
                    sum[4] = x.mul_add(d.y, sum[4]);
                    sum[5] = y.mul_add(d.z, sum[5]);
                    sum[6] = z.mul_add(d.x, sum[6]);
                    sum[7] = e.mul_add(ratio, sum[7]);
                }
            }
            for (k, all) in all.iter_mut().enumerate() {
                let sums = &sums[k / LANES];
                let at = |c: usize| f64::from(sums[c].as_array()[k % LANES]);
                all.energy += at(0);
                all.moments.iter_mut().enumerate().for_each(|(c, m)| *m += at(c + 1));
                all.squares += at(7);
            }
        }
        all
    }
}
