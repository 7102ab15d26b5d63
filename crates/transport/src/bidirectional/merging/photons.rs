//! The light's vertices of a pass, kept small for merging.

use super::grid::HashGrid;
use super::recursion::Carried;
use kaustika_film::path_expression::Back;
use kaustika_math::Vec3;
use kaustika_spectra::Spectrum;

/// Where light arrived.
#[derive(Clone, Copy, Debug)]
pub(super) struct Photon {
    pub(super) p: Vec3,
    /// Unit direction to where it came from.
    pub(super) wo: Vec3,
    /// Flux, over the density of the path.
    pub(super) beta: Spectrum,
    /// For its weight.
    pub(super) vcm: f32,
    pub(super) vm: f32,
    /// Surfaces met, this one included.
    pub(super) depth: u32,
    /// True if only the hero wavelength is left.
    pub(super) dispersed: bool,
}

impl Photon {
    /// The weight's numbers.
    pub(super) fn carried(&self) -> Carried {
        Carried { vcm: self.vcm, vc: 0.0, vm: self.vm }
    }
}

/// All photons of a pass.
#[derive(Debug, Default)]
pub(super) struct Photons {
    all: Vec<Photon>,
    /// The classes of each one's path, if there are layers of them.
    classes: Vec<Vec<(Back, Spectrum)>>,
    grid: HashGrid,
    radius2: f32,
}

impl Photons {
    pub(super) fn new(
        all: Vec<Photon>,
        classes: Vec<Vec<(Back, Spectrum)>>,
        radius: f32,
    ) -> Photons {
        let grid = HashGrid::new(all.len(), radius, |i| all[i].p);
        Photons { all, classes, grid, radius2: radius * radius }
    }

    /// The classes of a photon's path.
    pub(super) fn back(&self, number: u32) -> &[(Back, Spectrum)] {
        &self.classes[number as usize]
    }

    /// Calls `each` with the photons within the radius of `p`, and their numbers.
    #[inline]
    pub(super) fn near(&self, p: Vec3, mut each: impl FnMut(u32, &Photon)) {
        self.grid.near(p, |i| {
            let photon = &self.all[i as usize];
            if (photon.p - p).length_squared() < self.radius2 {
                each(i, photon);
            }
        });
    }
}
