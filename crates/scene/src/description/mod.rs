//! What a scene file says, free of any file format: the readers' output, the builder's input.
//!
//! Everything refers to everything by index; meshes and images are already loaded (a reader
//! knows best where to look for a file and which line to blame). World space is the file's.

mod bitmap;
mod camera;
mod curve;
mod ellipsoid;
mod grating;
mod hair;
mod lens;
mod light;
mod material;
mod measured;
mod medium;
mod mesh;
mod metallic_roughness;
mod sdf;
mod shape;
mod source;
mod texture;

pub use bitmap::{Bitmap, Encoding, Texels};
pub use camera::{
    BandsDesc, CameraDesc, CameraKind, FilmDesc, FilterChoice, FovAxis, GBufferSpace,
    IntegratorDesc, MeterTarget,
};
pub use curve::{CurveProfile, CurveSegment, Curves};
pub use ellipsoid::Ellipsoid;
pub use grating::{GratingDesc, GratingProfileDesc};
pub use hair::{FibreLayout, HairAbsorption, HairDesc};
pub use lens::{ApertureShape, LensDesc, LensSurface};
pub use light::{EnvironmentLayout, LightDesc, LightKind, SkyDesc, SpotFalloff};
pub use material::{
    CoatDesc, ConductorColor, Distribution, FilterModel, IorDesc, MaterialDesc, MaterialId,
    MaterialModel, PrincipledDesc, RoughnessDesc, WardVariant,
};
pub use measured::{
    MeasuredBrdf, MeasuredChannels, MeasuredMueller, MeasuredPolarizedDesc, SquareTable,
};
pub use medium::{
    CloudDesc, CoefficientsDesc, DensityDesc, FieldDesc, GlowDesc, GlowSource, GridDesc,
    GridFilter, GridLayout, MediumDesc, MediumId, PhaseDesc, SggxDesc,
};
pub use mesh::{DisplacedMesh, MeshAttribute, TriMesh};
pub use metallic_roughness::{
    AnisotropyDesc, ClearcoatDesc, DiffuseTransmissionDesc, IridescenceDesc, MetallicRoughnessDesc,
    SheenDesc, TangentSpace, VolumeDesc,
};
pub use sdf::{SdfGrid, SdfNormals};
pub use shape::{
    EmissionDesc, GeometryDesc, GroupDesc, GroupId, InstanceDesc, MotionKey, ShapeDesc,
};
pub use source::{
    Diagnostic, Diagnostics, Severity, SourceFile, SourceMap, Span, known_names, nearest_name,
};
pub use texture::{
    BitmapChannels, BitmapFilter, BitmapTexture, NoiseKind, TextureDesc, TextureId, TextureMapping,
    TextureNode, Wrap,
};

/// Where a description came from; decides defaults that differ between the formats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SourceFormat {
    /// Made by a program.
    #[default]
    BuiltIn,
    /// pbrt-v4 (or v3, upgraded).
    Pbrt,
    /// Mitsuba 2 and 3.
    Mitsuba3,
    /// Mitsuba 0.4 to 0.6.
    Mitsuba06,
    /// glTF 2.0.
    Gltf,
}

/// A whole scene as a file says it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneDescription {
    /// Format it was read from.
    pub format: SourceFormat,
    /// The files read.
    pub sources: SourceMap,
    /// What there is to say about them.
    pub diagnostics: Diagnostics,
    /// Cameras; the first is the default.
    pub cameras: Vec<CameraDesc>,
    /// The method asked for.
    pub integrator: IntegratorDesc,
    /// Texture nodes.
    pub textures: Vec<TextureDesc>,
    /// Materials.
    pub materials: Vec<MaterialDesc>,
    /// Media.
    pub media: Vec<MediumDesc>,
    /// Shapes in world space.
    pub shapes: Vec<ShapeDesc>,
    /// Shapes placed by instances.
    pub groups: Vec<GroupDesc>,
    /// Placements.
    pub instances: Vec<InstanceDesc>,
    /// Lights without surface.
    pub lights: Vec<LightDesc>,
}

impl SceneDescription {
    /// Adds a texture node.
    pub fn add_texture(&mut self, node: TextureNode, span: Option<Span>) -> TextureId {
        self.textures.push(TextureDesc { node, span });
        TextureId(self.textures.len() as u32 - 1)
    }

    /// Adds a material.
    pub fn add_material(
        &mut self,
        name: impl Into<String>,
        model: MaterialModel,
        span: Option<Span>,
    ) -> MaterialId {
        self.materials.push(MaterialDesc { name: name.into(), model, span });
        MaterialId(self.materials.len() as u32 - 1)
    }

    /// Adds a texture that is the same number everywhere.
    pub fn float(&mut self, value: f32) -> TextureId {
        self.add_texture(TextureNode::Float(value), None)
    }

    /// Adds a texture that is the same linear sRGB colour everywhere.
    pub fn rgb(&mut self, rgb: [f32; 3]) -> TextureId {
        let space = kaustika_spectra::ColorSpace::Srgb;
        let desc = kaustika_spectra::SpectrumDesc::Rgb { rgb, space };
        self.add_texture(TextureNode::Spectrum(desc), None)
    }
}
