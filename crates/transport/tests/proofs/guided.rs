//! Guided paths and trees of paths: whatever was learned, and if it is nonsense, the picture is
//! that of plain paths.

use crate::bidirectional::{SIZE, agree, means, means_of, room};
use crate::breaks::threads_and_breaks;
use crate::media::{Form, filled, hg, medium, rgb};
use crate::scenes::*;
use kaustika_film::FilterDesc;
use kaustika_film::accumulate::{Feature, Layers, PassImage};
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::description::*;
use kaustika_spectra::{ColorMode, SpectrumDesc};
use kaustika_transport::path::guided::{Guided, GuidedParams};
use kaustika_transport::{Frame, Method, Workers};
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A room with glass, metal and a lamp behind a screen, so that most light comes by a wall.
pub(crate) fn furnished() -> Stage {
    let mut stage = room();
    let glass = stage.glass(1.5, 0.0);
    stage.shape(sphere(0.25), at(0.45, -0.2, 0.26), glass);
    let white = stage.diffuse(0.6);
    let screen = stage.two_sided(white);
    let t = at(0.2, 0.1, 1.45) * scale(0.5, 0.4, 1.0);
    stage.shape(GeometryDesc::Rectangle, t, screen);
    stage.lamp(GeometryDesc::Rectangle, at(0.2, 0.1, 1.7) * down() * scale(0.3, 0.2, 1.0), 8.0);
    stage
}

pub(crate) const RULES: [&str; 6] =
    ["none", "throughput", "albedo", "szirmay-kalos", "adjoint", "efficiency"];

/// The method, which never goes on as plain paths.
fn guided(p: Value) -> Guided {
    let Value::Object(mut p) = p else { panic!("an object") };
    p.insert("fallback".into(), false.into());
    let p: GuidedParams = serde_json::from_value(Value::Object(p)).expect("sound parameters");
    Guided::new(p)
}

#[test]
fn every_rule_with_every_field_gives_the_plain_picture() {
    let scene = furnished().build();
    let path = means(&scene, "path", json!({"max_depth": 6}), 3000, 2000);
    for (i, rule) in RULES.into_iter().enumerate() {
        for (k, field) in ["none", "quadtree", "mixture"].into_iter().enumerate() {
            let method = guided(json!({"max_depth": 6, "roulette": rule, "field": field}));
            let found = means_of(&scene, Box::new(method), 700, 2010 + 3 * i as u64 + k as u64);
            agree(&format!("{rule}, {field}"), &found, &path);
        }
    }
}

#[test]
fn nonsense_that_is_learned_costs_time_and_no_bias() {
    let scene = furnished().build();
    let path = means(&scene, "path", json!({"max_depth": 4}), 3000, 2070);
    for (i, rule) in ["throughput", "adjoint", "efficiency"].into_iter().enumerate() {
        let p = json!({"max_depth": 4, "roulette": rule});
        let found = means_of(&scene, Box::new(guided(p).misled()), 1000, 2071 + i as u64);
        agree(&format!("{rule}, misled"), &found, &path);
    }
}

#[test]
fn each_number_of_bounces_agrees() {
    let scene = furnished().build();
    for depth in 1..=3 {
        let path = means(&scene, "path", json!({"only_depth": depth}), 2000, 2040 + depth);
        let method = guided(json!({"only_depth": depth, "roulette": "efficiency"}));
        let found = means_of(&scene, Box::new(method), 600, 2050 + depth);
        agree(&format!("{depth} bounces"), &found, &path);
    }
}

#[test]
fn branches_that_lose_wavelengths_keep_their_light() {
    // A prism's ball: only the hero goes on, and light on the wall behind it is mixed from
    // branches with four wavelengths and with one.
    let mut stage = furnished();
    let ior = SpectrumDesc::sampled(&[400.0, 700.0], &[1.7, 1.4]).expect("rises");
    let ior = stage.d.add_texture(TextureNode::Spectrum(ior), None);
    let (roughness, one) = (stage.rough(0.0), stage.d.float(1.0));
    let glass = stage.material(MaterialModel::Dielectric {
        ior: IorDesc::Spectrum(ior),
        specular_reflectance: one,
        specular_transmittance: one,
        roughness,
    });
    stage.shape(sphere(0.25), at(0.0, -0.6, 0.5), glass);
    let scene = stage.build_in(ColorMode::Spectral);
    let path = means(&scene, "path", json!({"max_depth": 6}), 3000, 2060);
    for (i, rule) in ["szirmay-kalos", "efficiency"].into_iter().enumerate() {
        let method = guided(json!({"max_depth": 6, "roulette": rule}));
        let found = means_of(&scene, Box::new(method), 800, 2061 + i as u64);
        agree(&format!("{rule}, spectral"), &found, &path);
    }
}

/// [`furnished`], filled with what absorbs and glows, a box of something denser, coloured glass.
fn hazy() -> Stage {
    let mut stage = furnished();
    let absorbing = |c: [f32; 3]| {
        let mut m = medium(Form::Even, 1.0, 0.0, hg(0.0));
        let (sigma_t, none) = (FieldDesc::Constant(rgb(c)), FieldDesc::Constant(grey(0.0)));
        m.coefficients = CoefficientsDesc::ExtinctionAlbedo(sigma_t, none);
        m
    };
    let mut haze = absorbing([0.2, 0.1, 0.4]);
    let source = GlowSource::Radiance(FieldDesc::Constant(grey(0.1)));
    haze.glow = Some(GlowDesc { source, scale: 1.0, grid: None });
    stage.d.media.push(haze);
    let all = Some(MediumId(stage.d.media.len() as u32 - 1));
    stage.d.cameras[0].medium = all;
    let t = at(-0.3, 0.1, 0.6) * scale(0.2, 0.2, 0.3);
    filled(&mut stage, GeometryDesc::Cube, t, absorbing([1.0, 3.0, 2.0]));
    stage.d.shapes.last_mut().expect("the box").exterior = all;
    let glass = stage.glass(1.5, 0.0);
    stage.d.media.push(absorbing([4.0, 0.5, 2.0]));
    let inside = Some(MediumId(stage.d.media.len() as u32 - 1));
    let ball = stage.shape(sphere(0.2), at(0.0, -0.6, 0.5), glass);
    (ball.interior, ball.exterior) = (inside, all);
    stage
}

#[test]
fn what_absorbs_weakens_guided_light() {
    let scene = hazy().build();
    let path = means(&scene, "path", json!({"max_depth": 5}), 3000, 2080);
    for (i, rule) in ["none", "adjoint", "efficiency"].into_iter().enumerate() {
        let p = json!({"max_depth": 5, "roulette": rule, "warmup": 3});
        let found = means_of(&scene, Box::new(guided(p)), 700, 2081 + i as u64);
        agree(&format!("{rule}, absorbed"), &found, &path);
    }
}

#[test]
fn media_that_scatter_are_refused() {
    assert!(guided(json!({})).knows_media(&furnished().build()));
    assert!(guided(json!({})).knows_media(&hazy().build()));
    let mut stage = furnished();
    filled(&mut stage, GeometryDesc::Cube, HERE, medium(Form::Even, 1.0, 0.5, hg(0.0)));
    assert!(!guided(json!({})).knows_media(&stage.build()));
}

#[test]
fn threads_and_breaks_change_no_bit() {
    let p = json!({"max_depth": 5, "roulette": "efficiency", "warmup": 3});
    // In the midst of an iteration, and at the end of one.
    threads_and_breaks(&furnished().build(), || guided(p.clone()), 20, &[9, 15]);
}

#[test]
fn the_layer_of_trees_counts_every_ray() {
    let scene = furnished().build();
    let config = SamplerConfig { kind: SamplerKind::Sobol, seed: 4, spp: 16, resolution: SIZE };
    let mut frame = Frame::new(SIZE, FilterDesc::BOX, config);
    frame.layers = Layers::new(&[Feature::Depth, Feature::Trees]);
    let workers = Workers::new(2, Arc::new(AtomicBool::new(false))).expect("threads");
    let mut method = guided(json!({"max_depth": 5, "roulette": "adjoint", "warmup": 3}));
    assert!(method.grows_trees());
    method.prepare(&scene, &frame, &workers).expect("prepared");
    let at = frame.layers.offset(Feature::Trees).expect("kept");
    let mut all_added = 0.0;
    for index in 0..15 {
        let mut image = PassImage::new(SIZE[0], SIZE[1], frame.layers.clone());
        let commit = method.pass(index, &scene, &frame, &mut image, &workers).expect("a pass");
        let sum = |k: usize| -> f64 {
            image.data().chunks(frame.layers.stride()).map(|pixel| f64::from(pixel[at + k])).sum()
        };
        let [factor, added, ended, longest, rays] = [0, 1, 2, 3, 4].map(sum);
        let pixels = f64::from(SIZE[0] * SIZE[1]);
        assert_eq!(rays, (commit.stats.closest_rays + commit.stats.shadow_rays) as f64);
        assert!(longest <= 5.0 * pixels && longest > pixels, "{longest}");
        assert!(factor > 0.0);
        // While the rule waits no path is split, and none is ended.
        let waits = (1..3).contains(&index);
        assert!(!waits || (added, ended, factor) == (0.0, 0.0, pixels), "{index}");
        all_added += added;
    }
    assert!(all_added > 0.0);
}
