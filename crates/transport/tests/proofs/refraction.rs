//! Glass: Fresnel's numbers, and the n² law of radiance at refraction.

use crate::scenes::*;
use crate::stats::{agrees, close};
use kaustika_math::Vec3;
use kaustika_scene::description::*;
use serde_json::json;

/// A slab of glass in |z| < 0.2 before a wall at z = -1.
fn slab(wall: f32) -> Stage {
    let mut stage = Stage::new();
    let glass = stage.glass(1.5, 0.0);
    stage.shape(GeometryDesc::Cube, scale(50.0, 50.0, 0.2), glass);
    stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, -1.0) * scale(50.0, 50.0, 1.0), wall);
    stage
}

#[test]
fn a_wall_seen_through_a_slab() {
    // All internal reflections: T = (1 - R)/(1 + R), with R = 0.04 at normal incidence and, at
    // Brewster's angle, the mean of both polarisations, R = 0.147929/2.
    let stage = slab(3.0);
    let p = json!({"rr_depth": 100});
    for (d, r) in [
        (v(0.0, 0.0, -1.0), 0.04),
        (v((56.310f32).to_radians().sin(), 0.0, -(56.310f32).to_radians().cos()), 0.147929 / 2.0),
        (v((45.0f32).to_radians().sin(), 0.0, -(45.0f32).to_radians().cos()), 0.0502395),
    ] {
        let seen = stage.probe(v(0.0, 0.0, 1.0), d, p.clone(), 60_000);
        // Unpolarised light is a mean at each interface, as the renderer has it.
        agrees(&format!("through {d:?}"), &seen, 3.0 * (1.0 - r) / (1.0 + r));
    }
}

#[test]
fn radiance_inside_glass_is_greater_by_the_index_squared() {
    // Basic radiance L/n² is what refraction preserves: in a uniform field L, a point inside
    // glass sees n² L.
    for n in [1.5f32, 2.2] {
        let mut stage = Stage::new();
        let glass = stage.glass(n, 0.0);
        stage.shape(sphere(1.0), HERE, glass);
        stage.sky(0.5);
        // From near the centre no direction is reflected totally.
        let seen =
            stage.probe(v(0.05, 0.02, -0.03), v(0.3, 1.0, 0.2), json!({"rr_depth": 50}), 4000);
        agrees(&format!("n = {n}"), &seen, 0.5 * (n * n) as f64);
        // From outside the same field looks as if there were no glass.
        let seen = stage.probe(v(0.0, 0.0, 3.0), v(0.1, 0.2, -1.0), json!({"rr_depth": 50}), 4000);
        agrees(&format!("outside, n = {n}"), &seen, 0.5);
    }
}

#[test]
fn a_diffuse_emitter_embedded_in_glass_furnace_stays_itself() {
    // An emitter within a glass sphere, both in a furnace of the same radiance: the picture is
    // uniform only if refraction scales radiance both ways. The emitter inside must be n² times
    // as bright to be in balance.
    let n = 1.5f32;
    let mut stage = Stage::new();
    let glass = stage.glass(n, 0.0);
    stage.shape(sphere(1.0), HERE, glass);
    stage.lamp(sphere(0.4), HERE, 0.5 * n * n);
    stage.sky(0.5);
    for mis in ["power", "bsdf", "light"] {
        for d in [v(0.0, 0.0, -1.0), v(0.05, 0.1, -1.0), v(0.2, 0.22, -1.0)] {
            let p = json!({"rr_depth": 50, "mis": mis});
            agrees(&format!("{mis} {d:?}"), &stage.probe(v(0.0, 0.0, 3.0), d, p, 3000), 0.5);
        }
    }
}

#[test]
fn a_thin_pane_passes_what_a_slab_does() {
    let mut stage = slab(3.0);
    let one = stage.d.float(1.0);
    let pane = stage.material(MaterialModel::ThinDielectric {
        ior: IorDesc::Constant(1.5),
        specular_reflectance: one,
        specular_transmittance: one,
    });
    stage.d.shapes[0] = shape(GeometryDesc::Rectangle, scale(50.0, 50.0, 1.0), pane);
    let seen = stage.probe(v(0.0, 0.0, 1.0), -Vec3::Z, json!({}), 40_000);
    agrees("pane", &seen, 3.0 * 0.96 / 1.04);
}

#[test]
fn light_reflected_and_passed_adds_up() {
    // Radiance from behind and from before the slab, both 1: nothing is lost.
    let mut stage = slab(1.0);
    stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, 2.0) * down() * scale(50.0, 50.0, 1.0), 1.0);
    let seen = stage.probe(v(0.0, 0.0, 1.0), v(0.6, 0.2, -1.0), json!({"rr_depth": 200}), 2);
    close("both sides", seen.mean(), 1.0, 1e-4);
}
