//! Parameter lists: `"type name" [ values ]`, with pbrt's rules of look-up.

use super::spectrum;
use kaustika_math::{Vec2, Vec3};
use kaustika_scene::description::{Diagnostics, Span};
use kaustika_spectra::{ColorSpace, SpectrumDesc};
use std::path::Path;

/// Types of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ParamType {
    Bool,
    Float,
    Integer,
    Point2,
    Vector2,
    Point3,
    Vector3,
    Normal,
    String,
    Texture,
    Rgb,
    Spectrum,
    Blackbody,
}

/// Names of the types as pbrt-v4 writes them.
pub(super) const TYPES: [(&str, ParamType); 13] = [
    ("bool", ParamType::Bool),
    ("float", ParamType::Float),
    ("integer", ParamType::Integer),
    ("point2", ParamType::Point2),
    ("vector2", ParamType::Vector2),
    ("point3", ParamType::Point3),
    ("vector3", ParamType::Vector3),
    ("normal", ParamType::Normal),
    ("string", ParamType::String),
    ("texture", ParamType::Texture),
    ("rgb", ParamType::Rgb),
    ("spectrum", ParamType::Spectrum),
    ("blackbody", ParamType::Blackbody),
];

impl ParamType {
    /// Its name in a file.
    pub fn name(self) -> &'static str {
        TYPES.iter().find(|(_, t)| *t == self).map_or("", |(n, _)| n)
    }

    /// Numbers a value is made of.
    fn arity(self) -> usize {
        match self {
            ParamType::Point2 | ParamType::Vector2 => 2,
            ParamType::Point3 | ParamType::Vector3 | ParamType::Normal | ParamType::Rgb => 3,
            _ => 1,
        }
    }
}

/// A string with its place.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Text {
    pub text: String,
    pub span: Span,
}

/// Values of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Values {
    Floats(Vec<f32>),
    Ints(Vec<i32>),
    Bools(Vec<bool>),
    Strings(Vec<Text>),
}

impl Values {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Values::Floats(v) => v.len(),
            Values::Ints(v) => v.len(),
            Values::Bools(v) => v.len(),
            Values::Strings(v) => v.len(),
        }
    }
}

/// One parameter.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Param {
    pub ty: ParamType,
    pub name: String,
    /// The declaration.
    pub span: Span,
    pub values: Values,
    /// Colour space that was current where it was written.
    pub space: ColorSpace,
    /// True if an error in it was reported: it counts as given, but has no value.
    pub bad: bool,
    /// True if a look-up found it.
    pub used: bool,
}

/// The parameters of one directive.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Params {
    /// In the order of the file; of equal names the last counts.
    pub own: Vec<Param>,
    /// From `Attribute`; count only where `own` has nothing, and may stay unused.
    pub inherited: Vec<Param>,
    /// Where the directive stands.
    pub span: Span,
    /// Colour space that was current there.
    pub space: ColorSpace,
    asked: Vec<&'static str>,
}

impl Params {
    /// A parameter list of a directive at `span`.
    pub fn new(own: Vec<Param>, inherited: Vec<Param>, span: Span, space: ColorSpace) -> Self {
        Params { own, inherited, span, space, asked: Vec::new() }
    }

    /// The parameter of this name and one of these types. A parameter of another type is an
    /// error.
    pub fn find(
        &mut self,
        diag: &mut Diagnostics,
        name: &'static str,
        types: &[ParamType],
    ) -> Option<&mut Param> {
        self.asked.push(name);
        let mut found = None;
        for (i, p) in self.own.iter_mut().enumerate().filter(|(_, p)| p.name == name) {
            p.used = true;
            found = Some(i);
        }
        if let Some(i) = found {
            let p = &mut self.own[i];
            if p.bad {
                return None;
            }
            if !types.contains(&p.ty) {
                let expected: Vec<_> = types.iter().map(|t| format!("`{}`", t.name())).collect();
                let message = format!(
                    "parameter `{name}` has type `{}`, expected {}",
                    p.ty.name(),
                    expected.join(" or ")
                );
                let hint = format!("write \"{} {name}\"", types[0].name());
                diag.error(p.span, message).hint(hint);
                p.bad = true;
                return None;
            }
            return Some(p);
        }
        self.inherited.iter_mut().rev().find(|p| p.name == name && types.contains(&p.ty) && !p.bad)
    }

    /// True if the parameter was written, rightly or not.
    pub fn has(&self, name: &str) -> bool {
        self.own.iter().chain(&self.inherited).any(|p| p.name == name)
    }

    /// Where a parameter stands, or the directive if it was not given.
    pub fn place(&self, name: &str) -> Span {
        let mut all = self.own.iter().rev().chain(self.inherited.iter().rev());
        all.find(|p| p.name == name).map_or(self.span, |p| p.span)
    }

    /// One number.
    pub fn float(&mut self, diag: &mut Diagnostics, name: &'static str, default: f32) -> f32 {
        self.float_or_none(diag, name).unwrap_or(default)
    }

    /// One number, if it is given.
    pub fn float_or_none(&mut self, diag: &mut Diagnostics, name: &'static str) -> Option<f32> {
        let p = self.find(diag, name, &[ParamType::Float])?;
        p.single(diag)?.first().copied()
    }

    /// Any number of numbers.
    pub fn floats(&mut self, diag: &mut Diagnostics, name: &'static str) -> Option<Vec<f32>> {
        self.find(diag, name, &[ParamType::Float])?.take_floats(diag)
    }

    /// The components of any number of colours, linear sRGB.
    pub fn colors(&mut self, diag: &mut Diagnostics, name: &'static str) -> Option<Vec<f32>> {
        let p = self.find(diag, name, &[ParamType::Rgb])?;
        let space = p.space;
        let mut values = p.take_floats(diag)?;
        if space != ColorSpace::Srgb {
            for c in values.chunks_exact_mut(3) {
                c.copy_from_slice(&space.to_srgb([c[0], c[1], c[2]]).map(|v| v.max(0.0)));
            }
        }
        Some(values)
    }

    /// One integer.
    pub fn int(&mut self, diag: &mut Diagnostics, name: &'static str, default: i32) -> i32 {
        self.int_or_none(diag, name).unwrap_or(default)
    }

    /// One integer, if it is given.
    pub fn int_or_none(&mut self, diag: &mut Diagnostics, name: &'static str) -> Option<i32> {
        let p = self.find(diag, name, &[ParamType::Integer])?;
        p.check_count(diag, 1)?;
        match &p.values {
            Values::Ints(v) => v.first().copied(),
            _ => None,
        }
    }

    /// Any number of integers.
    pub fn ints(&mut self, diag: &mut Diagnostics, name: &'static str) -> Option<Vec<i32>> {
        match &mut self.find(diag, name, &[ParamType::Integer])?.values {
            Values::Ints(v) => Some(std::mem::take(v)),
            _ => None,
        }
    }

    /// A truth value.
    pub fn boolean(&mut self, diag: &mut Diagnostics, name: &'static str, default: bool) -> bool {
        let Some(p) = self.find(diag, name, &[ParamType::Bool]) else { return default };
        match (p.check_count(diag, 1), &p.values) {
            (Some(()), Values::Bools(v)) => v[0],
            _ => default,
        }
    }

    /// A string.
    pub fn string(&mut self, diag: &mut Diagnostics, name: &'static str) -> Option<Text> {
        let p = self.find(diag, name, &[ParamType::String])?;
        p.check_count(diag, 1)?;
        p.strings().first().cloned()
    }

    /// Strings.
    pub fn strings(&mut self, diag: &mut Diagnostics, name: &'static str) -> Option<Vec<Text>> {
        Some(self.find(diag, name, &[ParamType::String])?.strings().to_vec())
    }

    /// A point of space.
    pub fn point3(&mut self, diag: &mut Diagnostics, name: &'static str, default: Vec3) -> Vec3 {
        self.triple(diag, name, ParamType::Point3).unwrap_or(default)
    }

    /// A vector of space.
    pub fn vector3(&mut self, diag: &mut Diagnostics, name: &'static str, default: Vec3) -> Vec3 {
        self.triple(diag, name, ParamType::Vector3).unwrap_or(default)
    }

    fn triple(
        &mut self,
        diag: &mut Diagnostics,
        name: &'static str,
        ty: ParamType,
    ) -> Option<Vec3> {
        let p = self.find(diag, name, &[ty])?;
        p.single(diag).map(|v| Vec3::new(v[0], v[1], v[2]))
    }

    /// Points or normals, as `ty` says.
    pub fn triples(
        &mut self,
        diag: &mut Diagnostics,
        name: &'static str,
        ty: ParamType,
    ) -> Option<Vec<Vec3>> {
        let v = self.find(diag, name, &[ty])?.take_floats(diag)?;
        Some(v.chunks_exact(3).map(|c| Vec3::new(c[0], c[1], c[2])).collect())
    }

    /// Points of the plane.
    pub fn points2(&mut self, diag: &mut Diagnostics, name: &'static str) -> Option<Vec<Vec2>> {
        let v = self.find(diag, name, &[ParamType::Point2])?.take_floats(diag)?;
        Some(v.chunks_exact(2).map(|c| Vec2::new(c[0], c[1])).collect())
    }

    /// A spectrum; files are looked for with `resolve`.
    pub fn spectrum(
        &mut self,
        diag: &mut Diagnostics,
        name: &'static str,
        resolve: &dyn Fn(&Text) -> Option<std::path::PathBuf>,
    ) -> Option<SpectrumDesc> {
        let types = [ParamType::Rgb, ParamType::Spectrum, ParamType::Blackbody];
        self.find(diag, name, &types)?.spectrum(diag, resolve)
    }

    /// Warns of parameters that no look-up asked for; `what` says whose they are.
    pub fn report_unused(&mut self, diag: &mut Diagnostics, what: &str) {
        self.asked.sort_unstable();
        self.asked.dedup();
        for p in self.own.iter_mut().filter(|p| !p.used) {
            p.used = true;
            let message = format!("unknown parameter `{}` of {what} is ignored", p.name);
            let warning = diag.warning(p.span, message);
            if !self.asked.is_empty() {
                warning.nearest(&p.name, &self.asked);
            }
        }
    }

    /// Accepts everything: for things that are replaced as a whole.
    pub fn ignore_rest(&mut self) {
        self.own.iter_mut().for_each(|p| p.used = true);
    }
}

impl Param {
    /// Reports a count other than one value; the parameter then has no value.
    fn check_count(&mut self, diag: &mut Diagnostics, expected: usize) -> Option<()> {
        let found = self.values.len();
        if found == expected {
            return Some(());
        }
        let of = match self.values {
            Values::Strings(_) => "string",
            _ => "value",
        };
        let s = if expected == 1 { "" } else { "s" };
        let message = format!("parameter `{}` needs {expected} {of}{s}, {found} given", self.name);
        diag.error(self.span, message);
        self.bad = true;
        None
    }

    /// The numbers of exactly one value.
    fn single(&mut self, diag: &mut Diagnostics) -> Option<&[f32]> {
        self.check_count(diag, self.ty.arity())?;
        match &self.values {
            Values::Floats(v) => Some(v),
            _ => None,
        }
    }

    /// The numbers of any number of values, at least one.
    fn take_floats(&mut self, diag: &mut Diagnostics) -> Option<Vec<f32>> {
        let Values::Floats(v) = &mut self.values else { return None };
        let arity = self.ty.arity();
        if !v.len().is_multiple_of(arity) {
            let message = format!(
                "parameter `{}` needs {arity} numbers a value, {} given in all",
                self.name,
                v.len()
            );
            diag.error(self.span, message);
            self.bad = true;
            return None;
        }
        Some(std::mem::take(v))
    }

    /// The strings, if it has any.
    pub fn strings(&self) -> &[Text] {
        match &self.values {
            Values::Strings(v) => v,
            _ => &[],
        }
    }

    /// The number, if it is a single `float`.
    pub fn number(&mut self, diag: &mut Diagnostics) -> Option<f32> {
        self.single(diag).map(|v| v[0])
    }

    /// The spectrum that an `rgb`, `spectrum` or `blackbody` parameter means.
    pub fn spectrum(
        &mut self,
        diag: &mut Diagnostics,
        resolve: &dyn Fn(&Text) -> Option<std::path::PathBuf>,
    ) -> Option<SpectrumDesc> {
        match self.ty {
            ParamType::Rgb => {
                let rgb = self.single(diag).map(|v| [v[0], v[1], v[2]])?;
                if rgb.iter().any(|&c| c < 0.0) {
                    let message = format!("colour `{}` has a negative component", self.name);
                    diag.error(self.span, message);
                    return None;
                }
                Some(SpectrumDesc::Rgb { rgb, space: self.space })
            }
            ParamType::Blackbody => {
                let kelvin = self.single(diag)?[0];
                if kelvin <= 0.0 {
                    diag.error(self.span, "a black body needs a temperature above 0 K");
                    return None;
                }
                Some(SpectrumDesc::Blackbody { kelvin, normalized: true })
            }
            _ => match &self.values {
                Values::Floats(v) => {
                    let spectrum = spectrum::from_pairs(v);
                    spectrum.map_err(|cause| diag.error(self.span, cause)).ok()
                }
                _ => {
                    self.check_count(diag, 1)?;
                    let name = self.strings().first()?.clone();
                    named_or_file(diag, &name, resolve(&name).as_deref())
                }
            },
        }
    }
}

/// A spectrum by pbrt's name, or else from a file.
fn named_or_file(diag: &mut Diagnostics, name: &Text, path: Option<&Path>) -> Option<SpectrumDesc> {
    if let Some(known) = kaustika_spectra::named(&name.text) {
        return Some(known);
    }
    let Some(path) = path else {
        let message = format!("no spectrum and no file is called `{}`", name.text);
        let error = diag.error(name.span, message);
        if let Some(near) = kaustika_spectra::suggest(&name.text, kaustika_spectra::names()) {
            error.hint(format!("did you mean `{near}`?"));
        }
        return None;
    };
    let read = std::fs::read_to_string(path).map_err(|e| e.to_string());
    match read.and_then(|text| spectrum::from_spd(&text)) {
        Ok(spectrum) => Some(spectrum),
        Err(cause) => {
            diag.error(name.span, format!("can't read spectrum file `{}`: {cause}", name.text));
            None
        }
    }
}
