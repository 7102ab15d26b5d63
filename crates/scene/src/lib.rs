//! What is there: shapes, textures, materials, lights, cameras; answers queries.
//!
//! A [`description::SceneDescription`] says what a file says; [`Scene::build`] makes of it the
//! immutable [`Scene`] that methods ask: what does this ray meet, how does it scatter there,
//! which light, from where.

mod batch;
pub mod bsdf;
mod build;
mod camera;
mod chart;
mod curvature;
pub mod description;
mod displace;
mod error;
mod facets;
mod geometry;
pub mod lanes;
mod light;
mod material;
pub mod medium;
mod moving;
pub mod polarization;
mod scene;
mod shape;
mod surface;
mod tessellate;
mod texture;
mod whereabouts;

pub use batch::RayBatch;
pub use build::SceneOptions;
pub use camera::{Camera, CameraConnection, CameraRay, CameraRays, FlatView, LensHit};
pub use chart::ChartPoint;
pub use error::BuildError;
pub use facets::{Facet, FacetId};
pub use geometry::{Geometry, Hit, Primitive};
pub use kaustika_accel::Segment;
pub use light::{
    AreaLight, AreaShape, EmittedRay, Escaped, LearnedLights, Light, LightChoice, LightSample,
    LightSelection, LightSelectionKind, ShadingPoint,
};
pub use material::{Looks, Materials, Tint};
pub use medium::Medium;
pub use scene::{Scene, ShapeInfo};
pub use shape::ShapeSample;
pub use surface::{LightId, Surface};
pub use texture::{BitmapSampler, TexturePoint, Textures};
