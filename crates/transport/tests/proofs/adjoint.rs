//! Light seen from its side and from the camera's: the same flux, the same pictures.

use crate::scenes::*;
use crate::stats::{Random, agrees, close, same};
use kaustika_math::{Ray, Vec3};
use kaustika_sampling::estimator::RunningMean;
use kaustika_scene::bsdf::{Lobes, Mode};
use kaustika_scene::description::*;
use kaustika_scene::{Camera, Light, Scene};
use kaustika_spectra::{ColorSpace, Wavelengths};
use serde_json::json;

/// One of every light, each by itself above the floor.
fn lights() -> Vec<(&'static str, Stage)> {
    let tilted = at(0.3, -0.2, 1.2) * rotate(160.0, v(1.0, 0.2, 0.1));
    let lamp = |form: GeometryDesc, t| {
        let mut stage = Stage::new();
        stage.lamp(form, t, 2.0);
        stage
    };
    let light = |kind: LightKind| {
        let mut stage = Stage::new();
        stage.light(kind, tilted);
        stage
    };
    let tube = GeometryDesc::Cylinder { radius: 0.2, z_min: -0.4, z_max: 0.4, phi_max: 360.0 };
    let both = |mut stage: Stage| {
        stage.d.shapes[0].emission.as_mut().expect("a lamp").two_sided = true;
        stage
    };
    let smooth = |x: f32, y: f32| [0.3 + x * y, 0.5 + 0.4 * (5.0 * x).sin(), 1.0 - 0.7 * y];
    let spot = |falloff, texture| LightKind::Spot {
        intensity: grey(3.0),
        scale: 1.0,
        power: None,
        cutoff: 60.0,
        beam_width: 25.0,
        falloff,
        texture,
    };
    let environment = |layout, w, h| LightKind::Image {
        bitmap: bitmap(w, h, smooth),
        space: ColorSpace::Srgb,
        layout,
        scale: 0.5,
        illuminance: None,
    };
    let mut slide = Stage::new();
    let picture = texture(&mut slide, bitmap(8, 8, smooth), BitmapFilter::Bilinear);
    slide.light(spot(SpotFalloff::SmoothstepCosine, Some(picture)), tilted);
    let mut painted = lamp(GeometryDesc::Rectangle, tilted * scale(0.5, 0.3, 1.0));
    let picture = texture(&mut painted, bitmap(5, 7, smooth), BitmapFilter::Bilinear);
    painted.d.shapes[0].emission.as_mut().expect("a lamp").radiance = picture;
    let mut all = vec![
        ("rectangle", lamp(GeometryDesc::Rectangle, tilted * scale(0.4, 0.2, 1.0))),
        ("two-sided disk", both(lamp(disk(0.4), tilted))),
        ("ellipse", lamp(disk(0.4), tilted * scale(1.5, 0.5, 1.0))),
        ("sphere", lamp(sphere(0.3), tilted)),
        ("ellipsoid", lamp(sphere(0.3), tilted * scale(1.0, 0.4, 1.6))),
        ("cylinder", lamp(tube, tilted)),
        ("painted rectangle", painted),
        ("point", light(LightKind::Point { intensity: grey(3.0), scale: 1.0, power: None })),
        ("spot, linear", light(spot(SpotFalloff::LinearAngle, None))),
        ("spot, smooth", light(spot(SpotFalloff::SmoothstepCosine, None))),
        ("spot, squared", light(spot(SpotFalloff::SquaredLinearCosine, None))),
        ("slide", slide),
        (
            "parallel",
            light(LightKind::Directional { irradiance: grey(1.0), scale: 1.0, illuminance: None }),
        ),
        (
            "constant",
            light(LightKind::Constant { radiance: grey(0.5), scale: 1.0, illuminance: None }),
        ),
        ("lat-long", light(environment(EnvironmentLayout::LatLong, 16, 8))),
        ("equal-area", light(environment(EnvironmentLayout::EqualArea, 12, 12))),
        (
            "portal",
            light(LightKind::Portal {
                bitmap: bitmap(12, 12, smooth),
                space: ColorSpace::Srgb,
                layout: EnvironmentLayout::EqualArea,
                scale: 2.0,
                corners: window(v(-0.5, 0.1, 1.2)),
            }),
        ),
        (
            "projection",
            light(LightKind::Projection {
                bitmap: bitmap(12, 8, smooth),
                space: ColorSpace::Srgb,
                fov_x: 70.0,
                scale: 2.0,
                power: None,
            }),
        ),
        ("projector", {
            let mut stage = Stage::new();
            let texture = texture(&mut stage, bitmap(12, 8, smooth), BitmapFilter::Bilinear);
            let fov_axis = FovAxis::Smaller;
            stage.light(LightKind::Projector { texture, scale: 2.0, fov: 70.0, fov_axis }, tilted);
            stage
        }),
        (
            "goniometric",
            light(LightKind::Goniometric {
                intensity: grey(2.0),
                bitmap: bitmap(10, 10, smooth),
                scale: 1.5,
                power: None,
            }),
        ),
    ];
    for (_, stage) in &mut all {
        floor(stage);
    }
    all
}

#[test]
fn emitted_rays_carry_the_power() {
    let lambda = Wavelengths::rgb();
    for (what, stage) in lights() {
        let scene = stage.build();
        let mut random = Random::new(11);
        let (mut flux, mut power) = (RunningMean::new(), 0.0);
        for light in &scene.lights {
            power += light.power(&scene, &lambda).luminance(&lambda) as f64;
        }
        // A rectangle is two lights: one of them a sample, at random.
        let k = scene.lights.len();
        for _ in 0..40_000 {
            let light = &scene.lights[((random.f() * k as f32) as usize).min(k - 1)];
            let ray = light.sample_le(&scene, random.v2(), random.v2(), &lambda);
            flux.push(ray.map_or(0.0, |r| {
                assert!((r.ray.d.length() - 1.0).abs() < 1e-5);
                let le = r.le.luminance(&lambda) as f64;
                k as f64 * le * r.cos as f64 / (r.pdf_a as f64 * r.pdf_w as f64)
            }));
        }
        agrees(what, &flux, power);
    }
}

#[test]
fn densities_of_emitted_rays_are_consistent() {
    let lambda = Wavelengths::rgb();
    for (what, stage) in lights() {
        let scene = stage.build();
        let mut random = Random::new(12);
        for light in &scene.lights {
            for _ in 0..300 {
                let Some(r) = light.sample_le(&scene, random.v2(), random.v2(), &lambda) else {
                    continue;
                };
                let (pdf_a, pdf_w) = light.pdf_le(&scene, r.ray.o, r.n, r.ray.d);
                // Dirac densities stand as 1 in samples and 0 in `pdf_le`.
                let fixed_point = matches!(
                    light,
                    Light::Point(_)
                        | Light::Spot(_)
                        | Light::Projection(_)
                        | Light::Projector(_)
                        | Light::Goniometric(_)
                );
                let fixed_direction = matches!(light, Light::Directional(_));
                let rim = r.cos < 1e-3;
                let want_a = if fixed_point { 0.0 } else { r.pdf_a };
                let want_w = if fixed_direction { 0.0 } else { r.pdf_w };
                close(&format!("{what}, area"), pdf_a as f64, want_a as f64, 1e-3);
                if !rim && r.pdf_w > 1e-3 {
                    close(&format!("{what}, direction"), pdf_w as f64, want_w as f64, 1e-2);
                }
            }
        }
    }
}

fn cameras() -> Vec<(&'static str, CameraKind)> {
    let mut shifted = pinhole(60.0);
    if let CameraKind::Perspective { principal_point, .. } = &mut shifted {
        *principal_point = [0.1, -0.2];
    }
    vec![
        ("pinhole", pinhole(60.0)),
        ("shifted pinhole", shifted),
        ("thin lens", thin_lens(60.0, 0.15, 1.2)),
        ("parallel", parallel(1.0, 0.0, 1.0)),
        ("parallel with a lens", parallel(1.0, 0.15, 1.2)),
        ("lat-long", CameraKind::Spherical { equal_area: false }),
        ("equal-area", CameraKind::Spherical { equal_area: true }),
    ]
}

const SIZE: [u32; 2] = [8, 6];

/// Above the floor, looking down askew, larger than life.
fn eye(mirrored: bool) -> kaustika_math::Transform {
    let k = 1.3;
    look(v(0.6, -1.0, 1.1), v(0.0, 0.1, 0.0)) * scale(if mirrored { -k } else { k }, k, k)
}

/// One bounce from the light to the floor to the lens, splatted.
fn light_traced(scene: &Scene, runs: usize, rays: usize, seed: u64) -> Vec<RunningMean> {
    let mut random = Random::new(seed);
    let lambda = Wavelengths::rgb();
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let mut picture = vec![RunningMean::new(); pixels];
    let k = scene.lights.len();
    for _ in 0..runs {
        let mut sum = vec![0.0f64; pixels];
        for _ in 0..rays {
            let light = &scene.lights[((random.f() * k as f32) as usize).min(k - 1)];
            let Some(r) = light.sample_le(scene, random.v2(), random.v2(), &lambda) else {
                continue;
            };
            let lens = random.v2();
            let Some(s) = scene.intersect(&r.ray, f32::INFINITY) else { continue };
            let Some(c) = scene.camera.sample_wi(s.p, lens, 0.0) else { continue };
            let wo = -r.ray.d;
            let mut lambda = lambda;
            let Some(bsdf) = scene.bsdf(&s, wo, &mut lambda) else { continue };
            // The BSDF with its cosine toward the lens, of light that comes along wo.
            let f = bsdf.eval(wo, c.wi, Mode::Importance, Lobes::ALL);
            if f.is_black() || !scene.unoccluded_to(&s, c.p_near) {
                continue;
            }
            let flux = r.le * (k as f32 * r.cos / (r.pdf_a * r.pdf_w));
            let value = flux * f * (c.we / c.pdf_w);
            let at = c.film.y as usize * SIZE[0] as usize + c.film.x as usize;
            sum[at] += ((value.0[0] + value.0[1] + value.0[2]) / 3.0) as f64 / rays as f64;
        }
        for (p, v) in picture.iter_mut().zip(sum) {
            p.push(v);
        }
    }
    picture
}

/// Pixel by pixel where both estimates have a normal law as far out as the level of a comparison
/// asks, all others as one sum.
///
/// A mean of N hits of like size has a skewness of 1/√N, and about that relative error. At the
/// level's 4.7 standard errors a skewness of 0.1 makes the tail, exp(skewness 4.7³/6) by
/// Edgeworth's expansion, six times the normal one; all tails together stay at a few times the
/// level, and hardly any pixel is at that bound.
fn pictures_agree(what: &str, stage: &Stage, seed: u64) {
    let traced = light_traced(&stage.build(), 200, 1000, seed);
    let pathed = stage.render(json!({"only_depth": 1, "max_depth": 1}), 800, seed);
    let mut lit = 0;
    let mut rest = (Vec::new(), Vec::new());
    for (i, (a, b)) in traced.iter().zip(&pathed.pixels).enumerate() {
        if a.relative_error().max(b.relative_error()) < 0.1 {
            same(&format!("{what}, pixel {i}"), a, b);
            lit += 1;
        } else {
            rest.0.push(*a);
            rest.1.push(*b);
        }
    }
    let sum = |p: &[RunningMean]| {
        let variance: f64 = p.iter().map(|p| p.standard_error().powi(2)).sum();
        with_error(p.iter().map(RunningMean::mean).sum(), variance.sqrt())
    };
    same(&format!("{what}, dim pixels"), &sum(&rest.0), &sum(&rest.1));
    same(&format!("{what}, whole picture"), &sum(&traced), &sum(&pathed.pixels));
    assert!(lit >= 12, "{what}: {lit} pixels lit");
}

#[test]
fn every_light_draws_the_path_tracer_s_picture() {
    for (i, (what, mut stage)) in lights().into_iter().enumerate() {
        stage.camera(pinhole(70.0), eye(false), SIZE);
        pictures_agree(what, &stage, 20 + i as u64);
    }
}

#[test]
fn every_camera_receives_the_path_tracer_s_picture() {
    for (i, (what, kind)) in cameras().into_iter().enumerate() {
        for mirrored in [false, true] {
            let mut stage = Stage::new();
            floor(&mut stage);
            stage.lamp(disk(0.3), at(0.0, 0.3, 1.0) * down(), 3.0);
            // A small obstacle: connections have to look.
            let black = stage.diffuse(0.0);
            let black = stage.two_sided(black);
            stage.shape(disk(0.25), at(0.3, -0.3, 0.5), black);
            stage.camera(kind.clone(), eye(mirrored), SIZE);
            pictures_agree(what, &stage, 40 + i as u64);
        }
    }
}

#[test]
fn a_uniform_wall_gives_a_uniform_picture_to_the_corners() {
    // cos⁴ is handled by the importance: every pixel of a wall of radiance B/π is the same.
    let mut stage = Stage::new();
    let m = stage.diffuse(1.0);
    stage.shape(sphere(2.0), HERE, m).flip_normals = true;
    stage.point_light(Vec3::ZERO, 4.0);
    stage.camera(thin_lens(100.0, 0.1, 1.0), HERE, SIZE);
    for (i, p) in light_traced(&stage.build(), 50, 2000, 9).iter().enumerate() {
        agrees(&format!("pixel {i}"), p, 1.0 / std::f64::consts::PI);
    }
}

#[test]
fn connections_invert_camera_rays() {
    for (what, kind) in cameras() {
        for mirrored in [false, true] {
            let mut stage = Stage::new();
            stage.camera(kind.clone(), eye(mirrored), SIZE);
            let scene = stage.build();
            let camera = &scene.camera;
            let mut random = Random::new(13);
            for _ in 0..300 {
                let lens = random.v2();
                let film = v2(random.f() * SIZE[0] as f32, random.f() * SIZE[1] as f32);
                let ray = camera.sample_we(film, lens, 0.0).ray;
                let p = ray.at(0.3 + 3.0 * random.f());
                let c = camera.sample_wi(p, lens, 0.0).expect("it is in the picture");
                assert!((c.film - film).length() < 5e-3, "{what}: {film:?} {:?}", c.film);
                assert!((c.wi + ray.d).length() < 1e-4, "{what}");
                densities(what, camera, &ray, p, &c);
            }
            // What is not in the picture has no density.
            let away = Ray::new(
                camera.position(0.0),
                -camera.sample_we(v2(4.0, 3.0), v2(0.5, 0.5), 0.0).ray.d,
            );
            let spherical = matches!(camera, Camera::Spherical(_));
            assert_eq!(camera.pdf_we(&away) == (0.0, 0.0), !spherical, "{what}");
        }
    }
}

/// we / pdf_w, the weight of a connection, in terms of the densities of rays: over the N pixels
/// of the film, N p_w / d² where a direction is chosen at the lens; N p_a / cos where all rays
/// of a lens point are parallel.
fn densities(
    what: &str,
    camera: &Camera,
    ray: &Ray,
    p: Vec3,
    c: &kaustika_scene::CameraConnection,
) {
    let (pdf_a, pdf_w) = camera.pdf_we(ray);
    let n = (SIZE[0] * SIZE[1]) as f64;
    let weight = c.we as f64 / c.pdf_w as f64;
    let truth = if what.starts_with("parallel") {
        let axis = camera.sample_we(v2(4.0, 3.0), v2(0.5, 0.5), 0.0).ray.d;
        if !c.delta {
            close(&format!("{what}, direction"), pdf_w as f64, c.pdf_w as f64, 1e-3);
        }
        n * pdf_a as f64 / axis.dot(ray.d) as f64
    } else {
        n * pdf_w as f64 / (c.p_lens - p).length_squared() as f64
    };
    close(&format!("{what}, weight"), weight, truth, 2e-3);
}
