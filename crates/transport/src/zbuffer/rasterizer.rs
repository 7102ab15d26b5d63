//! A scene made ready to be drawn, and the picture drawn last.

use super::lamps::Lamps;
use super::looks::{Look, texture_point};
use super::mesh::Meshes;
use super::params::ZBufferParams;
use super::raster::{Holes, Raster};
use super::shade::Shader;
use super::view::View;
use kaustika_math::Vec3;
use kaustika_scene::{Scene, Surface};

/// Draws a scene again and again.
#[derive(Debug)]
pub struct Rasterizer {
    params: ZBufferParams,
    looks: Vec<Look>,
    meshes: Meshes,
    lamps: Lamps,
    /// Of each shape whether it has holes.
    holes: Vec<bool>,
    raster: Raster,
    /// Linear RGB, as the raster's buffers lie.
    colors: Vec<[f32; 3]>,
}

/// What a pixel shows.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Which triangle, as [`Meshes::sources`] tells.
    pub triangle: u32,
    /// Barycentric weights of its corners.
    pub b: [f32; 3],
    /// Depth, in units of camera space.
    pub depth: f32,
    /// The point.
    pub p: Vec3,
}

impl Rasterizer {
    /// Of a scene.
    pub fn new(scene: &Scene, params: &ZBufferParams) -> Rasterizer {
        let looks = Look::all(scene);
        let drawn = |shape: u32| params.clear || looks[shape as usize].opaque;
        let meshes = Meshes::new(scene, drawn);
        let holes: Vec<bool> = looks.iter().map(Look::has_holes).collect();
        // A lamp stands in the middle of what emits, which must not hide it.
        let casters = Meshes::new(scene, |s| drawn(s) && !looks[s as usize].emits);
        let lamps = {
            let open = opening(scene, &looks, &casters);
            Lamps::new(scene, params, &looks, &casters, &Holes { shapes: &holes, open: &open })
        };
        Rasterizer {
            params: params.clone(),
            looks,
            meshes,
            lamps,
            holes,
            raster: Raster::default(),
            colors: Vec::new(),
        }
    }

    /// Draws what a view shows; pixel (i, j) is what lies at x = i, y = j.
    pub fn draw(&mut self, scene: &Scene, view: &View) {
        let Rasterizer { looks, meshes, lamps, holes, raster, .. } = self;
        raster.sort(meshes, view);
        let open = opening(scene, looks, meshes);
        let holes = Holes { shapes: holes, open: &open };
        let model = self.params.model;
        let shader = Shader { scene, meshes, looks, lamps, model, view };
        raster.fill(
            meshes,
            view,
            &holes,
            &mut self.colors,
            || [0.0; 3],
            |tile, out| {
                shader.shade(tile, out);
            },
        );
    }

    /// Linear RGB of a pixel.
    #[inline]
    pub fn color(&self, x: u32, y: u32) -> [f32; 3] {
        self.colors[self.raster.place(x, y)]
    }

    /// What a pixel of the view that was drawn shows.
    pub fn seen(&self, view: &View, x: u32, y: u32) -> Option<Seen> {
        let (triangle, kappa) = self.raster.seen(x, y)?;
        let (fx, fy) = (f64::from(x), f64::from(y));
        let p = view.point(fx, fy, view.depth(f64::from(kappa)));
        let depth = view.depth(f64::from(kappa)) as f32;
        Some(Seen { triangle: triangle.id, b: triangle.barycentric(fx, fy), depth, p })
    }

    /// The triangles.
    pub fn meshes(&self) -> &Meshes {
        &self.meshes
    }

    /// The scene's surface that a pixel shows, `t` along a ray.
    pub fn surface(&self, scene: &Scene, seen: &Seen, t: f32) -> Surface {
        self.meshes.surface(scene, seen.triangle, seen.b, t)
    }
}

/// Whether a triangle of some meshes is open at a place.
fn opening<'a>(
    scene: &'a Scene,
    looks: &'a [Look],
    meshes: &'a Meshes,
) -> impl Fn(u32, [f32; 3]) -> bool + Sync + 'a {
    |id, b| {
        let shape = meshes.sources[id as usize].shape as usize;
        looks[shape].open(scene, &texture_point(meshes, id, b, 0.0))
    }
}
