//! The directives of the format (pbrt.org/fileformat-v4).

use super::entity::{
    CameraEntity, Entity, LightEntity, MaterialRef, MediumEntity, NameRef, NamedMaterialEntity,
    ShapeEntity, TextureEntity, TextureType,
};
use super::lexer::{Lexer, Token, TokenKind};
use super::param::{Params, Text};
use super::reader::{GivenUp, Reader};
use super::{upgrade, upgrade_material};
use kaustika_scene::description::Span;
use kaustika_spectra::ColorSpace;

/// All directives; `WorldEnd` is pbrt-v3's.
pub(super) const DIRECTIVES: &[&str] = &[
    "Accelerator",
    "ActiveTransform",
    "AreaLightSource",
    "Attribute",
    "AttributeBegin",
    "AttributeEnd",
    "Camera",
    "ColorSpace",
    "ConcatTransform",
    "CoordSysTransform",
    "CoordinateSystem",
    "Film",
    "Identity",
    "Import",
    "Include",
    "Integrator",
    "LightSource",
    "LookAt",
    "MakeNamedMaterial",
    "MakeNamedMedium",
    "Material",
    "MediumInterface",
    "NamedMaterial",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "Option",
    "PixelFilter",
    "ReverseOrientation",
    "Rotate",
    "Sampler",
    "Scale",
    "Shape",
    "Texture",
    "Transform",
    "TransformBegin",
    "TransformEnd",
    "TransformTimes",
    "Translate",
    "WorldBegin",
    "WorldEnd",
];

/// Directives that belong before `WorldBegin`.
const OPTIONS: &[&str] =
    &["Accelerator", "Camera", "Film", "Integrator", "PixelFilter", "Sampler", "TransformTimes"];

/// Directives that belong after `WorldBegin`.
const WORLD: &[&str] = &[
    "AreaLightSource",
    "AttributeBegin",
    "AttributeEnd",
    "Import",
    "LightSource",
    "MakeNamedMaterial",
    "Material",
    "NamedMaterial",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "ReverseOrientation",
    "Shape",
    "Texture",
    "WorldEnd",
];

/// pbrt's names of colour spaces.
const SPACES: [(&str, ColorSpace); 4] = [
    ("srgb", ColorSpace::Srgb),
    ("dci-p3", ColorSpace::DciP3),
    ("rec2020", ColorSpace::Rec2020),
    ("aces2065-1", ColorSpace::Aces2065_1),
];

/// Told where a transform moves what can't.
pub(super) const ANIMATED: &str = "lights and textures do not move, using the start";

impl Reader {
    /// Runs the directive that starts with `token`.
    pub fn directive(&mut self, lexer: &mut Lexer, token: Token) -> Result<(), GivenUp> {
        let (name, span) = (lexer.slice(token.span), token.span);
        if token.kind != TokenKind::Word || !DIRECTIVES.contains(&name) {
            let message = format!("expected a directive, found `{name}`");
            let error = self.diag.error(span, message);
            if token.kind == TokenKind::Word && !name.starts_with(|c: char| c.is_ascii_digit()) {
                error.message = format!("unknown directive `{name}`");
                if let Some(near) = super::nearest_name(name, DIRECTIVES) {
                    error.hint(format!("did you mean `{near}`?"));
                }
            }
            return Err(GivenUp);
        }
        self.order += 1;
        if self.in_world && OPTIONS.contains(&name) {
            self.diag
                .error(span, format!("`{name}` is not allowed after `WorldBegin`"))
                .hint("move it before `WorldBegin`");
            return Err(GivenUp);
        }
        if !self.in_world && WORLD.contains(&name) {
            self.diag
                .error(span, format!("`{name}` is not allowed before `WorldBegin`"))
                .hint("move it after `WorldBegin`");
            return Err(GivenUp);
        }
        match name {
            "AttributeBegin" | "TransformBegin" => self.attribute_begin(name, span),
            "AttributeEnd" | "TransformEnd" => self.attribute_end(name, span),
            "Attribute" => self.attribute(lexer)?,
            "ActiveTransform" => self.active_transform(lexer)?,
            "ColorSpace" => self.color_space(lexer)?,
            "CoordinateSystem" => {
                let name = self.string(lexer, "a name")?;
                self.systems.insert(name.text, self.state.ctm);
            }
            "CoordSysTransform" => self.coord_sys_transform(lexer)?,
            "Identity" | "Translate" | "Scale" | "Rotate" | "LookAt" | "Transform"
            | "ConcatTransform" => self.transform(lexer, name, span)?,
            "TransformTimes" => self.transform_times(lexer, span)?,
            "Include" | "Import" => self.include(lexer, name == "Import")?,
            "ReverseOrientation" => self.state.reverse = !self.state.reverse,
            "WorldBegin" => self.world_begin(span),
            "WorldEnd" => self.v3_note(span, "pbrt-v3 directive `WorldEnd` is ignored"),
            "MediumInterface" => self.medium_interface(lexer)?,
            "NamedMaterial" => {
                let name = self.string(lexer, "the name of a material")?;
                self.state.material = MaterialRef::Named(NameRef { name, order: self.order });
            }
            "ObjectBegin" => self.object_begin(lexer, span)?,
            "ObjectEnd" => self.object_end(span),
            "ObjectInstance" => self.object_instance(lexer, span)?,
            "Option" => self.option(lexer)?,
            "Texture" => self.texture(lexer, span)?,
            _ => self.entity(lexer, name, span)?,
        }
        Ok(())
    }

    /// Directives with a kind and parameters.
    fn entity(&mut self, lexer: &mut Lexer, name: &str, span: Span) -> Result<(), GivenUp> {
        let kind = self.string(lexer, "a kind")?;
        let own = self.params(lexer)?;
        let target = match name {
            "Shape" => Some(0),
            "LightSource" | "AreaLightSource" => Some(1),
            "Material" | "MakeNamedMaterial" => Some(2),
            "MakeNamedMedium" => Some(3),
            _ => None,
        };
        let inherited = target.map_or(Vec::new(), |t: usize| (*self.state.attributes[t]).clone());
        let params = Params::new(own, inherited, span, self.state.space);
        let mut e = Entity { kind, params, span, order: self.order };
        let animated = self.state.ctm[0] != self.state.ctm[1];
        let (transform, medium) = (self.state.ctm[0], self.state.outside.clone());
        match name {
            "Accelerator" => self.scene.accelerator = Some(e),
            "Film" => {
                upgrade::film(&mut e, self);
                self.scene.film = Some(e);
            }
            "Integrator" => {
                upgrade::integrator(&mut e, self);
                self.scene.integrator = Some(e);
            }
            "PixelFilter" => {
                upgrade::filter(&mut e, self);
                self.scene.filter = Some(e);
            }
            "Sampler" => {
                upgrade::sampler(&mut e, self);
                self.scene.sampler = Some(e);
            }
            "Camera" => {
                upgrade::camera(&mut e, self);
                self.systems.insert("camera".into(), self.state.ctm.map(|t| t.inverse()));
                let mut place = self.place(span);
                place.transforms = place.transforms.map(|t| t.inverse());
                self.scene.camera = Some(CameraEntity { entity: e, place, medium });
            }
            "LightSource" => {
                upgrade::light(&mut e, self);
                if animated {
                    self.notes.warning(span, ANIMATED);
                }
                self.scene.lights.push(LightEntity { entity: e, transform, medium });
            }
            "AreaLightSource" => {
                upgrade::area_light(&mut e, self);
                self.scene.area_lights.push(e);
                self.state.area_light = Some(self.scene.area_lights.len() - 1);
            }
            "Material" => {
                upgrade_material::material(&mut e, self);
                self.scene.materials.push(e);
                self.state.material = MaterialRef::Plain(self.scene.materials.len() - 1);
            }
            "MakeNamedMaterial" => {
                let name = std::mem::take(&mut e.kind);
                let number = self.scene.named_materials.len();
                if self.scene.material_names.insert(&name.text, number, self.order) {
                    self.redefined.push((name.clone(), "material"));
                }
                match e.params.string(&mut self.diag, "type") {
                    Some(kind) => e.kind = kind,
                    None if e.params.has("type") => e.kind.text = "diffuse".into(),
                    None => {
                        let message = format!("material `{}` has no type", name.text);
                        self.diag
                            .error(name.span, message)
                            .hint("add \"string type\" \"diffuse\" or another kind");
                        e.kind.text = "diffuse".into();
                    }
                }
                upgrade_material::material(&mut e, self);
                self.scene.named_materials.push(NamedMaterialEntity { name, entity: e });
            }
            "MakeNamedMedium" => {
                let name = std::mem::take(&mut e.kind);
                let number = self.scene.media.len();
                if self.scene.medium_names.insert(&name.text, number, self.order) {
                    self.redefined.push((name.clone(), "medium"));
                }
                self.scene.media.push(MediumEntity { name, entity: e, transform });
            }
            _ => {
                upgrade::shape(&mut e, self);
                self.shape(e);
            }
        }
        Ok(())
    }

    fn shape(&mut self, entity: Entity) {
        let place = self.place(entity.span);
        let s = &self.state;
        let shape = ShapeEntity {
            entity,
            place,
            reverse: s.reverse,
            material: s.material.clone(),
            area_light: s.area_light,
            inside: s.inside.clone(),
            outside: s.outside.clone(),
        };
        match self.object {
            Some(o) => self.scene.objects[o].shapes.push(shape),
            None => self.scene.shapes.push(shape),
        }
    }

    fn texture(&mut self, lexer: &mut Lexer, span: Span) -> Result<(), GivenUp> {
        let name = self.string(lexer, "the name of a texture")?;
        let mut ty = self.string(lexer, "`float` or `spectrum`")?;
        let kind = self.string(lexer, "a kind of texture")?;
        let own = self.params(lexer)?;
        if ty.text == "color" {
            self.v3_note(ty.span, "pbrt-v3 texture type `color` is read as `spectrum`");
            ty.text = "spectrum".into();
        }
        let ty = match ty.text.as_str() {
            "float" => TextureType::Float,
            "spectrum" => TextureType::Spectrum,
            other => {
                self.diag
                    .error(ty.span, format!("unknown texture type `{other}`"))
                    .nearest(other, &["float", "spectrum"]);
                return Ok(());
            }
        };
        let inherited = (*self.state.attributes[4]).clone();
        let params = Params::new(own, inherited, span, self.state.space);
        let mut entity = Entity { kind, params, span, order: self.order };
        upgrade::texture(&mut entity, ty, self);
        let number = self.scene.textures.len();
        if self.scene.texture_names[ty as usize].insert(&name.text, number, self.order) {
            self.redefined.push((name.clone(), "texture"));
        }
        if self.state.ctm[0] != self.state.ctm[1] {
            self.notes.warning(span, ANIMATED);
        }
        let transform = self.state.ctm[0];
        self.scene.textures.push(TextureEntity { name, ty, entity, transform });
        Ok(())
    }

    fn color_space(&mut self, lexer: &mut Lexer) -> Result<(), GivenUp> {
        let name = self.string(lexer, "the name of a colour space")?;
        let lower = name.text.to_lowercase();
        match SPACES.iter().find(|(n, _)| *n == lower) {
            Some((_, space)) => self.state.space = *space,
            None => {
                self.diag
                    .error(name.span, format!("unknown colour space `{}`", name.text))
                    .nearest(&name.text, &SPACES.map(|(n, _)| n));
            }
        }
        Ok(())
    }

    fn medium_interface(&mut self, lexer: &mut Lexer) -> Result<(), GivenUp> {
        let inside = self.string(lexer, "the name of a medium")?;
        let before = lexer.pos;
        let outside = match self.next(lexer)? {
            Some(t) if t.kind == TokenKind::String => self.unquote(lexer, t)?,
            _ => {
                lexer.pos = before;
                inside.clone()
            }
        };
        let some = |t: Text| (!t.text.is_empty()).then_some(t);
        self.state.inside = some(inside);
        self.state.outside = some(outside);
        Ok(())
    }

    fn option(&mut self, lexer: &mut Lexer) -> Result<(), GivenUp> {
        let name = self.string(lexer, "the name of an option")?;
        let value = self.required(lexer, "the value of the option")?;
        let text = lexer.slice(value.span);
        // pbrt ignores the case, `-` and `_`.
        let plain: String =
            name.text.to_lowercase().chars().filter(|c| !matches!(c, '-' | '_')).collect();
        match plain.as_str() {
            "seed" => match super::number::scan_i32(text.as_bytes(), 0) {
                Ok((seed, _)) => self.scene.seed = Some(seed),
                Err(_) => {
                    let message = format!("option `seed` needs an integer, found `{text}`");
                    self.diag.error(value.span, message);
                }
            },
            // Neither changes the picture.
            "rendercoordsys" | "wavefront" => {}
            "msereferenceimage" | "msereferenceout" => {
                let message = format!("option `{}` is ignored", name.text);
                let hint = "`kaustika compare` measures errors";
                self.diag.note(name.span, message).hint(hint);
            }
            "displacementedgescale" => match super::number::scan_f32(text.as_bytes(), 0) {
                Some((scale, _)) => self.scene.edge_scale = Some(scale),
                None => {
                    let message = format!("option `{}` needs a number, found `{text}`", name.text);
                    self.diag.error(value.span, message);
                }
            },
            "disablepixeljitter"
            | "disabletexturefiltering"
            | "disablewavelengthjitter"
            | "forcediffuse"
            | "pixelstats" => {
                if text.trim_matches('"') != "false" {
                    let message = format!("option `{}` is not supported, ignored", name.text);
                    self.diag.warning(name.span, message);
                }
            }
            _ => {
                let known = ["seed", "rendercoordsys", "disablepixeljitter", "forcediffuse"];
                self.diag
                    .error(name.span, format!("unknown option `{}`", name.text))
                    .nearest(&name.text, &known);
            }
        }
        Ok(())
    }

    /// Notes something that only pbrt-v3 has.
    pub fn v3_note(&mut self, span: Span, message: impl Into<String>) {
        self.v3 = true;
        self.notes.note(span, message);
    }
}
