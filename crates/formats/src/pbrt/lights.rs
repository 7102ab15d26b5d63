//! `LightSource` (pbrt-v4, lights.cpp).
//!
//! pbrt divides the spectrum of every light by its luminance, so `scale` is in photometric units,
//! and turns `power` and `illuminance` into a factor at once, without looking at the components
//! of an RGB colour. The same is done here: the description holds the final `scale`.

use super::build::Builder;
use super::entity::{Entity, LightEntity};
use super::images;
use super::param::Text;
use super::spectrum::unit_luminance;
use kaustika_math::{Frame, Transform, Vec3};
use kaustika_scene::description::{Bitmap, LightDesc, LightKind, SpotFalloff};
use kaustika_spectra::{ColorSpace, SpectrumDesc};
use std::f32::consts::PI;
use std::sync::Arc;

const KINDS: [&str; 6] = ["distant", "goniometric", "infinite", "point", "projection", "spot"];

impl Builder {
    /// All lights without a surface.
    pub fn lights(&mut self) {
        for mut l in std::mem::take(&mut self.scene.lights) {
            let light = self.light(&mut l);
            let medium = self.medium(&l.medium);
            let what = format!("light `{}`", l.entity.kind.text);
            match light {
                Some((kind, local)) => {
                    l.entity.params.report_unused(&mut self.desc.diagnostics, &what);
                    self.desc.lights.push(LightDesc {
                        name: String::new(),
                        kind,
                        transform: l.transform * local,
                        medium,
                        span: Some(l.entity.span),
                    });
                }
                None => l.entity.params.ignore_rest(),
            }
        }
    }

    /// The kind, and the transform from its own space to the current one.
    fn light(&mut self, l: &mut LightEntity) -> Option<(LightKind, Transform)> {
        let e = &mut l.entity;
        match e.kind.text.as_str() {
            "point" => Some(self.point(e)),
            "spot" => self.spot(e),
            "distant" => self.distant(e),
            "infinite" => self.infinite(e),
            "goniometric" => self.goniometric(e),
            "projection" => self.projection(e),
            kind => {
                let message = format!("unknown light `{kind}`");
                let error = self.desc.diagnostics.error(e.kind.span, message);
                if kind == "diffuse" || kind == "area" {
                    error.hint("a light on a surface is an `AreaLightSource`");
                } else {
                    error.nearest(kind, &KINDS);
                }
                None
            }
        }
    }

    /// The spectrum of a light, white of the current colour space by default, and `scale` with
    /// pbrt's normalisation.
    pub(super) fn emission(&mut self, e: &mut Entity, name: &'static str) -> (SpectrumDesc, f32) {
        let spectrum = self
            .spectrum(e, name)
            .unwrap_or(SpectrumDesc::Rgb { rgb: [1.0; 3], space: e.params.space });
        let scale = e.params.float(&mut self.desc.diagnostics, "scale", 1.0);
        let scale = scale * unit_luminance(&spectrum);
        (spectrum, scale)
    }

    /// A positive `power` or `illuminance`.
    pub(super) fn target(&mut self, e: &mut Entity, name: &'static str) -> Option<f32> {
        let value = e.params.float_or_none(&mut self.desc.diagnostics, name)?;
        (value > 0.0).then_some(value)
    }

    fn point(&mut self, e: &mut Entity) -> (LightKind, Transform) {
        let (intensity, mut scale) = self.emission(e, "I");
        if let Some(power) = self.target(e, "power") {
            scale *= power / (4.0 * PI);
        }
        let from = e.params.point3(&mut self.desc.diagnostics, "from", Vec3::ZERO);
        (LightKind::Point { intensity, scale, power: None }, Transform::translate(from))
    }

    fn spot(&mut self, e: &mut Entity) -> Option<(LightKind, Transform)> {
        let (intensity, mut scale) = self.emission(e, "I");
        let diag = &mut self.desc.diagnostics;
        let cutoff = e.params.float(diag, "coneangle", 30.0);
        let delta = e.params.float(diag, "conedeltaangle", 5.0);
        let (frame, from) = self.aim(e)?;
        let beam_width = (cutoff - delta).max(0.0);
        if let Some(power) = self.target(e, "power") {
            let (end, start) = (cutoff.to_radians().cos(), beam_width.to_radians().cos());
            scale *= power / (2.0 * PI * ((1.0 - start) + (start - end) / 2.0));
        }
        let kind = LightKind::Spot {
            intensity,
            scale,
            power: None,
            cutoff,
            beam_width,
            falloff: SpotFalloff::SmoothstepCosine,
            texture: None,
        };
        Some((kind, Transform::translate(from) * frame))
    }

    fn distant(&mut self, e: &mut Entity) -> Option<(LightKind, Transform)> {
        let (irradiance, mut scale) = self.emission(e, "L");
        let (frame, _) = self.aim(e)?;
        if let Some(illuminance) = self.target(e, "illuminance") {
            scale *= illuminance;
        }
        Some((LightKind::Directional { irradiance, scale, illuminance: None }, frame))
    }

    /// The frame whose +z runs from `from` to `to`, and `from`.
    fn aim(&mut self, e: &mut Entity) -> Option<(Transform, Vec3)> {
        let diag = &mut self.desc.diagnostics;
        let from = e.params.point3(diag, "from", Vec3::ZERO);
        let to = e.params.point3(diag, "to", Vec3::Z);
        let Some(z) = (to - from).try_normalize() else {
            diag.error(e.params.place("to"), "`from` and `to` are the same point");
            return None;
        };
        let f = Frame::from_normal(z);
        let row = |i: usize| [f.s[i], f.t[i], f.n[i], 0.0];
        let frame = Transform::from_rows([row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]])?;
        Some((frame, from))
    }

    /// An image that can be a light.
    pub fn light_image(&mut self, name: &Text) -> Option<Arc<Bitmap>> {
        let bitmap = self.image(name)?;
        if !images::is_finite(&bitmap) {
            let message = format!("`{}` has infinite or undefined pixels", name.text);
            self.desc.diagnostics.error(name.span, message);
            return None;
        }
        Some(bitmap)
    }

    fn goniometric(&mut self, e: &mut Entity) -> Option<(LightKind, Transform)> {
        let (intensity, mut scale) = self.emission(e, "I");
        let power = self.target(e, "power");
        // pbrt turns its octahedral directions so that +y is up.
        let swap_yz = Transform { m: SWAP_YZ, inv: SWAP_YZ };
        let Some(name) = e.params.string(&mut self.desc.diagnostics, "filename") else {
            let message = "light `goniometric` has no image and shines the same everywhere";
            self.desc.diagnostics.warning(e.kind.span, message).hint("add \"string filename\"");
            scale *= power.map_or(1.0, |p| p / (4.0 * PI));
            return Some((LightKind::Point { intensity, scale, power: None }, swap_yz));
        };
        let bitmap = self.light_image(&name)?;
        if bitmap.width != bitmap.height {
            let message = format!(
                "`{}` is {} x {} pixels, a goniometric map must be square",
                name.text, bitmap.width, bitmap.height
            );
            self.desc
                .diagnostics
                .error(name.span, message)
                .hint("pbrt-v4 uses equal-area octahedral maps; `imgtool makeequiarea` makes them");
            return None;
        }
        if let Some(power) = power {
            let grey = |x, y| (0..3).map(|c| images::texel(&bitmap, x, y, c)).sum::<f32>() / 3.0;
            let mean = images::mean(&bitmap, grey);
            scale *= if mean > 0.0 { power / (4.0 * PI * mean) } else { 1.0 };
        }
        Some((LightKind::Goniometric { intensity, bitmap, scale, power: None }, swap_yz))
    }

    fn projection(&mut self, e: &mut Entity) -> Option<(LightKind, Transform)> {
        let diag = &mut self.desc.diagnostics;
        let mut scale = e.params.float(diag, "scale", 1.0);
        let fov = e.params.float(diag, "fov", 90.0);
        if !(fov > 0.0 && fov < 180.0) {
            diag.error(e.params.place("fov"), "`fov` must lie between 0 and 180 degrees");
            return None;
        }
        let power = self.target(e, "power");
        let Some(name) = e.params.string(&mut self.desc.diagnostics, "filename") else {
            if !e.params.has("filename") {
                let message = "light `projection` needs \"string filename\"";
                self.desc.diagnostics.error(e.kind.span, message);
            }
            return None;
        };
        let bitmap = self.light_image(&name)?;
        let aspect = bitmap.width as f32 / bitmap.height as f32;
        let tan = (0.5 * fov.to_radians()).tan();
        // pbrt's angle spans the shorter side.
        let (half_x, half_y) = (tan * aspect.max(1.0), tan * (1.0 / aspect).max(1.0));
        if let Some(power) = power {
            let mean = images::mean(&bitmap, |x, y| {
                let px = ((x as f32 + 0.5) / bitmap.width as f32 * 2.0 - 1.0) * half_x;
                let py = ((y as f32 + 0.5) / bitmap.height as f32 * 2.0 - 1.0) * half_y;
                let cos = 1.0 / (1.0 + px * px + py * py).sqrt();
                images::luminance(&bitmap, x, y) * cos * cos * cos
            });
            let area = 4.0 * half_x * half_y;
            scale *= if mean > 0.0 { power / (area * mean) } else { 1.0 };
        }
        let fov_x = 2.0 * half_x.atan().to_degrees();
        let space = ColorSpace::Srgb;
        let kind = LightKind::Projection { bitmap, space, fov_x, scale, power: None };
        Some((kind, Transform::IDENTITY))
    }
}

const SWAP_YZ: [[f32; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
