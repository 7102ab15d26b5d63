//! Mixtures fitted to what is known: closed forms, known mixtures, places, faults.

use super::expectation::Expectation;
use super::lobes::{Known, Lobe, Lobes};
use super::*;
use crate::guiding::tests::{draws_its_density, number, over_the_sphere, uniform_record};
use crate::saved::Saved;
use kaustika_math::{ONE_MINUS_EPSILON, warp};
use std::f32::consts::PI;

fn lobe(mean: Vec3, kappa: f32, weight: f32) -> Lobe {
    Lobe { mean: mean.normalize(), kappa, weight, nearness: 0.0 }
}

/// A target that mixtures can hold exactly.
fn target() -> [Lobe; 4] {
    [
        lobe(Vec3::new(0.0, 0.0, 1.0), 3.0, 0.4),
        lobe(Vec3::new(1.0, 0.2, 0.1), 60.0, 0.3),
        lobe(Vec3::new(0.9, 0.2, 0.45), 200.0, 0.1),
        lobe(Vec3::new(-0.5, -0.7, -0.2), 800.0, 0.2),
    ]
}

const FLUENCE: f32 = 7.0;

/// Learned from `records` of each iteration.
fn learned(iterations: u32, records: impl Fn(u32) -> Vec<LightRecord>) -> Mixture {
    let mut mixture = Mixture::default();
    for i in 0..iterations {
        mixture.learn(&records(i));
        mixture.refine();
    }
    mixture
}

/// Record number `i` of radiance ∝ `lobes`, half of them drawn by it.
fn guided_record(i: u32, lobes: &Lobes) -> LightRecord {
    let u = Vec2::new(number(u64::from(i), 0), number(u64::from(i), 1));
    let w = if i.is_multiple_of(2) { lobes.sample(u) } else { warp::uniform_sphere(u) };
    let pdf = 0.5 * lobes.pdf(w) + 0.5 / (4.0 * PI);
    LightRecord { w, pdf, radiance: FLUENCE * lobes.pdf(w), ..uniform_record(i, |_| 0.0) }
}

/// `n` records of the target in iteration `i`.
fn of_target(i: u32, n: u32) -> Vec<LightRecord> {
    let lobes = Lobes::new(&target());
    (i * n..(i + 1) * n).map(|i| guided_record(i, &lobes)).collect()
}

#[test]
fn densities_are_densities_whatever_kappa() {
    for kappa in [0.01, 0.3, 2.0, 30.0, 1000.0] {
        let lobes = Lobes::new(&[lobe(Vec3::new(0.3, -0.5, 0.2), kappa, 1.0)]);
        let whole = over_the_sphere(|w| lobes.pdf(w));
        assert!((whole - 1.0).abs() < 1e-3, "{kappa} {whole}");
    }
    // The narrowest by its own samples: their mean cosine is R.
    let mean = Vec3::new(0.3, -0.5, 0.2).normalize();
    let lobes = Lobes::new(&[lobe(mean, 3.2e4, 1.0)]);
    let n = 100_000;
    let far =
        |i| 0.5 * (lobes.sample(Vec2::new(number(i, 0), number(i, 1))) - mean).length_squared();
    let sum: f64 = (0..n).map(|i| f64::from(far(i))).sum();
    // Exponentially distributed: five standard errors.
    assert!((sum / n as f64 * 3.2e4 - 1.0).abs() < 5.0 / (n as f64).sqrt(), "{sum}");
}

#[test]
fn em_finds_a_known_mixture() {
    let mixture = learned(12, |i| of_target(i, 50_000));
    let local = mixture.at(Vec3::ZERO).expect("learned");
    let exact = Lobes::new(&target());
    // Half of ∫ |p - target|: the share of directions drawn amiss.
    let amiss = 0.5 * over_the_sphere(|w| (local.pdf(w) - exact.pdf(w)).abs());
    assert!(amiss < 0.02, "{amiss}");
    let energy = over_the_sphere(|w| local.radiance(w));
    assert!((energy / f64::from(FLUENCE) - 1.0).abs() < 2e-3, "{energy}");
    // Lobe by lobe.
    assert_eq!(mixture.size(), target().len());
    for t in target() {
        let found = mixture.components.iter().map(|c| c.lobe);
        let l = found.max_by(|a, b| a.mean.dot(t.mean).total_cmp(&b.mean.dot(t.mean)));
        let l = l.expect("lobes");
        assert!((l.weight - t.weight).abs() < 0.01, "{l:?} {t:?}");
        assert!((l.kappa / t.kappa - 1.0).abs() < 0.1, "{l:?} {t:?}");
        // A tenth of the lobe's own width.
        assert!((l.mean - t.mean).length() < 0.1 / t.kappa.sqrt(), "{l:?} {t:?}");
    }
}

#[test]
fn one_lobe_is_found_with_its_parameters() {
    for kappa in [2.0f32, 50.0, 2000.0] {
        let t = lobe(Vec3::new(-0.4, 0.8, 0.3), kappa, 1.0);
        let exact = Lobes::new(&[t]);
        let numbers = |i| i * 20_000..(i + 1) * 20_000;
        let mixture = learned(10, |i| numbers(i).map(|i| guided_record(i, &exact)).collect());
        let sum = mixture.components.iter().fold(Vec3::ZERO, |sum, c| {
            sum + c.lobe.mean * (c.lobe.weight * vmf::mean_cosine(f64::from(c.lobe.kappa)) as f32)
        });
        let found = vmf::concentration(f64::from(sum.length()));
        assert!((found / f64::from(kappa) - 1.0).abs() < 0.05, "{kappa} {found}");
        assert!(sum.normalize().dot(t.mean) > 1.0 - 1e-3 / kappa, "{kappa} {sum:?}");
    }
}

#[test]
fn irradiance_is_that_of_the_radiance() {
    for kappa in [0.01, 0.5, 1.0, 2.0, 4.0, 8.0, 20.0, 100.0, 1000.0] {
        let known = Known::new(&[lobe(Vec3::X, kappa, 1.0)], Vec3::ZERO, 1.0);
        let lobes = known.at(Vec3::ZERO);
        for i in 0..=12 {
            let (sin, cos) = (PI * i as f32 / 12.0).sin_cos();
            let n = Vec3::new(cos, 0.0, sin);
            let exact = over_the_sphere(|w| lobes.pdf(w) * w.dot(n).max(0.0));
            let ours = f64::from(known.irradiance(&lobes, n));
            assert!((ours - exact).abs() < 0.01, "{kappa} {i}: {ours} {exact}");
        }
    }
}

#[test]
fn products_with_a_cosine_are_densities_near_the_product() {
    let mixture = learned(8, |i| of_target(i, 20_000));
    let n = Vec3::new(0.5, 0.1, 0.8).normalize();
    let radiance = mixture.at(Vec3::ZERO).expect("learned");
    let product = radiance.towards(n);
    let whole = over_the_sphere(|w| product.pdf(w));
    assert!((whole - 1.0).abs() < 2e-3, "{whole}");
    draws_its_density(&product);
    // Closer to radiance times cosine than radiance alone is.
    let cosine = |w: Vec3| w.dot(n).max(0.0);
    let scale = over_the_sphere(|w| radiance.pdf(w) * cosine(w)) as f32;
    let exact = |w: Vec3| radiance.pdf(w) * cosine(w) / scale;
    let amiss = |p: &dyn Fn(Vec3) -> f32| 0.5 * over_the_sphere(|w| (p(w) - exact(w)).abs());
    let (with, without) = (amiss(&|w| product.pdf(w)), amiss(&|w| radiance.pdf(w)));
    assert!(with < 0.5 * without && with < 0.1, "{with} {without}");
    // Radiance and irradiance are as before.
    let w = Vec3::new(0.6, 0.0, 0.8);
    assert_eq!(product.radiance(w), radiance.radiance(w));
    assert_eq!(product.irradiance(n), radiance.irradiance(n));
}

/// Records at places in a cube, of a small light at `light` and a dim sky.
fn near_a_light(i: u32, n: u32, light: Vec3) -> Vec<LightRecord> {
    (i * n..(i + 1) * n)
        .map(|i| {
            let u = |k| number(u64::from(i), k);
            let p = (Vec3::new(u(0), u(1), u(2)) * 2.0 - Vec3::splat(1.0)) * 0.5;
            let to = (light - p).normalize();
            let beam = Lobes::new(&[lobe(to, 500.0, 1.0)]);
            let bright = i.is_multiple_of(2);
            let w = if bright {
                beam.sample(Vec2::new(u(3), u(4)))
            } else {
                warp::uniform_sphere(Vec2::new(u(3), u(4)))
            };
            let pdf = 0.5 * beam.pdf(w) + 0.5 / (4.0 * PI);
            // What is seen in the beam is at the light, everything else far away.
            let seen = w.dot(to) > 0.99;
            let radiance = if seen { beam.pdf(w) } else { 0.01 };
            let distance = if seen { (light - p).length() } else { f32::INFINITY };
            LightRecord { p, w, pdf, radiance, distance, pdf_bsdf: pdf, product: 0.0 }
        })
        .collect()
}

#[test]
fn lights_are_found_from_elsewhere() {
    let light = Vec3::new(0.3, 0.5, 1.5);
    let mixture = learned(6, |i| near_a_light(i, 10_000, light));
    for p in [Vec3::ZERO, Vec3::new(0.4, 0.4, 0.4), Vec3::new(-0.4, 0.3, -0.4)] {
        let local = mixture.at(p).expect("learned");
        // The mean of directions within 30° of the light.
        let to = (light - p).normalize();
        let mut mean = Vec3::ZERO;
        let mut hits = 0;
        for i in 0..10_000 {
            let (w, _) = local.sample(Vec2::new(number(i, 6), number(i, 7)));
            if w.dot(to) > 0.87 {
                mean += w;
                hits += 1;
            }
        }
        let off = mean.normalize().dot(to).acos().to_degrees();
        assert!(hits > 8000 && off < 1.0, "{p:?}: {off}° {hits}");
    }
    // Surroundings stay where they are.
    let far = |i| {
        near_a_light(i, 5000, light)
            .into_iter()
            .map(|r| LightRecord { distance: f32::INFINITY, ..r })
    };
    let mixture = learned(2, |i| far(i).collect());
    let (a, b) = (mixture.at(Vec3::ZERO).expect("learned"), mixture.at(Vec3::X).expect("learned"));
    let w = Vec3::new(0.2, 0.3, 0.9).normalize();
    assert!((a.pdf(w) / b.pdf(w) - 1.0).abs() < 1e-4);
}

#[test]
fn early_faults_fade() {
    let wrong = lobe(Vec3::new(0.0, -1.0, 0.0), 100.0, 1.0);
    let dark = Lobes::new(&[wrong]);
    let mixture = learned(8, |i| {
        let n = 20_000;
        let numbers = i * n..(i + 1) * n;
        match i {
            0 => numbers.map(|i| uniform_record(i, |w| 50.0 * dark.pdf(w))).collect(),
            _ => of_target(i, n),
        }
    });
    let local = mixture.at(Vec3::ZERO).expect("learned");
    let spike = local.radiance(wrong.mean) / (50.0 * dark.pdf(wrong.mean));
    assert!(spike < 0.01, "{spike}");
    let energy = over_the_sphere(|w| local.radiance(w));
    assert!((energy / f64::from(FLUENCE) - 1.0).abs() < 0.15, "{energy}");
}

#[test]
fn nothing_breaks_a_mixture() {
    let usual = |i: u32| uniform_record(i, |_| 1.0);
    let sound = |mixture: &Mixture| {
        for p in [Vec3::ZERO, Vec3::new(1e3, -2.0, 5.0), Vec3::splat(1e20)] {
            let Some(local) = mixture.at(p) else { continue };
            for local in [local, local.towards(Vec3::Y)] {
                for i in 0..200 {
                    let (w, pdf) = local.sample(Vec2::new(number(i, 0), number(i, 1)));
                    assert!((w.length() - 1.0).abs() < 1e-4, "{w:?}");
                    assert!(pdf.is_finite() && pdf > 0.0, "{pdf}");
                    let e = local.irradiance(w);
                    assert!(local.radiance(w).is_finite() && e.is_finite() && e >= 0.0);
                }
                for u in [0.0, 0.5, ONE_MINUS_EPSILON] {
                    let (w, pdf) = local.sample(Vec2::new(u, u));
                    assert!(w.is_finite() && pdf.is_finite() && pdf >= 0.0, "{u} {w:?} {pdf}");
                }
            }
        }
    };
    let faults: [(&str, &dyn Fn(u32) -> LightRecord); 13] = [
        ("black", &|i| LightRecord { radiance: 0.0, ..usual(i) }),
        ("one direction", &|i| LightRecord { w: Vec3::X, ..usual(i) }),
        ("one bright", &|i| LightRecord { radiance: if i == 7 { 1e12 } else { 1e-6 }, ..usual(i) }),
        ("at infinity", &|i| LightRecord { distance: f32::INFINITY, ..usual(i) }),
        ("at no distance", &|i| LightRecord { distance: 0.0, ..usual(i) }),
        ("nowhere", &|i| LightRecord { distance: f32::NAN, ..usual(i) }),
        ("far", &|i| LightRecord { distance: 1e30, ..usual(i) }),
        ("blinding", &|i| LightRecord { radiance: 1e29, pdf: 1.0, ..usual(i) }),
        ("beyond numbers", &|i| LightRecord { radiance: 3e38, ..usual(i) }),
        ("faint", &|i| LightRecord { radiance: 1e-38, pdf: 1e6, ..usual(i) }),
        ("NaN", &|i| LightRecord { radiance: f32::NAN, ..usual(i) }),
        ("no density", &|i| LightRecord { pdf: 0.0, ..usual(i) }),
        ("wide apart", &|i| LightRecord {
            p: Vec3::new(if i.is_multiple_of(2) { 1e6 } else { -1e6 }, 0.0, 0.0),
            ..usual(i)
        }),
    ];
    for (name, fault) in faults {
        for count in [1, 3, 5000] {
            let mixture = learned(3, |i| (i * count..(i + 1) * count).map(fault).collect());
            let known = !["black", "NaN", "no density", "beyond numbers"].contains(&name);
            assert_eq!(mixture.at(Vec3::ZERO).is_some(), known, "{name}");
            sound(&mixture);
            // It recovers.
            let mut mixture = mixture;
            for i in 0..3 {
                mixture.learn(&of_target(i, 5000));
                mixture.refine();
                sound(&mixture);
            }
        }
    }
    let mut nothing = Mixture::default();
    nothing.learn(&[]);
    nothing.refine();
    assert!(nothing.at(Vec3::ZERO).is_none());
}

#[test]
fn shares_far_from_all_lobes_go_to_the_nearest() {
    let lobes = [lobe(Vec3::X, 3e4, 0.5), lobe(Vec3::Y, 3e4, 0.5)];
    let sample =
        Sample { w: Vec3::new(-0.1, -0.9, 0.3).normalize(), energy: 2.0, pdf: 1.0, nearness: 0.0 };
    let (sums, likelihood) = Expectation::new(&lobes).sums(&[sample]);
    assert!(likelihood.is_finite() && likelihood < -1e4);
    assert!((sums[0].energy - 2.0).abs() < 1e-5 && sums[1].energy < 1e-5);
}

#[test]
fn children_begin_with_what_their_parent_knew() {
    let parent = learned(3, |i| near_a_light(i, 10_000, Vec3::new(0.3, 0.5, 1.5)));
    let mut child = parent.clone();
    let w = Vec3::new(0.2, 0.3, 0.9).normalize();
    let p = Vec3::new(0.4, 0.4, 0.4);
    let pdf = |m: &Mixture| m.at(p).expect("learned").pdf(w);
    assert_eq!(pdf(&parent), pdf(&child));
    // Its records lie elsewhere than the parent's; the light is where it was.
    let light = Vec3::new(0.3, 0.5, 1.5);
    let of_child = near_a_light(9, 40_000, light).into_iter().filter(|r| r.p.x > 0.2);
    let of_child: Vec<LightRecord> = of_child.collect();
    let before = child.pivot;
    child.learn(&of_child);
    assert_eq!(pdf(&parent), pdf(&child));
    child.refine();
    assert!(child.pivot.x > before.x + 0.1);
    let to = (light - p).normalize();
    let hits = (0..1000).filter(|&i| {
        let (w, _) = child.at(p).expect("learned").sample(Vec2::new(number(i, 0), number(i, 1)));
        w.dot(to) > 0.98
    });
    assert!(hits.count() > 750);
}

#[test]
fn what_is_saved_goes_on_as_if_it_never_stopped() {
    let mut mixture = learned(3, |i| near_a_light(i, 4000, Vec3::Z));
    mixture.learn(&near_a_light(3, 4000, Vec3::Z));
    let mut bytes = Vec::new();
    mixture.save(&mut bytes).expect("a list takes all");
    let mut again = Mixture::load(&mut &bytes[..]).expect("whole");
    for _ in 0..2 {
        for i in 0..100 {
            let (p, u) =
                (warp::uniform_sphere(Vec2::new(number(i, 0), number(i, 1))), number(i, 2));
            let at =
                |m: &Mixture| m.at(p * 0.3).expect("learned").sample(Vec2::new(u, number(i, 3)));
            assert_eq!(at(&mixture), at(&again));
        }
        mixture.refine();
        again.refine();
    }
    for n in (0..bytes.len()).step_by(7) {
        assert!(Mixture::load(&mut &bytes[..n]).is_err(), "{n}");
    }
}

#[test]
fn lobes_follow_when_the_pivot_moves() {
    let light = Vec3::new(0.3, 0.5, 1.5);
    let mut mixture = learned(4, |i| near_a_light(i, 10_000, light));
    let elsewhere: Vec<LightRecord> = near_a_light(4, 10_000, light)
        .into_iter()
        .map(|r| LightRecord { p: r.p + Vec3::new(0.6, -0.4, 0.2), ..r })
        .collect();
    let before = mixture.pivot;
    mixture.follow(&elsewhere);
    assert!((mixture.pivot - before).length() > 0.2, "{:?}", mixture.pivot);
    let brightest =
        mixture.components.iter().max_by(|a, b| a.lobe.weight.total_cmp(&b.lobe.weight));
    let c = brightest.expect("lobes");
    let to = light - mixture.pivot;
    assert!(c.lobe.mean.dot(to.normalize()) > 0.9995, "{:?} {to:?}", c.lobe);
    assert!((c.lobe.nearness * to.length() - 1.0).abs() < 0.05, "{:?} {to:?}", c.lobe);
    let r = Vec3::from(c.sums.direction.map(|x| x as f32)).normalize();
    assert!(r.dot(c.lobe.mean) > 0.9999);
}
