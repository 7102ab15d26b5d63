//! Materials: the plain ones. Reflecting models are one-sided, as in Mitsuba.

use super::convert::{Converter, old};
use super::document::{Kind, Object, ObjectId};
use super::textures::Role;
use kaustika_scene::description::{
    ConductorColor, Distribution, IorDesc, MaterialId, MaterialModel, PrincipledDesc,
    RoughnessDesc, TextureId, TextureNode, WardVariant,
};
use kaustika_spectra::SpectrumDesc;

/// BSDFs that Mitsuba knows.
const KNOWN: &[&str] = &[
    "diffuse",
    "roughdiffuse",
    "dielectric",
    "thindielectric",
    "roughdielectric",
    "conductor",
    "roughconductor",
    "plastic",
    "roughplastic",
    "phong",
    "ward",
    "principled",
    "principledthin",
    "mask",
    "twosided",
    "bumpmap",
    "normalmap",
    "blendbsdf",
    "mixturebsdf",
    "null",
    "difftrans",
    "coating",
    "roughcoating",
    "hk",
    "irawan",
    "hair",
    "measured",
    "measured_polarized",
    "pplastic",
    "polarizer",
    "retarder",
    "circular",
    "grating",
    "heightfield",
];

/// Roughness below this is taken to be this, as Mitsuba does for its rough models.
const MIN_ALPHA: f32 = 1e-4;

impl<'a> Converter<'a> {
    /// A material; each is made once.
    pub(super) fn material(&mut self, id: ObjectId) -> MaterialId {
        if let Some(known) = self.materials.get(&id) {
            return *known;
        }
        let object = self.object(id);
        let model = self.guarded(id, |c| c.model(object));
        let model = model.unwrap_or_else(|| self.grey());
        let made = self.out.add_material(object.id.clone(), model, Some(object.span));
        self.materials.insert(id, made);
        self.finish(id);
        made
    }

    /// True if the integrator knows media: for `volpath`, unlike `path`, passing `null` is no
    /// bounce, and shadow rays pass it.
    fn through_volumes(&self) -> bool {
        let knows = |o: &Object| o.kind == Kind::Integrator && o.plugin.starts_with("volpath");
        self.document.objects.iter().any(knows)
    }

    /// Mitsuba's material where none is given: grey, black on light sources.
    pub(super) fn default_material(&mut self, emits: bool) -> MaterialId {
        let reflectance = self.out.float(if emits { 0.0 } else { 0.5 });
        self.out.add_material("", MaterialModel::Diffuse { reflectance }, None)
    }

    pub(super) fn grey(&mut self) -> MaterialModel {
        MaterialModel::Diffuse { reflectance: self.out.float(0.5) }
    }

    fn model(&mut self, object: &'a Object) -> MaterialModel {
        if old(object) {
            object.ignore(&["ensure_energy_conservation"]);
        }
        match object.plugin.as_str() {
            "diffuse" => MaterialModel::Diffuse { reflectance: self.diffuse_color(object) },
            "roughdiffuse" => MaterialModel::OrenNayar {
                reflectance: self.diffuse_color(object),
                alpha: self.texture(object, "alpha", 0.2, Role::Scalar),
                fast: self.boolean(object, "use_fast_approx", false),
            },
            "difftrans" => MaterialModel::DiffuseTransmission {
                reflectance: self.out.float(0.0),
                transmittance: {
                    let name = match object.has("transmittance") {
                        true => "transmittance",
                        false => "diffuse_transmittance",
                    };
                    self.texture(object, name, 0.5, Role::Reflectance)
                },
                scale: 1.0,
            },
            "dielectric" => self.dielectric(object, false),
            "roughdielectric" => self.dielectric(object, true),
            "thindielectric" => MaterialModel::ThinDielectric {
                ior: IorDesc::Constant(self.relative_ior(object, "bk7")),
                specular_reflectance: self.specular(object, "specular_reflectance", 1.0),
                specular_transmittance: self.specular(object, "specular_transmittance", 1.0),
            },
            "conductor" => self.conductor(object, false),
            "roughconductor" => self.conductor(object, true),
            "plastic" => self.plastic(object, false),
            "roughplastic" => self.plastic(object, true),
            "pplastic" => MaterialModel::PolarizedPlastic {
                diffuse_reflectance: self.specular(object, "diffuse_reflectance", 0.5),
                specular_reflectance: self.specular(object, "specular_reflectance", 1.0),
                ior: self.relative_ior(object, "polypropylene"),
                roughness: self.roughness(object, true),
            },
            "phong" => MaterialModel::Phong {
                diffuse_reflectance: self.specular(object, "diffuse_reflectance", 0.5),
                specular_reflectance: self.specular(object, "specular_reflectance", 0.2),
                exponent: self.texture(object, "exponent", 30.0, Role::Scalar),
            },
            "ward" => self.ward(object),
            "principled" => self.principled(object, false),
            "principledthin" => self.principled(object, true),
            "null" => MaterialModel::Null { counts: !self.through_volumes() },
            "hk" => self.stand_in(object, "reflectance"),
            "hair" => self.hair(object),
            "grating" => self.grating(object),
            "heightfield" => self.height_field(object),
            "measured" => self.measured(object),
            "measured_polarized" => self.measured_polarized(object),
            "irawan" => self.stand_in(object, ""),
            "polarizer" | "retarder" | "circular" => self.polarizing_filter(object),
            "mask" | "twosided" | "bumpmap" | "bump" | "normalmap" | "blendbsdf"
            | "mixturebsdf" | "coating" | "roughcoating" => self.nested_model(object),
            _ => {
                self.unknown_plugin(object, KNOWN);
                self.replaced_silently(object);
                self.grey()
            }
        }
    }

    fn stand_in(&mut self, object: &'a Object, color: &'static str) -> MaterialModel {
        let reflectance = match object.get(color) {
            Some(p) => self.texture_of(object, p, Role::Reflectance),
            None => self.out.float(0.5),
        };
        self.replaced(object, "a diffuse material is used");
        MaterialModel::Diffuse { reflectance }
    }

    /// Marks everything as read, where an error was reported already.
    pub(super) fn replaced_silently(&self, object: &Object) {
        for p in &object.parameters {
            p.used.set(true);
        }
    }

    /// `reflectance`, which 0.6 also calls `diffuseReflectance`.
    fn diffuse_color(&mut self, object: &'a Object) -> TextureId {
        let other = old(object) && !object.has("reflectance") && object.has("diffuse_reflectance");
        let name = if other { "diffuse_reflectance" } else { "reflectance" };
        self.texture(object, name, 0.5, Role::Reflectance)
    }

    fn specular(&mut self, object: &'a Object, name: &'static str, default: f32) -> TextureId {
        self.texture(object, name, default, Role::Reflectance)
    }

    fn dielectric(&mut self, object: &'a Object, rough: bool) -> MaterialModel {
        MaterialModel::Dielectric {
            ior: IorDesc::Constant(self.relative_ior(object, "bk7")),
            specular_reflectance: self.specular(object, "specular_reflectance", 1.0),
            specular_transmittance: self.specular(object, "specular_transmittance", 1.0),
            roughness: self.roughness(object, rough),
        }
    }

    fn plastic(&mut self, object: &'a Object, rough: bool) -> MaterialModel {
        MaterialModel::Plastic {
            diffuse_reflectance: self.specular(object, "diffuse_reflectance", 0.5),
            specular_reflectance: self.specular(object, "specular_reflectance", 1.0),
            ior: self.relative_ior(object, "polypropylene"),
            nonlinear: self.boolean(object, "nonlinear", false),
            roughness: rough.then(|| self.roughness(object, true)),
        }
    }

    /// `distribution` and `alpha` or both of `alpha_u` and `alpha_v`; zero if smooth.
    pub(super) fn roughness(&mut self, object: &'a Object, rough: bool) -> RoughnessDesc {
        if !rough {
            let zero = self.out.float(0.0);
            let distribution = Distribution::default();
            return RoughnessDesc { distribution, alpha_u: zero, alpha_v: zero, remap: false };
        }
        object.ignore(&["sample_visible"]);
        let distribution = self.distribution(object);
        let (u, v) = (object.has("alpha_u"), object.has("alpha_v"));
        if (u || v) && object.has("alpha") {
            let message = "`alpha` and `alpha_u`, `alpha_v` exclude each other";
            self.out.diagnostics.error(object.span, message);
        } else if u != v {
            self.out.diagnostics.error(object.span, "`alpha_u` and `alpha_v` belong together");
            object.ignore(&["alpha_u", "alpha_v"]);
        }
        let (alpha_u, alpha_v) = if u && v {
            (self.alpha(object, "alpha_u"), self.alpha(object, "alpha_v"))
        } else {
            let alpha = self.alpha(object, "alpha");
            (alpha, alpha)
        };
        RoughnessDesc { distribution, alpha_u, alpha_v, remap: false }
    }

    fn alpha(&mut self, object: &'a Object, name: &'static str) -> TextureId {
        let id = self.texture(object, name, 0.1, Role::Scalar);
        if let Some(TextureNode::Float(alpha)) =
            self.out.textures.get_mut(id.0 as usize).map(|t| &mut t.node)
        {
            *alpha = alpha.max(MIN_ALPHA);
        }
        id
    }

    fn distribution(&mut self, object: &'a Object) -> Distribution {
        let names = [
            ("beckmann", Some(Distribution::Beckmann)),
            ("ggx", Some(Distribution::Ggx)),
            ("phong", None),
            ("as", None),
        ];
        let choice = self.choice(object, "distribution", &names, Some(Distribution::Beckmann));
        choice.unwrap_or_else(|| {
            let span = object.get("distribution").map(|p| p.value_span);
            self.out
                .diagnostics
                .warning(span, "the Phong distribution of facets is not supported")
                .label("Beckmann's is used");
            Distribution::Beckmann
        })
    }

    fn conductor(&mut self, object: &'a Object, rough: bool) -> MaterialModel {
        let color = self.conductor_color(object);
        MaterialModel::Conductor {
            color,
            specular_reflectance: self.specular(object, "specular_reflectance", 1.0),
            roughness: self.roughness(object, rough),
        }
    }

    /// `eta` and `k`, or a `material` by name. Mitsuba 3 assumes `none`, an ideal mirror; 0.6
    /// assumes copper, and divides by the index outside, `extEta`.
    fn conductor_color(&mut self, object: &'a Object) -> ConductorColor {
        let outside = if old(object) { self.ior(object, "ext_eta", "air") } else { 1.0 };
        let default = if old(object) { "Cu" } else { "none" };
        let named = self.string(object, "material");
        let (material, at) = named.map_or((default, None), |(m, span)| (m, Some(span)));
        let given = object.has("eta") || (object.has("k") && (old(object) || material == "none"));
        let (eta, k) = if material.eq_ignore_ascii_case("none") || object.has("eta") {
            if !given {
                return ConductorColor::Mirror;
            }
            (
                self.texture(object, "eta", 0.0, Role::Unbounded),
                self.texture(object, "k", 1.0, Role::Unbounded),
            )
        } else {
            let Some((eta, k)) = kaustika_spectra::conductor(material) else {
                let known: Vec<&str> = kaustika_spectra::conductor_names().collect();
                self.out
                    .diagnostics
                    .error(at.unwrap_or(object.span), format!("unknown metal `{material}`"))
                    .nearest(material, &known);
                return ConductorColor::Mirror;
            };
            let span = at.unwrap_or(object.span);
            let eta = self.spectrum_texture(eta, span);
            let k = match old(object) && object.has("k") {
                true => self.texture(object, "k", 1.0, Role::Unbounded),
                false => self.spectrum_texture(k, span),
            };
            (eta, k)
        };
        ConductorColor::EtaK { eta: self.over(eta, outside), k: self.over(k, outside) }
    }

    fn over(&mut self, texture: TextureId, divisor: f32) -> TextureId {
        if divisor == 1.0 {
            return texture;
        }
        let scale = self.out.float(1.0 / divisor);
        self.out.add_texture(TextureNode::Scale { texture, scale }, None)
    }

    fn ward(&mut self, object: &'a Object) -> MaterialModel {
        let variants = [
            ("ward", WardVariant::Ward),
            ("ward-duer", WardVariant::WardDuer),
            ("balanced", WardVariant::Balanced),
        ];
        let variant = self.choice(object, "variant", &variants, WardVariant::Balanced);
        let alpha_u = if object.has("alpha_u") { "alpha_u" } else { "alpha" };
        let alpha_v = if object.has("alpha_v") { "alpha_v" } else { "alpha" };
        MaterialModel::Ward {
            variant,
            diffuse_reflectance: self.specular(object, "diffuse_reflectance", 0.5),
            specular_reflectance: self.specular(object, "specular_reflectance", 0.2),
            alpha_u: self.alpha(object, alpha_u),
            alpha_v: self.alpha(object, alpha_v),
        }
    }

    fn principled(&mut self, object: &'a Object, thin: bool) -> MaterialModel {
        object.ignore(&[
            "main_specular_sampling_rate",
            "clearcoat_sampling_rate",
            "diffuse_reflectance_sampling_rate",
            "spec_reflectance_sampling_rate",
            "spec_trans_sampling_rate",
            "diff_trans_sampling_rate",
        ]);
        let eta = if thin { self.thin_eta(object) } else { self.principled_eta(object) };
        let scalar = |c: &mut Self, name: &'static str, default: f32| {
            c.texture(object, name, default, Role::Scalar)
        };
        // Parameters that a variant lacks are zero, and unknown if given.
        let only = |c: &mut Self, has: bool, name: &'static str| {
            if has { scalar(c, name, 0.0) } else { c.out.float(0.0) }
        };
        MaterialModel::Principled(PrincipledDesc {
            thin,
            base_color: self.texture(object, "base_color", 0.5, Role::Reflectance),
            roughness: scalar(self, "roughness", 0.5),
            anisotropic: scalar(self, "anisotropic", 0.0),
            metallic: only(self, !thin, "metallic"),
            spec_trans: scalar(self, "spec_trans", 0.0),
            diff_trans: only(self, thin, "diff_trans"),
            eta,
            spec_tint: scalar(self, "spec_tint", 0.0),
            sheen: scalar(self, "sheen", 0.0),
            sheen_tint: scalar(self, "sheen_tint", 0.0),
            flatness: scalar(self, "flatness", 0.0),
            clearcoat: only(self, !thin, "clearcoat"),
            clearcoat_gloss: only(self, !thin, "clearcoat_gloss"),
        })
    }

    /// The index from `eta` or from `specular` s: 2 / (1 - √(0.08 s)) - 1 (Burley 2015). An index
    /// of 1 can't transmit: Mitsuba moves it off 1 where `spec_trans` is given.
    fn principled_eta(&mut self, object: &'a Object) -> f32 {
        let transmits = object.has("spec_trans");
        if object.has("eta") {
            if object.get("specular").is_some() {
                self.out.diagnostics.error(object.span, "`eta` and `specular` exclude each other");
            }
            let eta = self.number(object, "eta", 1.5);
            return if transmits && eta == 1.0 { 1.001 } else { eta };
        }
        let mut specular = self.number(object, "specular", 0.5);
        if transmits && specular == 0.0 {
            specular = 1e-3;
        }
        2.0 / (1.0 - (0.08 * specular.max(0.0)).sqrt()) - 1.0
    }

    /// The thin variant allows a texture here; the description has one number.
    fn thin_eta(&mut self, object: &'a Object) -> f32 {
        let Some(p) = object.get("eta") else { return 1.5 };
        let texture = self.texture_of(object, p, Role::Scalar);
        match &self.out.textures[texture.0 as usize].node {
            TextureNode::Float(eta) => *eta,
            TextureNode::Spectrum(SpectrumDesc::Constant(eta) | SpectrumDesc::EqualEnergy(eta)) => {
                *eta
            }
            _ => {
                self.out
                    .diagnostics
                    .warning(p.span, "an index that varies is not supported")
                    .label("1.5 is used");
                1.5
            }
        }
    }

    /// The nested materials, each made.
    pub(super) fn nested_materials(&mut self, object: &'a Object) -> Vec<MaterialId> {
        self.children(object, Kind::Bsdf).into_iter().map(|(_, id)| self.material(id)).collect()
    }
}
