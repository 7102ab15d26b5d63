//! Loop's subdivision surfaces (Loop 1987, "Smooth Subdivision Surfaces Based on Triangles").
//!
//! ```text
//! a new vertex on an inner edge:   3/8 of its ends, 1/8 of the two corners across           (1)
//! on a boundary edge:              1/2 of its ends                                           (2)
//! an inner vertex of n neighbours: (1 - nβ) v + β Σ vᵢ,  β = 3/16 (n = 3), 3/(8n)            (3)
//! a boundary vertex:               3/4 v + 1/8 (v₀ + vₙ₋₁)                                   (4)
//! limit of an inner vertex:        (1 - nγ) v + γ Σ vᵢ,  γ = 1/(n + 3/(8β))                  (5)
//! limit of a boundary vertex:      2/3 v + 1/6 (v₀ + vₙ₋₁): a cubic B-spline                 (6)
//! inner tangents:                  Σ cos(2πi/n) vᵢ,  Σ sin(2πi/n) vᵢ                         (7)
//! ```
//!
//! Tangents on boundaries are those of Hoppe et al. (1994, "Piecewise Smooth Surface
//! Reconstruction", appendix). pbrt-v4 has weights of 1/5 in (6), which is not the limit.

use kaustika_math::Vec3;
use kaustika_scene::description::TriMesh;
use std::collections::HashMap;
use std::f32::consts::PI;

/// More triangles than this are not made: they take some seconds and a gigabyte or two.
const MOST_TRIANGLES: usize = 1 << 24;

/// The neighbours of a vertex.
struct Ring {
    /// Anticlockwise, seen from the front.
    around: Vec<u32>,
    /// True if it does not close.
    is_boundary: bool,
}

/// The limit surface of a control mesh, as a mesh: its vertices after `levels` subdivisions, moved
/// to their limits, with the normals there. An error is a one-line cause.
pub fn subdivide(
    mut positions: Vec<Vec3>,
    mut triangles: Vec<[u32; 3]>,
    levels: u32,
) -> Result<TriMesh, String> {
    let total = 4usize.checked_pow(levels).and_then(|n| n.checked_mul(triangles.len()));
    if total.is_none_or(|n| n > MOST_TRIANGLES) {
        return Err(format!("{levels} levels would make more than {MOST_TRIANGLES} triangles"));
    }
    for _ in 0..levels {
        (positions, triangles) = refine(&positions, &triangles)?;
    }
    let rings = rings(positions.len(), &triangles)?;
    let of = |f: fn(&[Vec3], usize, &Ring) -> Vec3| {
        rings.iter().enumerate().map(|(v, ring)| f(&positions, v, ring)).collect::<Vec<Vec3>>()
    };
    let normals = of(normal);
    Ok(TriMesh { positions: of(limit), normals, indices: triangles, ..TriMesh::default() })
}

/// The neighbours of all vertices.
fn rings(vertices: usize, triangles: &[[u32; 3]]) -> Result<Vec<Ring>, String> {
    // Of each vertex: the other two corners of its triangles, in their order.
    let mut wedges: Vec<Vec<[u32; 2]>> = vec![Vec::new(); vertices];
    for t in triangles {
        for i in 0..3 {
            wedges[t[i] as usize].push([t[(i + 1) % 3], t[(i + 2) % 3]]);
        }
    }
    wedges.iter().enumerate().map(|(v, wedges)| ring(v, wedges)).collect()
}

fn ring(vertex: usize, wedges: &[[u32; 2]]) -> Result<Ring, String> {
    let first = wedges.iter().find(|w| wedges.iter().all(|o| o[1] != w[0]));
    let Some(start) = first.or(wedges.first()) else {
        return Ok(Ring { around: Vec::new(), is_boundary: true });
    };
    let is_boundary = first.is_some();
    let mut around = vec![start[0]];
    let mut last = start[1];
    while last != start[0] {
        around.push(last);
        // Each wedge is followed by one other at most, or they do not form one fan.
        let mut next = wedges.iter().filter(|w| w[0] == last);
        match (next.next(), next.next()) {
            (Some(w), None) if around.len() <= wedges.len() => last = w[1],
            (None, _) if is_boundary => break,
            _ => return Err(not_one_fan(vertex)),
        }
    }
    match around.len() == wedges.len() + usize::from(is_boundary) {
        true => Ok(Ring { around, is_boundary }),
        false => Err(not_one_fan(vertex)),
    }
}

fn not_one_fan(vertex: usize) -> String {
    format!("the triangles at point {vertex} do not form one fan of one orientation")
}

/// One subdivision.
fn refine(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
) -> Result<(Vec<Vec3>, Vec<[u32; 3]>), String> {
    let mut out: Vec<Vec3> = Vec::with_capacity(4 * positions.len());
    for (v, ring) in rings(positions.len(), triangles)?.iter().enumerate() {
        let weight = if ring.is_boundary { 0.125 } else { beta(ring.around.len()) };
        out.push(weighted(positions, v, ring, weight)); // (3), (4)
    }
    // Corners across each edge, by its ends in rising order.
    let key = |a: u32, b: u32| (a.min(b), a.max(b));
    let mut across: HashMap<(u32, u32), (u32, Vec<u32>)> = HashMap::new();
    for t in triangles {
        for i in 0..3 {
            let edge = across.entry(key(t[i], t[(i + 1) % 3])).or_insert_with(|| {
                out.push(Vec3::ZERO);
                (out.len() as u32 - 1, Vec::with_capacity(2))
            });
            edge.1.push(t[(i + 2) % 3]);
        }
    }
    let p = |i: u32| positions[i as usize];
    for (&(a, b), (number, corners)) in &across {
        out[*number as usize] = match corners[..] {
            [c, d] => (p(a) + p(b)) * 0.375 + (p(c) + p(d)) * 0.125, // (1)
            _ => (p(a) + p(b)) * 0.5,                                // (2)
        };
    }
    let middle = |a: u32, b: u32| across[&key(a, b)].0;
    let parts = triangles.iter().flat_map(|&[a, b, c]| {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    });
    let parts = parts.collect();
    Ok((out, parts))
}

fn beta(neighbours: usize) -> f32 {
    if neighbours == 3 { 3.0 / 16.0 } else { 3.0 / (8.0 * neighbours as f32) }
}

/// The vertex and its neighbours, of which a boundary's count only with the two on it.
fn weighted(positions: &[Vec3], vertex: usize, ring: &Ring, weight: f32) -> Vec3 {
    let p = |i: &u32| positions[*i as usize];
    let v = positions[vertex];
    match (ring.is_boundary, &ring.around[..]) {
        (true, [first, .., last]) => v * (1.0 - 2.0 * weight) + (p(first) + p(last)) * weight,
        (true, _) => v,
        (false, around) => {
            let sum = around.iter().map(p).fold(Vec3::ZERO, |a, b| a + b);
            v * (1.0 - around.len() as f32 * weight) + sum * weight
        }
    }
}

fn limit(positions: &[Vec3], vertex: usize, ring: &Ring) -> Vec3 {
    let n = ring.around.len();
    let weight = match ring.is_boundary {
        true => 1.0 / 6.0,                                 // (6)
        false => 1.0 / (n as f32 + 3.0 / (8.0 * beta(n))), // (5)
    };
    weighted(positions, vertex, ring, weight)
}

/// Normal of the limit surface, on the side from which the corners run clockwise: pbrt-v4's.
fn normal(positions: &[Vec3], vertex: usize, ring: &Ring) -> Vec3 {
    let v = positions[vertex];
    let p: Vec<Vec3> = ring.around.iter().map(|i| positions[*i as usize]).collect();
    let n = p.len();
    let sum = |weight: &dyn Fn(usize) -> f32| {
        p.iter().enumerate().fold(Vec3::ZERO, |s, (i, p)| s + *p * weight(i))
    };
    let (s, t) = if !ring.is_boundary {
        let angle = |i: usize| 2.0 * PI * i as f32 / n as f32;
        (sum(&|i| angle(i).cos()), sum(&|i| angle(i).sin())) // (7)
    } else if n < 2 {
        return Vec3::ZERO;
    } else {
        let inward = match n {
            2 => p[0] + p[1] - v * 2.0,
            3 => p[1] - v,
            4 => p[1] * 2.0 + p[2] * 2.0 - p[0] - p[3] - v * 2.0,
            _ => {
                let theta = PI / (n - 1) as f32;
                let end = theta.sin();
                let inner = 2.0 * theta.cos() - 2.0;
                -sum(&|k| match k == 0 || k == n - 1 {
                    true => end,
                    false => inner * (k as f32 * theta).sin(),
                })
            }
        };
        (p[0] - p[n - 1], inward)
    };
    -s.cross(t).try_normalize().unwrap_or(Vec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A closed body of vertices with 4 and 5 neighbours, and an open one with a boundary.
    fn bodies() -> [(Vec<Vec3>, Vec<[u32; 3]>); 2] {
        let v = Vec3::new;
        let mut double_pyramid = vec![v(0.1, 0.2, 1.5), v(0.0, -0.1, -1.0)];
        let mut faces = Vec::new();
        for i in 0..5 {
            let a = i as f32 * 2.0 * PI / 5.0;
            double_pyramid.push(v(a.cos(), a.sin(), 0.1 * i as f32));
            let (j, k) = (2 + i, 2 + (i + 1) % 5);
            faces.extend([[0, j, k], [1, k, j]]);
        }
        let open: Vec<Vec3> =
            (0..9).map(|i| v((i % 3) as f32, (i / 3) as f32, ((i * i) % 5) as f32 * 0.3)).collect();
        let cells = [0u32, 1, 3, 4];
        let open_faces =
            cells.iter().flat_map(|&c| [[c, c + 1, c + 4], [c, c + 4, c + 3]]).collect();
        [(double_pyramid, faces), (open, open_faces)]
    }

    /// The limit is that, however far it was gone toward it.
    #[test]
    fn limits_do_not_depend_on_the_level() {
        for (positions, triangles) in bodies() {
            let at = |levels| subdivide(positions.clone(), triangles.clone(), levels).unwrap();
            let first = at(0);
            for levels in 1..5 {
                let finer = at(levels);
                assert_eq!(finer.indices.len(), triangles.len() << (2 * levels));
                for i in 0..positions.len() {
                    assert!((finer.positions[i] - first.positions[i]).length() < 2e-6, "{i}");
                    assert!((finer.normals[i] - first.normals[i]).length() < 1e-3, "{i} {levels}");
                }
            }
        }
    }

    #[test]
    fn normals_are_those_of_the_fine_mesh_from_behind() {
        for (positions, triangles) in bodies() {
            let mesh = subdivide(positions, triangles, 5).unwrap();
            let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
            for t in &mesh.indices {
                let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
                t.iter().for_each(|&i| sums[i as usize] += (b - a).cross(c - a));
            }
            for (sum, n) in sums.iter().zip(&mesh.normals) {
                assert!(sum.normalize().dot(*n) < -0.99, "{sum:?} {n:?}");
            }
        }
    }

    #[test]
    fn what_is_no_surface_is_refused() {
        let p = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(1.0, 1.0, 1.0)];
        let three_at_an_edge = vec![[0, 1, 2], [0, 3, 1], [0, 4, 1]];
        let turned = vec![[0, 1, 2], [0, 1, 3]];
        for triangles in [three_at_an_edge, turned] {
            let cause = subdivide(p.clone(), triangles, 1).unwrap_err();
            assert!(cause.contains("do not form one fan"), "{cause}");
        }
        let cause = subdivide(p, vec![[0, 1, 2]], 30).unwrap_err();
        assert!(cause.contains("30 levels"), "{cause}");
    }
}
