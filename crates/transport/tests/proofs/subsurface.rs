//! Glass-bounded scattering matter, as readers make it of materials with subsurface scattering.

use crate::scenes::*;
use crate::stats::agrees;
use kaustika_scene::description::*;
use serde_json::json;
use std::f64::consts::PI;

/// A ball of radius 1 before a white sky, of index 1.33 around isotropic matter.
fn ball(albedo: f32, sigma_t: f32) -> Stage {
    let mut stage = Stage::new();
    stage.sky(1.0);
    let glass = stage.glass(1.33, 0.0);
    let constant = |v| FieldDesc::Constant(grey(v));
    stage.d.media.push(MediumDesc {
        name: String::new(),
        kind: "subsurface".into(),
        coefficients: CoefficientsDesc::AbsorptionScattering(
            constant(sigma_t * (1.0 - albedo)),
            constant(sigma_t * albedo),
        ),
        scale: 1.0,
        density: None,
        glow: None,
        phase: PhaseDesc::Isotropic,
        extent: None,
        span: None,
    });
    stage.shape(sphere(1.0), at(0.0, 0.0, 3.0), glass).interior = Some(MediumId(0));
    stage.camera(parallel(1.0, 0.0, 1.0), HERE, [16, 16]);
    stage
}

/// A ball seen in parallel projection under even light shows the mean of its albedo over cosine-weighted
/// directions: what the boundary reflects, and of what has entered the share A that a half space
/// gives back (`formats/src/half_space.rs`), if the ball is large for its matter.
#[test]
fn a_large_ball_gives_back_what_a_half_space_does() {
    // Matter that gives back one half.
    let (alpha, share) = (0.970_500_8, 0.5);
    // ∫ 2 μ F(μ) dμ from outside, by quadrature.
    let eta = 1.33f64;
    let n = 2000;
    let outside: f64 = (0..n)
        .map(|i| {
            let x = (f64::from(i) + 0.5) / f64::from(n);
            let y = (1.0 - (1.0 - x * x) / (eta * eta)).sqrt();
            let (s, p) = ((x - eta * y) / (x + eta * y), (eta * x - y) / (eta * x + y));
            x * (s * s + p * p) / f64::from(n)
        })
        .sum();
    let albedo = outside + (1.0 - outside) * share;
    let seen = ball(alpha, 500.0).render(json!({"max_depth": 100_000}), 200, 1).mean();
    agrees("half space", &seen, 1.0 - PI / 4.0 * (1.0 - albedo));
}

/// White matter under a white sky is white.
#[test]
fn white_matter_behind_glass_is_not_seen() {
    let seen = ball(1.0, 5.0).render(json!({"max_depth": 100_000, "roulette": "none"}), 40, 2);
    agrees("white", &seen.mean(), 1.0);
}
