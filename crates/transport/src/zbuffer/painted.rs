//! A mesh whose vertices have their light already, such as that of a radiosity solution: drawn by z-buffer,
//! interpolated between vertices (Gouraud 1971; Cohen & Greenberg 1985 for radiosity).

use super::mesh::Meshes;
use super::raster::{AREA, EMPTY, Holes, Raster, TILE, Tile};
use super::shade::background;
use super::view::View;
use kaustika_scene::Scene;
use kaustika_scene::description::TriMesh;

/// Draws it again and again.
#[derive(Debug)]
pub struct Painted {
    meshes: Meshes,
    colors: Vec<[f32; 3]>,
    raster: Raster,
    pixels: Vec<[f32; 3]>,
}

impl Painted {
    /// Of a mesh with the attribute `vertex_color` of three channels, linear RGB; `None` without it.
    pub fn new(mesh: &TriMesh) -> Option<Painted> {
        let is_color = |name: &str, channels| name == "vertex_color" && channels == 3;
        let colors = mesh.attributes.iter().find(|a| is_color(&a.name, a.channels))?;
        let colors: Vec<[f32; 3]> = colors.values.as_chunks().0.to_vec();
        let whole = colors.len() == mesh.positions.len();
        let meshes = Meshes::of_front(mesh);
        let (raster, pixels) = (Raster::default(), Vec::new());
        whole.then_some(Painted { meshes, colors, raster, pixels })
    }

    /// Draws what a view shows, before what surrounds a scene.
    pub fn draw(&mut self, scene: &Scene, view: &View) {
        let Painted { meshes, colors, raster, pixels } = self;
        raster.sort(meshes, view);
        let holes = Holes { shapes: &[false], open: &|_, _| false };
        raster.fill(
            meshes,
            view,
            &holes,
            pixels,
            || [0.0; 3],
            |tile, out| {
                for i in (0..AREA).filter(|i| i % TILE < tile.size[0] && i / TILE < tile.size[1]) {
                    out[i] = pixel(scene, view, (meshes, colors), tile, i);
                }
            },
        );
    }

    /// Linear RGB of a pixel.
    #[inline]
    pub fn color(&self, x: u32, y: u32) -> [f32; 3] {
        self.pixels[self.raster.place(x, y)]
    }
}

fn pixel(
    scene: &Scene,
    view: &View,
    (meshes, colors): (&Meshes, &[[f32; 3]]),
    tile: &Tile,
    i: usize,
) -> [f32; 3] {
    let (x, y) = ((tile.origin[0] + i % TILE) as f64, (tile.origin[1] + i / TILE) as f64);
    if tile.slots[i] == EMPTY {
        return background(scene, view, x, y);
    }
    let triangle = tile.triangle(tile.slots[i]);
    let b = triangle.barycentric(x, y);
    let at = meshes.indices[triangle.id as usize].map(|v| colors[v as usize]);
    std::array::from_fn(|k| at[0][k] * b[0] + at[1][k] * b[1] + at[2][k] * b[2])
}
