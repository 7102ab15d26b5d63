//! Curved surfaces as grids of triangles with smooth normals.

use kaustika_math::{Vec2, Vec3};
use kaustika_scene::description::TriMesh;

/// `nu` by `nv` cells over (u, v) in [0,1]². `surface` gives position and unit normal; the normal
/// must point along ∂p/∂u x ∂p/∂v. Seams keep a vertex on either side, so that uv may jump there.
/// Triangles without area (at poles and closed ends) are left out.
pub fn grid(nu: u32, nv: u32, surface: impl Fn(f32, f32) -> (Vec3, Vec3)) -> TriMesh {
    let mut mesh = TriMesh::default();
    for j in 0..=nv {
        for i in 0..=nu {
            let (u, v) = (i as f32 / nu as f32, j as f32 / nv as f32);
            let (p, n) = surface(u, v);
            mesh.positions.push(p);
            mesh.normals.push(n);
            mesh.uvs.push(Vec2::new(u, v));
        }
    }
    let at = |i: u32, j: u32| j * (nu + 1) + i;
    for j in 0..nv {
        for i in 0..nu {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            for t in [[a, b, c], [a, c, d]] {
                let [p, q, r] = t.map(|k| mesh.positions[k as usize]);
                if (q - p).cross(r - p).length_squared() > 0.0 {
                    mesh.indices.push(t);
                }
            }
        }
    }
    mesh
}

/// What is wrong with a mesh: triangles that face away from their normals, numbers out of range.
#[cfg(test)]
pub fn defects(mesh: &TriMesh) -> Vec<String> {
    let mut found = Vec::new();
    if mesh.normals.len() != mesh.positions.len() || mesh.indices.is_empty() {
        found.push("no triangles, or not a normal for each vertex".to_string());
    }
    for t in &mesh.indices {
        let [p, q, r] = t.map(|k| mesh.positions[k as usize]);
        let ng = (q - p).cross(r - p);
        for &k in t {
            let n = mesh.normals[k as usize];
            // Not also "> 0 by some margin": at the rims of bevels the two differ by 45 degrees.
            if !p.is_finite() || (n.length() - 1.0).abs() > 1e-3 || ng.dot(n) <= 0.0 {
                found.push(format!("triangle {t:?} at {p:?} has normal {n:?}, faces {ng:?}"));
            }
        }
    }
    found
}

/// The volume that a closed mesh with outward faces encloses (divergence theorem), Σ p·(q x r)/6.
#[cfg(test)]
pub fn volume(mesh: &TriMesh) -> f32 {
    let signed = |t: &[u32; 3]| {
        let [p, q, r] = t.map(|k| mesh.positions[k as usize]);
        p.dot(q.cross(r)) / 6.0
    };
    mesh.indices.iter().map(signed).sum()
}
