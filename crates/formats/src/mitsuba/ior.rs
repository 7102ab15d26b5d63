//! Indices of refraction by name.

use super::convert::Converter;
use super::document::{Object, Value};

/// Materials and their indices at 589 nm, as Mitsuba lists them (its `ior.h`, largely after
/// Hecht, "Optics", 4th edition).
const TABLE: &[(&str, f32)] = &[
    ("vacuum", 1.0),
    ("helium", 1.000036),
    ("hydrogen", 1.000132),
    ("air", 1.000277),
    ("carbon dioxide", 1.00045),
    ("water", 1.3330),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.52045),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.470),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.5750),
    ("diamond", 2.419),
];

/// The index of a material by name.
pub(super) fn by_name(name: &str) -> Option<f32> {
    let name = name.trim().to_ascii_lowercase();
    TABLE.iter().find(|(n, _)| *n == name).map(|(_, ior)| *ior)
}

impl<'a> Converter<'a> {
    /// A parameter that is a number or a material's name; `default` is a name.
    pub(super) fn ior(&mut self, object: &'a Object, name: &'static str, default: &str) -> f32 {
        // Every default is in the table.
        let default = by_name(default).unwrap_or(1.0);
        let Some(p) = object.get(name) else { return default };
        let ior = match &p.value {
            Value::Float(v) => *v as f32,
            Value::Integer(v) => *v as f32,
            Value::String(text) => match by_name(text) {
                Some(ior) => ior,
                None => {
                    let names: Vec<&str> = TABLE.iter().map(|(n, _)| *n).collect();
                    self.out
                        .diagnostics
                        .error(p.value_span, format!("no index of refraction for `{text}`"))
                        .nearest(text, &names);
                    default
                }
            },
            _ => {
                self.wrong_type(object, p, "a number or the name of a material");
                default
            }
        };
        if ior > 0.0 {
            return ior;
        }
        self.out.diagnostics.error(p.value_span, format!("`{name}` must be positive"));
        default
    }

    /// `int_ior` over `ext_ior`.
    pub(super) fn relative_ior(&mut self, object: &'a Object, interior: &str) -> f32 {
        let inside = self.ior(object, "int_ior", interior);
        let outside = self.ior(object, "ext_ior", "air");
        inside / outside
    }
}
