//! pbrt-v4's cloud: a density from noise (media.h, `CloudMedium`).
//!
//! ```text
//! q = f p + Σ_{i<2} ω_i ∇n(λ_i q),  ω_0 = 0.05 w,  λ_0 = 10                      (1)
//! s = Σ_{i<5} 2^{-(i+1)} n(λ_i q),  λ_0 = 1                                      (2)
//! d = clamp(4.5 ρ (1 - y) s, 0, 1) + 2 max(0, ½ - y),  at most 1                 (3)
//! ```
//!
//! n is Perlin's noise, f the frequency, w the wispiness, ρ the density; ω halves and λ grows by
//! 1.99 from term to term. In (1) each term is added before the next is taken.

use crate::description::CloudDesc;
use crate::texture::perlin;
use kaustika_math::{Bounds3, Transform, Vec3};

/// A cloud that can be asked at any point of the world.
#[derive(Debug)]
pub(super) struct Cloud {
    desc: CloudDesc,
    to_own: Transform,
}

/// From one term of a sum of noise to the next.
const LACUNARITY: f32 = 1.99;
/// No less than (2): |n| is at most 1.
const MOST_NOISE: f32 = 31.0 / 32.0;

impl Cloud {
    pub(super) fn new(desc: &CloudDesc) -> Cloud {
        Cloud { desc: *desc, to_own: desc.to_world.inverse() }
    }

    /// The density at a point of the world, in [0, 1].
    pub(super) fn number(&self, p: Vec3) -> f32 {
        let p = self.to_own.point(p);
        let mut q = p * self.desc.frequency;
        if self.desc.wispiness > 0.0 {
            let (mut omega, mut lambda) = (0.05 * self.desc.wispiness, 10.0);
            for _ in 0..2 {
                q += slope(q * lambda) * omega; // (1)
                omega *= 0.5;
                lambda *= LACUNARITY;
            }
        }
        let (mut sum, mut omega, mut lambda) = (0.0, 0.5, 1.0);
        for _ in 0..5 {
            sum += omega * perlin(q * lambda); // (2)
            omega *= 0.5;
            lambda *= LACUNARITY;
        }
        self.shaped(p.y, sum)
    }

    /// (3)
    fn shaped(&self, y: f32, noise: f32) -> f32 {
        let puffs = ((1.0 - y) * 4.5 * self.desc.density * noise).clamp(0.0, 1.0);
        (puffs + 2.0 * (0.5 - y).max(0.0)).clamp(0.0, 1.0)
    }

    /// No less than any value at the points of a box of the world.
    pub(super) fn bound(&self, corners: impl Iterator<Item = Vec3>) -> f32 {
        let own = Bounds3::of_points(corners.map(|p| self.to_own.point(p)));
        // Largest where it is lowest, and above y = 1 where it is highest with noise below 0.
        let at = |y: f32| self.shaped(y, MOST_NOISE).max(self.shaped(y, -MOST_NOISE));
        at(own.min.y).max(at(own.max.y))
    }
}

/// ∇n by differences over 0.01, as pbrt takes them.
fn slope(p: Vec3) -> Vec3 {
    const STEP: f32 = 0.01;
    let n = perlin(p);
    let toward = |axis: Vec3| (perlin(p + axis * STEP) - n) / STEP;
    Vec3::new(toward(Vec3::X), toward(Vec3::Y), toward(Vec3::Z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn densities_lie_below_their_bounds_and_thin_out_upward() {
        let desc = CloudDesc {
            density: 1.3,
            wispiness: 0.8,
            frequency: 4.0,
            to_world: Transform::translate(Vec3::X * 3.0),
        };
        let cloud = Cloud::new(&desc);
        let mut means = [0.0; 4];
        let mut between = 0;
        for i in 0..4000u64 {
            let unit =
                |k: u64| (kaustika_math::mix_bits(8 * i + k) >> 40) as f32 / (1 << 24) as f32;
            let layer = i as usize % 4;
            let p = Vec3::new(3.0 + unit(1), 0.3 + 0.2 * (layer as f32 + unit(2)), unit(3));
            let d = cloud.number(p);
            means[layer] += d / 1000.0;
            between += usize::from(d > 0.0 && d < 1.0);
            let b = Bounds3::new(p - Vec3::splat(0.1), p + Vec3::splat(0.05));
            let bound = cloud.bound((0..8).map(|k| b.corner(k)));
            assert!((0.0..=bound).contains(&d), "{d} of {bound}");
        }
        assert!(means[0] > means[1] && means[1] > means[2] && means[2] > means[3], "{means:?}");
        assert!(between > 800, "{between}");
        // Solid below, nothing above.
        assert_eq!(cloud.number(Vec3::new(3.2, -0.1, 0.4)), 1.0);
        assert_eq!(cloud.bound([Vec3::new(3.2, 1.0, 0.4)].into_iter()), 0.0);
    }
}
