use super::super::testing::Random;
use super::*;

/// 600 lines a millimetre.
const PERIOD: f32 = 1e6 / 600.0;

fn grating(light: GratingLight, transmittance: f32) -> Grating<'static> {
    Grating {
        period: PERIOD,
        profile: GratingProfile::Sinusoidal { depth: 150.0, eta: 1.5 },
        reflectance: Spectrum::splat(0.9 - transmittance),
        transmittance: Spectrum::splat(transmittance),
        light,
    }
}

/// `n` directions drawn from `wo`, those that are absorbed left out.
fn drawn(g: &Grating, wo: Vec3, n: usize) -> Vec<BsdfSample> {
    let mut random = Random::new(17);
    let draw = |_| g.sample(wo, random.next_1d(), random.next_2d(), Mode::Radiance, Lobes::ALL);
    (0..n).filter_map(draw).collect()
}

/// sin θ_m = sin θᵢ + mλ/d: all the orders that the equation allows are found, and no others.
#[test]
fn orders_have_the_angles_of_the_grating_equation() {
    let lambda = 532.0;
    for (degrees, transmittance) in [(0.0f32, 0.0), (20.0, 0.4), (-65.0, 0.0), (30.0, 0.4)] {
        let profile = GratingProfile::Efficiencies(&[0.09; 6]);
        let g = Grating { profile, ..grating(GratingLight::Hero(lambda), transmittance) };
        let (s, c) = degrees.to_radians().sin_cos();
        let wo = Vec3::new(s, 0.0, c);
        let mut found = std::collections::BTreeSet::new();
        for sample in drawn(&g, wo, 2000) {
            let m = (sample.wi.x as f64 + s as f64) * (PERIOD / lambda) as f64;
            assert!((m - m.round()).abs() < 1e-4 && sample.wi.y == 0.0, "{sample:?}: {m}");
            assert_eq!(sample.wi.z > 0.0, sample.lobe == Lobes::DELTA_REFLECTION);
            assert!((sample.wi.length() - 1.0).abs() < 1e-5);
            found.insert((sample.wi.z < 0.0, m.round() as i32));
        }
        let allowed = |m: &i32| (-s + *m as f32 * lambda / PERIOD).abs() < 1.0;
        let orders: Vec<i32> = (-5..=5).filter(allowed).collect();
        let sides: &[bool] = if transmittance > 0.0 { &[false, true] } else { &[false] };
        let expected: std::collections::BTreeSet<_> =
            sides.iter().flat_map(|t| orders.iter().map(|m| (*t, *m))).collect();
        assert!(orders.len() >= 5, "{orders:?}");
        assert_eq!(found, expected, "{degrees}°");
    }
    // By hand: green at normal incidence has its first order at 18.61°.
    let g = grating(GratingLight::Hero(lambda), 0.0);
    let first = drawn(&g, Vec3::Z, 2000).into_iter().find(|s| s.wi.x > 0.1).expect("an order");
    assert!((first.wi.x.asin().to_degrees() - 18.61).abs() < 0.01, "{first:?}");
}

/// Across the lines the component along them stays: directions lie on a cone.
#[test]
fn oblique_light_goes_into_a_cone() {
    let g = grating(GratingLight::Hero(600.0), 0.0);
    let wo = Vec3::new(0.1, 0.6, 0.0);
    let wo = Vec3::new(wo.x, wo.y, (1.0 - wo.length_squared()).sqrt());
    assert!(drawn(&g, wo, 500).iter().all(|s| (s.wi.y + 0.6).abs() < 1e-6));
}

/// No light is lost or made, in any colour (four standard deviations), also where most orders can't propagate; each order's
/// way back has the probability that was promised.
#[test]
fn energy_is_kept_and_ways_lead_back() {
    for light in [GratingLight::Hero(550.0), GratingLight::Rgb] {
        for (x, transmittance) in [(0.0f32, 0.3), (0.5, 0.0), (0.99, 0.3), (-0.7, 0.0)] {
            let g = grating(light, transmittance);
            let wo = Vec3::new(x, 0.05, (1.0 - x * x - 0.0025).sqrt());
            let samples = drawn(&g, wo, 300_000);
            let mean = samples.iter().fold(Spectrum::ZERO, |a, s| a + s.weight) / 300_000.0;
            let lanes = if light == GratingLight::Rgb { 3 } else { 4 };
            for lane in 0..lanes {
                assert!((mean[lane] - 0.9).abs() < 0.01, "{light:?} {x}: {mean:?}");
            }
            for s in samples.iter().step_by(9001) {
                let back = drawn(&g, s.wi, 20_000);
                let same = |b: &&BsdfSample| (b.wi - wo).length() < 1e-3 && b.lobe == s.lobe;
                let back = back.iter().find(same).expect("light comes back");
                assert!((back.pdf - s.pdf_rev).abs() < 1e-4 * s.pdf_rev, "{s:?} {back:?}");
            }
        }
    }
}

/// J_m against the integral 1/π ∫ cos(mτ - x sin τ) dτ, and the known figure that a sinusoidal
/// phase grating sends at most 33.9 % into a first order, at a = 1.841.
#[test]
fn efficiencies_are_bessel_functions() {
    for x in [1e-4f64, 0.02, 0.5, 1.841, 5.0, 12.0, 30.0] {
        let squares = squared_bessel(x as f32);
        for (m, square) in squares.iter().enumerate() {
            let n = 400;
            let term = |k: usize| {
                let t = std::f64::consts::PI * k as f64 / n as f64;
                (m as f64 * t - x * t.sin()).cos()
            };
            let sum: f64 = (1..n).map(term).sum::<f64>() + 0.5 * (term(0) + term(n));
            let exact = (sum / n as f64).powi(2);
            assert!((*square as f64 - exact).abs() < 2e-6, "J{m}({x})²: {square} {exact}");
        }
    }
    assert!((squared_bessel(1.841)[1] - 0.3386).abs() < 1e-4);
}

/// Given efficiencies are met, and what is left is absorbed: within four standard deviations.
#[test]
fn given_efficiencies_are_met() {
    let list = [0.3, 0.2, 0.05];
    let profile = GratingProfile::Efficiencies(&list);
    let g = Grating { profile, ..grating(GratingLight::Hero(500.0), 0.0) };
    let samples = drawn(&g, Vec3::Z, 100_000);
    let share = |x: f32| {
        let n = samples.iter().filter(|s| (s.wi.x - x).abs() < 1e-4).count();
        n as f32 / 100_000.0
    };
    for (m, e) in [(0, 0.3), (1, 0.2), (-1, 0.2), (2, 0.05), (-2, 0.05)] {
        let found = share(m as f32 * 500.0 / PERIOD);
        assert!((found - e).abs() < 0.006, "{m}: {found}");
    }
    assert!((samples.len() as f32 / 100_000.0 - 0.8).abs() < 0.006);
    assert_eq!(g.albedo(Vec3::Z)[0], 0.9 * 0.8);
}
