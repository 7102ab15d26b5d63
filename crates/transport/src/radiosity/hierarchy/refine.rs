//! Where nodes are linked.
//!
//! ```text
//! P = A_p F_pq B_q                                power that may be carried         (4)
//! κ = (r_p + r_q)/d, at most 1                    how uneven it is                  (5)
//! δ = 4V(1 - V), at least 1/2(n+1) after n rays                                      (6)
//! link if P max(Vκ, δ) ≤ ε, or nothing can be divided                               (7)
//! ```
//!
//! More rays ask where few could not tell: those that all agree, of a link that is otherwise good enough. Or
//! every link above some power would be refined for the rays' sake, at every level, whatever its κ.
//!
//! (7) is brightness-weighted refinement (Hanrahan et al. 1991): what is dark, small or far is linked
//! coarsely. (5) lets even light through that is strong; (6) goes on where something is partly in
//! the way. Of the two nodes the larger is divided. F between elements is Lambert's formula from
//! points of p; between an element and a cluster, or two, light goes from middle to middle. A link
//! that is refined is taken away, or its light would arrive twice.

use super::{Hierarchy, Link, Node};
use crate::radiosity::form_factor::polygon::point_to_triangle;
use crate::radiosity::mesh::{Element, NONE, Point};
use crate::radiosity::points::{r2, rotated};
use crate::workers::Workers;
use kaustika_math::{Vec2, Vec3, mix_bits};
use kaustika_sampling::hash::{combine, halves, unit};
use kaustika_scene::RayBatch;
use rayon::prelude::*;
use std::f32::consts::PI;

/// Links at most: beyond, coarse ones stay.
const MOST_LINKS: usize = 1 << 26;
/// Rays that ask what is between two nodes.
const RAYS: (f32, f32) = (4.0, 32.0);
/// At most, where these all agree.
const MORE_RAYS: f32 = 512.0;
/// Attempts to find points that face each other, for each ray.
const ATTEMPTS: u32 = 4;

impl Hierarchy<'_, '_> {
    /// Refines all links until each errs by no more than `error`, or elements are no larger than
    /// `area`. `None` if cancelled.
    pub(super) fn refine(&mut self, error: f32, area: f32, workers: &Workers) -> Option<()> {
        let mut links = std::mem::take(&mut self.links);
        if let (Some(root), true) = (self.root, links.is_empty()) {
            links.extend(self.estimate((root, root), error));
        }
        while !links.is_empty() {
            if workers.cancelled() {
                return None;
            }
            workers.tell(|| {
                let elements = self.mesh.elements.len();
                let (made, asked) = (self.links.len(), links.len());
                format!("refining: {elements} elements, {made} links, {asked} in question")
            });
            // Which are good enough?
            let power: Vec<f32> = links
                .par_iter()
                .map(|l| self.sent_over(l.p.into(), l.q.into()) * l.doubt)
                .collect();
            let mut pairs = Vec::new();
            let mut divided = Vec::new();
            let mut coarse = Vec::new();
            for (link, power) in links.into_iter().zip(power) {
                let full = self.links.len() + coarse.len() + pairs.len() > MOST_LINKS;
                if power <= error || full {
                    self.links.push(link); // (7)
                    continue;
                }
                match self.larger(&link, area) {
                    Some(node) => {
                        if let Node::Element(e) = node
                            && self.mesh.elements[e as usize].children == NONE
                        {
                            divided.push(e);
                        }
                        coarse.push((link, node));
                    }
                    None => self.links.push(link),
                }
            }
            divided.sort_unstable();
            divided.dedup();
            self.mesh.divide(self.scene, &divided);
            self.add_sources();
            for e in divided {
                // Until light arrives by finer links.
                let b = self.radiosity[e as usize];
                let first = self.mesh.elements[e as usize].children as usize;
                self.radiosity[first..first + 2].fill(b);
            }
            for (link, node) in coarse {
                self.parts(&link, node, &mut pairs);
            }
            let pairs_of_light = pairs.into_par_iter().filter(|(p, _)| self.receives(*p));
            links = pairs_of_light.filter_map(|pair| self.estimate(pair, error)).collect();
        }
        Some(())
    }

    /// A_p B_q of (4), from what is sent by now. What a cluster sends may go in other directions than
    /// from middle to middle, the more so the nearer the two are.
    fn sent_over(&self, p: Node, q: Node) -> f32 {
        let sent = match q {
            Node::Element(q) => self.radiosity[q as usize].average(),
            Node::Cluster(c) => {
                let w = (self.center(p) - self.center(q)).try_normalize().unwrap_or(Vec3::Z);
                let sent = &self.sent[c as usize];
                let ahead = sent.value(w).average();
                ahead.max(self.uneven(p, q) * sent.most().average())
            }
        };
        self.area(p) * sent
    }

    /// The node to divide: the larger one that can be.
    fn larger(&self, link: &Link, area: f32) -> Option<Node> {
        let can = |node: Node| match node {
            Node::Cluster(_) => true,
            Node::Element(e) => {
                let element = &self.mesh.elements[e as usize];
                element.children != NONE || element.area > area && !element.is_black()
            }
        };
        let (p, q) = (Node::from(link.p), Node::from(link.q));
        let order = if self.radius(p) >= self.radius(q) { [p, q] } else { [q, p] };
        order.into_iter().find(|node| can(*node))
    }

    /// The pairs that take the place of a link whose `node` is divided.
    fn parts(&self, link: &Link, node: Node, pairs: &mut Vec<(Node, Node)>) {
        let children = match node {
            Node::Cluster(c) => self.clusters[c as usize].children,
            Node::Element(e) => {
                let first = self.mesh.elements[e as usize].children;
                [Node::Element(first), Node::Element(first + 1)]
            }
        };
        let (p, q) = (Node::from(link.p), Node::from(link.q));
        match (p == q, p == node) {
            // A cluster with itself. Flat elements do not see themselves.
            (true, _) => {
                let [a, b] = children;
                pairs.extend([(a, b), (b, a)]);
                let of_itself = children.into_iter().filter(|c| matches!(c, Node::Cluster(_)));
                pairs.extend(of_itself.map(|c| (c, c)));
            }
            (false, true) => pairs.extend(children.map(|c| (c, q))),
            (false, false) => pairs.extend(children.map(|c| (p, c))),
        }
    }

    fn receives(&self, p: Node) -> bool {
        match p {
            Node::Element(e) => !self.mesh.elements[e as usize].albedo.is_black(),
            Node::Cluster(_) => true,
        }
    }

    /// The link between two nodes, if they can see each other.
    fn estimate(&self, (p, q): (Node, Node), error: f32) -> Option<Link> {
        let d = self.center(q) - self.center(p);
        let uneven = self.uneven(p, q);
        let (f, most) = match (p, q) {
            (Node::Element(p), Node::Element(q)) => {
                let f = self.between_elements(p, q, uneven);
                (f, f)
            }
            _ => self.between_middles(p, q, d, uneven),
        };
        if most <= 0.0 {
            return None;
        }
        if p == q || uneven >= 1.0 && self.is_cluster(p, q) {
            // What overlaps is not worth asking: it is refined if it matters at all.
            return Some(Link { p: p.into(), q: q.into(), f, doubt: most });
        }
        let power = self.sent_over(p, q) * most;
        let part = power / error.max(f32::MIN_POSITIVE);
        let mut rays = (0.25 * part).clamp(RAYS.0, RAYS.1);
        let (mut v, mut asked) = self.visible(p, q, rays as u32);
        let agree = |v: f32| v == 0.0 || v == 1.0;
        // (6) of n rays that agree is below 1/part from n of part/2 on.
        let needed = 0.5 * part;
        if agree(v) && v * uneven * part <= 1.0 && rays < needed && needed < MORE_RAYS {
            rays = needed.ceil();
            (v, asked) = self.visible(p, q, rays as u32);
        }
        let hidden = (4.0 * v * (1.0 - v)).max(0.5 / (asked + 1) as f32);
        let doubt = most * (v * uneven).max(hidden); // (6)
        Some(Link { p: p.into(), q: q.into(), f: f * v, doubt })
    }

    /// (5).
    fn uneven(&self, p: Node, q: Node) -> f32 {
        let reach = self.radius(p) + self.radius(q);
        let distance = (self.center(q) - self.center(p)).length();
        if distance > reach { reach / distance } else { 1.0 }
    }

    fn is_cluster(&self, p: Node, q: Node) -> bool {
        matches!(p, Node::Cluster(_)) || matches!(q, Node::Cluster(_))
    }

    /// F from one element to another, if nothing is between.
    fn between_elements(&self, p: u32, q: u32, uneven: f32) -> f32 {
        let (p, q) = (&self.mesh.elements[p as usize], &self.mesh.elements[q as usize]);
        let behind = |a: &Element, b: &Element| {
            let slack = 1e-5 * (a.area.sqrt() + b.area.sqrt());
            b.corners.iter().all(|c| a.normal.dot(*c - a.corners[0]) <= slack)
        };
        if behind(p, q) || behind(q, p) {
            return 0.0;
        }
        let from = |b: [f32; 3]| {
            let x = p.corners[0] * b[0] + p.corners[1] * b[1] + p.corners[2] * b[2];
            match q.normal.dot(x - q.corners[0]) > 0.0 {
                true => point_to_triangle(x, p.normal, &q.corners) as f32,
                false => 0.0,
            }
        };
        // The nearer, the less even: parts of p, of which each is asked in its middle.
        let n = match uneven {
            x if x < 0.25 => 1,
            x if x < 0.6 => 2,
            x if x < 1.0 => 4,
            _ => 8,
        };
        let sum: f32 = middles(n).map(from).sum();
        sum / (n * n) as f32
    }

    /// What takes the place of F where a cluster is one of two, if nothing is between, and what it
    /// may be at most: from middle to middle, no nearer than a cluster is wide, and sides may turn
    /// as far as the other node is wide.
    fn between_middles(&self, p: Node, q: Node, d: Vec3, uneven: f32) -> (f32, f32) {
        let wide = |node: Node| match node {
            Node::Cluster(_) => self.radius(node),
            Node::Element(_) => 0.0,
        };
        let d2 = d.length_squared().max(wide(p).max(wide(q)).powi(2)).max(f32::MIN_POSITIVE);
        let cosines = |node: Node, w: Vec3| match node {
            Node::Cluster(_) => (1.0, 1.0),
            Node::Element(e) => {
                let n = self.mesh.elements[e as usize].normal;
                let cos = w.try_normalize().map_or(0.0, |w| n.dot(w));
                (cos.max(0.0), (cos + uneven).clamp(0.0, 1.0))
            }
        };
        let (of_p, most_p) = cosines(p, d);
        let (of_q, most_q) = cosines(q, -d);
        let sent = match q {
            Node::Element(_) => self.area(q) / PI,
            Node::Cluster(_) => 1.0,
        };
        (of_p * of_q * sent / d2, most_p * most_q * sent / d2)
    }

    /// V, by `n` rays between points that face each other, weighted as the kernel is; and how many
    /// there were.
    fn visible(&self, p: Node, q: Node, n: u32) -> (f32, u32) {
        let name = |node: Node| match node {
            Node::Element(e) => u64::from(e),
            Node::Cluster(c) => u64::from(c) | 1 << 32,
        };
        let (low, high) = (name(p).min(name(q)), name(p).max(name(q)));
        let key = mix_bits(mix_bits(low) ^ high);
        let disk = self.area(q) / n as f32;
        let (mut segments, mut weights) = (Vec::with_capacity(n as usize), Vec::new());
        for i in 0..n * ATTEMPTS {
            let pick = |node, k: u64| {
                let u = rotated(r2(i), combine(key, k));
                self.pick(node, combine(combine(key, k + 2), u64::from(i)), u)
            };
            let (x, y) = (pick(p, 0), pick(q, 1));
            let d = y.p - x.p;
            let (cos_x, cos_y, r2) = (x.n.dot(d), -y.n.dot(d), d.length_squared());
            if cos_x > 0.0 && cos_y > 0.0 {
                segments.push(x.sight(&y));
                weights.push(cos_x * cos_y / (r2 * (PI * r2 + disk)));
            }
            if segments.len() as u32 == n {
                break;
            }
        }
        let mut batch = RayBatch::default();
        self.scene.occluded_all(&segments, &mut batch);
        let all: f32 = weights.iter().sum();
        let open = weights.iter().zip(&batch.occluded).filter(|(_, hidden)| !**hidden);
        let v = open.map(|(w, _)| w).sum::<f32>() / all.max(f32::MIN_POSITIVE);
        (v.min(1.0), segments.len() as u32)
    }

    /// A point of a node, uniform over its area.
    fn pick(&self, mut node: Node, mut key: u64, u: Vec2) -> Point {
        while let Node::Cluster(c) = node {
            let [a, b] = self.clusters[c as usize].children;
            let share = self.area(a) / self.clusters[c as usize].area;
            key = mix_bits(key);
            node = if unit(halves(key).0) < share { a } else { b };
        }
        match node {
            Node::Element(e) => self.mesh.sample(self.scene, e, u),
            Node::Cluster(_) => unreachable!("clusters end in elements"),
        }
    }
}

/// The middles of the n² equal parts of a triangle, as barycentric weights.
fn middles(n: u32) -> impl Iterator<Item = [f32; 3]> {
    let parts = (0..n).flat_map(move |i| (0..n - i).map(move |j| (i, j)));
    parts.flat_map(move |(i, j)| {
        // One that stands on its side, and, but for the last of a row, one on its head.
        let at = move |k: f32| {
            let [x, y] = [i, j].map(|c| (c as f32 + k) / n as f32);
            [1.0 - x - y, x, y]
        };
        [Some(at(1.0 / 3.0)), (i + j + 1 < n).then(|| at(2.0 / 3.0))].into_iter().flatten()
    })
}
