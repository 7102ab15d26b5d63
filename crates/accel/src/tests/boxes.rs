//! The tree of boxes against testing every primitive: spheres here.

use kaustika_math::{Bounds3, Ray, Vec3};

use super::meshes::Random;
use crate::BoxBvh;

#[derive(Clone, Copy)]
struct Sphere {
    c: Vec3,
    r: f32,
}

impl Sphere {
    /// The nearest t in (0, t_max), in double precision.
    fn intersect(&self, ray: &Ray, t_max: f32) -> Option<f32> {
        let v = |v: Vec3| [f64::from(v.x), f64::from(v.y), f64::from(v.z)];
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (o, d, c) = (v(ray.o), v(ray.d), v(self.c));
        let oc = [0, 1, 2].map(|i| o[i] - c[i]);
        let (a, b) = (dot(d, d), dot(oc, d));
        let k = dot(oc, oc) - f64::from(self.r) * f64::from(self.r);
        let root = (b * b - a * k).sqrt();
        [(-b - root) / a, (-b + root) / a]
            .map(|t| t as f32)
            .into_iter()
            .find(|t| *t > 0.0 && *t < t_max)
    }
}

#[test]
fn queries_equal_brute_force() {
    for (n, scale) in [(1, 1.0), (7, 1.0), (50, 1.0), (2000, 1.0), (300, 1e6), (300, 1e-6)] {
        let mut r = Random::new(n);
        let mut spheres: Vec<Sphere> =
            (0..n).map(|_| Sphere { c: r.cube() * scale, r: 0.15 * r.unit() * scale }).collect();
        // Some twice: hits at equal distances.
        spheres.extend(spheres.clone().iter().step_by(3));
        let bounds: Vec<Bounds3> = spheres
            .iter()
            .map(|s| Bounds3 { min: s.c - Vec3::splat(s.r), max: s.c + Vec3::splat(s.r) })
            .collect();
        let bvh = BoxBvh::build(&bounds);
        assert_eq!(bvh.primitive_count(), spheres.len());
        let mut hits = 0;
        for i in 0..20_000 {
            let length = [1.0, 1e-9, 1e9][r.below(3)];
            let mut d = r.direction() * length;
            if i % 4 == 0 {
                d[r.below(3)] = 0.0;
            }
            let ray = Ray::new(r.cube() * (1.5 * scale), d);
            let t_max = if i % 2 == 0 { f32::INFINITY } else { scale * r.unit() / length };
            let expected = spheres
                .iter()
                .enumerate()
                .filter_map(|(i, s)| Some((s.intersect(&ray, t_max)?, i as u32)))
                .reduce(|a, b| if b.0 < a.0 { b } else { a });
            let got = bvh.intersect(&ray, t_max, |prim, t_max| {
                let t = spheres[prim as usize].intersect(&ray, t_max)?;
                Some((t, prim))
            });
            assert_eq!(got, expected.map(|(t, i)| (t, i, i)), "{n} {i}: {ray:?} to {t_max}");
            let any = bvh
                .any(&ray, t_max, |p, t_max| spheres[p as usize].intersect(&ray, t_max).is_some());
            assert_eq!(any, expected.is_some(), "{n} {i}: {ray:?} to {t_max}");
            hits += usize::from(any);
        }
        assert!(hits > 20, "only {hits} hits");
    }
}
