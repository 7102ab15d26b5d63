//! Vertex normals: computed where a file has none, dropped where faces shall look flat, split
//! where an edge is sharp.
//!
//! A computed normal is the sum of the unit normals of the faces around the vertex, each weighted
//! by the face's angle there: Grit Thürmer and Charles A. Wüthrich, "Computing Vertex Normals
//! from Polygonal Facets", Journal of Graphics Tools 3(1), 1998. Mitsuba 0.6 and 3 do the same.
//! Unlike area weights, it does not depend on how a flat polygon was cut into triangles.

use std::collections::HashMap;

use super::error::MeshNote;
use kaustika_math::Vec3;
use kaustika_scene::description::TriMesh;

/// What becomes of vertex normals when a mesh is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NormalPolicy {
    /// They are as in the file, or absent. pbrt.
    AsStored,
    /// As in the file, or computed by [`smooth`] if the file has none. Mitsuba's default.
    SmoothIfMissing,
    /// Dropped. Mitsuba's `face_normals` (0.6: `faceNormals`).
    Flat,
    /// Computed by [`smooth_below`] with this angle in degrees, in place of any in the file.
    /// Mitsuba 0.6's `maxSmoothAngle`.
    SmoothBelow(f32),
}

impl NormalPolicy {
    /// False if normals in the file do not matter.
    pub(super) fn uses_stored(self) -> bool {
        match self {
            NormalPolicy::AsStored | NormalPolicy::SmoothIfMissing => true,
            NormalPolicy::Flat | NormalPolicy::SmoothBelow(_) => false,
        }
    }
}

/// Brings the normals of a mesh, as the readers leave it, in line with `policy`.
pub(super) fn apply(mesh: &mut TriMesh, policy: NormalPolicy, notes: &mut Vec<MeshNote>) {
    let missing = match policy {
        NormalPolicy::AsStored => return,
        NormalPolicy::Flat => {
            mesh.normals = Vec::new();
            return;
        }
        NormalPolicy::SmoothIfMissing if !mesh.normals.is_empty() => return,
        NormalPolicy::SmoothIfMissing => smooth(mesh),
        NormalPolicy::SmoothBelow(degrees) => smooth_below(mesh, degrees),
    };
    if missing.faces > 0 {
        notes.push(MeshNote::DegenerateFaces(missing.faces));
    }
    if missing.vertices > 0 {
        notes.push(MeshNote::VerticesWithoutNormal(missing.vertices));
    }
}

/// What vertex normals could not be computed from, or for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Missing {
    /// Faces without area.
    pub faces: u64,
    /// Vertices whose normal is zero: of no face with area, or of faces that cancel.
    pub vertices: u64,
}

/// Computes all vertex normals anew, weighted by angle. Where there is none the normal is zero,
/// which stands for the geometric one (Mitsuba writes (1, 0, 0) there).
pub fn smooth(mesh: &mut TriMesh) -> Missing {
    let mut missing = Missing::default();
    // Sums in double precision: thousands of faces may share a vertex.
    let mut sums = vec![[0f64; 3]; mesh.positions.len()];
    for triangle in &mesh.indices {
        let p = triangle.map(|v| mesh.positions[v as usize]);
        let Some(normal) = face_normal(p) else {
            missing.faces += 1;
            continue;
        };
        for corner in 0..3 {
            let angle = corner_angle(p, corner);
            let sum = &mut sums[triangle[corner] as usize];
            for axis in 0..3 {
                sum[axis] += angle * normal[axis];
            }
        }
    }
    mesh.normals = sums
        .into_iter()
        .map(|sum| match unit(sum) {
            // Sums of rounded terms that should cancel exactly leave about 1e-16.
            Some(n) if dot(sum, sum) > 1e-24 => Vec3::new(n[0] as f32, n[1] as f32, n[2] as f32),
            _ => {
                missing.vertices += 1;
                Vec3::ZERO
            }
        })
        .collect();
    missing
}

/// Splits vertices along edges sharper than `max_degrees` and computes normals: two faces share
/// the vertex at a common corner only if their normals differ by less than this angle.
///
/// As in Mitsuba 0.6 (`TriMesh::rebuildTopology`), corners are first brought together wherever
/// position, texture coordinates and attributes agree, whatever the numbering, and are then
/// grouped greedily: the first face not yet in a group takes all others that are within the
/// angle of itself.
pub fn smooth_below(mesh: &mut TriMesh, max_degrees: f32) -> Missing {
    let threshold = (max_degrees as f64).to_radians().cos();
    let faces: Vec<Option<[f64; 3]>> = mesh
        .indices
        .iter()
        .map(|triangle| face_normal(triangle.map(|v| mesh.positions[v as usize])))
        .collect();
    let together = |a: usize, b: usize| match (faces[a], faces[b]) {
        (Some(a), Some(b)) => a == b || dot(a, b) > threshold,
        (None, None) => true,
        _ => false,
    };

    // Leaders of the groups at each distinct vertex: (face, new vertex number).
    let (class, classes) = equal_vertices(mesh);
    let mut leaders: Vec<Vec<(usize, u32)>> = vec![Vec::new(); classes];
    // Which old vertex each new one copies.
    let mut origin: Vec<u32> = Vec::new();
    for face in 0..mesh.indices.len() {
        for corner in 0..3 {
            let old = mesh.indices[face][corner];
            let groups = &mut leaders[class[old as usize] as usize];
            let found = groups.iter().find(|(leader, _)| together(*leader, face));
            mesh.indices[face][corner] = match found {
                Some((_, new)) => *new,
                None => {
                    let new = origin.len() as u32;
                    groups.push((face, new));
                    origin.push(old);
                    new
                }
            };
        }
    }

    mesh.positions = gather(&mesh.positions, 1, &origin);
    mesh.uvs = gather(&mesh.uvs, 1, &origin);
    for attribute in mesh.attributes.iter_mut().filter(|a| !a.per_face) {
        attribute.values = gather(&attribute.values, attribute.channels as usize, &origin);
    }
    smooth(mesh)
}

/// Faces without area, or with a corner that is not finite.
pub fn degenerate_faces(mesh: &TriMesh) -> usize {
    mesh.indices
        .iter()
        .filter(|triangle| face_normal(triangle.map(|v| mesh.positions[v as usize])).is_none())
        .count()
}

/// For each vertex the number of its class of equal vertices, normals aside; and how many classes
/// there are.
fn equal_vertices(mesh: &TriMesh) -> (Vec<u32>, usize) {
    // 0 and -0 are the same place.
    let bits = |v: f32| if v == 0.0 { 0 } else { v.to_bits() };
    let attributes: Vec<_> = mesh.attributes.iter().filter(|a| !a.per_face).collect();
    let mut numbers: HashMap<Vec<u32>, u32> = HashMap::new();
    let class = (0..mesh.positions.len())
        .map(|v| {
            let p = mesh.positions[v];
            let mut key = vec![bits(p.x), bits(p.y), bits(p.z)];
            if let Some(uv) = mesh.uvs.get(v) {
                key.extend([bits(uv.x), bits(uv.y)]);
            }
            for attribute in &attributes {
                let n = attribute.channels as usize;
                key.extend(attribute.values[v * n..][..n].iter().map(|&v| bits(v)));
            }
            let next = numbers.len() as u32;
            *numbers.entry(key).or_insert(next)
        })
        .collect();
    (class, numbers.len())
}

/// Elements `origin` of an array with `width` values an element; nothing of nothing.
fn gather<T: Copy>(values: &[T], width: usize, origin: &[u32]) -> Vec<T> {
    if values.is_empty() {
        return Vec::new();
    }
    let element = |&v: &u32| values[v as usize * width..][..width].iter().copied();
    origin.iter().flat_map(element).collect()
}

/// The unit normal of a triangle, in double precision so that tiny triangles have one too.
fn face_normal(p: [Vec3; 3]) -> Option<[f64; 3]> {
    unit(cross(edge(p[0], p[1]), edge(p[0], p[2])))
}

/// The angle of a triangle at a corner, in radians.
fn corner_angle(p: [Vec3; 3], corner: usize) -> f64 {
    let a = edge(p[corner], p[(corner + 1) % 3]);
    let b = edge(p[corner], p[(corner + 2) % 3]);
    // Exact near 0 and pi, where an arc cosine is not.
    let c = cross(a, b);
    dot(c, c).sqrt().atan2(dot(a, b))
}

fn edge(from: Vec3, to: Vec3) -> [f64; 3] {
    let d = |a: f32, b: f32| b as f64 - a as f64;
    [d(from.x, to.x), d(from.y, to.y), d(from.z, to.z)]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(v, v).sqrt();
    (length > 0.0 && length.is_finite()).then(|| v.map(|x| x / length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_math::Vec2;
    use kaustika_scene::description::MeshAttribute;

    /// The unit cube's 8 corners; two triangles a side, facing out.
    fn cube() -> TriMesh {
        let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
        let quads =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        TriMesh {
            positions: (0..8).map(corner).collect(),
            indices: quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect(),
            ..TriMesh::default()
        }
    }

    #[test]
    fn a_cubes_normals_point_along_its_diagonals() {
        // Angle weights make up for sides that meet a corner with one triangle or two.
        let mut mesh = cube();
        assert_eq!(smooth(&mut mesh), Missing::default());
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            let expected = (*p - Vec3::splat(0.5)).normalize();
            assert!((*n - expected).length() < 1e-6, "{p:?}: {n:?}");
        }
    }

    #[test]
    fn a_sharp_cube_has_three_vertices_a_corner() {
        let mut mesh = cube();
        smooth_below(&mut mesh, 30.0);
        assert_eq!(mesh.positions.len(), 24);
        for triangle in &mesh.indices {
            let p = triangle.map(|v| mesh.positions[v as usize]);
            let ng = (p[1] - p[0]).cross(p[2] - p[0]).normalize();
            for v in triangle {
                assert!((mesh.normals[*v as usize] - ng).length() < 1e-6);
            }
        }
    }

    #[test]
    fn a_blunt_angle_keeps_the_cube_smooth() {
        let mut mesh = cube();
        smooth_below(&mut mesh, 91.0);
        assert_eq!(mesh.positions.len(), 8);
    }

    #[test]
    fn smoothing_joins_duplicate_vertices_but_not_across_seams() {
        // Two coplanar triangles with all six vertices apart; two places coincide.
        let p = |x, y| Vec3::new(x, y, 0.0);
        let mut mesh = TriMesh {
            positions: vec![p(0., 0.), p(1., 0.), p(0., 1.), p(1., 0.), p(1., 1.), p(0., 1.)],
            indices: vec![[0, 1, 2], [3, 4, 5]],
            uvs: vec![Vec2::new(0.5, 0.5); 6],
            attributes: vec![MeshAttribute {
                name: "vertex_heat".into(),
                channels: 1,
                per_face: false,
                values: vec![0.0, 1.0, 2.0, 1.0, 3.0, 2.0],
            }],
            ..TriMesh::default()
        };
        let mut joined = mesh.clone();
        smooth_below(&mut joined, 10.0);
        assert_eq!(joined.positions.len(), 4);
        assert_eq!(joined.attributes[0].values, [0.0, 1.0, 2.0, 3.0]);
        mesh.uvs[3] = Vec2::new(0.25, 0.5);
        smooth_below(&mut mesh, 10.0);
        assert_eq!(mesh.positions.len(), 5);
        assert_eq!(mesh.uvs.len(), 5);
    }

    #[test]
    fn what_has_no_normal_is_counted_and_zero() {
        let p = |x, y| Vec3::new(x, y, 0.0);
        let mut mesh = TriMesh {
            // Vertex 3 lies on the line 0-1; vertex 4 is of no face.
            positions: vec![p(0., 0.), p(1., 0.), p(0., 1.), p(2., 0.), p(5., 5.)],
            indices: vec![[0, 1, 2], [0, 1, 3], [1, 1, 2]],
            ..TriMesh::default()
        };
        assert_eq!(degenerate_faces(&mesh), 2);
        let missing = smooth(&mut mesh);
        assert_eq!((missing.faces, missing.vertices), (2, 2));
        assert_eq!(mesh.normals[0], Vec3::Z);
        assert_eq!(mesh.normals[3], Vec3::ZERO);
        assert_eq!(mesh.normals[4], Vec3::ZERO);
    }

    #[test]
    fn faces_back_to_back_cancel() {
        let mut mesh = cube();
        let back: Vec<_> = mesh.indices.iter().map(|t| [t[0], t[2], t[1]]).collect();
        mesh.indices.extend(back);
        assert_eq!(smooth(&mut mesh).vertices, 8);
    }

    #[test]
    fn tiny_triangles_have_normals() {
        let mut mesh = cube();
        for p in &mut mesh.positions {
            *p *= 1e-30;
        }
        assert_eq!(smooth(&mut mesh), Missing::default());
        assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-6));
    }

    #[test]
    fn policies() {
        let stored = TriMesh { normals: vec![Vec3::X; 8], ..cube() };
        let mut notes = Vec::new();
        let mut with = |policy, mesh: &TriMesh| {
            let mut mesh = mesh.clone();
            apply(&mut mesh, policy, &mut notes);
            mesh
        };
        assert_eq!(with(NormalPolicy::AsStored, &cube()), cube());
        assert_eq!(with(NormalPolicy::SmoothIfMissing, &stored), stored);
        assert_eq!(with(NormalPolicy::SmoothIfMissing, &cube()).normals.len(), 8);
        assert_eq!(with(NormalPolicy::Flat, &stored), cube());
        assert_eq!(with(NormalPolicy::SmoothBelow(5.0), &stored).normals.len(), 24);
    }
}
