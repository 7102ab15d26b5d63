//! From entities to the scene description: names, defaults, references.

use super::entity::{Entities, Entity, MaterialRef, NameRef, TextureType};
use super::files;
use super::images::Images;
use super::notes::Notes;
use super::param::{ParamType, Text};
use super::reader::Reader;
use super::upgrade;
use crate::measured::MeasuredFiles;
use kaustika_scene::description::{
    EmissionDesc, MaterialId, MaterialModel, MediumId, SceneDescription, SourceFile, SourceFormat,
    Span, TextureId, TextureNode,
};
use kaustika_spectra::SpectrumDesc;
use std::collections::{HashMap, HashSet};
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
    pub measured: MeasuredFiles,
    pub textures: Vec<Slot<TextureId>>,
    pub named_materials: Vec<Slot<MaterialId>>,
    pub materials: Vec<Option<MaterialId>>,
    /// What each `AreaLightSource` makes shapes emit.
    pub emissions: Vec<Option<Option<EmissionDesc>>>,
    /// Definitions that are being built within one another.
    pub depth: usize,
    default_material: Option<MaterialId>,
    /// What fills shapes of a material that scatters below the surface.
    pub insides: HashMap<MaterialId, MediumId>,
    /// Places of names that were reported as unknown.
    unknown: HashSet<u64>,
    main: PathBuf,
}

/// Definitions that may refer to one another in a row.
pub(super) const MAX_DEPTH: usize = 200;

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
        emissions: vec![None; scene.area_lights.len()],
        desc,
        scene,
        notes: reader.notes,
        images: Images::default(),
        measured: MeasuredFiles::default(),
        depth: 0,
        default_material: None,
        insides: HashMap::new(),
        unknown: HashSet::new(),
        main: reader.main,
    };
    b.load_images();
    b.media();
    b.options();
    for i in 0..b.textures.len() {
        b.texture(i, b.scene.textures[i].name.span);
    }
    for i in 0..b.named_materials.len() {
        b.named_material(i, b.scene.named_materials[i].name.span);
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
            error.hint(match files::nearest_file(&name.text, &self.main) {
                Some(near) => format!("did you mean `{near}`?"),
                None => files::WHERE_LOOKED.into(),
            });
        }
        found
    }

    /// The file a string parameter names.
    pub fn find_file(&self, name: &Text) -> Option<PathBuf> {
        find_file(&self.desc.sources.files, &self.main, name)
    }

    /// A spectrum parameter.
    pub fn spectrum(&mut self, e: &mut Entity, name: &'static str) -> Option<SpectrumDesc> {
        let (files, main) = (&self.desc.sources.files, &self.main);
        let resolve = |t: &Text| find_file(files, main, t);
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
            let (value, span) = (p.number(diag)?, p.span);
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
        let (files, main) = (&self.desc.sources.files, &self.main);
        let resolve = |t: &Text| find_file(files, main, t);
        let diag = &mut self.desc.diagnostics;
        let p = e.params.find(diag, name, &[Rgb, Spectrum, Texture, Blackbody])?;
        if p.ty != Texture {
            let span = p.span;
            let spectrum = p.spectrum(diag, &resolve)?;
            return Some(self.desc.add_texture(TextureNode::Spectrum(spectrum), Some(span)));
        }
        let r = NameRef { name: p.strings().first()?.clone(), order: e.order };
        self.texture_by_name(&r, TextureType::Spectrum)
    }

    /// A texture that is the same at every wavelength and everywhere.
    pub fn constant(&mut self, value: f32) -> TextureId {
        let node = TextureNode::Spectrum(SpectrumDesc::Constant(value));
        self.desc.add_texture(node, None)
    }

    /// The texture of this name; an error if there is none.
    fn texture_by_name(&mut self, r: &NameRef, ty: TextureType) -> Option<TextureId> {
        match self.scene.texture_names[ty as usize].find(&r.name.text, r.order) {
            Some(i) => self.texture(i, r.name.span),
            None => {
                self.no_such_texture(r, ty);
                None
            }
        }
    }

    fn no_such_texture(&mut self, r: &NameRef, ty: TextureType) {
        let (word, other, other_word) = match ty {
            TextureType::Float => ("float", TextureType::Spectrum, "spectrum"),
            TextureType::Spectrum => ("spectrum", TextureType::Float, "float"),
        };
        let (name, names) = (r.name.text.as_str(), &self.scene.texture_names);
        let hint = match names[other as usize].find(name, r.order) {
            Some(_) => {
                Some(format!("there is a {other_word} texture of this name, {word} is needed"))
            }
            None => names[ty as usize].hint(name),
        };
        let message = format!("no {word} texture is called `{name}`");
        let error = self.desc.diagnostics.error(r.name.span, message);
        error.hint = hint;
    }

    /// The material of this name; an error, and the default one, if there is none.
    pub fn material_by_name(&mut self, r: &NameRef) -> MaterialId {
        match self.scene.material_names.find(&r.name.text, r.order) {
            Some(i) => self.named_material(i, r.name.span),
            None => {
                // Every shape in its reach would repeat it.
                if self.unknown.insert(key(r.name.span)) {
                    let message = format!("no material is called `{}`", r.name.text);
                    let error = self.desc.diagnostics.error(r.name.span, message);
                    error.hint = self.scene.material_names.hint(&r.name.text);
                }
                self.default_material()
            }
        }
    }

    /// A named material, by number; `from` names it.
    pub fn named_material(&mut self, i: usize, from: Span) -> MaterialId {
        match self.named_materials[i] {
            Slot::Done(id) => id,
            Slot::Busy => {
                let name = &self.scene.named_materials[i].name;
                let message = format!("material `{}` is made of itself", name.text);
                self.desc.diagnostics.error(from, message);
                self.default_material()
            }
            Slot::Open if self.depth >= MAX_DEPTH => {
                self.too_deep(from);
                self.default_material()
            }
            Slot::Open => {
                self.named_materials[i] = Slot::Busy;
                self.depth += 1;
                let mut e = std::mem::take(&mut self.scene.named_materials[i].entity);
                let name = self.scene.named_materials[i].name.text.clone();
                let id = self.material(&mut e, &name);
                self.scene.named_materials[i].entity.kind = e.kind;
                self.named_materials[i] = Slot::Done(id);
                self.depth -= 1;
                id
            }
        }
    }

    /// Reports that things refer to one another too often in a row.
    pub fn too_deep(&mut self, from: Span) {
        let message = format!("more than {MAX_DEPTH} definitions refer to one another in a row");
        self.desc.diagnostics.error(from, message);
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
                let found = self.scene.material_names.find(&name.name.text, name.order);
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

    /// The medium of this name; an error if there is none.
    pub fn medium(&mut self, name: &Option<Text>) -> Option<MediumId> {
        let name = name.as_ref()?;
        let found = self.scene.medium_names.find(&name.text, u32::MAX);
        // Every shape in its reach would repeat it.
        if found.is_none() && self.unknown.insert(key(name.span)) {
            let message = format!("no medium is called `{}`", name.text);
            let error = self.desc.diagnostics.error(name.span, message);
            error.hint = self.scene.medium_names.hint(&name.text);
        }
        found.map(|i| MediumId(i as u32))
    }
}

/// The file that a string means, which stands in one of `sources`.
fn find_file(sources: &[SourceFile], main: &Path, name: &Text) -> Option<PathBuf> {
    let current = sources.get(name.span.file as usize).and_then(|f| f.path.parent());
    files::resolve(&name.text, main, current.unwrap_or(Path::new("")))
}

/// A place as one number.
fn key(span: Span) -> u64 {
    (span.file as u64) << 32 | span.start as u64
}
