use super::super::testing::{Expect, Random, check_model};
use super::super::{ConductorFresnel, Masking, PlasticCoat};
use super::*;
use crate::description::{Distribution, WardVariant};
use kaustika_math::warp;

const PPLASTIC: [[f32; 3]; 4] = [
    [0.0437985, 0.144669, 0.245539],
    [0.0457496, 0.0803104, 0.114871],
    [0.0199599, 0.0856654, 0.151371],
    [0.0261195, 0.078232, 0.130344],
];
const CLEAR: Spectrum = Spectrum::ZERO;
const AMBER: Spectrum = Spectrum([0.1, 0.3, 0.9, 0.0]);
const MATTE: Diffuse = Diffuse { reflectance: Spectrum([0.8, 0.5, 0.2, 0.0]) };

fn smooth(eta: f32, depth: Spectrum) -> CoatingLayer<'static> {
    let surface = Microfacet::smooth();
    CoatingLayer { eta, surface, through: None, reflectance: Spectrum::ONE, depth }
}

fn metal(alpha_u: f32, alpha_v: f32) -> Model<'static> {
    Model::Conductor(Conductor {
        fresnel: ConductorFresnel::EtaK {
            eta: Spectrum([0.2, 0.9, 1.4, 2.0]),
            k: Spectrum([3.9, 2.4, 1.6, 0.6]),
        },
        tint: Spectrum::ONE,
        surface: match alpha_u {
            0.0 => Microfacet::smooth(),
            _ => Microfacet::new(Distribution::Ggx, alpha_u, alpha_v),
        },
    })
}

fn coated<'a>(layer: CoatingLayer<'a>, base: Model<'a>) -> Coating<'a> {
    Coating::new(layer, base).expect("these can be coated")
}

#[test]
fn coats_hold_the_contract() {
    let expect = Expect { albedo_error: 1.0, samples: 15_000, ..Expect::default() };
    let ward = Ward::new(WardVariant::Balanced, MATTE.reflectance, Spectrum::splat(0.2), 0.2, 0.1);
    let phong =
        Phong { diffuse: MATTE.reflectance, specular: Spectrum::splat(0.2), exponent: 20.0 };
    let bases = [
        Model::Diffuse(MATTE),
        metal(0.3, 0.1),
        metal(0.0, 0.0),
        Model::Ward(ward),
        Model::Phong(phong),
        Model::Plastic(Plastic::new(
            PlasticCoat::new(1.3),
            MATTE.reflectance,
            Spectrum::ONE,
            false,
        )),
    ];
    let tables = RoughTransmittance::new(Distribution::Beckmann, 0.2, 1.5);
    let surface = Microfacet::new(Distribution::Beckmann, 0.2, 0.2);
    let through = Some((&tables, tables.index(0.2)));
    for (k, base) in bases.into_iter().enumerate() {
        let model = coated(smooth(1.5, if k % 2 == 0 { AMBER } else { CLEAR }), base);
        check_model(&format!("smooth coat over base {k}"), &model, expect);
        let layer = CoatingLayer { surface, through, ..smooth(1.5, AMBER) };
        check_model(&format!("rough coat over base {k}"), &coated(layer, base), expect);
    }
    // A coat of the thinner matter: some of the base's light can't leave.
    let model = coated(smooth(0.8, CLEAR), metal(0.3, 0.1));
    check_model("thin coat", &model, expect);
}

/// Over a matte base the coat is plastic without the light between base and coat: plastic whose
/// base is darker by what that adds.
#[test]
fn coated_matte_is_plastic_without_its_series() {
    let internal = super::super::fresnel::fresnel_diffuse_reflectance(1.0 / 1.5);
    let darker = MATTE.reflectance.map(|r| r / (1.0 + r * internal));
    let plastic = Plastic::new(PlasticCoat::new(1.5), darker, Spectrum::ONE, true);
    let model = coated(smooth(1.5, CLEAR), Model::Diffuse(MATTE));
    let mut random = Random::new(5);
    for _ in 0..200 {
        let wo = warp::uniform_hemisphere(random.next_2d());
        let wi = warp::uniform_hemisphere(random.next_2d());
        let a = model.eval(wo, wi, Mode::Radiance, Lobes::ALL);
        let b = plastic.eval(wo, wi, Mode::Radiance, Lobes::ALL);
        (0..3).for_each(|i| assert!((a[i] - b[i]).abs() <= 1e-4 * b[i], "{a:?} {b:?}"));
    }
}

/// Lambert and Beer: a mirror under a coat at 60° loses 2σd/cos θ', besides Fresnel's parts.
#[test]
fn absorption_follows_the_way() {
    let model = coated(
        smooth(1.5, AMBER),
        Model::Conductor(Conductor {
            fresnel: ConductorFresnel::Mirror,
            tint: Spectrum::ONE,
            surface: Microfacet::smooth(),
        }),
    );
    let wo = Vec3::new(0.75f32.sqrt(), 0.0, 0.5);
    let s = model.sample(wo, 0.99, Vec2::new(0.5, 0.5), Mode::Radiance, Lobes::ALL);
    let s = s.expect("a mirror");
    let f = fresnel_dielectric(0.5, 1.5).reflectance;
    let cos = (1.0f32 - 0.75 / 2.25).sqrt();
    for i in 0..3 {
        let exact = f + sqr(1.0 - f) * (-2.0 * AMBER[i] / cos).exp();
        assert!((s.weight[i] * s.pdf - exact).abs() < 1e-5, "{s:?}, exactly {exact}");
    }
    assert_eq!((s.pdf, s.lobe), (1.0, Lobes::DELTA_REFLECTION));
}

/// `pplastic` of Mitsuba 3.9.1 (scalar_rgb, GGX, alpha 0.3, index 1.5 in air of 1, diffuse 0.1,
/// 0.5, 0.9): a rough coat that lets light through as a smooth one, without 1/η².
#[test]
fn mitsuba_pplastic_agrees() {
    let pairs = [
        ([0.3, 0.2, 0.8], [-0.4, 0.1, 0.7]),
        ([0.9, 0.1, 0.3], [-0.8, 0.2, 0.35]),
        ([0.0, 0.0, 1.0], [0.5, 0.5, 0.5]),
        ([0.2, -0.9, 0.1], [0.1, 0.3, 0.9]),
    ];
    let surface = Microfacet::new(Distribution::Ggx, 0.3, 0.3).with_masking(Masking::Separable);
    let layer = CoatingLayer { surface, ..smooth(1.5, CLEAR) };
    let base = Diffuse { reflectance: Spectrum([0.1, 0.5, 0.9, 0.0]) * sqr(1.5) };
    let model = coated(layer, Model::Diffuse(base));
    for ((wo, wi), figure) in pairs.into_iter().zip(PPLASTIC) {
        let (wo, wi) = (Vec3::from(wo).normalize(), Vec3::from(wi).normalize());
        let value = model.eval(wo, wi, Mode::Radiance, Lobes::ALL);
        for i in 0..3 {
            assert!((value[i] / figure[i] - 1.0).abs() < 5e-4, "{value:?}, Mitsuba {figure:?}");
        }
    }
}
