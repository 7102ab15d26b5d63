//! Parameters of radiosity.

use super::form_factor::FormFactorKind;
use crate::registry::{Parameter, count, positive};
use serde::Deserialize;

/// How the system is solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Solver {
    /// Hierarchical, but Jacobi's where most triangles are patches as they are ([`Solver::chosen`]).
    #[default]
    Auto,
    /// Links at many levels, refined where light asks for it.
    Hierarchical,
    /// The brightest patch shoots.
    Southwell,
    /// Gauss's elimination.
    Direct,
    /// All patches gather at once.
    Jacobi,
    /// One patch after the other gathers.
    GaussSeidel,
}

impl Solver {
    /// Which one it is, with so many triangles that are not black. A hierarchy pays where triangles are divided
    /// many times: its links stand for many pairs of patches each. Of triangles that are smaller than patches
    /// need be, it must link nearly each anyway, and rays from each are both cheaper and right.
    fn chosen(self, triangles: usize, patches: usize, by_rows: bool) -> Solver {
        match self {
            Solver::Auto if by_rows || triangles > patches => Solver::Jacobi,
            Solver::Auto => Solver::Hierarchical,
            solver => solver,
        }
    }
}

/// How the solution is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Display {
    /// Interpolated between vertices.
    #[default]
    Gouraud,
    /// Even over each patch.
    Constant,
    /// Gathered by rays from what is seen: patches are seen by way of it alone.
    Gather,
}

/// How light comes from lights to patches and to what is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DirectLight {
    /// By rays, wherever a pixel is.
    #[default]
    Rays,
    /// By patches that emit.
    Mesh,
}

/// Everything that can be set with `-p KEY=VALUE`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RadiosityParams {
    /// How the system is solved.
    pub solver: Solver,
    /// Patches; of the hierarchical solver as many as there would be if all were as small as its
    /// smallest.
    #[serde(deserialize_with = "count")]
    pub patches: u32,
    /// True: patches are small where light changes; not for the hierarchical solver, whose always are.
    pub adapt: bool,
    /// How form factors are found.
    pub form_factors: FormFactorKind,
    /// Samples of a row or a pair of form factors, cells across a hemicube; 0: by kind.
    pub samples: u32,
    /// How the solution is shown.
    pub display: Display,
    /// How light comes from the lights.
    pub direct: DirectLight,
    /// What iterations leave, as a part of all.
    #[serde(deserialize_with = "positive")]
    pub tolerance: f32,
    /// Power that a link may err by, as a part of what a patch has on average.
    #[serde(deserialize_with = "positive")]
    pub error: f32,
    /// Rays of each patch that gather once more at the end: of the hierarchical solver, and of matrices whose
    /// form factors are by rays, if lamps are patches; 0: none.
    pub polish: u32,
    /// Shots at most, 0 for no limit.
    pub shots: u32,
    /// True: what is not shot yet is shown as if it were even.
    pub ambient: bool,
    /// True: light goes from patch to patch by way of mirrors and glass too.
    pub extended: bool,
    /// Bands of spherical harmonics for what patches reflect by direction; 0: nothing.
    pub glossy: u32,
    /// Rays of a final gather.
    #[serde(deserialize_with = "count")]
    pub gather: u32,
    /// True: lights are not seen directly.
    pub hide_emitters: bool,
}

impl Default for RadiosityParams {
    fn default() -> Self {
        RadiosityParams {
            solver: Solver::Auto,
            patches: 20_000,
            adapt: false,
            form_factors: FormFactorKind::Rays,
            samples: 0,
            display: Display::Gouraud,
            direct: DirectLight::Rays,
            tolerance: 1e-3,
            error: 4e-3,
            polish: 512,
            shots: 0,
            ambient: false,
            extended: false,
            glossy: 0,
            gather: 4,
            hide_emitters: false,
        }
    }
}

impl RadiosityParams {
    /// Samples of form factors, of so many patches.
    pub fn samples(&self, patches: usize) -> u32 {
        let usual = self.form_factors.samples();
        match (self.samples, self.form_factors) {
            (0, FormFactorKind::Rays) => usual.min((MOST_RAYS / patches.max(1)).max(64) as u32),
            (0, _) => usual,
            (n, _) => n,
        }
    }

    /// With the solver that it is, of a scene with so many triangles that are not black.
    #[must_use]
    pub fn of_scene(&self, triangles: usize) -> RadiosityParams {
        let by_rows = self.extended || self.glossy > 0;
        let solver = self.solver.chosen(triangles, self.patches as usize, by_rows);
        RadiosityParams { solver, ..self.clone() }
    }

    /// What does not go together.
    ///
    /// # Errors
    /// Says what, and what to do.
    pub fn check(&self) -> Result<(), String> {
        let by_rays = self.form_factors == FormFactorKind::Rays;
        if self.extended && (self.solver == Solver::Hierarchical || !by_rays) {
            let message = "extended form factors are found by rays, row by row: set `solver` to \
                           southwell, direct, jacobi or gauss-seidel, and `form_factors` to rays";
            return Err(message.into());
        }
        let iterates = matches!(self.solver, Solver::Auto | Solver::Jacobi | Solver::GaussSeidel);
        let fits = iterates && by_rays && self.direct == DirectLight::Mesh && !self.extended;
        if self.glossy > 0 && !fits {
            let message = "glossy radiosity iterates over rays between patches, lamps among them: set \
                           `solver` to jacobi, `direct` to mesh and `form_factors` to rays, without \
                           `extended`";
            return Err(message.into());
        }
        if self.glossy > MOST_BANDS {
            return Err(format!("`glossy` is at most {MOST_BANDS} bands of harmonics"));
        }
        self.check_unused()
    }

    /// What the solver would take no notice of.
    fn check_unused(&self) -> Result<(), String> {
        let matrix = "southwell, direct, jacobi or gauss-seidel";
        let d = RadiosityParams::default();
        let is = |solver: Solver| self.solver == solver;
        let (auto, hierarchical, southwell) =
            (is(Solver::Auto), is(Solver::Hierarchical), is(Solver::Southwell));
        for (key, is_set, is_used, solvers) in [
            ("shots", self.shots > 0, southwell, "southwell"),
            ("ambient", self.ambient, southwell, "southwell"),
            ("form_factors", self.form_factors != d.form_factors, !hierarchical && !auto, matrix),
            ("samples", self.samples > 0, !hierarchical, matrix),
            ("polish", self.polish > 0 && self.polish != d.polish, !southwell, "any other"),
            ("error", self.error != d.error, hierarchical || auto, "hierarchical"),
        ] {
            if is_set && !is_used {
                return Err(format!(
                    "this `solver` takes no notice of `{key}`: set `solver` to {solvers}"
                ));
            }
        }
        let gathers = self.display == Display::Gather;
        if self.gather != d.gather && !gathers {
            return Err("`gather` is for `display=gather`".into());
        }
        Ok(())
    }
}

/// Rays of all rows of form factors, where nobody says how many.
const MOST_RAYS: usize = 100_000_000;
/// Bands that glossy radiosity takes at most.
const MOST_BANDS: u32 = 12;

/// The parameters with their defaults and meanings.
pub fn parameters() -> Vec<Parameter> {
    let d = RadiosityParams::default();
    let p = |key, default: String, help| Parameter { key, default, help };
    vec![
        p(
            "solver",
            "auto".into(),
            "auto (hierarchical; jacobi where there are more triangles than `patches`), hierarchical, southwell \
             (progressive shooting), direct, jacobi, gauss-seidel",
        ),
        p(
            "patches",
            d.patches.to_string(),
            "patches; for `hierarchical` as if all were as small as the smallest may be",
        ),
        p(
            "adapt",
            d.adapt.to_string(),
            "patches are small where light changes; `hierarchical` always does so",
        ),
        p("form_factors", "rays".into(), "rays, area, analytic, hemicube; not for `hierarchical`"),
        p(
            "samples",
            d.samples.to_string(),
            "rays of a row, points of a pair, cells across a hemicube; 0: 1024 (of more than 97,000 patches fewer), 4, 256",
        ),
        p("display", "gouraud".into(), "gouraud, constant, gather (final gathering)"),
        p(
            "direct",
            "rays".into(),
            "light of lights by rays, or by a mesh whose patches emit: rays, mesh",
        ),
        p("tolerance", d.tolerance.to_string(), "what iterations leave, as a part of all light"),
        p(
            "error",
            d.error.to_string(),
            "power that a link may err by, as a part of all light over `patches` (`hierarchical`)",
        ),
        p(
            "polish",
            d.polish.to_string(),
            "rays of a patch that gather once more at the end; 0: none; not for `southwell`",
        ),
        p("shots", d.shots.to_string(), "shots at most (`southwell`); 0 no limit"),
        p(
            "ambient",
            d.ambient.to_string(),
            "what is not shot yet is shown as if it were even (`southwell`)",
        ),
        p(
            "extended",
            d.extended.to_string(),
            "light goes by way of mirrors and glass too; not for `hierarchical`",
        ),
        p(
            "glossy",
            d.glossy.to_string(),
            "bands of harmonics by which patches reflect by direction; needs `direct=mesh`",
        ),
        p("gather", d.gather.to_string(), "rays of a final gather"),
        p("hide_emitters", d.hide_emitters.to_string(), "lights are not seen directly"),
    ]
}
