//! The scene's materials in terms of the classical models.
//!
//! ```text
//! k_d = π f_D(n, n),   k_s = ρ(n) - k_d                                              (1)
//! n = 2/α² - 2 for half vectors (Walter et al. 2007),  a quarter of it about the mirror direction     (2)
//! ```
//!
//! f_D is the diffuse part of the material seen and lit along its normal, ρ its albedo there and α its roughness. A
//! material that is textured keeps the texture, scaled so that (1) holds at one place.

use super::mesh::Meshes;
use kaustika_math::Vec2;
use kaustika_scene::bsdf::{Lobes, Mode};
use kaustika_scene::description::TextureId;
use kaustika_scene::{BitmapSampler, Looks, Scene, ShapeInfo, TexturePoint, Tint};
use kaustika_spectra::{Sensor, Spectrum, Wavelengths};

/// A shape as a classical picture has it.
#[derive(Debug)]
pub struct Look {
    /// Diffuse reflectance, or what the texture is multiplied by.
    pub diffuse: [f32; 3],
    /// Reflectance of the highlight.
    pub specular: [f32; 3],
    /// Of the lobe about the mirror direction; of half vectors four times this.
    pub exponent: f32,
    /// True if it emits.
    pub emits: bool,
    /// What colours it, if that varies.
    pub texture: Option<Texture>,
    /// Opacities that cut it out.
    opacity: Vec<TextureId>,
    /// False for what lets light through without scattering it everywhere.
    pub opaque: bool,
}

/// Textures that add up to a colour.
#[derive(Debug)]
pub struct Texture {
    layers: Vec<Layer>,
}

/// A texture, as an image with mip maps where it is one, and what part of a mixture it is.
#[derive(Debug)]
struct Layer {
    tint: Tint,
    image: Option<BitmapSampler>,
}

/// Greatest exponent.
const SHARPEST: f32 = 4096.0;

impl Look {
    /// Of every shape, in the scene's order.
    pub fn all(scene: &Scene) -> Vec<Look> {
        let mut looks: Vec<Look> = scene.shapes.iter().map(|s| Look::new(scene, s)).collect();
        let all = Meshes::new(scene, |_| true);
        let mut known = vec![false; looks.len()];
        for (i, source) in all.sources.iter().enumerate() {
            let shape = source.shape as usize;
            if !std::mem::replace(&mut known[shape], true) {
                looks[shape].measure(scene, &all, i as u32);
            }
        }
        looks
    }

    fn new(scene: &Scene, shape: &ShapeInfo) -> Look {
        let Looks { colors, mut opacity, clear, .. } = scene.materials.looks(shape.material);
        opacity.extend(shape.alpha);
        let lambda = Wavelengths::rgb();
        let textures = &scene.textures;
        let varies = |tint: &Tint| {
            let varies = |(id, _): &(TextureId, bool)| textures.constant(*id).is_none();
            textures.uniform(tint.color, &lambda).is_none() || tint.amounts.iter().any(varies)
        };
        let layer = |tint: Tint| {
            let image = textures.uniform(tint.color, &lambda).is_none();
            Layer { image: image.then(|| textures.mip_mapped(tint.color)).flatten(), tint }
        };
        let texture = colors
            .iter()
            .any(varies)
            .then(|| Texture { layers: colors.into_iter().map(layer).collect() });
        Look {
            diffuse: [0.0; 3],
            specular: [0.0; 3],
            exponent: 1.0,
            emits: false,
            texture,
            opacity,
            opaque: !clear && !shape.interface,
        }
    }

    /// (1) and (2), at the middle of a triangle.
    fn measure(&mut self, scene: &Scene, meshes: &Meshes, triangle: u32) {
        let surface = meshes.surface(scene, triangle, [1.0 / 3.0; 3], 0.0);
        let mut lambda = Wavelengths::rgb();
        let rgb = |s: Spectrum| Sensor::default().rgb(s, &Wavelengths::rgb());
        let n = surface.ns;
        if let Some(bsdf) = scene.bsdf(&surface, n, &mut lambda) {
            let diffuse = bsdf.eval(n, n, Mode::Radiance, Lobes::DIFFUSE);
            self.diffuse = rgb(diffuse * std::f32::consts::PI);
            let albedo = rgb(bsdf.albedo(n));
            self.specular = std::array::from_fn(|k| (albedo[k] - self.diffuse[k]).max(0.0));
            // What is left of a matte surface by rounding is no highlight.
            if !bsdf.lobes().has(Lobes::SPECULAR) {
                self.specular = [0.0; 3];
            }
            let alpha = bsdf.roughness().clamp(0.01, 1.0);
            self.exponent = ((2.0 / (alpha * alpha) - 2.0) / 4.0).clamp(1.0, SHARPEST);
        }
        let exponent = scene.materials.looks(scene.material_of(&surface)).exponent;
        if let Some(exponent) = exponent.and_then(|id| scene.textures.constant(id)) {
            self.exponent = exponent.clamp(0.0, SHARPEST);
        }
        self.emits = surface.light.is_some();
        if let Some(texture) = &self.texture {
            let here = texture.color(scene, &TexturePoint::of(&scene.geometry, &surface));
            let ratio = |k: usize| if here[k] > 1e-3 { self.diffuse[k] / here[k] } else { 1.0 };
            self.diffuse = std::array::from_fn(|k| ratio(k).min(1.0));
        }
    }

    /// True if parts of the surface are cut out.
    pub fn has_holes(&self) -> bool {
        !self.opacity.is_empty()
    }

    /// True where less than half of the surface is there.
    pub fn open(&self, scene: &Scene, at: &TexturePoint) -> bool {
        self.opacity.iter().map(|&id| scene.textures.float(id, at)).product::<f32>() < 0.5
    }
}

impl Texture {
    /// Linear RGB.
    #[inline]
    pub fn color(&self, scene: &Scene, at: &TexturePoint) -> [f32; 3] {
        self.layers.iter().fold([0.0; 3], |sum, layer| {
            let part = layer.part(scene, at);
            let color = layer.color(scene, at);
            std::array::from_fn(|k| sum[k] + part * color[k])
        })
    }
}

impl Layer {
    #[inline]
    fn color(&self, scene: &Scene, at: &TexturePoint) -> [f32; 3] {
        match &self.image {
            Some(image) => image.rgb(at),
            None => {
                let lambda = Wavelengths::rgb();
                let color = scene.textures.spectrum(self.tint.color, at, &lambda);
                Sensor::default().rgb(color, &lambda)
            }
        }
    }

    #[inline]
    fn part(&self, scene: &Scene, at: &TexturePoint) -> f32 {
        self.tint.amounts.iter().fold(self.tint.weight, |part, (id, rest)| {
            let amount = scene.textures.float(*id, at).clamp(0.0, 1.0);
            part * if *rest { 1.0 - amount } else { amount }
        })
    }
}

/// A place on a triangle, as textures want it.
pub fn texture_point(meshes: &Meshes, id: u32, b: [f32; 3], uv_width: f32) -> TexturePoint {
    let [i, j, k] = meshes.indices[id as usize].map(|i| i as usize);
    let uv: Vec2 = meshes.uvs[i] * b[0] + meshes.uvs[j] * b[1] + meshes.uvs[k] * b[2];
    let p = meshes.positions[i] * b[0] + meshes.positions[j] * b[1] + meshes.positions[k] * b[2];
    TexturePoint {
        p,
        n: meshes.facets[id as usize],
        uv,
        uv_width,
        triangle: meshes.sources[id as usize].triangle,
        barycentrics: Vec2::new(b[1], b[2]),
    }
}
