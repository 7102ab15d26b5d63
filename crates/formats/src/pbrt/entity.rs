//! What the directives leave behind, before anything is looked up.

use super::param::{Param, Params, Text};
use kaustika_math::Transform;
use kaustika_scene::description::{MotionKey, Span};
use kaustika_spectra::ColorSpace;
use std::collections::HashMap;
use std::rc::Rc;

/// A thing with a kind and parameters: `Directive "kind" "type name" [ ... ]`.
#[derive(Clone, Debug, Default)]
pub(super) struct Entity {
    /// Kind, such as `sphere`, with its place.
    pub kind: Text,
    /// Its parameters.
    pub params: Params,
    /// Place of the directive.
    pub span: Span,
    /// Number of the directive; a name means the last definition before this.
    pub order: u32,
}

/// A name used, and when.
#[derive(Clone, Debug)]
pub(super) struct NameRef {
    pub name: Text,
    pub order: u32,
}

/// More names than these are not listed in advice.
const MOST_LISTED: usize = 8;

/// Definitions by name: number and order of each, in the order of the files.
#[derive(Clone, Debug, Default)]
pub(super) struct Names(HashMap<String, Vec<(usize, u32)>>);

impl Names {
    /// Adds a definition; true if the name was defined already.
    pub fn insert(&mut self, name: &str, number: usize, order: u32) -> bool {
        let definitions = self.0.entry(name.to_string()).or_default();
        definitions.push((number, order));
        definitions.len() > 1
    }

    /// What a name means: its last definition before `order`, or else the first.
    pub fn find(&self, name: &str, order: u32) -> Option<usize> {
        let definitions = self.0.get(name)?;
        let before = definitions.iter().take_while(|(_, o)| *o < order).last();
        before.or(definitions.first()).map(|(n, _)| *n)
    }

    /// "Did you mean", if a name is near; else the names, if they are few.
    pub fn hint(&self, name: &str) -> Option<String> {
        let mut known: Vec<&str> = self.0.keys().map(String::as_str).collect();
        known.sort_unstable();
        if known.is_empty() {
            return Some("none is defined".into());
        }
        let near = super::nearest_name(name, &known).map(|n| format!("did you mean `{n}`?"));
        let few = known.len() <= MOST_LISTED;
        near.or_else(|| few.then(|| format!("known: {}", known.join(", "))))
    }
}

/// The value type of a texture; each has its own names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum TextureType {
    Float,
    Spectrum,
}

/// `Texture`.
#[derive(Clone, Debug)]
pub(super) struct TextureEntity {
    pub name: Text,
    pub ty: TextureType,
    pub entity: Entity,
    /// Texture to world.
    pub transform: Transform,
}

/// `MakeNamedMaterial`; the kind is in the parameter `type`.
#[derive(Clone, Debug)]
pub(super) struct NamedMaterialEntity {
    pub name: Text,
    pub entity: Entity,
}

/// `MakeNamedMedium`.
#[derive(Clone, Debug)]
pub(super) struct MediumEntity {
    pub name: Text,
    pub entity: Entity,
    /// Medium to world.
    pub transform: Transform,
}

/// Where something stands at the start and at the end of `TransformTimes`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub transforms: [Transform; 2],
    pub times: [f32; 2],
}

impl Place {
    /// True if it stands still.
    pub fn is_still(&self) -> bool {
        self.transforms[0] == self.transforms[1]
    }

    /// As keys; none where it stands still.
    pub fn motion(&self) -> Vec<MotionKey> {
        let key = |i: usize| MotionKey { time: self.times[i], transform: self.transforms[i] };
        if self.is_still() { Vec::new() } else { vec![key(0), key(1)] }
    }

    /// True if one transform mirrors and the other does not: there is no way between them.
    pub fn turns_over(&self) -> bool {
        self.transforms[0].swaps_handedness() != self.transforms[1].swaps_handedness()
    }
}

/// `Camera`.
#[derive(Clone, Debug)]
pub(super) struct CameraEntity {
    pub entity: Entity,
    /// Camera to world.
    pub place: Place,
    pub medium: Option<Text>,
}

/// `LightSource`.
#[derive(Clone, Debug)]
pub(super) struct LightEntity {
    pub entity: Entity,
    /// Light to world.
    pub transform: Transform,
    pub medium: Option<Text>,
}

/// The current material.
#[derive(Clone, Debug, Default)]
pub(super) enum MaterialRef {
    /// None was named: diffuse 0.5.
    #[default]
    Default,
    /// Number of a `Material`.
    Plain(usize),
    /// `NamedMaterial`.
    Named(NameRef),
}

/// `Shape`.
#[derive(Clone, Debug)]
pub(super) struct ShapeEntity {
    pub entity: Entity,
    /// Object to world.
    pub place: Place,
    pub reverse: bool,
    pub material: MaterialRef,
    /// Number of its `AreaLightSource`.
    pub area_light: Option<usize>,
    pub inside: Option<Text>,
    pub outside: Option<Text>,
}

/// `ObjectBegin` ... `ObjectEnd`.
#[derive(Clone, Debug)]
pub(super) struct ObjectEntity {
    pub name: Text,
    pub shapes: Vec<ShapeEntity>,
}

/// `ObjectInstance`.
#[derive(Clone, Debug)]
pub(super) struct InstanceEntity {
    pub object: NameRef,
    pub place: Place,
    pub span: Span,
}

/// Everything read from all files.
#[derive(Clone, Debug, Default)]
pub(super) struct Entities {
    pub camera: Option<CameraEntity>,
    pub film: Option<Entity>,
    pub sampler: Option<Entity>,
    pub filter: Option<Entity>,
    pub integrator: Option<Entity>,
    pub accelerator: Option<Entity>,
    pub seed: Option<i32>,
    /// Multiplies the `edgelength` of displaced meshes.
    pub edge_scale: Option<f32>,
    pub textures: Vec<TextureEntity>,
    /// Names of textures by [`TextureType`].
    pub texture_names: [Names; 2],
    pub materials: Vec<Entity>,
    pub named_materials: Vec<NamedMaterialEntity>,
    pub material_names: Names,
    pub media: Vec<MediumEntity>,
    pub medium_names: Names,
    pub lights: Vec<LightEntity>,
    pub area_lights: Vec<Entity>,
    pub shapes: Vec<ShapeEntity>,
    pub objects: Vec<ObjectEntity>,
    pub object_names: Names,
    pub instances: Vec<InstanceEntity>,
}

/// Targets of `Attribute`, in the order of [`GraphicsState::attributes`].
pub(super) const ATTRIBUTE_TARGETS: [&str; 5] = ["shape", "light", "material", "medium", "texture"];

/// What `AttributeBegin` saves and `AttributeEnd` restores.
#[derive(Clone, Debug, Default)]
pub(super) struct GraphicsState {
    /// The current transform at the start and the end of the shutter interval.
    pub ctm: [Transform; 2],
    /// Which of them directives change.
    pub active: [bool; 2],
    pub reverse: bool,
    pub material: MaterialRef,
    pub inside: Option<Text>,
    pub outside: Option<Text>,
    pub area_light: Option<usize>,
    pub space: ColorSpace,
    /// Parameters set by `Attribute`, by target.
    pub attributes: [Rc<Vec<Param>>; 5],
}
