//! Metadata of pictures as EXR attributes. Names that the EXR standard reserves have fields of
//! their own in the `exr` crate; every other name goes to its map of custom attributes.

use std::path::Path;

use exr::meta::attribute::{AttributeValue, Chromaticities, Text};
use exr::meta::header::{Header, ImageAttributes, LayerAttributes, standard_names};
use exr::prelude::Vec2;

use crate::{ImageError, MetaValue};

/// Attributes that describe the file rather than the picture.
const STRUCTURE: &[&str] = &[
    "tiles",
    "name",
    "type",
    "version",
    "chunkCount",
    "maxSamplesPerPixel",
    "channels",
    "compression",
    "dataWindow",
    "displayWindow",
    "lineOrder",
    "pixelAspectRatio",
    "screenWindowCenter",
    "screenWindowWidth",
    "dwaCompressionLevel",
];

/// All attributes of kinds that [`MetaValue`] has, sorted by name.
pub(super) fn read_metadata(header: &Header) -> Vec<(String, MetaValue)> {
    let pair = |v: Vec2<f32>| [v.0, v.1];
    let mut entries: Vec<(String, MetaValue)> = header
        .all_named_attributes()
        .filter_map(|(name, value)| {
            let name = String::from_utf8_lossy(name).into_owned();
            if STRUCTURE.contains(&name.as_str()) {
                return None;
            }
            let value = match value {
                AttributeValue::Text(t) => {
                    MetaValue::Text(String::from_utf8_lossy(t.as_slice()).into_owned())
                }
                AttributeValue::I32(i) => MetaValue::Int(i),
                AttributeValue::F32(f) => MetaValue::Float(f),
                AttributeValue::F64(f) => MetaValue::Double(f),
                AttributeValue::Matrix4x4(m) => MetaValue::Matrix(m),
                AttributeValue::Chromaticities(c) => {
                    MetaValue::Chromaticities([c.red, c.green, c.blue, c.white].map(pair))
                }
                _ => return None,
            };
            Some((name, value))
        })
        .collect();
    entries.sort_by(|(a, _), (b, _)| a.cmp(b));
    entries
}

/// Files each entry under its field, or under its own name.
pub(super) fn store_metadata(
    path: &Path,
    metadata: &[(String, MetaValue)],
    of_image: &mut ImageAttributes,
    of_layer: &mut LayerAttributes,
) -> Result<(), ImageError> {
    for (name, value) in metadata {
        if !store_standard(name, value, of_image, of_layer) {
            let reserved = standard_names::ALL.contains(&name.as_bytes());
            if reserved || name.is_empty() || name.len() > 255 || name.contains('\0') {
                let shown = name.escape_debug();
                let cause = format!("'{shown}' cannot be a metadata entry with this value");
                return Err(ImageError::cannot_store(path, cause));
            }
            let name = Text::from_slice_unchecked(name.as_bytes());
            of_layer.other.insert(name, attribute(value));
        }
    }
    Ok(())
}

fn text(s: &str) -> Text {
    Text::from_slice_unchecked(s.as_bytes())
}

fn attribute(value: &MetaValue) -> AttributeValue {
    match value {
        MetaValue::Text(s) => AttributeValue::Text(text(s)),
        MetaValue::Int(i) => AttributeValue::I32(*i),
        MetaValue::Float(f) => AttributeValue::F32(*f),
        MetaValue::Double(f) => AttributeValue::F64(*f),
        MetaValue::Matrix(m) => AttributeValue::Matrix4x4(*m),
        MetaValue::Chromaticities(c) => AttributeValue::Chromaticities(chromaticities(c)),
    }
}

fn chromaticities(c: &[[f32; 2]; 4]) -> Chromaticities {
    let [red, green, blue, white] = c.map(|[x, y]| Vec2(x, y));
    Chromaticities { red, green, blue, white }
}

/// True if the name and kind of value belong to a standard attribute, which is then set.
fn store_standard(
    name: &str,
    value: &MetaValue,
    of_image: &mut ImageAttributes,
    of_layer: &mut LayerAttributes,
) -> bool {
    match value {
        MetaValue::Chromaticities(c) if name == "chromaticities" => {
            of_image.chromaticities = Some(chromaticities(c));
            true
        }
        MetaValue::Matrix(m) => {
            let field = match name {
                "worldToCamera" => &mut of_layer.world_to_camera,
                "worldToNDC" => &mut of_layer.world_to_normalized_device,
                _ => return false,
            };
            *field = Some(*m);
            true
        }
        MetaValue::Text(s) => {
            let field = match name {
                "owner" => &mut of_layer.owner,
                "comments" => &mut of_layer.comments,
                "capDate" => &mut of_layer.capture_date,
                "software" => &mut of_layer.software_name,
                "view" => &mut of_layer.view_name,
                "wrapmodes" => &mut of_layer.wrap_mode_name,
                "renderingTransform" => &mut of_layer.rendering_transform_name,
                "lookModTransform" => &mut of_layer.look_modification_transform_name,
                _ => return false,
            };
            *field = Some(text(s));
            true
        }
        MetaValue::Float(f) => {
            let field = match name {
                "whiteLuminance" => &mut of_layer.white_luminance,
                "xDensity" => &mut of_layer.horizontal_density,
                "utcOffset" => &mut of_layer.utc_offset,
                "longitude" => &mut of_layer.longitude,
                "latitude" => &mut of_layer.latitude,
                "altitude" => &mut of_layer.altitude,
                "focus" => &mut of_layer.focus,
                "expTime" => &mut of_layer.exposure,
                "aperture" => &mut of_layer.aperture,
                "isoSpeed" => &mut of_layer.iso_speed,
                "near" => &mut of_layer.near_clip_plane,
                "far" => &mut of_layer.far_clip_plane,
                "fieldOfViewHorizontal" => &mut of_layer.horizontal_field_of_view,
                "fieldOfViewVertical" => &mut of_layer.vertical_field_of_view,
                _ => return false,
            };
            *field = Some(*f);
            true
        }
        _ => false,
    }
}
