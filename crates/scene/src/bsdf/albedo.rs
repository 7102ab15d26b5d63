//! Directional albedo of a reflecting microfacet surface, from small tables.
//!
//! With Schlick's F = F₀ + (1 - F₀)(1 - cos θ)⁵ the albedo is linear in F₀,
//!
//! ```text
//! E(μ) = F₀ A(μ, α) + B(μ, α),   A + B = albedo of an ideal mirror's facets      (1)
//! ```
//!
//! and A and B are tabulated over (μ, α) for each distribution and masking (Karis 2013, "Real
//! shading in Unreal Engine 4"; here for Smith's masking as [`Microfacet`] has it).

use super::fresnel::{fresnel_schlick, reflect};
use super::microfacet::{Masking, Microfacet};
use crate::description::Distribution;
use kaustika_math::{Vec2, Vec3};
use kaustika_spectra::Spectrum;
use std::sync::OnceLock;

/// Nodes along μ and along √α, both uniform on [0, 1].
const SIZE: usize = 16;
/// Points of the quadrature along each random number.
const POINTS: usize = 12;

type Table = [[[f32; 2]; SIZE]; SIZE];

static TABLES: [OnceLock<Box<Table>>; 4] = [const { OnceLock::new() }; 4];

/// Albedo of facets with reflectance `r0` at normal incidence, seen from `wo`, `wo.z` >= 0: (1).
/// Anisotropic surfaces count as isotropic ones ([`Microfacet::isotropic_alpha`]). Error by the tables about 0.02 up
/// to α = 1, beyond which α is clamped.
#[inline]
pub fn microfacet_albedo(surface: &Microfacet, r0: Spectrum, wo: Vec3) -> Spectrum {
    if surface.is_smooth() {
        return fresnel_schlick(wo.z, r0);
    }
    let [a, b] = microfacet_albedo_terms(surface, wo);
    r0 * a + Spectrum::splat(b)
}

/// A and B of (1) for a surface that is not smooth.
#[inline]
pub(super) fn microfacet_albedo_terms(surface: &Microfacet, wo: Vec3) -> [f32; 2] {
    let table = table(surface);
    let (i, s) = place(surface.isotropic_alpha(wo).sqrt());
    let (j, t) = place(wo.z);
    [0, 1].map(|c| {
        let row = |r: &[[f32; 2]; SIZE]| r[j][c] * (1.0 - t) + r[j + 1][c] * t;
        row(&table[i]) * (1.0 - s) + row(&table[i + 1]) * s
    })
}

/// Means of A and B over the hemisphere of a diffuse light, 2 ∫ A μ dμ: by Simpson's rule, exact
/// for the tables' interpolation.
pub(super) fn microfacet_mean_terms(surface: &Microfacet) -> [f32; 2] {
    let table = table(surface);
    let (i, s) = place(surface.alpha().sqrt());
    let h = 1.0 / (SIZE - 1) as f32;
    let mut mean = [0.0; 2];
    for j in 0..SIZE - 1 {
        for c in 0..2 {
            let at = |j: usize| table[i][j][c] * (1.0 - s) + table[i + 1][j][c] * s;
            let (low, high, mu) = (at(j), at(j + 1), j as f32 * h);
            let middle = 4.0 * 0.5 * (low + high) * (mu + 0.5 * h);
            mean[c] += 2.0 * h / 6.0 * (low * mu + middle + high * (mu + h));
        }
    }
    mean
}

/// The node below x in [0,1], and how far x is on the way to the next.
#[inline]
fn place(x: f32) -> (usize, f32) {
    let x = x.clamp(0.0, 1.0) * (SIZE - 1) as f32;
    let i = (x as usize).min(SIZE - 2);
    (i, x - i as f32)
}

/// The table of a surface's distribution and masking.
#[inline]
fn table(surface: &Microfacet) -> &'static Table {
    let (kind, masking) = (surface.kind(), surface.masking());
    let slot =
        2 * (kind == Distribution::Beckmann) as usize + (masking == Masking::Separable) as usize;
    TABLES[slot].get_or_init(|| tabulate(kind, masking))
}

fn tabulate(kind: Distribution, masking: Masking) -> Box<Table> {
    let mut table = Box::new([[[0.0; 2]; SIZE]; SIZE]);
    let node = |i: usize| i as f32 / (SIZE - 1) as f32;
    for (i, row) in table.iter_mut().enumerate() {
        let alpha = (node(i) * node(i)).max(Microfacet::SMOOTH);
        let surface = Microfacet::new(kind, alpha, alpha).with_masking(masking);
        for (j, entry) in row.iter_mut().enumerate() {
            let mu = node(j).max(1e-3);
            let wo = Vec3::new((1.0 - mu * mu).sqrt(), 0.0, mu);
            for k in 0..POINTS * POINTS {
                let u = Vec2::new((k % POINTS) as f32 + 0.5, (k / POINTS) as f32 + 0.5)
                    * (1.0 / POINTS as f32);
                let wm = surface.sample_visible(wo, u);
                let wi = reflect(wo, wm);
                if wi.z > 0.0 {
                    let weight = surface.g2_over_g1(wo, wi) / (POINTS * POINTS) as f32;
                    let fresnel = (1.0 - wo.dot(wm)).max(0.0).powi(5);
                    entry[0] += weight * (1.0 - fresnel);
                    entry[1] += weight * fresnel;
                }
            }
        }
    }
    table
}
