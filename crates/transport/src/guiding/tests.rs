//! What every distribution of directions must hold.

use super::{Directions, LightRecord, LocalDirections, Mixture, Quadtree};
use kaustika_math::{Vec2, Vec3, mix_bits, warp};
use std::f32::consts::PI;

pub fn number(i: u64, k: u64) -> f32 {
    (mix_bits(i.wrapping_mul(8) + k) >> 40) as f32 / (1u32 << 24) as f32
}

/// A sky with a bright spot.
fn sky(w: Vec3) -> f32 {
    let spot = Vec3::new(0.6, 0.0, 0.8);
    0.2 + if w.z > 0.0 { w.z } else { 0.0 } + if w.dot(spot) > 0.98 { 30.0 } else { 0.0 }
}

/// Record number `i` of directions that are evenly spread over the sphere: the R₂ sequence of
/// Roberts.
pub fn uniform_record(i: u32, radiance: impl Fn(Vec3) -> f32) -> LightRecord {
    let i = f64::from(i);
    let u = Vec2::new((i * 0.754_877_666).fract() as f32, (i * 0.569_840_296).fract() as f32);
    let w = warp::uniform_sphere(u);
    let pdf = 1.0 / (4.0 * PI);
    let (radiance, distance) = (radiance(w), 5.0);
    LightRecord { p: Vec3::ZERO, w, pdf, radiance, distance, pdf_bsdf: pdf, product: radiance }
}

/// Learned from uniform directions, over a few iterations.
fn learned<D: Directions>() -> D {
    let mut directions = D::default();
    for iteration in 0..5 {
        let numbers = iteration * 20_000..(iteration + 1) * 20_000;
        let records: Vec<LightRecord> = numbers.map(|i| uniform_record(i, sky)).collect();
        directions.learn(&records);
        directions.refine();
    }
    directions
}

/// ∫ f(ω) dω by the midpoint rule on an even grid.
pub fn over_the_sphere(f: impl Fn(Vec3) -> f32) -> f64 {
    let n = 1000;
    let mut sum = 0.0f64;
    for i in 0..n * n {
        let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
        sum += f64::from(f(warp::uniform_sphere(u)));
    }
    sum * 4.0 * std::f64::consts::PI / f64::from(n * n)
}

fn holds<D: Directions>(fluence: f32, irradiance: f32, tolerance: f32) {
    assert!(D::default().at(Vec3::ZERO).is_none());
    let learned = learned::<D>();
    let local = learned.at(Vec3::ZERO).expect("learned");
    // The density integrates to 1, radiance to the fluence.
    let whole = over_the_sphere(|w| local.pdf(w));
    assert!((whole - 1.0).abs() < 2e-3, "{whole}");
    let energy = over_the_sphere(|w| local.radiance(w));
    assert!((energy / f64::from(fluence) - 1.0).abs() < 0.03, "{energy}");
    let up = local.irradiance(Vec3::Z);
    assert!((up / irradiance - 1.0).abs() < tolerance, "{up} {irradiance}");
}

/// χ² of directions drawn against the density, over a grid of equal areas.
pub fn draws_its_density(local: &impl LocalDirections) {
    let (rows, draws, fine) = (12usize, 200_000u64, 40);
    let mut differ = 0;
    let mut seen = vec![0.0f64; rows * rows];
    for i in 0..draws {
        let (w, pdf) = local.sample(Vec2::new(number(i, 4), number(i, 5)));
        // Other than at the borders of quadrants, where rounding decides.
        differ += u32::from((local.pdf(w) / pdf - 1.0).abs() > 1e-2);
        let p = warp::equal_area_sphere_to_square(w) * (rows as f32 * 0.99999);
        seen[p.x as usize + rows * p.y as usize] += 1.0;
    }
    assert!(differ < 20, "{differ}");
    let (mut chi2, mut cells) = (0.0, 0);
    for (i, seen) in seen.iter().enumerate() {
        let mut density = 0.0f64;
        for k in 0..fine * fine {
            let inner = Vec2::new((k % fine) as f32 + 0.5, (k / fine) as f32 + 0.5) / fine as f32;
            let corner = Vec2::new((i % rows) as f32, (i / rows) as f32);
            let w = warp::equal_area_square_to_sphere((corner + inner) / rows as f32);
            density += f64::from(local.pdf(w));
        }
        let area = 4.0 * std::f64::consts::PI / ((rows * rows) as f64);
        let expected = draws as f64 * density / f64::from(fine * fine) * area;
        if expected > 5.0 {
            chi2 += (seen - expected).powi(2) / expected;
            cells += 1;
        }
    }
    // 1 - 10⁻⁴ quantile of χ², by Wilson & Hilferty.
    let k = f64::from(cells - 1);
    let bound = k * (1.0 - 2.0 / (9.0 * k) + 3.719 * (2.0 / (9.0 * k)).sqrt()).powi(3);
    assert!(chi2 < bound, "{chi2} {bound}");
}

/// The integrals of the sky: ∫ sky dω = 0.2·4π + π + 30·2π·0.02, ∫ sky cos dω = 0.2π + 2π/3 + ∫ spot cos.
fn sky_fluence_and_irradiance() -> (f32, f32) {
    let spot = 30.0 * 2.0 * PI * 0.02;
    (0.8 * PI + PI + spot, 0.2 * PI + 2.0 * PI / 3.0 + spot * 0.8 * 0.99)
}

#[test]
fn quadtrees_hold_radiance_and_irradiance() {
    let (fluence, irradiance) = sky_fluence_and_irradiance();
    holds::<Quadtree>(fluence, irradiance, 0.02);
}

#[test]
fn quadtrees_draw_their_density() {
    let learned = learned::<Quadtree>();
    draws_its_density(&learned.at(Vec3::ZERO).expect("learned"));
}

#[test]
fn mixtures_hold_radiance_and_irradiance() {
    let (fluence, irradiance) = sky_fluence_and_irradiance();
    holds::<Mixture>(fluence, irradiance, 0.02);
}

#[test]
fn mixtures_draw_their_density() {
    let learned = learned::<Mixture>();
    draws_its_density(&learned.at(Vec3::ZERO).expect("learned"));
}
