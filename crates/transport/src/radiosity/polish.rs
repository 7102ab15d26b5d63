//! A last gathering at the finest level, which takes off what coarse links, or few rays to small lamps, err
//! by (the local pass of Lischinski, Tampieri & Greenberg 1993, with rays).
//!
//! ```text
//! H_i ≈ 1/n Σ_r (B_j(r) - E_j(r)) + π/n Σ_r w_r Lₑ(r) + 1/m Σ_s w_s Lₑ V cos θ / p_s          (1)
//! w = n p_r/(n p_r + m p_s) or m p_s/(n p_r + m p_s),   p_r = cos θ / π                     (2)
//! ```
//!
//! n cosine-distributed rays r from points of a patch find what other patches reflect; what lamps emit is
//! found by them and by m points s of lamps, weighted by the balance heuristic (Veach & Guibas 1995).

use super::form_factor::{FormFactorKind, FormFactors};
use super::mesh::Mesh;
use super::sources::{Rivals, Sources};
use crate::workers::Workers;
use kaustika_math::Vec3;
use kaustika_scene::{Light, RayBatch, Scene, Surface};
use kaustika_spectra::{Spectrum, Wavelengths};
use rayon::prelude::*;
use std::f32::consts::PI;
use std::sync::atomic::{AtomicUsize, Ordering};

/// n for each point of lamps, n/m.
const PART: u32 = 4;

/// (1) of some leaves, of which is known what they reflect. `None` if cancelled.
pub fn polished(
    scene: &Scene,
    mesh: &Mesh,
    (leaves, reflected): (&[u32], &[Spectrum]),
    sources: &Sources,
    rays: u32,
    workers: &Workers,
) -> Option<Vec<Spectrum>> {
    let ff = FormFactors::new(scene, mesh, FormFactorKind::Rays, rays, false);
    let rivals = Rivals { rays, points: rays.div_ceil(PART) };
    let done = AtomicUsize::new(0);
    let gathered = (0..leaves.len()).into_par_iter().map_init(RayBatch::default, |batch, i| {
        let number = done.fetch_add(1, Ordering::Relaxed) + 1;
        workers.tell(|| format!("gathering: {number} of {} patches", leaves.len()));
        let mut h = Spectrum::ZERO;
        if !mesh.elements[leaves[i] as usize].albedo.is_black() {
            let segments = ff.segments(i);
            scene.hit_all(&segments, batch);
            for (k, segment) in segments.iter().enumerate() {
                let (o, d) = (segment.ray.o, segment.ray.d);
                let Some(hit) = batch.hit(k) else { continue };
                let s = scene.geometry.surface(&hit, &segment.ray);
                if let Some(j) = ff.patch_at(&s, -d) {
                    h += reflected[j as usize] / rays as f32;
                }
                if sources.emit() {
                    let n = mesh.elements[leaves[i] as usize].normal;
                    h += emitted(scene, &s, (o, n, d), rivals) * (PI / rays as f32);
                }
            }
        }
        (!workers.cancelled()).then_some(h)
    });
    let mut gathered = gathered.collect::<Option<Vec<Spectrum>>>()?;
    if sources.emit() {
        let asked = sources.of_areas(mesh, leaves, rivals);
        gathered.iter_mut().zip(asked).for_each(|(h, e)| *h += e);
    }
    Some(gathered)
}

/// w_r Lₑ of what a ray along `d` from a place with this normal has met.
fn emitted(
    scene: &Scene,
    s: &Surface,
    (from, n, d): (Vec3, Vec3, Vec3),
    rivals: Rivals,
) -> Spectrum {
    let Some(id) = s.light.filter(|&id| matches!(scene.light(id), Light::Area(_))) else {
        return Spectrum::ZERO;
    };
    let le = scene.light(id).le(scene, s, -d, &Wavelengths::rgb());
    if le.is_black() {
        return le;
    }
    let asked = scene.light_selection.pmf(from, n, id) * scene.light(id).pdf_li(scene, from, s, d);
    le * (1.0 - rivals.of_points(asked, n.dot(d)))
}
