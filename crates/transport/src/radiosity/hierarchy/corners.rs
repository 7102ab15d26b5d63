//! What arrives at the corners of leaves, by the links of the leaf and of all above it.
//!
//! ```text
//! H(x) = Σ over links p←q F(x→q) V_pq B_q                                           (8)
//! ```
//!
//! The kernel of (1) at the corner itself instead of its mean over the element (as vertices receive in
//! Wallace, Elmquist & Haines 1989): between vertices the light of coarse links varies as it does,
//! into the corners of rooms. What is in the way stays the link's.

use super::{Hierarchy, Node};
use crate::radiosity::form_factor::polygon::point_to_triangle;
use crate::radiosity::mesh::NONE;
use kaustika_math::Vec3;
use kaustika_spectra::Spectrum;
use rayon::prelude::*;

/// How far toward the middle of the leaf a corner is asked: not in the plane of a wall that it touches.
const INSIDE: f32 = 0.03;

impl Hierarchy<'_, '_> {
    /// (8) at the three corners of each leaf.
    pub(super) fn corners(&mut self, leaves: &[u32]) -> Vec<[Spectrum; 3]> {
        let name = |node: Node| match node {
            Node::Element(e) => e,
            Node::Cluster(_) => NONE,
        };
        self.links.sort_by_key(|l| name(l.p));
        let first = |e: u32| self.links.partition_point(|l| name(l.p) < e);
        let mut above = vec![NONE; self.mesh.elements.len()];
        for (e, element) in self.mesh.elements.iter().enumerate().filter(|(_, e)| !e.is_leaf()) {
            above[element.children as usize..][..2].fill(e as u32);
        }
        let corners = leaves.par_iter().map(|&leaf| {
            let element = &self.mesh.elements[leaf as usize];
            let center = element.center();
            let at = element.corners.map(|c| c.lerp(center, INSIDE));
            let mut h = [Spectrum::ZERO; 3];
            let mut e = leaf;
            loop {
                for link in &self.links[first(e)..first(e + 1)] {
                    for (h, x) in h.iter_mut().zip(at) {
                        *h += self.arriving(x, element.normal, link.q) * link.v;
                    }
                }
                if above[e as usize] == NONE {
                    break;
                }
                e = above[e as usize];
            }
            h.map(|h| h + self.by_clusters[e as usize])
        });
        corners.collect()
    }

    /// Irradiance at a place from a node that nothing hides.
    fn arriving(&self, x: Vec3, n: Vec3, q: Node) -> Spectrum {
        match q {
            Node::Element(q) => {
                let element = &self.mesh.elements[q as usize];
                let b = self.radiosity[q as usize];
                match !b.is_black() && element.normal.dot(x - element.corners[0]) > 0.0 {
                    true => b * point_to_triangle(x, n, &element.corners) as f32,
                    false => Spectrum::ZERO,
                }
            }
            Node::Cluster(c) => {
                let d = self.clusters[c as usize].center - x;
                let d2 = d.length_squared().max(self.clusters[c as usize].radius.powi(2));
                let Some(w) = d.try_normalize() else { return Spectrum::ZERO };
                self.sent[c as usize].value(-w) * (n.dot(w).max(0.0) / d2)
            }
        }
    }
}
