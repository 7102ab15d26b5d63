//! Photon maps of photons that learn: whatever was learned, and if it is nonsense, the picture is
//! that of photons which know nothing, at the same radius; and photons go where they are read.

use crate::bidirectional::{agree, means, means_of};
use crate::breaks::threads_and_breaks;
use crate::guided::{RULES, furnished};
use crate::guided_light::two_rooms;
use crate::photons::furnace;
use crate::scenes::*;
use crate::stats::same;
use kaustika_film::FilterDesc;
use kaustika_film::accumulate::PassImage;
use kaustika_sampling::estimator::RunningMean;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::description::*;
use kaustika_spectra::{ColorMode, SpectrumDesc};
use kaustika_transport::particle::photon_map::{GuidedPhotonMapper, PhotonMapParams};
use kaustika_transport::{Frame, Method, Workers, registry};
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Parameters of small tests, and others over them. All photons within a fixed radius count: means do
/// not depend on where photons are dense.
fn with(extra: Value) -> Value {
    let mut p = json!({
        "photons": 2000, "caustic_photons": 1000, "nearest": 1_000_000, "caustic_nearest": 1_000_000,
        "radius": 0.1, "caustic_radius": 0.05, "filter": "box", "gather": 1, "alpha": 1.0, "max_depth": 4,
    });
    let (Value::Object(all), Value::Object(extra)) = (&mut p, extra) else { panic!("objects") };
    all.extend(extra);
    p
}

fn guided(extra: Value) -> GuidedPhotonMapper {
    let p: PhotonMapParams = serde_json::from_value(with(extra)).expect("sound parameters");
    GuidedPhotonMapper::new(p)
}

#[test]
fn every_rule_guided_or_not_gives_the_plain_picture() {
    let scene = furnished().build();
    let plain = means(&scene, "photonmap", with(json!({})), 600, 2300);
    for (i, rule) in RULES.into_iter().enumerate() {
        for guiding in [false, true] {
            let method = guided(json!({"roulette": rule, "guiding": guiding}));
            let seed = 2310 + 2 * i as u64 + u64::from(guiding);
            let found = means_of(&scene, Box::new(method), 300, seed);
            agree(&format!("{rule}, guiding {guiding}"), &found, &plain);
        }
    }
}

#[test]
fn even_small_errors_of_power_would_show_in_an_integrating_sphere() {
    // All light is alike there: what photons bring is known to a thousandth.
    let scene = furnace(0.5).build();
    let p = json!({"photons": 10_000, "caustic_photons": 1, "radius": 0.3, "gather": 0});
    let plain = means(&scene, "photonmap", with(p.clone()), 120, 2380);
    for (i, rule) in ["throughput", "adjoint", "efficiency"].into_iter().enumerate() {
        for (k, misled) in [false, true].into_iter().enumerate() {
            let mut p = p.clone();
            (p["roulette"], p["guiding"], p["training"]) = (rule.into(), true.into(), 7.into());
            let method = if misled { guided(p).misled() } else { guided(p) };
            let found = means_of(&scene, Box::new(method), 60, 2381 + 2 * i as u64 + k as u64);
            agree(&format!("{rule}, misled {misled}"), &found, &plain);
        }
    }
}

#[test]
fn nonsense_that_is_learned_costs_time_and_no_bias() {
    let scene = furnished().build();
    let plain = means(&scene, "photonmap", with(json!({"max_depth": 3})), 600, 2330);
    for (i, rule) in ["throughput", "adjoint", "efficiency"].into_iter().enumerate() {
        let method = guided(json!({"max_depth": 3, "roulette": rule, "guiding": true})).misled();
        let found = means_of(&scene, Box::new(method), 400, 2331 + i as u64);
        agree(&format!("{rule}, misled"), &found, &plain);
    }
}

#[test]
fn each_number_of_bounces_and_each_map_agrees() {
    let scene = furnished().build();
    for (i, extra) in [
        json!({"only_depth": 2}),
        json!({"only_depth": 3}),
        json!({"gather": 0, "caustic_photons": 1, "photons": 20_000, "max_depth": 2}),
        json!({"photons": 1, "gather": 2}),
        json!({"matte": 0.1}),
        json!({"matte": 0.9}),
    ]
    .into_iter()
    .enumerate()
    {
        let plain = means(&scene, "photonmap", with(extra.clone()), 500, 2340 + i as u64);
        let what = extra.to_string();
        let mut extra = extra;
        (extra["roulette"], extra["guiding"]) = ("adjoint".into(), true.into());
        let found = means_of(&scene, Box::new(guided(extra)), 250, 2350 + i as u64);
        agree(&what, &found, &plain);
    }
}

#[test]
fn photons_that_lose_wavelengths_keep_their_light() {
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
    let plain = means(&scene, "photonmap", with(json!({})), 800, 2360);
    let method = guided(json!({"roulette": "efficiency", "guiding": true}));
    let found = means_of(&scene, Box::new(method), 400, 2361);
    agree("spectral", &found, &plain);
}

#[test]
fn the_sun_and_points_are_guided_without_bias() {
    // Emission of a light at infinity is aimed by its places, that of others by their directions.
    let mut stage = furnished();
    stage.point_light(v(0.4, -0.2, 1.3), 0.5);
    let kind = LightKind::Directional { irradiance: grey(1.0), scale: 1.0, illuminance: None };
    stage.light(kind, rotate(150.0, v(1.0, 0.3, 0.1)));
    let scene = stage.build();
    let plain = means(&scene, "photonmap", with(json!({})), 500, 2365);
    let method = guided(json!({"roulette": "adjoint", "guiding": true}));
    agree("kinds", &means_of(&scene, Box::new(method), 300, 2366), &plain);
}

#[test]
fn rooms_that_nobody_sees_grow_empty_of_photons() {
    // Cells are coarse after so few passes: no wall of both.
    let scene = two_rooms(3.0);
    let workers = Workers::new(2, Arc::new(AtomicBool::new(false))).expect("threads");
    // Radii that do not reach through the wall. Photons in the unseen room and in all, and the flux that arrives in the seen one.
    let counted = |p: Value| {
        let [mut there, mut all, mut flux] = [RunningMean::new(); 3];
        for seed in 0..4 {
            let config = SamplerConfig {
                kind: SamplerKind::Independent,
                seed: 2370 + seed,
                spp: 256,
                resolution: [48, 32],
            };
            let frame = Frame::new([48, 32], FilterDesc::BOX, config);
            let mut p = p.clone();
            (p["radius"], p["photons"]) = (0.02.into(), 20_000.into());
            let mut method = guided(p);
            method.prepare(&scene, &frame, &workers).expect("prepared");
            for index in 0..7 {
                let mut image = PassImage::new(48, 32, frame.layers.clone());
                method.pass(index, &scene, &frame, &mut image, &workers).expect("a pass");
            }
            let photons = method.photons(7, &scene, &frame, &workers).expect("a pass");
            let behind = photons.iter().filter(|(p, _)| p.y > 1.05).count();
            all.push(photons.len() as f64);
            there.push(behind as f64);
            let seen = photons.iter().filter(|(p, _)| p.y < 1.05).map(|(_, f)| f64::from(*f));
            flux.push(seen.sum());
        }
        (there, all, flux)
    };
    // Of the light 8/9 is emitted there, and it stays long.
    let (there, all, flux) = counted(json!({"roulette": "albedo"}));
    assert!(there.mean() > 0.8 * all.mean(), "{} of {}", there.mean(), all.mean());
    for rule in ["adjoint", "efficiency"] {
        let (found, _, arrived) = counted(json!({"roulette": rule, "guiding": true}));
        same(&format!("flux in the seen room, {rule}"), &arrived, &flux);
        let most = found.mean() + 3.0 * found.standard_error();
        assert!(most < 0.25 * there.mean(), "{rule}: {} of {}", found.mean(), there.mean());
    }
}

#[test]
fn threads_and_breaks_change_no_bit() {
    let p = json!({"roulette": "efficiency", "guiding": true});
    // Before anything is known, in the midst of an iteration, and at the end of one.
    threads_and_breaks(&furnished().build(), || guided(p.clone()), 12, &[1, 5, 7]);
}

#[test]
fn what_does_not_go_together_is_refused() {
    let make = registry::find("photonmap").expect("known").make;
    for (p, key) in [
        (json!({"renew": 2, "guiding": true}), "`renew`"),
        (json!({"cache": 0.2, "roulette": "adjoint"}), "`cache`"),
    ] {
        let Value::Object(p) = p else { panic!("an object") };
        let error = make(&p).err().expect("refused");
        assert!(error.contains(key), "{error}");
    }
}
