//! From a [`Document`] to a scene description: the walk over the scene and what all objects need.

use super::document::{Dialect, Document, Kind, Object, ObjectId, Parameter, Value};
use super::resources::Pending;
use super::textures::Role;
use super::{document, parse, upgrade};
use crate::measured::MeasuredFiles;
use kaustika_math::{Transform, Vec3};
use kaustika_scene::description::{
    Diagnostic, GroupId, MaterialId, MediumId, MotionKey, SceneDescription, Span, TextureId,
};
use std::collections::{HashMap, HashSet};

/// Fills a description from a document. Objects that are referred to repeatedly become one
/// texture, material, medium or group.
pub(super) struct Converter<'a> {
    pub document: &'a Document,
    pub out: SceneDescription,
    pub materials: HashMap<ObjectId, MaterialId>,
    pub textures: HashMap<(ObjectId, Role), TextureId>,
    pub groups: HashMap<ObjectId, GroupId>,
    pub media: HashMap<ObjectId, MediumId>,
    /// Objects being converted, to find circles.
    active: Vec<ObjectId>,
    /// Objects whose unknown parameters were reported.
    finished: HashSet<ObjectId>,
    pub pending: Pending,
    pub measured: MeasuredFiles,
    /// Feature layers that an `aov` integrator asks for.
    pub aovs: Vec<String>,
}

impl<'a> Converter<'a> {
    pub(super) fn new(document: &'a Document, out: SceneDescription) -> Converter<'a> {
        Converter {
            document,
            out,
            materials: HashMap::new(),
            textures: HashMap::new(),
            groups: HashMap::new(),
            media: HashMap::new(),
            active: Vec::new(),
            finished: HashSet::new(),
            pending: Pending::default(),
            measured: MeasuredFiles::default(),
            aovs: Vec::new(),
        }
    }

    /// Converts all that stands directly in the scene.
    pub(super) fn scene(&mut self, root: ObjectId) {
        self.report_dangling_references();
        let scene = self.object(root);
        let children: Vec<(&'a Parameter, ObjectId)> =
            scene.parameters.iter().filter_map(|p| Some((p, self.target(p)?))).collect();
        for (parameter, child) in &children {
            parameter.used.set(true);
            match self.object(*child).kind {
                Kind::Shape => self.shape(*child),
                Kind::Emitter => self.emitter(*child),
                Kind::Sensor => self.sensor(*child),
                Kind::Integrator => self.integrator(*child),
                Kind::Bsdf => {
                    self.material(*child);
                }
                Kind::Medium => {
                    self.medium(*child);
                }
                // Made when something refers to them.
                Kind::Texture | Kind::Phase | Kind::Volume | Kind::Subsurface => {}
                kind => {
                    let message = format!("a {} does not stand directly in the scene", kind.word());
                    self.out.diagnostics.warning(parameter.span, message);
                }
            }
        }
        if self.out.integrator.name.is_empty() {
            self.out.integrator.name = "path".to_string();
        }
        if self.out.cameras.is_empty() && !self.out.diagnostics.has_errors() {
            self.out
                .diagnostics
                .warning(scene.span, "the scene has no camera")
                .hint("add `<sensor type=\"perspective\">`");
        }
        for camera in &mut self.out.cameras {
            camera.film.aovs = self.aovs.clone();
        }
    }

    fn report_dangling_references(&mut self) {
        for object in &self.document.objects {
            for p in &object.parameters {
                let Value::Reference(id) = &p.value else { continue };
                if !self.document.ids.contains_key(id) {
                    p.used.set(true);
                    let message = format!("no object has the id `{id}`");
                    let error = self.out.diagnostics.error(p.value_span, message);
                    suggest(error, id, &parse::known_ids(self.document));
                }
            }
        }
    }

    pub(super) fn object(&self, id: ObjectId) -> &'a Object {
        self.document.object(id)
    }

    pub(super) fn target(&self, parameter: &Parameter) -> Option<ObjectId> {
        self.document.target(&parameter.value)
    }

    /// Children of a kind, in order, by whatever name; marks them as used.
    pub(super) fn children(
        &self,
        object: &'a Object,
        kind: Kind,
    ) -> Vec<(&'a Parameter, ObjectId)> {
        let of_kind = |p: &'a Parameter| {
            let id = self.target(p)?;
            (self.object(id).kind == kind).then(|| {
                p.used.set(true);
                (p, id)
            })
        };
        object.parameters.iter().filter_map(of_kind).collect()
    }

    /// The only child of a kind; more are an error.
    pub(super) fn child(
        &mut self,
        object: &'a Object,
        kind: Kind,
    ) -> Option<(&'a Parameter, ObjectId)> {
        let children = self.children(object, kind);
        if let Some((second, _)) = children.get(1) {
            let (what, word) = (object.kind.word(), kind.word());
            self.out
                .diagnostics
                .error(second.span, format!("{what} `{}` takes one {word} only", object.plugin));
        }
        children.first().copied()
    }

    /// Runs `make` unless the object is being made already: a circle of references.
    pub(super) fn guarded<T>(
        &mut self,
        id: ObjectId,
        make: impl FnOnce(&mut Self) -> T,
    ) -> Option<T> {
        if self.active.contains(&id) {
            let object = self.object(id);
            let message = format!("{} `{}` refers to itself", object.kind.word(), object.id);
            self.out.diagnostics.error(object.span, message);
            // What it has not asked for yet is no fault of the file's.
            object.parameters.iter().for_each(|p| p.used.set(true));
            return None;
        }
        self.active.push(id);
        let made = make(self);
        self.active.pop();
        Some(made)
    }

    /// A parameter has a value of the wrong kind.
    pub(super) fn wrong_type(&mut self, object: &Object, parameter: &Parameter, expected: &str) {
        let found = match self.target(parameter) {
            Some(id) => format!("a {}", self.object(id).kind.word()),
            None => parameter.value.word().to_string(),
        };
        let message = format!(
            "`{}` of {} `{}` must be {expected}, found {found}",
            parameter.written,
            object.kind.word(),
            object.plugin
        );
        self.out.diagnostics.error(parameter.span, message);
    }

    pub(super) fn optional_number(
        &mut self,
        object: &'a Object,
        name: &'static str,
    ) -> Option<f32> {
        let p = object.get(name)?;
        match p.value {
            Value::Float(v) => Some(v as f32),
            Value::Integer(v) => Some(v as f32),
            _ => {
                self.wrong_type(object, p, "a number");
                None
            }
        }
    }

    pub(super) fn number(&mut self, object: &'a Object, name: &'static str, default: f32) -> f32 {
        self.optional_number(object, name).unwrap_or(default)
    }

    pub(super) fn integer(&mut self, object: &'a Object, name: &'static str) -> Option<i64> {
        let p = object.get(name)?;
        match p.value {
            Value::Integer(v) => Some(v),
            Value::Float(v) if v.fract() == 0.0 && v.abs() < 1e15 => Some(v as i64),
            _ => {
                self.wrong_type(object, p, "an integer");
                None
            }
        }
    }

    pub(super) fn boolean(
        &mut self,
        object: &'a Object,
        name: &'static str,
        default: bool,
    ) -> bool {
        let Some(p) = object.get(name) else { return default };
        match p.value {
            Value::Boolean(v) => v,
            _ => {
                self.wrong_type(object, p, "a boolean");
                default
            }
        }
    }

    /// The text and where it stands.
    pub(super) fn string(
        &mut self,
        object: &'a Object,
        name: &'static str,
    ) -> Option<(&'a str, Span)> {
        let p = object.get(name)?;
        match &p.value {
            Value::String(v) => Some((v.as_str(), p.value_span)),
            _ => {
                self.wrong_type(object, p, "a string");
                None
            }
        }
    }

    /// One of the words of a list; anything else is an error and the default is taken.
    pub(super) fn choice<T: Copy>(
        &mut self,
        object: &'a Object,
        name: &'static str,
        choices: &[(&'static str, T)],
        default: T,
    ) -> T {
        let Some((text, span)) = self.string(object, name) else { return default };
        let lower = text.to_ascii_lowercase();
        if let Some((_, value)) = choices.iter().find(|(word, _)| *word == lower) {
            return *value;
        }
        let known: Vec<&str> = choices.iter().map(|(word, _)| *word).collect();
        self.out
            .diagnostics
            .error(span, format!("`{name}` can't be `{text}`"))
            .nearest(text, &known);
        default
    }

    pub(super) fn vector(&mut self, object: &'a Object, name: &'static str) -> Option<[f64; 3]> {
        let p = object.get(name)?;
        match p.value {
            Value::Vector(v) => Some(v),
            _ => {
                self.wrong_type(object, p, "a point or vector");
                None
            }
        }
    }

    /// A transform that must have an inverse; the identity if it is not given, and the first
    /// where it moves, with a warning.
    pub(super) fn transform(&mut self, object: &'a Object, name: &'static str) -> Transform {
        let (transform, keys) = self.placement(object, name);
        if !keys.is_empty() {
            let span = object.get(name).map_or(object.span, |p| p.span);
            let message = format!("a {} does not move here", object.kind.word());
            self.out.diagnostics.warning(span, message).label("the first key stands for all");
        }
        transform
    }

    /// A transform that must have an inverse, and the keys if it moves.
    pub(super) fn placement(
        &mut self,
        object: &'a Object,
        name: &'static str,
    ) -> (Transform, Vec<MotionKey>) {
        let Some(p) = object.get(name) else { return (Transform::IDENTITY, Vec::new()) };
        match &p.value {
            Value::Transform(m) => (self.invertible(object, p, m), Vec::new()),
            Value::Motion(keys) => {
                let keys: Vec<MotionKey> = keys
                    .iter()
                    .map(|(time, m)| MotionKey {
                        time: *time as f32,
                        transform: self.invertible(object, p, m),
                    })
                    .collect();
                (keys[0].transform, keys)
            }
            _ => {
                self.wrong_type(object, p, "a transform");
                (Transform::IDENTITY, Vec::new())
            }
        }
    }

    /// The transform of a matrix; an error, and the identity, if it has no inverse.
    fn invertible(&mut self, object: &Object, p: &Parameter, m: &[[f64; 4]; 4]) -> Transform {
        document::invertible(m).unwrap_or_else(|| {
            let message = format!("the transform `{}` has no inverse", spelling(object, &p.name));
            let error = self.out.diagnostics.error(p.span, message);
            error.hint("no axis may be scaled by zero");
            Transform::IDENTITY
        })
    }

    /// The file a parameter names; none is an error.
    pub(super) fn file(
        &mut self,
        object: &'a Object,
        name: &'static str,
    ) -> Option<(std::path::PathBuf, Span)> {
        let Some((text, span)) = self.string(object, name) else {
            if !object.has(name) {
                let message = format!("{} `{}` needs `{name}`", object.kind.word(), object.plugin);
                self.out.diagnostics.error(object.span, message);
            }
            return None;
        };
        let found = super::find::find(self.document, &self.out.sources, span.file, text);
        if found.is_none() {
            self.out
                .diagnostics
                .error(span, format!("can't find the file `{text}`"))
                .hint(super::find::WHERE_LOOKED);
        }
        found.map(|path| (path, span))
    }

    /// Warns of parameters that nothing asked for. Every object is reported on once, when it has
    /// been converted.
    pub(super) fn finish(&mut self, id: ObjectId) {
        if !self.finished.insert(id) {
            return;
        }
        let object = self.object(id);
        for p in object.parameters.iter().filter(|p| !p.used.get()) {
            let (what, plugin) = (object.kind.word(), &object.plugin);
            if p.name.is_empty() {
                let child = self.target(p).map_or("object", |c| self.object(c).kind.word());
                let message = format!("{what} `{plugin}` has no use for this {child}");
                self.out.diagnostics.warning(p.span, message);
            } else {
                let message = format!("unknown parameter `{}` of {what} `{plugin}`", p.written);
                let asked = object.asked.borrow();
                let known = asked.iter().map(|name| spelling(object, name));
                let known: Vec<String> = known.collect();
                let warning = self.out.diagnostics.warning(p.span, message);
                suggest(warning, &p.written, &known);
            }
        }
    }

    /// An unknown `type`: an error that names the nearest one.
    pub(super) fn unknown_plugin(&mut self, object: &Object, known: &[&str]) {
        let message = format!("unknown {} `{}`", object.kind.word(), object.plugin);
        self.out.diagnostics.error(object.type_span, message).nearest(&object.plugin, known);
    }

    /// A known `type` that Kaustika lacks: says what stands in for it. Its parameters are not
    /// reported one by one.
    pub(super) fn replaced(&mut self, object: &Object, instead: &str) {
        for p in &object.parameters {
            p.used.set(true);
        }
        let message = format!("{} `{}` is not supported", object.kind.word(), object.plugin);
        self.out.diagnostics.warning(object.type_span, message).label(instead);
    }
}

/// A parameter's name as the object's dialect spells it.
pub(super) fn spelling(object: &Object, name: &str) -> String {
    if old(object) { upgrade::camel_case(name) } else { name.to_string() }
}

/// Advises the nearest known name, or lists them; says nothing where there are none.
pub(super) fn suggest<S: AsRef<str>>(diagnostic: &mut Diagnostic, found: &str, known: &[S]) {
    let known: Vec<&str> = known.iter().map(AsRef::as_ref).collect();
    if !known.is_empty() {
        diagnostic.nearest(found, &known);
    }
}

/// True for files of Mitsuba 0.4 to 0.6.
pub(super) fn old(object: &Object) -> bool {
    object.dialect == Dialect::V06
}

/// In single precision.
pub(super) fn vec3(v: [f64; 3]) -> Vec3 {
    Vec3::new(v[0] as f32, v[1] as f32, v[2] as f32)
}
