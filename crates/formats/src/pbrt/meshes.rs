//! Meshes written out in the scene file (pbrt-v4, shapes.cpp).

use super::build::Builder;
use super::entity::Entity;
use super::param::ParamType;
use crate::mesh::subdivide;
use kaustika_math::Vec3;
use kaustika_scene::description::{GeometryDesc, TriMesh};
use std::sync::Arc;

impl Builder {
    /// `P`, `indices`, `N`, `uv` of a triangle mesh.
    pub fn triangle_mesh(&mut self, e: &mut Entity) -> Option<GeometryDesc> {
        let (positions, corners) = self.corners::<3>(e)?;
        let n = positions.len();
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        let uvs = p.points2(diag, "uv").unwrap_or_default();
        let normals = p.triples(diag, "N", ParamType::Normal).unwrap_or_default();
        // Tangents are made from uv; face numbers serve ptex only.
        p.triples(diag, "S", ParamType::Vector3);
        p.ints(diag, "faceIndices");
        let uvs = self.per_vertex(e, "uv", uvs, n);
        let normals = self.per_vertex(e, "N", normals, n);
        let mesh = TriMesh { positions, normals, uvs, indices: corners, attributes: Vec::new() };
        Some(GeometryDesc::Mesh(face_normals(Arc::new(mesh))))
    }

    /// A Loop subdivision surface.
    pub fn subdivision(&mut self, e: &mut Entity) -> Option<GeometryDesc> {
        let diag = &mut self.desc.diagnostics;
        let levels = e.params.int(diag, "levels", 3);
        // The only one there is.
        e.params.string(diag, "scheme");
        let (positions, indices) = self.corners::<3>(e)?;
        let levels = u32::try_from(levels).unwrap_or(0);
        match subdivide(positions, indices, levels) {
            Ok(mesh) => Some(GeometryDesc::Mesh(face_normals(Arc::new(mesh)))),
            Err(cause) => {
                let place = e.params.place("indices");
                self.desc.diagnostics.error(place, format!("can't subdivide: {cause}"));
                None
            }
        }
    }

    /// `P`, `indices`, `N`, `uv` of bilinear patches.
    pub fn bilinear_mesh(&mut self, e: &mut Entity) -> Option<GeometryDesc> {
        let (positions, indices) = self.corners::<4>(e)?;
        let n = positions.len();
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        let uvs = p.points2(diag, "uv").unwrap_or_default();
        let normals = p.triples(diag, "N", ParamType::Normal).unwrap_or_default();
        p.ints(diag, "faceIndices");
        // Only says how pbrt samples the patch as a light.
        p.string(diag, "emissionfilename");
        let uvs = self.per_vertex(e, "uv", uvs, n);
        let normals = self.per_vertex(e, "N", normals, n);
        Some(GeometryDesc::BilinearPatches { positions, indices, normals, uvs })
    }

    /// `P` and `indices`, `N` a face.
    fn corners<const N: usize>(&mut self, e: &mut Entity) -> Option<(Vec<Vec3>, Vec<[u32; N]>)> {
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        let positions = p.triples(diag, "P", ParamType::Point3);
        let indices = p.ints(diag, "indices");
        let Some(positions) = positions else {
            if !p.has("P") {
                let message = format!("shape `{}` needs \"point3 P\"", e.kind.text);
                diag.error(e.kind.span, message);
            }
            p.ignore_rest();
            return None;
        };
        let indices = match indices {
            Some(i) => i,
            None if p.has("indices") => return None,
            // A single face needs none.
            None if positions.len() == N => (0..N as i32).collect(),
            None => {
                let message = format!("shape `{}` needs \"integer indices\"", e.kind.text);
                diag.error(e.kind.span, message);
                p.ignore_rest();
                return None;
            }
        };
        let rest = indices.len() % N;
        if rest != 0 {
            let message =
                format!("{} indices are no multiple of {N}, {rest} ignored", indices.len());
            diag.warning(p.place("indices"), message);
        }
        if let Some(bad) = indices.iter().find(|&&i| i < 0 || i as usize >= positions.len()) {
            let message =
                format!("index {bad} is out of range, `P` has {} points", positions.len());
            diag.error(p.place("indices"), message);
            return None;
        }
        let faces = indices.chunks_exact(N).map(|c| std::array::from_fn(|i| c[i] as u32)).collect();
        Some((positions, faces))
    }

    /// Values on vertices, dropped with a warning if their number is wrong.
    fn per_vertex<T>(&mut self, e: &Entity, name: &str, values: Vec<T>, n: usize) -> Vec<T> {
        if values.is_empty() || values.len() == n {
            return values;
        }
        let message = format!("{} values of `{name}` for {n} points are ignored", values.len());
        self.desc.diagnostics.warning(e.params.place(name), message);
        Vec::new()
    }
}

/// The mesh with every triangle's corners in the order that makes its front face its shading
/// normals; the same mesh if all are, or if it has no normals.
pub(super) fn face_normals(mesh: Arc<TriMesh>) -> Arc<TriMesh> {
    if mesh.normals.len() != mesh.positions.len() {
        return mesh;
    }
    let away = |m: &TriMesh, &[a, b, c]: &[u32; 3]| {
        let p = |i: u32| m.positions[i as usize];
        let n = |i: u32| m.normals[i as usize];
        (p(b) - p(a)).cross(p(c) - p(a)).dot(n(a) + n(b) + n(c)) < 0.0
    };
    if !mesh.indices.iter().any(|t| away(&mesh, t)) {
        return mesh;
    }
    let mut turned = Arc::unwrap_or_clone(mesh);
    let mut indices = std::mem::take(&mut turned.indices);
    for t in indices.iter_mut().filter(|t| away(&turned, t)) {
        t.swap(1, 2);
    }
    turned.indices = indices;
    Arc::new(turned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_are_turned_to_their_normals_and_others_stay() {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        let mut mesh = TriMesh { positions, indices: vec![[0, 1, 2]], ..TriMesh::default() };
        let plain = Arc::new(mesh.clone());
        assert!(Arc::ptr_eq(&face_normals(plain.clone()), &plain));
        mesh.normals = vec![-Vec3::Z; 3];
        assert_eq!(face_normals(Arc::new(mesh.clone())).indices, [[0, 2, 1]]);
        mesh.normals = vec![Vec3::Z; 3];
        let right = Arc::new(mesh);
        assert!(Arc::ptr_eq(&face_normals(right.clone()), &right));
    }
}
