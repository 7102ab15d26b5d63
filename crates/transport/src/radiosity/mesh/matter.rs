//! What an element reflects and emits.
//!
//! ```text
//! ρ = 1/π ∫∫ f_D(ωₒ,ωᵢ) |cos θᵢ| |cos θₒ| dωᵢ dωₒ,   mean over the element          (1)
//! E = π Lₑ,   mean over the element                                                 (2)
//! ```
//!
//! (1) is Lambert's albedo for Lambert's law; for other diffuse scattering, under a clear coat or of
//! rough surfaces, that of even light from everywhere.

use super::{Element, TIME};
use crate::radiosity::points::{r2, rotated};
use kaustika_math::{Frame, Vec3, warp};
use kaustika_scene::bsdf::{Bsdf, Lobes, Mode, Model};
use kaustika_scene::{Facet, Light, Scene};
use kaustika_spectra::{Spectrum, Wavelengths};
use std::f32::consts::PI;

/// Places on an element at which it is asked.
const PLACES: u32 = 4;
/// Pairs of directions of (1).
const PAIRS: u32 = 16;

/// Sets what an element of a facet reflects and emits; `glossy` if more than its matte part matters.
pub fn furnish(scene: &Scene, facet: &Facet, element: &mut Element, glossy: bool) {
    let mut lambda = Wavelengths::rgb();
    let mut bsdf = Bsdf::default();
    let (mut albedo, mut emission) = (Spectrum::ZERO, Spectrum::ZERO);
    for i in 0..PLACES {
        let b = warp::triangle(r2(i));
        let s = scene.geometry.on_facet(facet, element.place(b), TIME);
        let n = if element.back { -s.ng } else { s.ng };
        if let Some(Light::Area(light)) = s.light.map(|id| scene.light(id)) {
            emission += light.le(scene, &s, n, &lambda) * (PI / PLACES as f32); // (2)
        }
        if scene.bsdf_into(&s, n, &mut lambda, &mut bsdf) {
            albedo += albedo_at(&bsdf, n) / PLACES as f32;
            element.glossy |= glossy && bsdf.lobes().has(Lobes::GLOSSY_REFLECTION);
        }
    }
    (element.albedo, element.emission) = (albedo.clamp(0.0, 1.0), emission.clamp_zero());
}

/// (1) at one place, on the side of `n`.
fn albedo_at(bsdf: &Bsdf, n: Vec3) -> Spectrum {
    let diffuse = |wo: Vec3, wi: Vec3| {
        // Reflected light alone.
        match wo.dot(n) > 0.0 && wi.dot(n) > 0.0 {
            true => bsdf.eval(wo, wi, Mode::Radiance, Lobes::DIFFUSE_REFLECTION),
            false => Spectrum::ZERO,
        }
    };
    if !bsdf.lobes().has(Lobes::DIFFUSE_REFLECTION) {
        return Spectrum::ZERO;
    }
    let up = bsdf.shading_normal().face_forward(n);
    if bsdf.parts().iter().all(|p| matches!(p.model, Model::Diffuse(_))) {
        return diffuse(up, up) * PI;
    }
    let frame = Frame::from_normal(up);
    let along = |u| frame.to_world(warp::cosine_hemisphere(u));
    let mean = (0..PAIRS).fold(Spectrum::ZERO, |sum, i| {
        let (wo, wi) = (along(r2(i)), along(rotated(r2(i), 0x7061_6972)));
        sum + diffuse(wo, wi) * (PI / frame.n.abs_dot(wi).max(1e-4))
    });
    mean / PAIRS as f32
}
