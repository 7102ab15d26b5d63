//! A light field on patches: progressive radiosity with extended form factors (Wallace, Cohen &
//! Greenberg 1987; Sillion & Puech 1989), of which each part is kept apart.
//!
//! ```text
//! H₀ ≈ 1/n Σ Lₑ V cos θ / p                       straight from lights                    (3)
//! H₁ = Σ_p Φ_p / A                                photons by way of mirrors and glass      (4)
//! H₂ = Σⱼ F_ij ρⱼ (H₀ + H₁ + H₂)ⱼ                  Southwell's iteration; F by D X* D       (5)
//! ```
//!
//! Nothing emits here: lights are asked for by rays and photons, so that light without extent is no
//! exception, and emission is in no part of the field.

use super::{HybridParams, Lamps};
use crate::frame::Frame;
use crate::method::{PassStats, RenderError};
use crate::particle::photon_map::Past;
use crate::particle::photon_map::field::Wanted;
use crate::path_space::Chain;
use crate::radiosity::form_factor::{FormFactorKind, FormFactors};
use crate::radiosity::mesh::Mesh;
use crate::radiosity::shading::{Shading, Values};
use crate::radiosity::solve::{Patches, Shooting, shoot};
use crate::radiosity::sources::Sources;
use crate::workers::Workers;
use kaustika_math::Vec3;
use kaustika_scene::{Scene, Surface};
use kaustika_spectra::Spectrum;

/// Photons that fall on patches, for each of a pass of a photon field.
const MORE_PHOTONS: u32 = 16;

/// The irradiance of patches.
#[derive(Debug)]
pub struct PatchField {
    mesh: Mesh,
    shading: Shading,
    /// H₀, H₁ and H₂.
    parts: [Values; 3],
    leaves: usize,
    shots: usize,
}

impl PatchField {
    /// Meshes and solves; light goes from patch to patch through `chain`.
    ///
    /// # Errors
    /// If nothing in the scene is diffuse, or if cancelled.
    pub(super) fn new(
        (scene, frame, lamps): (&Scene, &Frame, &Lamps),
        params: &HybridParams,
        chain: Chain,
        workers: &Workers,
    ) -> Result<PatchField, RenderError> {
        let mut mesh = workers.install(|| Mesh::new(scene, false));
        if mesh.elements.iter().all(|e| e.albedo.is_black()) {
            let message = "nothing in this scene is diffuse, so there are no patches for \
                           `radiosity@N`: leave such terms out, with `of` for what is left";
            return Err(RenderError::Failed(message.into()));
        }
        workers.install(|| mesh.divide_evenly(scene, params.patches as usize));
        let leaves = mesh.leaves();
        let sources = Sources::new(scene, true);
        let straight = workers.install(|| sources.direct_of_all(&mesh, &leaves, workers)); // (3)
        let straight = straight.ok_or(RenderError::Cancelled)?;
        let caustic = match chain == Chain::NONE {
            true => vec![Spectrum::ZERO; leaves.len()],
            false => {
                let count = params.photons.saturating_mul(MORE_PHOTONS);
                let pasts = &[Past::Straight, Past::Caustic];
                let wanted = Wanted { pasts, chain, count };
                caustics((scene, frame, lamps), &mesh, &leaves, &wanted, workers)?
            }
        };
        let lit: Vec<Spectrum> = straight.iter().zip(&caustic).map(|(a, b)| *a + *b).collect();
        let patches = Patches::new(&mesh, &leaves, &lit, false);
        let (kind, rays) = (FormFactorKind::Rays, params.form_rays);
        let factors = FormFactors::new(scene, &mesh, kind, rays, false).through(chain);
        let row = |i| (!workers.cancelled()).then(|| factors.row(i));
        let shooting = Shooting { tolerance: params.tolerance, shots: usize::MAX, ambient: false };
        let (reflected, shots) = shoot(&patches, &shooting, row, |_| ()) // (5)
            .ok_or(RenderError::Cancelled)?;
        let shading = Shading::new(scene, &mesh, &leaves);
        let parts = [straight, caustic, reflected].map(|h| shading.values(h));
        Ok(PatchField { leaves: leaves.len(), mesh, shading, parts, shots })
    }

    /// Irradiance at a surface on the side of `w`, of the light with these pasts; none on what has no
    /// patches.
    pub fn irradiance(&self, scene: &Scene, s: &Surface, w: Vec3, pasts: &[Past]) -> Spectrum {
        let Some((leaf, b)) = self.mesh.locate(scene, s, w) else { return Spectrum::ZERO };
        let part = |past: &Past| match past {
            Past::Straight => 0,
            Past::Caustic => 1,
            Past::Reflected => 2,
        };
        let parts = pasts.iter().map(|past| self.shading.smooth(&self.parts[part(past)], leaf, b));
        parts.fold(Spectrum::ZERO, |sum, h| sum + h)
    }

    /// Figures of it.
    pub(super) fn report(&self) -> Vec<(String, f64)> {
        vec![("patches".into(), self.leaves as f64), ("shots".into(), self.shots as f64)]
    }
}

/// (4).
fn caustics(
    (scene, frame, lamps): (&Scene, &Frame, &Lamps),
    mesh: &Mesh,
    leaves: &[u32],
    wanted: &Wanted,
    workers: &Workers,
) -> Result<Vec<Spectrum>, RenderError> {
    let mut number = vec![0; mesh.elements.len()];
    leaves.iter().enumerate().for_each(|(i, &e)| number[e as usize] = i);
    let patch = |s: &Surface, w: Vec3| mesh.locate(scene, s, w).map(|(e, _)| e);
    let stats = &mut PassStats::default();
    let fallen = lamps.deposited((scene, frame), wanted, patch, workers, stats)?;
    let mut h = vec![Spectrum::ZERO; leaves.len()];
    for (e, power) in fallen {
        h[number[e as usize]] += power / mesh.elements[e as usize].area;
    }
    Ok(h)
}
