//! Trees of light paths, many side by side.
//!
//! ```text
//! Φ ≈ β f(ωₒ,ω_c)|cos θ_c| V Wₑ / p_C     where a path arrives, added to the pixel where it shows   (1)
//! n = ⌊q + ξ⌋ copies, each:                                                                    (2)
//!     β ← β f |cos θ|/(p(ω) q)            a direction by the mixture of BSDF and guide
//! x = Φ/(β I_px)                          what is learned: importance, over the pixel's value      (3)
//! ```
//!
//! A vertex is shown to the lens once, before its copies: through a pinhole all would be shown
//! alike. All branches of a group of paths trace their rays as one batch, generation by
//! generation.

use super::emission::{Emission, EmissionRecord};
use crate::frame::Frame;
use crate::guiding::{AnyField, AnyLocal, Expected, LocalDirections, MixedBsdf, is_matte};
use crate::method::PassStats;
use crate::path_space::{LightEnd, MAX_PASSAGES, Splat, Vertex, leave, to_lens};
use crate::roulette::{Collision, Decision, Roulette, Rule, Splitting, Survival, WalkState};
use crate::trees::{Met, Node, Records, hero_for_all, mean, sweep};
use kaustika_math::{Ray, Vec2};
use kaustika_sampling::Sampler;
use kaustika_scene::bsdf::{Lobes, Mode};
use kaustika_scene::{Hit, LightId, LightSelection, RayBatch, Scene, Segment};
use kaustika_spectra::{Spectrum, Wavelengths};
use std::ops::Range;

/// Paths of a group.
pub(super) const PATHS: u32 = 1024;
/// Splits of one tree; after those it only plays roulette.
const MOST_SPLITS: u32 = 1000;

/// How trees grow.
pub(super) struct Grower<'a, 'f> {
    pub scene: &'a Scene,
    pub frame: &'a Frame,
    /// Lights by power.
    pub table: &'f LightSelection,
    /// Lights as learned, if paths are guided.
    pub emission: &'f Emission,
    /// What is known of importance.
    pub field: &'f AnyField,
    /// Decisions of the rule, if it splits.
    pub splitting: Splitting,
    /// Roulette after the bounce, where the rule is of that kind or knows nothing.
    pub roulette: Roulette,
    /// I: what a path contributes on average, as the rule takes it.
    pub measurement: f32,
    /// I_px, row by row; empty while nothing is known, and then nothing is learned.
    pub pixels: &'f [f32],
    pub max_depth: usize,
    pub only_depth: Option<usize>,
    /// One over the paths of a pass.
    pub scale: f32,
}

impl Grower<'_, '_> {
    /// 1/I_px where a connection shows; `None` if it shows nowhere.
    fn importance(&self, film: Vec2) -> Option<f32> {
        let [x0, y0, x1, y1] = self.frame.region;
        let radius = self.frame.filter_desc.radius();
        let place = |at: f32, radius: f32, from: u32, to: u32| {
            let reached = at + radius >= from as f32 && at - radius <= to as f32;
            reached.then(|| (at.max(0.0) as u32).clamp(from, to - 1) - from)
        };
        let (x, y) = (place(film.x, radius.x, x0, x1)?, place(film.y, radius.y, y0, y1)?);
        let of_pixel = self.pixels.get(y as usize * (x1 - x0) as usize + x as usize);
        Some(of_pixel.map_or(1.0, |i| 1.0 / i))
    }

    /// q at a vertex; `None` if the rule does not decide here.
    fn copies(
        &self,
        weight: f32,
        expected: Option<Expected>,
        at: &Vertex,
        rho: f32,
    ) -> Option<f32> {
        let expected = match self.splitting.rule {
            // A pixel sees next to none of the paths: its variance is their second moment.
            Rule::Efficiency => expected.map(|e| Expected { mean: 0.0, ..e }),
            _ => expected,
        };
        let decision = self.splitting.decide(&Collision {
            weight,
            measurement: self.measurement,
            expected,
            albedo: rho,
            roughness: at.bsdf.roughness(),
            // The light did.
            scattered: 1,
        });
        match decision {
            Decision::Copies(q) => Some(q),
            Decision::Unknown => None,
        }
    }
}

/// A ray to be traced.
struct Branch<'a> {
    ray: Ray,
    /// What it carries.
    beta: Spectrum,
    /// The same without what the path began with.
    throughput: Spectrum,
    lambda: Wavelengths,
    /// Surfaces met.
    depth: usize,
    /// Passages through interfaces since.
    passages: u32,
    sampler: Sampler<'a>,
    /// Number of its node.
    node: u32,
    /// Number of its tree.
    tree: u32,
}

/// What is kept of a tree.
struct Tree {
    light: LightId,
    numbers: [Vec2; 2],
    beta: Spectrum,
    lambda: Wavelengths,
    splits: u32,
}

/// A vertex that waits to be shown to the lens.
struct Shown {
    node: u32,
    /// Of one path for each picture, for a unit of arriving flux.
    value: Spectrum,
    beta: Spectrum,
    importance: f32,
    dispersed: bool,
    film: Vec2,
    lambda: Wavelengths,
}

/// Room to work in.
#[derive(Default)]
pub(super) struct Forest<'a> {
    branches: Vec<Branch<'a>>,
    next: Vec<Branch<'a>>,
    segments: Vec<Segment>,
    shadow_rays: Vec<Segment>,
    shown: Vec<Shown>,
    batch: RayBatch,
    nodes: Vec<Node>,
    trees: Vec<Tree>,
    vertex: Vertex<'a>,
}

/// What a band of paths gives besides its splats.
#[derive(Default)]
pub(super) struct Harvest {
    pub stats: PassStats,
    pub records: Records,
    pub emitted: Vec<EmissionRecord>,
}

impl<'a> Forest<'a> {
    /// The paths of some pixels, in which they need not show.
    pub(super) fn trace(
        &mut self,
        grower: &Grower<'a, '_>,
        index: u64,
        pixels: impl Iterator<Item = [u32; 2]>,
        learns: bool,
        splats: &mut Vec<Splat>,
        harvest: &mut Harvest,
    ) {
        self.nodes.clear();
        self.trees.clear();
        pixels.for_each(|pixel| self.plant(grower, pixel, index));
        while !self.branches.is_empty() {
            self.grow(grower, splats, &mut harvest.stats);
        }
        if !learns {
            return;
        }
        sweep(&mut self.nodes, grower.scene.mode, Some(&mut harvest.records));
        let roots = 0..self.trees.len();
        for (tree, root) in self.trees.iter().zip(&self.nodes[roots]) {
            let contribution = mean(tree.beta * root.value(), &tree.lambda);
            let (light, numbers) = (tree.light, tree.numbers);
            harvest.emitted.push(EmissionRecord { light, numbers, contribution });
        }
    }

    /// Starts a tree.
    fn plant(&mut self, grower: &Grower<'a, '_>, pixel: [u32; 2], index: u64) {
        let mut sampler = grower.frame.sampler.start(pixel, index);
        let u = sampler.get_2d();
        let lambda = Wavelengths::sample_for(grower.scene.mode, u.x);
        let numbers = sampler.get_vertex();
        let Some((choice, v)) = grower.emission.sample(grower.table, &numbers) else { return };
        let emitted = LightEnd::emit_chosen(grower.scene, grower.table, &choice, v, &lambda, u.y);
        let Some((_, start)) = emitted else { return };
        let (beta, tree) = (start.beta, self.trees.len() as u32);
        let numbers = [choice.u, v];
        self.nodes.push(Node::root(start.ray.o, start.ray.d));
        self.trees.push(Tree { light: choice.light, numbers, beta, lambda, splits: 0 });
        self.branches.push(Branch {
            ray: start.ray,
            beta,
            throughput: Spectrum::ONE,
            lambda,
            depth: 0,
            passages: 0,
            sampler,
            node: tree,
            tree,
        });
    }

    /// Traces a generation of rays.
    fn grow(&mut self, grower: &Grower<'a, '_>, splats: &mut Vec<Splat>, stats: &mut PassStats) {
        self.segments.clear();
        let segment = |b: &Branch| Segment { ray: b.ray, t_max: f32::INFINITY };
        self.segments.extend(self.branches.iter().map(segment));
        grower.scene.hit_all(&self.segments, &mut self.batch);
        self.shadow_rays.clear();
        self.shown.clear();
        let mut branches = std::mem::take(&mut self.branches);
        stats.closest_rays += branches.len() as u64;
        for (i, branch) in branches.drain(..).enumerate() {
            let hit = self.batch.hit(i);
            self.vertex(grower, branch, hit.as_ref());
        }
        stats.shadow_rays += self.shadow_rays.len() as u64;
        grower.scene.occluded_all(&self.shadow_rays, &mut self.batch);
        for (s, &occluded) in self.shown.iter().zip(&self.batch.occluded) {
            if !occluded {
                let value = s.value * grower.scale;
                let found = value * s.importance; // (3)
                self.nodes[s.node as usize].found =
                    if s.dispersed { hero_for_all(found) } else { found };
                let sound = leave(grower.frame, None, s.beta * value, s.film, &s.lambda, splats);
                stats.bad_samples += u64::from(!sound);
            }
        }
        // The memory of this generation is the next but one's.
        self.branches = std::mem::replace(&mut self.next, branches);
    }

    /// Takes a branch on from what its ray met.
    fn vertex(&mut self, grower: &Grower<'a, '_>, mut branch: Branch<'a>, hit: Option<&Hit>) {
        let scene = grower.scene;
        let node = branch.node as usize;
        let Some(hit) = hit else {
            self.nodes[node].distance = f32::INFINITY;
            return;
        };
        let surface = scene.geometry.surface(hit, &branch.ray);
        self.nodes[node].distance += surface.t;
        let wo = -branch.ray.d;
        let ended = branch.lambda.secondary_terminated();
        if !scene.bsdf_into(&surface, wo, &mut branch.lambda, &mut self.vertex.bsdf) {
            branch.passages += 1;
            branch.ray = surface.spawn(branch.ray.d);
            if branch.passages <= MAX_PASSAGES {
                self.next.push(branch);
            }
            return;
        }
        let dispersed = branch.lambda.secondary_terminated() && !ended;
        self.nodes[node].dispersed = dispersed;
        branch.depth += 1;
        branch.passages = 0;
        let u = branch.sampler.get_vertex();
        let v = &mut self.vertex;
        (v.surface, v.wo, v.lambda) = (surface, wo, branch.lambda);
        (v.beta, v.u) = (Spectrum::ONE, [u[0], u[1], u[4]]);
        if grower.only_depth.is_none_or(|d| d == branch.depth) {
            self.show(grower, &branch, dispersed);
        }
        if branch.depth < grower.max_depth {
            self.scatter(grower, branch, &u);
        }
    }

    /// (1), but for what may be in the way.
    fn show(&mut self, grower: &Grower<'a, '_>, branch: &Branch, dispersed: bool) {
        if !self.vertex.connects() {
            return;
        }
        let Some(c) = to_lens(grower.scene, &self.vertex) else { return };
        let film = c.end.film;
        let Some(importance) = grower.importance(film) else { return };
        self.nodes[branch.node as usize].asked = true;
        self.shadow_rays.push(c.segment);
        self.shown.push(Shown {
            node: branch.node,
            value: c.value,
            beta: branch.beta,
            importance,
            dispersed,
            film,
            lambda: branch.lambda,
        });
    }

    /// (2)
    fn scatter(&mut self, grower: &Grower<'a, '_>, branch: Branch<'a>, u: &[f32; 8]) {
        let Vertex { surface, wo, bsdf, .. } = &self.vertex;
        let (wo, node) = (*wo, branch.node as usize);
        let smooth = bsdf.lobes().has(Lobes::SMOOTH);
        let tree = &mut self.trees[branch.tree as usize];
        let mut roulette = grower.roulette;
        let (mut q, mut guide) = (1.0, None);
        if smooth {
            let splits = grower.splitting.rule.survival().is_none();
            let albedo = match splits {
                true => mean(bsdf.albedo(wo), &branch.lambda),
                false => 0.0,
            };
            self.nodes[node].met = Some(Met { p: surface.p, albedo });
            let expected;
            (guide, expected) = grower.field.at(surface.p, wo, albedo);
            if let (Some(g), true) = (&mut guide, is_matte(bsdf)) {
                g.directions = g.directions.towards(surface.facing(wo));
            }
            let weight = mean(branch.beta, &branch.lambda);
            let decided = match splits {
                true => grower.copies(weight, expected, &self.vertex, albedo),
                false => None,
            };
            if let Some(factor) = decided {
                let whole = tree.splits >= MOST_SPLITS || branch.sampler.is_chain();
                q = if whole { factor.min(1.0) } else { factor };
                roulette.survival = Survival::None;
            }
        }
        let copies = (q + u[7]) as u32;
        self.nodes[node].inv_q = 1.0 / q;
        tree.splits += copies.saturating_sub(1);

        let mixed: MixedBsdf<AnyLocal> = MixedBsdf::new(bsdf, guide.as_ref());
        let Branch { lambda, depth, .. } = branch;
        let mut sampler = Some(branch.sampler);
        for copy in 1..=copies {
            // The last goes on with the branch's own numbers, the others with numbers of theirs.
            let (sampler, u) = match copy == copies {
                true => (sampler.take(), *u),
                false => {
                    let mut other = sampler.as_ref().and_then(|s| s.branch(u64::from(copy)));
                    let u = other.as_mut().map_or(*u, Sampler::get_vertex);
                    (other, u)
                }
            };
            let number = self.nodes.len() as u32;
            let hero = lambda.secondary_terminated();
            let mut child = Node { hero, ..Node::copy(branch.node, surface.p) };
            let drawn = mixed.sample(wo, u[5], Vec2::new(u[2], u[3]), Mode::Importance);
            if let Some(s) = drawn.filter(|s| !s.bsdf.weight.is_black()) {
                (child.w, child.weight) = (s.bsdf.wi, s.bsdf.weight);
                if smooth && !s.bsdf.lobe.has(Lobes::DELTA) && !s.bsdf.lobe.has(Lobes::NULL) {
                    (child.pdf, child.pdf_bsdf) = (s.bsdf.pdf, s.pdf_bsdf);
                }
                let factor = s.bsdf.weight * (1.0 / q);
                let (beta, throughput) = (branch.beta * factor, branch.throughput * factor);
                let state = WalkState {
                    beta: throughput,
                    eta_scale: 1.0,
                    weight: s.bsdf.weight,
                    depth: depth as u32,
                };
                let survival = roulette.q(&state);
                if let (true, Some(sampler)) = (u[6] < survival, sampler) {
                    (child.survival, child.traced) = (survival, true);
                    self.next.push(Branch {
                        ray: surface.spawn(s.bsdf.wi),
                        beta: beta * (1.0 / survival),
                        throughput: throughput * (1.0 / survival),
                        lambda,
                        depth,
                        passages: 0,
                        sampler,
                        node: number,
                        tree: branch.tree,
                    });
                }
            }
            self.nodes.push(child);
        }
    }
}

/// Groups of the pixels of a band.
pub(super) fn groups(pixels: u32) -> impl Iterator<Item = Range<u32>> {
    (0..pixels).step_by(PATHS as usize).map(move |first| first..pixels.min(first + PATHS))
}
