//! Diffraction gratings from textures.

use super::Hit;
use crate::bsdf::{Grating, GratingLight, GratingProfile};
use crate::description::{GratingDesc, GratingProfileDesc};
use kaustika_spectra::{ColorMode, Spectrum};

impl Hit<'_, '_> {
    /// The grating here. Every wavelength goes elsewhere: the path keeps only its hero.
    pub(super) fn grating<'a>(&mut self, desc: &'a GratingDesc) -> Grating<'a> {
        self.lambda.terminate_secondary();
        let reflectance = self.spectrum(desc.reflectance);
        let left = Spectrum::ONE - reflectance;
        Grating {
            period: desc.period,
            profile: match &desc.profile {
                GratingProfileDesc::Sinusoidal { depth, ior } => {
                    GratingProfile::Sinusoidal { depth: *depth, eta: *ior }
                }
                GratingProfileDesc::Efficiencies(list) => GratingProfile::Efficiencies(list),
            },
            reflectance,
            transmittance: self.spectrum(desc.transmittance).zip(left, f32::min).clamp_zero(),
            light: match self.lambda.mode {
                ColorMode::Rgb => GratingLight::Rgb,
                ColorMode::Spectral => GratingLight::Hero(self.lambda.lambda[0]),
            },
        }
    }
}
