//! Shapes that become triangles when a scene is built.

use crate::description::TriMesh;
use kaustika_math::{Vec2, Vec3, lerp};

/// The square [-1,1]² in z = 0, normal +z.
pub fn rectangle() -> TriMesh {
    let corner =
        |x: f32, y: f32| (Vec3::new(x, y, 0.0), Vec2::new(0.5 * (x + 1.0), 0.5 * (y + 1.0)));
    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    TriMesh {
        positions: corners.map(|c| c.0).to_vec(),
        uvs: corners.map(|c| c.1).to_vec(),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..TriMesh::default()
    }
}

/// The cube [-1,1]³, normals outward, each face with uv over [0,1]² as Mitsuba's has it.
pub fn cube() -> TriMesh {
    // Where u and v grow on the faces -x, +x, -y, +y, -z, +z; u x v points inward.
    const UV: [[Vec3; 2]; 6] = [
        [Vec3::Y, Vec3::Z],
        [Vec3::Y, Vec3::new(0.0, 0.0, -1.0)],
        [Vec3::Z, Vec3::X],
        [Vec3::new(-1.0, 0.0, 0.0), Vec3::new(0.0, 0.0, -1.0)],
        [Vec3::new(0.0, -1.0, 0.0), Vec3::X],
        [Vec3::Y, Vec3::X],
    ];
    let mut mesh = TriMesh::default();
    for axis in 0..3 {
        for (side, sign) in [-1.0f32, 1.0].into_iter().enumerate() {
            let mut n = Vec3::ZERO;
            n[axis] = sign;
            // Two edges with s x t = n.
            let mut s = Vec3::ZERO;
            s[(axis + 1) % 3] = 1.0;
            let t = n.cross(s);
            let base = mesh.positions.len() as u32;
            for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let p = n + s * a + t * b;
                let [u, v] = UV[2 * axis + side].map(|grows| 0.5 * (1.0 + p.dot(grows)));
                mesh.positions.push(p);
                mesh.uvs.push(Vec2::new(u, v));
            }
            mesh.indices.push([base, base + 1, base + 2]);
            mesh.indices.push([base, base + 2, base + 3]);
        }
    }
    mesh
}

/// Bilinear patches with corners p00, p10, p01, p11: planar ones become two triangles, curved
/// ones a grid fine enough that facets do not show with their smooth normals.
pub fn bilinear_patches(
    positions: &[Vec3],
    indices: &[[u32; 4]],
    normals: &[Vec3],
    uvs: &[Vec2],
) -> TriMesh {
    let mut mesh = TriMesh::default();
    for quad in indices {
        let p = quad.map(|i| positions[i as usize]);
        let twist = (p[0] - p[1] - p[2] + p[3]).length();
        let size = (p[3] - p[0]).length().max((p[2] - p[1]).length());
        let cells: u32 = if twist <= 1e-4 * size { 1 } else { 16 };
        let uv = match uvs.is_empty() {
            true => [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(u, v)| Vec2::new(u, v)),
            false => quad.map(|i| uvs[i as usize]),
        };
        let base = mesh.positions.len() as u32;
        for j in 0..=cells {
            for i in 0..=cells {
                let (u, v) = (i as f32 / cells as f32, j as f32 / cells as f32);
                let at = |c: [Vec3; 4]| c[0].lerp(c[1], u).lerp(c[2].lerp(c[3], u), v);
                mesh.positions.push(at(p));
                mesh.uvs.push(Vec2::new(
                    lerp(v, lerp(u, uv[0].x, uv[1].x), lerp(u, uv[2].x, uv[3].x)),
                    lerp(v, lerp(u, uv[0].y, uv[1].y), lerp(u, uv[2].y, uv[3].y)),
                ));
                let n = if normals.is_empty() {
                    let dpdu = (p[1] - p[0]).lerp(p[3] - p[2], v);
                    let dpdv = (p[2] - p[0]).lerp(p[3] - p[1], u);
                    dpdu.cross(dpdv)
                } else {
                    at(quad.map(|i| normals[i as usize]))
                };
                mesh.normals.push(n.try_normalize().unwrap_or(Vec3::ZERO));
            }
        }
        for j in 0..cells {
            for i in 0..cells {
                let a = base + j * (cells + 1) + i;
                let (b, c, d) = (a + 1, a + cells + 1, a + cells + 2);
                mesh.indices.push([a, b, d]);
                mesh.indices.push([a, d, c]);
            }
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners as `mitsuba.traverse` lists them (3.9.1), one or two a face.
    #[test]
    fn uv_of_the_cube_are_mitsubas() {
        let cube = cube();
        for (p, n, uv) in [
            ([1.0, -1.0, -1.0], -Vec3::Y, [0.0, 1.0]),
            ([-1.0, -1.0, 1.0], -Vec3::Y, [1.0, 0.0]),
            ([-1.0, 1.0, -1.0], Vec3::Y, [1.0, 1.0]),
            ([1.0, 1.0, 1.0], Vec3::Y, [0.0, 0.0]),
            ([1.0, 1.0, -1.0], Vec3::X, [1.0, 1.0]),
            ([1.0, -1.0, 1.0], Vec3::X, [0.0, 0.0]),
            ([1.0, -1.0, 1.0], Vec3::Z, [0.0, 1.0]),
            ([-1.0, 1.0, 1.0], Vec3::Z, [1.0, 0.0]),
            ([-1.0, 1.0, 1.0], -Vec3::X, [1.0, 1.0]),
            ([-1.0, -1.0, -1.0], -Vec3::X, [0.0, 0.0]),
            ([1.0, 1.0, -1.0], -Vec3::Z, [0.0, 1.0]),
            ([-1.0, -1.0, -1.0], -Vec3::Z, [1.0, 0.0]),
        ] {
            let face = cube.positions.chunks(4).position(|c| c.iter().all(|q| q.dot(n) == 1.0));
            let first = 4 * face.expect("a face of each side");
            let corner = (first..first + 4).find(|i| cube.positions[*i] == Vec3::from(p));
            let found = cube.uvs[corner.expect("a corner of the face")];
            assert_eq!([found.x, found.y], uv, "{p:?} on {n:?}");
        }
    }

    #[test]
    fn faces_turn_outward() {
        let c = cube();
        assert_eq!((c.positions.len(), c.indices.len()), (24, 12));
        for [i, j, k] in c.indices {
            let [a, b, d] = [i, j, k].map(|i| c.positions[i as usize]);
            let n = (b - a).cross(d - a);
            assert!(n.dot(a) > 0.0 && (n.length() - 4.0).abs() < 1e-6);
        }
        let [a, b, d] = rectangle().indices[0].map(|i| rectangle().positions[i as usize]);
        assert!((b - a).cross(d - a).z > 0.0);
    }
}
