//! Radiosity: a hierarchy's elements are small where light changes, at the edges of shadows and where surfaces meet.

use crate::radiosity::solved;
use crate::scenes::*;
use crate::stats::Random;
use kaustika_math::{Ray, Vec3};
use kaustika_scene::Scene;
use kaustika_scene::description::GeometryDesc;
use kaustika_transport::radiosity::Solution;
use serde_json::json;

/// The mean area of the elements that lie at places of the floor.
fn mean_area(scene: &Scene, solution: &Solution, place: impl Fn(&mut Random) -> [f32; 2]) -> f64 {
    const PLACES: u32 = 4000;
    let mut random = Random::new(3);
    let area = |_| {
        let [x, y] = place(&mut random);
        let ray = Ray::new(v(x, y, 1e-3), -Vec3::Z);
        let s = scene.intersect(&ray, f32::INFINITY).expect("the floor");
        let (leaf, _) = solution.mesh.locate(scene, &s, Vec3::Z).expect("an element");
        f64::from(solution.mesh.elements[leaf as usize].area)
    };
    (0..PLACES).map(area).sum::<f64>() / f64::from(PLACES)
}

/// Within a rectangle.
fn within([x0, x1]: [f32; 2], [y0, y1]: [f32; 2]) -> impl Fn(&mut Random) -> [f32; 2] {
    move |random| [x0 + (x1 - x0) * random.f(), y0 + (y1 - y0) * random.f()]
}

/// By an error that lets elements be larger than the smallest, but where it matters.
fn refined(scene: &Scene) -> Solution {
    let p = json!({"direct": "mesh", "patches": 50_000, "error": 0.5, "polish": 0});
    solved(scene, p)
}

/// A small lamp over a square that hides it: the shadow's edge is a square 0.533 from its middle, 0.067 wide. Elements
/// there have a sixth of the area of those in light, and a twentieth of those in shadow.
#[test]
fn elements_are_small_at_the_edges_of_shadows() {
    let mut stage = Stage::new();
    let (white, black) = (stage.diffuse(0.5), stage.diffuse(0.0));
    stage.shape(GeometryDesc::Rectangle, scale(2.0, 2.0, 1.0), white);
    stage.shape(GeometryDesc::Rectangle, at(0.0, 0.0, 0.5) * scale(0.4, 0.4, 1.0), black);
    stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, 2.0) * down() * scale(0.1, 0.1, 1.0), 50.0);
    let scene = stage.build();
    let s = refined(&scene);
    let edges = [[[0.51, 0.56], [-0.5, 0.5]], [[-0.5, 0.5], [-0.56, -0.51]]];
    let [right, lower] = edges.map(|[x, y]| mean_area(&scene, &s, within(x, y)));
    let dark = mean_area(&scene, &s, within([-0.4, 0.4], [-0.4, 0.4]));
    let lit = mean_area(&scene, &s, within([0.8, 1.6], [-0.8, 0.8]));
    for edge in [right, lower] {
        assert!(5.0 * edge < lit && 10.0 * edge < dark, "{edge}, {lit} in light, {dark} in shadow");
    }
}

/// A wall that shines on the floor that it stands on, and a box on the floor that shades it: where they touch it,
/// elements have a tenth and a fifth of the area of those in the open.
#[test]
fn elements_are_small_where_surfaces_meet() {
    let mut stage = Stage::new();
    let (white, bright) = (stage.diffuse(0.5), stage.diffuse(0.8));
    stage.shape(GeometryDesc::Rectangle, scale(2.0, 2.0, 1.0), white);
    let wall = at(-2.0, 0.0, 1.0) * rotate(90.0, Vec3::Y) * scale(1.0, 2.0, 1.0);
    stage.lamp(GeometryDesc::Rectangle, wall, 1.0);
    stage.shape(GeometryDesc::Cube, at(1.0, 0.0, 0.25) * scale(0.25, 0.5, 0.25), bright);
    let scene = stage.build();
    let s = refined(&scene);
    let at_wall = mean_area(&scene, &s, within([-2.0, -1.9], [-1.5, 1.5]));
    let at_box = mean_area(&scene, &s, within([0.7, 0.75], [-0.4, 0.4]));
    let open = mean_area(&scene, &s, within([-0.5, 0.4], [-1.5, 1.5]));
    assert!(
        10.0 * at_wall < open && 5.0 * at_box < open,
        "{at_wall}, {at_box}, {open} in the open"
    );
}
