//! Signed distance grids and ellipsoids in pictures.

use crate::scenes::*;
use crate::stats::{agrees, same};
use kaustika_math::Vec3;
use kaustika_scene::description::*;
use serde_json::json;
use std::f64::consts::PI;
use std::sync::Arc;

/// The surface f = 0 in the unit cube, as a grid of n³ samples.
fn surface(n: u32, normals: SdfNormals, f: impl Fn(Vec3) -> f32) -> GeometryDesc {
    let at = |i: u32| i as f32 / (n - 1) as f32;
    let place = |i: u32| v(at(i % n), at(i / n % n), at(i / (n * n)));
    let values = (0..n * n * n).map(|i| f(place(i))).collect();
    GeometryDesc::SdfGrid(Arc::new(SdfGrid { resolution: [n; 3], values, normals }))
}

fn ball(p: Vec3) -> f32 {
    (p - Vec3::splat(0.5)).length() - 0.4
}

/// Half axes 0.8, 0.3 and 1.2, the first turned by 30 degrees about z.
fn ellipsoid() -> GeometryDesc {
    let (s, c) = 15f32.to_radians().sin_cos();
    let one = Ellipsoid {
        center: v(0.0, 0.0, 3.0),
        radii: v(0.8, 0.3, 1.2),
        rotation: [0.0, 0.0, 2.0 * s, 2.0 * c],
    };
    GeometryDesc::Ellipsoids(Arc::new(vec![one]))
}

/// In parallel projection a black ellipsoid hides π a b of the window [-1,1]² before a white sky.
#[test]
fn ellipsoids_hide_what_their_axes_say() {
    let mut stage = Stage::new();
    stage.sky(1.0);
    let black = stage.diffuse(0.0);
    stage.shape(ellipsoid(), HERE, black);
    stage.camera(parallel(1.0, 0.0, 1.0), HERE, [8, 8]);
    let seen = stage.render(json!({"max_depth": 1}), 2000, 1).mean();
    agrees("ellipse", &seen, 1.0 - PI * 0.8 * 0.3 / 4.0);
}

/// Rays from inside pass.
#[test]
fn ellipsoids_are_not_seen_from_inside() {
    let mut stage = Stage::new();
    stage.sky(1.0);
    let black = stage.diffuse(0.0);
    stage.shape(ellipsoid(), HERE, black);
    stage.camera(CameraKind::Spherical { equal_area: true }, at(0.1, 0.0, 3.2), [4, 4]);
    assert_eq!(stage.render(json!({"max_depth": 1}), 16, 1).mean().mean(), 1.0);
}

/// Shining ellipsoids light a floor alike whether the floor looks for them or finds them.
#[test]
fn ellipsoids_shine() {
    let mut stage = Stage::new();
    floor(&mut stage);
    let (black, lamp) = (stage.diffuse(0.0), stage.emission(2.0));
    let s = stage.shape(ellipsoid(), at(0.0, 0.0, -1.5), black);
    s.emission = Some(lamp);
    stage.camera(pinhole(30.0), look(v(0.0, -3.5, 1.8), v(0.0, 0.0, 0.0)), [4, 4]);
    let [a, b] = ["light", "bsdf"]
        .map(|mis| stage.render(json!({"max_depth": 1, "mis": mis}), 3000, 2).mean());
    assert!(a.mean() > 0.05);
    same("light against bsdf", &a, &b);
}

/// White matter under a white sky is white: no light is lost between cells, whatever the surface.
#[test]
fn white_surfaces_are_not_seen_before_a_white_sky() {
    let wavy = |p: Vec3| p.z - 0.5 - 0.2 * (11.0 * p.x).sin() * (9.0 * p.y).cos();
    type Form = (&'static str, fn(Vec3) -> f32);
    let forms: [Form; 2] = [("ball", ball), ("wavy", wavy)];
    for (name, f) in forms {
        let mut stage = Stage::new();
        stage.sky(1.0);
        // The sheet is seen from behind too.
        let white = stage.diffuse(1.0);
        let white = stage.two_sided(white);
        let place = rotate(40.0, v(1.0, 1.0, 0.0)) * scale(2.0, 1.0, 3.0);
        stage.shape(surface(20, SdfNormals::Analytic, f), at(0.0, 0.0, 5.0) * place, white);
        stage.camera(pinhole(40.0), HERE, [8, 8]);
        let params = json!({"max_depth": 200, "roulette": "none"});
        agrees(name, &stage.render(params, 40, 3).mean(), 1.0);
    }
}

/// A fine grid of a ball's distance looks as the ball does, in glass too.
#[test]
fn a_ball_of_distances_looks_as_a_ball_does() {
    for glass in [false, true] {
        let stage = |exact: bool| {
            let mut stage = Stage::new();
            floor(&mut stage);
            let material = if glass { stage.glass(1.5, 0.0) } else { stage.diffuse(0.6) };
            match exact {
                true => stage.shape(sphere(0.4), at(0.0, 0.0, 0.6), material),
                false => {
                    let form = surface(96, SdfNormals::Smooth, ball);
                    stage.shape(form, at(-0.5, -0.5, 0.1), material)
                }
            };
            stage.sky(1.0);
            stage.camera(pinhole(30.0), look(v(0.0, -3.5, 1.8), v(0.0, 0.0, 0.5)), [6, 6]);
            stage
        };
        let p = json!({"max_depth": 6});
        let [a, b] = [true, false].map(|e| stage(e).render(p.clone(), 300, 7 + u64::from(e)));
        for (i, (a, b)) in a.pixels.iter().zip(&b.pixels).enumerate() {
            same(&format!("glass {glass}, pixel {i}"), a, b);
        }
    }
}
