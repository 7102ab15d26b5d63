//! The contract where f is smooth; where it is made of walks, the contract's parts that walks do
//! not blur, and the mean against a simulation of another kind.

use super::super::testing::{Expect, Random, check_model};
use super::*;
use crate::description::Distribution;
use kaustika_math::special::p_two_sided;
use kaustika_math::warp;

fn facets(alpha: f32) -> Microfacet {
    Microfacet::new(Distribution::Ggx, alpha, alpha)
}

fn coat(alpha: f32) -> Coat {
    Coat {
        ior: 1.5,
        surface: facets(alpha),
        thickness: 0.01,
        albedo: Spectrum::ZERO,
        g: 0.0,
        max_depth: 10,
        samples: 1,
        salt: 0,
    }
}

/// Scatters.
fn milky(alpha: f32) -> Coat {
    Coat { thickness: 0.5, albedo: Spectrum([0.9, 0.5, 0.2, 0.0]), g: 0.6, ..coat(alpha) }
}

const RED: Spectrum = Spectrum([0.8, 0.3, 0.1, 0.0]);

fn diffuse(coat: Coat) -> CoatedDiffuse {
    CoatedDiffuse::new(RED, coat)
}

fn metal(alpha: f32, coat: Coat) -> CoatedConductor {
    let eta_k = ConductorFresnel::EtaK {
        eta: Spectrum([0.2, 0.9, 1.1, 1.0]),
        k: Spectrum([3.9, 2.4, 2.2, 0.0]),
    };
    CoatedConductor::new(eta_k, facets(alpha), coat)
}

#[test]
fn closed_form_holds_the_contract() {
    let smooth = Expect { albedo_error: 2e-3, ..Expect::default() };
    check_model("coated matte", &diffuse(coat(0.0)), smooth);
    check_model("thick", &diffuse(Coat { thickness: 0.4, ..coat(0.0) }), smooth);
    check_model("lighter coat", &diffuse(Coat { ior: 0.8, ..coat(0.0) }), smooth);
    check_model("black base", &CoatedDiffuse::new(Spectrum::ZERO, coat(0.0)), smooth);
    check_model("coated mirror", &metal(0.0, coat(0.0)), smooth);
}

/// The same sampling and densities over a smooth, symmetric value: all that `check_model` asks
/// but the value itself.
#[derive(Clone, Copy)]
struct Densities<B>(Layered<B>);

impl<B: Base> Scatter for Densities<B> {
    fn eval(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> Spectrum {
        if !lobes.has(B::CLASS) {
            return Spectrum::ZERO;
        }
        let (forward, reverse) = self.0.pdf(wo, wi, mode, Lobes::ALL);
        Spectrum::splat(forward.min(1e6) * wi.z * wo.z / 4.0 + reverse * wi.z * wi.z / 4.0)
    }
    fn pdf(&self, wo: Vec3, wi: Vec3, mode: Mode, lobes: Lobes) -> (f32, f32) {
        self.0.pdf(wo, wi, mode, lobes)
    }
    fn sample(&self, wo: Vec3, uc: f32, u2: Vec2, mode: Mode, lobes: Lobes) -> Option<BsdfSample> {
        let mut s = self.0.sample(wo, uc, u2, mode, lobes)?;
        if Lobes::SMOOTH.has(s.lobe) {
            s.weight = self.eval(wo, s.wi, mode, lobes) / s.pdf;
        }
        Some(s)
    }
    fn albedo(&self, _: Vec3) -> Spectrum {
        Spectrum::ONE
    }
    fn roughness(&self) -> f32 {
        self.0.roughness()
    }
    fn lobes(&self) -> Lobes {
        self.0.lobes()
    }
}

fn check_densities(name: &str, layered: Layered<impl Base>) {
    let expect =
        Expect { samples: 20_000, albedo_error: 1e3, albedo_max: 1e3, ..Expect::default() };
    check_model(name, &Densities(layered), expect);
}

#[test]
fn directions_have_their_densities() {
    check_densities("rough coat", diffuse(coat(0.2)));
    check_densities("milky coat", diffuse(milky(0.0)));
    check_densities("coated rough metal", metal(0.2, coat(0.0)));
    check_densities("coated sharp metal", metal(0.02, coat(0.0)));
    check_densities("rough coat on metal", metal(0.1, coat(0.3)));
    check_densities("rough coat on mirror", metal(0.0, coat(0.2)));
    check_densities("milky coat on mirror", metal(0.0, milky(0.0)));
}

/// What does not depend on luck: value and weight agree, both modes and both ends agree exactly,
/// classes add up, nothing below, and no number is bad.
fn check_values(name: &str, layered: Layered<impl Base>) {
    let mut random = Random::new(11);
    for _ in 0..3000 {
        let wo = warp::uniform_hemisphere(random.next_2d());
        let (uc, u2) = (random.next_1d(), random.next_2d());
        let Some(s) = layered.sample(wo, uc, u2, Mode::Radiance, Lobes::ALL) else { continue };
        if Lobes::DELTA.has(s.lobe) {
            continue;
        }
        let value = layered.eval(wo, s.wi, Mode::Radiance, Lobes::ALL);
        let back = layered.eval(s.wi, wo, Mode::Importance, Lobes::ALL);
        let parts = layered.eval(wo, s.wi, Mode::Radiance, Lobes::GLOSSY_REFLECTION)
            + layered.eval(wo, s.wi, Mode::Radiance, Lobes::DIFFUSE_REFLECTION);
        for lane in 0..4 {
            let v = value[lane];
            let near = |x: f32| (x - v).abs() <= 1e-4 * v + 1e-7;
            assert!(v >= 0.0 && v.is_finite(), "{name}: {wo:?} {s:?} {value:?}");
            assert!(near(s.weight[lane] * s.pdf), "{name}: {wo:?} {s:?} {value:?}");
            assert!(near(back[lane] * s.wi.z / wo.z), "{name}: {wo:?} {s:?} {value:?} {back:?}");
            assert!(near(parts[lane]), "{name}: {value:?} {parts:?}");
        }
        for (a, b) in [(-wo, s.wi), (wo, -s.wi), (-wo, -s.wi)] {
            assert!(layered.eval(a, b, Mode::Radiance, Lobes::ALL).is_black());
        }
        assert!(layered.sample(-wo, uc, u2, Mode::Radiance, Lobes::ALL).is_none());
    }
}

#[test]
fn values_are_symmetric_and_finite() {
    check_values("rough coat", diffuse(coat(0.2)));
    check_values("milky coat", diffuse(milky(0.3)));
    check_values("coated metal", metal(0.2, coat(0.0)));
    check_values("rough coat on metal", metal(0.1, milky(0.3)));
    check_values("rough coat on mirror", metal(0.0, coat(0.2)));
    check_values("lighter coat", metal(0.1, Coat { ior: 0.7, ..coat(0.2) }));
}

/// Mean and variance of several quantities.
struct Moments {
    n: f64,
    sum: [f64; 12],
    square: [f64; 12],
}

impl Moments {
    /// Of the quantities weight, weight cos θ, weight (1 + cos φ) for each colour.
    fn of(n: usize, mut draw: impl FnMut() -> Option<(Spectrum, Vec3)>) -> Moments {
        let mut m = Moments { n: n as f64, sum: [0.0; 12], square: [0.0; 12] };
        for _ in 0..n {
            let Some((weight, w)) = draw() else { continue };
            let (x, y) = (w.z, 1.0 + w.x);
            for lane in 0..4 {
                for (k, factor) in [1.0, x, y].into_iter().enumerate() {
                    let v = (weight[lane] * factor) as f64;
                    m.sum[3 * lane + k] += v;
                    m.square[3 * lane + k] += v * v;
                }
            }
        }
        m
    }

    fn mean(&self, i: usize) -> f64 {
        self.sum[i] / self.n
    }

    fn error(&self, i: usize) -> f64 {
        ((self.square[i] / self.n - self.mean(i).powi(2)).max(0.0) / self.n).sqrt()
    }
}

/// A photon followed through the layers as it happens: no connections, no mixture.
fn follow(l: &Layered<impl Base>, wo: Vec3, random: &mut Random) -> Option<(Spectrum, Vec3)> {
    let mode = Mode::Importance;
    let draw = |m: &dyn Fn(f32, Vec2) -> Option<BsdfSample>, r: &mut Random| {
        let uc = r.next_1d();
        m(uc, r.next_2d())
    };
    let s = draw(&|uc, u| l.surface.sample(wo, uc, u, mode, Lobes::ALL), random)?;
    let mut weight = s.weight;
    if s.wi.z > 0.0 {
        return Some((weight, s.wi));
    }
    let (mut w, mut z, mut events) = (s.wi, 0.0f32, 0);
    let (g, scatters) = (l.coat.g, !l.coat.albedo.is_black());
    loop {
        // A free path of the medium; without scattering it only absorbs.
        let free = -(1.0 - random.next_1d()).ln();
        let boundary = if w.z < 0.0 { l.coat.thickness - z } else { z } / w.z.abs();
        if free < boundary {
            if !scatters || events == l.coat.max_depth {
                return None;
            }
            events += 1;
            weight *= l.coat.albedo;
            z -= free * w.z;
            // Henyey and Greenstein by rejection from the sphere.
            let most = (1.0 - g * g) / (1.0 - g.abs()).powi(3);
            w = loop {
                let d = warp::uniform_sphere(random.next_2d());
                let p = (1.0 - g * g) / (1.0 + g * g - 2.0 * g * w.dot(d)).powf(1.5);
                if random.next_1d() * most < p {
                    break d;
                }
            };
            continue;
        }
        if w.z < 0.0 {
            if events == l.coat.max_depth {
                return None;
            }
            z = l.coat.thickness;
            let s = draw(&|uc, u| l.base.sample(-w, uc, u, mode, Lobes::ALL), random)?;
            (weight, w) = (weight * s.weight, s.wi);
        } else {
            z = 0.0;
            let s = draw(&|uc, u| l.surface.sample(-w, uc, u, mode, Lobes::ALL), random)?;
            (weight, w) = (weight * s.weight, s.wi);
            if w.z > 0.0 {
                return Some((weight, w));
            }
            if events == l.coat.max_depth {
                return None;
            }
        }
        events += 1;
    }
}

/// The albedo and two moments of the reflected light by `sample` and by photons: z-tests, 1 % for
/// all of them together (Šidák).
fn check_against_photons(name: &str, layered: Layered<impl Base>, n: usize) {
    let p_least = 1.0 - 0.99f64.powf(1.0 / (3.0 * 12.0));
    for (k, z) in [0.95f32, 0.5, 0.15].into_iter().enumerate() {
        let wo = Vec3::new((1.0 - z * z).sqrt(), 0.0, z);
        let mut random = Random::new(100 + k as u64);
        let ours = Moments::of(n, || {
            let (uc, u2) = (random.next_1d(), random.next_2d());
            let s = layered.sample(wo, uc, u2, Mode::Radiance, Lobes::ALL)?;
            Some((s.weight, s.wi))
        });
        let mut random = Random::new(200 + k as u64);
        let truth = Moments::of(n, || follow(&layered, wo, &mut random));
        for i in 0..12 {
            let (a, b) = (ours.mean(i), truth.mean(i));
            let error = ours.error(i).hypot(truth.error(i));
            let z = ((a - b).abs() - 1e-5 * b) / error.max(1e-12);
            assert!(
                p_two_sided(z.max(0.0)) > p_least,
                "{name} cos {} quantity {i}: {a:.5} ± {:.5}, photons {b:.5} ± {:.5}",
                wo.z,
                ours.error(i),
                truth.error(i)
            );
        }
        let stated = layered.albedo(wo);
        for lane in 0..3 {
            let (a, b) = (stated[lane] as f64, truth.mean(3 * lane));
            assert!((a - b).abs() < 0.2, "{name} cos {} lane {lane}: albedo() {a}, {b}", wo.z);
        }
    }
}

#[test]
fn coated_matte_bases_agree_with_photons() {
    check_against_photons("smooth clear", diffuse(coat(0.0)), 200_000);
    check_against_photons("rough clear", diffuse(coat(0.3)), 200_000);
    check_against_photons("very rough clear", diffuse(coat(0.8)), 200_000);
    check_against_photons("smooth milky", diffuse(milky(0.0)), 200_000);
    check_against_photons("rough milky", diffuse(milky(0.2)), 200_000);
    let short = Coat { max_depth: 3, ..milky(0.2) };
    check_against_photons("short paths", diffuse(short), 200_000);
    let more = Coat { samples: 4, ..milky(0.0) };
    check_against_photons("four walks", diffuse(more), 100_000);
}

#[test]
fn coated_metals_agree_with_photons() {
    check_against_photons("smooth on mirror", metal(0.0, coat(0.0)), 200_000);
    check_against_photons("smooth on rough", metal(0.3, coat(0.0)), 200_000);
    check_against_photons("smooth on sharp", metal(0.03, coat(0.0)), 200_000);
    check_against_photons("rough on rough", metal(0.2, coat(0.2)), 200_000);
    check_against_photons("rough on sharp", metal(0.02, coat(0.3)), 200_000);
    check_against_photons("rough on mirror", metal(0.0, coat(0.15)), 200_000);
    check_against_photons("very rough on mirror", metal(0.0, coat(0.7)), 200_000);
    check_against_photons("very rough on sharp", metal(0.05, coat(0.7)), 200_000);
    check_against_photons("milky on mirror", metal(0.0, milky(0.0)), 200_000);
    check_against_photons("milky on rough", metal(0.2, milky(0.1)), 200_000);
}

/// The walks' mean over salts is the closed form at every pair of directions.
#[test]
fn walks_average_to_the_closed_form() {
    let closed = diffuse(Coat { thickness: 0.2, ..coat(0.0) });
    let p_least = 1.0 - 0.99f64.powf(1.0 / (20.0 * 3.0));
    let mut random = Random::new(3);
    for _ in 0..20 {
        let wo = warp::uniform_hemisphere(random.next_2d());
        let wi = warp::uniform_hemisphere(random.next_2d());
        let exact = closed.below(wo, wi);
        let mut salt = 0;
        let walks = Moments::of(20_000, || {
            salt += 1;
            let coat = Coat { salt, ..closed.coat };
            Some((walk::average(&Layered { coat, ..closed }, wo, wi), Vec3::Z))
        });
        for lane in 0..3 {
            let z = (walks.mean(3 * lane) - exact[lane] as f64) / walks.error(3 * lane);
            assert!(
                p_two_sided(z) > p_least,
                "{wo:?} {wi:?} lane {lane}: {} ± {}, closed form {}",
                walks.mean(3 * lane),
                walks.error(3 * lane),
                exact[lane]
            );
        }
    }
}

/// A clear coat over white loses only what the truncation to `max_depth` cuts off: K^n of what
/// entered, K = 0.596, n = 5 at a depth of 10.
#[test]
fn a_clear_coat_on_white_is_white() {
    for (max_depth, lost) in [(10, 0.0753), (20, 0.0057), (200, 0.0)] {
        let clear = Coat { thickness: 0.0, max_depth, ..coat(0.0) };
        let model = CoatedDiffuse::new(Spectrum::ONE, clear);
        for z in [1.0f32, 0.5, 0.1] {
            let wo = Vec3::new((1.0 - z * z).sqrt(), 0.0, z);
            let entered = 1.0 - fresnel_dielectric(z, 1.5).reflectance;
            let albedo = model.albedo(wo)[0];
            assert!((albedo + entered * lost - 1.0).abs() < 1e-3, "{max_depth} {z}: {albedo}");
        }
    }
    // And the white furnace of a whole surface, through the contract.
    let clear = Coat { thickness: 0.0, max_depth: 200, ..coat(0.0) };
    let lossless = Expect { albedo: Some((1.0, 1e-3)), ..Expect::default() };
    check_model("clear coat on white", &CoatedDiffuse::new(Spectrum::ONE, clear), lossless);
}
