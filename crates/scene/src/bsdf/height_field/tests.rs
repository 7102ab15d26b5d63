use super::super::testing::{Expect, Random, check_model};
use super::super::{Masking, Microfacet};
use super::*;
use crate::description::Distribution;
use kaustika_math::warp;
use std::f32::consts::PI;

/// Random waves, whose slopes are near normal deviates of about this root mean square; whole waves a side, a
/// multiple of n, so that they repeat.
fn waves(n: usize, slope: f32) -> Heights {
    const WAVES: usize = 120;
    let lengths = n as f32 / 17.0;
    let mut random = Random::new(5);
    let mut values = vec![0.0f32; n * n];
    // A wave a cos(k·x) has the mean square slope (a k)²/2, along each of both axes half of it.
    let a = slope * 2.0 / (2.0 * PI * lengths * (WAVES as f32).sqrt());
    for _ in 0..WAVES {
        let (angle, phase) = (2.0 * PI * random.next_1d(), 2.0 * PI * random.next_1d());
        let [ku, kv] = [angle.cos(), angle.sin()].map(|c| (c * lengths).round());
        for (k, h) in values.iter_mut().enumerate() {
            let (u, v) = ((k % n) as f32 / n as f32, (k / n) as f32 / n as f32);
            *h += a * (2.0 * PI * (ku * u + kv * v) + phase).cos();
        }
    }
    Heights::new(n, values)
}

/// Root mean square slopes along u and v, by differences of neighbours.
fn rms(heights: &Heights) -> [f32; 2] {
    let n = heights.n as isize;
    [(1, 0), (0, 1)].map(|(di, dj)| {
        let slope = |k: isize| {
            let (i, j) = (k % n, k / n);
            (heights.at(i + di, j + dj) - heights.at(i, j)) * n as f32
        };
        ((0..n * n).map(|k| slope(k).powi(2)).sum::<f32>() / (n * n) as f32).sqrt()
    })
}

/// Waves of [`grooves`]: of an odd number no two have the same nodes.
const GROOVES: f32 = 5.0;

/// Grooves along v: waves along u of this height.
fn grooves(n: usize, height: f32) -> Heights {
    let at = |k: usize| height * (2.0 * PI * GROOVES * (k % n) as f32 / n as f32).cos();
    Heights::new(n, (0..n * n).map(at).collect())
}

fn tables(heights: &Heights) -> HeightFieldData {
    HeightFieldData::new(heights.n, heights.values.clone())
}

fn field(data: &HeightFieldData) -> HeightField<'_> {
    HeightField { data, reflectance: Spectrum([1.0, 0.7, 0.3, 0.0]) }
}

/// Grooves over waves of a quarter of their slopes: brushed.
fn brushed(n: usize) -> Heights {
    let (grooves, waves) = (grooves(n, 0.01), waves(n, 0.05));
    Heights::new(n, grooves.values.iter().zip(&waves.values).map(|(a, b)| a + b).collect())
}

#[test]
fn height_fields_hold_the_contract() {
    let expect = Expect { albedo_error: 0.02, samples: 20_000, ..Expect::default() };
    for (name, heights) in [("waves", waves(128, 0.7)), ("brushed", brushed(128))] {
        check_model(name, &field(&tables(&heights)), expect);
    }
}

/// A plane is a mirror, as far as the table tells slopes apart.
#[test]
fn planes_are_mirrors() {
    let data = HeightFieldData::new(2, vec![1.0; 4]);
    let (wo, mut random) = (Vec3::new(0.6, 0.0, 0.8), Random::new(3));
    for _ in 0..100 {
        let (uc, u2) = (random.next_1d(), random.next_2d());
        let s = field(&data).sample(wo, uc, u2, Mode::Radiance, Lobes::ALL).expect("a mirror");
        assert!((s.wi - Vec3::new(-0.6, 0.0, 0.8)).length() < 3e-3, "{s:?}");
        assert!((s.weight[0] - 1.0).abs() < 0.01, "{s:?}");
    }
}

/// What a random field reflects is what facets of Beckmann's distribution of its slopes reflect, with
/// Smith's masking (Beckmann & Spizzichino 1963; Heitz 2014): within a tenth of the mean over
/// directions of light, for eyes up to 70° from the normal.
#[test]
fn random_fields_are_microfacets() {
    let heights = waves(512, 0.35);
    let data = tables(&heights);
    let field = HeightField { data: &data, reflectance: Spectrum::ONE };
    let [u, v] = rms(&heights).map(|slope| 2f32.sqrt() * slope);
    assert!((field.roughness() - (u * v).sqrt()).abs() < 0.01, "{}", field.roughness());
    let facets =
        Microfacet::new(Distribution::Beckmann, u, v).with_masking(Masking::HeightCorrelated);
    let mut random = Random::new(11);
    for degrees in [0.0f32, 30.0, 50.0, 70.0] {
        let (s, c) = degrees.to_radians().sin_cos();
        let (mut difference, mut sum) = (0.0, 0.0);
        for _ in 0..4000 {
            // All azimuths of the eye: the field is random, not the same all around.
            let (y, x) = (2.0 * PI * random.next_1d()).sin_cos();
            let wo = Vec3::new(s * x, s * y, c);
            let wi = warp::uniform_hemisphere(random.next_2d());
            let m = (wo + wi).normalize();
            let truth = facets.d(m) * facets.g2(wo, wi) * 0.25 / wo.z;
            let found = field.eval(wo, wi, Mode::Radiance, Lobes::ALL)[0];
            difference += (found - truth).abs();
            sum += truth;
        }
        assert!(difference < 0.1 * sum, "{degrees}: {}", difference / sum);
    }
}

/// Grooves spread light across them and, along them, are a mirror: the slopes s of a wave are, up to s, a part
/// 1/2 + asin(s/a)/π of all, a the steepest; most are steep.
#[test]
fn grooves_are_anisotropic() {
    let height = 0.01;
    let data = tables(&grooves(512, height));
    let field = HeightField { data: &data, reflectance: Spectrum::ONE };
    let steepest = 2.0 * PI * GROOVES * height;
    let toward = |slope: Vec2| {
        // The direction in which a facet of this slope mirrors the normal.
        let m = Vec3::new(-slope.x, -slope.y, 1.0).normalize();
        let wi = reflect(Vec3::Z, m);
        field.eval(Vec3::Z, wi, Mode::Radiance, Lobes::ALL)[0] * 4.0 * m.z.powi(4)
    };
    // ∫ P over slopes across between two parts of the steepest, and all along: seen from above, by light that
    // is not low, nothing is hidden.
    let between = |from: f32, to: f32| {
        let (across, along) = (200, 200);
        let (dx, dy) = ((to - from) * steepest / across as f32, 0.04 / along as f32);
        let at = |i: i32, j: i32| {
            let x = from * steepest + (i as f32 + 0.5) * dx;
            toward(Vec2::new(x, (j as f32 + 0.5) * dy - 0.02))
        };
        (0..across)
            .flat_map(|i| (0..along).map(move |j| (i, j)))
            .map(|(i, j)| at(i, j))
            .sum::<f32>()
            * dx
            * dy
    };
    for [from, to] in [[-0.8f32, -0.4], [-0.4, 0.0], [0.0, 0.4], [0.4, 0.8]] {
        let truth = (to.asin() - from.asin()) / PI;
        let found = between(from, to);
        assert!((found - truth).abs() < 0.05 * truth, "{from} to {to}: {found} {truth}");
    }
    assert_eq!(toward(Vec2::new(0.0, 0.5 * steepest)), 0.0);
}

/// Of the facets that face an eye it sees cos θ/σ, by horizons too, which were not told so: what is seen of a
/// surface is its own projected area, whatever its relief (Heitz 2014, eq. 13).
#[test]
fn horizons_keep_the_projected_area() {
    let heights = waves(256, 0.6);
    let data = tables(&heights);
    for degrees in [20.0f32, 45.0, 60.0, 75.0] {
        let (s, c) = degrees.to_radians().sin_cos();
        let (mut seen, mut facing, mut told) = (0.0, 0.0, 0.0);
        for k in 0..16 {
            let (y, x) = (2.0 * PI * k as f32 / 16.0).sin_cos();
            let w = Vec3::new(s * x, s * y, c);
            told += data.shadows.seen(w) / 16.0;
            for uv in shadows::places() {
                let slope = heights.look(uv).1;
                let area = (w.z - slope.x * w.x - slope.y * w.y).max(0.0);
                let horizon = shadows::horizon(&heights, uv, Vec2::new(x, y));
                seen += if c > horizon * s { area } else { 0.0 };
                facing += area;
            }
        }
        assert!((seen / facing - told).abs() < 0.02, "{degrees}: {} {told}", seen / facing);
    }
}
