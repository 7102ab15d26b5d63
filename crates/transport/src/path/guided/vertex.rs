//! What becomes of a branch where its ray ends: emission, roulette and splitting, light asked for,
//! the next directions.

use super::super::integrate::{Integrator, MAX_PASSAGES};
use super::super::walk::{Previous, Walk};
use super::absorption::{Absorption, transmittance};
use super::trace::{Branch, Forest, Growth};
use crate::features::describe;
use crate::guiding::{MixedBsdf, is_matte};
use crate::method::PassStats;
use crate::roulette::{Collision, Decision, Survival, WalkState};
use crate::trees::{Met, Node, mean};
use kaustika_math::Vec2;
use kaustika_sampling::Sampler;
use kaustika_scene::bsdf::{Lobes, Mode};
use kaustika_scene::{Hit, Segment, Surface};

/// Splits of one tree; after those it only plays roulette.
const MOST_SPLITS: u32 = 1000;

impl<'a> Forest<'a> {
    /// Takes a branch on from what its ray met.
    pub(super) fn vertex(
        &mut self,
        integrator: &Integrator<'a>,
        growth: &Growth,
        mut branch: Branch<'a>,
        hit: Option<&Hit>,
        features: bool,
        stats: &mut PassStats,
    ) {
        let scene = integrator.scene();
        stats.closest_rays += 1;
        self.trees[branch.tree as usize].rays += 1;
        let (ray, shown) = (branch.walk.segment.ray, integrator.shows(branch.walk.depth));
        if !self.comes_through(integrator, &mut branch, hit.map_or(f32::INFINITY, |hit| hit.t)) {
            return;
        }
        let walk = &mut branch.walk;
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
        self.scatter(integrator, growth, branch, &surface, stats);
    }

    /// Scatters a branch at a surface whose BSDF is known.
    #[inline]
    fn scatter(
        &mut self,
        integrator: &Integrator<'a>,
        growth: &Growth,
        mut branch: Branch<'a>,
        surface: &Surface,
        stats: &mut PassStats,
    ) {
        let scene = integrator.scene();
        let (bsdf, walk) = (&self.bsdf, branch.walk);
        let (wo, node) = (-walk.segment.ray.d, branch.node as usize);
        let tree = &mut self.trees[branch.tree as usize];
        let smooth = bsdf.lobes().has(Lobes::SMOOTH);
        let u = branch.sampler.get_vertex();

        // How many copies go on?
        let mut roulette = growth.roulette;
        let mut q = 1.0;
        let cell = smooth.then(|| growth.field.at(surface.p));
        if let Some(cell) = cell {
            let albedo = match growth.keeps_albedo {
                true => mean(bsdf.albedo(wo), &walk.lambda),
                false => 0.0,
            };
            self.nodes[node].met = Some(Met { p: surface.p, albedo });
            if growth.splitting.rule.survival().is_none() {
                let expected = match growth.splitting.rule.learns() {
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
                if let Decision::Copies(factor) = growth.splitting.decide(&collision) {
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
        let mut sampler = Some(branch.sampler);
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
                let light = integrator.direct(surface, bsdf, wo, at, &walk.lambda, density);
                if let Some(light) = light {
                    stats.shadow_rays += 1;
                    tree.rays += 1;
                    child.asked = true;
                    if scene.has_media() {
                        let d = light.segment.ray.d;
                        let medium = scene.medium_beyond(surface, d, branch.medium);
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
                    let medium = scene.medium_beyond(surface, s.bsdf.wi, branch.medium);
                    self.next.push(Branch { walk: next, sampler, node, tree, scattered, medium });
                }
            }
            self.nodes.push(child);
        }
    }

    /// Follows a branch for `length` through the medium that it is in; false if nothing of it is
    /// left. What comes through stands in a node of its own.
    #[inline]
    fn comes_through(
        &mut self,
        integrator: &Integrator<'a>,
        branch: &mut Branch<'a>,
        length: f32,
    ) -> bool {
        let Some(id) = branch.medium else { return true };
        let (walk, number) = (&mut branch.walk, self.nodes.len() as u32);
        let (scene, ray) = (integrator.scene(), walk.segment.ray);
        let way = Absorption::along(scene.medium(id), &ray, length, &walk.lambda);
        let node = &mut self.nodes[branch.node as usize];
        node.distance += length;
        if integrator.counts(walk.depth) {
            node.found += way.glow;
        }
        if way.t.is_black() {
            return false;
        }
        walk.beta *= way.t;
        let hero = walk.lambda.secondary_terminated();
        let through = Node { hero, w: ray.d, weight: way.t, ..Node::copy(branch.node, ray.o) };
        self.nodes.push(through);
        branch.node = number;
        true
    }
}
