//! Textures: an image, how it is sampled and where.

use super::Reader;
use super::json::{Fault, Json};
use super::materials::Materials;
use kaustika_math::Affine2;
use kaustika_scene::description::{
    Bitmap, BitmapChannels, BitmapFilter, BitmapTexture, Texels, TextureId, TextureMapping,
    TextureNode, Wrap,
};
use kaustika_spectra::ColorSpace;
use std::sync::Arc;

/// What of an image is used, and with which curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Use {
    /// A colour, sRGB-encoded.
    Color,
    /// Its alpha channel.
    Alpha,
    /// One channel of linear numbers.
    Channel(u32),
    /// Three linear numbers that are no colour.
    Raw,
}

/// The set of texture coordinates that a texture info asks for.
pub(super) fn uv_set(info: &Json) -> Result<usize, Fault> {
    let own = info.size("texCoord", 0)?;
    match info.extension("KHR_texture_transform") {
        Some(t) => t.size("texCoord", own),
        None => Ok(own),
    }
}

/// KHR_texture_transform on coordinates whose v runs up.
fn mapping(info: &Json) -> Result<Affine2, Fault> {
    let Some(t) = info.extension("KHR_texture_transform") else { return Ok(Affine2::IDENTITY) };
    let [x, y] = t.floats("offset", [0.0; 2])?;
    let [su, sv] = t.floats("scale", [1.0; 2])?;
    let (sin, cos) = t.float("rotation", 0.0)?.sin_cos();
    // T R S on glTF's (u, v), v down: the rows of R S.
    let a = [[cos * su, sin * sv], [-sin * su, cos * sv]];
    Ok(Affine2 { m: [[a[0][0], -a[0][1], a[0][1] + x], [-a[1][0], a[1][1], 1.0 - a[1][1] - y]] })
}

fn wrap(sampler: Option<&Json>, key: &str) -> Result<Wrap, Fault> {
    let Some(json) = sampler.and_then(|s| s.get(key)) else { return Ok(Wrap::Repeat) };
    Ok(match json.whole()? {
        10497 => Wrap::Repeat,
        33071 => Wrap::Clamp,
        33648 => Wrap::Mirror,
        other => {
            return Err(json
                .fault(format!("unknown wrapping mode {other}"))
                .hint("known: 10497 repeat, 33071 clamp, 33648 mirrored repeat"));
        }
    })
}

/// Between texels: as the magnification says; over pyramids unless the file wants none.
fn filter(sampler: Option<&Json>) -> Result<BitmapFilter, Fault> {
    const NEAREST: usize = 9728;
    const LINEAR: usize = 9729;
    let Some(sampler) = sampler else { return Ok(BitmapFilter::Trilinear) };
    let magnified = sampler.size("magFilter", LINEAR)?;
    let minified = sampler.size_if("minFilter")?;
    Ok(match (magnified, minified) {
        (NEAREST, _) => BitmapFilter::Nearest,
        (_, Some(NEAREST | LINEAR)) => BitmapFilter::Bilinear,
        _ => BitmapFilter::Trilinear,
    })
}

/// True if some texel's alpha is not 1.
fn has_alpha(bitmap: &Bitmap) -> bool {
    let n = bitmap.channels as usize;
    if n != 2 && n != 4 {
        return false;
    }
    let skip = n - 1;
    match &bitmap.texels {
        Texels::U8(t) => t.iter().skip(skip).step_by(n).any(|v| *v != u8::MAX),
        Texels::U16(t) => t.iter().skip(skip).step_by(n).any(|v| *v != u16::MAX),
        Texels::F32(t) => t.iter().skip(skip).step_by(n).any(|v| *v != 1.0),
    }
}

impl Reader<'_> {
    /// The texture of a texture info, `None` if it can't be had or is 1 everywhere; why is said.
    /// `main` is the set of coordinates that is the mesh's own.
    pub(super) fn texture(
        &mut self,
        info: &Json,
        kind: Use,
        main: usize,
        materials: &mut Materials,
    ) -> Option<TextureId> {
        match self.try_texture(info, kind, main, materials) {
            Ok(id) => id,
            Err(fault) => {
                self.report(fault);
                None
            }
        }
    }

    fn try_texture(
        &mut self,
        info: &Json,
        kind: Use,
        main: usize,
        materials: &mut Materials,
    ) -> Result<Option<TextureId>, Fault> {
        let (_, texture) = info.require("index")?.pick(&materials.textures, "texture")?;
        let sampler = texture.refer("sampler", &materials.samplers, "sampler")?.map(|s| s.1);
        let Some(source) = texture.get("source") else {
            let other = super::images::KNOWN.iter().find(|n| texture.extension(n).is_some());
            let what = match other {
                Some(name) => format!("its only image is one of `{name}`, which is not supported"),
                None => "it names no image".into(),
            };
            return Err(texture.fault(what).hint("the texture is left out").mild());
        };
        let i = source.whole()?;
        let linear = matches!(kind, Use::Channel(_) | Use::Raw);
        let bitmap: Arc<Bitmap> = match materials.images.get(i, linear) {
            Some(bitmap) => bitmap?,
            None => return Err(source.fault(format!("there is no image {i}"))),
        };
        if kind == Use::Alpha && !has_alpha(&bitmap) {
            return Ok(None);
        }
        let node = TextureNode::Bitmap(BitmapTexture {
            bitmap,
            channels: match kind {
                Use::Color | Use::Raw => BitmapChannels::Color,
                Use::Alpha => BitmapChannels::Alpha,
                Use::Channel(c) => BitmapChannels::Channel(c),
            },
            filter: filter(sampler)?,
            wrap: [wrap(sampler, "wrapS")?, wrap(sampler, "wrapT")?],
            mapping: TextureMapping::Uv(mapping(info)?),
            scale: 1.0,
            invert: false,
            raw: kind == Use::Raw,
            space: ColorSpace::Srgb,
        });
        let span = self.span(texture);
        let id = self.out.add_texture(node, span);
        let set = uv_set(info)?;
        if set == main {
            return Ok(Some(id));
        }
        let attribute = format!("uv{set}");
        Ok(Some(self.out.add_texture(TextureNode::WithUv { texture: id, attribute }, span)))
    }

    /// `factor` times a texture.
    pub(super) fn product(&mut self, texture: Option<TextureId>, factor: TextureId) -> TextureId {
        match texture {
            // The first is what the parameter's role holds for, the second a share of it.
            Some(scale) => {
                self.out.add_texture(TextureNode::Scale { texture: factor, scale }, None)
            }
            None => factor,
        }
    }
}
