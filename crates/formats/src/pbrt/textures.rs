//! `Texture`: kinds and their parameters (pbrt-v4, textures.cpp).

use super::build::{Builder, MAX_DEPTH, Slot};
use super::entity::{Entity, TextureEntity, TextureType};
use kaustika_math::{Affine2, Transform, Vec3};
use kaustika_scene::description::{
    BitmapChannels, BitmapFilter, BitmapTexture, Encoding, NoiseKind, Span, TextureId,
    TextureMapping, TextureNode, Wrap,
};
use kaustika_spectra::ColorSpace;

const FLOAT_KINDS: [&str; 12] = [
    "bilerp",
    "checkerboard",
    "constant",
    "directionmix",
    "dots",
    "fbm",
    "imagemap",
    "mix",
    "ptex",
    "scale",
    "windy",
    "wrinkled",
];
const SPECTRUM_KINDS: [&str; 10] = [
    "bilerp",
    "checkerboard",
    "constant",
    "directionmix",
    "dots",
    "imagemap",
    "marble",
    "mix",
    "ptex",
    "scale",
];

impl Builder {
    /// The texture of this number, named at `from`; `None` if it is faulty, which is reported.
    pub fn texture(&mut self, i: usize, from: Span) -> Option<TextureId> {
        match self.textures[i] {
            Slot::Done(id) => return Some(id),
            Slot::Busy => {
                let name = &self.scene.textures[i].name;
                let message = format!("texture `{}` is made of itself", name.text);
                self.desc.diagnostics.error(from, message);
                return None;
            }
            Slot::Open if self.depth >= MAX_DEPTH => {
                self.too_deep(from);
                return None;
            }
            Slot::Open => self.textures[i] = Slot::Busy,
        }
        self.depth += 1;
        let entity = std::mem::take(&mut self.scene.textures[i].entity);
        let mut t = TextureEntity { entity, ..self.scene.textures[i].clone() };
        let id = self.build_texture(&mut t);
        self.depth -= 1;
        let what = format!("texture `{}`", t.entity.kind.text);
        t.entity.params.report_unused(&mut self.desc.diagnostics, &what);
        let id = id.unwrap_or_else(|| self.desc.float(0.5));
        self.textures[i] = Slot::Done(id);
        Some(id)
    }

    fn build_texture(&mut self, t: &mut TextureEntity) -> Option<TextureId> {
        let TextureEntity { entity: e, ty, transform, .. } = t;
        let (ty, span) = (*ty, e.span);
        let node = match (e.kind.text.as_str(), ty) {
            ("constant", TextureType::Float) => {
                let value = e.params.float(&mut self.desc.diagnostics, "value", 1.0);
                TextureNode::Float(value)
            }
            ("constant", TextureType::Spectrum) => match self.spectrum(e, "value") {
                Some(s) => TextureNode::Spectrum(s),
                None => return Some(self.constant(1.0)),
            },
            ("scale", _) => {
                let texture = self.value(e, ty, "tex", 1.0);
                let scale = self.float_texture(e, "scale", 1.0);
                TextureNode::Scale { texture, scale }
            }
            ("mix", _) => {
                let a = self.value(e, ty, "tex1", 0.0);
                let b = self.value(e, ty, "tex2", 1.0);
                let amount = self.float_texture(e, "amount", 0.5);
                TextureNode::Mix { a, b, amount }
            }
            ("directionmix", _) => {
                let a = self.value(e, ty, "tex1", 0.0);
                let b = self.value(e, ty, "tex2", 1.0);
                let dir = e.params.vector3(&mut self.desc.diagnostics, "dir", Vec3::Y);
                let Some(dir) = transform.vector(dir).try_normalize() else {
                    self.desc.diagnostics.error(e.params.place("dir"), "the direction is zero");
                    return None;
                };
                TextureNode::DirectionMix { a, b, dir: dir.into() }
            }
            ("bilerp", _) => {
                let corners = [
                    self.corner(e, ty, "v00", 0.0),
                    self.corner(e, ty, "v01", 1.0),
                    self.corner(e, ty, "v10", 0.0),
                    self.corner(e, ty, "v11", 1.0),
                ];
                TextureNode::Bilerp { corners, mapping: self.mapping(e, transform) }
            }
            ("imagemap", _) => self.imagemap(e, ty, transform)?,
            ("checkerboard", _) => return self.checkerboard(e, ty, transform),
            ("dots", _) => TextureNode::Dots {
                inside: self.value(e, ty, "inside", 1.0),
                outside: self.value(e, ty, "outside", 0.0),
                mapping: self.mapping(e, transform),
            },
            ("fbm", TextureType::Float) => self.noise(e, NoiseKind::Fbm, transform),
            ("wrinkled", TextureType::Float) => self.noise(e, NoiseKind::Wrinkled, transform),
            ("windy", TextureType::Float) => self.noise(e, NoiseKind::Windy, transform),
            ("marble", TextureType::Spectrum) => self.noise(e, NoiseKind::Marble, transform),
            ("ptex", _) => {
                e.params.ignore_rest();
                let message = "texture `ptex` is not supported, its mean is taken as 0.5";
                self.notes.warning(e.kind.span, message);
                return Some(self.desc.float(0.5));
            }
            (kind, _) => {
                let (known, word): (&[&str], _) = match ty {
                    TextureType::Float => (&FLOAT_KINDS, "float"),
                    TextureType::Spectrum => (&SPECTRUM_KINDS, "spectrum"),
                };
                let message = format!("unknown {word} texture `{kind}`");
                self.desc.diagnostics.error(e.kind.span, message).nearest(kind, known);
                e.params.ignore_rest();
                return None;
            }
        };
        Some(self.desc.add_texture(node, Some(span)))
    }

    /// A parameter that is a texture or constant of the texture's own type.
    fn value(
        &mut self,
        e: &mut Entity,
        ty: TextureType,
        name: &'static str,
        default: f32,
    ) -> TextureId {
        match ty {
            TextureType::Float => self.float_texture(e, name, default),
            TextureType::Spectrum => match self.spectrum_texture_or_none(e, name) {
                Some(id) => id,
                None => self.constant(default),
            },
        }
    }

    /// A constant of the texture's own type.
    fn corner(
        &mut self,
        e: &mut Entity,
        ty: TextureType,
        name: &'static str,
        default: f32,
    ) -> TextureId {
        match ty {
            TextureType::Float => {
                let value = e.params.float(&mut self.desc.diagnostics, name, default);
                self.desc.float(value)
            }
            TextureType::Spectrum => match self.spectrum(e, name) {
                Some(s) => self.desc.add_texture(TextureNode::Spectrum(s), None),
                None => self.constant(default),
            },
        }
    }

    fn mapping(&mut self, e: &mut Entity, transform: &Transform) -> TextureMapping {
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        let kind = p.string(diag, "mapping");
        match kind.as_ref().map_or("uv", |k| k.text.as_str()) {
            "uv" => TextureMapping::Uv(Affine2::scale_shift(
                p.float(diag, "uscale", 1.0),
                p.float(diag, "vscale", 1.0),
                p.float(diag, "udelta", 0.0),
                p.float(diag, "vdelta", 0.0),
            )),
            "spherical" => TextureMapping::Spherical(transform.inverse()),
            "cylindrical" => TextureMapping::Cylindrical(transform.inverse()),
            "planar" => TextureMapping::Planar {
                to_texture: transform.inverse(),
                vs: p.vector3(diag, "v1", Vec3::X).into(),
                vt: p.vector3(diag, "v2", Vec3::Y).into(),
                ds: p.float(diag, "udelta", 0.0),
                dt: p.float(diag, "vdelta", 0.0),
            },
            other => {
                let known = ["uv", "spherical", "cylindrical", "planar"];
                let span = kind.as_ref().map_or(e.span, |k| k.span);
                diag.error(span, format!("unknown mapping `{other}`")).nearest(other, &known);
                TextureMapping::default()
            }
        }
    }

    /// pbrt turns v around before it looks up the image, whose first row is the top one: v = 0 is
    /// the bottom row, as in [`BitmapTexture`].
    fn imagemap(
        &mut self,
        e: &mut Entity,
        ty: TextureType,
        transform: &Transform,
    ) -> Option<TextureNode> {
        let mapping = self.mapping(e, transform);
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        // Anisotropy is the filter's own business here.
        p.float(diag, "maxanisotropy", 8.0);
        let filter = p.string(diag, "filter");
        let filter = match filter.as_ref().map_or("bilinear", |f| f.text.as_str()) {
            "bilinear" => BitmapFilter::Bilinear,
            "trilinear" => BitmapFilter::Trilinear,
            "ewa" | "EWA" => BitmapFilter::Ewa,
            "point" => BitmapFilter::Nearest,
            other => {
                let known = ["bilinear", "trilinear", "ewa", "point"];
                let message = format!("unknown filter `{other}`, using bilinear");
                let span = filter.as_ref().map_or(e.span, |f| f.span);
                diag.warning(span, message).nearest(other, &known);
                BitmapFilter::Bilinear
            }
        };
        let wrap = p.string(diag, "wrap");
        let wrap = match wrap.as_ref().map_or("repeat", |w| w.text.as_str()) {
            "repeat" => Wrap::Repeat,
            "clamp" => Wrap::Clamp,
            "black" => Wrap::Black,
            other => {
                let message = format!("unknown wrap mode `{other}`");
                let span = wrap.as_ref().map_or(e.span, |w| w.span);
                diag.error(span, message).nearest(other, &["repeat", "clamp", "black"]);
                Wrap::Repeat
            }
        };
        let scale = p.float(diag, "scale", 1.0);
        let invert = p.boolean(diag, "invert", false);
        let encoding = self.encoding(e);
        let Some(name) = e.params.string(&mut self.desc.diagnostics, "filename") else {
            if !e.params.has("filename") {
                let message = "texture `imagemap` needs \"string filename\"";
                self.desc.diagnostics.error(e.kind.span, message);
            }
            return None;
        };
        let bitmap = match encoding {
            Some(encoding) => self.image_with(&name, encoding)?,
            None => self.image(&name)?,
        };
        Some(TextureNode::Bitmap(BitmapTexture {
            bitmap,
            channels: match ty {
                TextureType::Float => BitmapChannels::Channel(0),
                TextureType::Spectrum => BitmapChannels::Color,
            },
            filter,
            wrap: [wrap; 2],
            mapping,
            scale,
            invert,
            raw: false,
            space: ColorSpace::Srgb,
        }))
    }

    fn encoding(&mut self, e: &mut Entity) -> Option<Encoding> {
        let diag = &mut self.desc.diagnostics;
        let name = e.params.string(diag, "encoding")?;
        let mut words = name.text.split_whitespace();
        match (words.next(), words.next().and_then(|w| w.parse::<f32>().ok())) {
            (Some("linear"), _) => Some(Encoding::Linear),
            (Some("sRGB"), _) => Some(Encoding::Srgb),
            (Some("gamma"), Some(g)) if g > 0.0 && g.is_finite() => Some(Encoding::Gamma(g)),
            _ => {
                diag.error(name.span, format!("unknown encoding `{}`", name.text))
                    .hint("known: sRGB, linear, gamma <value>");
                None
            }
        }
    }

    fn checkerboard(
        &mut self,
        e: &mut Entity,
        ty: TextureType,
        transform: &Transform,
    ) -> Option<TextureId> {
        let dimension = e.params.int(&mut self.desc.diagnostics, "dimension", 2);
        let a = self.value(e, ty, "tex1", 1.0);
        let b = self.value(e, ty, "tex2", 0.0);
        let node = match dimension {
            3 => TextureNode::Checkerboard3d { a, b, to_texture: transform.inverse() },
            2 => match halved(self.mapping(e, transform)) {
                Some(mapping) => TextureNode::Checkerboard { a, b, mapping },
                None => return Some(a),
            },
            n => {
                let message = format!("a checkerboard has 2 or 3 dimensions, not {n}");
                self.desc.diagnostics.error(e.params.place("dimension"), message);
                return None;
            }
        };
        Some(self.desc.add_texture(node, Some(e.span)))
    }

    fn noise(&mut self, e: &mut Entity, kind: NoiseKind, transform: &Transform) -> TextureNode {
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        let (mut octaves, mut roughness, mut scale, mut variation) = (8, 0.5, 1.0, 0.2);
        if kind != NoiseKind::Windy {
            octaves = p.int(diag, "octaves", octaves);
            roughness = p.float(diag, "roughness", roughness);
        }
        if kind == NoiseKind::Marble {
            scale = p.float(diag, "scale", scale);
            variation = p.float(diag, "variation", variation);
        }
        let octaves = octaves.max(0) as u32;
        let to_texture = transform.inverse();
        TextureNode::Noise { kind, octaves, roughness, scale, variation, to_texture }
    }
}

/// The mapping that makes pbrt's unit squares squares of side 1/2. `None` for the mappings onto
/// [0,1]², which lies in one square.
fn halved(mapping: TextureMapping) -> Option<TextureMapping> {
    match mapping {
        TextureMapping::Uv(a) => {
            Some(TextureMapping::Uv(Affine2 { m: a.m.map(|row| row.map(|v| 0.5 * v)) }))
        }
        TextureMapping::Planar { to_texture, vs, vt, ds, dt } => Some(TextureMapping::Planar {
            to_texture,
            vs: vs.map(|v| 0.5 * v),
            vt: vt.map(|v| 0.5 * v),
            ds: 0.5 * ds,
            dt: 0.5 * dt,
        }),
        TextureMapping::Spherical(_) | TextureMapping::Cylindrical(_) => None,
    }
}
