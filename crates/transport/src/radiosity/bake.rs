//! The solution as a mesh with colours, for other programs to show.
//!
//! ```text
//! colour = (E + ρ H) / π,   radiance, the same in all directions                     (1)
//! ```

use super::solution::Solution;
use kaustika_scene::description::{MeshAttribute, TriMesh};
use kaustika_spectra::Spectrum;
use std::collections::HashMap;
use std::f32::consts::PI;

/// (1) at the vertices, with their irradiance: `vertex_color` and `vertex_irradiance`. Patches of
/// different colours have vertices of their own. Of what emits and of direct light all is there.
pub fn bake(solution: &Solution) -> TriMesh {
    let Solution { mesh, shading, direct, indirect, leaves, .. } = solution;
    let mut baked = TriMesh::default();
    let (mut colors, mut irradiance) = (Vec::new(), Vec::new());
    let mut numbers = HashMap::new();
    for (&leaf, corners) in leaves.iter().zip(shading.corners()) {
        let element = &mesh.elements[leaf as usize];
        let bits = |s: Spectrum| s.rgb().map(f32::to_bits);
        let matter = [bits(element.albedo), bits(element.emission)];
        let mut triangle = corners.map(|v| {
            *numbers.entry((v, matter)).or_insert_with(|| {
                let h = indirect.vertices[v as usize] + direct.vertices[v as usize];
                let radiance = (element.emission + element.albedo * h) / PI; // (1)
                baked.positions.push(shading.positions()[v as usize]);
                colors.extend(radiance.rgb());
                irradiance.extend(h.rgb());
                baked.positions.len() as u32 - 1
            })
        });
        let [a, b, c] = element.corners;
        if (b - a).cross(c - a).dot(element.normal) < 0.0 {
            triangle.swap(1, 2);
        }
        baked.indices.push(triangle);
    }
    let attribute = |name: &str, values| MeshAttribute {
        name: name.into(),
        channels: 3,
        per_face: false,
        values,
    };
    baked.attributes =
        vec![attribute("vertex_color", colors), attribute("vertex_irradiance", irradiance)];
    baked
}
