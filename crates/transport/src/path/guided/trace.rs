//! Trees of camera paths, many side by side.
//!
//! ```text
//! n = ⌊q + ξ⌋ copies at a vertex, each:                                                   (1)
//!     w_l f |cos θ_l| Lₑ V / (p p_l)     a light asked for,   w_l = h(p p_l, p(ω_l))
//!     β ← β f |cos θ|/(p(ω) q)           a direction by the mixture of BSDF and guide
//! ```
//!
//! Both weights of the light's two techniques see the density p(ω) of the whole mixture. All
//! branches of a group of pixels trace their rays as one batch, generation by generation.

use super::super::integrate::Integrator;
use super::super::walk::Walk;
use crate::guiding::AnyField;
use crate::method::PassStats;
use crate::roulette::{Roulette, Splitting};
use crate::trees::{Node, Records, mean, sweep};
use kaustika_film::accumulate::{PixelBand, PixelRecord};
use kaustika_math::mix_bits;
use kaustika_sampling::Sampler;
use kaustika_sampling::hash::combine;
use kaustika_scene::bsdf::Bsdf;
use kaustika_scene::description::MediumId;
use kaustika_scene::{RayBatch, Segment};
use kaustika_spectra::Spectrum;

/// Pixels of a group.
const PIXELS: u32 = 1024;

/// How trees grow.
pub(super) struct Growth<'f> {
    /// What is known of light.
    pub field: &'f AnyField,
    /// How paths end and split.
    pub splitting: Splitting,
    /// True if reflected light is kept over the albedo there.
    pub keeps_albedo: bool,
    /// Roulette after the bounce, where the rule is of that kind or knows nothing.
    pub roulette: Roulette,
    /// The picture's expected values, row by row.
    pub measurements: &'f [f32],
}

/// A ray to be traced.
pub(super) struct Branch<'a> {
    pub walk: Walk,
    pub sampler: Sampler<'a>,
    /// Number of its node.
    pub node: u32,
    /// Number of its tree.
    pub tree: u32,
    /// As [`Collision::scattered`].
    pub scattered: u32,
    /// What its ray goes through.
    pub medium: Option<MediumId>,
}

/// What is kept of a tree.
pub(super) struct Tree {
    pub walk: Walk,
    pub record: PixelRecord,
    pub splits: u32,
    pub measurement: f32,
    /// As [`Feature::Trees`](kaustika_film::Feature::Trees) has them, but for `splits`.
    pub factor: f32,
    pub ended: u32,
    pub longest: u32,
    pub rays: u32,
}

/// Room to work in.
#[derive(Default)]
pub(super) struct Forest<'a> {
    pub branches: Vec<Branch<'a>>,
    pub next: Vec<Branch<'a>>,
    pub segments: Vec<Segment>,
    pub shadow_rays: Vec<Segment>,
    pub lit: Vec<(u32, Spectrum)>,
    pub batch: RayBatch,
    pub nodes: Vec<Node>,
    pub trees: Vec<Tree>,
    pub bsdf: Bsdf<'a>,
    /// For surfaces that shadow rays pass.
    pub passed: Bsdf<'a>,
}

/// What a band of pixels gives besides its picture.
#[derive(Default)]
pub(super) struct Harvest {
    pub stats: PassStats,
    pub records: Records,
    /// Grey values of the pixels.
    pub values: Vec<f32>,
    /// Second moments of plain paths to them, see [`crate::trees`].
    pub plain: Vec<f32>,
}

impl<'a> Forest<'a> {
    /// One sample of every pixel of a band; about that share of them is `learned` from.
    pub(super) fn trace(
        &mut self,
        integrator: &Integrator<'a>,
        growth: &Growth,
        index: u64,
        learned: f64,
        band: &mut PixelBand,
    ) -> Harvest {
        let mut harvest = Harvest::default();
        let pixels = band.width() * band.height();
        for first in (0..pixels).step_by(PIXELS as usize) {
            let group = first..pixels.min(first + PIXELS);
            self.plant(integrator, growth, index, band, group.clone());
            while !self.branches.is_empty() {
                self.grow(integrator, growth, band.wants_features(), &mut harvest.stats);
            }
            let number = mix_bits(combine(index, u64::from(band.y * band.width() + first)));
            let learns = (number >> 11) as f64 / (1u64 << 53) as f64;
            let records = (learns < learned).then_some(&mut harvest.records);
            sweep(&mut self.nodes, integrator.scene().mode, records);
            self.deliver(integrator, band, group, &mut harvest);
        }
        harvest
    }

    /// Starts the trees of some pixels.
    fn plant(
        &mut self,
        integrator: &Integrator<'a>,
        growth: &Growth,
        index: u64,
        band: &PixelBand,
        group: std::ops::Range<u32>,
    ) {
        self.nodes.clear();
        self.trees.clear();
        let region = integrator.frame().region;
        for (tree, pixel) in group.enumerate() {
            let (x, y) = (pixel % band.width(), band.y + pixel / band.width());
            let (walk, sampler) = integrator.start([region[0] + x, region[1] + y], index);
            let ray = walk.segment.ray;
            let root = Node { found: walk.radiance, ..Node::root(ray.o, ray.d) };
            self.nodes.push(root);
            let at = y as usize * band.width() as usize + x as usize;
            let measurement = growth.measurements.get(at).copied().unwrap_or(1.0);
            let record = PixelRecord::default();
            self.trees.push(Tree {
                walk,
                record,
                splits: 0,
                measurement,
                factor: 1.0,
                ended: 0,
                longest: 0,
                rays: 0,
            });
            let tree = tree as u32;
            let medium = integrator.scene().camera_medium;
            self.branches.push(Branch { walk, sampler, node: tree, tree, scattered: 0, medium });
        }
    }

    /// Traces a generation of rays.
    fn grow(
        &mut self,
        integrator: &Integrator<'a>,
        growth: &Growth,
        features: bool,
        stats: &mut PassStats,
    ) {
        self.segments.clear();
        self.segments.extend(self.branches.iter().map(|b| b.walk.segment));
        integrator.scene().hit_all(&self.segments, &mut self.batch);
        self.shadow_rays.clear();
        self.lit.clear();
        let mut branches = std::mem::take(&mut self.branches);
        for (i, branch) in branches.drain(..).enumerate() {
            let hit = self.batch.hit(i);
            self.vertex(integrator, growth, branch, hit.as_ref(), features, stats);
        }
        integrator.scene().occluded_all(&self.shadow_rays, &mut self.batch);
        for (&(node, light), &occluded) in self.lit.iter().zip(&self.batch.occluded) {
            if !occluded {
                self.nodes[node as usize].direct = light;
            }
        }
        // The memory of this generation is the next but one's.
        self.branches = std::mem::replace(&mut self.next, branches);
    }

    /// Gives the film what the trees found.
    fn deliver(
        &mut self,
        integrator: &Integrator<'a>,
        band: &mut PixelBand,
        group: std::ops::Range<u32>,
        harvest: &mut Harvest,
    ) {
        for ((pixel, tree), root) in group.zip(&self.trees).zip(&self.nodes) {
            let (x, y) = (pixel % band.width(), pixel / band.width());
            let radiance = tree.walk.beta * root.value();
            let lambda = &tree.walk.lambda;
            let rgb = integrator.frame().rgb(radiance, lambda, &mut harvest.stats);
            let weight = tree.walk.film_weight;
            band.add(x, y, &PixelRecord { rgb, weight, ..tree.record });
            integrator.frame().add_bands(band, [x, y], weight, radiance, lambda);
            let counts = [tree.splits, tree.ended, tree.longest, tree.rays].map(|n| n as f32);
            let [added, ended, longest, rays] = counts;
            band.add_trees(x, y, weight, [tree.factor, added, ended, longest, rays]);
            let grey = mean(radiance, lambda);
            harvest.values.push(if grey.is_finite() { grey } else { 0.0 });
            let camera = mean(tree.walk.beta, lambda);
            let plain = camera * camera * root.plain(mean(root.found, lambda));
            harvest.plain.push(if plain.is_finite() { plain } else { 0.0 });
        }
    }
}
