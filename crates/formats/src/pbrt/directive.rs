//! The directives of the format (pbrt.org/fileformat-v4).

use super::entity::{
    ATTRIBUTE_TARGETS, CameraEntity, Entity, InstanceEntity, LightEntity, MaterialRef,
    MediumEntity, NameRef, NamedMaterialEntity, ObjectEntity, ShapeEntity, TextureEntity,
    TextureType,
};
use super::files;
use super::lexer::{Lexer, Token, TokenKind};
use super::number::scan_f32;
use super::param::{Params, Text};
use super::reader::{GivenUp, Open, Reader};
use super::upgrade;
use kaustika_math::{Transform, Vec3};
use kaustika_scene::description::Span;
use kaustika_spectra::ColorSpace;
use std::rc::Rc;

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

const ANIMATED: &str = "animated transforms are not rendered yet, using the start";

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
            "Attribute" => self.attribute(lexer, span)?,
            "ActiveTransform" => self.active_transform(lexer)?,
            "ColorSpace" => self.color_space(lexer)?,
            "CoordinateSystem" => {
                let name = self.string(lexer, "a name")?;
                self.systems.insert(name.text, self.state.ctm);
            }
            "CoordSysTransform" => self.coord_sys_transform(lexer)?,
            "Identity" | "Translate" | "Scale" | "Rotate" | "LookAt" | "Transform"
            | "ConcatTransform" => self.transform(lexer, name, span)?,
            "TransformTimes" => {
                self.numbers::<2>(lexer)?;
            }
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
                if animated {
                    self.notes.warning(span, ANIMATED);
                }
                let transform = transform.inverse();
                self.scene.camera = Some(CameraEntity { entity: e, transform, medium });
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
                upgrade::material(&mut e, self);
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
                upgrade::material(&mut e, self);
                self.scene.named_materials.push(NamedMaterialEntity { name, entity: e });
            }
            "MakeNamedMedium" => {
                let name = std::mem::take(&mut e.kind);
                let number = self.scene.media.len();
                if self.scene.medium_names.insert(&name.text, number, self.order) {
                    self.redefined.push((name.clone(), "medium"));
                }
                self.scene.media.push(MediumEntity { name, entity: e });
            }
            _ => {
                upgrade::shape(&mut e, self);
                if animated {
                    self.notes.warning(span, ANIMATED);
                }
                self.shape(e);
            }
        }
        Ok(())
    }

    fn shape(&mut self, entity: Entity) {
        let s = &self.state;
        let shape = ShapeEntity {
            entity,
            transform: s.ctm[0],
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

    fn attribute_begin(&mut self, name: &str, span: Span) {
        if name == "TransformBegin" {
            let message = "`TransformBegin` is deprecated and read as `AttributeBegin`";
            self.notes.warning(span, message);
        }
        self.stack.push(Open { state: self.state.clone(), object: false, span });
    }

    fn attribute_end(&mut self, name: &str, span: Span) {
        match self.stack.pop() {
            Some(open) if !open.object => self.state = open.state,
            Some(open) => {
                let message = format!("`{name}` inside an object; `ObjectEnd` is missing");
                self.diag.error(span, message);
                self.stack.push(open);
            }
            None => {
                let begin =
                    if name == "AttributeEnd" { "AttributeBegin" } else { "TransformBegin" };
                self.diag.error(span, format!("`{name}` without `{begin}`"));
            }
        }
    }

    fn attribute(&mut self, lexer: &mut Lexer, _span: Span) -> Result<(), GivenUp> {
        let target = self.string(lexer, "a target such as `shape`")?;
        let params = self.params(lexer)?;
        match ATTRIBUTE_TARGETS.iter().position(|t| *t == target.text) {
            Some(i) => Rc::make_mut(&mut self.state.attributes[i]).extend(params),
            None => {
                self.diag
                    .error(target.span, format!("unknown attribute target `{}`", target.text))
                    .nearest(&target.text, &ATTRIBUTE_TARGETS);
            }
        }
        Ok(())
    }

    fn active_transform(&mut self, lexer: &mut Lexer) -> Result<(), GivenUp> {
        let before = lexer.pos;
        let token = self.required(lexer, "`All`, `StartTime` or `EndTime`")?;
        let word = lexer.slice(token.span);
        self.state.active = match word {
            "All" => [true, true],
            "StartTime" => [true, false],
            "EndTime" => [false, true],
            _ => {
                let known = ["All", "StartTime", "EndTime"];
                let message = format!("expected `All`, `StartTime` or `EndTime`, found `{word}`");
                self.diag.error(token.span, message).nearest(word, &known);
                if DIRECTIVES.contains(&word) {
                    lexer.pos = before;
                }
                return Ok(());
            }
        };
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

    fn coord_sys_transform(&mut self, lexer: &mut Lexer) -> Result<(), GivenUp> {
        let name = self.string(lexer, "the name of a coordinate system")?;
        if let Some(ctm) = self.systems.get(&name.text) {
            self.state.ctm = *ctm;
            return Ok(());
        }
        let known: Vec<&str> = self.systems.keys().map(String::as_str).collect();
        let message = format!("no coordinate system is called `{}`, nothing is changed", name.text);
        let warning = self.diag.warning(name.span, message);
        if let Some(near) = super::nearest_name(&name.text, &known) {
            warning.hint(format!("did you mean `{near}`?"));
        }
        Ok(())
    }

    /// Directives that change the current transform.
    fn transform(&mut self, lexer: &mut Lexer, name: &str, span: Span) -> Result<(), GivenUp> {
        let vec = |v: &[f32]| Vec3::new(v[0], v[1], v[2]);
        let change = match name {
            "Identity" => Some(Transform::IDENTITY),
            "Translate" => Some(Transform::translate(vec(&self.numbers::<3>(lexer)?))),
            "Scale" => {
                let v = self.numbers::<3>(lexer)?;
                let scale = Transform::scale(vec(&v));
                if scale.is_none() {
                    self.diag
                        .error(span, format!("`Scale {} {} {}` is singular", v[0], v[1], v[2]))
                        .hint("no factor may be 0; a very small one flattens too");
                }
                scale
            }
            "Rotate" => {
                let v = self.numbers::<4>(lexer)?;
                let rotation = Transform::rotate(v[0], vec(&v[1..]));
                if rotation.is_none() {
                    self.diag.error(span, "the axis of `Rotate` is zero");
                }
                rotation
            }
            "LookAt" => {
                let v = self.numbers::<9>(lexer)?;
                let frame = Transform::look_at(vec(&v), vec(&v[3..]), vec(&v[6..]));
                if frame.is_none() {
                    let same = v[..3] == v[3..6];
                    let what = if same {
                        "eye and target are the same point"
                    } else {
                        "the up vector lies along the viewing direction"
                    };
                    self.diag.error(span, format!("`LookAt` is singular: {what}"));
                }
                frame.map(|t| t.inverse())
            }
            _ => {
                let v = self.matrix(lexer)?;
                // Columns come first in the file.
                let rows = std::array::from_fn(|i| std::array::from_fn(|j| v[4 * j + i]));
                let t = Transform::from_rows(rows);
                if t.is_none() {
                    self.diag.error(span, format!("the matrix of `{name}` is singular"));
                }
                t
            }
        };
        let Some(change) = change else { return Ok(()) };
        for (ctm, active) in self.state.ctm.iter_mut().zip(self.state.active) {
            if active {
                *ctm = match name {
                    "Identity" | "Transform" => change,
                    _ => *ctm * change,
                };
            }
        }
        Ok(())
    }

    /// Sixteen numbers in brackets.
    fn matrix(&mut self, lexer: &mut Lexer) -> Result<[f32; 16], GivenUp> {
        self.bracket(lexer, TokenKind::Open, "`[`")?;
        let m = self.numbers::<16>(lexer)?;
        self.bracket(lexer, TokenKind::Close, "`]`")?;
        Ok(m)
    }

    fn bracket(
        &mut self,
        lexer: &mut Lexer,
        kind: TokenKind,
        expected: &str,
    ) -> Result<(), GivenUp> {
        let before = lexer.pos;
        let token = self.required(lexer, expected)?;
        if token.kind == kind {
            return Ok(());
        }
        let found = lexer.slice(token.span);
        self.diag.error(token.span, format!("expected {expected}, found `{found}`"));
        lexer.pos = before;
        Err(GivenUp)
    }

    /// `N` numbers without brackets.
    fn numbers<const N: usize>(&mut self, lexer: &mut Lexer) -> Result<[f32; N], GivenUp> {
        let mut out = [0.0; N];
        for (i, v) in out.iter_mut().enumerate() {
            lexer.skip_blank();
            match scan_f32(lexer.bytes(), lexer.pos) {
                Some((value, end)) if value.is_finite() => {
                    *v = value;
                    lexer.pos = end;
                }
                _ => {
                    let before = lexer.pos;
                    let token = self.required(lexer, "a number")?;
                    let found = lexer.slice(token.span);
                    let message = format!("expected number {} of {N}, found `{found}`", i + 1);
                    self.diag.error(token.span, message);
                    lexer.pos = before;
                    return Err(GivenUp);
                }
            }
        }
        Ok(out)
    }

    fn include(&mut self, lexer: &mut Lexer, import: bool) -> Result<(), GivenUp> {
        let name = self.string(lexer, "a file name")?;
        let current = self.folder(name.span.file).to_path_buf();
        let Some(path) = files::resolve(&name.text, &self.main, &current) else {
            let error = self.diag.error(name.span, format!("no file `{}`", name.text));
            if let Some(near) = files::nearest_file(&name.text, &self.main) {
                error.hint(format!("did you mean `{near}`?"));
            }
            return Ok(());
        };
        if !import {
            self.read_file(&path, Some(name.span));
            return Ok(());
        }
        // An import has its own copy of the state and leaves ours alone.
        let (state, depth) = (self.state.clone(), self.stack.len());
        self.read_file(&path, Some(name.span));
        while self.stack.len() > depth {
            let open = self.stack.pop();
            self.report_open(open);
        }
        self.state = state;
        Ok(())
    }

    /// Reports a block that was not closed.
    pub fn report_open(&mut self, open: Option<Open>) {
        if let Some(open) = open {
            let name = if open.object { "ObjectBegin" } else { "AttributeBegin" };
            self.diag.error(open.span, format!("this `{name}` is never closed"));
        }
    }

    fn world_begin(&mut self, span: Span) {
        if self.in_world {
            self.diag.error(span, "second `WorldBegin`");
            return;
        }
        self.in_world = true;
        self.state.ctm = [Transform::IDENTITY; 2];
        self.state.active = [true; 2];
        self.systems.insert("world".into(), self.state.ctm);
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

    fn object_begin(&mut self, lexer: &mut Lexer, span: Span) -> Result<(), GivenUp> {
        let name = self.string(lexer, "the name of an object")?;
        if self.object.is_some() {
            self.diag.error(span, "`ObjectBegin` inside an object");
            return Ok(());
        }
        let number = self.scene.objects.len();
        if self.scene.object_names.insert(&name.text, number, self.order) {
            self.redefined.push((name.clone(), "object"));
        }
        self.stack.push(Open { state: self.state.clone(), object: true, span });
        self.object = Some(number);
        self.scene.objects.push(ObjectEntity { name, shapes: Vec::new() });
        Ok(())
    }

    fn object_end(&mut self, span: Span) {
        if self.object.take().is_none() {
            self.diag.error(span, "`ObjectEnd` without `ObjectBegin`");
            return;
        }
        while let Some(open) = self.stack.pop() {
            if open.object {
                self.state = open.state;
                return;
            }
            self.report_open(Some(open));
        }
    }

    fn object_instance(&mut self, lexer: &mut Lexer, span: Span) -> Result<(), GivenUp> {
        let name = self.string(lexer, "the name of an object")?;
        if self.object.is_some() {
            self.diag.error(span, "`ObjectInstance` inside an object");
            return Ok(());
        }
        if self.state.ctm[0] != self.state.ctm[1] {
            self.notes.warning(span, ANIMATED);
        }
        let object = NameRef { name, order: self.order };
        let transform = self.state.ctm[0];
        self.scene.instances.push(InstanceEntity { object, transform, span });
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
            "rendercoordsys"
            | "wavefront"
            | "msereferenceimage"
            | "msereferenceout"
            | "displacementedgescale" => {}
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
