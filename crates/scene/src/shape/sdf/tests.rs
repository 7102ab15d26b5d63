use super::*;
use kaustika_accel::BoxBvh;
use kaustika_math::{mix_bits, warp};

/// Numbers in [0, 1) of a fixed sequence.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f32 {
        self.0 = mix_bits(self.0 + 0x9e37_79b9_7f4a_7c15);
        (self.0 >> 40) as f32 / 16_777_216.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }

    fn direction(&mut self) -> Vec3 {
        warp::uniform_sphere(Vec2::new(self.next(), self.next()))
    }
}

/// Samples of `f` over the unit cube.
fn sampled(n: [u32; 3], normals: SdfNormals, f: impl Fn(Vec3) -> f32) -> Arc<SdfGrid> {
    let at = |i: u32, n: u32| i as f32 / (n - 1) as f32;
    let values = (0..n[2])
        .flat_map(|z| (0..n[1]).flat_map(move |y| (0..n[0]).map(move |x| [x, y, z])))
        .map(|[x, y, z]| f(Vec3::new(at(x, n[0]), at(y, n[1]), at(z, n[2]))))
        .collect();
    Arc::new(SdfGrid { resolution: n, values, normals })
}

fn store(grid: &Arc<SdfGrid>, to_world: Transform) -> SdfStore {
    let mut store = SdfStore::default();
    store.add(grid, to_world, 0, false);
    store
}

/// The first hit of all cells, without a hierarchy.
fn first(store: &SdfStore, ray: &Ray) -> Option<(u32, SdfHit)> {
    let hits = (0..store.cells.len() as u32)
        .filter_map(|c| Some((c, store.intersect(c, ray, f32::INFINITY)?)));
    hits.min_by(|a, b| a.1.t.total_cmp(&b.1.t))
}

/// Noise, whose surface has all the cases that eight corners can make.
fn noise() -> Arc<SdfGrid> {
    let grid = sampled([7, 5, 6], SdfNormals::Smooth, |_| 0.0);
    let mut draw = Draw(5);
    // A share of exact zeros and of equal values.
    let values = grid.values.iter().map(|_| match draw.next() {
        u if u < 0.05 => 0.0,
        u if u < 0.2 => 0.25,
        _ => draw.next() - 0.5,
    });
    Arc::new(SdfGrid { values: values.collect(), ..grid.as_ref().clone() })
}

fn crooked() -> Transform {
    Transform::translate(Vec3::new(20.0, -3.0, 5.0))
        * Transform::rotate(33.0, Vec3::new(1.0, 2.0, 3.0)).unwrap()
        * Transform::scale(Vec3::new(2.0, 1.0, -0.5)).unwrap()
}

#[test]
fn a_linear_distance_is_a_plane() {
    // Offsets of no cell's border, of a border, and just beside one.
    for offset in [0.437f32, 0.5, 0.500_01] {
        for (axis, tilt) in [(2, 0.0), (0, 0.0), (2, 0.3)] {
            let f = |p: Vec3| p[axis] - offset + tilt * (p.x - 0.5);
            let grid = sampled([5, 9, 7], SdfNormals::Smooth, f);
            let store = store(&grid, Transform::IDENTITY);
            let mut draw = Draw(1);
            for i in 0..3000 {
                let mut target = draw.vector() * 0.98 + Vec3::splat(0.01);
                if i % 3 == 0 {
                    // Through the cells' own borders.
                    target = Vec3::new(
                        (target.x * 4.0).round() / 4.0,
                        (target.y * 8.0).round() / 8.0,
                        0.4,
                    );
                }
                target[axis] += (-f(target)) / if axis == 0 { 1.0 + tilt } else { 1.0 };
                let mut d = draw.direction();
                if i % 5 == 0 {
                    d = Vec3::ZERO;
                    d[axis] = -1.0;
                }
                let slope = d[axis] + tilt * d.x;
                let within = (0..3).all(|k| (0.005..0.995).contains(&target[k]));
                if !within || slope.abs() < 0.05 {
                    continue;
                }
                let ray = Ray::new(target - d * 2.5, d);
                let inside = Bounds3::new(Vec3::splat(-2e-6), Vec3::splat(1.000_002));
                let (cell, hit) = first(&store, &ray).unwrap_or_else(|| panic!("{i} {target:?}"));
                assert!(inside.contains(hit.p) && (hit.t - 2.5).abs() < 2e-5, "{i} {}", hit.t);
                let s = store.surface((cell, 0), &hit, 0.0);
                let mut n = Vec3::ZERO;
                n[axis] = 1.0;
                let n = (n + Vec3::X * tilt).normalize();
                assert!((s.ng - n).length() < 1e-4 && (s.ns - n).length() < 1e-4, "{:?}", s.ns);
            }
        }
    }
}

/// The first hit is the first change of sign that small steps along the ray find.
#[test]
fn first_hits_are_those_of_small_steps() {
    let grid = noise();
    let store = store(&grid, Transform::IDENTITY);
    let field = &store.grids[0];
    let mut draw = Draw(2);
    let (mut hits, mut missed) = (0, 0);
    for i in 0..4000 {
        let inside = i % 2 == 0;
        let o = if inside { draw.vector() } else { draw.direction() * 3.0 + Vec3::splat(0.5) };
        let ray =
            Ray::new(o, if inside { draw.direction() } else { (draw.vector() - o).normalize() });
        let found = first(&store, &ray).map(|h| f64::from(h.1.t));
        if let Some((_, hit)) = first(&store, &ray) {
            hits += 1;
            assert!(field.value(field.in_cells(hit.p)).abs() < 5e-6, "{i}");
        }
        let mut before = None;
        let mut stepped = None;
        const STEP: f64 = 5e-4;
        for k in 0..12_000 {
            let t = f64::from(k) * STEP;
            let p = ray.o + ray.d * t as f32;
            if !Bounds3::new(Vec3::ZERO, Vec3::splat(1.0)).contains(p) {
                if before.is_some() {
                    break;
                }
                continue;
            }
            let sign = field.value(field.in_cells(p)) > 0.0;
            if before.is_some_and(|b| b != sign) {
                stepped = Some(t);
                break;
            }
            before = Some(sign);
        }
        match (found, stepped) {
            (None, None) => {}
            // Small steps pass over two changes close to one another, never the other way around.
            (Some(a), b) if b.is_none_or(|b| a < b - 2.0 * STEP) => missed += 1,
            (Some(a), Some(b)) => assert!((a - b).abs() < 2.0 * STEP, "{i}: {a} {b}"),
            (a, b) => panic!("{i}: {a:?} {b:?}"),
        }
    }
    assert!(hits > 2500 && missed < 40, "{hits} {missed}");
}

#[test]
fn boxes_hold_the_surface_and_no_more() {
    let grid = noise();
    for to_world in [Transform::IDENTITY, crooked()] {
        let store = store(&grid, to_world);
        let bounds: Vec<Bounds3> = (0..store.cells.len() as u32).map(|c| store.bounds(c)).collect();
        let bvh = BoxBvh::build(&bounds);
        let mut draw = Draw(3);
        let mut touched = vec![Bounds3::EMPTY; bounds.len()];
        for i in 0..60_000 {
            let o = to_world.point(draw.direction() * 2.0 + Vec3::splat(0.5));
            let target = to_world.point(draw.vector());
            let ray = Ray::new(o, target - o);
            let all = first(&store, &ray);
            let tree = bvh.intersect(&ray, f32::INFINITY, |c, t_max| {
                store.intersect(c, &ray, t_max).map(|h| (h.t, h))
            });
            assert_eq!(all.map(|h| h.1), tree.map(|h| h.2), "{i}");
            if let Some((cell, hit)) = all {
                let b = &mut touched[cell as usize];
                *b = b.with_point(to_world.point(hit.p));
            }
        }
        if to_world.is_identity() {
            // Cells met often fill their boxes.
            let large = bounds.iter().zip(&touched).filter(|(_, t)| !t.is_empty());
            let filled =
                large.filter(|(b, t)| (0..3).all(|k| t.diagonal()[k] > 0.5 * b.diagonal()[k]));
            assert!(filled.count() > bounds.len() / 2);
        }
    }
}

/// A ray that leaves the surface does not meet it where it left.
#[test]
fn rays_leave_the_surface() {
    let grid = sampled([24, 20, 28], SdfNormals::Smooth, |p| (p - Vec3::splat(0.5)).length() - 0.4);
    let to_world = crooked();
    let store = store(&grid, to_world);
    let bounds: Vec<Bounds3> = (0..store.cells.len() as u32).map(|c| store.bounds(c)).collect();
    let bvh = BoxBvh::build(&bounds);
    let meet = |ray: &Ray| {
        bvh.intersect(ray, f32::INFINITY, |c, t| store.intersect(c, ray, t).map(|h| (h.t, h)))
    };
    let mut draw = Draw(4);
    for i in 0..20_000 {
        let o = to_world.point(draw.direction() * 2.0 + Vec3::splat(0.5));
        let target = to_world.point(draw.direction() * 0.3 + Vec3::splat(0.5));
        let ray = Ray::new(o, (target - o).normalize());
        let (_, cell, hit) = meet(&ray).expect("the ball is met");
        let s = store.surface((cell, 0), &hit, 0.0);
        assert!((s.p - ray.at(hit.t)).length() < 1e-4);
        // The exact ball's normal, up to what cells leave of its curvature.
        let exact = to_world.inverse().point(s.p) - Vec3::splat(0.5);
        let own = |n: Vec3| to_world.inverse().normal(n).normalize().dot(exact.normalize());
        assert!(own(s.ng) > 0.99 && own(s.ns) > 0.9995, "{i} {} {}", own(s.ng), own(s.ns));
        let exact = to_world.normal(exact).normalize();
        let d = draw.direction();
        // Facets of a ball are convex but for the saddles of cells: out is out, in comes out again.
        let away = if d.dot(s.ng) < 0.0 { -d } else { d };
        if away.dot(exact) > 0.3 && away.dot(s.ng) > 0.3 {
            assert!(meet(&s.spawn(away)).is_none(), "{i}");
            let inward = -away;
            let through = meet(&s.spawn(inward)).expect("out on the other side");
            assert!(through.0 > 0.01, "{i} {}", through.0);
        }
    }
}

#[test]
fn smooth_normals_do_not_jump_and_analytic_ones_do() {
    let bumpy = |p: Vec3| p.z - 0.5 - 0.08 * (9.0 * p.x).sin() * (7.0 * p.y).cos();
    let jump = |normals| {
        let store = store(&sampled([9, 9, 9], normals, bumpy), Transform::IDENTITY);
        let normal = |x: f32| {
            let ray = Ray::new(Vec3::new(x, 0.377, 1.0), -Vec3::Z);
            let (cell, hit) = first(&store, &ray).unwrap();
            store.surface((cell, 0), &hit, 0.0).ns
        };
        let border = |i: u32| i as f32 / 16.0;
        let jump = |x: f32| (normal(x - 1e-5) - normal(x + 1e-5)).length();
        (1..15).map(|i| jump(border(i))).fold(0.0, f32::max)
    };
    assert!(jump(SdfNormals::Smooth) < 2e-3, "{}", jump(SdfNormals::Smooth));
    assert!(jump(SdfNormals::Analytic) > 0.05);
}
