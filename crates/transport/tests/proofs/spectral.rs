//! RGB and spectral rendering of the same RGB scene.

use crate::scenes::*;
use kaustika_film::FilterDesc;
use kaustika_math::{Ray, Vec3};
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::CameraRay;
use kaustika_scene::description::*;
use kaustika_spectra::{ColorMode, ColorSpace, Sensor, SpectrumDesc, Wavelengths};
use kaustika_transport::path::Integrator;
use kaustika_transport::{Frame, PassStats};
use serde_json::{Value, json};

/// Sensor values along one ray, by wavelengths in regular steps.
fn seen(stage: &Stage, mode: ColorMode, o: Vec3, d: Vec3, p: Value, n: u64) -> [f64; 3] {
    let scene = stage.build_in(mode);
    let config =
        SamplerConfig { kind: SamplerKind::Independent, seed: 3, spp: n, resolution: [1, 1] };
    let frame = Frame::new([1, 1], FilterDesc::BOX, config);
    let p = params(p);
    let integrator = Integrator::new(&scene, &frame, &p);
    let ray = CameraRay {
        ray: Ray::new(o, d.normalize()),
        t_max: f32::INFINITY,
        spread: 0.0,
        width: 0.0,
        weight: 1.0,
        receiver: None,
    };
    let mut sum = [0.0; 3];
    let mut stats = PassStats::default();
    for i in 0..n {
        let lambda = Wavelengths::sample_for(mode, (i as f32 + 0.5) / (n as f32));
        let sampler = frame.sampler.start([0, 0], i);
        let s = integrator.li(&ray, lambda, sampler, &mut stats);
        let rgb = Sensor::default().rgb(s.radiance, &s.lambda);
        for c in 0..3 {
            sum[c] += rgb[c] as f64 / n as f64;
        }
    }
    sum
}

fn colour(rgb: [f32; 3]) -> SpectrumDesc {
    SpectrumDesc::Rgb { rgb, space: ColorSpace::Srgb }
}

/// A coloured floor under a coloured point light.
fn stage(albedo: [f32; 3], light: [f32; 3]) -> Stage {
    let mut stage = Stage::new();
    let reflectance = stage.d.rgb(albedo);
    let m = stage.material(MaterialModel::Diffuse { reflectance });
    stage.shape(GeometryDesc::Rectangle, HERE, m);
    let kind = LightKind::Point { intensity: colour(light), scale: 1.0, power: None };
    stage.light(kind, at(0.0, 0.0, 1.0));
    stage
}

#[test]
fn direct_light_has_the_same_colour() {
    for (albedo, light, tolerance) in [
        ([0.5, 0.5, 0.5], [1.0, 1.0, 1.0], 0.005),
        ([0.6, 0.3, 0.2], [3.0, 3.0, 3.0], 0.01),
        ([0.1, 0.4, 0.7], [1.0, 1.0, 1.0], 0.01),
        // A product of two colours is not the product of their numbers: of the light's size.
        ([0.6, 0.4, 0.3], [1.0, 0.8, 0.6], 0.03),
    ] {
        let stage = stage(albedo, light);
        let p = json!({"max_depth": 1});
        let (o, d) = (v(0.0, -0.5, 0.5), v(0.0, 0.5, -0.5));
        let rgb = seen(&stage, ColorMode::Rgb, o, d, p.clone(), 1);
        let spectral = seen(&stage, ColorMode::Spectral, o, d, p, 4096);
        let size = rgb.iter().fold(0.0f64, |m, v| m.max(*v));
        for c in 0..3 {
            let truth = albedo[c] as f64 * light[c] as f64 / std::f64::consts::PI;
            assert!((rgb[c] - truth).abs() < 1e-5 * truth, "{rgb:?}");
            let error = (spectral[c] - rgb[c]).abs();
            assert!(error < tolerance * size, "{albedo:?} {light:?}: {rgb:?} {spectral:?}");
        }
    }
}

#[test]
fn environments_and_lamps_keep_their_colour() {
    let rgb = [0.8, 0.5, 0.3];
    let mut around = Stage::new();
    around.light(
        LightKind::Image {
            bitmap: bitmap(4, 2, |_, _| rgb),
            space: ColorSpace::Srgb,
            layout: EnvironmentLayout::LatLong,
            scale: 2.0,
            illuminance: None,
        },
        HERE,
    );
    let mut lamp = Stage::new();
    let radiance = lamp.d.rgb(rgb);
    let e = lamp.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, 1.0) * down(), 1.0);
    *e.emission.as_mut().expect("a lamp") = EmissionDesc {
        radiance,
        scale: 2.0,
        power: None,
        two_sided: false,
        along_normal: false,
        span: None,
    };
    for (what, stage) in [("environment", around), ("lamp", lamp)] {
        for mode in [ColorMode::Rgb, ColorMode::Spectral] {
            let got = seen(&stage, mode, Vec3::ZERO, Vec3::Z, json!({}), 4096);
            for c in 0..3 {
                let truth = 2.0 * rgb[c] as f64;
                assert!((got[c] - truth).abs() < 0.01 * truth, "{what} {mode:?}: {got:?}");
            }
        }
    }
}

#[test]
fn a_grey_furnace_is_spectral_too() {
    let mut stage = Stage::new();
    let (m, e) = (stage.diffuse(0.5), stage.d.rgb([1.0; 3]));
    let s = stage.shape(sphere(1.0), HERE, m);
    s.flip_normals = true;
    s.emission = Some(EmissionDesc {
        radiance: e,
        scale: 1.0,
        power: None,
        two_sided: false,
        along_normal: false,
        span: None,
    });
    let p = json!({"mis": "bsdf", "roulette": "none", "max_depth": 20});
    let got = seen(&stage, ColorMode::Spectral, v(0.1, 0.2, 0.3), Vec3::X, p, 2048);
    for c in got {
        assert!((c - 2.0).abs() < 0.01, "{got:?}");
    }
}
