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

use super::super::integrate::{Integrator, MAX_PASSAGES};
use super::super::walk::{Previous, Walk};
use super::absorption::{Absorption, transmittance};
use crate::features::describe;
use crate::guiding::{AnyField, MixedBsdf, is_matte};
use crate::method::PassStats;
use crate::roulette::{Collision, Decision, Roulette, Splitting, Survival, WalkState};
use crate::trees::{Met, Node, Records, mean, sweep};
use kaustika_film::accumulate::{PixelBand, PixelRecord};
use kaustika_math::Vec2;
use kaustika_sampling::Sampler;
use kaustika_scene::bsdf::{Bsdf, Lobes, Mode};
use kaustika_scene::description::MediumId;
use kaustika_scene::{Hit, RayBatch, Segment};
use kaustika_spectra::Spectrum;

/// Pixels of a group.
const PIXELS: u32 = 1024;
/// Splits of one tree; after those it only plays roulette.
const MOST_SPLITS: u32 = 1000;

/// How trees grow.
pub(super) struct Guides<'f> {
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
struct Branch<'a> {
    walk: Walk,
    sampler: Sampler<'a>,
    /// Number of its node.
    node: u32,
    /// Number of its tree.
    tree: u32,
    /// As [`Collision::scattered`].
    scattered: u32,
    /// What its ray goes through.
    medium: Option<MediumId>,
}

/// What is kept of a tree.
struct Tree {
    walk: Walk,
    record: PixelRecord,
    splits: u32,
    measurement: f32,
    /// As [`Feature::Trees`](kaustika_film::Feature::Trees) has them, but for `splits`.
    factor: f32,
    ended: u32,
    longest: u32,
    rays: u32,
}

/// Room to work in.
#[derive(Default)]
pub(super) struct Forest<'a> {
    branches: Vec<Branch<'a>>,
    next: Vec<Branch<'a>>,
    segments: Vec<Segment>,
    shadow_rays: Vec<Segment>,
    lit: Vec<(u32, Spectrum)>,
    batch: RayBatch,
    nodes: Vec<Node>,
    trees: Vec<Tree>,
    bsdf: Bsdf<'a>,
    /// For surfaces that shadow rays pass.
    passed: Bsdf<'a>,
}

/// What a band of pixels gives besides its picture.
#[derive(Default)]
pub(super) struct Harvest {
    pub stats: PassStats,
    pub records: Records,
    /// Grey values of the pixels.
    pub values: Vec<f32>,
}
impl<'a> Forest<'a> {
    /// One sample of every pixel of a band.
    pub(super) fn trace(
        &mut self,
        integrator: &Integrator<'a>,
        guides: &Guides,
        index: u64,
        learns: bool,
        band: &mut PixelBand,
    ) -> Harvest {
        let mut harvest = Harvest::default();
        let pixels = band.width() * band.height();
        for first in (0..pixels).step_by(PIXELS as usize) {
            let group = first..pixels.min(first + PIXELS);
            self.plant(integrator, guides, index, band, group.clone());
            while !self.branches.is_empty() {
                self.grow(integrator, guides, band.wants_features(), &mut harvest.stats);
            }
            let records = learns.then_some(&mut harvest.records);
            sweep(&mut self.nodes, integrator.scene().mode, records);
            self.deliver(integrator, band, group, &mut harvest);
        }
        harvest
    }

    /// Starts the trees of some pixels.
    fn plant(
        &mut self,
        integrator: &Integrator<'a>,
        guides: &Guides,
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
            let measurement = guides.measurements.get(at).copied().unwrap_or(1.0);
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
        guides: &Guides,
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
            self.vertex(integrator, guides, branch, hit.as_ref(), features, stats);
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

    /// Takes a branch on from what its ray met.
    fn vertex(
        &mut self,
        integrator: &Integrator<'a>,
        guides: &Guides,
        mut branch: Branch<'a>,
        hit: Option<&Hit>,
        features: bool,
        stats: &mut PassStats,
    ) {
        let scene = integrator.scene();
        let walk = &mut branch.walk;
        let node = branch.node as usize;
        stats.closest_rays += 1;
        self.trees[branch.tree as usize].rays += 1;
        let (ray, shown) = (walk.segment.ray, integrator.shows(walk.depth));
        if let Some(id) = branch.medium {
            let length = hit.map_or(f32::INFINITY, |hit| hit.t);
            let way = Absorption::along(scene.medium(id), &ray, length, &walk.lambda);
            if integrator.counts(walk.depth) {
                self.nodes[node].found += way.glow;
            }
            self.nodes[node].distance += length;
            if way.t.is_black() {
                return;
            }
            walk.beta *= way.t;
            // What comes through stands in a node of its own.
            let number = self.nodes.len() as u32;
            let hero = walk.lambda.secondary_terminated();
            let through = Node { hero, w: ray.d, weight: way.t, ..Node::copy(branch.node, ray.o) };
            self.nodes.push(through);
            branch.node = number;
        }
        let node = branch.node as usize;
        let Some(hit) = hit else {
            self.nodes[node].distance = f32::INFINITY;
            if shown {
                self.nodes[node].found += integrator.escaped(&ray, &walk.previous, &walk.lambda);
            }
            return;
        };
        let tree = &mut self.trees[branch.tree as usize];
        tree.longest = tree.longest.max(walk.depth);
        let mut surface = scene.geometry.surface(hit, &ray);
        self.nodes[node].distance += surface.t;
        if let (true, Some(id)) = (shown, surface.light) {
            let le = integrator.emitted(id, &surface, &ray, &walk.previous, &walk.lambda);
            self.nodes[node].found += le;
        }
        walk.footprint += walk.spread * surface.t;
        surface.footprint = walk.footprint;

        let wo = -ray.d;
        let ended = walk.lambda.secondary_terminated();
        if !scene.bsdf_into(&surface, wo, &mut walk.lambda, &mut self.bsdf) {
            walk.passages += 1;
            branch.medium = scene.medium_beyond(&surface, ray.d, branch.medium);
            walk.segment = Segment { ray: surface.spawn(ray.d), t_max: f32::INFINITY };
            if walk.passages <= MAX_PASSAGES {
                self.next.push(branch);
            }
            return;
        }
        let bsdf = &self.bsdf;
        self.nodes[node].dispersed = walk.lambda.secondary_terminated() && !ended;
        let tree = &mut self.trees[branch.tree as usize];
        if features && walk.depth == 0 {
            describe(scene, &surface, bsdf, wo, &walk.lambda, &mut tree.record);
        }
        if walk.depth >= integrator.max_depth {
            return;
        }
        let smooth = bsdf.lobes().has(Lobes::SMOOTH);
        let u = branch.sampler.get_vertex();

        // How many copies go on?
        let mut roulette = guides.roulette;
        let mut q = 1.0;
        let cell = smooth.then(|| guides.field.at(surface.p));
        if let Some(cell) = cell {
            let albedo = match guides.keeps_albedo {
                true => mean(bsdf.albedo(wo), &walk.lambda),
                false => 0.0,
            };
            self.nodes[node].met = Some(Met { p: surface.p, albedo });
            if guides.splitting.rule.survival().is_none() {
                let expected = match guides.splitting.rule.learns() {
                    true => cell.expected(wo, albedo),
                    false => None,
                };
                let collision = Collision {
                    weight: mean(walk.beta, &walk.lambda),
                    measurement: tree.measurement,
                    expected,
                    albedo,
                    roughness: bsdf.roughness(),
                    scattered: branch.scattered,
                };
                if let Decision::Copies(factor) = guides.splitting.decide(&collision) {
                    let whole = tree.splits >= MOST_SPLITS || branch.sampler.is_chain();
                    q = if whole { factor.min(1.0) } else { factor };
                    roulette.survival = Survival::None;
                }
            }
        }
        let copies = (q + u[7]) as u32;
        self.nodes[node].inv_q = 1.0 / q;
        tree.splits += copies.saturating_sub(1);
        if walk.depth == 0 {
            tree.factor = q;
        }
        if copies == 0 {
            tree.ended += 1;
            return;
        }

        let n = surface.facing(wo);
        let guide = cell.and_then(|cell| cell.guide(surface.p, is_matte(bsdf).then_some(n)));
        let mixed = MixedBsdf::new(bsdf, guide.as_ref());
        let samples_light = smooth && integrator.counts(walk.depth + 1);
        let (walk, mut sampler) = (branch.walk, Some(branch.sampler));
        for copy in 1..=copies {
            // The last goes on with the branch's own numbers, the others with numbers of theirs.
            let (sampler, u) = match copy == copies {
                true => (sampler.take(), u),
                false => {
                    let mut other = sampler.as_ref().and_then(|s| s.branch(u64::from(copy)));
                    let u = other.as_mut().map_or(u, Sampler::get_vertex);
                    (other, u)
                }
            };
            let number = self.nodes.len() as u32;
            let hero = walk.lambda.secondary_terminated();
            let mut child = Node { hero, ..Node::copy(branch.node, surface.p) };
            if samples_light {
                let at = (u[4], Vec2::new(u[0], u[1]));
                let density = |w, pdf_b| mixed.pdf(w, pdf_b);
                let light = integrator.direct(&surface, bsdf, wo, at, &walk.lambda, density);
                if let Some(light) = light {
                    stats.shadow_rays += 1;
                    tree.rays += 1;
                    child.asked = true;
                    if scene.has_media() {
                        let d = light.segment.ray.d;
                        let medium = scene.medium_beyond(&surface, d, branch.medium);
                        let room = &mut self.passed;
                        let t = transmittance(scene, &light, medium, &walk.lambda, room);
                        child.direct = light.radiance * t;
                    } else {
                        self.shadow_rays.push(light.segment);
                        self.lit.push((number, light.radiance));
                    }
                }
            }
            let drawn = mixed.sample(wo, u[5], Vec2::new(u[2], u[3]), Mode::Radiance);
            if let Some(s) = drawn.filter(|s| !s.bsdf.weight.is_black()) {
                let delta = s.bsdf.lobe.has(Lobes::DELTA);
                child.w = s.bsdf.wi;
                child.weight = s.bsdf.weight;
                let mut next = Walk { depth: walk.depth + 1, ..walk };
                next.beta = walk.beta * s.bsdf.weight * (1.0 / q);
                next.eta_scale *= s.bsdf.eta * s.bsdf.eta;
                match s.bsdf.lobe.has(Lobes::NULL) {
                    // Nothing was there: the light could not be sampled through it either.
                    true => next.previous.delta = true,
                    false => next.previous = Previous { p: surface.p, n, pdf_w: s.bsdf.pdf, delta },
                }
                if smooth && !delta {
                    (child.pdf, child.pdf_bsdf) = (s.bsdf.pdf, s.pdf_bsdf);
                }
                let state = WalkState {
                    beta: next.beta,
                    eta_scale: next.eta_scale,
                    weight: s.bsdf.weight,
                    depth: next.depth,
                };
                let survival = roulette.q(&state);
                if u[6] >= survival {
                    tree.ended += 1;
                } else if let Some(sampler) = sampler {
                    child.survival = survival;
                    child.traced = true;
                    next.beta *= 1.0 / survival;
                    next.segment = Segment { ray: surface.spawn(s.bsdf.wi), t_max: f32::INFINITY };
                    let scattered = branch.scattered + u32::from(!delta);
                    let (node, tree) = (number, branch.tree);
                    let medium = scene.medium_beyond(&surface, s.bsdf.wi, branch.medium);
                    self.next.push(Branch { walk: next, sampler, node, tree, scattered, medium });
                }
            }
            self.nodes.push(child);
        }
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
            let rgb = integrator.rgb(radiance, lambda, &mut harvest.stats);
            let weight = tree.walk.film_weight;
            band.add(x, y, &PixelRecord { rgb, weight, ..tree.record });
            integrator.frame().add_bands(band, [x, y], weight, radiance, lambda);
            let counts = [tree.splits, tree.ended, tree.longest, tree.rays].map(|n| n as f32);
            let [added, ended, longest, rays] = counts;
            band.add_trees(x, y, weight, [tree.factor, added, ended, longest, rays]);
            let grey = mean(radiance, lambda);
            harvest.values.push(if grey.is_finite() { grey } else { 0.0 });
        }
    }
}
