//! `LightSource` (pbrt-v4, lights.cpp).
//!
//! pbrt divides the spectrum of every light by its luminance, so `scale` is in photometric units,
//! and turns `power` and `illuminance` into a factor at once, without looking at the components
//! of an RGB colour. The same is done here: the description holds the final `scale`.

use super::build::Builder;
use super::entity::{Entity, LightEntity};
use super::images;
use super::param::{ParamType, Text};
use super::spectrum::unit_luminance;
use kaustika_math::{Frame, Transform, Vec3};
use kaustika_scene::description::{Bitmap, EnvironmentLayout, LightDesc, LightKind, SpotFalloff};
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
    fn emission(&mut self, e: &mut Entity, name: &'static str) -> (SpectrumDesc, f32) {
        let spectrum = self
            .spectrum(e, name)
            .unwrap_or(SpectrumDesc::Rgb { rgb: [1.0; 3], space: e.params.space });
        let scale = e.params.float(&mut self.desc.diagnostics, "scale", 1.0);
        let scale = scale * unit_luminance(&spectrum);
        (spectrum, scale)
    }

    /// A positive `power` or `illuminance`.
    fn target(&mut self, e: &mut Entity, name: &'static str) -> Option<f32> {
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

    fn infinite(&mut self, e: &mut Entity) -> Option<(LightKind, Transform)> {
        let portal = self.portal(e);
        let diag = &mut self.desc.diagnostics;
        let old = e.params.string(diag, "mapname");
        let new = e.params.string(diag, "filename");
        let illuminance = self.target(e, "illuminance");
        let lat_long = old.is_some();
        if let Some(name) = old.or(new) {
            if e.params.has("L") {
                let message = "an infinite light has `L` or `filename`, not both";
                self.desc.diagnostics.error(e.params.place("L"), message);
                return None;
            }
            let (kind, local) = self.environment(e, &name, lat_long, illuminance)?;
            return Some((through(kind, portal), local));
        }
        if portal.is_some() {
            let message = "a portal without an image is not supported";
            let place = e.params.place("portal");
            self.desc.diagnostics.warning(place, message).label("the light comes from everywhere");
        }
        if e.params.has("filename") || e.params.has("mapname") {
            return None;
        }
        let (radiance, mut scale) = self.emission(e, "L");
        if let Some(illuminance) = illuminance {
            scale *= illuminance / PI;
        }
        let kind = LightKind::Constant { radiance, scale, illuminance: None };
        Some((kind, Transform::IDENTITY))
    }

    /// The corners of a window that light comes through: in world space, whatever the current one.
    fn portal(&mut self, e: &mut Entity) -> Option<[Vec3; 4]> {
        let place = e.params.has("portal").then(|| e.params.place("portal"))?;
        let diag = &mut self.desc.diagnostics;
        let points = e.params.triples(diag, "portal", ParamType::Point3)?;
        let Ok(corners @ [a, b, c, d]) = <[Vec3; 4]>::try_from(points.as_slice()) else {
            let message = format!("a portal has four corners, found {}", points.len());
            diag.error(place, message);
            return None;
        };
        let (u, v) = (b - a, d - a);
        let size = u.length().max(v.length());
        let square = u.dot(v).abs() <= 1e-3 * u.length() * v.length();
        if !square || (a + u + v - c).length() > 1e-3 * size || u.cross(v).length() <= 0.0 {
            diag.error(place, "the corners of a portal must be those of a rectangle, in order");
            return None;
        }
        Some(corners)
    }

    fn environment(
        &mut self,
        e: &mut Entity,
        name: &Text,
        mut lat_long: bool,
        illuminance: Option<f32>,
    ) -> Option<(LightKind, Transform)> {
        let mut scale = e.params.float(&mut self.desc.diagnostics, "scale", 1.0);
        let bitmap = self.light_image(name)?;
        if !lat_long && bitmap.width != bitmap.height {
            if bitmap.width != 2 * bitmap.height {
                let message = format!(
                    "`{}` is {} x {} pixels, an environment map must be square",
                    name.text, bitmap.width, bitmap.height
                );
                self.desc.diagnostics.error(name.span, message).hint(
                    "pbrt-v4 uses equal-area octahedral maps; `imgtool makeequiarea` makes them",
                );
                return None;
            }
            let message =
                "the environment map is twice as wide as high: read as latitude-longitude";
            self.desc.diagnostics.warning(name.span, message);
            lat_long = true;
        }
        let layout =
            if lat_long { EnvironmentLayout::LatLong } else { EnvironmentLayout::EqualArea };
        if let Some(illuminance) = illuminance {
            let current = upper_illuminance(&bitmap, layout);
            if current > 0.0 {
                scale *= illuminance / current;
            }
        }
        let local = if lat_long { LAT_LONG_TO_PBRT } else { Transform::IDENTITY };
        let space = ColorSpace::Srgb;
        let kind = LightKind::Image { bitmap, space, layout, scale, illuminance: None };
        Some((kind, local))
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

/// From the space of [`EnvironmentLayout::LatLong`], +y up and (sin φ sin θ, cos θ, -cos φ sin θ)
/// at (φ/2π, θ/π), to pbrt-v3's, +z up and (cos φ sin θ, sin φ sin θ, cos θ) there.
const LAT_LONG_TO_PBRT: Transform = Transform {
    m: [[0.0, 0.0, -1.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]],
    inv: [[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]],
};

/// Illuminance by the upper half (+z) of an environment, ∫ L cos θ dω, as pbrt finds it: for
/// equal-area maps pbrt-v4 counts 2π/n sr for each of n texels, half of what they cover. That is
/// kept, so that pictures come out as bright as pbrt's.
fn upper_illuminance(b: &Bitmap, layout: EnvironmentLayout) -> f32 {
    match layout {
        EnvironmentLayout::EqualArea => {
            let mean = images::mean(b, |x, y| {
                let u = (x as f32 + 0.5) / b.width as f32;
                let v = (y as f32 + 0.5) / b.height as f32;
                octahedral_cos(u, v).max(0.0) * images::luminance(b, x, y)
            });
            2.0 * PI * mean
        }
        EnvironmentLayout::LatLong => {
            let mean = images::mean(b, |x, y| {
                let theta = (y as f32 + 0.5) / b.height as f32 * PI;
                theta.cos().max(0.0) * theta.sin() * images::luminance(b, x, y)
            });
            2.0 * PI * PI * mean
        }
    }
}

/// cos θ of a point of the equal-area octahedral square (Clarberg 2008, "Fast Equal-Area Mapping
/// of the (Hemi)Sphere using SIMD").
fn octahedral_cos(u: f32, v: f32) -> f32 {
    let signed_distance = 1.0 - ((2.0 * u - 1.0).abs() + (2.0 * v - 1.0).abs());
    let r = 1.0 - signed_distance.abs();
    (1.0 - r * r).copysign(signed_distance)
}

/// The light, coming in through a portal if there is one.
fn through(kind: LightKind, portal: Option<[Vec3; 4]>) -> LightKind {
    match (kind, portal) {
        (LightKind::Image { bitmap, space, layout, scale, .. }, Some(corners)) => {
            LightKind::Portal { bitmap, space, layout, scale, corners }
        }
        (kind, _) => kind,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kaustika_scene::description::{Encoding, Texels};

    #[test]
    fn a_uniform_environment_lights_the_ground_by_pi_or_what_pbrt_takes_for_it() {
        let kinds =
            [(64, EnvironmentLayout::EqualArea, 0.5), (128, EnvironmentLayout::LatLong, 1.0)];
        for (w, layout, share) in kinds {
            let texels = Texels::F32(vec![1.0; w as usize * 64]);
            let encoding = Encoding::Linear;
            let b = Bitmap { width: w, height: 64, channels: 1, texels, encoding };
            let e = upper_illuminance(&b, layout);
            assert!((e - share * PI).abs() < 2e-3, "{layout:?}: {e}");
        }
    }

    #[test]
    fn the_turn_of_latitude_longitude_maps_takes_directions_to_those_of_pbrt_v3() {
        for (phi, theta) in [(0.3f32, 0.7f32), (4.0, 2.0), (2.0, 1.2)] {
            let (sp, cp, st, ct) = (phi.sin(), phi.cos(), theta.sin(), theta.cos());
            let ours = Vec3::new(sp * st, ct, -cp * st);
            let v3 = Vec3::new(cp * st, sp * st, ct);
            assert!((LAT_LONG_TO_PBRT.vector(ours) - v3).length() < 1e-6);
            assert!((LAT_LONG_TO_PBRT.inverse().vector(v3) - ours).length() < 1e-6);
        }
    }
}
