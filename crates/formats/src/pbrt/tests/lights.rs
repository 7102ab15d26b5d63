//! Lights with and without surfaces.

use super::files::pfm;
use super::{assert_maps, messages, read, rgb, world};
use crate::pbrt::read_pbrt;
use kaustika_math::Vec3;
use kaustika_scene::description::{
    EmissionDesc, EnvironmentLayout, LightDesc, LightKind, SceneDescription, SpotFalloff,
};
use kaustika_spectra::SpectrumDesc;
use std::f32::consts::PI;
use tempfile::TempDir;

fn light(text: &str) -> LightDesc {
    world(text).lights[0].clone()
}

#[track_caller]
fn assert_near(found: f32, expected: f32) {
    assert!((found - expected).abs() <= 2e-4 * expected.abs(), "{found}, expected {expected}");
}

#[test]
fn points_have_a_place_and_a_power() {
    let l = light("Translate 1 0 0 LightSource \"point\" \"point3 from\" [ 0 2 0 ]");
    assert_maps(&l.transform, [0.0; 3], [1.0, 2.0, 0.0]);
    let white = SpectrumDesc::Rgb { rgb: [1.0; 3], space: Default::default() };
    assert_eq!(l.kind, LightKind::Point { intensity: white, scale: 1.0, power: None });
    // pbrt's power does not look at the components of the colour.
    let l = light("LightSource \"point\" \"rgb I\" [ 3 3 3 ] \"float power\" 40 \"float scale\" 2");
    let LightKind::Point { scale, .. } = l.kind else { panic!() };
    assert_near(scale, 2.0 * 40.0 / (4.0 * PI));
}

#[test]
fn spectra_other_than_rgb_are_scaled_to_unit_luminance() {
    let scale = |text: &str| match light(&format!("LightSource \"point\" {text}")).kind {
        LightKind::Point { scale, .. } => scale,
        _ => panic!(),
    };
    // A flat spectrum of 4 has luminance 4.
    assert_near(scale("\"spectrum I\" [ 200 4 900 4 ]"), 0.25);
    assert_near(scale("\"spectrum I\" \"stdillum-D65\" \"float scale\" 7"), 7.0);
    // A black body at 6500 K is scaled to a maximum of 1, at 446 nm, where the eye sees little; at
    // 555 nm it has 0.90.
    let blackbody = scale("\"blackbody I\" 6500");
    assert!((1.1..1.16).contains(&blackbody), "{blackbody}");
    assert_eq!(scale("\"rgb I\" [ 4 4 4 ]"), 1.0);
}

#[test]
fn spots_look_from_one_point_at_another() {
    let text = "LightSource \"spot\" \"point3 from\" [ 1 2 3 ] \"point3 to\" [ 1 2 10 ]
        \"float coneangle\" 40 \"float conedeltaangle\" 10 \"float power\" 5";
    let l = light(text);
    assert_maps(&l.transform, [0.0; 3], [1.0, 2.0, 3.0]);
    assert_maps(&l.transform, [0.0, 0.0, 7.0], [1.0, 2.0, 10.0]);
    let LightKind::Spot { cutoff, beam_width, falloff, scale, .. } = l.kind else { panic!() };
    assert_eq!((cutoff, beam_width, falloff), (40.0, 30.0, SpotFalloff::SmoothstepCosine));
    let (end, start) = (40f32.to_radians().cos(), 30f32.to_radians().cos());
    assert_near(scale, 5.0 / (2.0 * PI * (1.0 - start + 0.5 * (start - end))));
    let LightKind::Spot { cutoff, beam_width, .. } = light("LightSource \"spot\"").kind else {
        panic!()
    };
    assert_eq!((cutoff, beam_width), (30.0, 25.0));
}

#[test]
fn distant_light_travels_from_from_to_to() {
    let text = "LightSource \"distant\" \"point3 from\" [ 0 5 0 ] \"point3 to\" [ 0 0 0 ]
        \"rgb L\" [ 1 2 3 ] \"float illuminance\" 100";
    let l = light(text);
    assert_maps(&l.transform, [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]);
    let LightKind::Directional { scale, illuminance, .. } = l.kind else { panic!() };
    assert_eq!((scale, illuminance), (100.0, None));
    assert_maps(&light("LightSource \"distant\"").transform, [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]);
}

#[test]
fn constant_surroundings() {
    let l = light(
        "LightSource \"infinite\" \"rgb L\" [ 1 2 3 ] \"float scale\" 2 \"float illuminance\" 10",
    );
    let LightKind::Constant { radiance, scale, .. } = l.kind else { panic!() };
    assert_eq!(radiance, SpectrumDesc::Rgb { rgb: [1.0, 2.0, 3.0], space: Default::default() });
    assert_near(scale, 2.0 * 10.0 / PI);
}

fn with_image(text: &str, width: usize, height: usize, value: f32) -> SceneDescription {
    let dir = TempDir::new().unwrap();
    std::fs::write(dir.path().join("i.pfm"), pfm(width, height, value)).unwrap();
    std::fs::write(dir.path().join("main.pbrt"), format!("WorldBegin {text}")).unwrap();
    read_pbrt(&dir.path().join("main.pbrt"))
}

#[test]
fn environments_are_equal_area_squares() {
    let text = "LightSource \"infinite\" \"string filename\" \"i.pfm\" \"float scale\" 3";
    let s = with_image(text, 4, 4, 1.0);
    assert_eq!(messages(&s), "");
    let LightKind::Image { layout, scale, bitmap, .. } = &s.lights[0].kind else { panic!() };
    assert_eq!((*layout, *scale), (EnvironmentLayout::EqualArea, 3.0));
    assert_eq!((bitmap.width, bitmap.height), (4, 4));
    let s = with_image(text, 8, 4, 1.0);
    assert_eq!(
        messages(&s),
        "warning 1:53 <\"i.pfm\"> the environment map is twice as wide as high: read as \
         latitude-longitude\n"
    );
    // The middle of the map lies along -x of the file's space, +z is up.
    let t = &s.lights[0].transform;
    assert_maps(t, [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]);
    assert_maps(t, [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let s = with_image(text, 5, 4, 1.0);
    assert!(messages(&s).starts_with(
        "error 1:53 <\"i.pfm\"> `i.pfm` is 5 x 4 pixels, an environment map must be square; pbrt-v4"
    ));
    let s = with_image(text, 4, 4, f32::INFINITY);
    assert_eq!(messages(&s), "error 1:53 <\"i.pfm\"> `i.pfm` has infinite or undefined pixels\n");
}

#[test]
fn portals_are_windows() {
    let of = |portal: &str| {
        format!("Translate 5 5 5 LightSource \"infinite\" \"string filename\" \"i.pfm\" {portal}")
    };
    let text = of("\"point3 portal\" [ 0 0 2  0 1 2  1 1 2  1 0 2 ]");
    let s = with_image(&text, 4, 4, 1.0);
    assert_eq!(messages(&s), "");
    // In world space, as in pbrt, whatever the current transform is.
    let LightKind::Portal { corners, .. } = &s.lights[0].kind else { panic!() };
    assert_eq!(corners[2], Vec3::new(1.0, 1.0, 2.0));
    for (portal, message) in [
        ("[ 0 0 2  0 1 2  1 1 2 ]", "a portal has four corners, found 3"),
        (
            "[ 0 0 2  0 1 2  2 1 2  1 0 2 ]",
            "the corners of a portal must be those of a rectangle, in order",
        ),
    ] {
        let s = with_image(&of(&format!("\"point3 portal\" {portal}")), 4, 4, 1.0);
        assert!(messages(&s).contains(message), "{}", messages(&s));
    }
}

#[test]
fn an_even_sky_shines_through_a_portal_too() {
    let sky = |text: &str| {
        let portal = "\"point3 portal\" [ 0 0 2  0 1 2  1 1 2  1 0 2 ]";
        let s = world(&format!("LightSource \"infinite\" {text} \"float scale\" 3 {portal}"));
        let LightKind::Portal { bitmap, scale, .. } = &s.lights[0].kind else { panic!("{text}") };
        ([0, 1, 2].map(|c| super::super::images::texel(bitmap, 0, 0, c)), *scale)
    };
    assert_eq!(sky(""), ([1.0; 3], 3.0));
    assert_eq!(sky("\"rgb L\" [ 1 2 3 ]"), ([1.0, 2.0, 3.0], 3.0));
    // Twice what is flat stays twice, and is about as white as the flat spectrum.
    let ([r, g, b], _) = sky("\"spectrum L\" [ 300 2 900 2 ]");
    assert!((0.2126 * r + 0.7152 * g + 0.0722 * b - 2.0).abs() < 1e-2, "{r} {g} {b}");
    // As with images of equal area: half of what it gives.
    assert!((sky("\"float illuminance\" 6").1 - 3.0 * 6.0 / std::f32::consts::TAU).abs() < 1e-5);
}

#[test]
fn projections_span_the_shorter_side() {
    let text = "LightSource \"projection\" \"string filename\" \"i.pfm\" \"float fov\" 60";
    let s = with_image(text, 4, 2, 1.0);
    assert_eq!(messages(&s), "");
    let LightKind::Projection { fov_x, scale, .. } = &s.lights[0].kind else { panic!() };
    assert_near(*fov_x, 2.0 * (2.0 * 30f32.to_radians().tan()).atan().to_degrees());
    assert_eq!(*scale, 1.0);
    let s = with_image(text, 2, 4, 1.0);
    let LightKind::Projection { fov_x, .. } = &s.lights[0].kind else { panic!() };
    assert_near(*fov_x, 60.0);
    // The solid angle of a square picture of 90 degrees is a sixth of the sphere.
    let text = "LightSource \"projection\" \"string filename\" \"i.pfm\" \"float power\" 10";
    let s = with_image(text, 64, 64, 2.0);
    let LightKind::Projection { scale, .. } = &s.lights[0].kind else { panic!() };
    let expected = 10.0 / (2.0 * 4.0 * PI / 6.0);
    assert!((scale - expected).abs() < 1e-3 * expected, "{scale} {expected}");
}

#[test]
fn goniometric_lights_turn_y_up() {
    let text = "LightSource \"goniometric\" \"string filename\" \"i.pfm\" \"float power\" 10";
    let s = with_image(text, 4, 4, 0.5);
    assert_eq!(messages(&s), "");
    let LightKind::Goniometric { scale, .. } = &s.lights[0].kind else { panic!() };
    assert_near(*scale, 10.0 / (4.0 * PI * 0.5));
    assert_maps(&s.lights[0].transform, [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]);
}

fn emission(text: &str) -> EmissionDesc {
    world(text).shapes[0].emission.clone().unwrap()
}

#[test]
fn area_lights_belong_to_all_shapes_behind_them() {
    let s = world(
        "AreaLightSource \"diffuse\" \"rgb L\" [ 1 2 3 ] \"float scale\" 2 \"bool twosided\" true
        Shape \"sphere\" Shape \"disk\"",
    );
    let e = s.shapes[1].emission.as_ref().unwrap();
    assert_eq!((e.scale, e.power, e.two_sided), (2.0, None, true));
    assert_eq!(rgb(&s, e.radiance), [1.0, 2.0, 3.0]);
    assert_eq!(s.shapes[0].emission.as_ref(), Some(e));
    let e = emission("AreaLightSource \"diffuse\" Shape \"sphere\"");
    assert_eq!((e.scale, e.two_sided), (1.0, false));
}

#[test]
fn power_is_spread_over_the_area() {
    let light = "AreaLightSource \"diffuse\" \"float power\" 10 \"float scale\" 3";
    // Each of the two triangles, of area 2 after scaling, emits it.
    let quad = "Scale 2 2 2 Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 1 1 0 0 1 0 ]
        \"integer indices\" [ 0 1 2 0 2 3 ]";
    assert_near(emission(&format!("{light} {quad}")).scale, 3.0 * 10.0 / (2.0 * PI));
    let sphere = "Shape \"sphere\" \"float radius\" 2";
    assert_near(emission(&format!("{light} {sphere}")).scale, 3.0 * 10.0 / (16.0 * PI * PI));
    let both = format!("{light} \"bool twosided\" true {sphere}");
    assert_near(emission(&both).scale, 3.0 * 10.0 / (2.0 * 16.0 * PI * PI));
}

#[test]
fn lights_that_do_not_shine_in_pbrt_do_not_here() {
    let text = "WorldBegin AreaLightSource \"diffuse\"
Material \"interface\" Shape \"sphere\"
Material \"diffuse\"
ObjectBegin \"o\" Shape \"sphere\" ObjectEnd";
    let s = read(text);
    assert!(s.shapes[0].emission.is_none() && s.groups[0].shapes[0].emission.is_none());
    assert_eq!(
        messages(&s),
        "warning 2:22 <Shape> lights on shapes of material `interface` do not shine, as in pbrt\n\
         warning 4:17 <Shape> lights on shapes inside objects do not shine, as in pbrt\n"
    );
}
