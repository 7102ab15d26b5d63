//! The contract for every layer, and values against the formulas of the specification.

use super::super::testing::{Expect, Random, check_model};
use super::*;
use kaustika_spectra::Wavelengths;

type P = MetallicRoughnessParameters;

const COLOR: Spectrum = Spectrum([0.8, 0.5, 0.2, 0.0]);

fn opaque() -> P {
    P { base_color: COLOR, alpha: (0.25, 0.25), ..P::default() }
}

fn check(name: &str, p: P, expect: Expect) {
    check_model(name, &MetallicRoughness::new(p), Expect { samples: 20_000, ..expect });
}

/// Albedos by tables are right within some hundredths.
fn expect() -> Expect {
    Expect { albedo_error: 0.1, albedo_max: 1.03, ..Expect::default() }
}

#[test]
fn opaque_surfaces_hold_the_contract() {
    check("matte", P { alpha: (1.0, 1.0), ..opaque() }, expect());
    check("plastic", opaque(), expect());
    check("half metal", P { metallic: 0.5, ..opaque() }, expect());
    check("brushed", P { metallic: 1.0, alpha: (0.5, 0.1), ..opaque() }, expect());
    let tinted = P { specular: 0.6, specular_color: Spectrum([2.0, 1.0, 0.5, 0.0]), ..opaque() };
    check("tinted", tinted, expect());
    check("no index", P { ior: 0.0, specular_color: COLOR, ..opaque() }, expect());
    check(
        "film",
        P { film: Some(Film::new(1.0, 1.3, 400.0, &Wavelengths::rgb())), ..opaque() },
        expect(),
    );
}

#[test]
fn layers_hold_the_contract() {
    let velvet = P { sheen: Some((Spectrum([0.9, 0.3, 0.6, 0.0]), 0.5)), ..opaque() };
    check("sheen", velvet, expect());
    check("sharp sheen", P { sheen: Some((Spectrum::ONE, 0.2)), ..opaque() }, expect());
    let coat = |roughness, normal: Vec3| Some(Clearcoat::new(1.0, roughness, normal.normalize()));
    let car = P { metallic: 1.0, clearcoat: coat(0.4, Vec3::Z), ..opaque() };
    check("coat", car, expect());
    // albedo() leaves out the coat's shadow on light that goes elsewhere.
    let expect = || Expect { albedo_error: 0.15, ..expect() };
    check("coated sheen", P { clearcoat: coat(0.5, Vec3::Z), ..velvet }, expect());
    // About another normal a coat is not reciprocal within a mode, as no normal map is.
    let tilted = P { clearcoat: coat(0.5, Vec3::new(0.2, 0.1, 1.0)), ..opaque() };
    let expect = Expect { reciprocal: false, albedo_max: 1.3, albedo_error: 0.3, ..expect() };
    check("tilted coat", tilted, expect);
}

#[test]
fn sheets_hold_the_contract() {
    let both = Expect { both_sides: true, ..expect() };
    let pane = P { transmission: 1.0, boundary: Boundary::Sheet, ..opaque() };
    check("pane", pane, both);
    check("half pane", P { transmission: 0.5, metallic: 0.3, ..pane }, both);
    let leaf = P {
        diffuse_transmission: (0.6, Spectrum([0.2, 0.9, 0.1, 0.0])),
        boundary: Boundary::Sheet,
        ..opaque()
    };
    check("leaf", leaf, both);
    let all = P {
        transmission: 0.4,
        clearcoat: Some(Clearcoat::new(0.7, 0.3, Vec3::Z)),
        sheen: Some((COLOR, 0.4)),
        ..leaf
    };
    check("all in a sheet", all, both);
}

#[test]
fn solids_hold_the_contract() {
    let both = Expect { both_sides: true, albedo_error: 0.4, ..expect() };
    let solid = P { transmission: 1.0, boundary: Boundary::Solid, ..opaque() };
    check("glass", solid, both);
    check("diamond", P { ior: 2.4, alpha: (0.1, 0.1), ..solid }, both);
    check("half glass", P { transmission: 0.5, ..solid }, both);
    let wax = P { diffuse_transmission: (0.7, COLOR), transmission: 0.3, ..solid };
    check("wax", wax, both);
    check("coated", P { clearcoat: Some(Clearcoat::new(1.0, 0.2, Vec3::Z)), ..solid }, both);
}

fn albedo_of(p: P, wo: Vec3) -> f64 {
    let model = MetallicRoughness::new(p);
    let mut random = Random::new(17);
    let n = 200_000;
    let draw =
        |r: &mut Random| model.sample(wo, r.next_1d(), r.next_2d(), Mode::Importance, Lobes::ALL);
    let sum: f64 = (0..n).filter_map(|_| draw(&mut random)).map(|s| s.weight[0] as f64).sum();
    sum / n as f64
}

fn at(cos: f32) -> Vec3 {
    Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)
}

/// White matter of little roughness returns all light that comes, whatever the angle, and never
/// more; the standard error of the estimates is below 0.002.
#[test]
fn white_furnaces_are_white() {
    let smooth = P { alpha: (0.01, 0.01), ..P::default() };
    let cases = [
        ("plastic", smooth, 0.995),
        ("metal", P { metallic: 1.0, ..smooth }, 0.995),
        ("pane", P { transmission: 1.0, boundary: Boundary::Sheet, ..smooth }, 0.995),
        ("glass", P { transmission: 1.0, boundary: Boundary::Solid, ..smooth }, 0.99),
        // The coat's shadow on what is not a mirror is a little too dark.
        ("coat", P { clearcoat: Some(Clearcoat::new(1.0, 0.1, Vec3::Z)), ..smooth }, 0.8),
    ];
    for (name, p, least) in cases {
        for cos in [1.0, 0.7, 0.3, 0.1] {
            let albedo = albedo_of(p, at(cos));
            assert!(albedo > least - 0.01 && albedo < 1.015, "{name} {cos}: {albedo}");
        }
    }
}

/// At normal incidence the matte part is the specification's (1 - F) base/π: (1-0.04)·0.5, and
/// the mirror part 0.04.
#[test]
fn plastic_is_the_specifications_in_front() {
    let p = P { base_color: Spectrum::splat(0.5), alpha: (0.02, 0.02), ..P::default() };
    assert!((albedo_of(p, at(1.0)) - 0.52).abs() < 0.005);
    let model = MetallicRoughness::new(P { metallic: 1.0, alpha: (0.3, 0.3), ..p });
    // Metal face on, by hand: F₀ D/4, D = 1/(π α²).
    let value = model.eval(Vec3::Z, Vec3::Z, Mode::Radiance, Lobes::ALL);
    let exact = 0.5 / (4.0 * std::f32::consts::PI * 0.09);
    assert!((value[0] - exact).abs() < 1e-4 * exact, "{} {exact}", value[0]);
}

/// A solid's rough glass is [`Dielectric`](super::super::Dielectric) but for Schlick's F.
#[test]
fn glass_is_a_dielectric() {
    let surface = Microfacet::new(Distribution::Ggx, 0.3, 0.3);
    let (reflectance, transmittance) = (Spectrum::ONE, Spectrum::ONE);
    let glass = super::super::Dielectric { eta: 1.5, reflectance, transmittance, surface };
    let p = P { alpha: (0.3, 0.3), transmission: 1.0, boundary: Boundary::Solid, ..P::default() };
    let model = MetallicRoughness::new(p);
    let mut random = Random::new(3);
    let mut met = 0;
    for _ in 0..2000 {
        let wo = warp::uniform_sphere(random.next_2d());
        let wi = warp::uniform_sphere(random.next_2d());
        let value = |m: &dyn Fn(Vec3, Vec3) -> f32| m(wo, wi);
        let a = value(&|o, i| glass.eval(o, i, Mode::Radiance, Lobes::ALL)[0]);
        let b = value(&|o, i| model.eval(o, i, Mode::Radiance, Lobes::ALL)[0]);
        // Schlick is within 0.03 of Fresnel's reflectance, which matters where it is small.
        let reflects = wo.z * wi.z > 0.0;
        let allowed = if reflects { 1.2 * a + 0.05 } else { 0.12 * a + 2e-3 };
        assert!((a - b).abs() <= allowed, "{wo:?} {wi:?}: {a} {b}");
        met += usize::from(a > 0.0);
    }
    assert!(met > 500);
}
