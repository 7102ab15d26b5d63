//! Textures: numbers and colours that vary over surfaces.
//!
//! A scene's texture nodes lie in one array, children before parents; [`Textures::float`] and
//! [`Textures::spectrum`] evaluate a node at a point. What an RGB value means (albedo,
//! illuminant, ...) is the [`SpectrumRole`] that the parameter was compiled with.

mod bitmap;
mod build;
mod image_map;
mod mapping;
mod noise;
mod point;
mod procedural;

pub use bitmap::BitmapSampler;
pub use image_map::ImageMap;

pub(crate) use noise::perlin;

use crate::description::{NoiseKind, TextureId, TextureMapping};
use crate::medium::grid::Grid;
use kaustika_math::{Transform, Vec2, Vec3};
use kaustika_spectra::{
    CompiledSpectrum, Spectrum, SpectrumRole, Wavelengths, eval_rgb_albedo, eval_rgb_illuminant,
    eval_rgb_unbounded,
};

/// What a texture may depend on.
#[derive(Clone, Copy, Debug)]
pub struct TexturePoint {
    /// World-space position.
    pub p: Vec3,
    /// Shading normal.
    pub n: Vec3,
    /// Surface parameters.
    pub uv: Vec2,
    /// Width of the filtered region in uv; 0 for a point sample.
    pub uv_width: f32,
    /// Triangle of a mesh, or `u32::MAX`.
    pub triangle: u32,
    /// Barycentric weights of its corners 1 and 2.
    pub barycentrics: Vec2,
}

/// A node made ready for evaluation.
#[derive(Debug)]
enum Node {
    Float(f32),
    /// The spectrum, and the numbers of the file for uses without a colour.
    Spectrum {
        value: CompiledSpectrum,
        raw: [f32; 3],
        /// Value at the sodium D line, for indices of refraction.
        at_d_line: Option<f32>,
    },
    Bitmap(Box<BitmapSampler>),
    Checkerboard {
        a: TextureId,
        b: TextureId,
        mapping: TextureMapping,
    },
    Checkerboard3d {
        a: TextureId,
        b: TextureId,
        to_texture: Transform,
    },
    Dots {
        inside: TextureId,
        outside: TextureId,
        mapping: TextureMapping,
    },
    LineGrid {
        between: TextureId,
        lines: TextureId,
        half_width: f32,
        mapping: TextureMapping,
    },
    Grid(Grid),
    Scale {
        texture: TextureId,
        scale: TextureId,
    },
    Mix {
        a: TextureId,
        b: TextureId,
        amount: TextureId,
    },
    DirectionMix {
        a: TextureId,
        b: TextureId,
        dir: Vec3,
    },
    Bilerp {
        corners: [TextureId; 4],
        mapping: TextureMapping,
    },
    Noise {
        kind: NoiseKind,
        octaves: u32,
        roughness: f32,
        scale: f32,
        variation: f32,
        to_texture: Transform,
    },
    Attribute(Box<AttributeTable>),
    Step {
        texture: TextureId,
        threshold: f32,
    },
    WithUv {
        texture: TextureId,
        uv: Box<AttributeTable>,
    },
}

/// Values of a named mesh attribute for the meshes that have it.
#[derive(Debug, Default)]
pub struct AttributeTable {
    /// The meshes that have it.
    pub ranges: Vec<AttributeRange>,
    /// Multiplies the value.
    pub scale: f32,
}

/// An attribute of one mesh.
#[derive(Clone, Debug)]
pub struct AttributeRange {
    /// The mesh's triangles in the scene's list.
    pub triangles: std::ops::Range<u32>,
    /// Values at the three corners of each triangle.
    pub corners: Vec<[[f32; 3]; 3]>,
}

/// All texture nodes of a scene.
#[derive(Debug, Default)]
pub struct Textures {
    nodes: Vec<Node>,
    /// The role each node's colours have.
    roles: Vec<SpectrumRole>,
}

impl Textures {
    /// The value as a number; the mean of a colour.
    pub fn float(&self, id: TextureId, at: &TexturePoint) -> f32 {
        match &self.nodes[id.0 as usize] {
            Node::Float(v) => *v,
            Node::Spectrum { raw, .. } => mean(*raw),
            Node::Bitmap(b) => b.float(at),
            Node::Scale { texture, scale } => self.float(*texture, at) * self.float(*scale, at),
            Node::Mix { a, b, amount } => {
                let t = self.float(*amount, at);
                self.blend(t, *a, *b, |id| self.float(id, at), |a, b| a * (1.0 - t) + b * t)
            }
            Node::Bilerp { corners, mapping } => {
                let w = procedural::bilinear_weights(mapping::apply(mapping, at).st);
                (0..4).map(|i| w[i] * self.float(corners[i], at)).sum()
            }
            Node::Noise { .. } => self.noise(id, at).map_or(0.0, mean),
            Node::Grid(grid) => mean(grid.rgb(at.p)),
            Node::Attribute(table) => mean(table.value(at)),
            Node::Step { texture, threshold } => f32::from(self.float(*texture, at) >= *threshold),
            Node::WithUv { texture, uv } => self.float(*texture, &uv.moved(at)),
            _ => self.chosen(id, at).map_or(0.0, |(t, a, b)| {
                self.blend(t, a, b, |id| self.float(id, at), |a, b| a * (1.0 - t) + b * t)
            }),
        }
    }

    /// The value as a spectrum if it is the same at every point.
    #[inline]
    pub fn uniform(&self, id: TextureId, lambda: &Wavelengths) -> Option<Spectrum> {
        match &self.nodes[id.0 as usize] {
            Node::Float(v) => Some(Spectrum::splat(*v)),
            Node::Spectrum { value, .. } => Some(value.eval(lambda)),
            _ => None,
        }
    }

    /// The value as a spectrum at the path's wavelengths; a number is the same in every lane.
    pub fn spectrum(&self, id: TextureId, at: &TexturePoint, lambda: &Wavelengths) -> Spectrum {
        let role = self.roles[id.0 as usize];
        match &self.nodes[id.0 as usize] {
            Node::Float(v) => Spectrum::splat(*v),
            Node::Spectrum { value, .. } => value.eval(lambda),
            Node::Bitmap(b) => b.spectrum(at, role, lambda),
            Node::Scale { texture, scale } => {
                self.spectrum(*texture, at, lambda) * self.spectrum(*scale, at, lambda)
            }
            Node::Mix { a, b, amount } => {
                let t = self.float(*amount, at);
                let get = |id| self.spectrum(id, at, lambda);
                self.blend(t, *a, *b, get, |a, b| a.lerp(b, t))
            }
            Node::Bilerp { corners, mapping } => {
                let w = procedural::bilinear_weights(mapping::apply(mapping, at).st);
                (0..4).fold(Spectrum::ZERO, |s, i| s + self.spectrum(corners[i], at, lambda) * w[i])
            }
            Node::Noise { .. } => {
                self.noise(id, at).map_or(Spectrum::ZERO, |c| uplift(role, c, lambda))
            }
            Node::Grid(grid) => grid.spectrum(at.p, role, lambda),
            Node::Attribute(table) => uplift(role, table.value(at), lambda),
            Node::Step { .. } => Spectrum::splat(self.float(id, at)),
            Node::WithUv { texture, uv } => self.spectrum(*texture, &uv.moved(at), lambda),
            _ => self.chosen(id, at).map_or(Spectrum::ZERO, |(t, a, b)| {
                let get = |id| self.spectrum(id, at, lambda);
                self.blend(t, a, b, get, |a, b| a.lerp(b, t))
            }),
        }
    }

    /// The image of a node that is one, with mip maps; for renderers of one sample a pixel.
    pub fn mip_mapped(&self, id: TextureId) -> Option<BitmapSampler> {
        match &self.nodes[id.0 as usize] {
            Node::Bitmap(bitmap) => Some(bitmap.mip_mapped()),
            _ => None,
        }
    }

    /// Three raw numbers, for normal maps.
    pub fn raw_rgb(&self, id: TextureId, at: &TexturePoint) -> [f32; 3] {
        match &self.nodes[id.0 as usize] {
            Node::Bitmap(b) => b.rgb(at),
            Node::Spectrum { raw, .. } => *raw,
            Node::Grid(grid) => grid.rgb(at.p),
            Node::WithUv { texture, uv } => self.raw_rgb(*texture, &uv.moved(at)),
            _ => [self.float(id, at); 3],
        }
    }

    /// (∂/∂u, ∂/∂v) of the value as a number, for bump maps, on a surface with these ∂p/∂u and
    /// ∂p/∂v.
    pub fn gradient(&self, id: TextureId, at: &TexturePoint, (dpdu, dpdv): (Vec3, Vec3)) -> Vec2 {
        match &self.nodes[id.0 as usize] {
            Node::Float(_) | Node::Spectrum { .. } => Vec2::ZERO,
            Node::Bitmap(b) => b.gradient(at),
            _ => {
                // Forward differences over about the filter width.
                let h = (0.5 * at.uv_width).max(5e-4);
                let here = self.float(id, at);
                let shifted = |du: f32, dv: f32| {
                    let (uv, p) = (at.uv + Vec2::new(du, dv), at.p + dpdu * du + dpdv * dv);
                    (self.float(id, &TexturePoint { uv, p, ..*at }) - here) / h
                };
                Vec2::new(shifted(h, 0.0), shifted(0.0, h))
            }
        }
    }

    /// The index of refraction that a constant spectrum has at the sodium D line, 589.3 nm, which
    /// stands for all wavelengths in RGB mode.
    pub fn ior(&self, id: TextureId) -> Option<f32> {
        match &self.nodes[id.0 as usize] {
            Node::Spectrum { at_d_line, .. } => *at_d_line,
            _ => None,
        }
    }

    /// The number if it is the same everywhere.
    pub fn constant(&self, id: TextureId) -> Option<f32> {
        match &self.nodes[id.0 as usize] {
            Node::Float(v) => Some(*v),
            Node::Spectrum { raw, .. } => Some(mean(*raw)),
            _ => None,
        }
    }

    /// For nodes that choose between two children: (weight of the second, first, second).
    fn chosen(&self, id: TextureId, at: &TexturePoint) -> Option<(f32, TextureId, TextureId)> {
        match &self.nodes[id.0 as usize] {
            Node::Checkerboard { a, b, mapping } => {
                Some((procedural::checkerboard(&mapping::apply(mapping, at)), *a, *b))
            }
            Node::Checkerboard3d { a, b, to_texture } => {
                Some((procedural::checkerboard_3d(to_texture.point(at.p)), *a, *b))
            }
            Node::Dots { inside, outside, mapping } => {
                Some((procedural::outside_dots(mapping::apply(mapping, at).st), *inside, *outside))
            }
            Node::LineGrid { between, lines, half_width, mapping } => {
                let share = procedural::lines(&mapping::apply(mapping, at), *half_width);
                Some((share, *between, *lines))
            }
            Node::DirectionMix { a, b, dir } => Some((1.0 - at.n.abs_dot(*dir), *a, *b)),
            _ => None,
        }
    }

    /// Evaluates only the children whose weight is not zero.
    fn blend<T>(
        &self,
        t: f32,
        a: TextureId,
        b: TextureId,
        get: impl Fn(TextureId) -> T,
        mix: impl Fn(T, T) -> T,
    ) -> T {
        if t <= 0.0 {
            get(a)
        } else if t >= 1.0 {
            get(b)
        } else {
            mix(get(a), get(b))
        }
    }

    fn noise(&self, id: TextureId, at: &TexturePoint) -> Option<[f32; 3]> {
        let Node::Noise { kind, octaves, roughness, scale, variation, to_texture } =
            &self.nodes[id.0 as usize]
        else {
            return None;
        };
        let p = to_texture.point(at.p);
        Some(noise::evaluate(*kind, p, *octaves, *roughness, *scale, *variation))
    }
}

impl AttributeTable {
    fn value(&self, at: &TexturePoint) -> [f32; 3] {
        // Ranges ascend, as meshes were added.
        let range = self.ranges.partition_point(|r| r.triangles.end <= at.triangle);
        let Some(range) = self.ranges.get(range).filter(|r| r.triangles.contains(&at.triangle))
        else {
            return [0.0; 3];
        };
        let c = &range.corners[(at.triangle - range.triangles.start) as usize];
        let (b1, b2) = (at.barycentrics.x, at.barycentrics.y);
        std::array::from_fn(|i| {
            self.scale * ((1.0 - b1 - b2) * c[0][i] + b1 * c[1][i] + b2 * c[2][i])
        })
    }
}

impl AttributeTable {
    /// The point with the attribute's first two numbers as its uv, unfiltered.
    fn moved(&self, at: &TexturePoint) -> TexturePoint {
        let [u, v, _] = self.value(at);
        TexturePoint { uv: Vec2::new(u, v), uv_width: 0.0, ..*at }
    }
}

fn mean(c: [f32; 3]) -> f32 {
    (c[0] + c[1] + c[2]) / 3.0
}

/// A linear sRGB colour as a spectrum of the given role.
#[inline]
pub fn uplift(role: SpectrumRole, rgb: [f32; 3], lambda: &Wavelengths) -> Spectrum {
    match role {
        SpectrumRole::Albedo => eval_rgb_albedo(rgb, lambda),
        SpectrumRole::Unbounded => eval_rgb_unbounded(rgb, lambda),
        SpectrumRole::Illuminant => eval_rgb_illuminant(rgb, lambda),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{SceneDescription, TextureNode};
    use kaustika_spectra::ColorMode;

    /// A relief that is given in space rises along the surface as the surface lies in space.
    #[test]
    fn gradients_of_what_varies_in_space() {
        let mut d = SceneDescription::default();
        let grid = crate::description::GridDesc {
            resolution: [2, 1, 1],
            channels: 1,
            values: vec![0.0, 1.0],
            to_world: Transform::IDENTITY,
            layout: crate::description::GridLayout::Corners,
            filter: Default::default(),
        };
        // The value is x.
        let id = d.add_texture(TextureNode::Grid(std::sync::Arc::new(grid)), None);
        let role = |_| SpectrumRole::Albedo;
        let textures = Textures::new(&d, ColorMode::Rgb, role, |_| AttributeTable::default());
        let at = TexturePoint {
            p: Vec3::new(0.4, 0.0, 0.0),
            n: Vec3::Z,
            uv: Vec2::new(0.5, 0.5),
            uv_width: 0.0,
            triangle: u32::MAX,
            barycentrics: Vec2::ZERO,
        };
        let tangents = (Vec3::new(3.0, 4.0, 0.0), Vec3::new(-0.5, 1.0, 0.0));
        let g = textures.gradient(id, &at, tangents);
        assert!((g - Vec2::new(3.0, -0.5)).length() < 1e-2, "{g:?}");
    }
}
