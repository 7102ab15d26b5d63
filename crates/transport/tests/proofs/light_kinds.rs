//! Every light that can be met by chance: sampling it and meeting it agree.

use crate::scenes::*;
use crate::stats::{Random, same};
use kaustika_math::{Ray, Transform, Vec3};
use kaustika_scene::description::*;
use kaustika_spectra::{ColorSpace, Wavelengths};
use serde_json::json;

/// Sampling the light, meeting it and both, at two points of the floor.
fn techniques_agree(what: &str, stage: &Stage) {
    let scene = stage.build();
    for (x, y) in [(0.0, 0.0), (1.1, -0.7)] {
        let mean =
            |mis: &str| irradiance(&scene, x, y, json!({"mis": mis, "max_depth": 1}), 20_000);
        let (light, bsdf, both) = (mean("light"), mean("bsdf"), mean("power"));
        assert!(bsdf.mean() > 0.0, "{what}: dark");
        same(&format!("{what} at {x}, light and bsdf"), &light, &bsdf);
        same(&format!("{what} at {x}, light and both"), &light, &both);
    }
}

#[test]
fn area_lights() {
    let triangle = mesh(&[v(-0.5, 0.0, 1.0), v(0.7, 0.1, 0.9), v(0.0, 0.8, 1.3)], &[[0, 2, 1]]);
    let cut = GeometryDesc::Sphere { radius: 0.5, z_min: -0.2, z_max: 0.4, phi_max: 250.0 };
    let ring = GeometryDesc::Disk { height: 0.2, radius: 0.6, inner_radius: 0.3, phi_max: 300.0 };
    let tube = GeometryDesc::Cylinder { radius: 0.3, z_min: -0.5, z_max: 0.8, phi_max: 360.0 };
    let lying = at(0.2, 0.1, 0.9) * rotate(70.0, Vec3::Y);
    let cases = [
        ("triangle", triangle, HERE),
        ("sphere", sphere(0.4), lying),
        ("ellipsoid", sphere(0.4), lying * scale(1.0, 0.5, 1.4)),
        ("cut sphere", cut, lying),
        ("disk", disk(0.5), at(0.2, 0.0, 0.8) * down()),
        ("ellipse", disk(0.5), at(0.2, 0.0, 0.8) * down() * scale(1.5, 0.6, 1.0)),
        ("ring", ring, at(0.0, 0.0, 1.0) * down()),
        ("cylinder", tube.clone(), lying),
        ("squeezed cylinder", tube, lying * scale(1.0, 0.4, 1.0)),
        ("rectangle", GeometryDesc::Rectangle, at(0.0, 0.3, 1.0) * down() * scale(0.6, 0.3, 1.0)),
        ("cube", GeometryDesc::Cube, lying * scale(0.3, 0.2, 0.2)),
    ];
    for (what, form, t) in cases {
        for two_sided in [false, true] {
            let mut stage = Stage::new();
            floor(&mut stage);
            let lamp = stage.lamp(form.clone(), t, 2.0);
            lamp.emission.as_mut().expect("a lamp").two_sided = two_sided;
            techniques_agree(&format!("{what}, two-sided {two_sided}"), &stage);
        }
    }
}

/// However far away for its size, a lamp that all of its light reaches does not shadow itself.
#[test]
fn lamps_do_not_shadow_themselves() {
    let tube = GeometryDesc::Cylinder { radius: 0.5, z_min: -1.0, z_max: 1.0, phi_max: 360.0 };
    let forms = [
        ("rectangle", GeometryDesc::Rectangle),
        ("cube", GeometryDesc::Cube),
        ("disk", disk(1.0)),
        ("sphere", sphere(1.0)),
        ("ellipsoid", sphere(1.0)),
        ("cylinder", tube),
    ];
    let lambda = Wavelengths::rgb();
    for (what, form) in forms {
        let mut random = Random::new(5);
        for i in 0..400 {
            // Anywhere, turned, stretched by up to 20 and 1/20, seen from 1 to 1000 sizes.
            let k = random.v3() * 3.0;
            let k = if what == "sphere" { Vec3::splat(k.x) } else { k };
            let k = v(k.x.exp(), k.y.exp(), k.z.exp());
            let center = random.v3() * (5.0 * random.f()).exp();
            let turn = rotate(360.0 * random.f(), random.v3());
            let lamp = Transform::translate(center) * turn * scale(k.x, k.y, k.z);
            let size = k.max_component();
            let toward = random.v3().normalize();
            let eye = center + toward * size * 2.0 * (6.0 * random.f()).exp();
            let mut stage = Stage::new();
            stage.lamp(form.clone(), lamp, 1.0);
            let m = stage.diffuse(0.5);
            let wall = look(eye, center) * scale(0.1 * size, 0.1 * size, 1.0);
            stage.shape(GeometryDesc::Rectangle, wall, m);
            let scene = stage.build();
            let wall = Ray::new(eye - toward * 0.1 * size, toward);
            let s = scene.intersect(&wall, f32::INFINITY).expect("the wall is there");
            let lights = scene.lights.len();
            for j in 0..100 {
                let light = &scene.lights[j % lights];
                let Some(l) = light.sample_li(&scene, s.p, random.v2(), &lambda) else { continue };
                if !l.le.is_black() {
                    assert!(!scene.occluded(&scene.shadow_ray(&s, &l)), "{what} {i}");
                }
            }
        }
    }
}

#[test]
fn light_from_within() {
    // The floor inside an emitting sphere: E = πL.
    let mut stage = Stage::new();
    floor(&mut stage);
    stage.lamp(sphere(3.0), at(0.4, 0.0, 0.5), 2.0).flip_normals = true;
    techniques_agree("inside of a sphere", &stage);
    let e = irradiance(&stage.build(), 0.0, 0.0, json!({"max_depth": 1}), 20_000);
    crate::stats::agrees("inside of a sphere", &e, 2.0 * std::f64::consts::PI);
}

#[test]
fn painted_lights() {
    let paint = bitmap(8, 4, |x, y| [4.0 * x * y, (3.0 * x).floor(), 0.1]);
    for (what, form, t) in [
        ("painted rectangle", GeometryDesc::Rectangle, at(0.2, 0.0, 0.8) * down()),
        ("painted sphere", sphere(0.4), at(0.3, 0.2, 0.8) * rotate(40.0, Vec3::X)),
        ("painted disk", disk(0.6), at(0.3, 0.2, 0.8) * down()),
    ] {
        let mut stage = Stage::new();
        floor(&mut stage);
        let radiance = texture(&mut stage, paint.clone(), BitmapFilter::Bilinear);
        stage.lamp(form, t, 1.0).emission.as_mut().expect("a lamp").radiance = radiance;
        techniques_agree(what, &stage);
    }
}

#[test]
fn environments() {
    let sun = |x: f32, y: f32| {
        let d2 = (x - 0.3).powi(2) + (y - 0.2).powi(2);
        [0.2 + 30.0 * (-200.0 * d2).exp(), 0.2 + y, 0.5 * x]
    };
    for (what, layout, w, h) in [
        ("lat-long", EnvironmentLayout::LatLong, 32, 16),
        ("equal-area", EnvironmentLayout::EqualArea, 24, 24),
    ] {
        let mut stage = Stage::new();
        floor(&mut stage);
        let kind = LightKind::Image {
            bitmap: bitmap(w, h, sun),
            space: ColorSpace::Srgb,
            layout,
            scale: 0.7,
            illuminance: None,
        };
        stage.light(kind, rotate(100.0, v(1.0, 0.3, -0.2)));
        techniques_agree(what, &stage);
    }
    let mut stage = Stage::new();
    floor(&mut stage);
    stage.sky(0.3);
    techniques_agree("constant", &stage);
}

/// A sky of a low sun, as it is and reaching below the horizon, and the sun, near the zenith and
/// half set behind the floor's horizon.
#[test]
fn daylight() {
    let turn = rotate(100.0, v(1.0, 0.3, -0.2));
    for (turbidity, stretch, extend) in [(2.0, 1.0, false), (6.0, 1.3, false), (4.0, 1.0, true)] {
        let mut stage = Stage::new();
        floor(&mut stage);
        let albedo = grey(0.3);
        let sun = v(0.5, 0.6, 0.3);
        let sky = SkyDesc { turbidity, albedo, sun, stretch, extend };
        stage.light(LightKind::Sky { sky, scale: 2.0 }, turn);
        techniques_agree(&format!("sky {turbidity} {stretch} {extend}"), &stage);
    }
    for (toward, radius) in [(v(0.1, 0.2, 1.0), 20.0), (v(1.0, 0.0, 0.05), 15.0)] {
        let mut stage = Stage::new();
        floor(&mut stage);
        stage.light(
            LightKind::Sun { radiance: grey(3.0), scale: 2.0, radius },
            look(v(0.0, 0.0, 0.0), toward),
        );
        techniques_agree(&format!("sun of {radius}"), &stage);
    }
}

/// A room with a window in its ceiling, and a bright spot in the sky: the same whether the light is
/// sampled through the window or not.
#[test]
fn portals() {
    let sky = |x: f32, y: f32| {
        let d2 = (x - 0.55).powi(2) + (y - 0.45).powi(2);
        [0.2 + 60.0 * (-400.0 * d2).exp(), 0.2 + y, 0.5 * x]
    };
    let (space, scale_of) = (ColorSpace::Srgb, 0.7);
    let turn = rotate(30.0, v(1.0, 0.3, -0.2));
    for (layout, w, h) in
        [(EnvironmentLayout::LatLong, 32, 16), (EnvironmentLayout::EqualArea, 24, 24)]
    {
        let room = |kind: LightKind| {
            let mut stage = Stage::new();
            floor(&mut stage);
            let wall = stage.diffuse(0.6);
            // The ceiling around the window of x in [-0.5, 0.5], y in [-0.4, 0.4].
            for (x, y, a, b) in [
                (-5.25, 0.0, 4.75, 10.0),
                (5.25, 0.0, 4.75, 10.0),
                (0.0, -5.2, 0.5, 4.8),
                (0.0, 5.2, 0.5, 4.8),
            ] {
                stage.shape(
                    GeometryDesc::Rectangle,
                    at(x, y, 1.0) * down() * scale(a, b, 1.0),
                    wall,
                );
            }
            for turned in [0.0, 90.0, 180.0, 270.0] {
                let t = rotate(turned, Vec3::Z)
                    * at(3.9, 0.0, 0.0)
                    * rotate(-90.0, Vec3::Y)
                    * scale(1.0, 10.0, 1.0);
                stage.shape(GeometryDesc::Rectangle, t, wall);
            }
            stage.light(kind, turn);
            stage
        };
        let image = || bitmap(w, h, sky);
        let open = room(LightKind::Image {
            bitmap: image(),
            space,
            layout,
            scale: scale_of,
            illuminance: None,
        });
        let corners = window(v(-0.5, -0.4, 1.0));
        let through =
            room(LightKind::Portal { bitmap: image(), space, layout, scale: scale_of, corners });
        techniques_agree(&format!("portal {layout:?}"), &through);
        for (x, y) in [(0.0, 0.0), (1.3, -0.6)] {
            let e = |stage: &Stage, depth: u32| {
                irradiance(&stage.build(), x, y, json!({"max_depth": depth}), 40_000)
            };
            let (a, b) = (e(&open, 3), e(&through, 3));
            same(&format!("{layout:?} at {x}"), &a, &b);
            // What it is for.
            let (a, b) = (e(&open, 1), e(&through, 1));
            assert!(b.variance() < a.variance(), "{} {}", b.variance(), a.variance());
        }
    }
}

#[test]
fn many_lights_under_every_selection() {
    use kaustika_scene::LightSelectionKind as K;
    let mut stage = Stage::new();
    floor(&mut stage);
    let mut random = crate::stats::Random::new(5);
    for i in 0..24 {
        let p = random.v3();
        let t = at(2.0 * p.x, 2.0 * p.y, 1.0 + 0.6 * p.z) * rotate(360.0 * random.f(), random.v3());
        let form = match i % 4 {
            0 => sphere(0.1),
            1 => disk(0.2),
            2 => GeometryDesc::Rectangle,
            _ => GeometryDesc::Cylinder { radius: 0.05, z_min: 0.0, z_max: 0.4, phi_max: 360.0 },
        };
        stage.lamp(form, t * scale(0.5, 0.5, 0.5), 4.0 * random.f());
    }
    stage.sky(0.1);
    let mut all = Vec::new();
    for kind in [K::Uniform, K::Power, K::Bvh] {
        stage.selection = Some(kind);
        techniques_agree(&format!("{kind:?}"), &stage);
        let p = json!({"mis": "light", "max_depth": 1});
        all.push(irradiance(&stage.build(), 0.3, 0.2, p, 20_000));
    }
    same("uniform and power", &all[0], &all[1]);
    same("uniform and bvh", &all[0], &all[2]);
    // What the hierarchy is for.
    assert!(all[2].variance() < all[0].variance());
}
