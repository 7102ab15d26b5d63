//! From a scene to the light on its surfaces.

use super::form_factor::FormFactors;
use super::hierarchy::{Hierarchy, Refinement};
use super::mesh::Mesh;
use super::params::{DirectLight, RadiosityParams, Solver};
use super::shading::{Shading, Values};
use super::solve::{Patches, Shooting, direct, gauss_seidel, jacobi, shoot};
use super::sources::Sources;
use crate::method::RenderError;
use crate::workers::Workers;
use kaustika_math::Vec3;
use kaustika_scene::{Scene, Surface};
use kaustika_spectra::{ColorMode, Spectrum};

/// Patches beyond which a matrix does not fit.
const MOST_OF_A_MATRIX: usize = 20_000;
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
        let mut mesh = workers.install(|| Mesh::new(scene));
        if mesh.elements.iter().all(|e| e.is_black()) {
            let message = "there is nothing diffuse in this scene whose light radiosity could find";
            return Err(RenderError::Failed(message.into()));
        }
        let sources = Sources::new(scene, params.direct == DirectLight::Rays);
        workers.install(|| match params.solver {
            Solver::Hierarchical => Self::hierarchical(scene, mesh, sources, params, workers),
            _ => {
                mesh.divide_evenly(scene, params.patches as usize);
                Self::flat(scene, mesh, sources, params, workers)
            }
        })
    }

    /// Irradiance by patches at a surface, on the side of `w`, interpolated; and that by lights that
    /// are no patches.
    pub fn irradiance(&self, scene: &Scene, s: &Surface, w: Vec3) -> Option<[Spectrum; 2]> {
        let (leaf, b) = self.mesh.locate(scene, s, w)?;
        Some([&self.indirect, &self.direct].map(|values| self.shading.smooth(values, leaf, b)))
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
        let direct = sources.direct(&mesh, &leaves);
        let shading = Shading::new(scene, &mesh, &leaves);
        let direct = shading.values(direct);
        let indirect = shading.from_corners(solved.irradiance, &solved.corners);
        let links = solved.links;
        Ok(Solution { mesh, shading, direct, indirect, leaves, links, shots: 0 })
    }

    fn flat(
        scene: &Scene,
        mesh: Mesh,
        sources: Sources,
        params: &RadiosityParams,
        workers: &Workers,
    ) -> Result<Solution, RenderError> {
        let leaves = mesh.leaves();
        let by_lights = sources.direct(&mesh, &leaves);
        let patches = Patches::new(&mesh, &leaves, &by_lights, sources.emit());
        let ff =
            FormFactors::new(scene, &mesh, params.form_factors, params.samples(), params.extended);
        let shots = match params.shots {
            0 => usize::MAX,
            n => n as usize,
        };
        let (irradiance, shots) = if params.solver == Solver::Southwell {
            let (tolerance, ambient) = (params.tolerance, params.ambient);
            let row = |i| (!workers.cancelled()).then(|| ff.row(i));
            shoot(&patches, &Shooting { tolerance, shots, ambient }, row, |_| ())
                .ok_or(RenderError::Cancelled)?
        } else {
            if leaves.len() > MOST_OF_A_MATRIX {
                let message = format!(
                    "{} patches are too many for a matrix, which takes {MOST_OF_A_MATRIX}: lower \
                     `patches`, or set `solver` to southwell or hierarchical",
                    leaves.len()
                );
                return Err(RenderError::Failed(message));
            }
            let rows = ff.rows();
            if workers.cancelled() {
                return Err(RenderError::Cancelled);
            }
            let irradiance = match params.solver {
                Solver::Direct => direct(&rows, &patches),
                Solver::Jacobi => jacobi(&rows, &patches, params.tolerance),
                _ => gauss_seidel(&rows, &patches, params.tolerance),
            };
            (irradiance, 0)
        };
        let shading = Shading::new(scene, &mesh, &leaves);
        let (direct, indirect) = (shading.values(by_lights), shading.values(irradiance));
        Ok(Solution { mesh, shading, direct, indirect, leaves, links: 0, shots })
    }
}
