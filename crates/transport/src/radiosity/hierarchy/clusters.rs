//! Clusters (Smits, Arvo & Greenberg 1994; Sillion 1995): roots that lie together, so that scenes of
//! many surfaces need not link each with each.

use super::harmonics::Lobes9;
use crate::radiosity::mesh::Mesh;
use kaustika_math::{Bounds3, Vec3};
use kaustika_spectra::Spectrum;

/// An element or a cluster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Node {
    /// Of the mesh.
    Element(u32),
    /// Of the tree of clusters.
    Cluster(u32),
}

/// A node in four bytes, of which there are two in each of many millions of links: clusters count down from
/// the largest number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Short(u32);

impl From<Node> for Short {
    fn from(node: Node) -> Short {
        Short(match node {
            Node::Element(e) => e,
            Node::Cluster(c) => !c,
        })
    }
}

impl From<Short> for Node {
    fn from(Short(n): Short) -> Node {
        match n < 1 << 31 {
            true => Node::Element(n),
            false => Node::Cluster(!n),
        }
    }
}

/// Two nodes together.
#[derive(Clone, Debug)]
pub struct Cluster {
    /// The nodes.
    pub children: [Node; 2],
    /// Middle of the ball around them.
    pub center: Vec3,
    /// Its radius.
    pub radius: f32,
    /// Area of all elements.
    pub area: f32,
}

/// The tree of clusters over the roots that are not black, children before parents; and its root.
pub fn build(mesh: &Mesh) -> (Vec<Cluster>, Option<Node>) {
    let mut roots: Vec<u32> =
        (0..mesh.roots).filter(|&e| !mesh.elements[e as usize].is_black()).collect();
    let mut clusters = Vec::new();
    let root = (!roots.is_empty()).then(|| part(mesh, &mut roots, &mut clusters).0);
    (clusters, root)
}

/// Of each cluster the area that faces a direction w, Σ A max(n·w, 0) over its elements.
pub fn faces(clusters: &[Cluster], mesh: &Mesh) -> Vec<Lobes9> {
    let mut faces: Vec<Lobes9> = Vec::with_capacity(clusters.len());
    for cluster in clusters {
        let mut all = Lobes9::default();
        for child in cluster.children {
            match child {
                Node::Cluster(d) => all.add(&faces[d as usize]),
                Node::Element(e) => {
                    let element = &mesh.elements[e as usize];
                    all.add_lobe(element.normal, Spectrum::splat(element.area));
                }
            }
        }
        faces.push(all);
    }
    faces
}

/// A tree over some roots, what is around it, and its area.
fn part(mesh: &Mesh, roots: &mut [u32], clusters: &mut Vec<Cluster>) -> (Node, Bounds3, f32) {
    if let [e] = *roots {
        let element = &mesh.elements[e as usize];
        let bounds = element.corners.iter().fold(Bounds3::EMPTY, |b, c| b.with_point(*c));
        return (Node::Element(e), bounds, element.area);
    }
    let center = |e: &u32| mesh.elements[*e as usize].center();
    let middles = roots.iter().fold(Bounds3::EMPTY, |b, e| b.with_point(center(e)));
    let axis = middles.diagonal().max_axis();
    let half = roots.len() / 2;
    let order = |a: &u32, b: &u32| center(a)[axis].total_cmp(&center(b)[axis]).then(a.cmp(b));
    roots.select_nth_unstable_by(half, order);
    let (left, right) = roots.split_at_mut(half);
    let (a, bounds_a, area_a) = part(mesh, left, clusters);
    let (b, bounds_b, area_b) = part(mesh, right, clusters);
    let (bounds, area) = (bounds_a.union(bounds_b), area_a + area_b);
    let (center, radius) = bounds.bounding_sphere();
    clusters.push(Cluster { children: [a, b], center, radius, area });
    (Node::Cluster(clusters.len() as u32 - 1), bounds, area)
}
