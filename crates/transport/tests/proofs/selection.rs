//! The choice of a light: probabilities sum to one, and frequencies follow them.

use crate::scenes::*;
use crate::stats::{Random, close, follows};
use kaustika_math::Vec3;
use kaustika_scene::description::*;
use kaustika_scene::{LightId, LightSelectionKind as K, Scene};

/// Lights of every kind, some dark, some with one position.
fn lights(count: usize, infinite: bool) -> Stage {
    let mut stage = Stage::new();
    floor(&mut stage);
    let mut random = Random::new(count as u64);
    for i in 0..count {
        let p = random.v3();
        let t = at(3.0 * p.x, 3.0 * p.y, 1.0 + p.z) * rotate(360.0 * random.f(), random.v3());
        let k = (6.0 * random.f()).exp();
        match i % 7 {
            0 => drop(stage.lamp(sphere(0.1), t, k)),
            1 => drop(stage.lamp(disk(0.3), t, k)),
            2 => drop(stage.lamp(GeometryDesc::Rectangle, t * scale(0.1, 0.3, 1.0), k)),
            3 => stage.light(
                LightKind::Spot {
                    intensity: grey(k),
                    scale: 1.0,
                    power: None,
                    cutoff: 50.0,
                    beam_width: 35.0,
                    falloff: SpotFalloff::SmoothstepCosine,
                    texture: None,
                },
                t,
            ),
            4 => stage.point_light(v(0.5, 0.5, 0.5), k),
            5 => stage.point_light(v(0.5, 0.5, 0.5), 0.0),
            _ => drop(stage.lamp(disk(0.3), t, k).emission.as_mut().map(|e| e.two_sided = true)),
        }
    }
    if infinite {
        stage.sky(0.2);
        let kind = LightKind::Directional { irradiance: grey(1.0), scale: 1.0, illuminance: None };
        stage.light(kind, HERE);
    }
    stage
}

fn pmfs(scene: &Scene, p: Vec3, n: Vec3) -> Vec<f64> {
    let ids = 0..scene.lights.len() as u32;
    ids.map(|i| scene.light_selection.pmf(p, n, LightId(i)) as f64).collect()
}

#[test]
fn probabilities_sum_to_one_everywhere() {
    let mut random = Random::new(1);
    for kind in [K::Uniform, K::Power, K::Bvh] {
        for (count, infinite) in [(1, false), (2, true), (0, true), (40, false), (200, true)] {
            let mut stage = lights(count, infinite);
            stage.selection = Some(kind);
            let scene = stage.build();
            for i in 0..60 {
                let size = if i % 5 == 0 { 1e4 } else { 3.0 };
                let p = random.v3() * size;
                let n = if i % 3 == 0 { Vec3::ZERO } else { random.v3().normalize() };
                let sum: f64 = pmfs(&scene, p, n).iter().sum();
                close(&format!("{kind:?} over {count}"), sum, 1.0, 2e-5);
            }
        }
    }
}

#[test]
fn frequencies_follow_probabilities() {
    let mut random = Random::new(2);
    for kind in [K::Uniform, K::Power, K::Bvh] {
        for (count, infinite) in [(3, true), (50, false), (50, true)] {
            let mut stage = lights(count, infinite);
            stage.selection = Some(kind);
            let scene = stage.build();
            for i in 0..8 {
                let p = random.v3() * 2.0;
                let n = if i % 3 == 0 { Vec3::ZERO } else { random.v3().normalize() };
                let pmf = pmfs(&scene, p, n);
                let mut counts = vec![0.0; pmf.len()];
                let draws = 20_000;
                for _ in 0..draws {
                    let s = scene.light_selection.sample(p, n, random.f(), random.v2());
                    let s = s.expect("there are lights");
                    close("sample and pmf", s.p as f64, pmf[s.light.0 as usize], 1e-4);
                    counts[s.light.0 as usize] += 1.0;
                }
                let expected: Vec<f64> = pmf.iter().map(|q| q * draws as f64).collect();
                follows(&format!("{kind:?} over {count}"), &counts, &expected);
            }
        }
    }
}

#[test]
fn a_light_that_contributes_has_a_chance() {
    // Whatever light a point receives, the hierarchy gives that light some probability.
    let stage = {
        let mut s = lights(80, false);
        s.selection = Some(K::Bvh);
        s
    };
    let scene = stage.build();
    let mut random = Random::new(3);
    let lambda = kaustika_spectra::Wavelengths::rgb();
    let mut lit = 0;
    for _ in 0..400 {
        let (p, n) = (random.v3() * 3.0, random.v3().normalize());
        let pmf = pmfs(&scene, p, n);
        for (i, light) in scene.lights.iter().enumerate() {
            let Some(l) = light.sample_li(&scene, p, random.v2(), &lambda) else { continue };
            if l.le.0[0] > 0.0 && n.abs_dot(l.wi) > 1e-4 {
                // A share of the intensity may round to nothing beside brighter ones.
                assert!(pmf[i] > 0.0 || l.le.0[0] < 1e-4, "light {i} at {p:?}");
                lit += 1;
            }
        }
    }
    assert!(lit > 5000, "{lit}");
}

#[test]
fn few_lights_are_chosen_by_power_and_others_learned() {
    let default = |count, infinite| K::for_lights(&lights(count, infinite).build().lights);
    assert_eq!(default(2, false), K::Power);
    // Under a sky, and of many lamps.
    assert_eq!(default(0, true), K::Learned);
    assert_eq!(default(100, false), K::Learned);
    // A lamp beside a directional light.
    let mut stage = lights(1, false);
    let kind = LightKind::Directional { irradiance: grey(1.0), scale: 1.0, illuminance: None };
    stage.light(kind, HERE);
    assert_eq!(K::for_lights(&stage.build().lights), K::Bvh);
    let names = ["uniform", "power", "bvh", "learned"];
    for (name, kind) in names.into_iter().zip([K::Uniform, K::Power, K::Bvh, K::Learned]) {
        assert_eq!(name.parse(), Ok(kind));
    }
    assert!("kdtree".parse::<K>().is_err());
}
