//! `hair`: a fibre, coloured by absorption or by pigments.

use super::convert::Converter;
use super::document::Object;
use super::textures::Role;
use kaustika_scene::description::{
    FibreLayout, HairAbsorption, HairDesc, MaterialModel, TextureNode,
};

impl<'a> Converter<'a> {
    pub(super) fn hair(&mut self, object: &'a Object) -> MaterialModel {
        let pigments = object.has("eumelanin") || object.has("pheomelanin");
        if object.has("sigma_a") && pigments {
            let message =
                "`sigma_a` and the pigments `eumelanin`, `pheomelanin` exclude each other";
            self.out.diagnostics.error(object.span, message);
            object.ignore(&["eumelanin", "pheomelanin"]);
        }
        let absorption = if object.has("sigma_a") {
            let texture = self.texture(object, "sigma_a", 0.0, Role::Unbounded);
            let scale = self.number(object, "scale", 1.0);
            let scale = self.out.float(scale);
            let node = TextureNode::Scale { texture, scale };
            HairAbsorption::Coefficient(self.out.add_texture(node, None))
        } else {
            object.ignore(&["scale"]);
            HairAbsorption::Melanin {
                eumelanin: self.texture(object, "eumelanin", 1.3, Role::Scalar),
                pheomelanin: self.texture(object, "pheomelanin", 0.2, Role::Scalar),
            }
        };
        let eta = self.relative_ior(object, "amber");
        if eta == 1.0 {
            let message = "the indices of refraction inside and outside of hair must differ";
            self.out.diagnostics.error(object.span, message);
        }
        let roughness = |c: &mut Self, name: &'static str| {
            let value = c.number(object, name, 0.3);
            if !(0.0..=1.0).contains(&value) {
                let span = object.get(name).map(|p| p.value_span);
                c.out.diagnostics.error(span, format!("`{name}` must lie in [0, 1]"));
            }
            c.out.float(value)
        };
        MaterialModel::Hair(HairDesc {
            layout: FibreLayout::TubeAlongV,
            absorption,
            eta: self.out.float(eta),
            beta_m: roughness(self, "longitudinal_roughness"),
            beta_n: roughness(self, "azimuthal_roughness"),
            alpha: self.texture(object, "scale_tilt", 2.0, Role::Scalar),
        })
    }
}
