//! Instances: the same as the scene written out.

use crate::scenes::*;
use crate::stats::same;
use kaustika_math::Transform;
use kaustika_math::Vec3;
use kaustika_scene::description::*;
use serde_json::json;

/// Shapes of a group: analytic, mesh and with a cut-out.
fn group(stage: &mut Stage) -> Vec<ShapeDesc> {
    let (grey, glass, metal) = (stage.diffuse(0.7), stage.glass(1.5, 0.0), stage.metal(0.2));
    let alpha = stage.d.float(0.6);
    let mut veil = shape(disk(0.4), at(0.0, 0.0, 0.7), grey);
    veil.alpha = Some(alpha);
    let tube = GeometryDesc::Cylinder { radius: 0.2, z_min: 0.0, z_max: 0.5, phi_max: 360.0 };
    let two_sided = stage.two_sided(grey);
    vec![
        shape(GeometryDesc::Cube, at(-0.3, 0.0, 0.2) * scale(0.2, 0.2, 0.2), metal),
        shape(sphere(0.25), at(0.3, 0.0, 0.25), glass),
        shape(tube, at(0.0, 0.4, 0.0), two_sided),
        veil,
    ]
}

fn placements() -> Vec<Transform> {
    vec![
        at(-0.7, 0.0, 0.05),
        at(0.7, 0.2, 0.05) * rotate(130.0, Vec3::Z) * scale(0.8, 0.8, 1.3),
        at(0.1, 1.0, 0.4) * rotate(40.0, v(1.0, 1.0, 0.2)) * scale(-1.0, 1.0, 1.0),
    ]
}

pub fn stages() -> (Stage, Stage) {
    let mut stage = Stage::new();
    floor(&mut stage);
    let shapes = group(&mut stage);
    stage.lamp(disk(0.5), at(0.0, 0.0, 2.5) * down(), 6.0);
    stage.point_light(v(1.0, -1.5, 1.5), 2.0);
    stage.sky(0.2);
    stage.camera(pinhole(50.0), look(v(0.0, -3.5, 1.8), v(0.0, 0.2, 0.2)), [10, 8]);
    let (mut flat, mut instanced) = (stage.clone(), stage);
    for transform in placements() {
        instanced.d.instances.push(InstanceDesc {
            group: GroupId(0),
            transform,
            motion: Vec::new(),
            span: None,
        });
        flat.d.shapes.extend(shapes.iter().map(|s| {
            let mut s = s.clone();
            s.transform = transform * s.transform;
            s
        }));
    }
    instanced.d.groups.push(GroupDesc { name: String::new(), shapes });
    (flat, instanced)
}

#[test]
fn surfaces_are_the_same() {
    let (flat, instanced) = stages();
    let (flat, instanced) = (flat.build(), instanced.build());
    let mut random = crate::stats::Random::new(4);
    let mut met = 0;
    for _ in 0..20_000 {
        let o = v(0.0, 0.3, 0.5) + random.v3().normalize() * 3.0;
        let target = v(0.0, 0.3, 0.3) + random.v3();
        let ray = kaustika_math::Ray::new(o, (target - o).normalize());
        // Cut-outs are decided by the bits of the ray, which a placement changes: not here.
        let solid = |s: &kaustika_scene::Scene| {
            let hit = s.geometry.intersect(&ray, f32::INFINITY, |_, _| true)?;
            Some(s.geometry.surface(&hit, &ray))
        };
        match (solid(&flat), solid(&instanced)) {
            (None, None) => {}
            (Some(a), Some(b)) if (a.p - b.p).length() < 1e-4 => {
                met += 1;
                assert!((a.t - b.t).abs() < 1e-3, "{a:?} {b:?}");
                // Where a circle closes, and at poles, u jumps.
                let (dpdu, _) = flat.geometry.tangents(&a);
                let (placed, _) = instanced.geometry.tangents(&b);
                let pole = dpdu.length() < 0.02 || !(0.01..=0.99).contains(&a.uv.x);
                assert!(pole || (a.uv - b.uv).length() < 1e-2, "{a:?} {b:?}");
                assert!(a.ng.dot(b.ng) > 0.9999, "{a:?} {b:?}");
                assert!(a.ns.dot(b.ns) > 0.9999);
                // The same up to what mirroring does to tangents of one direction: nothing.
                assert!(pole || (dpdu - placed).length() < 1e-2 * dpdu.length());
                assert_eq!(a.light, b.light);
            }
            // Rounding decides at silhouettes.
            (a, b) => {
                let grazes = |s: Option<kaustika_scene::Surface>| {
                    s.is_some_and(|s| s.ng.abs_dot(ray.d) < 0.02)
                };
                let edge = [&a, &b].iter().any(|s| s.as_ref().is_some_and(near_edge));
                assert!(grazes(a) || grazes(b) || edge, "{a:?} {b:?}");
            }
        }
    }
    assert!(met > 5000, "{met}");
}

/// Near the border of a face, a disk or a tube.
fn near_edge(s: &kaustika_scene::Surface) -> bool {
    let near = |c: f32| !(2e-3..=1.0 - 2e-3).contains(&c);
    near(s.uv.x) || near(s.uv.y)
}

#[test]
fn pictures_are_the_same() {
    let (flat, instanced) = stages();
    let p = json!({"max_depth": 8});
    let (a, b) = (flat.render(p.clone(), 120, 1), instanced.render(p, 120, 2));
    same("whole picture", &a.mean(), &b.mean());
    for y in 0..8 {
        for x in 0..10 {
            same(&format!("pixel {x} {y}"), a.at(x, y), b.at(x, y));
        }
    }
}

#[test]
fn pictures_are_equal_up_to_rounding() {
    // With the same numbers and without cut-outs (decided by rays' bits) and glass (whose paths
    // branch on rounding), pixels are equal.
    let (mut flat, mut instanced) = stages();
    for stage in [&mut flat, &mut instanced] {
        // Power depends on the scene's size, which instances only bound.
        stage.selection = Some(kaustika_scene::LightSelectionKind::Uniform);
        let grey = stage.diffuse(0.6);
        let shapes = stage.d.shapes.iter_mut();
        for s in shapes.chain(stage.d.groups.iter_mut().flat_map(|g| &mut g.shapes)) {
            s.alpha = None;
            if s.emission.is_none() {
                s.material = grey;
            }
        }
    }
    let p = json!({"max_depth": 1});
    let (a, b) = (flat.render(p.clone(), 8, 3), instanced.render(p, 8, 3));
    let equal = |x: f64, y: f64| (x - y).abs() < 1e-3 * x.max(y) + 1e-6;
    let n = a.pixels.iter().zip(&b.pixels).filter(|(x, y)| equal(x.mean(), y.mean())).count();
    // A few samples at silhouettes fall to the other side.
    assert!(n * 100 >= 95 * a.pixels.len(), "{n} of {}", a.pixels.len());
}
