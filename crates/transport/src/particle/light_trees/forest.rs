//! Trees of light paths, many side by side.
//!
//! ```text
//! n = ⌊q + ξ⌋ copies, each:                                                                    (1)
//!     β ← β f |cos θ|/(p(ω) q)            a direction by the mixture of BSDF and guide
//! x = Φ/β                                 what is learned: importance, of a unit of arriving flux   (2)
//! ```
//!
//! All branches of a group of paths trace their rays as one batch, generation by generation. What
//! the light is for, where it arrives, is a [`Receiver`]'s: it is taken in once, before the copies.

use super::emission::{Emission, EmissionRecord, Unguided};
use crate::guiding::{AnyField, Expected, MixedBsdf, is_matte};
use crate::method::PassStats;
use crate::path_space::{MAX_PASSAGES, Vertex};
use crate::roulette::{Collision, Decision, Roulette, Rule, Splitting, Survival, WalkState};
use crate::trees::{Met, Node, RAY, Records, mean, sweep};
use kaustika_math::{Ray, Vec2};
use kaustika_sampling::Sampler;
use kaustika_scene::bsdf::{Lobes, Mode};
use kaustika_scene::{Hit, LightId, RayBatch, Scene, Segment};
use kaustika_spectra::{ColorMode, Spectrum, Wavelengths};

/// Paths of a group.
pub(in crate::particle) const PATHS: u32 = 1024;
/// Splits of one tree; after those it only plays roulette.
const MOST_SPLITS: u32 = 1000;

/// How trees grow.
pub(in crate::particle) struct Grower<'a, 'f> {
    pub scene: &'a Scene,
    /// Lights as nobody has learned of them.
    pub unguided: &'f dyn Unguided,
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
    pub max_depth: usize,
}

/// Light where something scatters it.
pub(in crate::particle) struct Arriving {
    /// Number of the node whose ray brought it.
    pub node: u32,
    /// Flux over the density of the path.
    pub beta: Spectrum,
    /// Surfaces met, this one included.
    pub depth: usize,
    /// True if a matte surface has scattered it before.
    pub indirect: bool,
    /// True if its secondary wavelengths ended here.
    pub dispersed: bool,
}

/// What becomes of light that was taken in.
pub(in crate::particle) struct Onward {
    /// The lobes that scatter it.
    pub lobes: Lobes,
    /// True if the surface counts as matte.
    pub matte: bool,
}

/// What light is for, where it arrives.
pub(in crate::particle) trait Receiver<'a> {
    /// Takes it in.
    fn arrive(&mut self, at: &Vertex<'a>, light: &Arriving, node: &mut Node) -> Onward;

    /// All rays of a generation have arrived.
    fn settle(&mut self, scene: &Scene, nodes: &mut [Node], stats: &mut PassStats) {
        let _ = (scene, nodes, stats);
    }
}

impl Grower<'_, '_> {
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
            Rule::Efficiency => expected.map(|e| Expected { mean: 0.0, variance: e.moment, ..e }),
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
    /// True if a matte surface has scattered it.
    indirect: bool,
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

/// Trees as they have grown, their roots first.
#[derive(Default)]
pub(in crate::particle) struct Grove {
    pub nodes: Vec<Node>,
    trees: Vec<Tree>,
}

impl Grove {
    /// What is to be learned of it, once its nodes know what was found.
    pub fn harvest(
        &mut self,
        mode: ColorMode,
        records: &mut Records,
        emitted: &mut Vec<EmissionRecord>,
    ) {
        sweep(&mut self.nodes, mode, Some(records));
        for (tree, root) in self.trees.iter().zip(&self.nodes) {
            let contribution = mean(tree.beta * root.value(), &tree.lambda);
            let (light, numbers) = (tree.light, tree.numbers);
            let cost = RAY + root.costs * root.inv_q;
            emitted.push(EmissionRecord { light, numbers, contribution, cost });
        }
    }
}

/// How a path begins: its numbers, its wavelengths and its time.
pub(in crate::particle) type Beginning<'a> = (Sampler<'a>, Wavelengths, f32);

/// Room to work in.
#[derive(Default)]
pub(in crate::particle) struct Forest<'a> {
    /// What has grown.
    pub grove: Grove,
    branches: Vec<Branch<'a>>,
    next: Vec<Branch<'a>>,
    segments: Vec<Segment>,
    batch: RayBatch,
    vertex: Vertex<'a>,
}

impl<'a> Forest<'a> {
    /// Grows a tree from each beginning.
    pub fn trace(
        &mut self,
        grower: &Grower<'a, '_>,
        beginnings: impl Iterator<Item = Beginning<'a>>,
        receiver: &mut impl Receiver<'a>,
        stats: &mut PassStats,
    ) {
        self.grove.nodes.clear();
        self.grove.trees.clear();
        beginnings.for_each(|beginning| self.plant(grower, beginning));
        while !self.branches.is_empty() {
            self.grow(grower, receiver, stats);
        }
    }

    /// Starts a tree.
    fn plant(&mut self, grower: &Grower<'a, '_>, (mut sampler, lambda, time): Beginning<'a>) {
        let Some(start) = grower.emission.sample(grower.unguided, &sampler.get_vertex()) else {
            return;
        };
        let (light, numbers) = (start.light, start.numbers);
        let emitter = grower.scene.light(light);
        let Some(mut e) = emitter.sample_le(grower.scene, numbers[0], numbers[1], &lambda) else {
            return;
        };
        e.ray.time = time;
        let beta = e.le * (e.cos / (start.p * e.pdf_a * e.pdf_w));
        if beta.is_black() {
            return;
        }
        let tree = self.grove.trees.len() as u32;
        self.grove.nodes.push(Node::root(e.ray.o, e.ray.d));
        self.grove.trees.push(Tree { light, numbers, beta, lambda, splits: 0 });
        self.branches.push(Branch {
            ray: e.ray,
            beta,
            throughput: Spectrum::ONE,
            lambda,
            depth: 0,
            indirect: false,
            passages: 0,
            sampler,
            node: tree,
            tree,
        });
    }

    /// Traces a generation of rays.
    fn grow(
        &mut self,
        grower: &Grower<'a, '_>,
        receiver: &mut impl Receiver<'a>,
        stats: &mut PassStats,
    ) {
        self.segments.clear();
        let segment = |b: &Branch| Segment { ray: b.ray, t_max: f32::INFINITY };
        self.segments.extend(self.branches.iter().map(segment));
        grower.scene.hit_all(&self.segments, &mut self.batch);
        let mut branches = std::mem::take(&mut self.branches);
        stats.closest_rays += branches.len() as u64;
        for (i, branch) in branches.drain(..).enumerate() {
            let hit = self.batch.hit(i);
            self.vertex(grower, branch, hit.as_ref(), receiver);
        }
        receiver.settle(grower.scene, &mut self.grove.nodes, stats);
        // The memory of this generation is the next but one's.
        self.branches = std::mem::replace(&mut self.next, branches);
    }

    /// Takes a branch on from what its ray met.
    fn vertex(
        &mut self,
        grower: &Grower<'a, '_>,
        mut branch: Branch<'a>,
        hit: Option<&Hit>,
        receiver: &mut impl Receiver<'a>,
    ) {
        let scene = grower.scene;
        let node = branch.node as usize;
        let Some(hit) = hit else {
            self.grove.nodes[node].distance = f32::INFINITY;
            return;
        };
        let surface = scene.geometry.surface(hit, &branch.ray);
        self.grove.nodes[node].distance += surface.t;
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
        self.grove.nodes[node].dispersed = dispersed;
        branch.depth += 1;
        branch.passages = 0;
        let u = branch.sampler.get_vertex();
        let v = &mut self.vertex;
        (v.surface, v.wo, v.lambda) = (surface, wo, branch.lambda);
        (v.beta, v.u) = (Spectrum::ONE, [u[0], u[1], u[4]]);
        let light = Arriving {
            node: branch.node,
            beta: branch.beta,
            depth: branch.depth,
            indirect: branch.indirect,
            dispersed,
        };
        let on = receiver.arrive(v, &light, &mut self.grove.nodes[node]);
        if branch.depth < grower.max_depth && !on.lobes.is_empty() {
            self.scatter(grower, branch, &u, &on);
        }
    }

    /// (1)
    fn scatter(&mut self, grower: &Grower<'a, '_>, branch: Branch<'a>, u: &[f32; 8], on: &Onward) {
        let Vertex { surface, wo, bsdf, .. } = &self.vertex;
        let (wo, node) = (*wo, branch.node as usize);
        let smooth = (bsdf.lobes() & on.lobes).has(Lobes::SMOOTH);
        let tree = &mut self.grove.trees[branch.tree as usize];
        let mut roulette = grower.roulette;
        let mut q = 1.0;
        let cell = smooth.then(|| grower.field.at(surface.p));
        if let Some(cell) = cell {
            let splits = grower.splitting.rule.survival().is_none();
            let albedo = match splits {
                true => mean(bsdf.albedo(wo), &branch.lambda),
                false => 0.0,
            };
            self.grove.nodes[node].met = Some(Met { p: surface.p, albedo });
            let weight = mean(branch.beta, &branch.lambda);
            let decided = match splits {
                true => grower.copies(weight, cell.expected(wo, albedo), &self.vertex, albedo),
                false => None,
            };
            if let Some(factor) = decided {
                let whole = tree.splits >= MOST_SPLITS || branch.sampler.is_chain();
                q = if whole { factor.min(1.0) } else { factor };
                roulette.survival = Survival::None;
            }
        }
        let copies = (q + u[7]) as u32;
        self.grove.nodes[node].inv_q = 1.0 / q;
        tree.splits += copies.saturating_sub(1);

        if copies == 0 {
            return;
        }

        let matte = is_matte(bsdf) && on.lobes.has(Lobes::DIFFUSE_REFLECTION);
        let matte = matte.then(|| surface.facing(wo));
        let guide = cell.and_then(|cell| cell.guide(surface.p, matte));
        let mixed = MixedBsdf::new(bsdf, guide.as_ref()).of(on.lobes);
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
            let number = self.grove.nodes.len() as u32;
            let hero = lambda.secondary_terminated();
            let mut child = Node { hero, ..Node::copy(branch.node, surface.p) };
            let drawn = mixed.sample(wo, u[5], Vec2::new(u[2], u[3]), Mode::Importance);
            if let Some(s) = drawn.filter(|s| !s.bsdf.weight.is_black()) {
                (child.w, child.weight) = (s.bsdf.wi, s.bsdf.weight);
                let spread = !s.bsdf.lobe.has(Lobes::DELTA) && !s.bsdf.lobe.has(Lobes::NULL);
                if smooth && spread {
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
                        indirect: branch.indirect || (on.matte && spread),
                        passages: 0,
                        sampler,
                        node: number,
                        tree: branch.tree,
                    });
                }
            }
            self.grove.nodes.push(child);
        }
    }
}
