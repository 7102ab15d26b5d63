//! What a path through media finds, shared by the lanes.

use super::super::walk::{Previous, Walk};
use super::Flight;
use kaustika_spectra::Spectrum;

impl Flight<'_> {
    /// A choice of probability `p` that shadow rays need not make; β knows of it already.
    pub(super) fn pass_with(&mut self, p: f32) {
        self.shares.other *= 1.0 / p;
    }

    /// The previous vertex with the density that gives (5).
    pub(super) fn seen_from(&self, previous: &Previous) -> Previous {
        Previous { pdf_w: previous.pdf_w / self.shares.mean(self.shares.other), ..*previous }
    }

    /// Adds what a path has found.
    #[inline]
    pub(super) fn add(&mut self, walk: &mut Walk, found: Spectrum) {
        self.add_by(walk, found, self.shares.path);
    }

    /// Adds what was found in another way, in which the lanes have these shares.
    #[inline]
    pub(super) fn add_by(&mut self, walk: &mut Walk, found: Spectrum, shares: Spectrum) {
        add_alone(&mut walk.radiance, &mut self.alone, found, shares);
    }

    /// After a surface: if it has ended the secondary wavelengths, lane 0 is alone from now on.
    /// The other lanes can't make up any more for the share that they took.
    #[inline]
    pub(super) fn follow(&mut self, walk: &mut Walk) {
        let k = 1.0 / self.shares.path[0];
        if self.shares.end_secondary(&walk.lambda) {
            walk.beta *= k;
            self.shares.other *= k;
        }
    }

    /// At the path's end.
    pub(super) fn settle(&self, walk: &mut Walk) {
        if self.shares.alone() {
            walk.radiance = Spectrum([self.alone, 0.0, 0.0, 0.0]);
        }
    }
}

/// Adds what was found to what all lanes found and to what lane 0 alone would have.
#[inline]
pub(super) fn add_alone(
    radiance: &mut Spectrum,
    alone: &mut f32,
    found: Spectrum,
    shares: Spectrum,
) {
    *radiance += found;
    if found[0] > 0.0 && shares[0] > 0.0 {
        *alone += found[0] / shares[0];
    }
}
