//! From entities to the scene description: names, defaults, references.

use super::entity::{Entities, Entity, MaterialRef, NameRef, TextureType};
use super::files;
use super::images::Images;
use super::notes::Notes;
use super::param::{ParamType, Text};
use super::reader::Reader;
use super::upgrade;
use kaustika_scene::description::{
    MaterialId, MaterialModel, MediumDesc, MediumId, SceneDescription, SourceFormat, Span,
    TextureId, TextureNode,
};
use kaustika_spectra::SpectrumDesc;
use std::path::{Path, PathBuf};

/// Progress of something that may refer to others of its kind.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Slot<T> {
    /// Not begun.
    #[default]
    Open,
    /// Being built: whoever comes here again goes in a circle.
    Busy,
    /// Built.
    Done(T),
}

/// Builds the description.
pub(super) struct Builder {
    pub desc: SceneDescription,
    pub scene: Entities,
    pub notes: Notes,
    pub images: Images,
    pub textures: Vec<Slot<TextureId>>,
    pub named_materials: Vec<Slot<MaterialId>>,
    pub materials: Vec<Option<MaterialId>>,
    default_material: Option<MaterialId>,
    main: PathBuf,
}

/// Turns what was read into a description.
pub(super) fn build(mut reader: Reader) -> SceneDescription {
    while let Some(open) = reader.stack.pop() {
        reader.report_open(Some(open));
    }
    if !reader.in_world && !reader.diag.has_errors() {
        let end = reader.files.first().map_or(0, |f| f.text.len()) as u32;
        let span = Span { file: 0, start: end, end };
        reader
            .diag
            .error(span, "the scene ends before `WorldBegin`")
            .hint("put `WorldBegin` between the camera and the shapes");
    }
    upgrade::report_redefined(&mut reader);
    let mut desc = SceneDescription { format: SourceFormat::Pbrt, ..SceneDescription::default() };
    desc.diagnostics = reader.diag;
    desc.sources.files = reader.files;
    let scene = reader.scene;
    let mut b = Builder {
        textures: vec![Slot::Open; scene.textures.len()],
        named_materials: vec![Slot::Open; scene.named_materials.len()],
        materials: vec![None; scene.materials.len()],
        desc,
        scene,
        notes: reader.notes,
        images: Images::default(),
        default_material: None,
        main: reader.main,
    };
    b.load_images();
    b.media();
    b.options();
    for i in 0..b.textures.len() {
        b.texture(i);
    }
    for i in 0..b.named_materials.len() {
        b.named_material(i);
    }
    for i in 0..b.materials.len() {
        let mut e = std::mem::take(&mut b.scene.materials[i]);
        let id = b.material(&mut e, "");
        b.materials[i] = Some(id);
        // The kind is asked for again by shapes.
        b.scene.materials[i].kind = e.kind;
    }
    b.lights();
    b.shapes();
    b.notes.tell(&mut b.desc.diagnostics);
    b.desc
}

impl Builder {
    /// The file a string parameter names; an error if there is none.
    pub fn file(&mut self, name: &Text, what: &str) -> Option<PathBuf> {
        let found = self.find_file(name);
        if found.is_none() {
            let message = format!("no {what} file `{}`", name.text);
            let error = self.desc.diagnostics.error(name.span, message);
            if let Some(near) = files::nearest_file(&name.text, &self.main) {
                error.hint(format!("did you mean `{near}`?"));
            }
        }
        found
    }

    /// The file a string parameter names.
    pub fn find_file(&self, name: &Text) -> Option<PathBuf> {
        let files = &self.desc.sources.files;
        let current = files.get(name.span.file as usize).and_then(|f| f.path.parent());
        files::resolve(&name.text, &self.main, current.unwrap_or(Path::new("")))
    }

    /// A spectrum parameter.
    pub fn spectrum(&mut self, e: &mut Entity, name: &'static str) -> Option<SpectrumDesc> {
        let main = self.main.clone();
        let resolve = |t: &Text| files::resolve(&t.text, &main, &main);
        e.params.spectrum(&mut self.desc.diagnostics, name, &resolve)
    }

    /// A number or float texture.
    pub fn float_texture(&mut self, e: &mut Entity, name: &'static str, default: f32) -> TextureId {
        match self.float_texture_or_none(e, name) {
            Some(id) => id,
            None => self.desc.float(default),
        }
    }

    /// A number or float texture, if one is given.
    pub fn float_texture_or_none(
        &mut self,
        e: &mut Entity,
        name: &'static str,
    ) -> Option<TextureId> {
        let order = e.order;
        let diag = &mut self.desc.diagnostics;
        let p = e.params.find(diag, name, &[ParamType::Float, ParamType::Texture])?;
        if p.ty == ParamType::Float {
            let (value, span) = (p.to_float(diag)?, p.span);
            return Some(self.desc.add_texture(TextureNode::Float(value), Some(span)));
        }
        let name = p.strings().first()?.clone();
        self.texture_by_name(&NameRef { name, order }, TextureType::Float)
    }

    /// A spectrum or spectrum texture that means a reflectance: components above 1 are cut.
    pub fn albedo(&mut self, e: &mut Entity, name: &'static str, default: f32) -> TextureId {
        match self.albedo_or_none(e, name) {
            Some(id) => id,
            None => self.constant(default),
        }
    }

    /// A reflectance, if one is given.
    pub fn albedo_or_none(&mut self, e: &mut Entity, name: &'static str) -> Option<TextureId> {
        let id = self.spectrum_texture_or_none(e, name)?;
        let place = e.params.place(name);
        if let TextureNode::Spectrum(SpectrumDesc::Rgb { rgb, .. }) =
            &mut self.desc.textures[id.0 as usize].node
            && rgb.iter().any(|&c| c > 1.0)
        {
            *rgb = rgb.map(|c| c.min(1.0));
            let message = format!("the reflectance `{name}` has a component above 1, cut at 1");
            self.notes.warning(place, message);
        }
        Some(id)
    }

    /// A spectrum or spectrum texture, if one is given.
    pub fn spectrum_texture_or_none(
        &mut self,
        e: &mut Entity,
        name: &'static str,
    ) -> Option<TextureId> {
        use ParamType::{Blackbody, Rgb, Spectrum, Texture};
        let (order, main) = (e.order, self.main.clone());
        let diag = &mut self.desc.diagnostics;
        let p = e.params.find(diag, name, &[Rgb, Spectrum, Texture, Blackbody])?;
        if p.ty != Texture {
            let span = p.span;
            let resolve = |t: &Text| files::resolve(&t.text, &main, &main);
            let spectrum = p.to_spectrum(diag, &resolve)?;
            return Some(self.desc.add_texture(TextureNode::Spectrum(spectrum), Some(span)));
        }
        let name = p.strings().first()?.clone();
        self.texture_by_name(&NameRef { name, order }, TextureType::Spectrum)
    }

    /// A texture that is the same at every wavelength and everywhere.
    pub fn constant(&mut self, value: f32) -> TextureId {
        let node = TextureNode::Spectrum(SpectrumDesc::Constant(value));
        self.desc.add_texture(node, None)
    }

    /// The texture of this name; an error if there is none.
    fn texture_by_name(&mut self, r: &NameRef, ty: TextureType) -> Option<TextureId> {
        let all = self.scene.textures.iter().enumerate().filter(|(_, t)| t.ty == ty);
        let same = all.filter(|(_, t)| t.name.text == r.name.text);
        match last_before(same.map(|(i, t)| (i, t.entity.order)), r.order) {
            Some(i) => self.texture(i),
            None => {
                self.no_such_texture(r, ty);
                None
            }
        }
    }

    fn no_such_texture(&mut self, r: &NameRef, ty: TextureType) {
        let names = |wanted: TextureType| {
            let all = self.scene.textures.iter().filter(move |t| t.ty == wanted);
            all.map(|t| t.name.text.as_str()).collect::<Vec<_>>()
        };
        let (word, other, other_word) = match ty {
            TextureType::Float => ("float", TextureType::Spectrum, "spectrum"),
            TextureType::Spectrum => ("spectrum", TextureType::Float, "float"),
        };
        let name = r.name.text.as_str();
        let hint = if names(other).contains(&name) {
            Some(format!("there is a {other_word} texture of this name, a {word} one is needed"))
        } else {
            super::nearest_name(name, &names(ty)).map(|n| format!("did you mean `{n}`?"))
        };
        let message = format!("no {word} texture is called `{name}`");
        let error = self.desc.diagnostics.error(r.name.span, message);
        if let Some(hint) = hint {
            error.hint(hint);
        }
    }

    /// The material of this name; an error, and the default one, if there is none.
    pub fn material_by_name(&mut self, r: &NameRef) -> MaterialId {
        match self.find_named_material(r) {
            Some(i) => self.named_material(i),
            None => {
                let known: Vec<&str> =
                    self.scene.named_materials.iter().map(|m| m.name.text.as_str()).collect();
                let hint = super::nearest_name(&r.name.text, &known);
                let message = format!("no material is called `{}`", r.name.text);
                let error = self.desc.diagnostics.error(r.name.span, message);
                if let Some(near) = hint {
                    error.hint(format!("did you mean `{near}`?"));
                }
                self.default_material()
            }
        }
    }

    fn find_named_material(&self, r: &NameRef) -> Option<usize> {
        let all = self.scene.named_materials.iter().enumerate();
        let same = all.filter(|(_, m)| m.name.text == r.name.text);
        last_before(same.map(|(i, m)| (i, m.entity.order)), r.order)
    }

    /// A named material, by number.
    pub fn named_material(&mut self, i: usize) -> MaterialId {
        match self.named_materials[i] {
            Slot::Done(id) => id,
            Slot::Busy => {
                let name = &self.scene.named_materials[i].name;
                let message = format!("material `{}` is made of itself", name.text);
                self.desc.diagnostics.error(name.span, message);
                self.default_material()
            }
            Slot::Open => {
                self.named_materials[i] = Slot::Busy;
                let mut e = std::mem::take(&mut self.scene.named_materials[i].entity);
                let name = self.scene.named_materials[i].name.text.clone();
                // Orders are compared while others refer to this one.
                self.scene.named_materials[i].entity.order = e.order;
                let id = self.material(&mut e, &name);
                self.scene.named_materials[i].entity.kind = e.kind;
                self.named_materials[i] = Slot::Done(id);
                id
            }
        }
    }

    /// The material a shape refers to, and its kind in the file.
    pub fn shape_material(&mut self, r: &MaterialRef) -> (MaterialId, String) {
        match r {
            MaterialRef::Default => (self.default_material(), "diffuse".into()),
            MaterialRef::Plain(i) => {
                let kind = self.scene.materials[*i].kind.text.clone();
                let id = match self.materials[*i] {
                    Some(id) => id,
                    None => self.default_material(),
                };
                (id, kind)
            }
            MaterialRef::Named(name) => {
                let id = self.material_by_name(name);
                let found = self.find_named_material(name);
                let kind = found.map(|i| self.scene.named_materials[i].entity.kind.text.clone());
                (id, kind.unwrap_or_default())
            }
        }
    }

    /// Diffuse 0.5, made when it is first needed.
    pub fn default_material(&mut self) -> MaterialId {
        if let Some(id) = self.default_material {
            return id;
        }
        let reflectance = self.constant(0.5);
        let id = self.desc.add_material("", MaterialModel::Diffuse { reflectance }, None);
        self.default_material = Some(id);
        id
    }

    /// `MakeNamedMedium`.
    fn media(&mut self) {
        const KINDS: [&str; 5] = ["homogeneous", "uniformgrid", "rgbgrid", "cloud", "nanovdb"];
        for mut m in std::mem::take(&mut self.scene.media) {
            let kind = m.entity.params.string(&mut self.desc.diagnostics, "type");
            let message = "participating media are not rendered yet, their space is left empty";
            self.notes.warning(m.name.span, message);
            match &kind {
                None => {
                    let message = format!("medium `{}` has no type", m.name.text);
                    self.desc
                        .diagnostics
                        .error(m.name.span, message)
                        .hint("add \"string type\" \"homogeneous\"");
                }
                Some(k) if k.text == "heterogeneous" || KINDS.contains(&k.text.as_str()) => {}
                Some(k) => {
                    let message = format!("unknown medium type `{}`", k.text);
                    self.desc.diagnostics.error(k.span, message).nearest(&k.text, &KINDS);
                }
            }
            let kind = kind.map_or(String::new(), |k| k.text);
            let span = Some(m.entity.span);
            self.desc.media.push(MediumDesc { name: m.name.text, kind, span });
        }
    }

    /// The medium of this name; an error if there is none.
    pub fn medium(&mut self, name: &Option<Text>) -> Option<MediumId> {
        let name = name.as_ref()?;
        if let Some(i) = self.desc.media.iter().position(|m| m.name == name.text) {
            return Some(MediumId(i as u32));
        }
        let known: Vec<&str> = self.desc.media.iter().map(|m| m.name.as_str()).collect();
        let near = super::nearest_name(&name.text, &known).map(str::to_string);
        // Every shape in its reach would repeat it.
        let message = format!("no medium is called `{}`", name.text);
        let told = self.desc.diagnostics.entries.iter().any(|d| d.span == Some(name.span));
        if !told {
            let error = self.desc.diagnostics.error(name.span, message);
            if let Some(near) = near {
                error.hint(format!("did you mean `{near}`?"));
            }
        }
        None
    }
}

/// Of definitions (number, order) of one name the last before `order`, or else the first.
pub(super) fn last_before(
    definitions: impl Iterator<Item = (usize, u32)>,
    order: u32,
) -> Option<usize> {
    let mut found = None;
    for (i, o) in definitions {
        if o < order || found.is_none() {
            found = Some(i);
        }
    }
    found
}
