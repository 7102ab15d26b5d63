//! Which properties of a PLY element become mesh attributes, and under which names.
//!
//! The rules are Mitsuba 3's (its PLY plugin's documentation and `find_other_fields`). For
//! vertices, and alike with `face_` for faces:
//!
//! * `r g b` or `red green blue` (also `diffuse_red ...`, as Mitsuba 0.6 knows it) become
//!   `vertex_color`;
//! * neighbours with a common prefix and endings `_x _y _z`, `_r _g _b`, `_0 _1 _2` or
//!   `_1 _2 _3` become `vertex_PREFIX`, of one or three channels; with `_r _g _b` (or `_r`
//!   alone) the name is `vertex_PREFIX_color`;
//! * anything else is skipped with a note.
//!
//! Colours stored as integers are divided by the type's largest value and decoded from sRGB.
//!
//! Three departures: an alpha beside a colour becomes an attribute of its own, `vertex_alpha`,
//! where Mitsuba makes a colour of four channels; other integers are taken as they are, where
//! Mitsuba treats them like colours; and pbrt's `face_indices` becomes an attribute of that name.

use super::header::{Element, Kind, Scalar};
use super::values::Column;
use crate::mesh::error::MeshNote;
use kaustika_scene::description::MeshAttribute;

/// How stored numbers become an attribute's values.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Decoding {
    AsStored,
    /// Times this.
    Scaled(f32),
    /// Times this, then from sRGB to linear.
    Srgb(f32),
}

/// An attribute being read.
pub(super) struct Reading {
    attribute: MeshAttribute,
    /// The column of each channel.
    columns: Vec<usize>,
    decoding: Decoding,
}

impl Reading {
    /// Adds the values of record `i` of a block.
    #[inline]
    pub(super) fn push(&mut self, columns: &[Column], i: usize) {
        for &column in &self.columns {
            let value = columns[column][i];
            self.attribute.values.push(match self.decoding {
                Decoding::AsStored => value,
                Decoding::Scaled(scale) => value * scale,
                Decoding::Srgb(scale) => srgb_to_linear(value * scale),
            });
        }
    }

    /// Adds the values once more that were added last.
    pub(super) fn repeat(&mut self) {
        let values = &mut self.attribute.values;
        values.extend_from_within(values.len() - self.columns.len()..);
    }

    pub(super) fn finish(self) -> MeshAttribute {
        self.attribute
    }
}

/// The sRGB transfer function's inverse, IEC 61966-2-1; odd-symmetric and without upper bound.
fn srgb_to_linear(value: f32) -> f32 {
    let v = value.abs();
    let linear = if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
    linear.copysign(value)
}

/// Assigns columns to properties: which column, if any, each property is read into.
pub(super) struct Slots {
    pub(super) of_property: Vec<Option<usize>>,
    pub(super) columns: usize,
}

impl Slots {
    pub(super) fn new(element: &Element) -> Slots {
        Slots { of_property: vec![None; element.properties.len()], columns: 0 }
    }

    /// Columns for the properties of these names, if `element` has all of them as numbers.
    pub(super) fn claim(&mut self, element: &Element, names: &[&str]) -> Option<Vec<usize>> {
        let found: Option<Vec<usize>> = names
            .iter()
            .map(|name| {
                element
                    .properties
                    .iter()
                    .position(|p| p.name == *name && matches!(p.kind, Kind::Number(_)))
            })
            .collect();
        found.map(|found| found.into_iter().map(|p| self.slot(p)).collect())
    }

    fn slot(&mut self, property: usize) -> usize {
        *self.of_property[property].get_or_insert_with(|| {
            self.columns += 1;
            self.columns - 1
        })
    }
}

const ENDINGS: [[&str; 3]; 4] =
    [["x", "y", "z"], ["r", "g", "b"], ["0", "1", "2"], ["1", "2", "3"]];
/// Index of the colours in `ENDINGS`.
const COLORS: usize = 1;
/// What would be a fourth channel of each of `ENDINGS`.
const FOURTH: [&str; 4] = ["w", "a", "3", "4"];

/// The attributes among the properties of `element` that nothing else has claimed.
/// `prefix` is `vertex` or `face`; `ignored` names properties that are known but unused.
pub(super) fn find(
    element: &Element,
    prefix: &str,
    slots: &mut Slots,
    ignored: &[&str],
    srgb_float_colors: bool,
    notes: &mut Vec<MeshNote>,
) -> Vec<Reading> {
    let mut found = Vec::new();
    let mut seen = vec![false; element.properties.len()];
    let kind_of = |property: usize| match element.properties[property].kind {
        Kind::Number(of) => Some(of),
        Kind::List { .. } => None,
    };
    let position = |name: &str| {
        element.properties.iter().position(|p| p.name == name && matches!(p.kind, Kind::Number(_)))
    };
    let reading = |slots: &mut Slots, name: String, properties: &[usize], decoding| Reading {
        attribute: MeshAttribute {
            name,
            channels: properties.len() as u32,
            per_face: prefix == "face",
            values: Vec::new(),
        },
        columns: properties.iter().map(|&p| slots.slot(p)).collect(),
        decoding,
    };
    let color_decoding = |of: Scalar| match of.integer_max() {
        Some(max) => Decoding::Srgb((1.0 / max) as f32),
        None if srgb_float_colors => Decoding::Srgb(1.0),
        None => Decoding::AsStored,
    };

    const NAMED: [([&str; 3], &str); 3] = [
        (["r", "g", "b"], "a"),
        (["red", "green", "blue"], "alpha"),
        (["diffuse_red", "diffuse_green", "diffuse_blue"], "alpha"),
    ];
    for (names, alpha) in NAMED {
        let [Some(r), Some(g), Some(b)] = names.map(position) else {
            continue;
        };
        let properties = [r, g, b];
        properties.iter().for_each(|&p| seen[p] = true);
        let Some(of) = kind_of(r) else { continue };
        let name = format!("{prefix}_color");
        found.push(reading(slots, name, &properties, color_decoding(of)));
        if let Some((alpha, of)) = position(alpha).and_then(|p| Some((p, kind_of(p)?))) {
            seen[alpha] = true;
            let decoding = match of.integer_max() {
                Some(max) => Decoding::Scaled((1.0 / max) as f32),
                None => Decoding::AsStored,
            };
            found.push(reading(slots, format!("{prefix}_alpha"), &[alpha], decoding));
        }
        break;
    }
    if let Some(p) = position("face_indices").filter(|_| prefix == "face") {
        seen[p] = true;
        let name = "face_indices".to_owned();
        found.push(reading(slots, name, &[p], Decoding::AsStored));
    }

    let mut next = 0;
    while next < element.properties.len() {
        let start = next;
        next += 1;
        let name = element.properties[start].name.as_str();
        if seen[start] || slots.of_property[start].is_some() || ignored.contains(&name) {
            continue;
        }
        let mut skip = |name: &str, why| {
            notes.push(MeshNote::Skipped { name: format!("{} {name}", element.name), why });
        };
        let Some(of) = kind_of(start) else {
            skip(name, "no use for lists of this name");
            continue;
        };
        let Some((stem, ending)) = name.rsplit_once('_') else {
            skip(name, "attributes need an ending such as _x or _r");
            continue;
        };
        let Some(family) = ENDINGS.iter().position(|e| e[0] == ending) else {
            skip(name, "attributes begin with an ending _x, _r, _0 or _1");
            continue;
        };
        let follows = |property: usize, ending: &str| {
            element.properties.get(property).is_some_and(|p| {
                matches!(p.kind, Kind::Number(_)) && p.name.rsplit_once('_') == Some((stem, ending))
            })
        };
        while next - start < 3 && follows(next, ENDINGS[family][next - start]) {
            next += 1;
        }
        if next - start == 3 && follows(next, FOURTH[family]) {
            next += 1;
        }
        let channels = next - start;
        let suffix = if family == COLORS { "_color" } else { "" };
        let attribute = format!("{prefix}_{stem}{suffix}");
        if channels != 1 && channels != 3 {
            skip(stem, "attributes need one or three channels");
        } else if found.iter().any(|r: &Reading| r.attribute.name == attribute) {
            skip(stem, "there is another attribute of this name");
        } else {
            let properties: Vec<usize> = (start..next).collect();
            let decoding = match family {
                COLORS => color_decoding(of),
                _ => Decoding::AsStored,
            };
            found.push(reading(slots, attribute, &properties, decoding));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_decodes_its_fixed_points_and_middle_grey() {
        assert_eq!(srgb_to_linear(0.0), 0.0);
        assert!((srgb_to_linear(1.0) - 1.0).abs() < 1e-6);
        // IEC 61966-2-1: 188/255 is close to one half.
        assert!((srgb_to_linear(188.0 / 255.0) - 0.5029).abs() < 1e-4);
        assert!((srgb_to_linear(0.04045) - 0.04045 / 12.92).abs() < 1e-7);
    }
}
