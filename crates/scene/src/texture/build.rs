//! From described texture nodes to evaluable ones.

use super::{AttributeTable, BitmapSampler, Node, Textures};
use crate::description::{SceneDescription, TextureId, TextureNode};
use crate::medium::grid::Grid;
use kaustika_math::Vec3;
use kaustika_spectra::{ColorMode, CompiledSpectrum, SpectrumDesc, SpectrumRole};

impl Textures {
    /// Compiles the nodes of a description. `role` says what the colours of each node mean;
    /// `attribute` fetches the values of a named mesh attribute.
    pub fn new(
        description: &SceneDescription,
        mode: ColorMode,
        role: impl Fn(TextureId) -> SpectrumRole,
        attribute: impl Fn(&str) -> AttributeTable,
    ) -> Textures {
        let mut textures = Textures::default();
        for (i, t) in description.textures.iter().enumerate() {
            let role = role(TextureId(i as u32));
            let node = match &t.node {
                TextureNode::Float(v) => Node::Float(*v),
                TextureNode::Spectrum(desc) => {
                    let value = CompiledSpectrum::new(desc, role, mode);
                    Node::Spectrum {
                        raw: raw(desc, &value),
                        at_d_line: desc.value_at(589.3),
                        value,
                    }
                }
                TextureNode::Bitmap(b) => Node::Bitmap(Box::new(BitmapSampler::new(b.clone()))),
                TextureNode::Checkerboard { a, b, mapping } => {
                    Node::Checkerboard { a: *a, b: *b, mapping: *mapping }
                }
                TextureNode::Checkerboard3d { a, b, to_texture } => {
                    Node::Checkerboard3d { a: *a, b: *b, to_texture: *to_texture }
                }
                TextureNode::Dots { inside, outside, mapping } => {
                    Node::Dots { inside: *inside, outside: *outside, mapping: *mapping }
                }
                TextureNode::LineGrid { between, lines, half_width, mapping } => Node::LineGrid {
                    between: *between,
                    lines: *lines,
                    half_width: *half_width,
                    mapping: *mapping,
                },
                TextureNode::Grid(grid) => Node::Grid(Grid::new(grid)),
                TextureNode::Scale { texture, scale } => {
                    Node::Scale { texture: *texture, scale: *scale }
                }
                TextureNode::Mix { a, b, amount } => Node::Mix { a: *a, b: *b, amount: *amount },
                TextureNode::DirectionMix { a, b, dir } => {
                    Node::DirectionMix { a: *a, b: *b, dir: Vec3::from(*dir) }
                }
                TextureNode::Bilerp { corners, mapping } => {
                    Node::Bilerp { corners: *corners, mapping: *mapping }
                }
                TextureNode::Noise { kind, octaves, roughness, scale, variation, to_texture } => {
                    Node::Noise {
                        kind: *kind,
                        octaves: *octaves,
                        roughness: *roughness,
                        scale: *scale,
                        variation: *variation,
                        to_texture: *to_texture,
                    }
                }
                TextureNode::MeshAttribute { name, scale } => {
                    let table = AttributeTable { scale: *scale, ..attribute(name) };
                    Node::Attribute(Box::new(table))
                }
                TextureNode::Step { texture, threshold } => {
                    Node::Step { texture: *texture, threshold: *threshold }
                }
                TextureNode::WithUv { texture, attribute: name } => {
                    let uv = AttributeTable { scale: 1.0, ..attribute(name) };
                    Node::WithUv { texture: *texture, uv: Box::new(uv) }
                }
            };
            textures.nodes.push(node);
            textures.roles.push(role);
        }
        textures
    }
}

/// The numbers as the file gives them; luminance stands for a spectrum that is not a colour.
fn raw(desc: &SpectrumDesc, value: &CompiledSpectrum) -> [f32; 3] {
    match desc {
        SpectrumDesc::Rgb { rgb, .. } => *rgb,
        _ => [value.luminance(); 3],
    }
}
