//! Fibres from textures.

use super::{Hit, Place};
use crate::bsdf::{
    Across, EUMELANIN, Hair, HairParameters, Model, PHEOMELANIN, Part, absorption_of_color,
};
use crate::description::{FibreLayout, HairAbsorption, HairDesc};
use crate::texture::uplift;
use kaustika_math::Frame;
use kaustika_spectra::{Spectrum, SpectrumRole};

impl Hit<'_, '_> {
    /// The fibre here, in its own frame: its first tangent runs from root to tip.
    pub(super) fn hair<'a>(&self, desc: &HairDesc, place: &Place) -> Part<'a> {
        let (dpdu, dpdv) = self.geometry.tangents(self.surface);
        let (along, across) = match desc.layout {
            FibreLayout::TubeAlongV => (dpdv, Across::Normal),
            FibreLayout::RibbonAlongU => {
                // v grows towards +y, or away from it where the surface is turned over.
                let t = Frame::from_normal_tangent(place.frame.n, dpdu).t;
                let turned = (t.dot(dpdv) < 0.0) != place.back;
                let offset = (2.0 * self.surface.uv.y - 1.0).clamp(-1.0, 1.0);
                (dpdu, Across::Offset(if turned { -offset } else { offset }))
            }
        };
        let beta_n = self.float(desc.beta_n);
        let hair = Hair::new(HairParameters {
            across,
            eta: self.float(desc.eta).max(1e-3),
            sigma_a: self.absorption(&desc.absorption, beta_n),
            beta_m: self.float(desc.beta_m),
            beta_n,
            alpha: self.float(desc.alpha).to_radians(),
        });
        let frame = Frame::from_normal_tangent(place.frame.n, along);
        Place { frame, ..*place }.part(Model::Hair(hair), place.weight)
    }

    fn absorption(&self, absorption: &HairAbsorption, beta_n: f32) -> Spectrum {
        match absorption {
            HairAbsorption::Coefficient(id) => self.spectrum(*id),
            HairAbsorption::Color(id) => absorption_of_color(self.spectrum(*id), beta_n),
            HairAbsorption::Melanin { eumelanin, pheomelanin } => {
                let (e, p) = (self.float(*eumelanin).max(0.0), self.float(*pheomelanin).max(0.0));
                let rgb = std::array::from_fn(|i| e * EUMELANIN[i] + p * PHEOMELANIN[i]);
                uplift(SpectrumRole::Unbounded, rgb, self.lambda)
            }
        }
    }
}
