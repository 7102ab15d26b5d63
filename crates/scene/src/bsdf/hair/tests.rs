use super::super::testing::{Expect, Random, check_model};
use super::*;

fn hair(across: Across, beta_m: f32, beta_n: f32, alpha: f32, sigma_a: Spectrum) -> Hair {
    let alpha = alpha.to_radians();
    Hair::new(HairParameters { across, eta: 1.55, sigma_a, beta_m, beta_n, alpha })
}

const BROWN: Spectrum = Spectrum([0.58, 0.99, 1.99, 0.2]);

#[test]
fn hair_holds_the_contract() {
    // Fibres are not reciprocal, and the albedo is stated for radiance: see below.
    let expect = Expect {
        both_sides: true,
        reciprocal: false,
        albedo_error: f32::INFINITY,
        albedo_max: f32::INFINITY,
        samples: 20_000,
        ..Expect::default()
    };
    let cases = [
        (Across::Offset(0.0), 0.3, 0.3, 2.0),
        (Across::Offset(-0.8), 0.1, 0.2, 3.0),
        (Across::Offset(0.95), 0.9, 0.7, 0.0),
        (Across::Normal, 0.3, 0.3, 2.0),
        (Across::Normal, 0.6, 1.0, 10.0),
    ];
    for (across, beta_m, beta_n, alpha) in cases {
        let model = hair(across, beta_m, beta_n, alpha, BROWN);
        check_model(&format!("{model:?}"), &model, expect);
    }
}

/// White fibres lose nothing, coloured ones what they say: quadrature over θ and φ, as (1) has
/// no cosine to be divided by.
#[test]
fn white_hair_keeps_all_light() {
    let mut random = Random::new(3);
    for case in 0..24 {
        let across = Across::Offset(2.0 * random.next_1d() - 1.0);
        let (beta_m, beta_n) = (0.1 + 0.9 * random.next_1d(), 0.15 + 0.85 * random.next_1d());
        let sigma = if case % 2 == 0 { Spectrum::ZERO } else { BROWN };
        let model = hair(across, beta_m, beta_n, 2.0, sigma);
        let wo = kaustika_math::warp::uniform_sphere(random.next_2d());
        let n = 600;
        let mut sum = [0f64; 4];
        for i in 0..n {
            let sin = -1.0 + (2 * i + 1) as f32 / n as f32;
            let cos = (1.0 - sqr(sin)).sqrt();
            for j in 0..n {
                let (s, c) = ((2 * j + 1) as f32 * PI / n as f32).sin_cos();
                let f =
                    model.value_and_density(wo, Vec3::new(sin, cos * c, cos * s), Mode::Radiance).0;
                (0..4).for_each(|k| sum[k] += f[k] as f64);
            }
        }
        let area = 4.0 * std::f64::consts::PI / (n * n) as f64;
        let stated = model.albedo(wo);
        for k in 0..4 {
            let (albedo, stated) = (sum[k] * area, stated[k] as f64);
            assert!((albedo - stated).abs() < 1e-3, "{model:?} {wo:?}: {albedo} {stated}");
            assert!(case % 2 == 1 || (stated - 1.0).abs() < 1e-5, "{wo:?}: {stated}");
        }
    }
}

/// Values of Mitsuba 3.9.1 (scalar_rgb) for `wo`, `wi` (not normalised; its y is our x, its x
/// our -y), and of its densities where the lobes are grey, for else it weighs colours otherwise. Its
/// Bessel function is cut off, to 0.5 %; `exact` are the formulas at the head of the file in double
/// precision with numpy's.
#[test]
fn mitsuba_agrees() {
    let pairs = [
        ([0.3, 0.2, 0.8], [-0.4, 0.1, 0.7]),
        ([0.9, 0.1, 0.3], [-0.8, 0.2, 0.35]),
        ([0.0, 0.0, 1.0], [0.5, 0.5, 0.5]),
        ([0.2, -0.9, 0.1], [0.1, 0.3, 0.9]),
        ([0.3, 0.2, 0.8], [-0.2, -0.1, -0.9]),
        ([-0.5, 0.6, 0.3], [-0.6, -0.3, -0.6]),
    ];
    let default = [
        [0.0184699, 0.0157368, 0.0150895],
        [0.00636618, 0.0047975, 0.00457208],
        [0.000154703, 0.000137843, 0.000134354],
        [0.000789005, 0.00034105, 0.000273237],
        [0.850197, 0.374848, 0.0488868],
        [1.14829e-05, 1.14679e-06, 4.06726e-09],
    ];
    let grey = [
        [0.00942879, 0.017163],
        [0.283642, 0.563543],
        [7.44357e-05, 0.000134226],
        [0.0996897, 0.133129],
        [0.00651937, 0.0118671],
        [2.1462e-07, 3.54461e-07],
    ];
    let exact: [f32; 6] =
        [0.009437982, 0.2848863, 7.456061e-5, 0.09980745, 0.006521957, 2.150903e-7];
    let melanin = |i: usize| 1.3 * EUMELANIN[i] + 0.2 * PHEOMELANIN[i];
    let sigma_a = Spectrum([melanin(0), melanin(1), melanin(2), 0.0]);
    let across = Across::Normal;
    // Amber in air.
    let eta = 1.55 / 1.000_277;
    let alpha = 2f32.to_radians();
    let brown = Hair::new(HairParameters { across, eta, sigma_a, beta_m: 0.3, beta_n: 0.3, alpha });
    let sigma_a = Spectrum::splat(0.3);
    let alpha = 5f32.to_radians();
    let plain =
        Hair::new(HairParameters { across, eta: 1.4, sigma_a, beta_m: 0.15, beta_n: 0.6, alpha });
    let near = |a: f32, b: f32| assert!((a - b).abs() <= 5e-3 * b, "{a}, Mitsuba {b}");
    for (k, (wo, wi)) in pairs.into_iter().enumerate() {
        let (wo, wi) = (Vec3::from(wo).normalize(), Vec3::from(wi).normalize());
        let value = brown.eval(wo, wi, Mode::Radiance, Lobes::ALL);
        (0..3).for_each(|i| near(value[i], default[k][i]));
        let (value, (pdf, _)) = plain.eval_pdf(wo, wi, Mode::Radiance, Lobes::ALL);
        near(value[0], grey[k][0]);
        near(pdf, grey[k][1]);
        assert!((value[0] / exact[k] - 1.0).abs() < 5e-5, "{value:?}, exactly {}", exact[k]);
    }
}

/// The colour that (10) is asked for is that of a bundle; its σ falls as the colour brightens.
#[test]
fn absorption_follows_the_color() {
    let sigma = absorption_of_color(Spectrum([1.0, 0.5, 0.1, 0.0]), 0.3);
    // ln² 0.5 / 5.88841²: the polynomial at 0.3.
    assert!((sigma[1] - 0.013_856_5).abs() < 1e-6, "{sigma:?}");
    assert!(sigma[0] == 0.0 && sigma[2] > sigma[1] && sigma.is_finite());
}

#[test]
fn both_ways_to_place_a_ray_agree() {
    // On a round fibre seen along z the offset towards +y is the normal's y. Turned about x into
    // the shading frame, the ray comes from the other side.
    for y in [-0.7f32, 0.2, 0.9] {
        let flat = hair(Across::Offset(y), 0.3, 0.3, 2.0, BROWN);
        let round = hair(Across::Normal, 0.3, 0.3, 2.0, BROWN);
        let z = (1.0 - y * y).sqrt();
        // Rows: the frame whose normal is (0, y, z).
        let turn = |w: Vec3| Vec3::new(w.x, z * w.y - y * w.z, y * w.y + z * w.z);
        let wo = Vec3::Z;
        let wi = Vec3::new(0.1, 0.5, 0.7).normalize();
        let a = flat.value_and_density(wo, wi, Mode::Radiance).0;
        let b = round.value_and_density(turn(wo), turn(wi), Mode::Radiance).0;
        assert!((a[0] - b[0]).abs() < 1e-4 * a[0], "{y}: {a:?} {b:?}");
    }
}
