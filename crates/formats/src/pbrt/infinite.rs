//! `LightSource "infinite"` (pbrt-v4, lights.cpp): light from all around or through a portal.

use super::build::Builder;
use super::entity::Entity;
use super::images;
use super::param::{ParamType, Text};
use kaustika_math::{Transform, Vec3};
use kaustika_scene::description::{Bitmap, Encoding, EnvironmentLayout, LightKind, Texels};
use kaustika_spectra::{
    ColorMode, ColorSpace, CompiledSpectrum, SpectrumDesc, SpectrumRole, Wavelengths,
};
use std::f32::consts::PI;
use std::sync::Arc;

impl Builder {
    pub(super) fn infinite(&mut self, e: &mut Entity) -> Option<(LightKind, Transform)> {
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
        if e.params.has("filename") || e.params.has("mapname") {
            return None;
        }
        if portal.is_some() {
            let kind = self.even_sky(e, illuminance);
            return Some((through(kind, portal), Transform::IDENTITY));
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

    /// `L` as an image of one pixel. As in pbrt it is not divided by its luminance, which matters for
    /// spectra that the scene writes out.
    fn even_sky(&mut self, e: &mut Entity, illuminance: Option<f32>) -> LightKind {
        let white = SpectrumDesc::Rgb { rgb: [1.0; 3], space: e.params.space };
        let radiance = self.spectrum(e, "L").unwrap_or(white);
        let mut scale = e.params.float(&mut self.desc.diagnostics, "scale", 1.0);
        let compiled = CompiledSpectrum::new(&radiance, SpectrumRole::Illuminant, ColorMode::Rgb);
        let rgb = compiled.eval(&Wavelengths::rgb()).rgb().map(|c| c.max(0.0));
        let (texels, encoding) = (Texels::F32(rgb.to_vec()), Encoding::Linear);
        let bitmap = Arc::new(Bitmap { width: 1, height: 1, channels: 3, texels, encoding });
        let layout = EnvironmentLayout::EqualArea;
        let current = upper_illuminance(&bitmap, layout);
        if let Some(illuminance) = illuminance
            && current > 0.0
        {
            scale *= illuminance / current;
        }
        let space = ColorSpace::Srgb;
        LightKind::Image { bitmap, space, layout, scale, illuminance: None }
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
}

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
