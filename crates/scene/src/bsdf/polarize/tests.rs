//! Matrices of models and of nests of models against their scalar values.

use super::*;
use crate::bsdf::{
    Bsdf, Coating, CoatingLayer, Diffuse, FilterElement, Lobes, Microfacet, Mode, Part,
    PolarizingFilter, Scatter,
};
use crate::description::Distribution;
use crate::polarization::{Stokes, Turn};
use kaustika_math::{Frame, Vec2};

fn rough() -> Microfacet {
    Microfacet::new(Distribution::Ggx, 0.3, 0.2)
}

fn metal(surface: Microfacet) -> Model<'static> {
    let eta = Spectrum([0.143, 0.375, 1.44, 2.0]);
    let fresnel = ConductorFresnel::EtaK { eta, k: Spectrum([3.98, 2.39, 1.60, 0.6]) };
    Model::Conductor(Conductor { fresnel, tint: Spectrum([1.0, 0.5, 0.2, 1.0]), surface })
}

fn glass(surface: Microfacet) -> Model<'static> {
    let (reflectance, transmittance) = (Spectrum([0.9, 0.5, 0.1, 0.2]), Spectrum::ONE);
    Model::Dielectric(Dielectric { eta: 1.5, reflectance, transmittance, surface })
}

/// Mitsuba 3's `pplastic`.
fn plastic(reflectance: Spectrum) -> Model<'static> {
    let base = Model::Diffuse(Diffuse { reflectance: Spectrum([0.1, 0.5, 0.9, 0.0]) });
    let layer = CoatingLayer {
        eta: 1.5,
        surface: rough(),
        through: None,
        reflectance,
        depth: Spectrum::ZERO,
    };
    Model::Coating(Coating::new(layer, base).expect("matte can be coated"))
}

/// Without a highlight, plastic shows its base through its surface: seen at θ, light leaves
/// polarized in the plane of incidence by (κ² - 1)/(κ² + 1) of κ = cos(θ - θ'), sin θ = η sin θ'.
#[test]
fn light_from_inside_plastic_is_polarized() {
    let theta = 1.2f32;
    let (wo, wi) = (Vec3::new(theta.sin(), 0.0, theta.cos()), Vec3::new(0.9, 0.3, 0.1).normalize());
    let m = bsdf(&[(1.0, plastic(Spectrum::ZERO))]);
    let frame = m.parts()[0].frame;
    let (wo, wi) = (frame.to_world(wo), frame.to_world(wi));
    let (mueller, _) = m.eval_mueller(wo, wi, Lobes::ALL);
    // In the frame of the plane of incidence of what leaves.
    let turn = Turn::between(wo, stokes_basis(wo), frame.n.cross(wo));
    let Stokes(s) = mueller.of_unpolarized().turned(turn);
    let kappa = (theta - (theta.sin() / 1.5).asin()).cos();
    let expected = (kappa * kappa - 1.0) / (kappa * kappa + 1.0);
    let found = s[1][2] / s[0][2];
    assert!((found - expected).abs() < 1e-4, "{found} {expected}");
}

fn models() -> Vec<Model<'static>> {
    let one = Spectrum::ONE;
    let filter = |element| {
        let transmittance = Spectrum([0.2, 0.8, 1.0, 0.3]);
        Model::PolarizingFilter(PolarizingFilter { element, transmittance })
    };
    vec![
        metal(Microfacet::smooth()),
        metal(rough()),
        glass(Microfacet::smooth()),
        glass(rough()),
        Model::ThinDielectric(ThinDielectric { eta: 1.5, reflectance: one, transmittance: one }),
        Model::Diffuse(Diffuse { reflectance: Spectrum([0.1, 0.5, 0.9, 0.0]) }),
        filter(FilterElement::Linear { theta: 0.4 }),
        filter(FilterElement::Retarder { theta: 0.4, delta: one }),
        filter(FilterElement::Circular { left_handed: true }),
        Model::Null(Null),
        plastic(Spectrum([1.0, 0.5, 1.0, 0.3])),
    ]
}

fn bsdf<'a>(models: &[(f32, Model<'a>)]) -> Bsdf<'a> {
    let n = Vec3::new(0.3, -0.5, 0.8).normalize();
    let frame = Frame::from_normal_tangent(n, Vec3::new(0.2, 1.0, 0.4));
    let mut bsdf = Bsdf::default();
    bsdf.reset(n);
    for (weight, model) in models {
        bsdf.push(Part { frame, guard: None, relief: 0.0, weight: *weight, model: *model });
    }
    bsdf
}

/// Fixed points of the unit cube.
fn random(i: u32, k: u32) -> f32 {
    (kaustika_math::mix_bits(u64::from(8 * i + k) + 1) >> 40) as f32 / (1u32 << 24) as f32
}

fn direction(i: u32, k: u32) -> Vec3 {
    kaustika_math::warp::uniform_sphere(Vec2::new(random(i, k), random(i, k + 1)))
}

fn near(a: Spectrum, b: Spectrum) {
    let size = a.max_component().abs().max(b.max_component().abs()).max(1.0);
    (0..4).for_each(|l| assert!((a[l] - b[l]).abs() <= 2e-5 * size, "{a:?} {b:?}"));
}

/// No matrix makes more light than m₀₀, or more polarized light than light.
fn sound(m: &Mueller, what: &str) {
    assert!(m.is_finite(), "{what}: {m:?}");
    for s in
        [[1.0, 0.0, 0.0, 0.0], [1.0, 0.6, 0.0, 0.8], [1.0, 0.0, -1.0, 0.0], [1.0, 0.3, 0.2, 0.1]]
    {
        let Stokes(s) = *m * Stokes(s.map(Spectrum::splat));
        for lane in 0..4 {
            let polarized = (1..4).map(|i| s[i][lane].powi(2)).sum::<f32>().sqrt();
            assert!(polarized <= s[0][lane] * (1.0 + 1e-4) + 1e-6, "{what}: {m:?}");
        }
    }
}

#[test]
fn m00_is_the_scalar_value() {
    let diffuse = Model::Diffuse(Diffuse { reflectance: Spectrum([0.1, 0.5, 0.9, 0.0]) });
    let mut cases: Vec<Vec<(f32, Model)>> = models().into_iter().map(|m| vec![(1.0, m)]).collect();
    cases.push(vec![(0.3, metal(rough())), (0.7, diffuse)]);
    cases.push(vec![
        (0.5, glass(rough())),
        (0.2, metal(Microfacet::smooth())),
        (0.3, Model::Null(Null)),
    ]);
    let mut polarized = 0;
    for (n, case) in cases.iter().enumerate() {
        let bsdf = bsdf(case);
        for i in 0..400 {
            let (wo, wi) = (direction(i, 0), direction(i, 2));
            let (m, pdf) = bsdf.eval_mueller(wo, wi, Lobes::ALL);
            let (value, (forward, _)) = bsdf.eval_pdf(wo, wi, Mode::Radiance, Lobes::ALL);
            near(m.m00(), value);
            assert_eq!(pdf, forward);
            sound(&m, &format!("case {n}"));
            let (uc, u2) = (random(i, 4), Vec2::new(random(i, 5), random(i, 6)));
            let scalar = bsdf.sample(wo, uc, u2, Mode::Radiance, Lobes::ALL);
            let both = bsdf.sample_mueller(wo, uc, u2, Lobes::ALL);
            assert_eq!(both.map(|b| b.0), scalar);
            if let Some((s, m)) = both {
                near(m.m00(), s.weight);
                sound(&m, &format!("case {n}, sampled"));
                polarized += usize::from(m.0[1][0].0 != [0.0; 4]);
            }
        }
    }
    assert!(polarized > 1000, "{polarized}");
}

/// A matrix does not depend on how the surface's tangent is turned, unless the model does.
#[test]
fn facets_know_no_tangent() {
    for model in [metal(Microfacet::smooth()), glass(Microfacet::smooth())] {
        for i in 0..100 {
            let wo = direction(i, 0);
            let wo = Vec3::new(wo.x, wo.y, wo.z.abs());
            let s = model.sample(wo, random(i, 4), Vec2::ZERO, Mode::Radiance, Lobes::ALL);
            let Some(s) = s else { continue };
            let a = model.polarization(wo, s.wi).map(|o| o.aligned(wo, s.wi));
            // The same event in a frame that is turned about z.
            let (sin, cos) = 1.1f32.sin_cos();
            let turn = |v: Vec3| Vec3::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y, v.z);
            let back = |v: Vec3| Vec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z);
            let b = model.polarization(turn(wo), turn(s.wi));
            let b = b.map(|o| Oriented { x: back(o.x), ..o }.aligned(wo, s.wi));
            let (Some(a), Some(b)) = (a, b) else { panic!("{model:?}") };
            a.0.iter().flatten().zip(b.0.iter().flatten()).for_each(|(a, b)| near(*a, *b));
        }
    }
}
