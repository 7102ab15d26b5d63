//! The contract, and figures by hand.

use super::super::testing::{Expect, check_model};
use super::*;
use std::f32::consts::PI;

fn colored() -> PrincipledParameters {
    let base_color = Spectrum([0.2, 0.8, 0.1, 0.0]);
    let base_luminance = 0.2126 * 0.2 + 0.7152 * 0.8 + 0.0722 * 0.1;
    PrincipledParameters { base_color, base_luminance, ..Default::default() }
}

#[test]
fn opaque_models_hold_the_contract() {
    let cases = [
        PrincipledParameters::default(),
        PrincipledParameters { base_color: Spectrum::ONE, base_luminance: 1.0, ..colored() },
        PrincipledParameters {
            roughness: 0.15,
            anisotropic: 0.8,
            metallic: 0.1,
            clearcoat: 0.9,
            sheen: 0.9,
            eta: eta_from_specular(0.7),
            ..colored()
        },
        PrincipledParameters {
            roughness: 0.4,
            metallic: 0.6,
            spec_tint: 0.5,
            sheen: 0.5,
            sheen_tint: 0.7,
            flatness: 0.6,
            clearcoat: 0.5,
            clearcoat_gloss: 0.7,
            ..colored()
        },
        PrincipledParameters { metallic: 1.0, roughness: 0.3, anisotropic: 0.4, ..colored() },
    ];
    for p in cases {
        let expect =
            Expect { albedo_max: 1.25, albedo_error: 0.1, samples: 20_000, ..Expect::default() };
        check_model(&format!("{p:?}"), &Principled::new(p), expect);
    }
}

#[test]
fn transparent_models_hold_the_contract() {
    let cases = [
        PrincipledParameters { spec_trans: 1.0, roughness: 0.3, ..colored() },
        PrincipledParameters {
            spec_trans: 0.6,
            metallic: 0.3,
            roughness: 0.5,
            anisotropic: 0.5,
            clearcoat: 1.0,
            spec_tint: 0.4,
            sheen: 0.3,
            eta: 1.33,
            ..colored()
        },
        PrincipledParameters { spec_trans: 0.9, eta: 0.7, spec_tint: 0.5, ..colored() },
    ];
    for p in cases {
        let expect = Expect {
            both_sides: true,
            albedo_max: 1.25,
            albedo_error: 0.3,
            samples: 20_000,
            ..Expect::default()
        };
        check_model(&format!("{p:?}"), &Principled::new(p), expect);
    }
}

/// At normal incidence by hand: diffuse base/π, D = 1/(π α²), F = 0.04 (η = 1.5), the clear
/// coat with α = 0.1: D = 0.99/(π ln 100 · 0.01).
#[test]
fn has_its_known_values() {
    let at = |p| Principled::new(p).eval(Vec3::Z, Vec3::Z, Mode::Radiance, Lobes::ALL)[0];
    let near = |a: f32, b: f32| assert!((a - b).abs() < 1e-5 * b, "{a} {b}");
    let p = PrincipledParameters { eta: 1.5, ..Default::default() };
    let shape = 0.25 / (PI * 0.0625);
    near(at(p), 0.5 * INV_PI + 0.04 * shape);
    near(at(PrincipledParameters { metallic: 1.0, ..p }), 0.5 * shape);
    let coat = 0.25 * 0.04 * 0.99 / (PI * 100f32.ln() * 0.01);
    near(at(PrincipledParameters { clearcoat: 1.0, ..p }), 0.5 * INV_PI + 0.04 * shape + coat);
    // Flattened: 1.25 (½ - ½ + ½).
    let flat = at(PrincipledParameters { flatness: 1.0, ..p });
    near(flat, 0.625 * 0.5 * INV_PI + 0.04 * shape);
    near(eta_from_specular(0.5), 1.5);
}

/// Through a nearly smooth, clear interface all light passes or is reflected.
#[test]
fn clear_glass_loses_nothing() {
    let p = PrincipledParameters {
        base_color: Spectrum::ONE,
        base_luminance: 1.0,
        roughness: 0.15,
        spec_trans: 1.0,
        ..Default::default()
    };
    let expect = Expect {
        both_sides: true,
        albedo: Some((1.0, 0.1)),
        albedo_error: 0.1,
        samples: 20_000,
        ..Expect::default()
    };
    check_model("principled glass", &Principled::new(p), expect);
}
