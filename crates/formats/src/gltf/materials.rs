//! Materials: what they have in common, sides, coverage and emission.

use super::Reader;
use super::images::Images;
use super::json::{Fault, Json};
use super::textures::{Use, uv_set};
use kaustika_scene::description::{
    EmissionDesc, MaterialId, MaterialModel, MetallicRoughnessDesc, TangentSpace, TextureId,
    TextureNode,
};
use std::collections::HashMap;

/// A material with what belongs to the shape in the description.
#[derive(Clone, Debug)]
pub(super) struct Material {
    pub id: MaterialId,
    pub emission: Option<EmissionDesc>,
    pub alpha: Option<TextureId>,
}

/// The materials of a file, each made for the meshes that use it.
pub(super) struct Materials<'a> {
    list: Vec<Json<'a>>,
    pub textures: Vec<Json<'a>>,
    pub samplers: Vec<Json<'a>>,
    pub images: Images,
    /// By number, and whether the mesh has colours and alphas.
    built: HashMap<(Option<usize>, (bool, bool)), Material>,
}

/// The members of a material that are texture infos, those of extensions by their extension.
const SLOTS: &[(&str, &str)] = &[
    ("", "normalTexture"),
    ("KHR_materials_anisotropy", "anisotropyTexture"),
    ("pbrMetallicRoughness", "baseColorTexture"),
    ("pbrMetallicRoughness", "metallicRoughnessTexture"),
    ("", "emissiveTexture"),
    ("KHR_materials_clearcoat", "clearcoatTexture"),
    ("KHR_materials_clearcoat", "clearcoatRoughnessTexture"),
    ("KHR_materials_clearcoat", "clearcoatNormalTexture"),
    ("KHR_materials_diffuse_transmission", "diffuseTransmissionTexture"),
    ("KHR_materials_diffuse_transmission", "diffuseTransmissionColorTexture"),
    ("KHR_materials_iridescence", "iridescenceTexture"),
    ("KHR_materials_iridescence", "iridescenceThicknessTexture"),
    ("KHR_materials_pbrSpecularGlossiness", "diffuseTexture"),
    ("KHR_materials_pbrSpecularGlossiness", "specularGlossinessTexture"),
    ("KHR_materials_sheen", "sheenColorTexture"),
    ("KHR_materials_sheen", "sheenRoughnessTexture"),
    ("KHR_materials_specular", "specularTexture"),
    ("KHR_materials_specular", "specularColorTexture"),
    ("KHR_materials_transmission", "transmissionTexture"),
];

/// The part of a material that [`SLOTS`] names.
fn section<'a>(material: &Json<'a>, name: &str) -> Option<Json<'a>> {
    match name {
        "" => Some(material.clone()),
        "pbrMetallicRoughness" => material.get(name),
        extension => material.extension(extension),
    }
}

impl<'a> Materials<'a> {
    pub fn new(root: &Json<'a>, images: Images) -> Result<Materials<'a>, Fault> {
        Ok(Materials {
            list: root.list("materials")?,
            textures: root.list("textures")?,
            samplers: root.list("samplers")?,
            images,
            built: HashMap::new(),
        })
    }

    /// The materials as the file has them.
    pub fn list(&self) -> &[Json<'a>] {
        &self.list
    }

    /// The sets of texture coordinates that a material needs. The first is the one whose
    /// directions are the tangents: the normal map's, if there is one.
    pub fn uv_sets(&self, material: Option<usize>) -> Vec<usize> {
        let mut sets = Vec::new();
        let Some(material) = material.map(|i| &self.list[i]) else { return sets };
        for (part, slot) in SLOTS {
            let info = section(material, part).and_then(|s| s.get(slot));
            // A fault in it is told where the texture is made.
            if let Some(set) = info.and_then(|i| uv_set(&i).ok())
                && !sets.contains(&set)
            {
                sets.push(set);
            }
        }
        sets
    }
}

/// Makes one material.
pub(super) struct Maker<'r, 'm, 'a, 't> {
    pub reader: &'r mut Reader<'t>,
    materials: &'m mut Materials<'a>,
    /// The set of coordinates that is the mesh's own.
    main: usize,
    has_color: bool,
    has_alpha: bool,
}

impl Reader<'_> {
    /// A material by number, `None` for glTF's default, for a mesh with or without colours and
    /// alphas.
    pub(super) fn material(
        &mut self,
        index: Option<usize>,
        colors: (bool, bool),
        materials: &mut Materials,
    ) -> Material {
        if let Some(material) = materials.built.get(&(index, colors)) {
            return material.clone();
        }
        let main = materials.uv_sets(index).first().copied().unwrap_or(0);
        let json = match index {
            Some(i) => materials.list[i].clone(),
            None => Json::root(&serde_json::Value::Null),
        };
        let (has_color, has_alpha) = colors;
        let mut maker = Maker { reader: self, materials, main, has_color, has_alpha };
        let material = maker.material(&json).unwrap_or_else(|fault| {
            self.report(fault);
            let reflectance = self.out.float(0.5);
            let id = self.out.add_material("", MaterialModel::Diffuse { reflectance }, None);
            Material { id, emission: None, alpha: None }
        });
        materials.built.insert((index, colors), material.clone());
        material
    }
}

impl Maker<'_, '_, '_, '_> {
    pub(super) fn node(&mut self, node: TextureNode) -> TextureId {
        self.reader.out.add_texture(node, None)
    }

    pub(super) fn texture(&mut self, parent: &Json, key: &str, kind: Use) -> Option<TextureId> {
        let info = parent.get(key)?;
        self.reader.texture(&info, kind, self.main, self.materials)
    }

    /// A number, with the channel of a texture as a factor.
    pub(super) fn scalar(
        &mut self,
        parent: &Json,
        (key, default): (&str, f32),
        (texture, kind): (&str, Use),
    ) -> Result<TextureId, Fault> {
        let factor = self.reader.out.float(parent.float(key, default)?);
        let texture = self.texture(parent, texture, kind);
        Ok(self.reader.product(texture, factor))
    }

    pub(super) fn rgb(&mut self, rgb: [f32; 3]) -> TextureId {
        match rgb {
            [1.0, 1.0, 1.0] => self.reader.white(),
            rgb => self.reader.out.rgb(rgb),
        }
    }

    /// A colour, with a texture as a factor.
    pub(super) fn color(
        &mut self,
        parent: &Json,
        (key, default): (&str, [f32; 3]),
        texture: &str,
    ) -> Result<TextureId, Fault> {
        let factor = parent.floats(key, default)?;
        let factor = self.reader.out.rgb(factor);
        let texture = self.texture(parent, texture, Use::Color);
        Ok(self.reader.product(texture, factor))
    }

    /// The base colour and its alpha, `None` where that is 1: factors, texture, vertices.
    fn base(
        &mut self,
        parent: &Json,
        (key, texture): (&str, &str),
    ) -> Result<(TextureId, Option<TextureId>), Fault> {
        let [r, g, b, a] = parent.floats(key, [1.0; 4])?.map(|v| v.clamp(0.0, 1.0));
        let mut color = self.rgb([r, g, b]);
        let map = self.texture(parent, texture, Use::Color);
        color = self.reader.product(map, color);
        if self.has_color {
            let name = "vertex_color".into();
            let vertices = self.node(TextureNode::MeshAttribute { name, scale: 1.0 });
            color = self.reader.product(Some(vertices), color);
        }
        let mut alpha = (a != 1.0).then(|| self.reader.out.float(a));
        let mut multiply = |maker: &mut Self, other: Option<TextureId>| {
            let Some(other) = other else { return };
            alpha = Some(match alpha {
                Some(alpha) => maker.reader.product(Some(other), alpha),
                None => other,
            });
        };
        let map = self.texture(parent, texture, Use::Alpha);
        multiply(self, map);
        let vertices = self.has_alpha.then(|| {
            let name = "vertex_alpha".into();
            self.node(TextureNode::MeshAttribute { name, scale: 1.0 })
        });
        multiply(self, vertices);
        Ok((color, alpha))
    }

    fn material(&mut self, json: &Json) -> Result<Material, Fault> {
        let null = serde_json::Value::Null;
        let section = json.get("pbrMetallicRoughness").unwrap_or(Json::root(&null));
        let old = json.extension("KHR_materials_pbrSpecularGlossiness");
        let (base_color, alpha) = match &old {
            Some(old) => self.base(old, ("diffuseFactor", "diffuseTexture"))?,
            None => self.base(&section, ("baseColorFactor", "baseColorTexture"))?,
        };
        let double_sided = json.truth("doubleSided", false)?;
        let span = self.reader.span(json);
        let emission = if json.extension("KHR_materials_unlit").is_some() {
            Some(EmissionDesc {
                radiance: base_color,
                scale: 1.0,
                power: None,
                two_sided: true,
                along_normal: false,
                span,
            })
        } else {
            self.emission(json, double_sided)?
        };
        let id = if json.extension("KHR_materials_unlit").is_some() {
            let reflectance = self.reader.out.float(0.0);
            let model = MaterialModel::Diffuse { reflectance };
            let id = self.reader.out.add_material(json.name(), model, span);
            self.reader.unlit.push(id);
            id
        } else {
            let desc = match &old {
                Some(old) => self.specular_glossiness(old, base_color)?,
                None => self.metallic_roughness(json, &section, base_color)?,
            };
            self.with_sides(json, desc)?
        };
        let alpha = self.alpha(json, alpha)?;
        Ok(Material { id, emission, alpha })
    }

    /// The model under its normal map, reflecting on both sides if only reflecting.
    fn with_sides(
        &mut self,
        json: &Json,
        desc: MetallicRoughnessDesc,
    ) -> Result<MaterialId, Fault> {
        let span = self.reader.span(json);
        let passes = desc.transmission.is_some() || desc.diffuse_transmission.is_some();
        let model = MaterialModel::MetallicRoughness(Box::new(desc));
        let mut id = self.reader.out.add_material(json.name(), model, span);
        if let Some((normals, space)) = self.normals(json, "normalTexture")? {
            let model = MaterialModel::NormalMap { material: id, normals, space };
            id = self.reader.out.add_material(json.name(), model, span);
        }
        if !passes {
            let model = MaterialModel::TwoSided { front: id, back: id };
            id = self.reader.out.add_material(json.name(), model, span);
        }
        Ok(id)
    }

    pub(super) fn normals(
        &mut self,
        parent: &Json,
        key: &str,
    ) -> Result<Option<(TextureId, TangentSpace)>, Fault> {
        let Some(info) = parent.get(key) else { return Ok(None) };
        let scale = info.float("scale", 1.0)?;
        let texture = self.texture(parent, key, Use::Raw);
        Ok(texture.map(|t| (t, TangentSpace { scale, follows_v: true })))
    }

    fn emission(&mut self, json: &Json, two_sided: bool) -> Result<Option<EmissionDesc>, Fault> {
        let factor = json.floats("emissiveFactor", [0.0; 3])?;
        let scale = match json.extension("KHR_materials_emissive_strength") {
            Some(e) => e.float("emissiveStrength", 1.0)?,
            None => 1.0,
        };
        if factor.iter().all(|v| *v <= 0.0) || scale <= 0.0 {
            return Ok(None);
        }
        let radiance = self.color(json, ("emissiveFactor", [0.0; 3]), "emissiveTexture")?;
        let span = self.reader.span(json);
        Ok(Some(EmissionDesc {
            radiance,
            scale,
            power: None,
            two_sided,
            along_normal: false,
            span,
        }))
    }

    /// Coverage, `None` for a surface without holes.
    fn alpha(&mut self, json: &Json, alpha: Option<TextureId>) -> Result<Option<TextureId>, Fault> {
        let mode = json.string("alphaMode")?.unwrap_or("OPAQUE");
        match (mode, alpha) {
            ("OPAQUE", _) => Ok(None),
            ("BLEND", alpha) => Ok(alpha),
            ("MASK", None) => Ok(None),
            ("MASK", Some(texture)) => {
                let threshold = json.float("alphaCutoff", 0.5)?;
                Ok(Some(self.node(TextureNode::Step { texture, threshold })))
            }
            _ => Err(json.require("alphaMode")?.fault("expected OPAQUE, MASK or BLEND")),
        }
    }
}
