//! Spectra and colours: what a number, `<rgb>`, `<spectrum>` or spectrum plugin stands for.

use super::convert::{Converter, old};
use super::document::{Object, ObjectId, Parameter, SpectrumValue, Value};
use super::textures::Role;
use super::values;
use kaustika_spectra::{ColorSpace, SpectrumDesc};

/// A linear sRGB colour.
pub(super) fn rgb(rgb: [f32; 3]) -> SpectrumDesc {
    SpectrumDesc::Rgb { rgb, space: ColorSpace::Srgb }
}

/// A spectrum and a factor.
pub(super) type Scaled = (SpectrumDesc, f32);

impl<'a> Converter<'a> {
    /// The spectrum of a light that can't vary over space; `default` is a number, which as light
    /// is that much of D65 white.
    pub(super) fn light_spectrum(
        &mut self,
        object: &'a Object,
        name: &'static str,
        default: f32,
    ) -> Scaled {
        let fallback = (SpectrumDesc::D65 { scale: default }, 1.0);
        let Some(p) = object.get(name) else { return fallback };
        if let Some(scaled) = self.plain_value(object, p, Role::Illuminant) {
            return scaled;
        }
        match self.target(p) {
            Some(id) => match self.spectrum_object(id, Role::Illuminant) {
                Some(scaled) => scaled,
                None => {
                    let message = format!(
                        "`{name}` of {} `{}` can't vary",
                        object.kind.word(),
                        object.plugin
                    );
                    self.out.diagnostics.error(p.span, message);
                    fallback
                }
            },
            None => {
                self.wrong_type(object, p, "a number, colour or spectrum");
                fallback
            }
        }
    }

    /// The spectrum a value without object stands for in this role; `None` for other values.
    ///
    /// As light, a number or colour is tinted D65 white; `<spectrum value="x"/>` is x at every
    /// wavelength in Mitsuba 3, but x times D65 in 0.6.
    pub(super) fn plain_value(
        &mut self,
        object: &Object,
        p: &Parameter,
        role: Role,
    ) -> Option<Scaled> {
        let light = role == Role::Illuminant;
        Some(match &p.value {
            Value::Float(v) if light => (SpectrumDesc::D65 { scale: *v as f32 }, 1.0),
            Value::Integer(v) if light => (SpectrumDesc::D65 { scale: *v as f32 }, 1.0),
            Value::Float(v) => (SpectrumDesc::Constant(*v as f32), 1.0),
            Value::Integer(v) => (SpectrumDesc::Constant(*v as f32), 1.0),
            Value::Rgb(c) => (rgb(self.reflectance(object, p, *c, role)), 1.0),
            Value::Spectrum(SpectrumValue::Uniform(v)) if light && old(object) => {
                (SpectrumDesc::D65 { scale: *v }, 1.0)
            }
            Value::Spectrum(SpectrumValue::Uniform(v)) => (SpectrumDesc::EqualEnergy(*v), 1.0),
            Value::Spectrum(SpectrumValue::Table(desc)) => (desc.clone(), 1.0),
            Value::Blackbody { kelvin, scale } => {
                (SpectrumDesc::Blackbody { kelvin: *kelvin, normalized: false }, *scale)
            }
            _ => return None,
        })
    }

    /// Reflectances are kept in [0,1]: by clamping, where Mitsuba 3 refuses, and by scaling, as
    /// 0.6 does.
    fn reflectance(&mut self, object: &Object, p: &Parameter, c: [f32; 3], role: Role) -> [f32; 3] {
        let outside = c.iter().any(|v| !(0.0..=1.0).contains(v));
        if role != Role::Reflectance || !outside {
            return c;
        }
        let largest = c.iter().copied().fold(1.0, f32::max);
        let (kept, how) = if old(object) {
            (c.map(|v| (v / largest).max(0.0)), "scaled into [0,1]")
        } else {
            (c.map(|v| v.clamp(0.0, 1.0)), "clamped to [0,1]")
        };
        self.out
            .diagnostics
            .warning(p.value_span, format!("the reflectance `{}` is outside [0,1]", p.name))
            .label(how);
        kept
    }

    /// The spectrum of a plugin that does not vary over space; `None` for true textures.
    pub(super) fn spectrum_object(&mut self, id: ObjectId, role: Role) -> Option<Scaled> {
        let object = self.object(id);
        let scaled = match object.plugin.as_str() {
            "uniform" => {
                object.ignore(&["wavelength_min", "wavelength_max"]);
                (SpectrumDesc::Constant(self.number(object, "value", 1.0)), 1.0)
            }
            "rawconstant" => match object.get("value").map(|p| &p.value) {
                Some(Value::Vector(v)) => (rgb(v.map(|c| c as f32)), 1.0),
                Some(Value::Rgb(c)) => (rgb(*c), 1.0),
                _ => (SpectrumDesc::Constant(self.number(object, "value", 1.0)), 1.0),
            },
            "srgb" => {
                object.ignore(&["unbounded"]);
                (rgb(self.color(object, "color").unwrap_or([0.5; 3])), 1.0)
            }
            "d65" => {
                if self.has_texture_child(object) {
                    return None;
                }
                let scale = self.number(object, "scale", 1.0);
                match self.color(object, "color") {
                    Some(color) => (rgb(color), scale),
                    None => (SpectrumDesc::D65 { scale }, 1.0),
                }
            }
            "blackbody" => {
                object.ignore(&["wavelength_min", "wavelength_max"]);
                let kelvin = self.optional_number(object, "temperature");
                if kelvin.is_none() && !object.has("temperature") {
                    self.out.diagnostics.error(object.span, "a black body needs `temperature`");
                }
                let kelvin = kelvin.unwrap_or(6500.0);
                (SpectrumDesc::Blackbody { kelvin, normalized: false }, 1.0)
            }
            "regular" | "irregular" | "spectrum" | "rgb" => (self.tabulated(object, role), 1.0),
            _ => return None,
        };
        self.finish(id);
        Some(scaled)
    }

    fn has_texture_child(&self, object: &Object) -> bool {
        object.parameters.iter().any(|p| self.target(p).is_some())
    }

    fn color(&mut self, object: &'a Object, name: &'static str) -> Option<[f32; 3]> {
        let p = object.get(name)?;
        match p.value {
            Value::Rgb(c) => Some(c),
            Value::Vector(v) => Some(v.map(|c| c as f32)),
            Value::Float(v) => Some([v as f32; 3]),
            _ => {
                self.wrong_type(object, p, "a colour");
                None
            }
        }
    }

    /// The plugins `regular` (values between two wavelengths) and `irregular` (lists of both).
    fn tabulated(&mut self, object: &'a Object, role: Role) -> SpectrumDesc {
        if let Some(p) = object.get("value") {
            if let Some((desc, _)) = self.plain_value(object, p, role) {
                return desc;
            }
            self.wrong_type(object, p, "a spectrum");
        }
        let min = self.number(object, "wavelength_min", 360.0);
        let max = self.number(object, "wavelength_max", 830.0);
        let values = self.number_list(object, "values");
        let lambda = match object.plugin.as_str() {
            "regular" => {
                let steps = values.len().saturating_sub(1).max(1) as f32;
                (0..values.len()).map(|i| min + (max - min) * i as f32 / steps).collect()
            }
            _ => self.number_list(object, "wavelengths"),
        };
        values::table(&lambda, &values).unwrap_or_else(|message| {
            self.out.diagnostics.error(object.span, message);
            SpectrumDesc::Constant(0.0)
        })
    }

    fn number_list(&mut self, object: &'a Object, name: &'static str) -> Vec<f32> {
        let Some((text, span)) = self.string(object, name) else { return Vec::new() };
        let parsed: Result<Vec<f32>, String> =
            values::tokens(text).into_iter().map(|t| values::number(t).map(|v| v as f32)).collect();
        parsed.unwrap_or_else(|message| {
            self.out.diagnostics.error(span, message);
            Vec::new()
        })
    }
}
