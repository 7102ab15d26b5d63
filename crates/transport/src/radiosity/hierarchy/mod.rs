//! Hierarchical radiosity (Hanrahan, Salzman & Aupperle 1991), with clusters.
//!
//! ```text
//! G_p = Σ over links p←q of F_pq V_pq B_q                          gather            (1)
//! H = G + G of all above;  B = S + ρH at leaves                    push              (2)
//! B = Σ A_c/A B_c over the halves                                  pull              (3)
//! σ² = Σ A_c/A (σ_c² + (B_c - B)²)                                 pull              (4)
//! ```
//!
//! Two nodes exchange light at the level at which that is good enough ([`refine`]). What arrives per
//! area is pushed down undivided, what leaves is pulled up by area. σ is how uneven B is over an element: over a
//! leaf, as far as it is from B of the element above. Clusters carry what they send and
//! get by direction ([`harmonics`]).

mod clusters;
mod harmonics;
mod refine;
mod visible;

use self::clusters::{Cluster, Node, Short};
use self::harmonics::Lobes9;
use self::refine::Bounds;
use super::mesh::{Mesh, NONE};
use super::solve::{Rest, sum};
use super::sources::Sources;
use crate::workers::Workers;
use kaustika_math::Vec3;
use kaustika_scene::Scene;
use kaustika_spectra::Spectrum;

/// How far a hierarchy is refined.
#[derive(Clone, Copy, Debug)]
pub struct Refinement {
    /// ε: power that a link may err by to the smallest element, as a part of all that is sent at first.
    pub error: f32,
    /// No element is divided that is smaller than this.
    pub area: f32,
    /// What iterations leave, as a part of all light.
    pub tolerance: f32,
}

/// Rounds of refining, each with a quarter of the error of the one before and what it found.
const ROUNDS: i32 = 4;
/// Links of each element at most.
const LINKS: usize = 64;
/// Iterations of gathering a round at most.
const ITERATIONS: u32 = 100;

/// Elements or links that are worked on between two looks at whether to go on.
const BETWEEN: usize = 1 << 14;

/// A way by which light goes from `q` to `p`.
#[derive(Clone, Copy, Debug)]
struct Link {
    p: Short,
    q: Short,
    /// F V: the form factor, or what takes its place with clusters, and the visible part.
    f: f32,
    /// What F may be at most, were nothing hidden.
    most: f32,
    /// V.
    v: f32,
    /// δ: what is hidden of one place, and not of another; of p alone, and of both.
    hidden: [f32; 2],
}

/// A mesh under refinement.
pub struct Hierarchy<'m, 'a> {
    scene: &'a Scene,
    mesh: &'m mut Mesh,
    clusters: Vec<Cluster>,
    root: Option<Node>,
    links: Vec<Link>,
    sources: Sources<'a>,
    /// Of the elements: S, B, and what was gathered at them and above.
    source: Vec<Spectrum>,
    radiosity: Vec<Spectrum>,
    irradiance: Vec<Spectrum>,
    /// σ of the elements, mean over the colours.
    spread: Vec<f32>,
    /// Of the clusters: intensity, and irradiance gathered at them and above.
    sent: Vec<Lobes9>,
    got: Vec<Lobes9>,
    /// Of the clusters: the area that faces a direction.
    faces: Vec<Lobes9>,
}

/// What a hierarchy came to.
#[derive(Clone, Debug)]
pub struct Solved {
    /// Irradiance of the leaves, W/m², in their order.
    pub irradiance: Vec<Spectrum>,
    /// What they reflect by it and by lights, W/m²: radiosity without what they emit.
    pub reflected: Vec<Spectrum>,
    /// How many links carry light.
    pub links: usize,
}

impl<'m, 'a> Hierarchy<'m, 'a> {
    /// Over a mesh, whose leaves may be divided further.
    pub fn new(scene: &'a Scene, mesh: &'m mut Mesh, sources: Sources<'a>) -> Hierarchy<'m, 'a> {
        let (clusters, root) = clusters::build(mesh);
        let faces = clusters::faces(&clusters, mesh);
        Hierarchy {
            scene,
            mesh,
            root,
            links: Vec::new(),
            sources,
            source: Vec::new(),
            radiosity: Vec::new(),
            irradiance: Vec::new(),
            spread: Vec::new(),
            sent: vec![Lobes9::default(); clusters.len()],
            got: vec![Lobes9::default(); clusters.len()],
            faces,
            clusters,
        }
    }

    /// Refines and iterates; `None` if cancelled.
    pub fn solve(&mut self, refinement: &Refinement, workers: &Workers) -> Option<Solved> {
        self.add_sources(workers)?;
        self.push_pull();
        let power: f32 = (0..self.mesh.roots as usize)
            .map(|e| self.radiosity[e].average() * self.mesh.elements[e].area)
            .sum();
        for round in 0..ROUNDS {
            let coarser = 4f32.powi(ROUNDS - 1 - round);
            let (last, area) = (refinement.error * power, refinement.area);
            // What a round leaves of the room is for what the light that it found asks for.
            let links = LINKS * (round + 1) as usize / ROUNDS as usize;
            self.refine(&Bounds { error: last * coarser, last, area, links }, workers)?;
            let mut rest = Rest::default();
            for i in 0..ITERATIONS {
                workers.tell(|| {
                    let (links, elements) = (self.links.len(), self.mesh.elements.len());
                    let round = round + 1;
                    format!("round {round} of {ROUNDS}: {elements} elements, {links} links, iteration {i}")
                });
                let before = self.radiosity.clone();
                self.gather(workers)?;
                self.push_pull();
                let (mut change, mut all) = (0.0, 0.0);
                for (e, element) in
                    self.mesh.elements.iter().enumerate().filter(|(_, e)| e.is_leaf())
                {
                    let area = f64::from(element.area);
                    change += area * sum(self.radiosity[e] - before[e]);
                    all += area * sum(self.radiosity[e] - self.source[e]);
                }
                if rest.is_within(change, all, refinement.tolerance) {
                    break;
                }
            }
        }
        let leaves = self.mesh.leaves();
        let irradiance = leaves.iter().map(|&e| self.irradiance[e as usize]).collect();
        let emits = self.sources.emit();
        let reflected = leaves.iter().map(|&e| {
            let emission = self.mesh.elements[e as usize].emission;
            self.radiosity[e as usize] - if emits { emission } else { Spectrum::ZERO }
        });
        let reflected = reflected.collect();
        Some(Solved { irradiance, reflected, links: self.links.len() })
    }

    /// S of elements that are new; `None` if cancelled.
    fn add_sources(&mut self, workers: &Workers) -> Option<()> {
        let first = self.source.len() as u32;
        let new: Vec<u32> = (first..self.mesh.elements.len() as u32).collect();
        for some in new.chunks(BETWEEN) {
            if workers.cancelled() {
                return None;
            }
            self.source.extend(self.sources.of(self.mesh, some));
        }
        self.radiosity.extend(&self.source[first as usize..]);
        self.irradiance.resize(self.source.len(), Spectrum::ZERO);
        self.spread.resize(self.source.len(), 0.0);
        Some(())
    }

    /// (1); `None` if cancelled.
    fn gather(&mut self, workers: &Workers) -> Option<()> {
        self.irradiance.fill(Spectrum::ZERO);
        self.got.fill(Lobes9::default());
        for (i, link) in self.links.iter().enumerate() {
            if i.is_multiple_of(BETWEEN) && workers.cancelled() {
                return None;
            }
            let k = link.f;
            if k == 0.0 {
                continue;
            }
            let (p, q) = (Node::from(link.p), Node::from(link.q));
            let toward = || (self.center(q) - self.center(p)).try_normalize();
            match (p, q) {
                (Node::Element(p), Node::Element(q)) => {
                    self.irradiance[p as usize] += self.radiosity[q as usize] * k;
                }
                (Node::Element(p), Node::Cluster(q)) => {
                    let Some(w) = toward() else { continue };
                    self.irradiance[p as usize] += self.sent[q as usize].value(-w) * k;
                }
                (Node::Cluster(p), Node::Element(q)) => {
                    let Some(w) = toward() else { continue };
                    self.got[p as usize].add_direction(w, self.radiosity[q as usize] * k);
                }
                (Node::Cluster(p), Node::Cluster(q)) => {
                    let Some(w) = toward() else { continue };
                    let intensity = self.sent[q as usize].value(-w);
                    self.got[p as usize].add_direction(w, intensity * k);
                }
            }
        }
        Some(())
    }

    /// (2) to (4).
    fn push_pull(&mut self) {
        for c in (0..self.clusters.len()).rev() {
            let got = self.got[c];
            for child in self.clusters[c].children {
                match child {
                    Node::Cluster(d) => self.got[d as usize].add(&got),
                    Node::Element(e) => {
                        let n = self.mesh.elements[e as usize].normal;
                        self.irradiance[e as usize] += got.over_lobe(n);
                    }
                }
            }
        }
        let elements = &self.mesh.elements;
        for (e, element) in elements.iter().enumerate().filter(|(_, e)| e.children != NONE) {
            let down = self.irradiance[e];
            for half in [element.children, element.children + 1] {
                self.irradiance[half as usize] += down;
            }
        }
        for (e, element) in elements.iter().enumerate().rev() {
            self.radiosity[e] = match element.children {
                NONE => self.source[e] + element.albedo * self.irradiance[e],
                first => {
                    let [a, b] = [first as usize, first as usize + 1];
                    let (x, y) = (elements[a].area, elements[b].area);
                    (self.radiosity[a] * x + self.radiosity[b] * y) / (x + y)
                }
            };
        }
        for c in 0..self.clusters.len() {
            let mut sent = Lobes9::default();
            for child in self.clusters[c].children {
                match child {
                    Node::Cluster(d) => sent.add(&self.sent[d as usize]),
                    Node::Element(e) => {
                        let element = &elements[e as usize];
                        let k = element.area / std::f32::consts::PI;
                        sent.add_lobe(element.normal, self.radiosity[e as usize] * k);
                    }
                }
            }
            self.sent[c] = sent;
        }
        self.pull_spread();
    }

    /// (4).
    fn pull_spread(&mut self) {
        let elements = &self.mesh.elements;
        let off = |a: usize, b: usize| (self.radiosity[a] - self.radiosity[b]).average().abs();
        for (e, element) in elements.iter().enumerate() {
            if e < self.mesh.roots as usize {
                // Nothing is known of what is whole; but what lamps emit is even.
                let emits = if self.sources.emit() { element.emission } else { Spectrum::ZERO };
                self.spread[e] = (self.radiosity[e] - emits).average().abs();
            }
            if element.children != NONE {
                let first = element.children as usize;
                (first..first + 2).for_each(|half| self.spread[half] = off(half, e));
            }
        }
        for (e, element) in elements.iter().enumerate().rev().filter(|(_, e)| !e.is_leaf()) {
            let first = element.children as usize;
            let terms = (first..first + 2).map(|half| {
                let share = elements[half].area / element.area;
                share * (self.spread[half].powi(2) + off(half, e).powi(2))
            });
            self.spread[e] = terms.sum::<f32>().sqrt();
        }
    }

    fn center(&self, node: Node) -> Vec3 {
        match node {
            Node::Element(e) => self.mesh.elements[e as usize].center(),
            Node::Cluster(c) => self.clusters[c as usize].center,
        }
    }

    fn radius(&self, node: Node) -> f32 {
        match node {
            Node::Element(e) => self.mesh.elements[e as usize].radius(),
            Node::Cluster(c) => self.clusters[c as usize].radius,
        }
    }

    fn area(&self, node: Node) -> f32 {
        match node {
            Node::Element(e) => self.mesh.elements[e as usize].area,
            Node::Cluster(c) => self.clusters[c as usize].area,
        }
    }
}
