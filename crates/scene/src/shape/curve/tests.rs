//! Curves against closed forms and against themselves.

use super::*;
use crate::description::{CurveSegment, Curves};
use crate::surface::Surface;
use kaustika_math::{Ray, Transform, Vec2, mix_bits, warp};

fn numbers() -> impl FnMut() -> f32 {
    let mut key = 1;
    move || {
        key = mix_bits(key + 0x9e37_79b9_7f4a_7c15);
        (key >> 40) as f32 / 16_777_216.0
    }
}

fn store(profile: CurveProfile, segments: &[CurveSegment]) -> CurveStore {
    let normals = match profile {
        CurveProfile::Ribbon => vec![[Vec3::Z; 2]; segments.len()],
        _ => Vec::new(),
    };
    let mut store = CurveStore::default();
    let curves = Curves { profile, segments: segments.to_vec(), normals };
    store.add(&curves, &Transform::IDENTITY, 0, false);
    store
}

/// The first surface, by trying all pieces.
fn meet(store: &CurveStore, ray: &Ray) -> Option<(u32, Surface)> {
    let space = RaySpace::new(ray)?;
    let hits = (0..store.pieces.len() as u32)
        .filter_map(|i| Some((i, store.intersect(i, &space, f32::INFINITY)?)));
    let (i, hit) = hits.min_by(|a, b| a.1.t.total_cmp(&b.1.t))?;
    Some((i, store.surface((i, i), &hit, ray)))
}

/// A strand that bends and twists, of several segments.
fn strand(radius: f32) -> Vec<CurveSegment> {
    let p: Vec<Vec3> = (0..12)
        .map(|i| {
            let a = i as f32 * 0.9;
            Vec3::new(a.cos() + 0.1 * i as f32, a.sin(), 0.5 * i as f32 - 2.0)
        })
        .collect();
    let segment = |w: &[Vec3]| CurveSegment::from_bspline([w[0], w[1], w[2], w[3]], [radius; 4]);
    p.windows(4).map(segment).collect()
}

/// Point and direction of a strand anywhere along it.
fn anywhere(segments: &[CurveSegment], u: f32) -> (Vec3, Vec3) {
    let s = u * segments.len() as f32;
    let i = (s as usize).min(segments.len() - 1);
    let p = segments[i].points.map(|p| [p.x, p.y, p.z, 0.0].map(f64::from));
    let [c, d, _] = bezier::jet(&p, f64::from(s - i as f32));
    let v = |q: [f64; 4]| Vec3::new(q[0] as f32, q[1] as f32, q[2] as f32);
    (v(c), v(d).normalize())
}

#[test]
fn a_straight_strip_is_a_rectangle_that_faces_the_ray() {
    let s = CurveSegment::straight([Vec3::ZERO, Vec3::X * 2.0], [0.25, 0.25]);
    for profile in [CurveProfile::Flat, CurveProfile::Cylinder] {
        let store = store(profile, &[s]);
        let mut u = numbers();
        let (mut hits, n) = (0, 40_000);
        for _ in 0..n {
            let (x, y) = (u() * 3.0 - 0.5, u() - 0.5);
            // From two sides: the strip turns.
            for (o, d, side) in
                [(Vec3::new(x, y, -5.0), Vec3::Z * 2.0, y), (Vec3::new(x, 4.0, y), -Vec3::Y, y)]
            {
                let inside = (0.0..2.0).contains(&x) && side.abs() < 0.25;
                let near =
                    (x.abs() < 1e-3 || (x - 2.0).abs() < 1e-3) || (side.abs() - 0.25).abs() < 1e-5;
                let hit = meet(&store, &Ray::new(o, d));
                assert!(near || hit.is_some() == inside, "{x} {side} {inside}");
                let Some((_, s)) = hit else { continue };
                hits += 1;
                assert!((s.t * d.length() - if d.z > 0.0 { 5.0 } else { 4.0 }).abs() < 1e-5);
                assert!((s.uv.x - x / 2.0).abs() < 1e-3);
                assert!((s.uv.y - 0.5).abs() * 0.5 - side.abs() < 1e-4);
                assert!(s.ng.dot(d) < 1e-3, "faces away: {:?}", s.ng);
            }
        }
        // Area over that of the window, and four standard errors.
        let p = 2.0 * 0.5 / 3.0;
        let error = (p * (1.0 - p) / (2.0 * n as f32)).sqrt();
        assert!((hits as f32 / (2 * n) as f32 - p).abs() < 4.0 * error);
    }
}

#[test]
fn strips_have_right_handed_frames() {
    // Seen along +z the curve runs along +x; n toward the viewer is -z, n x c' is -y.
    let s = CurveSegment::straight([-Vec3::X, Vec3::X], [0.5, 0.5]);
    let store = store(CurveProfile::Cylinder, &[s]);
    let (piece, s) = meet(&store, &Ray::new(Vec3::new(0.1, -0.25, -3.0), Vec3::Z)).unwrap();
    assert!((s.uv.y - 0.75).abs() < 1e-5);
    // A tube's normal leans outward.
    let lean = (std::f32::consts::PI * 0.25).sin();
    assert!((s.ng - Vec3::new(0.0, -lean, -lean)).length() < 1e-5, "{:?}", s.ng);
    let (dpdu, dpdv) = store.tangents(piece, s.uv, s.ns);
    assert!((dpdu - Vec3::X * 2.0).length() < 1e-4, "{dpdu:?}");
    assert!(dpdu.cross(dpdv).normalize().dot(s.ng) > 0.9999);
}

#[test]
fn ribbons_are_narrowed_by_their_normals_and_keep_their_front() {
    let s = CurveSegment::straight([-Vec3::X, Vec3::X], [0.5, 0.5]);
    let store = store(CurveProfile::Ribbon, &[s]);
    let tilted = |y: f32, d: Vec3| {
        let d = d.normalize();
        let up = d.cross(Vec3::X).normalize();
        meet(&store, &Ray::new(up * y - d * 4.0, d))
    };
    // At 60 degrees from its normal a ribbon is half as wide.
    let d = Vec3::new(0.0, 3f32.sqrt(), -1.0);
    assert!(tilted(0.249, d).is_some() && tilted(0.251, d).is_none());
    for d in [d, -d] {
        let (_, s) = tilted(0.1, d).unwrap();
        assert!((s.ng - Vec3::Z).length() < 1e-5);
    }
}

#[test]
fn no_ray_slips_through_along_a_curve() {
    for radius in [0.2f32, 1e-3] {
        let segments = strand(radius);
        for profile in [CurveProfile::Flat, CurveProfile::Tube] {
            let store = store(profile, &segments);
            assert!(store.pieces.len() > segments.len());
            let mut u = numbers();
            let mut met = 0;
            for i in 0..20_000 {
                // Half of the rays near the ends of pieces.
                // Not near the ends of tubes, through which rays may enter.
                let along = match i % 2 {
                    0 => 0.1 + 0.8 * u(),
                    _ => {
                        let k = 1 + (u() * (store.pieces.len() - 1) as f32) as usize;
                        let p = &store.pieces[k.min(store.pieces.len() - 1)];
                        let u0 = (p.segment as f32 + p.u[0]) / segments.len() as f32;
                        (u0 + (u() - 0.5) * 1e-5).clamp(0.1, 0.9)
                    }
                };
                let (c, t) = anywhere(&segments, along);
                let d = warp::uniform_sphere(Vec2::new(u(), u()));
                if d.dot(t).abs() > 0.6 {
                    continue;
                }
                let across = d.cross(t).normalize() * (radius * 1.8 * (u() - 0.5));
                let ray = Ray::new(c + across - d * 7.0, d);
                assert!(meet(&store, &ray).is_some(), "{profile:?} {radius} {along} {i}");
                met += 1;
            }
            assert!(met > 10_000);
        }
    }
}

#[test]
fn hits_of_tubes_lie_on_them_and_rays_leave() {
    for radius in [0.2f32, 1e-3] {
        let segments = strand(radius);
        let store = store(CurveProfile::Tube, &segments);
        let mut u = numbers();
        for i in 0..5_000 {
            let (c, t) = anywhere(&segments, 0.1 + 0.8 * u());
            let d = warp::uniform_sphere(Vec2::new(u(), u()));
            if d.dot(t).abs() > 0.6 {
                continue;
            }
            let ray = Ray::new(c - d * 9.0, d);
            let Some((piece, s)) = meet(&store, &ray) else { panic!("{i}") };
            assert!((s.p - ray.at(s.t)).length() < 1e-5);
            let (c, t) = anywhere(&segments, s.uv.y);
            assert!(((s.p - c).length() / radius - 1.0).abs() < 2e-6 / radius, "{i}");
            assert!((s.p - c).dot(t).abs() < 3e-6, "{i}");
            let (dpdu, dpdv) = store.tangents(piece, s.uv, s.ns);
            for v in [dpdu, dpdv] {
                assert!(v.normalize().dot(s.ng).abs() < 1e-2, "{i}");
            }
            assert!(dpdu.cross(dpdv).dot(s.ng) != 0.0);
            // Leaving along the normal the same place is not met again.
            let away = s.spawn(s.ng);
            if let Some((_, again)) = meet(&store, &away) {
                assert!(again.t > 0.1 * radius, "{i} {}", again.t);
            }
        }
    }
}

/// A tube whose radius grows evenly is a cone: x² + y² = (r(z))², normal of the cone.
#[test]
fn tapering_tubes_are_cones() {
    let s = CurveSegment::straight([Vec3::ZERO, Vec3::Z * 4.0], [1.0, 0.2]);
    let store = store(CurveProfile::Tube, &[s]);
    let slope = 0.2f32;
    let mut u = numbers();
    let mut hits = 0;
    for _ in 0..5_000 {
        let target = Vec3::new(0.0, 0.0, 0.2 + 3.6 * u());
        let d = warp::uniform_sphere(Vec2::new(u(), u()));
        let o = target - d * 8.0;
        let Some((_, s)) = meet(&store, &Ray::new(o, d)) else { continue };
        hits += 1;
        let rho = (s.p.x * s.p.x + s.p.y * s.p.y).sqrt();
        assert!((rho - (1.0 - slope * s.p.z)).abs() < 1e-5);
        let n = Vec3::new(s.p.x / rho, s.p.y / rho, slope).normalize();
        assert!((s.ng - n).length() < 1e-4, "{:?} {n:?}", s.ng);
        assert!(s.ng.dot(d) < 0.0);
    }
    assert!(hits > 4_000, "{hits}");
}

/// Swept spheres against very many spheres.
#[test]
fn swept_spheres_are_the_union_of_all_spheres() {
    let (a, b, r) = (Vec3::new(0.3, -0.2, 0.1), Vec3::new(1.5, 0.6, -0.4), [0.5f32, 0.2]);
    let store = store(CurveProfile::Spheres, &[CurveSegment::straight([a, b], r)]);
    let nearest = |ray: &Ray| {
        let ts = (0..=2000).filter_map(|i| {
            let w = i as f32 / 2000.0;
            let (c, r) = (a.lerp(b, w) - ray.o, r[0] + (r[1] - r[0]) * w);
            let along = c.dot(ray.d);
            let h = r * r - (c.length_squared() - along * along);
            (h >= 0.0).then(|| along - h.sqrt()).filter(|t| *t > 0.0)
        });
        ts.reduce(f32::min)
    };
    let mut u = numbers();
    let mut hits = 0;
    for _ in 0..4_000 {
        let target = a.lerp(b, u()) + warp::uniform_sphere(Vec2::new(u(), u())) * 0.5;
        let d = warp::uniform_sphere(Vec2::new(u(), u()));
        let ray = Ray::new(target - d * 5.0, d);
        match (meet(&store, &ray), nearest(&ray)) {
            (Some((_, s)), Some(t)) => {
                hits += 1;
                assert!((s.t - t).abs() < 2e-3, "{} {t}", s.t);
                assert!((s.p - ray.at(s.t)).length() < 1e-4);
            }
            (None, None) => {}
            // Grazing rays may pass between the many spheres.
            (Some((_, s)), None) => assert!(s.ng.dot(d).abs() < 0.05),
            (None, Some(t)) => panic!("{t}"),
        }
    }
    assert!(hits > 2_000, "{hits}");
}

#[test]
fn degenerate_curves_are_met_by_nothing() {
    let point = CurveSegment::straight([Vec3::X; 2], [0.0; 2]);
    let thin = CurveSegment::straight([Vec3::ZERO, Vec3::X], [0.0; 2]);
    for profile in [
        CurveProfile::Flat,
        CurveProfile::Cylinder,
        CurveProfile::Ribbon,
        CurveProfile::Tube,
        CurveProfile::Spheres,
    ] {
        let store = store(profile, &[point, thin]);
        for (o, d) in [(Vec3::Z, -Vec3::Z), (-Vec3::X, Vec3::X), (Vec3::ZERO, Vec3::Y)] {
            if let Some((_, s)) = meet(&store, &Ray::new(o + Vec3::X * 0.5, d)) {
                assert!(s.p.is_finite() && s.ng.is_finite(), "{profile:?}");
            }
        }
        assert!((0..store.pieces.len() as u32).all(|i| store.bounds(i).min.is_finite()));
    }
}

#[test]
fn boxes_hold_what_is_met() {
    for profile in [CurveProfile::Flat, CurveProfile::Tube, CurveProfile::Spheres] {
        let store = store(profile, &strand(0.1));
        let mut u = numbers();
        for _ in 0..5_000 {
            let d = warp::uniform_sphere(Vec2::new(u(), u()));
            let target = Vec3::new(u() * 2.0 - 0.5, u() * 2.0 - 1.0, u() * 4.0 - 1.5);
            let Some((i, s)) = meet(&store, &Ray::new(target - d * 6.0, d)) else { continue };
            let b = store.bounds(i);
            let more = Vec3::splat(1e-5);
            assert!(s.p.min(b.min - more) == b.min - more && s.p.max(b.max + more) == b.max + more);
        }
    }
}
