//! A Mitsuba scene file as a graph of objects with named parameters, before anything is made of it.

use kaustika_math::Transform;
use kaustika_scene::description::Span;
use kaustika_spectra::SpectrumDesc;
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::path::PathBuf;

/// Index into [`Document::objects`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct ObjectId(pub usize);

/// Which language an object was written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dialect {
    /// Mitsuba 0.4 to 0.6.
    V06,
    /// Mitsuba 2 and 3.
    V3,
}

/// Kinds of objects, by their tag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Kind {
    Scene,
    Shape,
    Bsdf,
    Texture,
    Emitter,
    Sensor,
    Film,
    Filter,
    Sampler,
    Integrator,
    Medium,
    Phase,
    Volume,
    Subsurface,
}

impl Kind {
    /// The kind a tag stands for.
    pub(super) fn of_tag(tag: &str) -> Option<Kind> {
        Some(match tag {
            "scene" => Kind::Scene,
            "shape" => Kind::Shape,
            "bsdf" => Kind::Bsdf,
            "texture" => Kind::Texture,
            "emitter" | "luminaire" => Kind::Emitter,
            "sensor" | "camera" => Kind::Sensor,
            "film" => Kind::Film,
            "rfilter" => Kind::Filter,
            "sampler" => Kind::Sampler,
            "integrator" => Kind::Integrator,
            "medium" => Kind::Medium,
            "phase" => Kind::Phase,
            "volume" => Kind::Volume,
            "subsurface" => Kind::Subsurface,
            _ => return None,
        })
    }

    /// The word for messages.
    pub(super) fn word(self) -> &'static str {
        match self {
            Kind::Scene => "scene",
            Kind::Shape => "shape",
            Kind::Bsdf => "bsdf",
            Kind::Texture => "texture",
            Kind::Emitter => "emitter",
            Kind::Sensor => "sensor",
            Kind::Film => "film",
            Kind::Filter => "rfilter",
            Kind::Sampler => "sampler",
            Kind::Integrator => "integrator",
            Kind::Medium => "medium",
            Kind::Phase => "phase",
            Kind::Volume => "volume",
            Kind::Subsurface => "subsurface",
        }
    }
}

/// A spectrum in a file's own terms.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum SpectrumValue {
    /// The same at every wavelength.
    Uniform(f32),
    /// Values at wavelengths.
    Table(SpectrumDesc),
}

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Boolean(bool),
    Integer(i64),
    Float(f64),
    String(String),
    Vector([f64; 3]),
    /// Linear sRGB.
    Rgb([f32; 3]),
    Spectrum(SpectrumValue),
    Blackbody {
        kelvin: f32,
        scale: f32,
    },
    /// Rows; may be singular (2D transforms).
    Transform([[f64; 4]; 4]),
    /// Rows at rising times.
    Motion(Vec<(f64, [[f64; 4]; 4])>),
    Object(ObjectId),
    /// Name of an object, not yet looked up.
    Reference(String),
}

impl Value {
    /// What it is, for messages.
    pub(super) fn word(&self) -> &'static str {
        match self {
            Value::Boolean(_) => "a boolean",
            Value::Integer(_) => "an integer",
            Value::Float(_) => "a number",
            Value::String(_) => "a string",
            Value::Vector(_) => "a vector",
            Value::Rgb(_) => "a colour",
            Value::Spectrum(_) => "a spectrum",
            Value::Blackbody { .. } => "a black body",
            Value::Transform(_) => "a transform",
            Value::Motion(_) => "an animation",
            Value::Object(_) | Value::Reference(_) => "an object",
        }
    }
}

/// A named parameter of an object; children without a name have an empty one.
#[derive(Clone, Debug)]
pub(super) struct Parameter {
    /// As Mitsuba 3 would spell it.
    pub name: String,
    /// As the file spells it.
    pub written: String,
    pub value: Value,
    /// The opening of the element.
    pub span: Span,
    /// The value itself.
    pub value_span: Span,
    /// True once something asked for it.
    pub used: Cell<bool>,
}

/// An element with a `type`.
#[derive(Clone, Debug)]
pub(super) struct Object {
    pub kind: Kind,
    /// The `type` attribute.
    pub plugin: String,
    /// The `id` attribute, or empty.
    pub id: String,
    pub dialect: Dialect,
    /// The opening of the element.
    pub span: Span,
    /// The value of the `type` attribute.
    pub type_span: Span,
    pub parameters: Vec<Parameter>,
    /// Names that were asked for: what a misspelt parameter could have meant.
    pub asked: RefCell<Vec<&'static str>>,
}

impl Object {
    /// The parameter of that name, marked as used; the last one wins.
    pub(super) fn get(&self, name: &'static str) -> Option<&Parameter> {
        let mut asked = self.asked.borrow_mut();
        if !asked.contains(&name) {
            asked.push(name);
        }
        let found = self.parameters.iter().rev().find(|p| p.name == name)?;
        found.used.set(true);
        Some(found)
    }

    /// True if the parameter is given; does not mark it.
    pub(super) fn has(&self, name: &str) -> bool {
        self.parameters.iter().any(|p| p.name == name)
    }

    /// Parameters that need no message though nothing reads them.
    pub(super) fn ignore(&self, names: &[&str]) {
        for p in self.parameters.iter().filter(|p| names.contains(&p.name.as_str())) {
            p.used.set(true);
        }
    }
}

/// All objects of a scene and how files are found.
#[derive(Debug, Default)]
pub(super) struct Document {
    pub objects: Vec<Object>,
    pub ids: HashMap<String, ObjectId>,
    /// Folders that `<path>` names, the last named first, a list a source file.
    pub paths: Vec<Vec<PathBuf>>,
}

impl Document {
    pub(super) fn object(&self, id: ObjectId) -> &Object {
        &self.objects[id.0]
    }

    /// The object a parameter holds or names.
    pub(super) fn target(&self, value: &Value) -> Option<ObjectId> {
        match value {
            Value::Object(id) => Some(*id),
            Value::Reference(name) => self.ids.get(name).copied(),
            _ => None,
        }
    }
}

/// A transform in single precision with its inverse; `None` if singular.
pub(super) fn invertible(m: &[[f64; 4]; 4]) -> Option<Transform> {
    Transform::from_rows(m.map(|row| row.map(|v| v as f32)))
}
