//! Parameters of the z-buffer.

use crate::registry::Parameter;
use serde::{Deserialize, Deserializer};

/// How light is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// Diffuse and ambient light, one value a facet (Bouknight 1970).
    Bouknight,
    /// As `phong`, at the corners alone, and interpolated (Gouraud 1971).
    Gouraud,
    /// Interpolated normals and a cosine lobe about the mirror direction (Phong 1975).
    #[default]
    Phong,
    /// Interpolated normals and microfacets (Blinn 1977).
    Blinn,
}

/// Everything that can be set with `-p KEY=VALUE`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ZBufferParams {
    /// How light is computed.
    pub model: Model,
    /// True: lamps cast shadows.
    pub shadows: bool,
    /// Width of a shadow map, in texels.
    #[serde(deserialize_with = "texels")]
    pub shadow_map: u32,
    /// Lamps at most; the strongest are kept.
    pub lamps: u32,
    /// Radiance of the ambient light; below 0: what arrives of what surrounds the scene, half of it
    /// from the eye if there are no lamps.
    pub ambient: f32,
    /// Radiance of a white matte surface that faces a lamp at the eye; below 0: as the ambient light, but
    /// none if there are lamps, and 1 in the dark.
    pub headlight: f32,
    /// True: glass is drawn too, as if it were opaque.
    pub clear: bool,
}

impl Default for ZBufferParams {
    fn default() -> Self {
        ZBufferParams {
            model: Model::Phong,
            shadows: true,
            shadow_map: 1024,
            lamps: 8,
            ambient: -1.0,
            headlight: -1.0,
            clear: false,
        }
    }
}

/// Most texels along a side of a shadow map.
const MOST_TEXELS: u32 = 8192;

fn texels<'de, D: Deserializer<'de>>(d: D) -> Result<u32, D::Error> {
    let n = crate::registry::count(d)?;
    match n <= MOST_TEXELS {
        true => Ok(n),
        false => Err(serde::de::Error::custom(format!("{n} is more than {MOST_TEXELS} texels"))),
    }
}

/// The parameters with their defaults and meanings.
pub fn parameters() -> Vec<Parameter> {
    let d = ZBufferParams::default();
    let p = |key, default: String, help| Parameter { key, default, help };
    vec![
        p(
            "model",
            "phong".into(),
            "bouknight (a value a facet), gouraud (a value a corner), phong, blinn",
        ),
        p("shadows", d.shadows.to_string(), "lamps cast shadows"),
        p("shadow_map", d.shadow_map.to_string(), "width of a shadow map, in texels"),
        p("lamps", d.lamps.to_string(), "lamps at most; the strongest are kept"),
        p(
            "ambient",
            d.ambient.to_string(),
            "radiance of the ambient light; below 0: what arrives of what surrounds the scene",
        ),
        p(
            "headlight",
            d.headlight.to_string(),
            "radiance of a white matte surface that faces a lamp at the eye; below 0: as the ambient light, but none if there are lamps",
        ),
        p("clear", d.clear.to_string(), "glass is drawn too, as if it were opaque"),
    ]
}
