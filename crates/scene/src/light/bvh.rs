//! A hierarchy of lights: chooses in proportion to what each may contribute at a point, in time
//! logarithmic in their number (Conty Estevez & Kulla 2018, "Importance Sampling of Many Lights
//! with Adaptive Tree Splitting"; importance without splitting as Pharr et al. 2023, sec. 12.6).
//!
//! ```text
//! importance   I cos θ' cos θᵢ' / d²                                                      (1)
//! θ' = max(0, θ - θₒ - θᵦ),  θᵢ' = max(0, θᵢ - θᵦ),  zero where θ' > θₑ                   (2)
//! cost         I M(Ω) A k,  M(Ω) = ∫ over the cone of directions θₒ widened by θₑ         (3)
//! ```
//!
//! A node knows the box of its lights, a cone of half-angle θₒ around the normals they emit
//! along, the angle θₑ beyond those normals up to which they emit, and the sum I of their peak
//! intensities. θ is the angle between the cone's axis and the direction to the point, θᵦ half
//! the angle that the box fills seen from there, θᵢ the angle of incidence. All angles err
//! toward more importance: a light that contributes is never given none.

use super::cone::Cone;
use crate::surface::LightId;
use kaustika_math::{Bounds3, Vec3, safe_sqrt, sqr};

/// What is known of a light, or of many.
#[derive(Clone, Copy, Debug)]
pub struct LightBounds {
    /// Where they are.
    pub bounds: Bounds3,
    /// The normals they emit along.
    pub cone: Cone,
    /// cos of the angle beyond a normal up to which they emit; at least 0.
    pub cos_emission: f32,
    /// Peak intensity, summed.
    pub intensity: f32,
    /// True if a light emits along its normal and against it.
    pub two_sided: bool,
}

impl LightBounds {
    fn union(&self, o: &LightBounds) -> LightBounds {
        LightBounds {
            bounds: self.bounds.union(o.bounds),
            cone: self.cone.union(&o.cone),
            cos_emission: self.cos_emission.min(o.cos_emission),
            intensity: self.intensity + o.intensity,
            two_sided: self.two_sided || o.two_sided,
        }
    }

    /// (1): how much may arrive at `p`, on a surface of normal `n` if that is not zero.
    fn importance(&self, p: Vec3, n: Vec3) -> f32 {
        let (center, radius) = self.bounds.bounding_sphere();
        let from_center = p - center;
        let d2 = from_center.length_squared();
        // Within the sphere everything may be in any direction, and no distance is known.
        let to_p = from_center.try_normalize().filter(|_| d2 > sqr(radius));
        let Some(to_p) = to_p else { return self.intensity / d2.max(sqr(radius)).max(1e-30) };

        let sin2_b = sqr(radius) / d2;
        let (cos_b, sin_b) = (safe_sqrt(1.0 - sin2_b), sin2_b.sqrt());
        let cos = self.cone.axis.dot(to_p);
        let cos = if self.two_sided { cos.abs() } else { cos };
        let (cos_o, sin_o) = (self.cone.cos, safe_sqrt(1.0 - sqr(self.cone.cos)));
        let (cos, sin) = subtract(cos, safe_sqrt(1.0 - sqr(cos)), cos_o, sin_o);
        let (cos, _) = subtract(cos, sin, cos_b, sin_b);
        if cos < self.cos_emission {
            return 0.0; // (2)
        }
        let mut importance = self.intensity * cos / d2;
        if n != Vec3::ZERO {
            // Light may come through the surface as well as onto it.
            let cos_i = n.abs_dot(to_p);
            importance *= subtract(cos_i, safe_sqrt(1.0 - sqr(cos_i)), cos_b, sin_b).0;
        }
        importance.max(0.0)
    }

    /// (3) for a split of a box with these extents along `axis`.
    fn cost(&self, extents: Vec3, axis: usize) -> f32 {
        let regularity = extents.max_component() / extents[axis];
        // Lights in a line have no area, but some splits of them are better than others.
        let d = self.bounds.diagonal() + Vec3::splat(1e-3 * extents.max_component());
        let area = d.x * d.y + d.y * d.z + d.z * d.x;
        self.intensity * self.cone.measure(self.cos_emission.acos()) * regularity * area
    }
}

/// Cosine and sine of max(0, a - b), for a and b in [0, π].
fn subtract(cos_a: f32, sin_a: f32, cos_b: f32, sin_b: f32) -> (f32, f32) {
    if cos_a > cos_b {
        return (1.0, 0.0);
    }
    (cos_a * cos_b + sin_a * sin_b, (sin_a * cos_b - cos_a * sin_b).max(0.0))
}

/// What a node leads to.
#[derive(Clone, Copy, Debug)]
enum Content {
    /// The first of two neighbouring children.
    Children(u32),
    Light(LightId),
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: LightBounds,
    content: Content,
    parent: u32,
}

/// The hierarchy. Siblings stand side by side, at odd and even places from 1 on; the root is 0.
#[derive(Debug, Default)]
pub struct LightBvh {
    nodes: Vec<Node>,
    /// Leaf of each light of the scene; `u32::MAX` for those that are not in the tree.
    leaves: Vec<u32>,
}

impl LightBvh {
    /// Over the lights given, of a scene that has `count` lights.
    pub fn new(mut lights: Vec<(LightId, LightBounds)>, count: usize) -> LightBvh {
        let mut tree = LightBvh { nodes: Vec::new(), leaves: vec![u32::MAX; count] };
        if lights.is_empty() {
            return tree;
        }
        tree.nodes.reserve(2 * lights.len());
        tree.nodes.push(Node {
            bounds: union_of(&lights),
            content: Content::Children(0),
            parent: u32::MAX,
        });
        let mut open = vec![(0u32, 0usize, lights.len())];
        while let Some((at, start, end)) = open.pop() {
            let part = &mut lights[start..end];
            if let [(id, _)] = part {
                tree.nodes[at as usize].content = Content::Light(*id);
                tree.leaves[id.0 as usize] = at;
                continue;
            }
            let middle = start + split(part, &tree.nodes[at as usize].bounds);
            let first = tree.nodes.len() as u32;
            tree.nodes[at as usize].content = Content::Children(first);
            for (child, range) in [(first, start..middle), (first + 1, middle..end)] {
                let bounds = union_of(&lights[range.clone()]);
                tree.nodes.push(Node { bounds, content: Content::Children(0), parent: at });
                open.push((child, range.start, range.end));
            }
        }
        tree
    }

    /// True without lights.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// A light for the point `p` with normal `n` (zero where there is none), and its
    /// probability; `u` in [0, 1). `None` only if the tree is empty.
    pub fn sample(&self, p: Vec3, n: Vec3, u: f32) -> Option<(LightId, f32)> {
        let mut at = self.nodes.first()?;
        let (mut u, mut pmf) = (u, 1.0);
        loop {
            match at.content {
                Content::Light(id) => return Some((id, pmf)),
                Content::Children(first) => {
                    let q = self.first_share(first, p, n);
                    let (child, q) = if u < q {
                        u /= q;
                        (first, q)
                    } else {
                        u = (u - q) / (1.0 - q);
                        (first + 1, 1.0 - q)
                    };
                    u = u.min(kaustika_math::ONE_MINUS_EPSILON);
                    pmf *= q;
                    at = &self.nodes[child as usize];
                }
            }
        }
    }

    /// Probability of [`LightBvh::sample`] choosing `light` for the same point.
    pub fn pmf(&self, p: Vec3, n: Vec3, light: LightId) -> f32 {
        let Some(&leaf) = self.leaves.get(light.0 as usize) else { return 0.0 };
        if leaf == u32::MAX {
            return 0.0;
        }
        let (mut at, mut pmf) = (leaf, 1.0);
        while at != 0 {
            let first = at - (at + 1) % 2;
            let q = self.first_share(first, p, n);
            pmf *= if at == first { q } else { 1.0 - q };
            at = self.nodes[at as usize].parent;
        }
        pmf
    }

    /// Probability of the first of two siblings. Where neither seems to contribute, as below
    /// the horizon of everything, they are chosen by intensity: probabilities always sum to 1.
    #[inline]
    fn first_share(&self, first: u32, p: Vec3, n: Vec3) -> f32 {
        let [a, b] = [0, 1].map(|i| &self.nodes[first as usize + i].bounds);
        let share = |a: f32, b: f32| Some(a / (a + b)).filter(|q| q.is_finite());
        share(a.importance(p, n), b.importance(p, n))
            .or_else(|| share(a.intensity, b.intensity))
            .unwrap_or(0.5)
    }
}

fn union_of(lights: &[(LightId, LightBounds)]) -> LightBounds {
    let first = lights[0].1;
    lights[1..].iter().fold(first, |sum, (_, b)| sum.union(b))
}

/// Candidate planes an axis.
const BUCKETS: usize = 12;

/// Parts lights in two by the cheapest of the planes; the number in the first part, neither
/// none nor all.
fn split(lights: &mut [(LightId, LightBounds)], all: &LightBounds) -> usize {
    let centers = Bounds3::of_points(lights.iter().map(|(_, b)| b.bounds.center()));
    let extents = all.bounds.diagonal();
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in (0..3).filter(|&a| centers.diagonal()[a] > 0.0) {
        let mut buckets = [None::<LightBounds>; BUCKETS];
        for (_, b) in lights.iter() {
            let slot = &mut buckets[bucket(&centers, axis, b)];
            *slot = Some(slot.map_or(*b, |s| s.union(b)));
        }
        for plane in 1..BUCKETS {
            let joined = |range: &[Option<LightBounds>]| {
                range.iter().flatten().copied().reduce(|a, b| a.union(&b))
            };
            let (Some(below), Some(above)) = (joined(&buckets[..plane]), joined(&buckets[plane..]))
            else {
                continue;
            };
            let cost = below.cost(extents, axis) + above.cost(extents, axis);
            if best.is_none_or(|(c, ..)| cost < c) {
                best = Some((cost, axis, plane));
            }
        }
    }
    // All in one place, or costs that cannot be compared: halves.
    let Some((_, axis, plane)) = best else { return lights.len() / 2 };
    let mut below = 0;
    for i in 0..lights.len() {
        if bucket(&centers, axis, &lights[i].1) < plane {
            lights.swap(i, below);
            below += 1;
        }
    }
    below
}

fn bucket(centers: &Bounds3, axis: usize, b: &LightBounds) -> usize {
    let t = (b.bounds.center()[axis] - centers.min[axis]) / centers.diagonal()[axis];
    ((t * BUCKETS as f32) as usize).min(BUCKETS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_subtracted_and_clamped() {
        for (a, b) in [(1.2f32, 0.5f32), (0.5, 1.2), (3.0, 0.1), (2.9, 2.9), (1.0, 0.0)] {
            let (cos, sin) = subtract(a.cos(), a.sin(), b.cos(), b.sin());
            let want = (a - b).max(0.0);
            assert!((cos - want.cos()).abs() < 1e-6 && (sin - want.sin()).abs() < 1e-6, "{a} {b}");
        }
    }

    #[test]
    fn importance_never_misses_what_a_point_of_the_box_may_send() {
        // A flat light of normal +z spread over a box: some of it may be in front of the point.
        let light = LightBounds {
            bounds: Bounds3::new(Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 0.2)),
            cone: Cone::around(Vec3::Z),
            cos_emission: 0.0,
            intensity: 3.0,
            two_sided: false,
        };
        let n = Vec3::new(0.0, 0.0, -1.0);
        assert!(light.importance(Vec3::new(4.0, 0.0, 0.1), n) > 0.0);
        assert!(light.importance(Vec3::new(0.0, 0.0, 5.0), n) > 0.1);
        // Far behind nothing arrives, but a two-sided light sends as much to both sides.
        assert_eq!(light.importance(Vec3::new(0.0, 0.0, -5.0), n), 0.0);
        let both = LightBounds { two_sided: true, ..light };
        let (up, down) = (Vec3::new(0.3, 0.0, 5.1), Vec3::new(0.3, 0.0, -4.9));
        assert!((both.importance(up, n) / both.importance(down, n) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn lights_in_one_place_and_dark_lights_are_chosen_too() {
        let at = |intensity| LightBounds {
            bounds: Bounds3::of_points([Vec3::ZERO]),
            cone: Cone::ALL,
            cos_emission: 0.0,
            intensity,
            two_sided: false,
        };
        for intensities in [vec![1.0; 9], vec![0.0; 5], vec![1e30, 1e-30, 1.0]] {
            let count = intensities.len();
            let lights = intensities.iter().enumerate();
            let lights = lights.map(|(i, &k)| (LightId(i as u32), at(k))).collect();
            let tree = LightBvh::new(lights, count);
            for p in [Vec3::ZERO, Vec3::new(1e20, 0.0, 0.0), Vec3::X] {
                let pmf = |i| tree.pmf(p, Vec3::ZERO, LightId(i));
                let sum: f32 = (0..count as u32).map(pmf).sum();
                assert!((sum - 1.0).abs() < 1e-5, "{intensities:?} {p:?} {sum}");
                assert!(tree.sample(p, Vec3::ZERO, 0.7).is_some());
            }
        }
        assert!(LightBvh::default().sample(Vec3::ZERO, Vec3::ZERO, 0.5).is_none());
    }
}
