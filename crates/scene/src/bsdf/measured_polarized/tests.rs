//! A metal that is known in closed form, measured: its table at the nodes and between them.

use super::*;
use crate::bsdf::testing::{Expect, check_model};
use crate::bsdf::{Conductor, ConductorFresnel, Microfacet, Model};
use crate::description::{Distribution, MeasuredMueller, MeasuredPolarizedDesc};
use kaustika_math::Frame;
use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

/// Wavelengths at which the metal's index is that of a lane.
const NM: [f32; 4] = [450.0, 500.0, 580.0, 650.0];

fn metal() -> Conductor {
    let eta = Spectrum([1.44, 1.2, 0.375, 0.143]);
    Conductor {
        fresnel: ConductorFresnel::EtaK { eta, k: Spectrum([1.60, 1.9, 2.39, 3.98]) },
        tint: Spectrum([1.0, 0.5, 0.2, 0.8]),
        surface: Microfacet::new(Distribution::Ggx, 0.5, 0.5),
    }
}

/// The directions (ωₒ, ωᵢ) of (1): the half vector's azimuth is free.
fn directions(phi_d: f32, theta_d: f32, theta_h: f32, phi_h: f32) -> (Vec3, Vec3) {
    let spherical = |theta: f32, phi: f32| {
        let (s, c) = theta.sin_cos();
        Vec3::new(s * phi.cos(), s * phi.sin(), c)
    };
    let h = spherical(theta_h, phi_h);
    // t is where θ grows and b where φ does.
    let t = spherical(theta_h + FRAC_PI_2, phi_h);
    let b = Vec3::new(-phi_h.sin(), phi_h.cos(), 0.0);
    let about_h = Frame { s: t, t: b, n: h };
    let wi = about_h.to_world(spherical(theta_d, phi_d));
    (reflect(wi, h), wi)
}

fn spectral() -> Wavelengths {
    Wavelengths { lambda: NM, ..Wavelengths::sample(0.5) }
}

fn measured() -> MuellerData {
    let even = |n: usize, from: f32, to: f32| -> Vec<f32> {
        (0..n).map(|i| from + (to - from) * i as f32 / (n - 1) as f32).collect()
    };
    let (phi_d, theta_d) = (even(13, -PI, PI), even(10, 0.0, 1.4));
    let theta_h = even(12, 0.0, 1.5);
    let mut values = Vec::new();
    for &p in &phi_d {
        for &d in &theta_d {
            for &h in &theta_h {
                let (wo, wi) = directions(p, d, h, 0.0);
                let f = metal().eval(wo, wi, Mode::Radiance, Lobes::ALL) / wi.z;
                let m = metal().polarization(wo, wi).mueller;
                for lane in 0..4 {
                    let there = wo.z > 0.0 && wi.z > 0.0;
                    let element = |k: usize| f[lane] * m.0[k / 4][k % 4][lane];
                    values.extend((0..16).map(|k| if there { element(k) } else { f32::NAN }));
                }
            }
        }
    }
    let table = MeasuredMueller { phi_d, theta_d, theta_h, wavelengths: NM.to_vec(), values };
    let desc = MeasuredPolarizedDesc { table: Arc::new(table), alpha: 0.5, wavelength: None };
    MuellerData::new(&desc)
}

fn near(a: Spectrum, b: Spectrum, error: f32, what: &str) {
    let size = a.max_component().abs().max(b.max_component().abs()).max(0.1);
    (0..4).for_each(|l| assert!((a[l] - b[l]).abs() <= error * size, "{what}: {a:?} {b:?}"));
}

/// At its nodes the table is the metal, wherever the pair of directions is turned about the normal.
#[test]
fn nodes_are_the_metal() {
    let data = measured();
    let model = MeasuredPolarized { data: &data, lambda: spectral() };
    let mut checked = 0;
    for (p, d, h) in [(3, 2, 1), (1, 3, 3), (8, 3, 2), (10, 1, 3), (6, 3, 2), (5, 2, 3)] {
        let t = &data.table;
        let (phi_d, theta_d, theta_h) = (t.phi_d[p], t.theta_d[d], t.theta_h[h]);
        for phi_h in [0.0, 1.0, -2.5] {
            let (wo, wi) = directions(phi_d, theta_d, theta_h, phi_h);
            if wo.z < 0.05 || wi.z < 0.05 {
                continue;
            }
            checked += 1;
            let expected = metal().eval(wo, wi, Mode::Radiance, Lobes::ALL);
            near(model.eval(wo, wi, Mode::Radiance, Lobes::ALL), expected, 1e-3, "value");
            let (a, b) = (model.polarization(wo, wi), metal().polarization(wo, wi));
            assert!((a.x - b.x).length() < 1e-4);
            for k in 0..16 {
                let of = |m: &Oriented| m.mueller.0[k / 4][k % 4];
                near(of(&a), of(&b), 2e-3, &format!("element {k} at {phi_d} {theta_d} {theta_h}"));
            }
        }
    }
    assert!(checked >= 12, "{checked}");
}

/// Between nodes it is linear, and near the metal; between wavelengths too.
#[test]
fn between_nodes_it_is_near() {
    let data = measured();
    let (wo, wi) = directions(1.1, 0.5, 0.2, 0.7);
    let model = MeasuredPolarized { data: &data, lambda: spectral() };
    let expected = metal().eval(wo, wi, Mode::Radiance, Lobes::ALL);
    near(model.eval(wo, wi, Mode::Radiance, Lobes::ALL), expected, 0.03, "between");
    let lambda = Wavelengths { lambda: [475.0, 400.0, 700.0, 450.0], ..spectral() };
    let value = model.eval(wo, wi, Mode::Radiance, Lobes::ALL);
    let between =
        MeasuredPolarized { data: &data, lambda }.eval(wo, wi, Mode::Radiance, Lobes::ALL);
    let by_hand = Spectrum([0.5 * (value[0] + value[1]), value[0], value[3], value[0]]);
    near(between, by_hand, 1e-5, "wavelengths");
}

/// What was not measured is black and no NaN.
#[test]
fn unknown_is_black() {
    let data = measured();
    let model = MeasuredPolarized { data: &data, lambda: spectral() };
    let (wo, wi) =
        (Vec3::new(0.999, 0.0, 0.03).normalize(), Vec3::new(0.99, 0.1, 0.02).normalize());
    let value = model.eval(wo, wi, Mode::Radiance, Lobes::ALL);
    let m = Model::MeasuredPolarized(model).polarization(wo, wi).expect("it polarizes");
    assert!(value.is_finite() && m.mueller.is_finite(), "{value:?} {m:?}");
}

#[test]
fn keeps_the_contract() {
    let data = measured();
    let expect = Expect { reciprocal: false, albedo_error: 0.05, ..Expect::default() };
    for lambda in [spectral(), Wavelengths::rgb()] {
        check_model("measured_polarized", &MeasuredPolarized { data: &data, lambda }, expect);
    }
}

/// One wavelength for all: grey in RGB.
#[test]
fn a_single_wavelength_is_grey() {
    let data = measured();
    let desc =
        MeasuredPolarizedDesc { table: data.table.clone(), alpha: 0.5, wavelength: Some(500.0) };
    let one = MuellerData::new(&desc);
    let (wo, wi) = directions(1.1, 0.5, 0.2, 0.7);
    let of =
        |data, lambda| MeasuredPolarized { data, lambda }.eval(wo, wi, Mode::Radiance, Lobes::ALL);
    let all = of(&data, spectral());
    assert_eq!(of(&one, Wavelengths::rgb()).rgb(), [all[1]; 3]);
    assert_eq!(of(&one, spectral()), Spectrum::splat(all[1]));
}
