//! Phase functions.

use super::convert::Converter;
use super::document::{Kind, Object, ObjectId, Value};
use super::values;
use kaustika_scene::description::{PhaseDesc, SggxDesc, Span};

const PHASES: &[&str] =
    &["isotropic", "hg", "rayleigh", "blendphase", "mixturephase", "tabphase", "sggx"];

impl<'a> Converter<'a> {
    pub(super) fn phase(&mut self, id: ObjectId) -> PhaseDesc {
        self.guarded(id, |c| c.new_phase(id)).unwrap_or(PhaseDesc::Isotropic)
    }

    fn new_phase(&mut self, id: ObjectId) -> PhaseDesc {
        let object = self.object(id);
        let phase = match object.plugin.as_str() {
            "isotropic" => PhaseDesc::Isotropic,
            "hg" => {
                let g = self.number(object, "g", 0.8);
                if g.abs() >= 1.0 {
                    let span = object.get("g").map(|p| p.value_span);
                    let message = format!("`g` must lie between -1 and 1, found {g}");
                    self.out.diagnostics.error(span, message);
                }
                PhaseDesc::HenyeyGreenstein { g }
            }
            "rayleigh" => PhaseDesc::Rayleigh,
            "blendphase" => self.blend_phase(object),
            "tabphase" => self.tabulated_phase(object),
            "mixturephase" => self.mixture_phase(object),
            "sggx" => self.sggx(object).map_or(PhaseDesc::Isotropic, PhaseDesc::Sggx),
            "microflake" | "kkay" => {
                self.replaced(object, "light scatters in all directions alike");
                PhaseDesc::Isotropic
            }
            _ => {
                self.unknown_plugin(object, PHASES);
                self.replaced_silently(object);
                PhaseDesc::Isotropic
            }
        };
        self.finish(id);
        phase
    }

    fn blend_phase(&mut self, object: &'a Object) -> PhaseDesc {
        let weight = match object.get("weight").map(|p| (&p.value, p)) {
            Some((Value::Float(_) | Value::Integer(_), _)) => self.number(object, "weight", 0.5),
            Some((_, p)) => {
                let message = "the weight of a `blendphase` can't vary";
                self.out.diagnostics.warning(p.span, message).label("0.5 is used");
                0.5
            }
            None => 0.5,
        };
        let parts = self.children(object, Kind::Phase);
        let [(_, a), (_, b)] = parts.as_slice() else {
            let message =
                format!("phase `blendphase` needs 2 phases inside, found {}", parts.len());
            self.out.diagnostics.error(object.span, message);
            return PhaseDesc::Isotropic;
        };
        let (a, b) = (Box::new(self.phase(*a)), Box::new(self.phase(*b)));
        PhaseDesc::Blend { weight, a, b }
    }

    fn tabulated_phase(&mut self, object: &'a Object) -> PhaseDesc {
        let Some((text, span)) = self.string(object, "values") else {
            if !object.has("values") {
                self.out.diagnostics.error(object.span, "phase `tabphase` needs `values`");
            }
            return PhaseDesc::Isotropic;
        };
        let words = text.split(|c: char| c.is_whitespace() || c == ',').filter(|w| !w.is_empty());
        let values: Result<Vec<f32>, String> =
            words.map(|w| values::number(w).map(|v| v as f32)).collect();
        match values {
            Err(message) => {
                self.out.diagnostics.error(span, message);
                PhaseDesc::Isotropic
            }
            Ok(v) if v.len() < 2 || v.iter().any(|v| *v < 0.0) || v.iter().all(|v| *v == 0.0) => {
                let message = "a phase function needs two values or more, none negative, not all 0";
                self.out.diagnostics.error(span, message);
                PhaseDesc::Isotropic
            }
            Ok(values) => PhaseDesc::Tabulated { values },
        }
    }

    /// 0.6: any number of parts, one after the other blended in. Weights that add up to more than
    /// 1 are scaled; what is left to 1 goes into no direction, which no phase function here does.
    fn mixture_phase(&mut self, object: &'a Object) -> PhaseDesc {
        let Some((text, span)) = self.string(object, "weights") else {
            if !object.has("weights") {
                self.out.diagnostics.error(object.span, "phase `mixturephase` needs `weights`");
            }
            return PhaseDesc::Isotropic;
        };
        let weights: Result<Vec<f64>, String> =
            values::tokens(text).into_iter().map(values::number).collect();
        let parts = self.children(object, Kind::Phase);
        let weights = match weights {
            Ok(w) if w.len() == parts.len() && w.iter().all(|w| *w >= 0.0) => w,
            Ok(w) => {
                let message = format!(
                    "expected as many `weights`, none negative, as phases inside, {}, found {}",
                    parts.len(),
                    w.len()
                );
                self.out.diagnostics.error(span, message);
                return PhaseDesc::Isotropic;
            }
            Err(message) => {
                self.out.diagnostics.error(span, message);
                return PhaseDesc::Isotropic;
            }
        };
        let total: f64 = weights.iter().sum();
        if total < 0.9999 {
            let message = "the `weights` add up to less than 1: they are scaled to add up to 1";
            self.out.diagnostics.warning(span, message);
        }
        let mut so_far = 0.0;
        let mut mixture = PhaseDesc::Isotropic;
        for ((_, part), weight) in parts.into_iter().zip(weights) {
            so_far += weight;
            if weight > 0.0 {
                let (a, b) = (Box::new(mixture), Box::new(self.phase(part)));
                mixture = PhaseDesc::Blend { weight: (weight / so_far) as f32, a, b };
            }
        }
        mixture
    }

    /// S, as a volume of six channels or as six numbers.
    fn sggx(&mut self, object: &'a Object) -> Option<SggxDesc> {
        let needs = "phase `sggx` needs `S`: a `gridvolume` of six channels, or the six numbers xx, \
                     yy, zz, xy, xz, yz in a `<string>`";
        let given = object.get("S");
        if let Some(Value::String(_)) = given.map(|p| &p.value) {
            let (text, span) = self.string(object, "S")?;
            return self.flakes(text, span);
        }
        let volume = given.and_then(|p| self.target(p));
        let Some(id) = volume.filter(|id| self.object(*id).kind == Kind::Volume) else {
            self.out.diagnostics.error(object.span, needs);
            return None;
        };
        let volume = self.object(id);
        let made = match volume.plugin.as_str() {
            "gridvolume" => self.grid(volume).and_then(|(grid, span)| {
                let sample = (grid.values.chunks_exact(6)).position(|s| !semidefinite(s));
                match sample {
                    _ if grid.channels != 6 => {
                        let message = format!("{needs}; this has {} channels", grid.channels);
                        self.out.diagnostics.error(span, message);
                        None
                    }
                    Some(i) => {
                        let message = format!("sample {i} of `S` is not positive semidefinite");
                        self.out.diagnostics.error(span, message);
                        None
                    }
                    None => Some(SggxDesc::Grid(grid)),
                }
            }),
            "constvolume" => match self.string(volume, "value") {
                Some((text, span)) => self.flakes(text, span),
                None => {
                    self.out.diagnostics.error(volume.span, needs);
                    None
                }
            },
            _ => {
                self.out.diagnostics.error(volume.type_span, needs);
                None
            }
        };
        self.finish(id);
        made
    }

    fn flakes(&mut self, text: &str, span: Span) -> Option<SggxDesc> {
        let numbers: Result<Vec<f64>, String> =
            values::tokens(text).into_iter().map(values::number).collect();
        let message = match numbers.map(|n| n.into_iter().map(|v| v as f32).collect::<Vec<_>>()) {
            Ok(n) => match <[f32; 6]>::try_from(n) {
                Ok(s) if semidefinite(&s) && determinant(&s) > 0.0 => {
                    return Some(SggxDesc::Constant(s));
                }
                Ok(_) => "`S` must be positive definite".to_string(),
                Err(n) => format!("`S` needs six numbers, found {}", n.len()),
            },
            Err(message) => message,
        };
        self.out.diagnostics.error(span, message);
        None
    }
}

fn determinant(s: &[f32]) -> f64 {
    let s: Vec<f64> = s.iter().map(|v| f64::from(*v)).collect();
    let [xx, yy, zz, xy, xz, yz] = std::array::from_fn(|i| s[i]);
    xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
}

/// True if no principal minor is negative, but for rounding.
fn semidefinite(s: &[f32]) -> bool {
    let [xx, yy, zz, xy, xz, yz] = std::array::from_fn(|i| f64::from(s[i]));
    let largest = xx.max(yy).max(zz);
    let room = -1e-6 * largest * largest;
    let minors = [xx * yy - xy * xy, xx * zz - xz * xz, yy * zz - yz * yz];
    xx >= 0.0
        && yy >= 0.0
        && zz >= 0.0
        && minors.iter().all(|m| *m >= room)
        && determinant(s) >= room * largest
}
