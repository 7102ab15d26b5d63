//! Which part of a height field is seen and lit.
//!
//! ```text
//! V(x, ω) = 1 if ω is above the horizon at x in its azimuth                                (1)
//! G(ωₒ, ωᵢ) = Σ V(x, ωₒ) V(x, ωᵢ) a(x, ωₒ) a(x, ωᵢ) / Σ a(x, ωₒ) a(x, ωᵢ)                   (2)
//! G ≤ cos θ/σ(ω) of either direction                                                       (3)
//! ρ(ωₒ) = ∫ P(s) G(ωₒ, ωᵢ(s)) max(0, ωₒ·(-s, 1)) ds / cos θₒ                                (4)
//! ```
//!
//! Horizons are Max's (1988, "Horizon mapping"), of some places x, in all azimuths; a = max(0, ω·(-s, 1)), the
//! facet's projected area. (4) is the albedo of white mirrors. (2) knows that what is high is seen and lit alike: shadows hide behind facets
//! when light comes from where the eye is. (3) keeps the energy: what is seen of all facets is cos θ of the
//! surface (Heitz 2014, eq. 13); the table, which is bilinear in both directions, might be more.

use super::Heights;
use super::slopes::Slopes;
use crate::bsdf::fresnel::reflect;
use kaustika_math::{Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::{FRAC_PI_2, PI};

/// Places of which horizons are known.
const PLACES: usize = 4096;
/// Directions of the table of (2): angles from the normal, the denser the nearer to the horizon, and azimuths.
const PAIRS: [usize; 2] = [17, 16];
/// Directions of σ.
const FACING: [usize; 2] = [65, 32];
/// Directions of (4).
const ALBEDO: [usize; 2] = [33, 16];
/// Cosine by which the albedo along the surface is told.
const GRAZING: f32 = 0.01;
/// Steps from node to node of the field, up to this part of what was gone already.
const STRIDE: f32 = 1.0 / 16.0;

/// What is known of shadows.
#[derive(Debug)]
pub(super) struct Shadows {
    /// (2), a row for each direction.
    pairs: Vec<f32>,
    /// σ.
    facing: Vec<f32>,
    albedo: Vec<f32>,
}

/// Four nodes of a grid of directions, and what each counts.
type Around = [(usize, f32); 4];

/// A direction among `angles` from the normal, whose distances to the horizon are squares, and `azimuths`, which
/// run faster.
fn around([angles, azimuths]: [usize; 2], w: Vec3) -> Around {
    let theta = w.z.clamp(0.0, 1.0).acos();
    let theta = (1.0 - (1.0 - theta / FRAC_PI_2).max(0.0).sqrt()) * (angles - 1) as f32;
    let phi = (w.y.atan2(w.x) / (2.0 * PI)).rem_euclid(1.0) * azimuths as f32;
    let i = (theta as usize).min(angles - 2);
    let (t, p) = (theta - i as f32, phi - phi.floor());
    let j = phi as usize % azimuths;
    let k = (j + 1) % azimuths;
    let at = |i: usize, j: usize| i * azimuths + j;
    [
        (at(i, j), (1.0 - t) * (1.0 - p)),
        (at(i, k), (1.0 - t) * p),
        (at(i + 1, j), t * (1.0 - p)),
        (at(i + 1, k), t * p),
    ]
}

/// The direction of a node.
fn direction([angles, azimuths]: [usize; 2], k: usize) -> Vec3 {
    let theta = FRAC_PI_2 * (1.0 - (1.0 - (k / azimuths) as f32 / (angles - 1) as f32).powi(2));
    let (s, c) = (2.0 * PI * (k % azimuths) as f32 / azimuths as f32).sin_cos();
    Vec3::new(theta.sin() * c, theta.sin() * s, theta.cos())
}

fn mean(table: &[f32], around: Around) -> f32 {
    around.into_iter().map(|(k, weight)| weight * table[k]).sum()
}

/// Places spread evenly over the square (Roberts 2018).
pub(super) fn places() -> impl Iterator<Item = Vec2> {
    let at = |i: usize, a: f64| (0.5 + i as f64 * a).fract() as f32;
    (0..PLACES)
        .map(move |i| Vec2::new(at(i, 0.754_877_666_246_692_8), at(i, 0.569_840_290_998_053_3)))
}

/// The tangent of the horizon's elevation along `w`, at a place.
pub(super) fn horizon(heights: &Heights, uv: Vec2, w: Vec2) -> f32 {
    let step = 1.0 / heights.n as f32;
    let (here, highest) = (heights.look(uv).0, heights.highest);
    let (mut t, mut most) = (0.5 * step, f32::NEG_INFINITY);
    // Nothing farther than this is above it.
    while (highest - here) > most.max(1e-3) * t {
        most = most.max((heights.look(uv + w * t).0 - here) / t);
        t += step.max(STRIDE * t);
    }
    most
}

impl Shadows {
    pub(super) fn new(heights: &Heights, slopes: &Slopes) -> Shadows {
        let places: Vec<(Vec2, Vec2)> = places().map(|uv| (uv, heights.look(uv).1)).collect();
        let [angles, azimuths] = PAIRS;
        let count = angles * azimuths;
        // a, and V a, of each direction at each place.
        let (mut all, mut open) = (vec![0.0; count * PLACES], vec![0.0; count * PLACES]);
        for j in 0..azimuths {
            let (s, c) = (2.0 * PI * j as f32 / azimuths as f32).sin_cos();
            for (x, &(uv, slope)) in places.iter().enumerate() {
                let horizon = horizon(heights, uv, Vec2::new(c, s));
                for i in 0..angles {
                    let k = i * azimuths + j;
                    let w = direction(PAIRS, k);
                    let area = (w.z - slope.x * w.x - slope.y * w.y).max(0.0);
                    all[k * PLACES + x] = area;
                    let above = w.z > horizon * w.x.hypot(w.y); // (1)
                    open[k * PLACES + x] = if above { area } else { 0.0 };
                }
            }
        }
        let dot = |table: &[f32], a: usize, b: usize| -> f32 {
            let of = |k: usize| &table[k * PLACES..][..PLACES];
            of(a).iter().zip(of(b)).map(|(x, y)| x * y).sum()
        };
        let mut pairs = vec![0.0; count * count];
        for a in 0..count {
            for b in 0..=a {
                let g = dot(&open, a, b) / dot(&all, a, b).max(f32::MIN_POSITIVE); // (2)
                (pairs[a * count + b], pairs[b * count + a]) = (g, g);
            }
        }
        let facing = (0..FACING[0] * FACING[1]).map(|k| slopes.facing(direction(FACING, k)));
        let mut shadows = Shadows { pairs, facing: facing.collect(), albedo: Vec::new() };
        let albedo = |k| {
            let mut wo = direction(ALBEDO, k);
            wo.z = wo.z.max(GRAZING);
            let reflected = |s: Vec2| {
                let m = Vec3::new(-s.x, -s.y, 1.0);
                let wi = reflect(wo, m.normalize());
                if wi.z > 0.0 { shadows.open(wo, wi) * wo.dot(m).max(0.0) / wo.z } else { 0.0 }
            };
            slopes.mean(reflected) // (4)
        };
        shadows.albedo = (0..ALBEDO[0] * ALBEDO[1]).into_par_iter().map(albedo).collect();
        shadows
    }

    /// (4).
    pub(super) fn albedo(&self, wo: Vec3) -> f32 {
        mean(&self.albedo, around(ALBEDO, wo))
    }

    /// G.
    pub(super) fn open(&self, wo: Vec3, wi: Vec3) -> f32 {
        let count = PAIRS[0] * PAIRS[1];
        let (a, b) = (around(PAIRS, wo), around(PAIRS, wi));
        let row = |k: usize| mean(&self.pairs[k * count..][..count], b);
        let g: f32 = a.into_iter().map(|(k, weight)| weight * row(k)).sum();
        g.min(self.seen(wo)).min(self.seen(wi)) // (3)
    }

    /// cos θ/σ(ω): the part of the facets that face ω that is seen from there.
    pub(super) fn seen(&self, w: Vec3) -> f32 {
        (w.z / mean(&self.facing, around(FACING, w)).max(f32::MIN_POSITIVE)).min(1.0)
    }
}
