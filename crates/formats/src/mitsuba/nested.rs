//! Materials made of other materials.

use super::convert::{Converter, old};
use super::document::{Kind, Object};
use super::textures::Role;
use super::values;
use kaustika_scene::description::{MaterialId, MaterialModel, TangentSpace, TextureId};

impl<'a> Converter<'a> {
    pub(super) fn nested_model(&mut self, object: &'a Object) -> MaterialModel {
        match object.plugin.as_str() {
            "mask" => MaterialModel::Mask {
                opacity: self.texture(object, "opacity", 0.5, Role::Scalar),
                material: self.only_nested(object),
            },
            "twosided" => self.two_sided(object),
            "bumpmap" | "bump" => MaterialModel::Bump {
                material: self.only_nested(object),
                scale: self.number(object, "scale", 1.0),
                displacement: self.nested_texture(object, Role::Scalar),
            },
            "normalmap" => {
                object.ignore(&["flip_invalid_normals", "use_shadowing_function"]);
                let material = self.only_nested(object);
                let normals = match object.has("normalmap") && !old(object) {
                    true => self.texture(object, "normalmap", 0.5, Role::Data),
                    false => self.nested_texture(object, Role::Data),
                };
                MaterialModel::NormalMap { material, normals, space: TangentSpace::default() }
            }
            "blendbsdf" => {
                let parts = self.nested_exactly(object, 2);
                if !object.has("weight") && !old(object) {
                    let message = "bsdf `blendbsdf` needs `weight`";
                    self.out.diagnostics.error(object.span, message);
                }
                let amount = self.texture(object, "weight", 0.5, Role::Scalar);
                MaterialModel::Mix { a: parts[0], b: parts[1], amount }
            }
            "mixturebsdf" => self.mixture(object),
            _ => self.coating(object),
        }
    }

    /// Exactly `count` nested materials; missing ones are an error and grey.
    fn nested_exactly(&mut self, object: &'a Object, count: usize) -> Vec<MaterialId> {
        let mut parts = self.nested_materials(object);
        if parts.len() != count {
            let message = format!(
                "bsdf `{}` needs {count} bsdf{} inside, found {}",
                object.plugin,
                if count == 1 { "" } else { "s" },
                parts.len()
            );
            self.out.diagnostics.error(object.span, message);
        }
        while parts.len() < count {
            parts.push(self.default_material(false));
        }
        parts
    }

    fn only_nested(&mut self, object: &'a Object) -> MaterialId {
        self.nested_exactly(object, 1)[0]
    }

    /// The one texture inside, whatever its name.
    fn nested_texture(&mut self, object: &'a Object, role: Role) -> TextureId {
        object.ignore(&["flip_invalid_normals", "use_shadowing_function"]);
        match self.child(object, Kind::Texture) {
            Some((_, id)) => self.texture_object(id, role),
            None => {
                let message = format!("bsdf `{}` needs a texture inside", object.plugin);
                self.out.diagnostics.error(object.span, message);
                self.out.float(0.5)
            }
        }
    }

    fn two_sided(&mut self, object: &'a Object) -> MaterialModel {
        let allowed = self.boolean(object, "allow_transmission", false);
        let parts = self.nested_materials(object);
        let (front, back) = match parts.as_slice() {
            [one] => (*one, *one),
            [front, back] => (*front, *back),
            _ => {
                let message =
                    format!("bsdf `twosided` needs one or two bsdfs inside, found {}", parts.len());
                self.out.diagnostics.error(object.span, message);
                let grey = self.default_material(false);
                (grey, grey)
            }
        };
        if !allowed && [front, back].iter().any(|m| self.transmits(*m)) {
            self.out
                .diagnostics
                .error(object.span, "bsdf `twosided` can't hold a material that transmits")
                .hint("use the inner material as it is");
        }
        MaterialModel::TwoSided { front, back }
    }

    /// True if light passes through the material.
    fn transmits(&self, id: MaterialId) -> bool {
        use MaterialModel as M;
        match &self.out.materials[id.0 as usize].model {
            M::Dielectric { .. }
            | M::ThinDielectric { .. }
            | M::DiffuseTransmission { .. }
            | M::Hair(_)
            | M::Grating(_)
            | M::Filter { .. }
            | M::Null { .. }
            | M::Mask { .. } => true,
            M::Bump { material, .. } | M::NormalMap { material, .. } => self.transmits(*material),
            M::Mix { a, b, .. } => self.transmits(*a) || self.transmits(*b),
            M::Sum { parts } => parts.iter().any(|(_, m)| self.transmits(*m)),
            _ => false,
        }
    }

    /// Mitsuba 0.6's weighted sum; weights beyond 1 in sum are scaled down to 1.
    fn mixture(&mut self, object: &'a Object) -> MaterialModel {
        let materials = self.nested_materials(object);
        let Some((text, span)) = self.string(object, "weights") else {
            if !object.has("weights") {
                self.out.diagnostics.error(object.span, "bsdf `mixturebsdf` needs `weights`");
            }
            return self.grey();
        };
        let words = text.split(|c: char| c.is_whitespace() || ",;".contains(c));
        let weights: Result<Vec<f32>, String> =
            words.filter(|w| !w.is_empty()).map(|w| values::number(w).map(|v| v as f32)).collect();
        let weights = match weights {
            Ok(weights) => weights,
            Err(message) => {
                self.out.diagnostics.error(span, message);
                return self.grey();
            }
        };
        if weights.len() != materials.len() {
            let message = format!("{} weights for {} bsdfs", weights.len(), materials.len());
            self.out.diagnostics.error(span, message);
            return self.grey();
        }
        let sum: f32 = weights.iter().sum();
        if weights.iter().any(|w| *w < 0.0) || sum <= 0.0 {
            self.out.diagnostics.error(span, "weights must be positive");
            return self.grey();
        }
        let scale = if sum > 1.0 { 1.0 / sum } else { 1.0 };
        let parts = weights.iter().zip(materials).map(|(w, m)| (w * scale, m)).collect();
        MaterialModel::Sum { parts }
    }

    /// True if a coat can lie over the material.
    fn coatable(&self, id: MaterialId) -> bool {
        use MaterialModel as M;
        match &self.out.materials[id.0 as usize].model {
            M::Diffuse { .. }
            | M::Conductor { .. }
            | M::OrenNayar { .. }
            | M::Phong { .. }
            | M::Ward { .. }
            | M::Plastic { .. } => true,
            M::Bump { material, .. } | M::NormalMap { material, .. } => self.coatable(*material),
            M::TwoSided { front, back } => self.coatable(*front) && self.coatable(*back),
            M::Mix { a, b, .. } => self.coatable(*a) && self.coatable(*b),
            M::Sum { parts } => parts.iter().all(|(_, m)| self.coatable(*m)),
            _ => false,
        }
    }

    /// A coat over what is inside; left off where that can't be coated.
    fn coating(&mut self, object: &'a Object) -> MaterialModel {
        let inner = self.only_nested(object);
        if !self.coatable(inner) {
            let message =
                format!("`{}` over this kind of material is not supported", object.plugin);
            let warning = self.out.diagnostics.warning(object.type_span, message);
            warning.label("the material inside is used without its coat");
            self.replaced_silently(object);
            return self.out.materials[inner.0 as usize].model.clone();
        }
        let roughness = (object.plugin == "roughcoating").then(|| self.roughness(object, true));
        MaterialModel::Coating {
            material: inner,
            ior: self.relative_ior(object, "bk7"),
            sigma_a: self.texture(object, "sigma_a", 0.0, Role::Unbounded),
            thickness: self.number(object, "thickness", 1.0).max(0.0),
            specular_reflectance: self.texture(
                object,
                "specular_reflectance",
                1.0,
                Role::Reflectance,
            ),
            roughness,
        }
    }
}
