//! Surfaces as elements: both sides of every triangle and of every facet of a quadric are the roots of
//! binary trees, whose leaves are the patches.
//!
//! ```text
//! a triangle is divided from the middle of its longest side to the corner across     (1)
//! ```
//!
//! (1) (Rivara 1984) keeps triangles from becoming slivers, and parts whatever lies on both sides of
//! an edge in the same way where the edge is the longest of both.

mod element;
mod grow;
mod locate;
mod matter;

pub use element::{Element, NONE};

use kaustika_math::{Ray, warp};
use kaustika_math::{Vec2, Vec3, gamma, ray::offset_origin};
use kaustika_scene::{Facet, Scene, Segment, Surface};
use rayon::prelude::*;
use std::collections::HashMap;

/// The time of the shutter at which things that move are where they are.
const TIME: f32 = 0.5;

/// The elements of a scene.
#[derive(Debug)]
pub struct Mesh {
    /// All elements; the roots come first.
    pub elements: Vec<Element>,
    /// How many are roots.
    pub roots: u32,
    /// True if more than matte light matters.
    glossy: bool,
    facets: Vec<Facet>,
    /// The roots of a facet's front and back, or [`NONE`].
    roots_of: HashMap<Facet, [u32; 2]>,
}

/// A point on an element.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Where.
    pub p: Vec3,
    /// Bound of its rounding error.
    pub p_error: Vec3,
    /// Normal on the element's side, unit.
    pub n: Vec3,
}

impl Point {
    /// The ray that finds whether two points see each other.
    pub fn sight(&self, other: &Point) -> Segment {
        let d = other.p - self.p;
        let slack = other.p_error + Vec3::splat(d.abs().max_component() * gamma(8));
        let o = offset_origin(self.p, self.p_error, self.n, d);
        let end = offset_origin(other.p, slack, other.n, -d);
        Segment { ray: Ray { o, d: end - o, time: TIME }, t_max: 1.0 }
    }

    /// A ray along `d`.
    pub fn ray(&self, d: Vec3) -> Ray {
        Ray { o: offset_origin(self.p, self.p_error, self.n, d), d, time: TIME }
    }
}

impl Mesh {
    /// The roots alone; `glossy` if more than matte light matters.
    pub fn new(scene: &Scene, glossy: bool) -> Mesh {
        let facets = scene.geometry.facets();
        let made: Vec<[Option<Element>; 2]> = (0..facets.len() as u32)
            .into_par_iter()
            .map(|i| [false, true].map(|back| root(scene, &facets[i as usize], i, (back, glossy))))
            .collect();
        let (mut elements, mut roots_of) = (Vec::new(), HashMap::with_capacity(facets.len()));
        for (facet, sides) in facets.iter().zip(made) {
            let mut number = |element: Option<Element>| match element {
                Some(element) => {
                    elements.push(element);
                    elements.len() as u32 - 1
                }
                None => NONE,
            };
            roots_of.insert(*facet, sides.map(&mut number));
        }
        let roots = elements.len() as u32;
        Mesh { elements, roots, glossy, facets, roots_of }
    }

    /// The numbers of the leaves, in the order of their trees.
    pub fn leaves(&self) -> Vec<u32> {
        let mut leaves = Vec::new();
        let mut stack: Vec<u32> = (0..self.roots).rev().collect();
        while let Some(e) = stack.pop() {
            match self.elements[e as usize].children {
                NONE => leaves.push(e),
                first => stack.extend([first + 1, first]),
            }
        }
        leaves
    }

    /// The point of an element with these barycentric weights.
    pub fn point(&self, scene: &Scene, e: u32, b: [f32; 3]) -> Point {
        let element = &self.elements[e as usize];
        let s = self.surface(scene, e, b);
        Point { p: s.p, p_error: s.p_error, n: if element.back { -s.ng } else { s.ng } }
    }

    /// A point of an element, uniform over it, from two numbers in [0, 1).
    pub fn sample(&self, scene: &Scene, e: u32, u: Vec2) -> Point {
        self.point(scene, e, warp::triangle(u))
    }

    /// The surface there.
    pub fn surface(&self, scene: &Scene, e: u32, b: [f32; 3]) -> Surface {
        let element = &self.elements[e as usize];
        let facet = &self.facets[element.facet as usize];
        scene.geometry.on_facet(facet, element.place(b), TIME)
    }
}

/// The root of one side of a facet, if there is anything on that side. Fronts always are, since they
/// are in the way of others' light.
fn root(
    scene: &Scene,
    facet: &Facet,
    number: u32,
    (back, glossy): (bool, bool),
) -> Option<Element> {
    let at = [Vec2::ZERO, Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0)];
    let on = |at| scene.geometry.on_facet(facet, at, TIME);
    let corners = at.map(|at| on(at).p);
    let middle = on(Vec2::splat(1.0 / 3.0));
    let facing = if back { -middle.ng } else { middle.ng };
    let [a, b, c] = corners;
    let cross = (b - a).cross(c - a);
    let normal = cross.try_normalize()?.face_forward(facing);
    let area = 0.5 * cross.length();
    let mut element = Element {
        facet: number,
        back,
        at,
        corners,
        normal,
        area,
        albedo: Default::default(),
        emission: Default::default(),
        glossy: false,
        children: NONE,
    };
    if !(area > 0.0 && normal.is_finite()) {
        return None;
    }
    matter::furnish(scene, facet, &mut element, glossy);
    (!back || !element.is_black()).then_some(element)
}
