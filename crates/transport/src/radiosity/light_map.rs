//! The solution as a light map: a texture with a chart for each triangle, and a mesh with the uv.
//!
//! ```text
//! x = x₀ + (k + ½) + w b₁,   y = y₀ + (k + ½) + h b₂                                 (1)
//! ```
//!
//! A chart is a right triangle in a rectangle of (w + 1 + 2k) × (h + 1 + 2k) texels, the right angle at
//! the corner across the longest side, k texels of gutter around. Corners lie in the middle of texels, so
//! that what a bilinear filter reads inside the triangle are texels of the chart. Those beyond the longest
//! side and in the gutter repeat the nearest place of the triangle. Charts stand on shelves, the tallest
//! first.

use super::mesh::Element;
use super::solution::Solution;
use crate::method::LightMap;
use kaustika_math::Vec2;
use kaustika_scene::description::TriMesh;
use kaustika_spectra::Spectrum;
use rayon::prelude::*;
use std::f32::consts::PI;

/// k of (1).
const GUTTER: u32 = 1;
/// Texels along a side of a patch of mean size.
const FINENESS: f32 = 2.0;
/// Most texels along a side of a map.
const MOST: u32 = 16_384;

/// Where a root is on the map.
struct Chart {
    root: u32,
    /// The element's corners in the order of (1).
    order: [usize; 3],
    /// w and h of (1).
    cells: [u32; 2],
    /// x₀ and y₀ of (1).
    origin: [u32; 2],
}

impl Chart {
    fn new(root: u32, element: &Element, texel: f32) -> Chart {
        let k = (element.longest_side().0 + 2) % 3;
        let order = [k, (k + 1) % 3, (k + 2) % 3];
        let side = |to: usize| {
            let length = (element.corners[order[to]] - element.corners[k]).length();
            ((length / texel).ceil() as u32).clamp(1, MOST / 4)
        };
        Chart { root, order, cells: [side(1), side(2)], origin: [0; 2] }
    }

    fn size(&self) -> [u32; 2] {
        self.cells.map(|n| n + 1 + 2 * GUTTER)
    }

    /// (1): barycentric weights, on the element, of the middle of a texel or of the nearest place.
    fn weights(&self, x: u32, y: u32) -> [f32; 3] {
        let part = |i: u32, k: usize| (i as f32 - GUTTER as f32) / self.cells[k] as f32;
        let [mut b1, mut b2] = [part(x, 0), part(y, 1)].map(|b| b.clamp(0.0, 1.0));
        let over = (b1 + b2 - 1.0).max(0.0) * 0.5;
        (b1, b2) = ((b1 - over).clamp(0.0, 1.0), (b2 - over).clamp(0.0, 1.0));
        let mut b = [0.0; 3];
        (b[self.order[0]], b[self.order[1]], b[self.order[2]]) = (1.0 - b1 - b2, b1, b2);
        b
    }
}

/// Puts charts on shelves of a map about as wide as high; its size.
fn pack(charts: &mut [Chart]) -> [u32; 2] {
    let mut order: Vec<usize> = (0..charts.len()).collect();
    order.sort_by_key(|&i| (std::cmp::Reverse(charts[i].size()[1]), i));
    let area: f64 =
        charts.iter().map(|c| c.size().iter().map(|&n| f64::from(n)).product::<f64>()).sum();
    let widest = charts.iter().map(|c| c.size()[0]).max().unwrap_or(1);
    let width = (area.sqrt().ceil() as u32).max(widest);
    let (mut x, mut y, mut shelf) = (0, 0, 0);
    for i in order {
        let [w, h] = charts[i].size();
        if x + w > width {
            (x, y, shelf) = (0, y + shelf, 0);
        }
        charts[i].origin = [x, y];
        (x, shelf) = (x + w, shelf.max(h));
    }
    [width, y + shelf]
}

/// The map of all that reflects or emits, and its mesh: `None` if it would be larger than a map may be.
pub fn light_map(solution: &Solution) -> Option<LightMap> {
    let mesh = &solution.mesh;
    let roots: Vec<u32> =
        (0..mesh.roots).filter(|&e| !mesh.elements[e as usize].is_black()).collect();
    let area: f32 = roots.iter().map(|&e| mesh.elements[e as usize].area).sum();
    let leaves = solution.leaves.len().max(1) as f32;
    let texel = (area / leaves).sqrt() / FINENESS;
    let mut charts: Vec<Chart> =
        roots.iter().map(|&e| Chart::new(e, &mesh.elements[e as usize], texel)).collect();
    let [width, height] = pack(&mut charts);
    if width > MOST || height > MOST {
        return None;
    }
    let black = vec![[0.0; 3]; width as usize * height as usize];
    let (mut radiance, mut irradiance) = (black.clone(), black);
    let filled: Vec<Vec<[Spectrum; 2]>> =
        charts.par_iter().map(|chart| fill(solution, chart)).collect();
    for (chart, texels) in charts.iter().zip(filled) {
        let [w, _] = chart.size();
        for (i, [l, h]) in texels.into_iter().enumerate() {
            let (x, y) = (chart.origin[0] + i as u32 % w, chart.origin[1] + i as u32 / w);
            let at = (y * width + x) as usize;
            (radiance[at], irradiance[at]) = (l.rgb(), h.rgb());
        }
    }
    let mesh = with_uv(solution, &charts, [width, height]);
    Some(LightMap { size: [width, height], radiance, irradiance, mesh })
}

/// Radiance and irradiance of a chart's texels, row by row.
fn fill(solution: &Solution, chart: &Chart) -> Vec<[Spectrum; 2]> {
    let Solution { mesh, shading, direct, indirect, .. } = solution;
    let [w, h] = chart.size();
    let texel = |i: u32| {
        let at = mesh.elements[chart.root as usize].place(chart.weights(i % w, i / w));
        let (leaf, b) = mesh.leaf(chart.root, at);
        let element = &mesh.elements[leaf as usize];
        let h = shading.smooth(indirect, leaf, b) + shading.smooth(direct, leaf, b);
        [(element.emission + element.albedo * h) / PI, h]
    };
    (0..w * h).map(texel).collect()
}

/// The roots as triangles, with their places on the map: u to the right and v up, from the lower left.
fn with_uv(solution: &Solution, charts: &[Chart], size: [u32; 2]) -> TriMesh {
    let mut mesh = TriMesh::default();
    let [width, height] = size.map(|n| n as f32);
    for chart in charts {
        let element = &solution.mesh.elements[chart.root as usize];
        let first = mesh.positions.len() as u32;
        let [w, h] = chart.cells;
        for (&corner, [x, y]) in chart.order.iter().zip([[0, 0], [w, 0], [0, h]]) {
            let middle = |k: usize, n: u32| (chart.origin[k] + GUTTER + n) as f32 + 0.5;
            mesh.positions.push(element.corners[corner]);
            mesh.uvs.push(Vec2::new(middle(0, x) / width, 1.0 - middle(1, y) / height));
        }
        let [a, b, c] = chart.order.map(|k| element.corners[k]);
        mesh.indices.push(match (b - a).cross(c - a).dot(element.normal) < 0.0 {
            true => [first, first + 2, first + 1],
            false => [first, first + 1, first + 2],
        });
    }
    mesh
}
