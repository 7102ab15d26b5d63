//! What the directives leave behind, before anything is looked up.

use super::param::{Param, Params, Text};
use kaustika_math::Transform;
use kaustika_scene::description::Span;
use kaustika_spectra::ColorSpace;
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
}

/// `Camera`.
#[derive(Clone, Debug)]
pub(super) struct CameraEntity {
    pub entity: Entity,
    /// Camera to world.
    pub transform: Transform,
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
    pub transform: Transform,
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
    pub order: u32,
    pub shapes: Vec<ShapeEntity>,
}

/// `ObjectInstance`.
#[derive(Clone, Debug)]
pub(super) struct InstanceEntity {
    pub object: NameRef,
    pub transform: Transform,
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
    pub textures: Vec<TextureEntity>,
    pub materials: Vec<Entity>,
    pub named_materials: Vec<NamedMaterialEntity>,
    pub media: Vec<MediumEntity>,
    pub lights: Vec<LightEntity>,
    pub area_lights: Vec<Entity>,
    pub shapes: Vec<ShapeEntity>,
    pub objects: Vec<ObjectEntity>,
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
