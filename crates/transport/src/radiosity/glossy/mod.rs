//! Glossy radiosity: what patches send by direction (Sillion, Arvo, Westin & Greenberg 1991).
//!
//! ```text
//! L_j(ω) = E_j/π + ρ_j H_j/π + G_j(ω),   G_j(ω) = Σ_k c_jk Y_k(ω)                       (1)
//! H_i    = π/n Σ_r L_j(r)(-d_r)                                                       (2)
//! G_i(ω) = 1/n Σ_r π f_S(ω, d_r) L_j(r)(-d_r)                                          (3)
//! c_ik   = Σ_s w_s G_i(ω_s) [Y_k(ω_s) + Y_k(ω̄_s)]                                      (4)
//! ```
//!
//! The matte part of a patch is one number, as ever; what it reflects otherwise is a sum of real spherical
//! harmonics Y up to a band. d_r are cosine-distributed rays from points of patch i, which meet patch j(r);
//! ω_s are directions above the patch, by Gauss and Legendre's rule in the cosine and even in azimuth (points
//! scattered over the hemisphere, as many, erred by 12 %), and ω̄_s their mirror images below: G is continued below the
//! surface as it is above, or harmonics would ring at the horizon that they cannot follow. (2) and (3) are
//! iterated together. Mirrors and clear glass, which have no f_S, are left to extended form factors.

mod harmonics;

use self::harmonics::Harmonics;
use super::form_factor::FormFactors;
use super::shading::Shading;
use super::solve::{Patches, Rest, sum};
use crate::workers::Workers;
use kaustika_math::quadrature::gauss_legendre;
use kaustika_math::{Frame, Vec3};
use kaustika_scene::Scene;
use kaustika_scene::bsdf::{Bsdf, Lobes, Mode};
use kaustika_spectra::{Spectrum, Wavelengths};
use rayon::prelude::*;
use std::f32::consts::PI;

/// Iterations at most.
const MOST: u32 = 100;
/// Azimuths of ω_s for each band; there are as many cosines as bands.
const AZIMUTHS: u32 = 3;

/// What patches send by direction, beyond their matte part.
#[derive(Debug)]
pub struct Glossy {
    harmonics: Harmonics,
    /// c of the mesh's vertices, those of each together.
    at_vertices: Vec<Spectrum>,
}

/// A ray from a patch: where it goes, and the patch that it meets.
type Ray = (Vec3, u32);

impl Glossy {
    /// Irradiance of the patches, and (1). `None` if cancelled.
    pub fn solve(
        ff: &FormFactors,
        patches: &Patches,
        shading: &Shading,
        (bands, tolerance): (u32, f32),
        workers: &Workers,
    ) -> Option<(Vec<Spectrum>, Glossy)> {
        let harmonics = Harmonics::new(bands);
        let rule = rule(bands);
        let (n, terms) = (ff.len(), harmonics.count());
        let rays: Vec<Vec<Ray>> = (0..n).into_par_iter().map(|i| ff.rays_of(i)).collect();
        let mut h = vec![Spectrum::ZERO; n];
        let mut c = vec![Spectrum::ZERO; n * terms];
        let mut rest = Rest::default();
        for iteration in 0..MOST {
            workers.tell(|| format!("glossy radiosity: iteration {iteration}"));
            if workers.cancelled() {
                return None;
            }
            let matte = patches.radiosity(&h);
            let seen = |(d, j): &Ray| match *j {
                u32::MAX => Spectrum::ZERO,
                j => {
                    let c = &c[j as usize * terms..][..terms];
                    matte[j as usize] / PI + harmonics.value(c, -*d).clamp_zero() // (1)
                }
            };
            let next: Vec<(Spectrum, Vec<Spectrum>)> = (0..n)
                .into_par_iter()
                .map(|i| {
                    let light: Vec<Spectrum> = rays[i].iter().map(seen).collect();
                    let mean = light.iter().fold(Spectrum::ZERO, |s, l| s + *l);
                    let lobe = lobe(ff, i, (&rays[i], &light), (&harmonics, &rule));
                    (mean * (PI / ff.samples() as f32), lobe) // (2)
                })
                .collect();
            let (mut change, mut all) = (0.0, 0.0);
            for (i, (new, lobe)) in next.into_iter().enumerate() {
                let area = f64::from(patches.area[i]);
                change += area * sum(new - h[i]);
                all += area * sum(new);
                h[i] = new;
                c[i * terms..][..terms].copy_from_slice(&lobe);
            }
            if rest.is_within(change, all, tolerance) {
                break;
            }
        }
        let at_vertices = shading.means(&c, terms);
        Some((h, Glossy { harmonics, at_vertices }))
    }

    /// G of (1) toward `wo`, interpolated between the vertices of a leaf.
    pub fn radiance(&self, shading: &Shading, leaf: u32, b: [f32; 3], wo: Vec3) -> Spectrum {
        let terms = self.harmonics.count();
        let corners = shading.corners_of(leaf).into_iter().zip(b);
        let value = corners.fold(Spectrum::ZERO, |sum, (v, b)| {
            sum + self.harmonics.value(&self.at_vertices[v as usize * terms..][..terms], wo) * b
        });
        value.clamp_zero()
    }
}

/// ω_s and w_s of (4), about +z.
fn rule(bands: u32) -> Vec<(Vec3, f32)> {
    let azimuths = AZIMUTHS * bands;
    let around = |(z, w): (f64, f64)| {
        let (z, w) = (z as f32, w as f32 * 2.0 * PI / azimuths as f32);
        let r = (1.0 - z * z).max(0.0).sqrt();
        (0..azimuths).map(move |k| {
            let (s, c) = (2.0 * PI * (k as f32 + 0.5) / azimuths as f32).sin_cos();
            (Vec3::new(r * c, r * s, z), w)
        })
    };
    gauss_legendre(bands as usize).into_iter().flat_map(around).collect()
}

/// (3) and (4) of patch `i`, whose rays bring this light.
fn lobe(
    ff: &FormFactors,
    i: usize,
    (rays, light): (&[Ray], &[Spectrum]),
    (harmonics, rule): (&Harmonics, &[(Vec3, f32)]),
) -> Vec<Spectrum> {
    let mut c = vec![Spectrum::ZERO; harmonics.count()];
    let element = ff.element(i);
    if !element.glossy {
        return c;
    }
    let scene: &Scene = ff.scene;
    let n = element.normal;
    let s = ff.mesh.surface(scene, ff.patches[i], [1.0 / 3.0; 3]);
    let (mut lambda, mut bsdf) = (Wavelengths::rgb(), Bsdf::default());
    if !scene.bsdf_into(&s, n, &mut lambda, &mut bsdf) {
        return c;
    }
    let frame = Frame::from_normal(n);
    for &(local, weight) in rule {
        let wo = frame.to_world(local);
        let terms = rays.iter().zip(light).filter(|(_, l)| !l.is_black());
        let g = terms.fold(Spectrum::ZERO, |sum, ((d, _), l)| {
            let f = bsdf.eval(wo, *d, Mode::Radiance, Lobes::GLOSSY_REFLECTION);
            sum + f * *l * (PI / n.dot(*d).max(1e-3))
        }) / ff.samples() as f32; // (3)
        let below = wo - n * (2.0 * n.dot(wo));
        harmonics.add(&mut c, wo, g * weight); // (4)
        harmonics.add(&mut c, below, g * weight);
    }
    c
}
