//! Points of the scene try the lights, and cells learn from it.

use super::cells::{Cells, Family};
use super::clusters::Clusters;
use super::{LearnedLights, UNITS};
use crate::scene::shadow_end;
use crate::{Scene, Segment};
use kaustika_math::ray::offset_origin;
use kaustika_math::{Ray, Vec2, Vec3, sqr};
use kaustika_sampling::distribution::shares::{choose, fill_starts};
use kaustika_sampling::hash::{combine, nth};
use kaustika_spectra::Wavelengths;
use rayon::prelude::*;

/// A point from which light is learned about.
#[derive(Clone, Copy, Debug)]
pub struct ShadingPoint {
    /// The point, world space.
    pub p: Vec3,
    /// Bound of its rounding error along each axis.
    pub p_error: Vec3,
    /// Geometric normal, unit; on the side that is seen.
    pub n: Vec3,
    /// True if light from behind counts, too.
    pub transmits: bool,
}

/// Rounds, each with what the ones before have learned.
const ROUNDS: u32 = 3;
/// Samples of a point in each round.
const SAMPLES: usize = 4;
/// α of (1).
const DEFENSIVE: f64 = 0.1;
/// α while learning.
const CURIOUS: f64 = 0.4;
/// k of (3) and (4): samples that what is expected is worth.
const TRUST: f32 = 3.0;

/// h of (4): what a sample of a region beside is worth.
const LIKENESS: f32 = 0.5;

/// What the samples of a cluster said in a part of the scene.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    n: f32,
    /// Sum of y².
    sum: f32,
}

impl Tally {
    fn add(&mut self, o: Tally) {
        self.n += o.n;
        self.sum += o.sum;
    }

    fn times(&self, k: f32) -> Tally {
        Tally { n: k * self.n, sum: k * self.sum }
    }

    /// (3)
    fn mean(&self, expected: f32) -> f32 {
        (self.sum + TRUST * expected) / (self.n + TRUST)
    }
}

/// All that is known while learning.
struct Pupil<'a> {
    scene: &'a Scene,
    points: Vec<ShadingPoint>,
    clusters: Clusters,
    family: Family,
    /// Node by node, for each cluster.
    tallies: Vec<Tally>,
}

/// As [`LearnedLights::new`].
pub(super) fn learn(
    scene: &Scene,
    mut points: Vec<ShadingPoint>,
    seed: u64,
) -> Option<LearnedLights> {
    let clusters = Clusters::new(scene)?;
    points.retain(|p| (p.p + p.n).length_squared().is_finite());
    if points.is_empty() || clusters.len() < 2 {
        return None;
    }
    let (cells, family) = Cells::new(&mut points);
    let tallies = vec![Tally::default(); family.parents.len() * clusters.len()];
    let mut pupil = Pupil { scene, points, clusters, family, tallies };
    // Nothing is known yet: every cluster as likely as any, or as bright.
    let mut starts = pupil.tables(|_| vec![0.0; pupil.clusters.len()], 1.0, 0.5);
    for round in 0..ROUNDS {
        pupil.try_lights(&starts, combine(seed, u64::from(round)));
        let last = round + 1 == ROUNDS;
        let (defensive, even) = if last { (DEFENSIVE, 0.0) } else { (CURIOUS, 0.5) };
        let expected = pupil.expectations();
        let count = pupil.clusters.len();
        let of_cell = |node: usize| expected[node * count..(node + 1) * count].to_vec();
        starts = pupil.tables(of_cell, defensive, even);
    }
    Some(LearnedLights { clusters: pupil.clusters, cells, starts })
}

impl Pupil<'_> {
    /// Every cell tries its lights as its table says, and notes what came of it.
    fn try_lights(&mut self, starts: &[u16], seed: u64) {
        let count = self.clusters.len();
        let of_cells: Vec<Vec<(usize, f32)>> = (0..self.family.cells.len())
            .into_par_iter()
            .map(|cell| {
                let table = &starts[cell * count..(cell + 1) * count];
                let points = &self.points[self.family.cells[cell].1.clone()];
                let key = combine(seed, cell as u64);
                let samples = SAMPLES * points.len();
                (0..samples)
                    .map(|i| {
                        let [a, b] = [0, 1].map(|k| nth(key, 2 * i as u32 + k));
                        let u = |bits: u64| (bits & 0xff_ffff) as f32 / (1u64 << 24) as f32;
                        // Clusters evenly over the samples of a cell.
                        let at = (i as f32 + u(a)) / samples as f32;
                        let (cluster, rest, _) = choose(table, UNITS, at);
                        let point = &points[(a >> 24) as usize % points.len()];
                        let u2 = Vec2::new(u(b), u(b >> 24));
                        (cluster, sqr(self.contribution(cluster, point, rest, u2)))
                    })
                    .collect()
            })
            .collect();
        for ((node, _), samples) in self.family.cells.iter().zip(of_cells) {
            for (cluster, square) in samples {
                self.tallies[node * count + cluster].add(Tally { n: 1.0, sum: square });
            }
        }
    }

    /// y of (2) for one sample of a cluster.
    fn contribution(&self, cluster: usize, point: &ShadingPoint, u: f32, u2: Vec2) -> f32 {
        let (scene, at) = (self.scene, point.p);
        let choice = self.clusters.sample(cluster, at, point.n, u, u2);
        let lambda = Wavelengths::sample_for(scene.mode, u);
        let Some(l) =
            scene.light(choice.light).sample_li_in(scene, at, choice.region, choice.u, &lambda)
        else {
            return 0.0;
        };
        let cos = point.n.dot(l.wi);
        let power = self.clusters.power[cluster];
        let unshadowed = cos.abs() * l.le.luminance(&lambda) / (choice.p * l.pdf_w * power);
        if !(unshadowed > 0.0 && unshadowed.is_finite()) || (cos < 0.0 && !point.transmits) {
            return 0.0;
        }
        let target = shadow_end(at, &l);
        let o = offset_origin(at, point.p_error, point.n, target - at);
        let ray = Ray { o, d: target - o, time: 0.0 };
        if scene.occluded(&Segment { ray, t_max: 1.0 }) { 0.0 } else { unshadowed }
    }

    /// g of (3) for each node and cluster, from the roots down.
    fn expectations(&self) -> Vec<f32> {
        let (nodes, count) = (self.family.parents.len(), self.clusters.len());
        // A part knows what its parts know.
        let mut tallies = self.tallies.clone();
        for node in (0..nodes).rev() {
            if let Some(parent) = self.family.parents[node] {
                for c in 0..count {
                    let part = tallies[node * count + c];
                    tallies[parent * count + c].add(part);
                }
            }
        }
        // Above the roots stands what is known of all lights at infinity, and of all others.
        let mut all = [Tally::default(); 2];
        for (node, _) in self.family.parents.iter().enumerate().filter(|(_, p)| p.is_none()) {
            for c in 0..count {
                all[usize::from(self.clusters.is_infinite(c))].add(tallies[node * count + c]);
            }
        }
        let all = all.map(|t| t.sum / t.n.max(1.0));
        let mut expected = vec![0.0; nodes * count];
        for node in 0..nodes {
            for c in 0..count {
                let above = match self.family.parents[node] {
                    Some(parent) => expected[parent * count + c],
                    None => all[usize::from(self.clusters.is_infinite(c))],
                };
                let own = &tallies[node * count..(node + 1) * count];
                // (4)
                let around = self.clusters.beside[c].iter().filter(|&&b| b as usize != c).fold(
                    Tally { n: TRUST, sum: TRUST * above },
                    |mut sum, &b| {
                        sum.add(own[b as usize].times(LIKENESS));
                        sum
                    },
                );
                expected[node * count + c] = own[c].mean(around.sum / around.n);
            }
        }
        expected
    }

    /// The tables of all cells by (1), from g of each node; of the share of the prior `even` goes to all
    /// clusters alike.
    fn tables(&self, g: impl Fn(usize) -> Vec<f32>, defensive: f64, even: f64) -> Vec<u16> {
        let (count, prior) = (self.clusters.len(), &self.clusters.prior);
        let power = &self.clusters.power;
        let alike = 1.0 / prior.iter().filter(|&&p| p > 0.0).count().max(1) as f64;
        let mut starts = vec![0; self.family.cells.len() * count];
        for (table, (node, _)) in starts.chunks_exact_mut(count).zip(&self.family.cells) {
            let learned: Vec<f64> =
                g(*node).iter().zip(power).map(|(&g, &p)| f64::from(p * g.sqrt())).collect();
            let sum: f64 = learned.iter().sum();
            let share = |c: usize| if sum > 0.0 { learned[c] / sum } else { prior[c] };
            let weight = |c: usize| match prior[c] > 0.0 {
                true => {
                    let without = (1.0 - even) * prior[c] + even * alike;
                    (1.0 - defensive) * share(c) + defensive * without
                }
                false => 0.0,
            };
            let weights: Vec<f64> = (0..count).map(weight).collect();
            fill_starts(&weights, UNITS, |c, start| table[c] = start as u16);
        }
        starts
    }
}
