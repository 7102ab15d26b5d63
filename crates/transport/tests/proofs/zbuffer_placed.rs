//! The z-buffer sees what rays see: of instances, of cut-outs, and of the facets that stand for quadrics.

use crate::scenes::*;
use crate::stats::Random;
use crate::zbuffer::{DEPTH, Drawn, EDGE};
use kaustika_math::{Vec2, Vec3};
use kaustika_scene::description::*;
use kaustika_scene::{Scene, Surface};
use kaustika_transport::zbuffer::ZBufferParams;

/// Relative change of depth within [`EDGE`] of a pixel, on the steepest surfaces that are compared.
const STEEP: f32 = 0.02;

/// Fails unless rays in `scene` meet what a picture shows, but within [`EDGE`] of an edge: there, what is shown is met
/// beside the pixel's sample. `alike` tells whether a surface is that of a triangle. How many pixels show something, and how
/// many lie at edges.
fn check(
    what: &str,
    drawn: &Drawn,
    scene: &Scene,
    alike: impl Fn(u32, &Surface) -> bool,
) -> [u32; 2] {
    let mut counts = [0, 0];
    for pixel in drawn.pixels() {
        let seen = drawn.seen(pixel);
        let t = seen.map(|s| drawn.view.distance(s.p));
        let shown = |off: Vec2, room: f32| {
            let camera = drawn.ray_beside(pixel, off);
            match (&seen, t, scene.intersect(&camera.ray, camera.t_max)) {
                (Some(s), Some(t), Some(m)) => {
                    // Another surface may be as near.
                    (t - m.t).abs() <= room * m.t && (room == DEPTH || alike(s.triangle, &m))
                }
                (None, _, None) => true,
                _ => false,
            }
        };
        counts[0] += u32::from(seen.is_some());
        if shown(Vec2::ZERO, DEPTH) {
            continue;
        }
        counts[1] += 1;
        let beside = (0..16).any(|i| {
            let (sin, cos) = f32::to_radians(22.5 * i as f32).sin_cos();
            shown(Vec2::new(cos, sin) * EDGE as f32, STEEP)
        });
        let met = drawn.met(pixel);
        assert!(beside, "{what}, pixel {pixel:?}: {seen:?} and {met:?}");
    }
    counts
}

/// The same, in the scene that is drawn.
fn check_itself(what: &str, stage: &Stage) -> [u32; 2] {
    let drawn = Drawn::new(stage, &ZBufferParams::default());
    check(what, &drawn, &drawn.scene, |triangle, met| {
        let source = drawn.rasterizer.meshes().sources[triangle as usize];
        (source.shape, source.instance) == (met.shape, met.instance.unwrap_or(u32::MAX))
    })
}

/// Places of a group: turned, sheared by another's turn, turned inside out, and moving.
fn place(stage: &mut Stage, shapes: Vec<ShapeDesc>) {
    stage.d.groups.push(GroupDesc { name: String::new(), shapes });
    let sheared = scale(1.0, 0.5, 1.4) * rotate(40.0, v(1.0, 1.0, 0.2));
    let places = [
        at(-0.9, 0.0, 0.4) * rotate(30.0, Vec3::Z),
        at(0.8, 0.3, 0.5) * sheared,
        at(0.0, 1.2, 0.6) * scale(-0.8, 0.8, 0.8),
    ];
    for transform in places {
        let motion = Vec::new();
        stage.d.instances.push(InstanceDesc { group: GroupId(0), transform, motion, span: None });
    }
    let [opens, closes] = [at(0.1, -0.9, 0.3) * scale(0.5, 0.5, 0.5), at(5.0, 0.0, 0.0)];
    let motion =
        vec![MotionKey { time: 0.0, transform: opens }, MotionKey { time: 1.0, transform: closes }];
    let (group, transform, span) = (GroupId(0), opens, None);
    stage.d.instances.push(InstanceDesc { group, transform, motion, span });
}

/// A floor, seen from above.
fn ground() -> Stage {
    let mut stage = Stage::new();
    let white = stage.diffuse(0.6);
    stage.shape(GeometryDesc::Rectangle, scale(3.0, 3.0, 1.0), white);
    stage.camera(pinhole(50.0), look(v(0.3, -4.0, 2.5), v(0.0, 0.1, 0.4)), [200, 150]);
    stage.d.cameras[0].shutter = [0.0, 1.0];
    stage
}

/// Small triangles around the origin.
fn splinters() -> GeometryDesc {
    let mut random = Random::new(23);
    let positions: Vec<Vec3> = (0..200)
        .flat_map(|_| {
            let middle = random.v3() * 0.5;
            [(); 3].map(|()| middle + random.v3() * 0.15)
        })
        .collect();
    let indices: Vec<[u32; 3]> = (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    mesh(&positions, &indices)
}

#[test]
fn rays_see_the_same_of_instances() {
    let mut stage = ground();
    let white = stage.diffuse(0.6);
    let cube = shape(GeometryDesc::Cube, rotate(20.0, Vec3::X) * scale(0.25, 0.3, 0.2), white);
    place(&mut stage, vec![shape(splinters(), HERE, white), cube]);
    let [count, edges] = check_itself("instances", &stage);
    assert!(count > 15_000 && edges < 100, "{count} {edges}");
}

/// Squares that are there and squares that are not, before each other, nearly along them, and in instances.
#[test]
fn rays_see_the_same_through_cut_outs() {
    let mut stage = ground();
    let white = stage.diffuse(0.6);
    let squares = |stage: &mut Stage, n: f32| {
        let [whole, none] = [1.0, 0.0].map(|x| stage.d.float(x));
        let mapping = TextureMapping::Uv(kaustika_math::Affine2::scale_shift(n, n, 0.1, 0.3));
        stage.d.add_texture(TextureNode::Checkerboard { a: whole, b: none, mapping }, None)
    };
    for (t, n) in [
        (at(0.0, -0.5, 0.9) * rotate(70.0, Vec3::X) * scale(1.5, 1.0, 1.0), 11.0),
        (at(0.2, 0.6, 0.8) * rotate(100.0, v(1.0, 0.1, 0.0)) * scale(1.2, 0.9, 1.0), 7.0),
        (at(0.0, 0.0, 1.3) * rotate(29.0, Vec3::X) * scale(2.0, 2.0, 1.0), 5.0),
    ] {
        let alpha = squares(&mut stage, n);
        stage.shape(GeometryDesc::Rectangle, t, white).alpha = Some(alpha);
    }
    let mut cube = shape(GeometryDesc::Cube, scale(0.3, 0.3, 0.3), white);
    cube.alpha = Some(squares(&mut stage, 3.0));
    place(&mut stage, vec![cube]);
    let [count, edges] = check_itself("cut-outs", &stage);
    assert!(count > 15_000 && edges < 400, "{count} {edges}");
    // There are holes: without them other things are seen.
    let drawn = |stage: &Stage| Drawn::new(stage, &ZBufferParams::default());
    let holed = drawn(&stage);
    stage.d.shapes.iter_mut().for_each(|s| s.alpha = None);
    let whole = drawn(&stage);
    let depth = |d: &Drawn, pixel| d.seen(pixel).map(|s| s.depth);
    let other = whole.pixels().filter(|p| depth(&whole, *p) != depth(&holed, *p)).count();
    assert!(other > 3000, "{other}");
}

/// Quadrics are drawn as facets: rays among the facets themselves see what is drawn.
#[test]
fn rays_see_the_same_of_the_facets_of_quadrics() {
    let mut stage = ground();
    let white = stage.diffuse(0.6);
    let part = GeometryDesc::Sphere { radius: 0.5, z_min: -0.3, z_max: 0.4, phi_max: 250.0 };
    let tube = GeometryDesc::Cylinder { radius: 0.2, z_min: -0.4, z_max: 0.3, phi_max: 300.0 };
    let ring = GeometryDesc::Disk { height: 0.1, radius: 0.6, inner_radius: 0.3, phi_max: 320.0 };
    stage.shape(sphere(0.4), at(0.0, 0.0, 0.3), white);
    stage.shape(part.clone(), at(1.5, 0.9, 0.5) * rotate(60.0, v(1.0, 0.4, 0.1)), white);
    let tilted = rotate(25.0, Vec3::X);
    place(
        &mut stage,
        vec![shape(part, HERE, white), shape(tube, tilted, white), shape(ring, tilted, white)],
    );
    let drawn = Drawn::new(&stage, &ZBufferParams::default());
    let meshes = drawn.rasterizer.meshes();
    let mut facets = Stage::new();
    let white = facets.diffuse(0.6);
    facets.shape(mesh(&meshes.positions, &meshes.indices), HERE, white);
    facets.d.cameras = stage.d.cameras.clone();
    let [count, edges] = check("facets", &drawn, &facets.build(), |_, _| true);
    assert!(count > 15_000 && edges < 200, "{count} {edges}");
    let of_quadrics = drawn.pixels().filter_map(|pixel| drawn.seen(pixel));
    let is_quadric = |t: u32| meshes.sources[t as usize].triangle == u32::MAX;
    assert!(of_quadrics.filter(|s| is_quadric(s.triangle)).count() > 5000);
}
