//! Where nodes are linked.
//!
//! ```text
//! κ_p = r_p/d,  κ_q = r_q/d,   d from the one's middle to the other, at most 1        (5)
//! δ = 4V(1 - V), at least 1/2(n+1) after n rays                                      (6)
//! divide p if A_p F max(κ_p, δ_p) B > ε                                              (7)
//! divide q if A_0 F max(κ_q σ, δ B) > ε,   σ ≤ B how uneven it is                     (8)
//! ```
//!
//! What p's division mends is the mesh: light that changes over p. That is judged by power, so that what is
//! large is divided first (brightness-weighted refinement, Hanrahan et al. 1991). What q's division mends is
//! what arrives at a place: F of elements is exact however large q is, if it sends evenly, so that its σ counts.
//! That is judged by what it brings per area, as if p were as small as the smallest, of area A_0: as
//! Hanrahan's F_ε, it opens q as wide, seen from p, at every level, and links are as many as elements. With
//! power they would be more of each, the deeper elements go.
//!
//! Where both are to be divided, the larger is. (6) goes on where something is partly in the way. δ_p is δ if p is
//! the larger; if q is, what is hidden of q from all of p alike is not p's, and δ_p is how V changes over p (9). More rays ask
//! where few could not tell: those that all agree, of a link that is otherwise good enough. Or
//! every link above some power would be refined for the rays' sake, at every level, whatever its κ.
//!
//! F between elements is Lambert's formula from
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
use std::f32::consts::{FRAC_1_SQRT_2, PI};

/// Links at most: beyond, coarse ones stay.
const MOST_LINKS: usize = 1 << 26;
/// Rays that ask what is between two nodes.
const RAYS: (f32, f32) = (4.0, 32.0);
/// At most, where these all agree.
const MORE_RAYS: f32 = 512.0;
/// Attempts to find points that face each other, for each ray.
const ATTEMPTS: u32 = 4;

/// What rays between two nodes have found.
struct Seen {
    /// V.
    v: f32,
    /// δ over p alone.
    over_p: f32,
    /// How many there were.
    rays: u32,
}

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
            let worst: Vec<Option<Node>> =
                links.par_iter().map(|l| self.to_divide(l, error, area)).collect();
            let mut pairs = Vec::new();
            let mut divided = Vec::new();
            let mut coarse = Vec::new();
            for (link, node) in links.into_iter().zip(worst) {
                let full = self.links.len() + coarse.len() + pairs.len() > MOST_LINKS;
                let Some(node) = node.filter(|_| !full) else {
                    self.links.push(link);
                    continue;
                };
                if let Node::Element(e) = node
                    && self.mesh.elements[e as usize].children == NONE
                {
                    divided.push(e);
                }
                coarse.push((link, node));
            }
            divided.sort_unstable();
            divided.dedup();
            self.mesh.divide(self.scene, &divided);
            self.add_sources();
            for e in divided {
                // Until light arrives by finer links: σ as of light that changes evenly.
                let (b, spread) = (self.radiosity[e as usize], self.spread[e as usize]);
                let first = self.mesh.elements[e as usize].children as usize;
                self.radiosity[first..first + 2].fill(b);
                self.spread[first..first + 2].fill(spread * FRAC_1_SQRT_2);
            }
            for (link, node) in coarse {
                self.parts(&link, node, &mut pairs);
            }
            let pairs_of_light = pairs.into_par_iter().filter(|(p, _)| self.receives(*p));
            links = pairs_of_light.filter_map(|pair| self.estimate(pair, error)).collect();
        }
        Some(())
    }

    /// (7) and (8): the node to divide, if one is to be, and can be.
    fn to_divide(&self, link: &Link, error: f32, area: f32) -> Option<Node> {
        let (p, q) = (Node::from(link.p), Node::from(link.q));
        let can = |node: Node| match node {
            Node::Cluster(_) => true,
            Node::Element(e) => {
                let element = &self.mesh.elements[e as usize];
                element.children != NONE || element.area > area && !element.is_black()
            }
        };
        let (b, spread) = self.sent(p, q);
        let [of_p, of_q] = self.uneven(p, q);
        let [over_p, over_both] = link.hidden;
        let q_is_larger = self.radius(q) > self.radius(p);
        let hidden = if q_is_larger { [over_p, over_both] } else { [over_both, 0.0] };
        let mends_p = self.area(p) * b * link.most * of_p.max(hidden[0]);
        let mends_q = area * link.most * (of_q * spread).max(hidden[1] * b);
        let first =
            if q_is_larger { [(q, mends_q), (p, mends_p)] } else { [(p, mends_p), (q, mends_q)] };
        first.into_iter().find(|(node, mends)| *mends > error && can(*node)).map(|(node, _)| node)
    }

    /// B_q, from what is sent by now, and its σ. What a cluster sends may go in other directions than
    /// from middle to middle, the more so the nearer the two are.
    fn sent(&self, p: Node, q: Node) -> (f32, f32) {
        match q {
            Node::Element(q) => (self.radiosity[q as usize].average(), self.spread[q as usize]),
            Node::Cluster(c) => {
                let w = (self.center(p) - self.center(q)).try_normalize().unwrap_or(Vec3::Z);
                let sent = &self.sent[c as usize];
                let [of_p, of_q] = self.uneven(p, q);
                let most = (of_p + of_q).min(1.0) * sent.most().average();
                let sent = sent.value(w).average().max(most);
                (sent, sent)
            }
        }
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
                let f = self.between_elements(p, q, uneven[0]);
                (f, f)
            }
            _ => self.between_middles(p, q, d, (uneven[0] + uneven[1]).min(1.0)),
        };
        if most <= 0.0 {
            return None;
        }
        let link = |v: f32, hidden| Link { p: p.into(), q: q.into(), f: f * v, most, hidden };
        if p == q || self.is_cluster(p, q) && uneven[0] + uneven[1] >= 1.0 {
            // What overlaps is not worth asking: it is refined if it matters at all.
            return Some(link(1.0, [1.0; 2]));
        }
        let part = self.area(p) * self.sent(p, q).0 * most / error.max(f32::MIN_POSITIVE);
        let mut rays = (0.25 * part).clamp(RAYS.0, RAYS.1);
        let mut seen = self.visible(p, q, rays as u32);
        let agree = |v: f32| v == 0.0 || v == 1.0;
        // (6) of n rays that agree is below 1/part from n of part/2 on.
        let needed = 0.5 * part;
        if agree(seen.v) && seen.v * uneven[0] * part <= 1.0 && rays < needed && needed < MORE_RAYS
        {
            rays = needed.ceil();
            seen = self.visible(p, q, rays as u32);
        }
        let least = 0.5 / (seen.rays + 1) as f32;
        let both = 4.0 * seen.v * (1.0 - seen.v); // (6)
        Some(link(seen.v, [seen.over_p.max(least), both.max(least)]))
    }

    /// (5), of p and of q.
    fn uneven(&self, p: Node, q: Node) -> [f32; 2] {
        if p == q {
            return [1.0; 2];
        }
        let (of_p, of_q) = (self.radius(p), self.radius(q));
        let part = |r: f32, d: f32| if d > r { r / d } else { 1.0 };
        match (p, q) {
            (Node::Element(a), Node::Element(b)) => {
                let (a, b) = (&self.mesh.elements[a as usize], &self.mesh.elements[b as usize]);
                [part(of_p, b.distance(a.center())), part(of_q, a.distance(b.center()))]
            }
            _ => {
                let d = (self.center(q) - self.center(p)).length();
                match d > of_p + of_q {
                    true => [part(of_p, d), part(of_q, d)],
                    false => [1.0; 2],
                }
            }
        }
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

    /// V, by `n` rays between points that face each other, weighted as the kernel is.
    fn visible(&self, p: Node, q: Node, n: u32) -> Seen {
        let name = |node: Node| match node {
            Node::Element(e) => u64::from(e),
            Node::Cluster(c) => u64::from(c) | 1 << 32,
        };
        let (low, high) = (name(p).min(name(q)), name(p).max(name(q)));
        let key = mix_bits(mix_bits(low) ^ high);
        let disk = self.area(q) / n as f32;
        let (mut segments, mut weights) = (Vec::with_capacity(n as usize), Vec::new());
        let mut places = Vec::with_capacity(n as usize);
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
                places.push(x.p);
            }
            if segments.len() as u32 == n {
                break;
            }
        }
        let mut batch = RayBatch::default();
        self.scene.occluded_all(&segments, &mut batch);
        let all: f32 = weights.iter().sum();
        let open = weights.iter().zip(&batch.occluded).filter(|(_, hidden)| !**hidden);
        let v = (open.map(|(w, _)| w).sum::<f32>() / all.max(f32::MIN_POSITIVE)).min(1.0);
        let over_p = match p {
            Node::Element(e) if v > 0.0 && v < 1.0 => {
                let corners = &self.mesh.elements[e as usize].corners;
                change(corners, places.iter().copied().zip(batch.occluded.iter().map(|h| !h)))
            }
            _ => 4.0 * v * (1.0 - v),
        };
        Seen { v, over_p, rays: segments.len() as u32 }
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

/// How much what is seen of places on a triangle changes between its corners, from 0 to 1: the standard deviation of
/// the parts V_k that are seen near each, twice, without what is chance.
///
/// ```text
/// 4 (1/2 Σ_k (V_k - V)² - V(1 - V)/3 Σ_k 1/n_k)                                      (9)
/// ```
fn change(corners: &[Vec3; 3], seen: impl Iterator<Item = (Vec3, bool)>) -> f32 {
    let (mut open, mut all) = ([0.0f32; 3], [0.0f32; 3]);
    for (x, is_open) in seen {
        let far = |k: usize| (corners[k] - x).length_squared();
        let k = (1..3).fold(0, |best, k| if far(k) < far(best) { k } else { best });
        all[k] += 1.0;
        open[k] += f32::from(is_open);
    }
    if all.contains(&0.0) {
        return 1.0;
    }
    let v = open.iter().sum::<f32>() / all.iter().sum::<f32>();
    let between: f32 = (0..3).map(|k| (open[k] / all[k] - v).powi(2)).sum();
    let chance: f32 = all.iter().map(|n| v * (1.0 - v) / n).sum();
    (4.0 * (0.5 * between - chance / 3.0)).clamp(0.0, 1.0).sqrt() // (9)
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
