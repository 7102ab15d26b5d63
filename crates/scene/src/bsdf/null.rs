//! Nothing: light passes straight through. A boundary between media, or a place for a light.

use super::{BsdfSample, Lobes, Mode, Scatter};
use kaustika_math::{Vec2, Vec3};
use kaustika_spectra::Spectrum;

/// A surface that is not there. One Dirac lobe, [`Lobes::NULL`], of weight 1.
#[derive(Clone, Copy, Debug, Default)]
pub struct Null;

impl Scatter for Null {
    #[inline]
    fn eval(&self, _: Vec3, _: Vec3, _: Mode, _: Lobes) -> Spectrum {
        Spectrum::ZERO
    }

    #[inline]
    fn pdf(&self, _: Vec3, _: Vec3, _: Mode, _: Lobes) -> (f32, f32) {
        (0.0, 0.0)
    }

    #[inline]
    fn sample(&self, wo: Vec3, _: f32, _: Vec2, _: Mode, lobes: Lobes) -> Option<BsdfSample> {
        lobes.has(Lobes::NULL).then_some(BsdfSample {
            wi: -wo,
            weight: Spectrum::ONE,
            pdf: 1.0,
            pdf_rev: 1.0,
            eta: 1.0,
            lobe: Lobes::NULL,
        })
    }

    #[inline]
    fn albedo(&self, _: Vec3) -> Spectrum {
        Spectrum::ONE
    }

    #[inline]
    fn roughness(&self) -> f32 {
        0.0
    }

    #[inline]
    fn lobes(&self) -> Lobes {
        Lobes::NULL
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Expect, check_model};
    use super::*;

    #[test]
    fn nothing_changes_nothing() {
        let expect = Expect { both_sides: true, albedo: Some((1.0, 1e-6)), ..Expect::default() };
        check_model("null", &Null, expect);
    }
}
