//! Triangles of all meshes in flat arrays, in the space of their group.

use super::ShapeSample;
use crate::surface::{LightId, Surface};
use kaustika_math::ray::triangle_point_error;
use kaustika_math::{Vec2, Vec3, warp};

/// A mesh's part of the arrays.
#[derive(Clone, Copy, Debug, Default)]
pub struct MeshRange {
    /// Shape in the scene's list.
    pub shape: u32,
    /// First triangle.
    pub first: u32,
    /// Number of triangles.
    pub count: u32,
    /// True if its vertices carry shading normals.
    pub has_normals: bool,
    /// True if its vertices carry texture coordinates.
    pub has_uvs: bool,
    /// True if normals point the other way.
    pub flip: bool,
    /// The first of one light a triangle, if the mesh emits.
    pub first_light: Option<u32>,
}

/// All triangles. Normals and uvs are as long as positions once any mesh has them.
#[derive(Debug, Default)]
pub struct TriangleStore {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Vertex normals (zero where a mesh has none), or empty.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, or empty.
    pub uvs: Vec<Vec2>,
    /// Vertices of each triangle.
    pub indices: Vec<[u32; 3]>,
    /// Mesh of each triangle.
    pub mesh_of: Vec<u32>,
    /// The meshes.
    pub meshes: Vec<MeshRange>,
}

impl TriangleStore {
    /// The mesh that a triangle belongs to.
    #[inline]
    pub fn mesh(&self, triangle: u32) -> &MeshRange {
        &self.meshes[self.mesh_of[triangle as usize] as usize]
    }

    /// Corners of a triangle.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.indices[triangle as usize].map(|i| self.positions[i as usize])
    }

    /// Texture coordinates of the corners; (0,0), (1,0), (1,1) where the mesh has none.
    #[inline]
    pub fn corner_uvs(&self, triangle: u32) -> [Vec2; 3] {
        if self.mesh(triangle).has_uvs {
            self.indices[triangle as usize].map(|i| self.uvs[i as usize])
        } else {
            [Vec2::new(0.0, 0.0), Vec2::new(1.0, 0.0), Vec2::new(1.0, 1.0)]
        }
    }

    /// Area.
    pub fn area(&self, triangle: u32) -> f32 {
        let [a, b, c] = self.corners(triangle);
        0.5 * (b - a).cross(c - a).length()
    }

    /// Geometric normal of the front side: of the corners' winding, turned to the side of the
    /// shading normal `ns` (of any length) where there is one, reversed if the mesh asks for it.
    #[inline]
    fn geometric_normal([p0, p1, p2]: [Vec3; 3], mesh: &MeshRange, ns: Option<Vec3>) -> Vec3 {
        let n = (p1 - p0).cross(p2 - p0).normalize();
        let n = if mesh.flip { -n } else { n };
        match ns {
            Some(ns) => n.face_forward(ns),
            None => n,
        }
    }

    /// Interpolated shading normal, not unit; zero if the vertices cancel. `None` where the mesh
    /// has none.
    #[inline]
    fn interpolated_normal(&self, triangle: u32, mesh: &MeshRange, b: [f32; 3]) -> Option<Vec3> {
        if !mesh.has_normals {
            return None;
        }
        let [i, j, k] = self.indices[triangle as usize].map(|i| self.normals[i as usize]);
        let n = i * b[0] + j * b[1] + k * b[2];
        Some(if mesh.flip { -n } else { n })
    }

    /// Surface parameters at barycentric weights `b`.
    #[inline]
    pub fn uv(&self, triangle: u32, b: [f32; 3]) -> Vec2 {
        let uvs = self.corner_uvs(triangle);
        uvs[0] * b[0] + uvs[1] * b[1] + uvs[2] * b[2]
    }

    /// The surface at barycentric weights `b`, met at ray parameter `t`.
    #[inline]
    pub fn surface(&self, triangle: u32, b: [f32; 3], t: f32, time: f32) -> Surface {
        let mesh = self.mesh(triangle);
        let corners = self.corners(triangle);
        let [p0, p1, p2] = corners;
        let interpolated = self.interpolated_normal(triangle, mesh, b);
        let ng = Self::geometric_normal(corners, mesh, interpolated);
        Surface {
            p: p0 * b[0] + p1 * b[1] + p2 * b[2],
            p_error: triangle_point_error(corners, b),
            t,
            ng,
            ns: interpolated.and_then(Vec3::try_normalize).unwrap_or(ng),
            uv: self.uv(triangle, b),
            footprint: 0.0,
            shape: mesh.shape,
            triangle,
            analytic: u32::MAX,
            instance: None,
            barycentrics: Vec2::new(b[1], b[2]),
            light: mesh.first_light.map(|l| LightId(l + triangle - mesh.first)),
            time,
        }
    }

    /// ∂p/∂u and ∂p/∂v; some tangents where the uvs are degenerate.
    pub fn tangents(&self, triangle: u32) -> (Vec3, Vec3) {
        partial_derivatives(self.corners(triangle), self.corner_uvs(triangle))
    }

    /// A point uniform over the triangle's area (density 1 / [`TriangleStore::area`]).
    #[inline]
    pub fn sample(&self, triangle: u32, u: Vec2) -> ShapeSample {
        let b = warp::triangle(u);
        let mesh = self.mesh(triangle);
        let corners = self.corners(triangle);
        let ns = self.interpolated_normal(triangle, mesh, b);
        ShapeSample {
            p: corners[0] * b[0] + corners[1] * b[1] + corners[2] * b[2],
            p_error: triangle_point_error(corners, b),
            n: Self::geometric_normal(corners, mesh, ns),
        }
    }
}

/// ∂p/∂u and ∂p/∂v of a triangle; some tangents where the uvs are degenerate.
fn partial_derivatives(p: [Vec3; 3], uv: [Vec2; 3]) -> (Vec3, Vec3) {
    let (d1, d2) = (uv[1] - uv[0], uv[2] - uv[0]);
    let (e1, e2) = (p[1] - p[0], p[2] - p[0]);
    let det = kaustika_math::diff_of_products(d1.x, d2.y, d1.y, d2.x);
    if det.abs() > 1e-12 {
        let inv = 1.0 / det;
        let dpdu = (e1 * d2.y - e2 * d1.y) * inv;
        let dpdv = (e2 * d1.x - e1 * d2.x) * inv;
        if dpdu.cross(dpdv).length_squared() > 0.0 && dpdu.is_finite() && dpdv.is_finite() {
            return (dpdu, dpdv);
        }
    }
    e1.cross(e2).normalize().coordinate_system()
}
