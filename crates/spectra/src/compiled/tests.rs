use super::*;
use crate::testing::Pcg;
use crate::{Sensor, conductor, named};

const ROLES: [SpectrumRole; 3] =
    [SpectrumRole::Albedo, SpectrumRole::Unbounded, SpectrumRole::Illuminant];

fn rgb_lanes(desc: &SpectrumDesc, role: SpectrumRole) -> [f32; 3] {
    CompiledSpectrum::new(desc, role, ColorMode::Rgb).eval(&Wavelengths::rgb()).rgb()
}

fn close(a: [f32; 3], b: [f32; 3], tolerance: f32) {
    assert!((0..3).all(|k| (a[k] - b[k]).abs() < tolerance), "{a:?} {b:?}");
}

#[test]
fn constants_are_the_same_in_every_role() {
    for role in ROLES {
        assert_eq!(rgb_lanes(&SpectrumDesc::Constant(0.7), role), [0.7; 3]);
        let s = CompiledSpectrum::new(&SpectrumDesc::Constant(0.7), role, ColorMode::Spectral);
        assert_eq!(s.eval(&Wavelengths::sample(0.1)), Spectrum::splat(0.7));
        assert!(s.is_constant() && s.max() == 0.7 && s.luminance() == 0.7);
    }
}

#[test]
fn whites_of_rgb_mode() {
    let flat = SpectrumDesc::sampled(&[300.0, 900.0], &[1.0, 1.0]).expect("valid");
    close(rgb_lanes(&flat, SpectrumRole::Albedo), [1.0; 3], 1e-5);
    close(rgb_lanes(&flat, SpectrumRole::Unbounded), [1.0; 3], 1e-5);
    // The equal-energy white in linear sRGB.
    let pink = [1.2048, 0.9483, 0.9089];
    close(rgb_lanes(&flat, SpectrumRole::Illuminant), pink, 1e-3);
    close(
        rgb_lanes(&SpectrumDesc::EqualEnergy(2.0), SpectrumRole::Illuminant),
        pink.map(|v| 2.0 * v),
        2e-3,
    );
    assert_eq!(rgb_lanes(&SpectrumDesc::EqualEnergy(2.0), SpectrumRole::Unbounded), [2.0; 3]);
    close(rgb_lanes(&SpectrumDesc::D65 { scale: 3.0 }, SpectrumRole::Illuminant), [3.0; 3], 1e-6);
    close(
        rgb_lanes(&named("stdillum-D65").expect("known"), SpectrumRole::Illuminant),
        [1.0; 3],
        1e-5,
    );
    // Illuminant A is orange: x = 0.4476, y = 0.4075 has r : g : b = 1.7 : 0.86 : 0.28 or so.
    let [r, g, b] = rgb_lanes(&named("stdillum-A").expect("known"), SpectrumRole::Illuminant);
    assert!(r > 1.6 && (0.8..0.95).contains(&g) && (0.2..0.35).contains(&b), "{r} {g} {b}");
}

#[test]
fn clamping_by_role() {
    let laser = SpectrumDesc::sampled(&[531.0, 532.0, 533.0], &[0.0, 100.0, 0.0]).expect("valid");
    let [r, g, b] = rgb_lanes(&laser, SpectrumRole::Illuminant);
    assert!(r == 0.0 && g > 1.0 && b == 0.0, "{r} {g} {b}");
    assert_eq!(rgb_lanes(&laser, SpectrumRole::Albedo), [0.0, 1.0, 0.0]);
    let bright = SpectrumDesc::Rgb { rgb: [2.0, -1.0, 0.5], space: ColorSpace::Srgb };
    assert_eq!(rgb_lanes(&bright, SpectrumRole::Albedo), [1.0, 0.0, 0.5]);
    assert_eq!(rgb_lanes(&bright, SpectrumRole::Unbounded), [2.0, 0.0, 0.5]);
}

#[test]
fn gold_is_yellow() {
    let (eta, k) = conductor("Au").expect("known");
    let n = rgb_lanes(&eta, SpectrumRole::Unbounded);
    let k = rgb_lanes(&k, SpectrumRole::Unbounded);
    // What Mitsuba's RGB variants use for gold.
    close(n, [0.143_119, 0.374_957, 1.442_479], 5e-3);
    close(k, [3.983_160, 2.385_721, 1.603_215], 1e-2);
    let f: [f32; 3] = std::array::from_fn(|i| {
        ((n[i] - 1.0).powi(2) + k[i] * k[i]) / ((n[i] + 1.0).powi(2) + k[i] * k[i])
    });
    assert!(f[0] > 0.93 && f[1] > 0.7 && f[2] < 0.45, "{f:?}");
    // By its other name the same table is seen under D65.
    let lit = rgb_lanes(&named("metal-Au-eta").expect("known"), SpectrumRole::Unbounded);
    assert!(lit[0] < n[0] && lit[2] > n[2], "{lit:?}");
}

#[test]
fn spectral_and_rgb_mode_see_the_same_colours() {
    let mut rng = Pcg(5);
    let sensor = Sensor::default();
    for _ in 0..10 {
        let rgb = rng.rgb();
        let desc = SpectrumDesc::Rgb { rgb, space: ColorSpace::Srgb };
        for role in ROLES {
            let s = CompiledSpectrum::new(&desc, role, ColorMode::Spectral);
            let n = 4096;
            let mut sum = [0.0; 3];
            for i in 0..n {
                let w = Wavelengths::sample((i as f32 + 0.5) / n as f32);
                let light = match role {
                    SpectrumRole::Illuminant => Spectrum::ONE,
                    _ => ColorSpace::Srgb.illuminant().eval(&w),
                };
                let seen = sensor.rgb(s.eval(&w) * light, &w);
                for k in 0..3 {
                    sum[k] += seen[k] / n as f32;
                }
            }
            close(sum, rgb, 4e-3);
            let y = CompiledSpectrum::new(&desc, role, ColorMode::Rgb).luminance();
            assert!((s.luminance() - y).abs() < 1e-3, "{} {y}", s.luminance());
        }
    }
}

#[test]
fn greys_stay_flat_and_white_stays_one() {
    for v in [0.0, 0.3, 1.0] {
        let desc = SpectrumDesc::Rgb { rgb: [v; 3], space: ColorSpace::Rec2020 };
        let s = CompiledSpectrum::new(&desc, SpectrumRole::Albedo, ColorMode::Spectral);
        assert_eq!(s.eval(&Wavelengths::sample(0.7)), Spectrum::splat(v));
        assert_eq!(s.is_black(), v == 0.0);
    }
}

#[test]
fn scaling_scales_everything() {
    let rgb = SpectrumDesc::Rgb { rgb: [0.9, 0.4, 0.1], space: ColorSpace::Srgb };
    for mode in [ColorMode::Rgb, ColorMode::Spectral] {
        for role in ROLES {
            let s = CompiledSpectrum::new(&rgb, role, mode);
            let t = s.scaled(3.0);
            let w = Wavelengths::sample_for(mode, 0.37);
            let difference = (s.eval(&w) * 3.0 - t.eval(&w)).map(f32::abs).max_component();
            assert!(difference < 1e-3, "{mode:?} {role:?} {difference}");
            assert!((t.luminance() - 3.0 * s.luminance()).abs() < 1e-5);
            assert!((t.max() - 3.0 * s.max()).abs() < 1e-3);
        }
    }
}

#[test]
fn max_bounds_every_lane() {
    let mut rng = Pcg(9);
    for name in ["metal-Cu-k", "stdillum-F11", "glass-BK7"] {
        let s = CompiledSpectrum::new(
            &named(name).expect("known"),
            SpectrumRole::Unbounded,
            ColorMode::Spectral,
        );
        for _ in 0..1000 {
            let v = s.eval(&Wavelengths::sample(rng.uniform()));
            assert!(v.max_component() <= s.max() * 1.000_001, "{name}");
        }
        assert!(!s.is_constant());
    }
}

#[test]
fn extreme_colours_compile_to_finite_values() {
    let w = Wavelengths::sample(0.9);
    for rgb in [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 1.0],
        [1e-20, 0.0, 0.0],
        [1e10, 0.0, 5.0],
        [-1.0; 3],
        [-1.0, 0.0, -2.0],
    ] {
        for space in ColorSpace::ALL {
            for role in ROLES {
                let desc = SpectrumDesc::Rgb { rgb, space };
                let s = CompiledSpectrum::new(&desc, role, ColorMode::Spectral);
                let v = s.eval(&w);
                assert!(v.is_finite() && v.0.iter().all(|&x| x >= 0.0), "{rgb:?} {role:?} {v:?}");
            }
        }
    }
}
