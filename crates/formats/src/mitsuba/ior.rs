//! Indices of refraction: numbers or names of materials.

use super::convert::Converter;
use super::document::{Object, Value};
use kaustika_spectra::{ior_by_name, ior_names};

impl<'a> Converter<'a> {
    /// A parameter that is a number or a material's name; `default` is a name.
    pub(super) fn ior(&mut self, object: &'a Object, name: &'static str, default: &str) -> f32 {
        // Every default is a known name.
        let default = ior_by_name(default).unwrap_or(1.0);
        let Some(p) = object.get(name) else { return default };
        let ior = match &p.value {
            Value::Float(v) => *v as f32,
            Value::Integer(v) => *v as f32,
            Value::String(text) => match ior_by_name(text.trim()) {
                Some(ior) => ior,
                None => {
                    let names: Vec<&str> = ior_names().collect();
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
