//! Distances in proportion to the light of a lamp: 1/d² along a ray.
//!
//! ```text
//! p(t) = D / ((θ_b - θ_a) (D² + (t - δ)²)),   t = δ + D tan θ,  θ uniform in [θ_a, θ_b]    (1)
//! ```
//!
//! D is the lamp's distance from the ray and δ where the ray is nearest to it (Kulla & Fajardo
//! 2012, "Importance sampling techniques for path tracing in participating media"; the idea is
//! Rief et al.'s, 1984).

use kaustika_math::{Ray, Vec3};

/// Distances along a part of a ray as a lamp lights it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Equiangular {
    near: f32,
    distance: f32,
    from: f32,
    to: f32,
}

impl Equiangular {
    /// For a lamp at `p` and the part of the ray from `t0` to `t1`, which may be infinite.
    pub(super) fn new(ray: &Ray, p: Vec3, t0: f32, t1: f32) -> Option<Equiangular> {
        let to_lamp = p - ray.o;
        let near = to_lamp.dot(ray.d);
        let across = (to_lamp - ray.d * near).length();
        // A ray through the lamp: any width does that is less than what can be told apart.
        let distance = across.max(1e-4 * to_lamp.length()).max(f32::MIN_POSITIVE);
        let angle = |t: f32| ((t - near) / distance).atan();
        let (from, to) = (angle(t0), angle(t1));
        (to - from > 1e-6).then_some(Equiangular { near, distance, from, to })
    }

    /// A distance.
    pub(super) fn sample(&self, u: f32) -> f32 {
        self.near + self.distance * (self.from + u * (self.to - self.from)).tan()
    }

    /// Its density.
    pub(super) fn pdf(&self, t: f32) -> f32 {
        let (d, x) = (self.distance, t - self.near);
        d / ((self.to - self.from) * (d * d + x * x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn density_integrates_to_one_and_is_that_of_the_samples() {
        let ray = Ray::new(Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.0, 0.6, 0.8));
        for (p, t0, t1) in [
            (Vec3::new(0.3, 1.0, 1.0), 0.0, 4.0),
            (Vec3::new(-2.0, 0.0, 0.0), 0.5, 1.5),
            // On the ray.
            (Vec3::new(0.1, 0.8, 1.1), 0.25, 3.0),
            (Vec3::new(0.3, 1.0, 1.0), 0.0, f32::INFINITY),
        ] {
            let e = Equiangular::new(&ray, p, t0, t1).expect("it has an extent");
            // The distribution function from the density, by steps that follow the samples.
            const N: usize = 20_000;
            let (mut sum, mut last) = (0.0f64, t0);
            for i in 1..N {
                let u = i as f32 / N as f32;
                let t = e.sample(u);
                assert!(t >= last && t <= t1, "{p:?} {u}: {t}");
                let middle = 0.5 * (last + t);
                let mean = (e.pdf(last) + 4.0 * e.pdf(middle) + e.pdf(t)) / 6.0;
                sum += mean as f64 * (t - last) as f64;
                last = t;
                if i % 1000 == 0 {
                    assert!((sum - u as f64).abs() < 1e-3, "{p:?}: {sum} at {u}");
                }
            }
            let beside = Equiangular::new(&ray, ray.o, 0.25, 3.0);
            assert!(beside.is_none(), "a lamp where the ray begins, and not on this part");
        }
    }
}
