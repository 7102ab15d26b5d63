//! Curves in pictures.

use crate::scenes::*;
use crate::stats::{agrees, same};
use kaustika_math::Vec3;
use kaustika_scene::description::*;
use serde_json::json;
use std::sync::Arc;

/// A curve of constant width along x.
fn bar(profile: CurveProfile, radius: f32) -> GeometryDesc {
    let segment = CurveSegment::straight([v(-3.0, 0.0, 2.0), v(3.0, 0.0, 2.0)], [radius; 2]);
    let normals = match profile {
        CurveProfile::Ribbon => vec![[-Vec3::Z; 2]],
        _ => Vec::new(),
    };
    GeometryDesc::Curves(Arc::new(Curves { profile, segments: vec![segment], normals }))
}

/// In parallel projection a black curve of radius r hides r/2 of the window [-2,2]² before a
/// white sky.
#[test]
fn curves_hide_what_their_width_says() {
    for profile in [
        CurveProfile::Flat,
        CurveProfile::Cylinder,
        CurveProfile::Ribbon,
        CurveProfile::Tube,
        CurveProfile::Spheres,
    ] {
        for radius in [0.5f32, 0.01] {
            let mut stage = Stage::new();
            stage.sky(1.0);
            let black = stage.diffuse(0.0);
            stage.shape(bar(profile, radius), HERE, black);
            stage.camera(parallel(2.0, 0.0, 1.0), HERE, [8, 8]);
            let seen = stage.render(json!({"max_depth": 1}), 2000, 1).mean();
            agrees(&format!("{profile:?} {radius}"), &seen, 1.0 - f64::from(radius) / 2.0);
        }
    }
}

/// A tube is a cylinder: the same light arrives from a lamp and from the other parts.
#[test]
fn a_tube_looks_as_a_cylinder_does() {
    let stage = |tube: bool| {
        let mut stage = Stage::new();
        floor(&mut stage);
        let grey = stage.diffuse(0.6);
        match tube {
            true => {
                let segment =
                    CurveSegment::straight([v(-0.5, 0.0, 0.4), v(0.5, 0.0, 0.4)], [0.3; 2]);
                let curves = Curves {
                    profile: CurveProfile::Tube,
                    segments: vec![segment],
                    normals: Vec::new(),
                };
                stage.shape(GeometryDesc::Curves(Arc::new(curves)), HERE, grey);
            }
            false => {
                let form =
                    GeometryDesc::Cylinder { radius: 0.3, z_min: -0.5, z_max: 0.5, phi_max: 360.0 };
                stage.shape(form, at(0.0, 0.0, 0.4) * rotate(90.0, Vec3::Y), grey);
                // A tube can't be entered: lids, black, seen by nobody.
                let black = stage.diffuse(0.0);
                for x in [-0.499, 0.499] {
                    stage.shape(disk(0.3), at(x, 0.0, 0.4) * rotate(90.0, Vec3::Y), black);
                }
            }
        }
        stage.lamp(disk(0.5), at(0.0, 0.0, 2.5) * down(), 6.0);
        stage.camera(pinhole(30.0), look(v(0.0, -3.5, 1.8), v(0.0, 0.0, 0.4)), [8, 6]);
        stage
    };
    let p = json!({"max_depth": 2});
    let [a, b] = [true, false].map(|t| stage(t).render(p.clone(), 400, 7 + u64::from(t)));
    // Pixels of the curve away from its ends.
    for y in 0..6 {
        for x in 3..5 {
            same(&format!("pixel {x} {y}"), a.at(x, y), b.at(x, y));
        }
    }
}
