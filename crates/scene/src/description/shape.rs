//! Shapes and instances.

use super::{
    Curves, DisplacedMesh, Ellipsoid, MaterialId, MediumId, SdfGrid, Span, TextureId, TriMesh,
};
use kaustika_math::Transform;
use std::sync::Arc;

/// A surface: geometry, where it stands and what it is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeDesc {
    /// Name or id in the file; may be empty.
    pub name: String,
    /// Form in object space.
    pub geometry: GeometryDesc,
    /// Object to world (or to the group's space).
    pub transform: Transform,
    /// True: normals point the other way (pbrt's ReverseOrientation, Mitsuba's flip_normals).
    pub flip_normals: bool,
    /// What it is made of.
    pub material: MaterialId,
    /// Light it emits.
    pub emission: Option<EmissionDesc>,
    /// Stochastic cut-out that does not count as a path vertex (pbrt's `alpha`), in [0,1].
    pub alpha: Option<TextureId>,
    /// Medium on the side the normal points away from.
    pub interior: Option<MediumId>,
    /// Medium on the side the normal points to.
    pub exterior: Option<MediumId>,
    /// Where it was written.
    pub span: Option<Span>,
}

/// Forms, in object space.
#[derive(Clone, Debug, PartialEq)]
pub enum GeometryDesc {
    /// Triangles. Its front is the side that sees the corners anticlockwise.
    Mesh(Arc<TriMesh>),
    /// Triangles, displaced.
    Displaced(DisplacedMesh),
    /// A sphere about the origin, possibly cut: z in [z_min, z_max], azimuth up to phi_max.
    Sphere {
        /// Radius.
        radius: f32,
        /// Lower cut.
        z_min: f32,
        /// Upper cut.
        z_max: f32,
        /// Azimuth, degrees.
        phi_max: f32,
    },
    /// A disk in the plane z = height, normal +z.
    Disk {
        /// z of its plane.
        height: f32,
        /// Outer radius.
        radius: f32,
        /// Inner radius.
        inner_radius: f32,
        /// Azimuth, degrees.
        phi_max: f32,
    },
    /// A cylinder about the z axis, open at its ends, normals outward.
    Cylinder {
        /// Radius.
        radius: f32,
        /// Lower end.
        z_min: f32,
        /// Upper end.
        z_max: f32,
        /// Azimuth, degrees.
        phi_max: f32,
    },
    /// Curves with a width.
    Curves(Arc<Curves>),
    /// Ellipsoids, met from outside only.
    Ellipsoids(Arc<Vec<Ellipsoid>>),
    /// Where a sampled signed distance is zero, within the unit cube; normals outward.
    SdfGrid(Arc<SdfGrid>),
    /// The square [-1,1]² in the plane z = 0, normal +z, uv = (xy + 1)/2.
    Rectangle,
    /// The cube [-1,1]³, normals outward, uv over each face.
    Cube,
    /// Four corners interpolated bilinearly: p00, p10, p01, p11 (pbrt's bilinearmesh).
    BilinearPatches {
        /// Corners, four indices a patch.
        positions: Vec<kaustika_math::Vec3>,
        /// Four corners a patch.
        indices: Vec<[u32; 4]>,
        /// Normals at the corners or empty.
        normals: Vec<kaustika_math::Vec3>,
        /// uv at the corners or empty.
        uvs: Vec<kaustika_math::Vec2>,
    },
}

/// Light emitted by a shape.
#[derive(Clone, Debug, PartialEq)]
pub struct EmissionDesc {
    /// Radiance, W/(m² sr); may vary over uv.
    pub radiance: TextureId,
    /// Multiplies it.
    pub scale: f32,
    /// Total power the shape is to emit, W, instead of `scale` (pbrt's `power`).
    pub power: Option<f32>,
    /// True: both sides emit.
    pub two_sided: bool,
    /// True: the front shines along its normal alone, and `radiance` is its power per area, W/m²
    /// (Mitsuba 3's `directionalarea`).
    pub along_normal: bool,
    /// Where it was written.
    pub span: Option<Span>,
}

/// Index into [`super::SceneDescription::groups`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct GroupId(pub u32);

/// Shapes that are placed as one (pbrt's ObjectBegin, Mitsuba's shapegroup).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GroupDesc {
    /// Its name.
    pub name: String,
    /// Shapes in the group's space.
    pub shapes: Vec<ShapeDesc>,
}

/// A group placed in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct InstanceDesc {
    /// Which.
    pub group: GroupId,
    /// Group space to world.
    pub transform: Transform,
    /// How it moves, at rising times; empty where it stands still.
    pub motion: Vec<MotionKey>,
    /// Where it was written.
    pub span: Option<Span>,
}

/// Where something stands at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionKey {
    /// In the unit of the camera's shutter.
    pub time: f32,
    /// Own space to world.
    pub transform: Transform,
}
