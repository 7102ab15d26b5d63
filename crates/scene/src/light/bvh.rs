//! A hierarchy of lights: chooses in proportion to what each may contribute at a point, in time
//! logarithmic in their number (Conty Estevez & Kulla 2018, "Importance Sampling of Many Lights
//! with Adaptive Tree Splitting"; importance without splitting as Pharr et al. 2023, sec. 12.6).
//!
//! ```text
//! cost         I M(Ω) A k,  M(Ω) = ∫ over the cone of directions θₒ widened by θₑ         (1)
//! ```
//!
//! A node knows the box of its lights, a cone of half-angle θₒ around the normals they emit
//! along, the angle θₑ beyond those normals up to which they emit, and the sum I of their peak
//! intensities. What two siblings may send to a point is computed together: [`Pair`].

use super::cone::Cone;
use super::pair::{Content, Pair, Place};
use crate::surface::LightId;
use kaustika_math::{Bounds3, Vec3};

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

    /// (1) for a split of a box with these extents along `axis`.
    fn cost(&self, extents: Vec3, axis: usize) -> f32 {
        let regularity = extents.max_component() / extents[axis];
        // Lights in a line have no area, but some splits of them are better than others.
        let d = self.bounds.diagonal() + Vec3::splat(1e-3 * extents.max_component());
        let area = d.x * d.y + d.y * d.z + d.z * d.x;
        self.intensity * self.cone.measure(self.cos_emission.acos()) * regularity * area
    }
}

/// A part of the tree: a node and all below it.
#[derive(Clone, Copy, Debug)]
pub struct Branch {
    place: Place,
    content: Content,
}

/// The hierarchy: its inner nodes, each as the pair of its children, the root's first.
#[derive(Debug, Default)]
pub struct LightBvh {
    pairs: Vec<Pair>,
    /// What the root leads to.
    root: Option<Content>,
    /// Place of each light of the scene; `None` for those that are not in the tree.
    places: Vec<Option<Place>>,
}

impl LightBvh {
    /// Over the lights given, of a scene that has `count` lights.
    pub fn new(mut lights: Vec<(LightId, LightBounds)>, count: usize) -> LightBvh {
        let mut tree = LightBvh { pairs: Vec::new(), root: None, places: vec![None; count] };
        if lights.is_empty() {
            return tree;
        }
        tree.pairs.reserve(lights.len() - 1);
        let mut open = vec![(Place::ROOT, 0usize, lights.len())];
        while let Some((place, start, end)) = open.pop() {
            let part = &mut lights[start..end];
            let content = if let [(id, _)] = part {
                tree.places[id.0 as usize] = Some(place);
                Content::Light(*id)
            } else {
                let middle = start + split(part, &union_of(part));
                let ranges = [start..middle, middle..end];
                let pair = tree.pairs.len() as u32;
                let children = ranges.clone().map(|range| union_of(&lights[range]));
                tree.pairs.push(Pair::new(&children, place));
                for (side, range) in ranges.into_iter().enumerate() {
                    open.push((Place::new(pair, side as u32), range.start, range.end));
                }
                Content::Pair(pair)
            };
            match place.pair() {
                Some(parent) => tree.pairs[parent as usize].contents[place.side()] = content,
                None => tree.root = Some(content),
            }
        }
        tree
    }

    /// True without lights.
    pub fn is_empty(&self) -> bool {
        self.root.is_none()
    }

    /// A light for the point `p` with normal `n` (zero where there is none), and its
    /// probability; `u` in [0, 1). `None` only if the tree is empty.
    pub fn sample(&self, p: Vec3, n: Vec3, u: f32) -> Option<(LightId, f32)> {
        Some(self.sample_branch(Branch { place: Place::ROOT, content: self.root? }, p, n, u))
    }

    /// As [`LightBvh::sample`] among the lights of a branch.
    pub fn sample_branch(&self, branch: Branch, p: Vec3, n: Vec3, u: f32) -> (LightId, f32) {
        let mut at = branch.content;
        let (mut u, mut pmf) = (u, 1.0);
        loop {
            match at {
                Content::Light(id) => return (id, pmf),
                Content::Pair(pair) => {
                    let pair = &self.pairs[pair as usize];
                    let q = pair.first_share(p, n);
                    let (side, q) = if u < q {
                        u /= q;
                        (0, q)
                    } else {
                        u = (u - q) / (1.0 - q);
                        (1, 1.0 - q)
                    };
                    u = u.min(kaustika_math::ONE_MINUS_EPSILON);
                    pmf *= q;
                    at = pair.contents[side];
                }
            }
        }
    }

    /// Probability of [`LightBvh::sample`] choosing `light` for the same point.
    pub fn pmf(&self, p: Vec3, n: Vec3, light: LightId) -> f32 {
        let Some(root) = self.root else { return 0.0 };
        self.pmf_in_branch(Branch { place: Place::ROOT, content: root }, p, n, light)
    }

    /// Probability of [`LightBvh::sample_branch`] choosing `light`, which is one of the branch.
    pub fn pmf_in_branch(&self, branch: Branch, p: Vec3, n: Vec3, light: LightId) -> f32 {
        let Some(&Some(mut at)) = self.places.get(light.0 as usize) else { return 0.0 };
        let mut pmf = 1.0;
        while let (Some(pair), true) = (at.pair(), at != branch.place) {
            let pair = &self.pairs[pair as usize];
            let q = pair.first_share(p, n);
            pmf *= if at.side() == 0 { q } else { 1.0 - q };
            at = pair.place;
        }
        pmf
    }

    /// The tree cut into branches, at most `most` ≥ 1: the brightest is halved again and again.
    pub fn branches(&self, most: usize) -> Vec<Branch> {
        let Some(root) = self.root else { return Vec::new() };
        let mut branches = vec![(f32::INFINITY, Branch { place: Place::ROOT, content: root })];
        while branches.len() < most {
            let inner = branches.iter().enumerate().filter_map(|(i, (intensity, branch))| {
                match branch.content {
                    Content::Pair(pair) => Some((*intensity, i, pair)),
                    Content::Light(_) => None,
                }
            });
            let Some((_, i, pair)) = inner.max_by(|a, b| a.0.total_cmp(&b.0)) else { break };
            branches.swap_remove(i);
            let children = &self.pairs[pair as usize];
            branches.extend([0, 1].map(|side| {
                let place = Place::new(pair, side as u32);
                (children.intensity[side], Branch { place, content: children.contents[side] })
            }));
        }
        branches.into_iter().map(|(_, branch)| branch).collect()
    }

    /// Which of the branches a light is in; `None` if it is not in the tree.
    pub fn branch_of(&self, branches: &[Branch], light: LightId) -> Option<usize> {
        let mut at = self.places.get(light.0 as usize).copied().flatten()?;
        loop {
            if let Some(i) = branches.iter().position(|b| b.place == at) {
                return Some(i);
            }
            at = self.pairs[at.pair()? as usize].place;
        }
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
