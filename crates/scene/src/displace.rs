//! Meshes that a texture moves along their normals.
//!
//! ```text
//! p' = p + d n                                                               (1)
//! ```
//!
//! Before, edges are halved until none is longer than asked for, the longest of each triangle first
//! (pbrt-v4, `TriQuadMesh::Displace`). Every edge that is too long is halved at its middle, whichever
//! triangle comes to it first: so no cracks open. Afterwards normals are those of the moved triangles.

use crate::description::TriMesh;
use crate::texture::TexturePoint;
use kaustika_math::{Transform, Vec2, Vec3};
use std::collections::HashMap;

/// Triangles that a mesh may have, some 3 GiB of memory.
const MOST: usize = 1 << 25;

/// The mesh with edges below `edge_length` in world space, moved in its own space by `height`, which is
/// asked for points of the world. `None` if that makes more than 2²⁵ triangles.
pub fn displaced(
    mesh: &TriMesh,
    to_world: &Transform,
    edge_length: f32,
    height: impl Fn(&TexturePoint) -> f32,
) -> Option<TriMesh> {
    let Refined { mut mesh, world, .. } = Refined::of(mesh, to_world, edge_length, MOST)?;
    for (i, p) in mesh.positions.iter_mut().enumerate() {
        let n = mesh.normals[i];
        let at = TexturePoint {
            p: world[i],
            n: to_world.normal(n).try_normalize().unwrap_or(n),
            uv: mesh.uvs.get(i).copied().unwrap_or(Vec2::ZERO),
            uv_width: 0.0,
            triangle: u32::MAX,
            barycentrics: Vec2::ZERO,
        };
        *p += n * height(&at); // (1)
    }
    mesh.normals = vertex_normals(&mesh);
    Some(mesh)
}

/// A mesh whose edges are being halved.
struct Refined {
    mesh: TriMesh,
    /// Its vertices in world space.
    world: Vec<Vec3>,
    /// The middles of edges, by the vertices at their ends, the lower number first.
    middles: HashMap<[u32; 2], u32>,
}

impl Refined {
    fn of(mesh: &TriMesh, to_world: &Transform, edge_length: f32, most: usize) -> Option<Refined> {
        let mut fine = TriMesh { indices: Vec::new(), attributes: Vec::new(), ..mesh.clone() };
        if fine.normals.len() != fine.positions.len() {
            fine.normals = vertex_normals(mesh);
        }
        let world = mesh.positions.iter().map(|p| to_world.point(*p)).collect();
        let mut refined = Refined { mesh: fine, world, middles: HashMap::new() };
        let mut open = Vec::new();
        for triangle in &mesh.indices {
            open.push(*triangle);
            while let Some(triangle) = open.pop() {
                match refined.longest_first(triangle, edge_length) {
                    None => refined.mesh.indices.push(triangle),
                    Some([a, b, c]) => {
                        let m = refined.middle(to_world, a, b);
                        open.extend([[m, b, c], [a, m, c]]);
                    }
                }
                if refined.mesh.indices.len() + open.len() > most {
                    return None;
                }
            }
        }
        Some(refined)
    }

    /// The corners in an order in which the longest edge lies between the first two; `None` if all are
    /// short enough.
    fn longest_first(&self, [a, b, c]: [u32; 3], enough: f32) -> Option<[u32; 3]> {
        let length = |i: u32, j: u32| (self.world[i as usize] - self.world[j as usize]).length();
        let edges =
            [([a, b, c], length(a, b)), ([b, c, a], length(b, c)), ([c, a, b], length(c, a))];
        let longest = edges.into_iter().max_by(|x, y| x.1.total_cmp(&y.1))?;
        (longest.1 >= enough).then_some(longest.0)
    }

    /// The vertex in the middle of an edge.
    fn middle(&mut self, to_world: &Transform, a: u32, b: u32) -> u32 {
        let Refined { mesh, world, middles } = self;
        *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            let (i, j) = (a as usize, b as usize);
            let p = (mesh.positions[i] + mesh.positions[j]) * 0.5;
            let n = mesh.normals[i] + mesh.normals[j];
            mesh.positions.push(p);
            mesh.normals.push(n.try_normalize().unwrap_or(Vec3::ZERO));
            if !mesh.uvs.is_empty() {
                mesh.uvs.push((mesh.uvs[i] + mesh.uvs[j]) * 0.5);
            }
            world.push(to_world.point(p));
            world.len() as u32 - 1
        })
    }
}

/// At each vertex the mean of the normals of its triangles, unit or zero.
fn vertex_normals(mesh: &TriMesh) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; mesh.positions.len()];
    for triangle in &mesh.indices {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
        let n = (b - a).cross(c - a).try_normalize().unwrap_or(Vec3::ZERO);
        triangle.iter().for_each(|i| normals[*i as usize] += n);
    }
    normals.into_iter().map(|n| n.try_normalize().unwrap_or(Vec3::ZERO)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tessellate;

    fn corners(mesh: &TriMesh, triangle: [u32; 3]) -> [Vec3; 3] {
        triangle.map(|i| mesh.positions[i as usize])
    }

    #[test]
    fn edges_are_short_in_the_world_and_no_crack_opens() {
        let wide = Transform::scale(Vec3::new(3.0, 1.0, 1.0)).expect("not flat");
        let bump = |at: &TexturePoint| 0.2 * (5.0 * at.p.x).sin() * (4.0 * at.uv.y).cos();
        let mesh = displaced(&tessellate::rectangle(), &wide, 0.25, bump).expect("few triangles");
        let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
        for &[a, b, c] in &mesh.indices {
            for [i, j] in [[a, b], [b, c], [c, a]] {
                *edges.entry([i.min(j), i.max(j)]).or_default() += if i < j { 1 } else { -1 };
                let flat =
                    |i: u32| wide.point(mesh.positions[i as usize] * Vec3::new(1.0, 1.0, 0.0));
                assert!((flat(i) - flat(j)).length() < 0.25);
            }
        }
        // What has a triangle on one side only is the rim.
        for ([i, j], _) in edges.into_iter().filter(|(_, turns)| *turns != 0) {
            let [p, q] = [i, j].map(|i| mesh.positions[i as usize]);
            let along = |a: f32, b: f32| a.abs() == 1.0 && a == b;
            assert!(along(p.x, q.x) || along(p.y, q.y), "{p:?} {q:?}");
        }
    }

    #[test]
    fn surfaces_lie_where_the_texture_says_and_face_the_same_way() {
        let slope = |at: &TexturePoint| 0.5 * at.uv.x;
        let mesh =
            displaced(&tessellate::rectangle(), &Transform::IDENTITY, 0.3, slope).expect("few");
        let n = Vec3::new(-0.25, 0.0, 1.0).normalize();
        for (p, normal) in mesh.positions.iter().zip(&mesh.normals) {
            assert!((p.z - 0.25 * (p.x + 1.0)).abs() < 1e-6);
            assert!((*normal - n).length() < 1e-5);
        }
        let area: f32 = mesh
            .indices
            .iter()
            .map(|t| {
                let [a, b, c] = corners(&mesh, *t);
                0.5 * (b - a).cross(c - a).length()
            })
            .sum();
        assert!((area - 4.0 / n.z).abs() < 1e-4, "{area}");
    }

    #[test]
    fn a_cube_keeps_its_area_where_nothing_moves_it_and_too_short_edges_are_refused() {
        let cube = tessellate::cube();
        let same = displaced(&cube, &Transform::IDENTITY, 0.6, |_| 0.0).expect("few");
        let area: f32 = same
            .indices
            .iter()
            .map(|t| {
                let [a, b, c] = corners(&same, *t);
                assert!((b - a).cross(c - a).dot(a) > 0.0);
                0.5 * (b - a).cross(c - a).length()
            })
            .sum();
        assert!((area - 24.0).abs() < 1e-4, "{area}");
        let far = TriMesh {
            positions: vec![
                Vec3::splat(1e7),
                Vec3::new(1e7, 1e7, 1.1e7),
                Vec3::new(1.1e7, 1e7, 1e7),
            ],
            indices: vec![[0, 1, 2]],
            ..TriMesh::default()
        };
        assert!(Refined::of(&far, &Transform::IDENTITY, 0.01, 1000).is_none());
    }
}
