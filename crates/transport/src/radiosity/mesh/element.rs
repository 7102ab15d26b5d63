//! One element of the mesh: a triangle on one side of a surface.

use kaustika_math::{Vec2, Vec3};
use kaustika_spectra::Spectrum;

/// No element.
pub const NONE: u32 = u32::MAX;

/// A flat triangle that stands for one side of a part of a surface. What it reflects and emits is
/// even over it; light on its other side is another element's.
#[derive(Clone, Debug)]
pub struct Element {
    /// The facet that it is part of, in the mesh's list.
    pub facet: u32,
    /// True if it is the back of the surface, which the surface's normal points away from.
    pub back: bool,
    /// Its corners on the facet: barycentric weights of the facet's corners 1 and 2.
    pub at: [Vec2; 3],
    /// Its corners in the world.
    pub corners: [Vec3; 3],
    /// Normal on its side, unit.
    pub normal: Vec3,
    /// Area.
    pub area: f32,
    /// ρ: the diffuse part of light that it reflects, over all directions.
    pub albedo: Spectrum,
    /// What it emits over all directions, W/m².
    pub emission: Spectrum,
    /// True if it reflects otherwise too, but not as a mirror, and that matters.
    pub glossy: bool,
    /// The first of two elements that it is divided into, or [`NONE`].
    pub children: u32,
}

impl Element {
    /// True if it is not divided.
    pub fn is_leaf(&self) -> bool {
        self.children == NONE
    }

    /// True if it neither reflects nor emits.
    pub fn is_black(&self) -> bool {
        !self.glossy && self.albedo.is_black() && self.emission.is_black()
    }

    /// The middle.
    pub fn center(&self) -> Vec3 {
        let [a, b, c] = self.corners;
        (a + b + c) * (1.0 / 3.0)
    }

    /// The farthest corner's distance from the middle.
    pub fn radius(&self) -> f32 {
        let center = self.center();
        self.corners.iter().map(|c| (*c - center).length()).fold(0.0, f32::max)
    }

    /// How far a place is from it.
    pub fn distance(&self, x: Vec3) -> f32 {
        let c = &self.corners;
        let side = |k: usize| c[(k + 1) % 3] - c[k];
        let turn = side(0).cross(side(1));
        // Above the triangle if on the inner side of all sides.
        if (0..3).all(|k| turn.cross(side(k)).dot(x - c[k]) >= 0.0) {
            return self.normal.dot(x - c[0]).abs();
        }
        let to_side = |k: usize| {
            let (s, to) = (side(k), x - c[k]);
            let t = (to.dot(s) / s.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
            (to - s * t).length()
        };
        (0..3).map(to_side).fold(f32::INFINITY, f32::min)
    }

    /// The corner before the longest side, and that side's length.
    pub fn longest_side(&self) -> (usize, f32) {
        let length = |k: usize| (self.corners[(k + 1) % 3] - self.corners[k]).length();
        (1..3).fold((0, length(0)), |best, k| match length(k) > best.1 {
            true => (k, length(k)),
            false => best,
        })
    }

    /// The place on the facet of barycentric weights on the element.
    pub fn place(&self, b: [f32; 3]) -> Vec2 {
        let [p, q, r] = self.at;
        p * b[0] + q * b[1] + r * b[2]
    }

    /// The barycentric weights of a place on the facet, clamped to the element.
    pub fn weights(&self, at: Vec2) -> [f32; 3] {
        let [p, q, r] = self.at;
        let cross = |a: Vec2, b: Vec2| a.x * b.y - a.y * b.x;
        let whole = cross(q - p, r - p);
        let b1 = (cross(at - p, r - p) / whole).clamp(0.0, 1.0);
        let b2 = (cross(q - p, at - p) / whole).clamp(0.0, 1.0 - b1);
        [1.0 - b1 - b2, b1, b2]
    }
}
