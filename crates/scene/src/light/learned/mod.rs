//! Light selection that has learned what arrives where.
//!
//! In a room most directions of the sky are blocked and most lamps hidden, and samples of them are
//! lost. Before the first pass a modest number of points of the scene try the lights, and what
//! they see decides with which probability a light is chosen in each part of the scene (as Vévoda
//! et al. 2018, "Bayesian online regression for adaptive direct illumination sampling", and Guo et
//! al. 2020, "Next event estimation++"; in proportion to root mean squares as Rath et al. 2020,
//! "Variance-aware path guiding"). An environment counts as many lights, its regions.
//!
//! ```text
//! q_c ∝ (1 - α) P_c √g_c / Σ P √g  +  α p_c                                               (1)
//! g_c = mean of y²,  y = V |cos θ| L / (P_c p)                                            (2)
//! g_c(cell) = (Σ y² + k e_c) / (n + k)                                                    (3)
//! e_c = (k g_c(parent) + h Σ y² of the regions beside c) / (k + h n of those)             (4)
//! ```
//!
//! c is a cluster: a light, a region, or a part of the hierarchy of lights; P_c its power and
//! p_c the probability it would have without what was learned. y compares what a sample of
//! density p within the cluster brings with the cluster's power: for an environment it is hardly
//! more than visibility and cosine, so few samples tell a lot. Cells with few samples lean on the
//! cell they are part of, and regions on those beside them (3, 4): what blocks light is larger than
//! either. Whatever was learned, every cluster keeps a share α of p_c: the
//! estimate stays unbiased, only noise depends on what was learned.

mod cells;
mod clusters;
mod learning;

pub use learning::ShadingPoint;

use super::LightChoice;
use crate::Scene;
use crate::surface::LightId;
use cells::Cells;
use clusters::Clusters;
use kaustika_math::{Vec2, Vec3};
use kaustika_sampling::distribution::shares::{choose, share};

/// Units of the probabilities of clusters.
const UNITS: u32 = 1 << 15;

/// Probabilities of clusters for each part of the scene.
#[derive(Debug)]
pub struct LearnedLights {
    clusters: Clusters,
    cells: Cells,
    /// Where the clusters' shares begin, cell by cell.
    starts: Vec<u16>,
}

impl LearnedLights {
    /// Learns from points of the scene; the same for the same points and seed. `None` if there
    /// is nothing to choose from or no point.
    pub fn new(scene: &Scene, points: Vec<ShadingPoint>, seed: u64) -> Option<LearnedLights> {
        learning::learn(scene, points, seed)
    }

    /// The table for the point `p` with normal `n`.
    #[inline]
    fn table(&self, p: Vec3, n: Vec3) -> &[u16] {
        let (cell, count) = (self.cells.find(p, n), self.clusters.len());
        &self.starts[cell * count..(cell + 1) * count]
    }

    /// As [`LightSelection::sample`](super::LightSelection::sample).
    #[inline]
    pub(super) fn sample(&self, p: Vec3, n: Vec3, u: f32, u2: Vec2) -> LightChoice {
        let (cluster, rest, q) = choose(self.table(p, n), UNITS, u);
        let choice = self.clusters.sample(cluster, p, n, rest, u2);
        LightChoice { p: q * choice.p, ..choice }
    }

    /// As [`LightSelection::pmf`](super::LightSelection::pmf).
    #[inline]
    pub(super) fn pmf(&self, p: Vec3, n: Vec3, light: LightId) -> f32 {
        let (cluster, pmf) = self.clusters.of_light(p, n, light);
        pmf * share(self.table(p, n), UNITS, cluster)
    }

    /// As [`LightSelection::pmf_escaped`](super::LightSelection::pmf_escaped).
    #[inline]
    pub(super) fn pmf_escaped(&self, p: Vec3, n: Vec3, light: LightId, region: u32) -> f32 {
        let (cluster, per_pmf) = self.clusters.of_region(light, region);
        per_pmf * share(self.table(p, n), UNITS, cluster)
    }
}
