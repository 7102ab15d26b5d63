//! Which element a ray has met.

use super::{Mesh, NONE};
use kaustika_math::{Vec2, Vec3};
use kaustika_scene::{FacetId, Scene, Surface};

impl Mesh {
    /// The leaf at a surface on the side of `w`, and the barycentric weights of the place on it;
    /// `None` on what has no elements.
    pub fn locate(&self, scene: &Scene, s: &Surface, w: Vec3) -> Option<(u32, [f32; 3])> {
        let (facet, at) = scene.geometry.facet_of(s)?;
        let root = self.roots_of.get(&facet)?[usize::from(s.ng.dot(w) < 0.0)];
        (root != NONE).then(|| self.leaf(root, at))
    }

    /// The leaf of a root at a place on the root's facet, and the barycentric weights of the place on it.
    pub fn leaf(&self, root: u32, at: Vec2) -> (u32, [f32; 3]) {
        let mut e = root;
        loop {
            let element = &self.elements[e as usize];
            if element.is_leaf() {
                return (e, element.weights(at));
            }
            // The halves share the corner across and the middle: which is the point's?
            let (first, second) = (element.children, element.children + 1);
            let is_in = |half: u32| inside(self.elements[half as usize].at, at);
            e = if is_in(first) >= is_in(second) { first } else { second };
        }
    }

    /// True if halves of the element lie in its plane.
    pub(super) fn is_flat(&self, e: u32) -> bool {
        let facet = self.elements[e as usize].facet;
        matches!(self.facets[facet as usize].id, FacetId::Triangle(_))
    }
}

/// How far inside a triangle of the facet a place is, negative outside.
fn inside([p, q, r]: [Vec2; 3], at: Vec2) -> f32 {
    let cross = |a: Vec2, b: Vec2| a.x * b.y - a.y * b.x;
    let whole = cross(q - p, r - p);
    let b1 = cross(at - p, r - p) / whole;
    let b2 = cross(q - p, at - p) / whole;
    b1.min(b2).min(1.0 - b1 - b2)
}
