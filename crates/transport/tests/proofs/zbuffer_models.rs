//! The z-buffer's light models against their formulas, and what interpolated normals make of a coarse ball.

use crate::scenes::*;
use crate::stats::close;
use crate::zbuffer::Drawn;
use kaustika_math::Vec3;
use kaustika_scene::bsdf::{Lobes, Mode};
use kaustika_scene::description::*;
use kaustika_spectra::Wavelengths;
use kaustika_transport::zbuffer::{Model, ZBufferParams};
use std::f32::consts::{PI, TAU};
use std::sync::Arc;

const EXPONENT: f32 = 12.0;

/// A glossy surface without a matte part.
fn gloss(stage: &mut Stage) -> MaterialId {
    let [d, s, n] = [0.0, 0.5, EXPONENT].map(|x| stage.d.float(x));
    stage.material(MaterialModel::Phong {
        diffuse_reflectance: d,
        specular_reflectance: s,
        exponent: n,
    })
}

/// Toward the light of this incidence, or to the eye if the angle is that beyond the normal.
fn along(degrees: f32) -> Vec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    v(sin, 0.0, cos)
}

/// Radiance of a surface under parallel light over E cos θ, θ the incidence.
fn reflected(model: Model, incidence: f32, seen: f32) -> f32 {
    let mut stage = Stage::new();
    let m = gloss(&mut stage);
    stage.shape(GeometryDesc::Rectangle, HERE, m);
    let kind = LightKind::Directional { irradiance: grey(1.0), scale: 1.0, illuminance: None };
    stage.light(kind, look(along(-incidence), Vec3::ZERO));
    stage.camera(parallel(0.1, 0.0, 1.0), look(along(seen) * 2.0, Vec3::ZERO), [4, 4]);
    let p = ZBufferParams { model, ambient: 0.0, shadows: false, ..ZBufferParams::default() };
    let drawn = Drawn::new(&stage, &p);
    drawn.rasterizer.color(2, 2)[0] / incidence.to_radians().cos()
}

/// (5) and (6) of the z-buffer, up to k_s.
fn formula(model: Model, incidence: f32, seen: f32) -> f32 {
    let (l, e) = (along(-incidence), along(seen));
    if model == Model::Phong {
        let mirror = along(incidence);
        return (EXPONENT + 2.0) / TAU * mirror.dot(e).max(0.0).powf(EXPONENT);
    }
    let (h, m) = ((l + e).normalize(), 4.0 * EXPONENT);
    let g = 1f32.min(2.0 * h.z * e.z / e.dot(h)).min(2.0 * h.z * l.z / e.dot(h));
    (m + 2.0) / TAU * h.z.powf(m) * g / (4.0 * l.z * e.z)
}

/// Phong's lobe (1975) has its top in the mirror direction, Blinn's (1977) beyond it where light grazes; and
/// Blinn's is the same both ways.
#[test]
fn lobes_are_their_formulas_and_facets_peak_beyond_the_mirror() {
    for model in [Model::Phong, Model::Blinn] {
        let scale = reflected(model, 0.0, 0.0) / formula(model, 0.0, 0.0);
        assert!(scale > 0.3 && scale < 0.7, "k_s is about 0.5: {scale}");
        for incidence in [0.0, 40.0, 70.0] {
            let angles = (-16..=17).map(|k| 5.0 * k as f32);
            let mut top = (0.0, 0.0);
            for seen in angles {
                let (found, truth) =
                    (reflected(model, incidence, seen), formula(model, incidence, seen));
                if truth > 1e-3 {
                    let what = format!("{model:?} {incidence} {seen}");
                    close(&what, f64::from(found), f64::from(scale * truth), 2e-3);
                }
                if found > top.1 {
                    top = (seen, found);
                }
            }
            match (model, incidence > 50.0) {
                (Model::Blinn, true) => assert!(top.0 > incidence + 4.0, "{top:?}"),
                // At most a step of the angles.
                (Model::Blinn, false) => assert!(top.0 - incidence <= 5.0, "{top:?}"),
                _ => assert_eq!(top.0, incidence),
            }
        }
    }
    for (a, b) in [(10.0, 60.0), (75.0, 30.0)] {
        let [there, back] = [(a, b), (b, a)].map(|(i, s)| f64::from(reflected(Model::Blinn, i, s)));
        close("both ways", there, back, 1e-4);
    }
}

/// A ball of few facets, with the normals of a ball at its corners.
fn coarse_ball() -> GeometryDesc {
    const AROUND: u32 = 16;
    const ALONG: u32 = 8;
    let point = |i: u32, j: u32| {
        let (theta, phi) = (PI * j as f32 / ALONG as f32, TAU * i as f32 / AROUND as f32);
        v(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    };
    let positions: Vec<Vec3> =
        (0..=ALONG).flat_map(|j| (0..=AROUND).map(move |i| point(i, j))).collect();
    let squares = (0..ALONG * AROUND).map(|k| (k % AROUND, k / AROUND));
    let triangles = squares.flat_map(|(i, j)| {
        let at = |i: u32, j: u32| j * (AROUND + 1) + i;
        let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        // At a pole there is one of them.
        let below = (j + 1 < ALONG).then_some([a, b, c]);
        below.into_iter().chain((j > 0).then_some([a, c, d]))
    });
    let indices = triangles.collect();
    let normals = positions.clone();
    GeometryDesc::Mesh(Arc::new(TriMesh { positions, normals, indices, ..TriMesh::default() }))
}

/// Interpolated normals (Phong 1975) shade a coarse ball nearly as a ball is, where facets do not; its
/// silhouette stays a polygon.
#[test]
fn a_coarse_ball_is_shaded_as_a_ball_and_stays_a_polygon() {
    let lamp = v(1.5, -3.0, 2.0);
    let build = |ball: GeometryDesc, model| {
        let mut stage = Stage::new();
        let [d, s, n] = [0.4, 0.3, EXPONENT].map(|x| stage.d.float(x));
        let m = stage.material(MaterialModel::Phong {
            diffuse_reflectance: d,
            specular_reflectance: s,
            exponent: n,
        });
        stage.shape(ball, rotate(20.0, v(1.0, 0.5, 0.0)), m);
        stage.point_light(lamp, 10.0);
        stage.camera(parallel(1.1, 0.0, 5.0), look(v(0.0, -5.0, 0.0), Vec3::ZERO), [96, 96]);
        let p = ZBufferParams { model, ambient: 0.0, shadows: false, ..ZBufferParams::default() };
        Drawn::new(&stage, &p)
    };
    let truth = build(sphere(1.0), Model::Phong);
    // Of the ball itself, lit by hand.
    let lit = |pixel| {
        let s = truth.met(pixel)?;
        let to_lamp = lamp - s.p;
        let bsdf = truth.scene.bsdf(&s, -Vec3::Y, &mut Wavelengths::rgb())?;
        let f = bsdf.eval(-Vec3::Y, to_lamp.normalize(), Mode::Radiance, Lobes::ALL);
        Some(f[0] * 10.0 / to_lamp.length_squared())
    };
    let error = |model| {
        let drawn = build(coarse_ball(), model);
        let (mut sum, mut all, mut inside, mut outside) = (0.0, 0.0, 0, 0);
        for pixel in drawn.pixels() {
            let Some(light) = lit(pixel) else {
                assert!(drawn.seen(pixel).is_none(), "corners lie on the ball");
                continue;
            };
            match drawn.seen(pixel) {
                Some(_) => {
                    sum += (drawn.rasterizer.color(pixel[0], pixel[1])[0] - light).powi(2);
                    all += light.powi(2);
                    inside += 1;
                }
                None => outside += 1,
            }
        }
        // A regular polygon of 16 corners misses 2.6 % of its circle.
        let missed = f64::from(outside) / f64::from(inside + outside);
        assert!(missed > 0.01 && missed < 0.08, "{missed}");
        (sum / all).sqrt()
    };
    let [facets, smooth] = [Model::Bouknight, Model::Phong].map(error);
    assert!(smooth < 0.06 && facets > 3.0 * smooth, "{facets} {smooth}");
}
