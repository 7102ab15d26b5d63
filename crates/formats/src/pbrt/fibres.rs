//! `hair`: a fibre, coloured by absorption, by a colour or by pigments.

use super::build::Builder;
use super::entity::Entity;
use kaustika_scene::description::{FibreLayout, HairAbsorption, HairDesc, MaterialModel};

impl Builder {
    pub(super) fn hair(&mut self, e: &mut Entity) -> MaterialModel {
        let absorption = self.hair_absorption(e);
        MaterialModel::Hair(HairDesc {
            layout: FibreLayout::RibbonAlongU,
            absorption,
            eta: self.float_texture(e, "eta", 1.55),
            beta_m: self.float_texture(e, "beta_m", 0.3),
            beta_n: self.float_texture(e, "beta_n", 0.3),
            alpha: self.float_texture(e, "alpha", 2.0),
        })
    }

    /// The first of `sigma_a`, a colour and pigments that is given; brown if none is.
    fn hair_absorption(&mut self, e: &mut Entity) -> HairAbsorption {
        let sigma_a = self.spectrum_texture_or_none(e, "sigma_a");
        let color = self.albedo_or_none(e, "reflectance");
        let eumelanin = self.float_texture_or_none(e, "eumelanin");
        let pheomelanin = self.float_texture_or_none(e, "pheomelanin");
        let pigments = eumelanin.is_some() || pheomelanin.is_some();
        let given = [sigma_a.is_some(), color.is_some(), pigments];
        if given.iter().filter(|g| **g).count() > 1 {
            let used = if sigma_a.is_some() { "sigma_a" } else { "reflectance" };
            let message = format!("hair has more than one colour, `{used}` is used");
            self.desc.diagnostics.warning(e.kind.span, message);
        }
        match (sigma_a, color) {
            (Some(t), _) => HairAbsorption::Coefficient(t),
            (None, Some(t)) => HairAbsorption::Color(t),
            (None, None) => {
                let default = if pigments { 0.0 } else { 1.3 };
                HairAbsorption::Melanin {
                    eumelanin: eumelanin.unwrap_or_else(|| self.desc.float(default)),
                    pheomelanin: pheomelanin.unwrap_or_else(|| self.desc.float(0.0)),
                }
            }
        }
    }
}
