//! Guided light tracing, and light paths that split: whatever was learned, and if it is nonsense,
//! the picture is that of plain light tracing; and light goes where it shows.

use crate::bidirectional::{SIZE, agree, means, means_of};
use crate::breaks::threads_and_breaks;
use crate::guided::{RULES, furnished};
use crate::scenes::*;
use crate::stats::same;
use kaustika_film::FilterDesc;
use kaustika_film::accumulate::PassImage;
use kaustika_sampling::estimator::RunningMean;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::Scene;
use kaustika_scene::description::*;
use kaustika_spectra::{ColorMode, SpectrumDesc};
use kaustika_transport::particle::{GuidedLight, LightParams};
use kaustika_transport::{Frame, Method, Workers, registry};
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn guided(p: Value) -> GuidedLight {
    let p: LightParams = serde_json::from_value(p).expect("sound parameters");
    GuidedLight::new(p)
}

#[test]
fn every_rule_guided_or_not_gives_the_plain_picture() {
    let scene = furnished().build();
    let plain = means(&scene, "light", json!({"max_depth": 5}), 3000, 2100);
    for (i, rule) in RULES.into_iter().enumerate() {
        for guiding in [false, true] {
            let method = guided(json!({"max_depth": 5, "roulette": rule, "guiding": guiding}));
            let seed = 2110 + 2 * i as u64 + u64::from(guiding);
            let found = means_of(&scene, Box::new(method), 1000, seed);
            agree(&format!("{rule}, guiding {guiding}"), &found, &plain);
        }
    }
}

#[test]
fn nonsense_that_is_learned_costs_time_and_no_bias() {
    let scene = furnished().build();
    let plain = means(&scene, "light", json!({"max_depth": 3}), 3000, 2130);
    for (i, rule) in ["throughput", "adjoint", "efficiency"].into_iter().enumerate() {
        let p = json!({"max_depth": 3, "roulette": rule, "guiding": true});
        let found = means_of(&scene, Box::new(guided(p).misled()), 1500, 2131 + i as u64);
        agree(&format!("{rule}, misled"), &found, &plain);
    }
}

/// A kind of light by name, and what adds it to a stage.
type Kind<'a> = (&'a str, &'a dyn Fn(&mut Stage));

/// Light of every kind, many lamps and a lens with an area: emission is guided all the same.
#[test]
fn every_light_is_guided_without_bias() {
    let painted = |x: f32, y: f32| [0.2 + x, 0.5 + y, 0.3 + 3.0 * x * y];
    let kinds: [Kind; 5] = [
        ("two-sided disk", &|s| {
            s.lamp(disk(0.25), at(0.3, 0.2, 1.2) * rotate(60.0, kaustika_math::Vec3::Y), 8.0);
            let l = s.d.shapes.last_mut().expect("a lamp");
            l.emission.as_mut().expect("it emits").two_sided = true;
        }),
        ("point and parallel", &|s| {
            s.point_light(v(0.4, -0.2, 1.3), 2.0);
            let irradiance = grey(2.0);
            let kind = LightKind::Directional { irradiance, scale: 1.0, illuminance: None };
            s.light(kind, rotate(150.0, v(1.0, 0.3, 0.1)));
        }),
        ("sky", &|s| s.sky(0.7)),
        ("painted sky", &|s| {
            let kind = LightKind::Image {
                bitmap: bitmap(8, 4, painted),
                space: kaustika_spectra::ColorSpace::Srgb,
                layout: EnvironmentLayout::LatLong,
                scale: 0.5,
                illuminance: None,
            };
            s.light(kind, HERE);
        }),
        ("many spheres", &|s| {
            for i in 0..6 {
                s.lamp(sphere(0.08), at(-0.7 + 0.25 * i as f32, 0.3, 1.5), 2.0 + 5.0 * i as f32);
            }
        }),
    ];
    for (i, (what, light)) in kinds.into_iter().enumerate() {
        let mut stage = crate::bidirectional::room();
        light(&mut stage);
        let lens = thin_lens(60.0, 0.2, 2.5);
        stage.camera(lens, look(v(0.1, -2.6, 1.0), v(0.0, 0.0, 0.7)), SIZE);
        let scene = stage.build();
        let plain = means(&scene, "light", json!({"max_depth": 3}), 1500, 2140 + i as u64);
        let p = json!({"max_depth": 3, "roulette": "adjoint", "guiding": true});
        let found = means_of(&scene, Box::new(guided(p)), 800, 2150 + i as u64);
        agree(what, &found, &plain);
    }
}

#[test]
fn each_number_of_bounces_agrees() {
    let scene = furnished().build();
    for depth in 1..=3 {
        let p = json!({"only_depth": depth, "roulette": "efficiency", "guiding": true});
        let plain = means(&scene, "light", json!({"only_depth": depth}), 1500, 2160 + depth);
        agree(
            &format!("{depth} bounces"),
            &means_of(&scene, Box::new(guided(p)), 800, 2170 + depth),
            &plain,
        );
    }
}

#[test]
fn paths_that_lose_wavelengths_keep_their_light() {
    let mut stage = furnished();
    let ior = SpectrumDesc::sampled(&[400.0, 700.0], &[1.7, 1.4]).expect("rises");
    let ior = stage.d.add_texture(TextureNode::Spectrum(ior), None);
    let (roughness, one) = (stage.rough(0.3), stage.d.float(1.0));
    let glass = stage.material(MaterialModel::Dielectric {
        ior: IorDesc::Spectrum(ior),
        specular_reflectance: one,
        specular_transmittance: one,
        roughness,
    });
    stage.shape(sphere(0.25), at(0.0, -0.6, 0.5), glass);
    let scene = stage.build_in(ColorMode::Spectral);
    let plain = means(&scene, "light", json!({"max_depth": 4}), 2000, 2180);
    let p = json!({"max_depth": 4, "roulette": "efficiency", "guiding": true});
    let found = means_of(&scene, Box::new(guided(p)), 1000, 2181);
    agree("spectral", &found, &plain);
}

/// A lit room that is seen through its open side, and behind its wall, by so much, another one with
/// a lamp four times as bright, into which nobody looks.
pub(crate) fn two_rooms(gap: f32) -> Scene {
    let mut stage = crate::bidirectional::room();
    let lamp = |s: &mut Stage, y: f32, radiance: f32| {
        let t = at(0.2, y, 1.7) * down() * scale(0.3, 0.2, 1.0);
        s.lamp(GeometryDesc::Rectangle, t, radiance);
    };
    lamp(&mut stage, 0.1, 8.0);
    let white = stage.diffuse(0.8);
    let behind = at(0.0, 3.0 + gap, 1.0) * scale(2.0, 2.0, 1.2);
    stage.shape(GeometryDesc::Cube, behind, white).flip_normals = true;
    lamp(&mut stage, 2.9 + gap, 32.0);
    stage.build()
}

#[test]
fn rooms_that_nobody_sees_grow_empty() {
    let scene = two_rooms(0.1);
    let config = |seed| SamplerConfig {
        kind: SamplerKind::Independent,
        seed,
        spp: 256,
        resolution: [48, 32],
    };
    let workers = Workers::new(2, Arc::new(AtomicBool::new(false))).expect("threads");
    // Vertices in the unseen room, of a pass after some that taught: means over renders.
    let unseen = |p: Value| {
        let [mut there, mut all, mut film] = [RunningMean::new(); 3];
        for seed in 0..6 {
            let frame = Frame::new([48, 32], FilterDesc::BOX, config(2190 + seed));
            let mut method = guided(p.clone());
            method.prepare(&scene, &frame, &workers).expect("prepared");
            for index in 0..31 {
                let mut image = PassImage::new(48, 32, frame.layers.clone());
                method.pass(index, &scene, &frame, &mut image, &workers).expect("a pass");
                if index >= 15 {
                    let stride = image.layers().stride();
                    film.push(image.data().chunks(stride).map(|p| f64::from(p[0])).sum());
                }
            }
            let vertices = method.vertices(31, &scene, &frame, &workers).expect("a pass");
            let behind = vertices.iter().filter(|p| p.y > 1.05).count();
            all.push(vertices.len() as f64);
            there.push(behind as f64);
        }
        (there, all, film)
    };
    let (plain, all, flux) = unseen(json!({}));
    // Of the light 8/9 is emitted there, and it stays long.
    assert!(plain.mean() > 0.85 * all.mean(), "{} of {}", plain.mean(), all.mean());
    // A quarter of the paths begins by power, whatever is known: they are a fifth of what is left.
    for rule in ["adjoint", "efficiency"] {
        let (there, _, found) = unseen(json!({"roulette": rule, "guiding": true}));
        same(&format!("flux on the film, {rule}"), &found, &flux);
        let most = there.mean() + 3.0 * there.standard_error();
        assert!(most < 0.25 * plain.mean(), "{rule}: {} of {}", there.mean(), plain.mean());
        // Roulette alone empties it, too: what arrives there is not scattered on.
        let (there, _, found) = unseen(json!({"roulette": rule, "splitting": false}));
        same(&format!("flux on the film, {rule} alone"), &found, &flux);
        let most = there.mean() + 3.0 * there.standard_error();
        assert!(most < plain.mean(), "{rule} alone: {} of {}", there.mean(), plain.mean());
    }
}

#[test]
fn threads_and_breaks_change_no_bit() {
    let p = json!({"max_depth": 5, "roulette": "efficiency", "guiding": true});
    // In the midst of an iteration, and at the end of one.
    threads_and_breaks(&furnished().build(), || guided(p.clone()), 20, &[9, 15]);
}

#[test]
fn what_does_not_go_together_is_refused() {
    let make = registry::find("light").expect("known").make;
    for p in [json!({"nee": false, "guiding": true}), json!({"nee": false, "roulette": "adjoint"})]
    {
        let Value::Object(p) = p else { panic!("an object") };
        let error = make(&p).err().expect("refused");
        assert!(error.contains("`nee`"), "{error}");
    }
}
