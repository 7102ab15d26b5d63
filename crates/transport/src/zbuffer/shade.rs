//! What a tile's pixels look like, sixteen of a row at a time.

use super::lamps::{Lamps, Lit, Points};
use super::looks::{Look, texture_point};
use super::mesh::Meshes;
use super::params::Model;
use super::raster::{EMPTY, TILE, Tile};
use super::view::View;
use kaustika_math::lanes::{LANES, Lanes, Row, Vec3s};
use kaustika_math::{Ray, Vec3};
use kaustika_scene::Scene;
use kaustika_spectra::{Sensor, Spectrum, Wavelengths};

/// Shades what a view shows.
pub struct Shader<'a> {
    /// Whose materials and lights.
    pub scene: &'a Scene,
    /// Its triangles.
    pub meshes: &'a Meshes,
    /// Of each shape.
    pub looks: &'a [Look],
    /// What lights it.
    pub lamps: &'a Lamps,
    /// How.
    pub model: Model,
    /// From where.
    pub view: &'a View,
}

/// Sixteen pixels before they are lit.
struct Block {
    /// Those that show something, a bit each.
    live: u32,
    /// Those whose surface emits, or is textured.
    emit: u32,
    textured: u32,
    /// Triangles and barycentric weights.
    ids: [u32; LANES],
    b: [[f32; 3]; LANES],
    /// Vertex or facet normals there; not unit.
    n: [Row; 3],
    facet: [Row; 3],
    diffuse: [Row; 3],
    specular: [Row; 3],
    exponent: Row,
}

/// Least cosine by which footprints grow on surfaces seen obliquely.
const GRAZING: f32 = 0.125;

impl Shader<'_> {
    /// Fills the colours of a tile, linear RGB.
    pub fn shade(&self, tile: &Tile, out: &mut [[f32; 3]]) {
        for y in 0..tile.size[1] {
            for x in (0..tile.size[0]).step_by(LANES) {
                let from = y * TILE + x;
                let (Some(slots), Some(nearness), Some(out)) = (
                    tile.slots[from..].first_chunk::<LANES>(),
                    tile.nearness[from..].first_chunk::<LANES>(),
                    out[from..].first_chunk_mut::<LANES>(),
                ) else {
                    continue;
                };
                let at = [tile.origin[0] + x, tile.origin[1] + y];
                self.pixels(tile, slots, nearness, at, out);
            }
        }
    }

    fn pixels(
        &self,
        tile: &Tile,
        slots: &[u32; LANES],
        nearness: &[f32; LANES],
        [x, y]: [usize; 2],
        out: &mut [[f32; 3]; LANES],
    ) {
        let mut block = self.gather(tile, slots, [x, y]);
        if block.live != 0 {
            let [o, a, dx, dy] = self.view.back().map(splat);
            let xs = Lanes::new(std::array::from_fn(|i| (x + i) as f32));
            let across = dx * xs + dy * Lanes::splat(y as f32);
            let kappa = Lanes::new(*nearness);
            let (p, v) = match self.view.perspective {
                true => {
                    let p = o.plus(a + across, Lanes::splat(1.0) / kappa);
                    (p, (o - p).normalize())
                }
                false => (o.plus(a, -kappa) + across, -a.normalize()),
            };
            let facet = Vec3s::load(&block.facet).face_forward(v);
            if block.textured != 0 {
                self.texture(&mut block, &facet.dot(v).to_array(), nearness);
            }
            let lit = self.lit(&block, p, v, facet);
            let color = |k: usize| {
                let diffuse = Lanes::new(block.diffuse[k]) * lit.diffuse[k];
                Lanes::new(block.specular[k]).mul_add(lit.specular[k], diffuse).to_array()
            };
            let rgb = [color(0), color(1), color(2)];
            let toward = v.to_rows();
            for i in 0..LANES {
                out[i] = [rgb[0][i], rgb[1][i], rgb[2][i]];
                if block.emit >> i & 1 != 0 {
                    let v = Vec3::new(toward[0][i], toward[1][i], toward[2][i]);
                    let s = self.meshes.surface(self.scene, block.ids[i], block.b[i], 0.0);
                    let le = rgb_of(self.scene.le(&s, v, &Wavelengths::rgb()));
                    (0..3).for_each(|k| out[i][k] += le[k]);
                }
            }
        }
        for i in (0..LANES).filter(|i| block.live >> i & 1 == 0) {
            out[i] = background(self.scene, self.view, (x + i) as f64, y as f64);
        }
    }

    /// What the triangles and materials of sixteen pixels are.
    #[inline]
    fn gather(&self, tile: &Tile, slots: &[u32; LANES], [x, y]: [usize; 2]) -> Block {
        let mut block = Block {
            live: 0,
            emit: 0,
            textured: 0,
            ids: [0; LANES],
            b: [[0.0; 3]; LANES],
            n: [[0.0; LANES]; 3],
            facet: [[0.0; LANES]; 3],
            diffuse: [[0.0; LANES]; 3],
            specular: [[0.0; LANES]; 3],
            exponent: [1.0; LANES],
        };
        let smooth = matches!(self.model, Model::Phong | Model::Blinn);
        for (i, &slot) in slots.iter().enumerate().filter(|(_, slot)| **slot != EMPTY) {
            let triangle = tile.triangle(slot);
            let id = triangle.id as usize;
            let look = &self.looks[self.meshes.sources[id].shape as usize];
            let b = triangle.barycentric((x + i) as f64, y as f64);
            let facet = self.meshes.facets[id];
            let n = if smooth { self.normal(id, b, facet) } else { facet };
            block.live |= 1 << i;
            block.emit |= u32::from(look.emits) << i;
            block.textured |= u32::from(look.texture.is_some()) << i;
            (block.ids[i], block.b[i]) = (id as u32, b);
            for k in 0..3 {
                (block.n[k][i], block.facet[k][i]) = (n[k], facet[k]);
                block.diffuse[k][i] = look.diffuse[k];
                block.specular[k][i] = look.specular[k];
            }
            block.exponent[i] = look.exponent;
        }
        block
    }

    /// Interpolated normal, not unit; the facet's where the corners have none.
    #[inline]
    fn normal(&self, id: usize, b: [f32; 3], facet: Vec3) -> Vec3 {
        let [n0, n1, n2] = self.meshes.indices[id].map(|i| self.meshes.normals[i as usize]);
        let n = n0 * b[0] + n1 * b[1] + n2 * b[2];
        if n.length_squared() > 0.0 { n } else { facet }
    }

    /// Multiplies diffuse reflectances by textures, filtered over the pixel.
    fn texture(&self, block: &mut Block, cos: &Row, nearness: &[f32; LANES]) {
        for i in (0..LANES).filter(|i| block.textured >> i & 1 != 0) {
            let id = block.ids[i];
            let shape = self.meshes.sources[id as usize].shape;
            let Some(texture) = &self.looks[shape as usize].texture else { continue };
            let z = if self.view.perspective { 1.0 / nearness[i] } else { 1.0 };
            let width = self.view.pixel * z / cos[i].max(GRAZING);
            let width = width * self.meshes.stretch[id as usize];
            let point = texture_point(self.meshes, id, block.b[i], width);
            let color = texture.color(self.scene, &point);
            (0..3).for_each(|k| block.diffuse[k][i] *= color[k]);
        }
    }

    /// Light as the model has it.
    #[inline]
    fn lit(&self, block: &Block, p: Vec3s, v: Vec3s, facet: Vec3s) -> Lit {
        let highlights =
            self.model != Model::Bouknight && block.specular.iter().flatten().any(|&s| s > 0.0);
        let exponent = Lanes::new(block.exponent);
        let light = |p: Vec3s, n: Vec3s, v: Vec3s| {
            // On the side of the facet that the eye sees.
            let n = n.normalize().face_forward(facet);
            let at = Points { p, n, facet, v, exponent, live: block.live };
            self.lamps.light(self.scene, &at, self.model, highlights)
        };
        match self.model {
            Model::Phong | Model::Blinn => light(p, Vec3s::load(&block.n), v),
            Model::Bouknight => {
                let middle =
                    Vec3s::load(&self.corners(block, |c, _, _| (c[0] + c[1] + c[2]) / 3.0));
                light(middle, facet, self.toward_eye(middle, v))
            }
            Model::Gouraud => {
                let zero = [Lanes::splat(0.0); 3];
                let mut sum = Lit { diffuse: zero, specular: zero };
                for corner in 0..3 {
                    let p = Vec3s::load(&self.corners(block, |c, _, _| c[corner]));
                    let mut unit = [0.0; 3];
                    unit[corner] = 1.0;
                    let n = self.corners(block, |_, id, facet| self.normal(id, unit, facet));
                    let lit = light(p, Vec3s::load(&n), self.toward_eye(p, v));
                    let b = Lanes::new(std::array::from_fn(|i| block.b[i][corner]));
                    for k in 0..3 {
                        sum.diffuse[k] = lit.diffuse[k].mul_add(b, sum.diffuse[k]);
                        sum.specular[k] = lit.specular[k].mul_add(b, sum.specular[k]);
                    }
                }
                sum
            }
        }
    }

    fn toward_eye(&self, p: Vec3s, v: Vec3s) -> Vec3s {
        match self.view.perspective {
            true => (splat(self.view.back()[0]) - p).normalize(),
            false => v,
        }
    }

    /// Something of the corners, number and facet normal of each pixel's triangle.
    fn corners(&self, block: &Block, f: impl Fn([Vec3; 3], usize, Vec3) -> Vec3) -> [Row; 3] {
        let mut rows = [[0.0; LANES]; 3];
        for i in (0..LANES).filter(|i| block.live >> i & 1 != 0) {
            let id = block.ids[i];
            let v = f(self.meshes.corners(id), id as usize, self.meshes.facets[id as usize]);
            (0..3).for_each(|k| rows[k][i] = v[k]);
        }
        rows
    }
}

/// What surrounds the scene, at a sample of a picture.
pub fn background(scene: &Scene, view: &View, x: f64, y: f64) -> [f32; 3] {
    if scene.environments.is_empty() {
        return [0.0; 3];
    }
    let [o, a, dx, dy] = view.back();
    let across = dx * x as f32 + dy * y as f32;
    let ray = match view.perspective {
        true => Ray::new(o, (a + across).normalize()),
        false => Ray::new(o + across, a.normalize()),
    };
    let lambda = Wavelengths::rgb();
    let le = scene
        .environments
        .iter()
        .fold(Spectrum::ZERO, |sum, &id| sum + scene.light(id).escaped(ray.o, ray.d, &lambda).le);
    rgb_of(le)
}

fn rgb_of(s: Spectrum) -> [f32; 3] {
    Sensor::default().rgb(s, &Wavelengths::rgb())
}

fn splat(v: Vec3) -> Vec3s {
    Vec3s { x: Lanes::splat(v.x), y: Lanes::splat(v.y), z: Lanes::splat(v.z) }
}
