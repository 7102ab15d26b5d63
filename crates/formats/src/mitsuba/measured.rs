//! Materials that were measured: Mitsuba 3's `measured` and `measured_polarized`.

use super::convert::Converter;
use super::document::Object;
use kaustika_scene::description::{MaterialModel, MeasuredPolarizedDesc};

impl<'a> Converter<'a> {
    pub(super) fn measured(&mut self, object: &'a Object) -> MaterialModel {
        let Some((path, span)) = self.file(object, "filename") else { return self.grey() };
        match self.measured.read(&path) {
            Ok(brdf) => MaterialModel::Measured(brdf),
            Err(cause) => {
                let message = format!("can't read the measured material: {cause}");
                self.out.diagnostics.error(span, message);
                self.grey()
            }
        }
    }

    pub(super) fn measured_polarized(&mut self, object: &'a Object) -> MaterialModel {
        let alpha = self.number(object, "alpha_sample", 0.1).clamp(1e-4, 1.0);
        // -1 means all that were measured.
        let wavelength = Some(self.number(object, "wavelength", -1.0)).filter(|w| *w != -1.0);
        let Some((path, span)) = self.file(object, "filename") else { return self.grey() };
        match self.measured.read_polarized(&path) {
            Ok(table) => {
                MaterialModel::MeasuredPolarized(MeasuredPolarizedDesc { table, alpha, wavelength })
            }
            Err(cause) => {
                let message = format!("can't read the measured material: {cause}");
                self.out.diagnostics.error(span, message);
                self.grey()
            }
        }
    }
}
