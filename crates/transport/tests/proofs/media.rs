//! Participating media against closed forms, quadrature, equilibrium and themselves.

use crate::scenes::*;
use crate::stats::{agrees, close, same};
use kaustika_film::FilterDesc;
use kaustika_math::{Transform, Vec3};
use kaustika_sampling::estimator::RunningMean;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::description::*;
use kaustika_spectra::{ColorMode, ColorSpace, SpectrumDesc};
use kaustika_transport::path::Integrator;
use kaustika_transport::{Frame, PassStats, Session, Workers, registry};
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::sync::Arc;

/// How the same coefficients are described.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Form {
    /// Once and for all.
    Even,
    /// By a grid of extinctions, all alike.
    Grid,
    /// By a density of 2, halved by the scale, in cells of which some have a majorant too high.
    Dense,
}
pub(crate) const FORMS: [Form; 3] = [Form::Even, Form::Grid, Form::Dense];

pub(crate) fn rgb(c: [f32; 3]) -> SpectrumDesc {
    SpectrumDesc::Rgb { rgb: c, space: ColorSpace::Srgb }
}

/// Samples over the cube [-2, 2]³.
fn grid(resolution: [u32; 3], values: Vec<f32>) -> Arc<GridDesc> {
    let to_world = at(-2.0, -2.0, -2.0) * scale(4.0, 4.0, 4.0);
    let layout = GridLayout::CellsClamped;
    Arc::new(GridDesc {
        resolution,
        channels: 1,
        values,
        to_world,
        layout,
        filter: Default::default(),
    })
}

/// σₜ, albedo and phase function.
pub(crate) fn medium(form: Form, sigma_t: f32, albedo: f32, phase: PhaseDesc) -> MediumDesc {
    let albedo = FieldDesc::Constant(grey(albedo));
    let extinction = |v| CoefficientsDesc::ExtinctionAlbedo(v, albedo);
    let (coefficients, density, scale) = match form {
        Form::Even => (extinction(FieldDesc::Constant(grey(sigma_t))), None, 1.0),
        Form::Grid => {
            let values = grid([3, 4, 5], vec![1.0; 60]);
            (extinction(FieldDesc::Grid(values)), None, sigma_t)
        }
        Form::Dense => {
            // A corner that no test comes near is denser.
            let mut values = vec![2.0; 4 * 4 * 4];
            values[0] = 5.0;
            let values = grid([4, 4, 4], values);
            let density = Some(DensityDesc::Grid(values));
            (extinction(FieldDesc::Constant(grey(sigma_t))), density, 0.5)
        }
    };
    let extent = (form != Form::Even).then(|| at(-2.0, -2.0, -2.0) * self::scale(4.0, 4.0, 4.0));
    MediumDesc {
        name: String::new(),
        kind: String::new(),
        coefficients,
        scale,
        density,
        glow: None,
        phase,
        extent,
        span: None,
    }
}

/// A shape of nothing, filled with a medium.
pub(crate) fn filled(stage: &mut Stage, g: GeometryDesc, t: Transform, m: MediumDesc) {
    let null = stage.material(MaterialModel::Null { counts: false });
    fill(stage, g, t, null, m);
}

fn fill(stage: &mut Stage, g: GeometryDesc, t: Transform, material: MaterialId, m: MediumDesc) {
    stage.d.media.push(m);
    let id = MediumId(stage.d.media.len() as u32 - 1);
    stage.shape(g, t, material).interior = Some(id);
}

pub(crate) fn hg(g: f32) -> PhaseDesc {
    PhaseDesc::HenyeyGreenstein { g }
}

/// The mean of ∫ₐᵇ f by Simpson's rule.
fn simpson(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    const N: usize = 400;
    let h = (b - a) / N as f64;
    let weight = |i| if i == 0 || i == N { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
    (0..=N).map(|i| weight(i) * f(a + i as f64 * h)).sum::<f64>() * h / 3.0
}

#[test]
fn a_slab_lets_through_what_beer_says() {
    for form in FORMS {
        for albedo in [0.0, 0.7] {
            let mut stage = Stage::new();
            stage.sky(1.0);
            filled(&mut stage, GeometryDesc::Cube, HERE, medium(form, 0.8, albedo, hg(0.3)));
            // 2 units straight through, not along an axis of the grid's cells.
            let d = v(0.2, 0.1, 1.0).normalize();
            let truth = (-0.8 * 2.0 / d.z as f64).exp();
            let p = json!({"only_depth": 0});
            let mean = stage.probe(d * (-1.5 / d.z), d, p, 20_000);
            agrees(&format!("{form:?} {albedo}"), &mean, truth);
            if form == Form::Even && albedo == 0.0 {
                assert!(mean.standard_error() < 1e-6, "no choice was to be made");
            }
        }
    }
}

#[test]
fn a_ramp_lets_through_what_its_integral_says() {
    // Corners: σₜ = 0 at z = -2, 3 at z = 2, linear.
    for albedo in [0.0, 0.9] {
        let mut stage = Stage::new();
        stage.sky(1.0);
        let mut m = medium(Form::Grid, 1.0, albedo, PhaseDesc::Isotropic);
        let mut ramp = (*grid([1, 1, 16], (0..16).map(|i| 0.2 * i as f32).collect())).clone();
        ramp.layout = GridLayout::Corners;
        let albedo_desc = FieldDesc::Constant(grey(albedo));
        m.coefficients =
            CoefficientsDesc::ExtinctionAlbedo(FieldDesc::Grid(Arc::new(ramp)), albedo_desc);
        filled(&mut stage, GeometryDesc::Cube, HERE, m);
        // From z = -1 to 1: ∫ 0.75 (z + 2) dz = 3.
        let p = json!({"only_depth": 0});
        let mean = stage.probe(v(0.1, 0.2, -3.0), Vec3::Z, p, 40_000);
        agrees(&format!("ramp {albedo}"), &mean, (-3.0f64).exp());
    }
}

/// Light of a sky of 1 that a ball scatters once toward a ray through its middle.
fn once_scattered(sigma_t: f64, albedo: f64, g: f64) -> f64 {
    let p = |c: f64| (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * c).powf(1.5));
    simpson(0.0, 2.0, |t| {
        // The light's direction of flight makes the angle of cosine c with that of the path.
        let x = 1.0 - t;
        let arriving = simpson(-1.0, 1.0, |c| {
            // Back along the light, from x on the axis: c counts toward the viewer.
            let way = -x * -c + (1.0 - x * x * (1.0 - c * c)).max(0.0).sqrt();
            2.0 * PI * p(c) * (-sigma_t * way).exp()
        });
        sigma_t * albedo * (-sigma_t * t).exp() * arriving
    })
}

#[test]
fn once_scattered_light_of_a_ball() {
    for form in FORMS {
        for (g, mis) in
            [(0.0, "power"), (0.5, "power"), (-0.6, "balance"), (0.5, "bsdf"), (0.5, "light")]
        {
            let mut stage = Stage::new();
            stage.sky(1.0);
            filled(&mut stage, sphere(1.0), HERE, medium(form, 1.3, 0.8, hg(g)));
            let p = json!({"only_depth": 1, "mis": mis});
            let mean = stage.probe(v(0.0, 0.0, -3.0), Vec3::Z, p, 20_000);
            let truth = once_scattered(1.3, 0.8, g as f64);
            agrees(&format!("{form:?} g {g} {mis}"), &mean, truth);
        }
    }
}

#[test]
fn once_scattered_light_of_a_lamp_in_fog() {
    // The camera stands in fog that has no end, a point light beside its ray.
    for form in FORMS {
        let mut stage = Stage::new();
        stage.point_light(v(0.5, 0.0, 1.0), 3.0);
        stage.d.media.push(medium(form, 0.9, 0.6, hg(0.4)));
        stage.d.cameras[0].medium = Some(MediumId(0));
        let p = json!({"only_depth": 1});
        let mean = stage.probe(Vec3::ZERO, Vec3::Z, p, 40_000);
        let end = if form == Form::Even { 14.0 } else { 2.0 };
        let truth = simpson(0.0, end, |t| {
            let d = (0.25 + (1.0 - t) * (1.0 - t)).sqrt();
            // The angle between the light's flight to the point and from there to the camera.
            let c = (1.0 - t) / d;
            let phase = (1.0 - 0.16) / (4.0 * PI * (1.0 + 0.16 - 0.8 * c).powf(1.5));
            0.54 * (-0.9 * (t + d)).exp() * phase * 3.0 / (d * d)
        });
        agrees(&format!("{form:?}"), &mean, truth);
    }
}

/// S of flakes with the squares of projected areas 0.09 along z, 0.81 and 0.36 along two axes
/// across, turned by 30°.
pub(crate) fn flakes() -> [f32; 6] {
    let (s, c) = (0.5f32, 0.75f32.sqrt());
    [0.81 * c * c + 0.36 * s * s, 0.81 * s * s + 0.36 * c * c, 0.09, 0.45 * s * c, 0.0, 0.0]
}

/// The same flakes everywhere, by a grid.
pub(crate) fn flake_grid() -> PhaseDesc {
    let values = flakes().repeat(8);
    let grid = GridDesc { channels: 6, ..(*grid([2, 2, 2], values)).clone() };
    PhaseDesc::Sggx(SggxDesc::Grid(Arc::new(grid)))
}

#[test]
fn flakes_let_through_what_shows_of_them() {
    // σₜ √(ωᵀ S ω), along x, z and between.
    for form in FORMS {
        for phase in [PhaseDesc::Sggx(SggxDesc::Constant(flakes())), flake_grid()] {
            for d in [Vec3::X, Vec3::Z, v(0.6, 0.0, 0.8)] {
                let mut stage = Stage::new();
                stage.sky(1.0);
                filled(&mut stage, sphere(1.0), HERE, medium(form, 0.8, 0.7, phase.clone()));
                let area = (d.x * d.x * flakes()[0] + d.z * d.z * flakes()[2]).sqrt();
                let truth = (-0.8 * 2.0 * f64::from(area)).exp();
                let mean = stage.probe(d * -1.5, d, json!({"only_depth": 0}), 20_000);
                agrees(&format!("{form:?} {d:?}"), &mean, truth);
            }
        }
    }
}

#[test]
fn a_grid_of_flakes_scatters_like_the_flakes() {
    let picture = |phase: PhaseDesc, seed| {
        let mut stage = Stage::new();
        stage.point_light(v(1.5, 1.0, -0.5), 3.0);
        filled(&mut stage, sphere(1.0), HERE, medium(Form::Even, 1.5, 0.9, phase));
        stage.camera(pinhole(50.0), look(v(0.0, 0.0, -2.0), Vec3::ZERO), [4, 4]);
        stage.render(json!({}), 500, seed).mean()
    };
    let even = picture(PhaseDesc::Sggx(SggxDesc::Constant(flakes())), 1);
    same("grid of flakes", &picture(flake_grid(), 2), &even);
}

#[test]
fn white_matter_in_a_white_room_is_invisible() {
    let blend = PhaseDesc::Blend {
        weight: 0.3,
        a: Box::new(PhaseDesc::Rayleigh),
        b: Box::new(PhaseDesc::Tabulated { values: vec![3.0, 0.5, 0.2, 1.0, 6.0] }),
    };
    for form in FORMS {
        let flakes = PhaseDesc::Sggx(SggxDesc::Constant(flakes()));
        for phase in [PhaseDesc::Isotropic, hg(0.7), hg(-0.5), blend.clone(), flakes, flake_grid()]
        {
            for mis in ["power", "bsdf"] {
                let mut stage = Stage::new();
                stage.sky(1.0);
                let what = format!("{form:?} {phase:?} {mis}");
                filled(&mut stage, sphere(1.0), HERE, medium(form, 3.0, 1.0, phase.clone()));
                stage.camera(pinhole(50.0), look(v(0.0, 0.0, -2.0), Vec3::ZERO), [3, 3]);
                let p = json!({"mis": mis, "roulette": "none"});
                agrees(&what, &stage.render(p, 300, 1).mean(), 1.0);
            }
        }
    }
}

#[test]
fn a_camera_in_white_matter_sees_white() {
    for form in FORMS {
        let mut stage = Stage::new();
        stage.sky(1.0);
        filled(&mut stage, sphere(1.0), HERE, medium(form, 2.0, 1.0, hg(0.4)));
        stage.camera(CameraKind::Spherical { equal_area: true }, at(0.3, 0.2, -0.4), [3, 3]);
        stage.d.cameras[0].medium = Some(MediumId(0));
        agrees(&format!("{form:?}"), &stage.render(json!({}), 600, 2).mean(), 1.0);
    }
}

#[test]
fn white_matter_in_glass_is_invisible() {
    for form in FORMS {
        let mut stage = Stage::new();
        stage.sky(1.0);
        let glass = stage.glass(1.4, 0.0);
        fill(&mut stage, sphere(1.0), HERE, glass, medium(form, 1.0, 1.0, hg(0.2)));
        stage.camera(pinhole(50.0), look(v(0.0, 0.0, -2.0), Vec3::ZERO), [3, 3]);
        let p = json!({"rr_depth": 200});
        agrees(&format!("{form:?}"), &stage.render(p, 300, 3).mean(), 1.0);
    }
}

#[test]
fn matter_as_warm_as_its_room_is_invisible() {
    // What it absorbs it emits: Lₑ = 1 under a sky of 1, whatever the albedo.
    for form in FORMS {
        for albedo in [0.0, 0.4, 0.9] {
            let mut stage = Stage::new();
            stage.sky(1.0);
            let mut m = medium(form, 1.5, albedo, hg(0.3));
            let source = GlowSource::Radiance(FieldDesc::Constant(grey(0.5)));
            m.glow = Some(GlowDesc { source, scale: 2.0, grid: None });
            filled(&mut stage, sphere(1.0), HERE, m);
            stage.camera(pinhole(50.0), look(v(0.0, 0.0, -2.0), Vec3::ZERO), [3, 3]);
            agrees(&format!("{form:?} {albedo}"), &stage.render(json!({}), 600, 4).mean(), 1.0);
        }
    }
}

#[test]
fn a_glowing_slab() {
    for form in FORMS {
        let mut stage = Stage::new();
        let mut m = medium(form, 0.7, 0.0, PhaseDesc::Isotropic);
        let source = GlowSource::Radiance(FieldDesc::Constant(grey(3.0)));
        m.glow = Some(GlowDesc { source, scale: 1.0, grid: None });
        filled(&mut stage, GeometryDesc::Cube, HERE, m);
        let mean = stage.probe(v(0.1, 0.2, -3.0), Vec3::Z, json!({}), 20_000);
        agrees(&format!("{form:?}"), &mean, 3.0 * (1.0 - (-1.4f64).exp()));
    }
}

/// A lamp and a lamp of no extent over a floor, all in fog, seen from within.
pub(crate) fn foggy_room(m: MediumDesc) -> Stage {
    let mut stage = Stage::new();
    stage.sky(0.3);
    let white = stage.diffuse(0.7);
    stage.shape(GeometryDesc::Rectangle, at(0.0, 0.0, -0.8), white);
    stage.lamp(sphere(0.2), at(0.3, 0.4, 0.2), 8.0);
    stage.point_light(v(-0.5, 0.0, 0.3), 0.5);
    filled(&mut stage, GeometryDesc::Cube, HERE, m);
    stage.camera(pinhole(70.0), look(v(0.0, -0.9, 0.0), v(0.0, 0.0, -0.2)), [3, 3]);
    stage.d.cameras[0].medium = Some(MediumId(0));
    stage
}

/// The three channels of a picture's mean.
fn channels(stage: &Stage, mode: ColorMode, p: Value, spp: u64, seed: u64) -> [RunningMean; 3] {
    let scene = stage.build_in(mode);
    let resolution = stage.resolution();
    let kind = SamplerKind::Independent;
    let config = SamplerConfig { kind, seed, spp, resolution };
    let frame = Frame::new(resolution, FilterDesc::BOX, config);
    let p = params(p);
    let integrator = Integrator::new(&scene, &frame, &p);
    let mut stats = PassStats::default();
    let mut mean = [(); 3].map(|()| RunningMean::new());
    let n = resolution[0] * resolution[1];
    for index in 0..spp {
        let mut sum = [0.0f64; 3];
        for i in 0..n {
            let at = [i % resolution[0], i / resolution[0]];
            let c = integrator.pixel(at, index, &mut stats).rgb;
            (0..3).for_each(|k| sum[k] += c[k] as f64 / n as f64);
        }
        (0..3).for_each(|k| mean[k].push(sum[k]));
    }
    assert_eq!(stats.bad_samples, 0);
    mean
}

#[test]
fn grids_of_one_value_are_homogeneous() {
    let mean = |form: Form, mis: &str| {
        let stage = foggy_room(medium(form, 1.2, 0.8, hg(0.5)));
        channels(&stage, ColorMode::Rgb, json!({"mis": mis}), 2000, 5)[0]
    };
    let even = mean(Form::Even, "power");
    for form in [Form::Grid, Form::Dense] {
        same(&format!("{form:?}"), &mean(form, "power"), &even);
    }
    same("light samples alone", &mean(Form::Dense, "light"), &even);
}

#[test]
fn every_colour_of_a_medium_is_that_of_a_grey_one() {
    let (sigma, albedo) = ([0.2, 1.0, 4.0], [0.9, 0.5, 0.95]);
    for form in FORMS {
        let mut m = medium(form, 1.0, 1.0, hg(0.3));
        let second = FieldDesc::Constant(rgb(albedo));
        let first = match form {
            Form::Grid => {
                let mut colors = (*grid([2, 2, 2], sigma.repeat(8))).clone();
                colors.channels = 3;
                FieldDesc::Grid(Arc::new(colors))
            }
            _ => FieldDesc::Constant(rgb(sigma)),
        };
        m.coefficients = CoefficientsDesc::ExtinctionAlbedo(first, second);
        let together = channels(&foggy_room(m), ColorMode::Rgb, json!({}), 3000, 6);
        for k in 0..3 {
            let grey = foggy_room(medium(Form::Even, sigma[k], albedo[k], hg(0.3)));
            let alone = &channels(&grey, ColorMode::Rgb, json!({}), 3000, 7)[k];
            same(&format!("{form:?} channel {k}"), &together[k], alone);
        }
    }
}

#[test]
fn a_medium_of_one_colour_alone_is_that() {
    // Nothing scatters or absorbs red and green: blue light alone is changed.
    let mut m = medium(Form::Even, 1.0, 1.0, hg(0.3));
    let (first, second) = (rgb([0.0, 0.0, 2.0]), rgb([0.0, 0.0, 0.7]));
    m.coefficients =
        CoefficientsDesc::ExtinctionAlbedo(FieldDesc::Constant(first), FieldDesc::Constant(second));
    let together = channels(&foggy_room(m), ColorMode::Rgb, json!({}), 3000, 8);
    for (k, sigma, albedo) in [(1, 0.0, 0.0), (2, 2.0, 0.7)] {
        let grey = foggy_room(medium(Form::Even, sigma, albedo, hg(0.3)));
        let alone = &channels(&grey, ColorMode::Rgb, json!({}), 3000, 9)[k];
        same(&format!("channel {k}"), &together[k], alone);
    }
}

/// Glass in coloured fog; a dispersive one ends the secondary wavelengths.
fn glass_in_fog(dispersive: bool) -> [RunningMean; 3] {
    let mut m = medium(Form::Even, 1.0, 1.0, hg(0.3));
    let lambda = [360.0, 500.0, 600.0, 830.0];
    let sigma = SpectrumDesc::sampled(&lambda, &[3.0, 2.0, 0.3, 0.1]).expect("a spectrum");
    let albedo = SpectrumDesc::sampled(&lambda, &[0.9, 0.5, 0.9, 0.9]).expect("a spectrum");
    m.coefficients =
        CoefficientsDesc::ExtinctionAlbedo(FieldDesc::Constant(sigma), FieldDesc::Constant(albedo));
    let mut stage = foggy_room(m);
    // An index that differs between the wavelengths by next to nothing.
    let ior = SpectrumDesc::sampled(&[360.0, 830.0], &[1.5, 1.499_999]).expect("a spectrum");
    let ior = stage.d.add_texture(TextureNode::Spectrum(ior), None);
    let ior = if dispersive { IorDesc::Spectrum(ior) } else { IorDesc::Constant(1.5) };
    let (roughness, one) = (stage.rough(0.0), stage.d.float(1.0));
    let glass = stage.material(MaterialModel::Dielectric {
        ior,
        specular_reflectance: one,
        specular_transmittance: one,
        roughness,
    });
    stage.shape(sphere(0.3), at(-0.1, -0.2, -0.3), glass);
    stage.shape(sphere(0.25), at(-0.2, 0.3, 0.4), glass);
    channels(&stage, ColorMode::Spectral, json!({}), 6000, if dispersive { 10 } else { 11 })
}

#[test]
fn ending_the_secondary_wavelengths_changes_no_mean() {
    let (ended, all) = (glass_in_fog(true), glass_in_fog(false));
    for k in 0..3 {
        same(&format!("channel {k}"), &ended[k], &all[k]);
    }
}

#[test]
fn shadow_rays_pass_what_paths_pass() {
    // Panes and cut-outs around a lamp in fog: light sampling and path sampling must agree.
    let build = || {
        let mut stage = foggy_room(medium(Form::Dense, 1.0, 0.8, hg(0.2)));
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
        // Without the lamp of no extent, which paths can't find.
        stage.d.lights.pop();
        stage
    };
    let mean = |mis: &str, seed| {
        channels(&build(), ColorMode::Rgb, json!({"mis": mis, "rr_depth": 20}), 4000, seed)[0]
    };
    let reference = mean("bsdf", 12);
    for (mis, seed) in [("power", 13), ("balance", 14), ("max", 15)] {
        same(mis, &mean(mis, seed), &reference);
    }
}

#[test]
fn bounces_add_up() {
    let stage = foggy_room(medium(Form::Dense, 1.0, 0.8, hg(0.2)));
    let mean = |p: Value, seed| channels(&stage, ColorMode::Rgb, p, 1500, seed)[0];
    let whole = mean(json!({"max_depth": 3, "roulette": "none"}), 16);
    let terms: Vec<_> =
        (0..4).map(|d| mean(json!({"only_depth": d, "roulette": "none"}), 17 + d)).collect();
    let sum = terms.iter().map(RunningMean::mean).sum();
    let error = terms.iter().map(|t| t.standard_error().powi(2)).sum::<f64>().sqrt();
    same("sum of bounces", &with_error(sum, error), &whole);
}

#[test]
fn a_medium_nobody_is_in_changes_nothing() {
    let mut stage = foggy_room(medium(Form::Even, 1.0, 0.8, hg(0.2)));
    stage.d.cameras[0].medium = None;
    stage.d.shapes.retain(|s| s.interior.is_none());
    assert!(!stage.build().has_media());
    let mut clear = foggy_room(medium(Form::Even, 0.0, 0.0, hg(0.0)));
    clear.d.lights.pop();
    stage.d.lights.pop();
    let a = channels(&stage, ColorMode::Rgb, json!({}), 2000, 30);
    let b = channels(&clear, ColorMode::Rgb, json!({}), 2000, 31);
    same("clear", &a[0], &b[0]);
    close("noise", a[0].standard_error(), b[0].standard_error(), 0.3);
}

#[test]
fn methods_that_know_no_media_say_so() {
    let scene = foggy_room(medium(Form::Even, 1.0, 0.8, hg(0.2))).build();
    let config =
        SamplerConfig { kind: SamplerKind::Independent, seed: 1, spp: 1, resolution: [1, 1] };
    let frame = Frame::new([1, 1], FilterDesc::BOX, config);
    let workers = Workers::new(1, Arc::default()).expect("a thread");
    for entry in registry::ALL {
        let method = (entry.make)(&serde_json::Map::new()).expect("defaults");
        let prepared = Session::new(&scene, &frame, method).prepare(&workers);
        assert_eq!(prepared.is_ok(), entry.info.media, "{}", entry.info.name);
        if let Err(e) = prepared {
            assert!(e.to_string().contains("media"), "{e}");
        }
    }
}
