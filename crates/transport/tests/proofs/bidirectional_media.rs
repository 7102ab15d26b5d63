//! Paths from both ends through participating media.

use crate::bidirectional::{SIZE, agree, means, renders};
use crate::media::{FORMS, Form, filled, flake_grid, flakes, foggy_room, hg, medium, rgb};
use crate::scenes::*;
use crate::stats::same;
use kaustika_film::FilterDesc;
use kaustika_film::accumulate::{Feature, Layers, PassImage};
use kaustika_film::path_expression::{PathClasses, PathLayer};
use kaustika_sampling::estimator::RunningMean;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::Scene;
use kaustika_scene::description::*;
use kaustika_spectra::{ColorMode, SpectrumDesc};
use kaustika_transport::{Frame, Workers, registry};
use serde_json::{Value, json};
use std::sync::Arc;

/// [`foggy_room`] seen by a picture of some pixels.
fn fog(m: MediumDesc) -> Stage {
    let mut stage = foggy_room(m);
    seen(&mut stage, pinhole(70.0));
    stage
}

fn seen(stage: &mut Stage, kind: CameraKind) {
    let medium = stage.d.cameras[0].medium;
    stage.camera(kind, look(v(0.0, -0.9, 0.0), v(0.0, 0.0, -0.2)), SIZE);
    stage.d.cameras[0].medium = medium;
}

/// σₜ and albedo that differ between the channels.
fn coloured(form: Form) -> MediumDesc {
    let mut m = medium(form, 1.0, 1.0, hg(0.3));
    let (sigma_t, albedo) = (rgb([0.3, 1.0, 2.5]), rgb([0.9, 0.5, 0.8]));
    let [sigma_t, albedo] = [sigma_t, albedo].map(FieldDesc::Constant);
    m.coefficients = CoefficientsDesc::ExtinctionAlbedo(sigma_t, albedo);
    m
}

fn pane(stage: &mut Stage) {
    let one = stage.d.float(1.0);
    let pane = stage.material(MaterialModel::ThinDielectric {
        ior: IorDesc::Constant(1.5),
        specular_reflectance: one,
        specular_transmittance: one,
    });
    stage.shape(GeometryDesc::Rectangle, at(0.3, 0.2, 0.4) * scale(0.4, 0.3, 1.0), pane);
    let (white, half) = (stage.diffuse(0.6), stage.d.float(0.4));
    let mask = stage.material(MaterialModel::Mask { material: white, opacity: half });
    stage.shape(GeometryDesc::Rectangle, at(0.1, 0.0, -0.1) * scale(0.5, 0.9, 1.0), mask);
}

/// Media and what stands in them.
fn stages() -> Vec<(String, Stage)> {
    let mut stages = Vec::new();
    for form in FORMS {
        stages.push((format!("grey, {form:?}"), fog(medium(form, 1.2, 0.8, hg(0.5)))));
    }
    stages.push(("coloured".into(), fog(coloured(Form::Even))));
    stages.push(("coloured, dense".into(), fog(coloured(Form::Dense))));
    let mut glowing = medium(Form::Dense, 0.8, 0.6, hg(-0.2));
    let source = GlowSource::Radiance(FieldDesc::Constant(grey(0.4)));
    glowing.glow = Some(GlowDesc { source, scale: 1.0, grid: None });
    stages.push(("glowing".into(), fog(glowing)));
    let flakes = PhaseDesc::Sggx(SggxDesc::Constant(flakes()));
    stages.push(("microflakes".into(), fog(medium(Form::Even, 2.0, 0.8, flakes))));
    stages.push(("microflakes, grid".into(), fog(medium(Form::Dense, 2.0, 0.8, flake_grid()))));
    let mut panes = fog(medium(Form::Dense, 1.0, 0.8, hg(0.2)));
    pane(&mut panes);
    stages.push(("panes and cut-outs".into(), panes));
    let mut absorbing = fog(medium(Form::Dense, 1.0, 0.0, hg(0.0)));
    seen(&mut absorbing, thin_lens(70.0, 0.1, 1.0));
    stages.push(("nothing but absorption, a lens".into(), absorbing));
    // Fog within glass within fog.
    let mut glass = fog(medium(Form::Even, 0.7, 0.9, hg(0.6)));
    let m = glass.glass(1.3, 0.0);
    glass.d.media.push(medium(Form::Even, 3.0, 0.9, hg(0.0)));
    let ball = glass.shape(sphere(0.3), at(-0.2, 0.2, -0.3), m);
    (ball.interior, ball.exterior) = (Some(MediumId(1)), Some(MediumId(0)));
    stages.push(("glass".into(), glass));
    stages
}

#[test]
fn methods_agree_in_media() {
    for (i, (what, stage)) in stages().into_iter().enumerate() {
        let scene = stage.build();
        assert!(scene.has_media());
        let seed = 2000 + 10 * i as u64;
        let p = json!({"max_depth": 5});
        let path = means(&scene, "path", p.clone(), 500, seed);
        agree(&format!("bdpt, {what}"), &means(&scene, "bdpt", p, 250, seed + 1), &path);
        let p = json!({"max_depth": 5, "radius": 0.004});
        agree(&format!("vcm, {what}"), &renders(&scene, "vcm", p, 20, seed + 2), &path);
    }
}

#[test]
fn light_tracing_sees_fog() {
    // From without: the light of fog at the lens itself has no bound, nor a finite variance.
    for (i, kind) in [pinhole(50.0), thin_lens(50.0, 0.2, 2.0)].into_iter().enumerate() {
        let mut stage = fog(coloured(Form::Dense));
        stage.camera(kind, look(v(0.3, -2.9, 0.4), v(0.0, 0.0, -0.1)), SIZE);
        stage.d.cameras[0].medium = None;
        let scene = stage.build();
        for depth in 1..=3 {
            let p = json!({"only_depth": depth});
            let seed = 2200 + 10 * i as u64 + depth;
            let path = means(&scene, "path", p.clone(), 600, seed);
            let light = means(&scene, "light", p, 600, seed + 5);
            agree(&format!("camera {i}, {depth} bounces"), &light, &path);
        }
    }
}

/// The mean distance and the mean albedo of what camera paths meet first.
fn first_met(scene: &Scene, method: &str, by_path: bool, seed: u64) -> [RunningMean; 2] {
    let kind = SamplerKind::Independent;
    let config = SamplerConfig { kind, seed, spp: 200, resolution: SIZE };
    let mut frame = Frame::new(SIZE, FilterDesc::BOX, config);
    frame.layers = Layers::new(&[Feature::Depth, Feature::Albedo]);
    if by_path {
        let layer = PathLayer::parse("all=C.*").expect("sound");
        frame.keep_paths(PathClasses::new(vec![layer]).expect("one layer"));
    }
    let workers = Workers::new(2, Arc::default()).expect("threads");
    let p = serde_json::Map::from_iter([("max_depth".into(), json!(2))]);
    let mut method = (registry::find(method).expect("known").make)(&p).expect("parameters");
    method.prepare(scene, &frame, &workers).expect("prepared");
    let mut means = [RunningMean::new(), RunningMean::new()];
    for index in 0..200 {
        let mut image = PassImage::new(SIZE[0], SIZE[1], frame.layers.clone());
        method.pass(index, scene, &frame, &mut image, &workers).expect("a pass");
        for (mean, feature) in means.iter_mut().zip([Feature::Depth, Feature::Albedo]) {
            let at = image.layers().offset(feature).expect("kept");
            let pixels = image.data().chunks(image.layers().stride());
            mean.push(pixels.map(|p| f64::from(p[at])).sum());
        }
    }
    means
}

#[test]
fn what_is_met_first_may_be_fog() {
    for (i, form) in FORMS.into_iter().enumerate() {
        let scene = fog(medium(form, 1.2, 0.8, hg(0.5))).build();
        let seed = 2600 + 10 * i as u64;
        let path = first_met(&scene, "path", false, seed);
        let others = [("path", true), ("bdpt", false), ("vcm", false), ("vpl", false)];
        for (k, (method, by_path)) in others.into_iter().enumerate() {
            let met = first_met(&scene, method, by_path, seed + 1 + k as u64);
            // Beside lamps `path` draws distances in another way in even media.
            let first = usize::from(form == Form::Even);
            for (k, what) in ["distance", "albedo"].into_iter().enumerate().skip(first) {
                same(&format!("{form:?}, {method}, {what}"), &met[k], &path[k]);
            }
        }
    }
}

/// A box of fog in which every strategy can make every path.
fn closed_box(m: MediumDesc) -> Scene {
    let mut stage = Stage::new();
    let white = stage.diffuse(0.6);
    let walls = stage.shape(GeometryDesc::Cube, HERE, white);
    walls.flip_normals = true;
    stage.lamp(GeometryDesc::Rectangle, at(0.0, 0.0, 0.9) * down() * scale(0.5, 0.5, 1.0), 3.0);
    filled(&mut stage, GeometryDesc::Cube, scale(2.0, 2.0, 2.0), m);
    stage.camera(thin_lens(80.0, 0.3, 1.2), look(v(0.0, -0.9, 0.1), v(0.0, 1.0, -0.2)), SIZE);
    stage.d.cameras[0].medium = Some(MediumId(0));
    stage.build()
}

#[test]
fn every_strategy_alone_makes_the_paths_of_its_length_in_fog() {
    for (form, first) in [(Form::Even, 2300), (Form::Dense, 2400)] {
        let scene = closed_box(medium(form, 0.8, 0.7, hg(0.4)));
        for depth in 1..=2usize {
            let only = json!({"only_depth": depth});
            let path = means(&scene, "path", only, 800, first + depth as u64);
            for s in 0..=depth + 2 {
                let p = json!({
                    "only_depth": depth, "strategy": format!("{s},{}", depth + 2 - s),
                    "weighted": false, "roulette": "none",
                });
                let passes = if s == depth + 2 { 3000 } else { 800 };
                let seed = first + 20 + 10 * depth as u64 + s as u64;
                let alone = means(&scene, "bdpt", p, passes, seed);
                agree(&format!("{form:?}, {depth} bounces, s = {s}"), &alone, &path);
            }
        }
    }
}

#[test]
fn weighted_strategies_add_up_to_the_picture_of_fog() {
    let scene = closed_box(coloured(Form::Dense));
    let picture = |p: Value| -> Vec<f64> {
        means(&scene, "bdpt", p, 4, 2500).iter().map(RunningMean::mean).collect()
    };
    let whole = picture(json!({"only_depth": 2}));
    let mut sum = vec![0.0; whole.len()];
    for s in 0..=4 {
        let p = json!({"only_depth": 2, "strategy": format!("{s},{}", 4 - s)});
        sum.iter_mut().zip(picture(p)).for_each(|(sum, v)| *sum += v);
    }
    for (sum, whole) in sum.iter().zip(&whole) {
        crate::stats::close("sum of strategies", *sum, *whole, 1e-5);
    }
}

#[test]
fn connections_of_both_weightings_are_the_same_samples_in_fog() {
    let mut stage = fog(coloured(Form::Even));
    pane(&mut stage);
    let scene = stage.build();
    for mis in ["balance", "power"] {
        let p = |extra: (&str, &str)| json!({"max_depth": 5, "mis": mis, extra.0: extra.1});
        let a = means(&scene, "bdpt", p(("roulette", "throughput")), 3, 2510);
        let b = means(&scene, "vcm", p(("mode", "bpt")), 3, 2510);
        for (a, b) in a.iter().zip(&b) {
            crate::stats::close(mis, b.mean(), a.mean(), 2e-3);
        }
    }
}

#[test]
fn dispersed_paths_agree_in_coloured_fog() {
    let lambda = [360.0, 500.0, 600.0, 830.0];
    let sigma = SpectrumDesc::sampled(&lambda, &[3.0, 2.0, 0.3, 0.1]).expect("a spectrum");
    let albedo = SpectrumDesc::sampled(&lambda, &[0.9, 0.5, 0.9, 0.9]).expect("a spectrum");
    let mut m = medium(Form::Even, 1.0, 1.0, hg(0.3));
    let [sigma, albedo] = [sigma, albedo].map(FieldDesc::Constant);
    m.coefficients = CoefficientsDesc::ExtinctionAlbedo(sigma, albedo);
    let mut stage = fog(m);
    let ior = SpectrumDesc::sampled(&[360.0, 830.0], &[1.6, 1.4]).expect("a spectrum");
    let ior = IorDesc::Spectrum(stage.d.add_texture(TextureNode::Spectrum(ior), None));
    let (roughness, one) = (stage.rough(0.0), stage.d.float(1.0));
    let glass = stage.material(MaterialModel::Dielectric {
        ior,
        specular_reflectance: one,
        specular_transmittance: one,
        roughness,
    });
    stage.shape(sphere(0.3), at(-0.1, -0.2, -0.3), glass);
    let scene = stage.build_in(ColorMode::Spectral);
    let p = json!({"max_depth": 5});
    let path = means(&scene, "path", p.clone(), 1500, 2520);
    agree("bdpt", &means(&scene, "bdpt", p, 600, 2521), &path);
}
