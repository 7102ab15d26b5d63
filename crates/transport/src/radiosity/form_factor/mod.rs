//! Form factors: the part of the power that leaves patch i evenly and falls on patch j.
//!
//! ```text
//! F_ij = 1/A_i ∫_Ai ∫_Aj V cos θ_i cos θ_j / (π r²) dA_j dA_i                       (1)
//! A_i F_ij = A_j F_ji,   Σⱼ F_ij = 1 in a closed scene                              (2)
//! ```
//!
//! (Goral et al. 1984.) Four ways to find a row: rays from the patch (`rays`), points of both patches
//! (`pairs`), Lambert's formula with rays that ask what hides (`pairs` too), a hemicube (`hemicube`).

pub mod hemicube;
mod pairs;
pub mod polygon;
mod rays;
mod windows;

use self::windows::Windows;
use super::mesh::{Element, Mesh, Point};
use super::points::{r2, rotated};
use crate::path_space::Chain;
use kaustika_math::mix_bits;
use kaustika_scene::Scene;
use kaustika_spectra::Spectrum;
use rayon::prelude::*;
use serde::Deserialize;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How form factors are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FormFactorKind {
    /// Cosine-distributed rays from the patch: rows that sum to 1, and mirrors and glass.
    #[default]
    Rays,
    /// Pairs of points (Wallace et al. 1989).
    Area,
    /// Lambert's formula, times the visible part.
    Analytic,
    /// Item buffers around the patch's middle (Cohen & Greenberg 1985).
    Hemicube,
}

impl FormFactorKind {
    /// Samples a row or a pair, or cells across, where nobody says.
    pub fn samples(self) -> u32 {
        match self {
            FormFactorKind::Rays => 1024,
            FormFactorKind::Area | FormFactorKind::Analytic => 4,
            FormFactorKind::Hemicube => 256,
        }
    }
}

/// Form factors from one patch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Patches that are seen, in rising order, and F_ij.
    pub seen: Vec<(u32, f32)>,
    /// Patches that are seen by way of mirrors and glass, in rising order, and what of it comes back.
    pub mirrored: Vec<(u32, Spectrum)>,
    /// Irradiance by what surrounds the scene, by way of mirrors and glass, W/m².
    pub outside: Spectrum,
}

impl Row {
    /// F_ij of each patch, those of mirrors added.
    pub fn each(&self, mut f: impl FnMut(usize, Spectrum)) {
        self.seen.iter().for_each(|&(j, x)| f(j as usize, Spectrum::splat(x)));
        self.mirrored.iter().for_each(|&(j, x)| f(j as usize, x));
    }

    /// Σⱼ F_ij.
    pub fn sum(&self) -> f32 {
        let mirrored: f32 =
            self.mirrored.iter().map(|(_, x)| x.rgb().iter().sum::<f32>() / 3.0).sum();
        self.seen.iter().map(|(_, x)| x).sum::<f32>() + mirrored
    }
}

/// The patches of a mesh, and how their form factors are found.
pub struct FormFactors<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The patches: its leaves.
    pub patches: Vec<u32>,
    kind: FormFactorKind,
    samples: u32,
    /// What rays are followed through.
    chain: Chain,
    /// Of the mesh's elements, their number among the patches.
    number: Vec<u32>,
    /// Points of the patches, some of each, for pairs.
    points: Vec<Point>,
    /// Where light of the surroundings comes in by way of mirrors and glass.
    windows: Option<Windows>,
}

impl<'a> FormFactors<'a> {
    /// For the leaves of a mesh; `extended` follows rays through mirrors and glass.
    pub fn new(
        scene: &'a Scene,
        mesh: &'a Mesh,
        kind: FormFactorKind,
        samples: u32,
        extended: bool,
    ) -> FormFactors<'a> {
        let patches = mesh.leaves();
        let mut number = vec![u32::MAX; mesh.elements.len()];
        for (i, &e) in patches.iter().enumerate() {
            number[e as usize] = i as u32;
        }
        let points = match kind {
            FormFactorKind::Area | FormFactorKind::Analytic => patches
                .par_iter()
                .flat_map_iter(|&e| {
                    let key = mix_bits(u64::from(e));
                    (0..samples).map(move |k| mesh.sample(scene, e, rotated(r2(k), key)))
                })
                .collect(),
            FormFactorKind::Rays | FormFactorKind::Hemicube => Vec::new(),
        };
        let chain = if extended { Chain::ANY } else { Chain::NONE };
        let windows = None;
        let mut ff =
            FormFactors { scene, mesh, patches, kind, samples, chain, number, points, windows };
        ff.windows = (extended && !scene.environments.is_empty()).then(|| Windows::learn(&ff));
        ff
    }

    /// Follows rays through this.
    pub fn through(self, chain: Chain) -> FormFactors<'a> {
        FormFactors { chain, ..self }
    }

    /// How many patches there are.
    pub fn len(&self) -> usize {
        self.patches.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.patches.is_empty()
    }

    /// F_ij of patch `i` to all others.
    pub fn row(&self, i: usize) -> Row {
        match self.kind {
            FormFactorKind::Rays => self.by_rays(i),
            FormFactorKind::Area | FormFactorKind::Analytic => self.by_pairs(i),
            FormFactorKind::Hemicube => self.by_hemicube(i),
        }
    }

    /// Samples of a row or a pair.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Patch `i`.
    pub fn element(&self, i: usize) -> &Element {
        &self.mesh.elements[self.patches[i] as usize]
    }

    /// All rows; `each` is told how many there are already. `None` if it says `None`.
    pub fn rows(&self, each: impl Fn(usize) -> Option<()> + Sync) -> Option<Vec<Row>> {
        let done = AtomicUsize::new(0);
        let row = |i| {
            each(done.fetch_add(1, Ordering::Relaxed))?;
            Some(self.row(i))
        };
        (0..self.len()).into_par_iter().map(row).collect()
    }

    /// Irradiance of all patches that is no patch's radiosity and that lights, asked for, never give:
    /// by way of mirrors and glass from what surrounds the scene, and from patches that emit, if so.
    /// `each` as in [`FormFactors::rows`].
    pub fn by_mirrors(
        &self,
        emitters: bool,
        each: impl Fn(usize) -> Option<()> + Sync,
    ) -> Option<Vec<Spectrum>> {
        let done = AtomicUsize::new(0);
        let lit = |i| {
            each(done.fetch_add(1, Ordering::Relaxed))?;
            Some(self.mirrored_light(&self.row(i), emitters))
        };
        (0..self.len()).into_par_iter().map(lit).collect()
    }

    /// Of one row: (2) of `rays` over what emits.
    pub fn mirrored_light(&self, row: &Row, emitters: bool) -> Spectrum {
        let emitted = row.mirrored.iter().filter(|_| emitters);
        emitted.fold(row.outside, |sum, &(j, f)| sum + f * self.element(j as usize).emission)
    }

    /// Areas of the patches.
    pub fn areas(&self) -> Vec<f32> {
        self.patches.iter().map(|&e| self.mesh.elements[e as usize].area).collect()
    }
}
