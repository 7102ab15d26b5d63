//! Where nodes are linked.
//!
//! ```text
//! κ_p = r_p/d,  κ_q = r_q/d,   d from the one's middle to the other, at most 1        (5)
//! divide p if A_p F max(κ_p V, δ_p) B > ε                                            (7)
//! divide q if A_0 F max(κ_q V σ, δ B) > ε,   σ ≤ B how uneven it is                   (8)
//! ```
//!
//! What p's division mends is the mesh: light that changes over p. That is judged by power, so that what is
//! large is divided first (brightness-weighted refinement, Hanrahan et al. 1991). What q's division mends is
//! what arrives at a place: F of elements is exact however large q is, if it sends evenly, so that its σ counts.
//! That is judged by what it brings per area, as if p were as small as the smallest, of area A_0: as
//! Hanrahan's F_ε, it opens q as wide, seen from p, at every level, and links are as many as elements. With
//! power they would be more of each, the deeper elements go.
//!
//! Where both are to be divided, the larger is. δ, what is in doubt of V ([`visible`](super::visible)), goes on where something
//! is partly in the way. δ_p is δ if p is
//! the larger; if q is, what is hidden of q from all of p alike is not p's, and δ_p is how V changes over p (9). More rays ask
//! where few could not tell: those that all agree, of a link that is otherwise good enough. Or every link above some
//! power would be refined for the rays' sake, at every level, whatever its κ. What is not seen at all is not uneven
//! either: κ counts by V, or all that real scenes hide would be refined as if it were seen.
//!
//! A_p of a cluster is the area that faces q. No node is divided that is smaller than A_0, cluster or element: what lies within
//! is as small as patches may be, and none of it has more light to get than one. Else all that touches would be
//! linked triangle by triangle, each with as many links as the largest patch. Only with itself is a cluster divided
//! whatever its light, since that link carries none.
//!
//! F between elements is Lambert's formula from
//! points of p; between an element and a cluster, or two, light goes from middle to middle. A link
//! that is refined is taken away, or its light would arrive twice.

use super::{Hierarchy, Link, Node};
use crate::radiosity::form_factor::polygon::point_to_triangle;
use crate::radiosity::mesh::{Element, NONE};
use crate::workers::Workers;
use kaustika_math::Vec3;
use rayon::prelude::*;
use std::f32::consts::{FRAC_1_SQRT_2, PI};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Links at most.
const MOST_LINKS: usize = 1 << 26;
/// Rays that ask what is between two nodes.
const RAYS: (f32, f32) = (4.0, 32.0);
/// At most, where these all agree.
const MORE_RAYS: f32 = 512.0;
/// Pairs that are asked about between two words of how far it is.
const TOLD: usize = 1024;

/// What links are judged by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// ε: what a link may err by.
    pub error: f32,
    /// ε of the last round.
    pub last: f32,
    /// A_0: the smallest area.
    pub area: f32,
    /// Links for each element: beyond, the worst alone are refined, until there is no room.
    pub links: usize,
}

impl Hierarchy<'_, '_> {
    /// Refines all links until each is good enough. `None` if cancelled, which is obeyed within some rays.
    pub(super) fn refine(&mut self, bounds: &Bounds, workers: &Workers) -> Option<()> {
        let mut links = std::mem::take(&mut self.links);
        if let (Some(root), true) = (self.root, links.is_empty()) {
            links.extend(self.estimate((root, root), bounds));
        }
        let is_last = bounds.error <= bounds.last;
        let uncancelled = || (!workers.cancelled()).then_some(());
        loop {
            uncancelled()?;
            if links.is_empty() {
                return Some(());
            }
            workers.tell(|| {
                let elements = self.mesh.elements.len();
                let (made, asked) = (self.links.len(), links.len());
                format!("refining: {elements} elements, {made} links, {asked} in question")
            });
            // Which are good enough?
            let judge = |l| uncancelled().map(|()| self.to_divide(l, bounds));
            let judged = links.par_iter().map(judge).collect::<Option<Vec<_>>>()?;
            let least = self.least_that_is_refined(&judged, bounds);
            let mut pairs = Vec::new();
            let mut divided = Vec::new();
            let mut coarse = Vec::new();
            for (link, node) in links.into_iter().zip(judged) {
                let Some((node, _)) = node.filter(|(_, errs)| *errs >= least) else {
                    // What carries no light is kept only for what another round may find.
                    if link.f > 0.0 || !is_last {
                        self.links.push(link);
                    }
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
            self.add_sources(workers)?;
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
            let (asked, all) = (AtomicUsize::new(0), pairs.len());
            let estimate = |pair| {
                uncancelled()?;
                let asked = asked.fetch_add(1, Ordering::Relaxed) + 1;
                if asked.is_multiple_of(TOLD) {
                    let elements = self.mesh.elements.len();
                    workers.tell(|| {
                        format!("refining: {elements} elements, {asked} of {all} links asked")
                    });
                }
                self.estimate(pair, bounds)
            };
            let pairs_of_light = pairs.into_par_iter().filter(|(p, _)| self.receives(*p));
            links = pairs_of_light.filter_map(estimate).collect();
        }
    }

    /// What a link must err by to be refined, of those that are judged: 0, if there is room for them all.
    fn least_that_is_refined(&self, judged: &[Option<(Node, f32)>], bounds: &Bounds) -> f32 {
        let most = (bounds.links * self.mesh.elements.len()).min(MOST_LINKS);
        // Each that is refined becomes two.
        let room = most.saturating_sub(self.links.len() + judged.len());
        let mut errs: Vec<f32> = judged.iter().flatten().map(|(_, errs)| *errs).collect();
        if errs.len() <= room {
            return 0.0;
        }
        let (_, &mut last, _) = errs.select_nth_unstable_by(room, |a, b| b.total_cmp(a));
        // No more of them than there is room for, if many err alike.
        last.next_up()
    }

    /// (7) and (8): the node to divide, if one is to be, and can be; and what the link errs by, of what it may.
    fn to_divide(&self, link: &Link, bounds: &Bounds) -> Option<(Node, f32)> {
        let (p, q) = (Node::from(link.p), Node::from(link.q));
        let area = bounds.area;
        let can = |node: Node| match node {
            Node::Cluster(_) => self.area(node) > area,
            Node::Element(e) => {
                let element = &self.mesh.elements[e as usize];
                element.children != NONE || element.area > area && !element.is_black()
            }
        };
        if p == q {
            return can(p).then_some((p, f32::INFINITY));
        }
        let (b, spread) = self.sent(p, q);
        let [of_p, of_q] = self.uneven(p, q);
        let [over_p, over_both] = link.hidden;
        let q_is_larger = self.radius(q) > self.radius(p);
        let hidden = if q_is_larger { [over_p, over_both] } else { [over_both, 0.0] };
        let mends_p = self.facing(p, q) * b * link.most * (of_p * link.v).max(hidden[0]);
        let mends_q = area * link.most * (of_q * link.v * spread).max(hidden[1] * b);
        let first =
            if q_is_larger { [(q, mends_q), (p, mends_p)] } else { [(p, mends_p), (q, mends_q)] };
        first
            .into_iter()
            .find(|(node, mends)| *mends > bounds.error && can(*node))
            .map(|(node, mends)| (node, mends / bounds.error))
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

    /// The area of p that may face q: as with what is sent, not from middle to middle alone.
    fn facing(&self, p: Node, q: Node) -> f32 {
        let Node::Cluster(c) = p else { return self.area(p) };
        let w = (self.center(q) - self.center(p)).try_normalize().unwrap_or(Vec3::Z);
        let [of_p, of_q] = self.uneven(p, q);
        let most = (of_p + of_q).min(1.0) * self.area(p);
        self.faces[c as usize].value(w).average().max(most)
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
    fn estimate(&self, (p, q): (Node, Node), bounds: &Bounds) -> Option<Link> {
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
        let link = |v: f32, hidden| Link { p: p.into(), q: q.into(), f: f * v, most, v, hidden };
        let power = self.facing(p, q) * self.sent(p, q).0 * most;
        if p == q || self.is_cluster(p, q) && uneven[0] + uneven[1] >= 1.0 {
            // What overlaps is not worth asking: it is refined if it matters at all.
            return Some(link(1.0, [1.0; 2]));
        }
        let part = power / bounds.error.max(f32::MIN_POSITIVE);
        let mut rays = (0.25 * part).clamp(RAYS.0, RAYS.1);
        let mut seen = self.visible(p, q, rays as u32);
        // (6) of n rays that agree is below 1/part from n of part/2 on.
        let needed = 0.5 * part;
        let is_good = seen.agrees() && seen.v * uneven[0] * part <= 1.0;
        if is_good && rays < needed && needed < MORE_RAYS {
            rays = needed.ceil();
            seen = self.visible(p, q, rays as u32);
        }
        Some(link(seen.v, seen.in_doubt()))
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
