//! `Material`: kinds and their parameters (pbrt-v4, materials.cpp).

use super::build::Builder;
use super::entity::{Entity, NameRef};
use super::param::ParamType;
use super::upgrade_material::OPACITY;
use kaustika_scene::description::{
    BitmapChannels, BitmapFilter, BitmapTexture, CoatDesc, ConductorColor, Distribution, Encoding,
    IorDesc, MaterialId, MaterialModel, RoughnessDesc, TangentSpace, TextureId, TextureMapping,
    TextureNode, Wrap,
};
use kaustika_spectra::{ColorSpace, SpectrumDesc};

const KINDS: [&str; 12] = [
    "coatedconductor",
    "coateddiffuse",
    "conductor",
    "dielectric",
    "diffuse",
    "diffusetransmission",
    "hair",
    "interface",
    "measured",
    "mix",
    "subsurface",
    "thindielectric",
];

impl Builder {
    /// The material an entity means; the default one, and an error, if it is none.
    pub fn material(&mut self, e: &mut Entity, name: &str) -> MaterialId {
        let (model, inside) = match e.kind.text.as_str() {
            "subsurface" => self.subsurface(e),
            _ => (self.model(e), None),
        };
        let Some(model) = model else {
            e.params.ignore_rest();
            return self.default_material();
        };
        let interface = matches!(model, MaterialModel::Null { .. });
        let plain = matches!(model, MaterialModel::Mix { .. }) || interface;
        let inside = match &model {
            MaterialModel::Mix { a, b, .. } => {
                [a, b].into_iter().find_map(|part| self.insides.get(part).copied())
            }
            _ => inside,
        };
        let mut id = self.desc.add_material(name, model, Some(e.span));
        if !plain {
            id = self.shading_frame(e, name, id);
        }
        if e.params.has(OPACITY) {
            let opacity = self.albedo(e, OPACITY, 1.0);
            let mask = MaterialModel::Mask { material: id, opacity };
            id = self.desc.add_material(name, mask, Some(e.span));
        }
        // As pbrt-v4 does, for materials made from those of other kinds.
        if interface {
            e.params.ignore_rest();
        }
        if let Some(medium) = inside {
            self.insides.insert(id, medium);
        }
        let what = format!("material `{}`", e.kind.text);
        e.params.report_unused(&mut self.desc.diagnostics, &what);
        id
    }

    /// `displacement` and `normalmap`; of both, pbrt uses the normal map.
    fn shading_frame(&mut self, e: &mut Entity, name: &str, material: MaterialId) -> MaterialId {
        let displacement = self.float_texture_or_none(e, "displacement");
        let map = e.params.string(&mut self.desc.diagnostics, "normalmap");
        let model = if let Some(map) = map {
            let Some(bitmap) = self.image_with(&map, Encoding::Linear) else { return material };
            let node = TextureNode::Bitmap(BitmapTexture {
                bitmap,
                channels: BitmapChannels::Color,
                filter: BitmapFilter::Bilinear,
                wrap: [Wrap::Repeat; 2],
                mapping: TextureMapping::default(),
                scale: 1.0,
                invert: false,
                raw: true,
                space: ColorSpace::Srgb,
            });
            let normals = self.desc.add_texture(node, Some(map.span));
            MaterialModel::NormalMap { material, normals, space: TangentSpace::default() }
        } else if let Some(displacement) = displacement {
            MaterialModel::Bump { material, displacement, scale: 1.0 }
        } else {
            return material;
        };
        self.desc.add_material(name, model, Some(e.span))
    }

    fn model(&mut self, e: &mut Entity) -> Option<MaterialModel> {
        Some(match e.kind.text.as_str() {
            "diffuse" => MaterialModel::Diffuse { reflectance: self.albedo(e, "reflectance", 0.5) },
            "diffusetransmission" => MaterialModel::DiffuseTransmission {
                reflectance: self.albedo(e, "reflectance", 0.25),
                transmittance: self.albedo(e, "transmittance", 0.25),
                scale: e.params.float(&mut self.desc.diagnostics, "scale", 1.0),
            },
            "conductor" => MaterialModel::Conductor {
                color: self.conductor_color(e, "eta", "k")?,
                specular_reflectance: self.constant(1.0),
                roughness: self.roughness(e, ["uroughness", "vroughness", "roughness"]),
            },
            "dielectric" => MaterialModel::Dielectric {
                ior: self.ior(e, "eta")?,
                specular_reflectance: self.constant(1.0),
                specular_transmittance: self.constant(1.0),
                roughness: self.roughness(e, ["uroughness", "vroughness", "roughness"]),
            },
            "thindielectric" => MaterialModel::ThinDielectric {
                ior: self.ior(e, "eta")?,
                specular_reflectance: self.constant(1.0),
                specular_transmittance: self.constant(1.0),
            },
            "coateddiffuse" => MaterialModel::CoatedDiffuse {
                reflectance: self.albedo(e, "reflectance", 0.5),
                coat: self.coat(e, "eta", ["uroughness", "vroughness", "roughness"])?,
            },
            "coatedconductor" => MaterialModel::CoatedConductor {
                color: self.conductor_color(e, "conductor.eta", "conductor.k")?,
                base_roughness: self.roughness(
                    e,
                    ["conductor.uroughness", "conductor.vroughness", "conductor.roughness"],
                ),
                coat: self.coat(
                    e,
                    "interface.eta",
                    ["interface.uroughness", "interface.vroughness", "interface.roughness"],
                )?,
            },
            "mix" => self.mix(e)?,
            "interface" => MaterialModel::Null { counts: false },
            "hair" => self.hair(e),
            "measured" => self.measured(e)?,
            kind => {
                let message = format!("unknown material `{kind}`");
                self.desc.diagnostics.error(e.kind.span, message).nearest(kind, &KINDS);
                return None;
            }
        })
    }

    /// Roughness along u and v, each falling back to the common one, which is 0.
    pub(super) fn roughness(&mut self, e: &mut Entity, names: [&'static str; 3]) -> RoughnessDesc {
        let [u, v, both] = names;
        let common = self.float_texture(e, both, 0.0);
        let alpha_u = self.float_texture_or_none(e, u).unwrap_or(common);
        let alpha_v = self.float_texture_or_none(e, v).unwrap_or(common);
        let remap = e.params.boolean(&mut self.desc.diagnostics, "remaproughness", true);
        RoughnessDesc { distribution: Distribution::Ggx, alpha_u, alpha_v, remap }
    }

    /// An index of refraction: a number or a spectrum, 1.5 if none is given.
    fn ior(&mut self, e: &mut Entity, name: &'static str) -> Option<IorDesc> {
        use ParamType::{Blackbody, Float, Rgb, Spectrum, Texture};
        let diag = &mut self.desc.diagnostics;
        let types = [Float, Spectrum, Rgb, Blackbody, Texture];
        let Some(p) = e.params.find(diag, name, &types) else {
            return Some(IorDesc::Constant(1.5));
        };
        match p.ty {
            Float => {
                let (value, span) = (p.number(diag)?, p.span);
                if value < 0.0 {
                    diag.error(span, format!("the index of refraction `{name}` is negative"));
                    return None;
                }
                // As in pbrt, 0 stands for no change of medium.
                Some(IorDesc::Constant(if value == 0.0 { 1.0 } else { value }))
            }
            Texture => {
                let span = p.span;
                diag.error(span, format!("`{name}` can't be a texture"))
                    .hint(format!("write \"float {name}\" or \"spectrum {name}\""));
                None
            }
            _ => Some(match self.spectrum(e, name)? {
                SpectrumDesc::Constant(c) => IorDesc::Constant(c),
                s => IorDesc::Spectrum(self.desc.add_texture(TextureNode::Spectrum(s), None)),
            }),
        }
    }

    /// eta and k, copper's by default, or a reflectance.
    fn conductor_color(
        &mut self,
        e: &mut Entity,
        eta_name: &'static str,
        k_name: &'static str,
    ) -> Option<ConductorColor> {
        let eta = self.spectrum_texture_or_none(e, eta_name);
        let k = self.spectrum_texture_or_none(e, k_name);
        let reflectance = self.albedo_or_none(e, "reflectance");
        match (reflectance, eta, k) {
            (Some(_), Some(_), _) | (Some(_), _, Some(_)) => {
                let place = e.params.place("reflectance");
                let message =
                    format!("give `reflectance` or `{eta_name}` and `{k_name}`, not both");
                self.desc.diagnostics.error(place, message);
                None
            }
            (Some(r), None, None) => Some(ConductorColor::Reflectance(r)),
            (None, eta, k) => Some(ConductorColor::EtaK {
                eta: eta.unwrap_or_else(|| self.named("metal-Cu-eta")),
                k: k.unwrap_or_else(|| self.named("metal-Cu-k")),
            }),
        }
    }

    /// A texture of one of our named spectra.
    fn named(&mut self, name: &str) -> TextureId {
        let spectrum = kaustika_spectra::named(name).unwrap_or(SpectrumDesc::Constant(1.0));
        self.desc.add_texture(TextureNode::Spectrum(spectrum), None)
    }

    fn coat(
        &mut self,
        e: &mut Entity,
        eta: &'static str,
        roughness: [&'static str; 3],
    ) -> Option<CoatDesc> {
        let ior = self.ior(e, eta)?;
        let diag = &mut self.desc.diagnostics;
        let max_depth = e.params.int(diag, "maxdepth", 10).max(0) as u32;
        let samples = e.params.int(diag, "nsamples", 1).max(1) as u32;
        Some(CoatDesc {
            ior,
            roughness: self.roughness(e, roughness),
            thickness: self.float_texture(e, "thickness", 0.01),
            albedo: self.albedo(e, "albedo", 0.0),
            g: self.float_texture(e, "g", 0.0),
            max_depth,
            samples,
        })
    }

    fn mix(&mut self, e: &mut Entity) -> Option<MaterialModel> {
        let amount = self.float_texture(e, "amount", 0.5);
        let names = e.params.strings(&mut self.desc.diagnostics, "materials").unwrap_or_default();
        let [a, b] = &names[..] else {
            let message = format!(
                "material `mix` needs two names in \"string materials\", {} given",
                names.len()
            );
            self.desc.diagnostics.error(e.params.place("materials"), message);
            return None;
        };
        let mut part = |name: &super::param::Text| {
            let id = self.material_by_name(&NameRef { name: name.clone(), order: e.order });
            if matches!(self.desc.materials[id.0 as usize].model, MaterialModel::Null { .. }) {
                let message = format!("`{}` is an interface and can't be mixed", name.text);
                self.desc.diagnostics.error(name.span, message);
            }
            id
        };
        Some(MaterialModel::Mix { a: part(a), b: part(b), amount })
    }

    fn measured(&mut self, e: &mut Entity) -> Option<MaterialModel> {
        let Some(name) = e.params.string(&mut self.desc.diagnostics, "filename") else {
            let message = "material `measured` needs \"string filename\"";
            self.desc.diagnostics.error(e.kind.span, message);
            return None;
        };
        let path = self.file(&name, "material")?;
        match self.measured.read(&path) {
            Ok(brdf) => Some(MaterialModel::Measured(brdf)),
            Err(cause) => {
                let message = format!("can't read measured material `{}`: {cause}", name.text);
                self.desc.diagnostics.error(name.span, message);
                None
            }
        }
    }
}
