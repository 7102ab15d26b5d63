//! Triangle meshes as files give them.

use super::TextureId;
use kaustika_math::{Vec2, Vec3};
use std::sync::Arc;

/// Triangles over shared vertices, in object space.
///
/// `normals`, `uvs` and the attributes are empty or as long as `positions` (attributes with
/// `per_face` as long as `indices`). Quads are split by the readers along the diagonal 0-2.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Shading normals, unit or zero, or empty.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, or empty.
    pub uvs: Vec<Vec2>,
    /// Three vertex numbers a triangle, all below `positions.len()`.
    pub indices: Vec<[u32; 3]>,
    /// Further values on vertices or faces, such as colours.
    pub attributes: Vec<MeshAttribute>,
}

/// A mesh that a texture moves along its normals.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplacedMesh {
    /// The mesh as it is before.
    pub mesh: Arc<TriMesh>,
    /// How far, in object space.
    pub height: TextureId,
    /// Edges are halved until they are shorter than this in world space; above 0.
    pub edge_length: f32,
}

/// Named values on the vertices or faces of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshAttribute {
    /// Its name in the file, as Mitsuba writes it: `vertex_color`, `face_color`, ...
    pub name: String,
    /// Numbers a vertex (or face): 1 or 3.
    pub channels: u32,
    /// True if the values belong to faces.
    pub per_face: bool,
    /// `channels` numbers an element.
    pub values: Vec<f32>,
}
