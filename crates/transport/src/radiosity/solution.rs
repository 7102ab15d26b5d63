//! From a scene to the light on its surfaces.
//!
//! ```text
//! A (ρ (H_max - H_min))²   over the corners of a patch: divide where it is largest   (1)
//! B - E ← ρ (F (B - E) + F E + H_d)   by rays, thrice, after a hierarchy             (2)
//! ```
//!
//! (1) is about the square of what interpolation errs by; it is large along shadows and in corners
//! (adaptive subdivision, Cohen, Greenberg, Immel & Brock 1986). Coarse links lose a little light each where
//! what is hidden of a sender is darker than what is not; of that (2) leaves ρ³.

use super::form_factor::{FormFactorKind, FormFactors};
use super::glossy::Glossy;
use super::hierarchy::{Hierarchy, Refinement};
use super::mesh::Mesh;
use super::params::{DirectLight, RadiosityParams, Solver};
use super::polish::polished;
use super::shading::{Shading, Values};
use super::solve::{Patches, Shooting, direct, gauss_seidel, jacobi, shoot};
use super::sources::Sources;
use crate::method::RenderError;
use crate::workers::Workers;
use kaustika_math::Vec3;
use kaustika_scene::{Scene, Surface};
use kaustika_spectra::{ColorMode, Spectrum};
use rayon::prelude::*;

/// Form factors beyond which a matrix does not fit: some 3 GB.
const MOST_FORM_FACTORS: usize = 400_000_000;
/// Coarser meshes before an adapted one, each with half as many divisions as the next.
const ADAPTIONS: u32 = 2;
/// A last gathering's rays for each of the two before it, whose noise it evens out.
const FEW: u32 = 8;
/// Patches that a hierarchy begins with, as a part of all.
const FIRST: usize = 64;

/// The light on the surfaces of a scene.
#[derive(Debug)]
pub struct Solution {
    /// The patches.
    pub mesh: Mesh,
    /// Their vertices.
    pub shading: Shading,
    /// Irradiance by light that is no patch's, W/m².
    pub direct: Values,
    /// Irradiance by patches.
    pub indirect: Values,
    /// The mesh's leaves.
    pub leaves: Vec<u32>,
    /// How many links there are, of a hierarchy.
    pub links: usize,
    /// How many shots there were.
    pub shots: usize,
    /// What patches reflect by direction.
    pub glossy: Option<Glossy>,
}

impl Solution {
    /// Meshes and solves.
    ///
    /// # Errors
    /// If the scene is spectral, has no patches or too many for a matrix, or if cancelled.
    pub fn new(
        scene: &Scene,
        params: &RadiosityParams,
        workers: &Workers,
    ) -> Result<Solution, RenderError> {
        if scene.mode == ColorMode::Spectral {
            let message = "radiosity is in red, green and blue: leave out `--spectral`";
            return Err(RenderError::Failed(message.into()));
        }
        let mesh = workers.install(|| Mesh::new(scene, params.glossy > 0));
        if mesh.elements.iter().all(|e| e.is_black()) {
            let message = "there is nothing diffuse in this scene whose light radiosity could find";
            return Err(RenderError::Failed(message.into()));
        }
        let sources = Sources::new(scene, params.direct == DirectLight::Rays);
        let lit = mesh.elements.iter().filter(|e| !e.is_black()).count();
        let params = &params.of_scene(lit);
        workers.install(|| match params.solver {
            Solver::Hierarchical => Self::hierarchical(scene, mesh, sources, params, workers),
            _ => Self::flat(scene, mesh, sources, params, workers),
        })
    }

    /// Irradiance by patches at a surface, on the side of `w`, interpolated; and that by lights that
    /// are no patches.
    pub fn irradiance(&self, scene: &Scene, s: &Surface, w: Vec3) -> Option<[Spectrum; 2]> {
        let (leaf, b) = self.mesh.locate(scene, s, w)?;
        Some([&self.indirect, &self.direct].map(|values| self.shading.smooth(values, leaf, b)))
    }

    /// Says so if most of what could be divided is not: then large triangles are patches as they are.
    pub(super) fn coarseness(&self) -> Option<String> {
        let elements = &self.mesh.elements;
        let lit = |e: &&u32| !elements[**e as usize].is_black();
        let whole = (0..self.mesh.roots).filter(|e| lit(&e)).count();
        let patches = self.leaves.iter().filter(lit).count();
        (patches < 2 * whole).then(|| {
            format!(
                "{patches} patches on {whole} triangles and facets: few are divided, and light on large \
                 ones is coarse; set `patches` to several times {whole}"
            )
        })
    }

    fn hierarchical(
        scene: &Scene,
        mut mesh: Mesh,
        sources: Sources,
        params: &RadiosityParams,
        workers: &Workers,
    ) -> Result<Solution, RenderError> {
        let area: f32 = mesh.elements.iter().filter(|e| !e.is_black()).map(|e| e.area).sum();
        mesh.divide_evenly(scene, params.patches as usize / FIRST);
        let refinement = Refinement {
            error: params.error / params.patches as f32,
            area: area / params.patches as f32,
            tolerance: params.tolerance,
        };
        let mut hierarchy = Hierarchy::new(scene, &mut mesh, sources.clone());
        let solved = hierarchy.solve(&refinement, workers).ok_or(RenderError::Cancelled)?;
        let leaves = mesh.leaves();
        let direct =
            sources.direct_of_all(&mesh, &leaves, workers).ok_or(RenderError::Cancelled)?;
        let (mut irradiance, mut reflected) = (solved.irradiance, solved.reflected);
        let few = params.polish.div_ceil(FEW);
        for rays in [few, few, params.polish].into_iter().filter(|rays| *rays > 0) {
            irradiance = polished(scene, &mesh, (&leaves, &reflected), &sources, rays, workers)
                .ok_or(RenderError::Cancelled)?;
            let all = irradiance.iter().zip(&direct).map(|(a, b)| *a + *b).zip(&leaves);
            reflected = all.map(|(h, &e)| mesh.elements[e as usize].albedo * h).collect(); // (2)
        }
        let shading = Shading::new(scene, &mesh, &leaves);
        let (direct, indirect) = (shading.values(direct), shading.values(irradiance));
        let links = solved.links;
        Ok(Solution { mesh, shading, direct, indirect, leaves, links, shots: 0, glossy: None })
    }

    /// (1): a mesh of patches of one level; `adapt` finds out from coarser ones where it is to be fine.
    fn flat(
        scene: &Scene,
        mut mesh: Mesh,
        sources: Sources,
        params: &RadiosityParams,
        workers: &Workers,
    ) -> Result<Solution, RenderError> {
        let count = params.patches as usize;
        let rounds = if params.adapt { ADAPTIONS } else { 0 };
        // Of what can be divided at all: many scenes are hundreds of thousands of triangles as they are.
        let whole = mesh.roots as usize;
        let of_round = |round: u32| whole + (count.saturating_sub(whole) >> round);
        mesh.divide_evenly(scene, of_round(rounds));
        for round in (1..=rounds).rev() {
            let coarse = Self::level(scene, mesh, &sources, params, workers)?;
            let errs = coarse.errs();
            mesh = coarse.mesh;
            mesh.divide_worst(scene, of_round(round - 1), &errs);
        }
        Self::level(scene, mesh, &sources, params, workers)
    }

    /// (1) of the leaves.
    fn errs(&self) -> Vec<(u32, f32)> {
        let seen = |v: u32| {
            (self.indirect.vertices[v as usize] + self.direct.vertices[v as usize]).average()
        };
        let err = |(&leaf, corners): (&u32, &[u32; 3])| {
            let element = &self.mesh.elements[leaf as usize];
            let at = corners.map(seen);
            let spread = at.iter().copied().fold(0.0, f32::max)
                - at.iter().copied().fold(f32::INFINITY, f32::min);
            (leaf, element.area * (element.albedo.average() * spread).powi(2))
        };
        self.leaves.iter().zip(self.shading.corners()).map(err).collect()
    }

    fn level(
        scene: &Scene,
        mesh: Mesh,
        sources: &Sources,
        params: &RadiosityParams,
        workers: &Workers,
    ) -> Result<Solution, RenderError> {
        let leaves = mesh.leaves();
        let (kind, samples) = (params.form_factors, params.samples(leaves.len()));
        check_room(leaves.len(), samples, params)?;
        let by_lights =
            sources.direct_of_all(&mesh, &leaves, workers).ok_or(RenderError::Cancelled)?;
        let ff = FormFactors::new(scene, &mesh, kind, samples, params.extended);
        let uncancelled = || (!workers.cancelled()).then_some(());
        let told = |rows: usize| {
            workers.tell(|| format!("form factors of {rows} of {} patches", leaves.len()));
            uncancelled()
        };
        let by_mirrors = |lit: &dyn Fn() -> Option<Vec<Spectrum>>| match params.extended {
            true => lit().ok_or(RenderError::Cancelled),
            false => Ok(vec![Spectrum::ZERO; leaves.len()]),
        };
        let patches = |by_mirrors: &[Spectrum]| {
            let both: Vec<Spectrum> =
                by_lights.iter().zip(by_mirrors).map(|(a, b)| *a + *b).collect();
            Patches::new(&mesh, &leaves, &both, sources.emit())
        };
        let shading = Shading::new(scene, &mesh, &leaves);
        let mut glossy = None;
        let (mut irradiance, mirrored, shots) = if params.glossy > 0 {
            let none = vec![Spectrum::ZERO; leaves.len()];
            let how = (params.glossy, params.tolerance);
            let (h, found) = Glossy::solve(&ff, &patches(&none), &shading, how, workers)
                .ok_or(RenderError::Cancelled)?;
            glossy = Some(found);
            (h, none, 0)
        } else if params.solver == Solver::Southwell {
            let mirrored = by_mirrors(&|| ff.by_mirrors(!sources.emit(), told))?;
            let limit = if params.shots == 0 { usize::MAX } else { params.shots as usize };
            let (tolerance, ambient) = (params.tolerance, params.ambient);
            let shooting = Shooting { tolerance, shots: limit, ambient };
            let row = |i| (!workers.cancelled()).then(|| ff.row(i));
            let mut shots = 0;
            let each = |left: f32| {
                shots += 1;
                workers.tell(|| format!("{shots} shots, {:.2} % of the light left", 100.0 * left));
            };
            let (h, shots) =
                shoot(&patches(&mirrored), &shooting, row, each).ok_or(RenderError::Cancelled)?;
            (h, mirrored, shots)
        } else {
            let rows = ff.rows(told).ok_or(RenderError::Cancelled)?;
            let lit = || {
                let light = rows.par_iter().map(|row| ff.mirrored_light(row, !sources.emit()));
                Some(light.collect())
            };
            let mirrored = by_mirrors(&lit)?;
            let patches = patches(&mirrored);
            let h = match params.solver {
                Solver::Direct => {
                    direct(&rows, &patches, uncancelled).ok_or(RenderError::Cancelled)?
                }
                Solver::Jacobi => jacobi(&rows, &patches, params.tolerance),
                _ => gauss_seidel(&rows, &patches, params.tolerance),
            };
            let h = match (kind, params.polish) {
                (FormFactorKind::Rays, 1..) if sources.emit() && !params.extended => {
                    let all = patches.radiosity(&h).into_iter().zip(&leaves);
                    let reflected = all.map(|(b, &e)| b - mesh.elements[e as usize].emission);
                    let known = (&leaves[..], &reflected.collect::<Vec<_>>()[..]);
                    polished(scene, &mesh, known, sources, params.polish, workers)
                        .ok_or(RenderError::Cancelled)?
                }
                _ => h,
            };
            (h, mirrored, 0)
        };
        irradiance.iter_mut().zip(mirrored).for_each(|(h, m)| *h += m);
        let (direct, indirect) = (shading.values(by_lights), shading.values(irradiance));
        Ok(Solution { mesh, shading, direct, indirect, leaves, links: 0, shots, glossy })
    }
}

/// Refuses a matrix that does not fit.
fn check_room(patches: usize, samples: u32, params: &RadiosityParams) -> Result<(), RenderError> {
    if params.solver == Solver::Southwell {
        return Ok(());
    }
    // Rows by rays know no more patches than they have rays.
    let known = match (params.solver, params.form_factors) {
        (Solver::Jacobi | Solver::GaussSeidel, FormFactorKind::Rays) => samples as usize,
        _ => patches,
    };
    if patches * patches.min(known) <= MOST_FORM_FACTORS {
        return Ok(());
    }
    let most = (MOST_FORM_FACTORS as f64).sqrt() as usize;
    let most = most.max(MOST_FORM_FACTORS / known);
    let message = format!(
        "{patches} patches are too many for a matrix, which takes {most} here: set fewer \
         `samples` or `patches`, or `solver` to southwell or hierarchical"
    );
    Err(RenderError::Failed(message))
}
