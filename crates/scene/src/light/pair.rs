//! Two siblings of the hierarchy of lights, weighed against each other.
//!
//! ```text
//! importance   I cos θ' cos θᵢ' / d²                                                      (1)
//! θ' = max(0, θ - θₒ - θᵦ),  θᵢ' = max(0, θᵢ - θᵦ),  zero where θ' > θₑ                   (2)
//! ```
//!
//! I, θₒ and θₑ are those of [`LightBounds`]. θ is the angle between the cone's axis and the
//! direction to the point, θᵦ half the angle that the sphere about the box fills seen from
//! there, θᵢ the angle of incidence. All angles err toward more importance: a light that
//! contributes is never given none. Angles are kept as cosine and sine, and both siblings go
//! through the same operations without a branch, lane by lane.

use super::bvh::LightBounds;
use crate::surface::LightId;
use kaustika_math::{Vec3, safe_sqrt, sqr};

/// Where a node stands: which child of which pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place(u32);

impl Place {
    /// Not a child.
    pub const ROOT: Place = Place(u32::MAX);

    /// Child 0 or 1 of a pair.
    pub fn new(pair: u32, side: u32) -> Place {
        Place(2 * pair + side)
    }

    /// The pair; `None` of the root.
    #[inline]
    pub fn pair(self) -> Option<u32> {
        (self != Place::ROOT).then_some(self.0 / 2)
    }

    /// 0 or 1.
    #[inline]
    pub fn side(self) -> usize {
        self.0 as usize % 2
    }
}

/// What a node leads to.
#[derive(Clone, Copy, Debug)]
pub(super) enum Content {
    /// The pair of its children.
    Pair(u32),
    Light(LightId),
}

/// Two siblings, as an array over both of each number that the importance needs: two cache
/// lines in all.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Pair {
    /// Centre and radius of the sphere about the box.
    center: [[f32; 2]; 3],
    radius: [f32; 2],
    axis: [[f32; 2]; 3],
    /// -1 if emission against the axis counts as emission along it, else 1.
    mirror: [f32; 2],
    cos_cone: [f32; 2],
    sin_cone: [f32; 2],
    cos_emission: [f32; 2],
    pub intensity: [f32; 2],
    /// The importance of either within its sphere.
    within: [f32; 2],
    /// What each of the two leads to.
    pub contents: [Content; 2],
    /// Where their parent stands.
    pub place: Place,
}

impl Pair {
    /// Of two children that lead nowhere yet, with a parent at `place`.
    pub fn new(children: &[LightBounds; 2], place: Place) -> Pair {
        let spheres = children.map(|c| c.bounds.bounding_sphere());
        Pair {
            center: std::array::from_fn(|k| spheres.map(|(c, _)| c[k])),
            radius: spheres.map(|(_, r)| r),
            axis: std::array::from_fn(|k| children.map(|c| c.cone.axis[k])),
            mirror: children.map(|c| if c.two_sided { -1.0 } else { 1.0 }),
            cos_cone: children.map(|c| c.cone.cos),
            sin_cone: children.map(|c| safe_sqrt(1.0 - sqr(c.cone.cos))),
            cos_emission: children.map(|c| c.cos_emission),
            intensity: children.map(|c| c.intensity),
            within: [0, 1].map(|i| children[i].intensity / near(spheres[i].1)),
            contents: [Content::Pair(u32::MAX); 2],
            place,
        }
    }

    /// (1): how much may arrive from each at `p`, on a surface of normal `n` if that is not zero.
    #[inline]
    pub fn importance(&self, p: Vec3, n: Vec3) -> [f32; 2] {
        let free = n == Vec3::ZERO;
        [self.importance_of(0, p, n, free), self.importance_of(1, p, n, free)]
    }

    /// One lane of [`Pair::importance`].
    #[inline(always)]
    fn importance_of(&self, i: usize, p: Vec3, n: Vec3, free: bool) -> f32 {
        let [x, y, z] = &self.center;
        let d = Vec3::new(p.x - x[i], p.y - y[i], p.z - z[i]);
        let d2 = d.length_squared();
        let inverse = 1.0 / d2.sqrt();
        let sin_b = self.radius[i] * inverse;
        let cos_b = safe_sqrt(1.0 - sqr(sin_b));

        let [x, y, z] = &self.axis;
        let cos = Vec3::new(x[i], y[i], z[i]).dot(d) * inverse;
        let cos = cos.max(self.mirror[i] * cos);
        let (cos, sin) = (cos, safe_sqrt(1.0 - sqr(cos)));
        let (cos, sin) = subtract(cos, sin, self.cos_cone[i], self.sin_cone[i]);
        let (cos, _) = subtract(cos, sin, cos_b, sin_b);

        // Light may come through the surface as well as onto it.
        let cos_i = n.abs_dot(d) * inverse;
        let incidence = subtract(cos_i, safe_sqrt(1.0 - sqr(cos_i)), cos_b, sin_b).0;
        let incidence = if free { 1.0 } else { incidence };

        let outside = (self.intensity[i] * cos * sqr(inverse) * incidence).max(0.0);
        let outside = if cos < self.cos_emission[i] { 0.0 } else { outside }; // (2)
        // Within the sphere everything may be in any direction, and no distance is known.
        if d2 > near(self.radius[i]) { outside } else { self.within[i] }
    }

    /// Probability of the first. Where neither seems to contribute, as below the horizon of
    /// everything, they are chosen by intensity: probabilities always sum to 1.
    #[inline]
    pub fn first_share(&self, p: Vec3, n: Vec3) -> f32 {
        let share = |[a, b]: [f32; 2]| Some(a / (a + b)).filter(|q| q.is_finite());
        share(self.importance(p, n)).or_else(|| share(self.intensity)).unwrap_or(0.5)
    }
}

/// The square of a sphere's radius, and not zero.
#[inline]
fn near(radius: f32) -> f32 {
    sqr(radius).max(1e-30)
}

/// Cosine and sine of max(0, a - b), for a and b in [0, π].
#[inline]
fn subtract(cos_a: f32, sin_a: f32, cos_b: f32, sin_b: f32) -> (f32, f32) {
    let (cos, sin) = (cos_a * cos_b + sin_a * sin_b, (sin_a * cos_b - cos_a * sin_b).max(0.0));
    if cos_a > cos_b { (1.0, 0.0) } else { (cos, sin) }
}

#[cfg(test)]
mod tests {
    use super::super::cone::Cone;
    use super::*;
    use kaustika_math::Bounds3;

    #[test]
    fn a_pair_takes_two_cache_lines() {
        assert_eq!(size_of::<Pair>(), 128);
    }

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
        let both = LightBounds { two_sided: true, ..light };
        let pair = Pair::new(&[light, both], Place::ROOT);
        assert!(pair.importance(Vec3::new(4.0, 0.0, 0.1), n)[0] > 0.0);
        assert!(pair.importance(Vec3::new(0.0, 0.0, 5.0), n)[0] > 0.1);
        // Far behind nothing arrives, but a two-sided light sends as much to both sides.
        assert_eq!(pair.importance(Vec3::new(0.0, 0.0, -5.0), n)[0], 0.0);
        let (up, down) = (Vec3::new(0.3, 0.0, 5.1), Vec3::new(0.3, 0.0, -4.9));
        let [up, down] = [up, down].map(|p| pair.importance(p, n)[1]);
        assert!((up / down - 1.0).abs() < 1e-5);
    }
}
