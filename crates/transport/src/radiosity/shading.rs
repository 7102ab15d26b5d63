//! What patches know, as a function over the surfaces: even over each, or interpolated between vertices
//! (Gouraud 1971).
//!
//! ```text
//! H(v) = Σ γ_e H_e / Σ γ_e                                                          (1)
//! H(v) ← H(v) + Σ γ_e (H_e - mean of H over e's corners) / Σ γ_e                     (2)
//! ```
//!
//! γ_e is the angle of element e at the vertex; elements share one if their normals are less than
//! 30° apart. (2) sharpens what (1) blurs, so that elements keep their means, most of all along
//! the borders of walls, where (1) knows one side alone. A vertex in the middle of an undivided
//! neighbour's side takes the mean of that side's ends, or there would be a crack.

use super::mesh::{Mesh, NONE};
use kaustika_math::Vec3;
use kaustika_scene::Scene;
use kaustika_spectra::Spectrum;
use std::collections::{HashMap, HashSet};

/// Cosine of the angle up to which normals count as those of one smooth surface.
const SMOOTH: f32 = 0.866;
/// Rounds of (2).
const ROUNDS: u32 = 2;
/// Vertices nearer than this part of the scene's radius are one.
const SAME: f32 = 1.0 / (1 << 20) as f32;

/// Values of the patches of a mesh.
#[derive(Debug)]
pub struct Shading {
    /// Of the mesh's elements: their number among the leaves.
    number: Vec<u32>,
    /// The leaves' vertices.
    corners: Vec<[u32; 3]>,
    /// Places of the vertices.
    positions: Vec<Vec3>,
    /// Vertices that hang in a side, and its ends, coarse ones first.
    hanging: Vec<(u32, [u32; 2])>,
    /// Angles of the leaves at their vertices.
    angles: Vec<[f32; 3]>,
}

/// One value a leaf, and one a vertex.
#[derive(Clone, Debug)]
pub struct Values {
    /// Of the leaves, in their order.
    pub leaves: Vec<Spectrum>,
    /// Of the vertices.
    pub vertices: Vec<Spectrum>,
}

/// Vertices by place.
struct Vertices {
    cell: f32,
    by_place: HashMap<[i64; 3], Vec<(Vec3, u32)>>,
    positions: Vec<Vec3>,
}

impl Vertices {
    fn at(&mut self, p: Vec3, n: Vec3) -> u32 {
        let key = [p.x, p.y, p.z].map(|x| (f64::from(x) / f64::from(self.cell)).round() as i64);
        let here = self.by_place.entry(key).or_default();
        if let Some((_, v)) = here.iter().find(|(m, _)| m.dot(n) > SMOOTH) {
            return *v;
        }
        let v = self.positions.len() as u32;
        here.push((n, v));
        self.positions.push(p);
        v
    }
}

impl Shading {
    /// The vertices of a mesh.
    pub fn new(scene: &Scene, mesh: &Mesh, leaves: &[u32]) -> Shading {
        let cell = scene.radius * SAME;
        let mut vertices = Vertices { cell, by_place: HashMap::new(), positions: Vec::new() };
        let mut number = vec![NONE; mesh.elements.len()];
        let (mut corners, mut angles) = (Vec::new(), Vec::new());
        for (i, &e) in leaves.iter().enumerate() {
            let element = &mesh.elements[e as usize];
            number[e as usize] = i as u32;
            corners.push(element.corners.map(|c| vertices.at(c, element.normal)));
            angles.push(std::array::from_fn(|k| angle(&element.corners, k)));
        }
        let side = |a: u32, b: u32| (a.min(b), a.max(b));
        let mut sides = HashSet::new();
        for [a, b, c] in &corners {
            sides.extend([side(*a, *b), side(*b, *c), side(*c, *a)]);
        }
        // Parents come before children.
        let mut hanging = Vec::new();
        for element in mesh.elements.iter().filter(|e| !e.is_leaf()) {
            let k = element.longest_side().0;
            let half = &mesh.elements[element.children as usize];
            let middle = half.corners.iter().find(|c| !element.corners.contains(c));
            let Some(middle) = middle else { continue };
            let ends = [element.corners[k], element.corners[(k + 1) % 3]];
            let [a, b] = ends.map(|c| vertices.at(c, element.normal));
            let m = vertices.at(*middle, element.normal);
            if sides.contains(&side(a, b)) && m != a && m != b {
                hanging.push((m, [a, b]));
                sides.extend([side(a, m), side(m, b)]);
            }
        }
        Shading { number, corners, positions: vertices.positions, hanging, angles }
    }

    /// (1) and (2).
    pub fn values(&self, leaves: Vec<Spectrum>) -> Values {
        let mut vertices = vec![Spectrum::ZERO; self.positions.len()];
        let mut weights = vec![f32::MIN_POSITIVE; vertices.len()];
        for (corners, angles) in self.corners.iter().zip(&self.angles) {
            corners.iter().zip(angles).for_each(|(&v, a)| weights[v as usize] += a);
        }
        for _ in 0..=ROUNDS {
            let mut sums = vec![Spectrum::ZERO; vertices.len()];
            for (i, (corners, angles)) in self.corners.iter().zip(&self.angles).enumerate() {
                let mean = corners.iter().fold(Spectrum::ZERO, |s, &v| s + vertices[v as usize]);
                let missing = leaves[i] - mean / 3.0;
                corners.iter().zip(angles).for_each(|(&v, a)| sums[v as usize] += missing * *a);
            }
            let terms = vertices.iter_mut().zip(sums).zip(&weights);
            terms.for_each(|((v, sum), w)| *v += sum / *w);
            self.hang(&mut vertices);
        }
        vertices.iter_mut().for_each(|v| *v = v.clamp_zero());
        Values { leaves, vertices }
    }

    /// Means over the leaves at each vertex, by angle, of `width` values a leaf.
    pub fn means(&self, leaves: &[Spectrum], width: usize) -> Vec<Spectrum> {
        let mut vertices = vec![Spectrum::ZERO; self.positions.len() * width];
        let mut weights = vec![f32::MIN_POSITIVE; self.positions.len()];
        for (i, (corners, angles)) in self.corners.iter().zip(&self.angles).enumerate() {
            for (&v, &angle) in corners.iter().zip(angles) {
                weights[v as usize] += angle;
                let sums = vertices[v as usize * width..][..width].iter_mut();
                sums.zip(&leaves[i * width..]).for_each(|(sum, x)| *sum += *x * angle);
            }
        }
        for (values, w) in vertices.chunks_mut(width).zip(weights) {
            values.iter_mut().for_each(|v| *v /= w);
        }
        for &(m, [a, b]) in &self.hanging {
            for k in 0..width {
                let [a, b] = [a, b].map(|v| vertices[v as usize * width + k]);
                vertices[m as usize * width + k] = (a + b) * 0.5;
            }
        }
        vertices
    }

    /// The vertices of one leaf.
    pub fn corners_of(&self, leaf: u32) -> [u32; 3] {
        self.corners[self.number[leaf as usize] as usize]
    }

    fn hang(&self, vertices: &mut [Spectrum]) {
        for &(m, [a, b]) in &self.hanging {
            vertices[m as usize] = (vertices[a as usize] + vertices[b as usize]) * 0.5;
        }
    }

    /// The even value of a leaf.
    pub fn even(&self, values: &Values, leaf: u32) -> Spectrum {
        values.leaves[self.number[leaf as usize] as usize]
    }

    /// The interpolated value at these barycentric weights of a leaf.
    pub fn smooth(&self, values: &Values, leaf: u32, b: [f32; 3]) -> Spectrum {
        let corners = self.corners_of(leaf);
        let parts = corners.iter().zip(b);
        parts.fold(Spectrum::ZERO, |sum, (&v, b)| sum + values.vertices[v as usize] * b)
    }

    /// The leaves' vertices.
    pub fn corners(&self) -> &[[u32; 3]] {
        &self.corners
    }

    /// Where the vertices are.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }
}

/// The angle of a triangle at a corner, radians.
fn angle(corners: &[Vec3; 3], k: usize) -> f32 {
    let (a, b) = (corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]);
    a.cross(b).length().atan2(a.dot(b))
}
