//! From described lights to ready ones.

use super::{
    Beam, Directional, Environment, Goniometric, Light, Point, Projection, Projector, Spot,
};
use crate::description::{LightDesc, LightKind, TextureDesc, TextureNode};
use crate::texture::ImageMap;
use kaustika_math::Vec3;
use kaustika_spectra::{ColorMode, ColorSpace, CompiledSpectrum, SpectrumDesc, SpectrumRole};
use std::f32::consts::PI;

fn illuminant(desc: &SpectrumDesc, mode: ColorMode) -> CompiledSpectrum {
    CompiledSpectrum::new(desc, SpectrumRole::Illuminant, mode)
}

impl Light {
    /// Prepares a light without surface. Where a power or illuminance is given, the scale is
    /// set so that a light of unit luminance would have it (pbrt's convention).
    pub fn build(desc: &LightDesc, textures: &[TextureDesc], mode: ColorMode) -> Light {
        let to_world = desc.transform;
        match &desc.kind {
            LightKind::Point { intensity, scale, power } => Light::Point(Point {
                p: to_world.point(Vec3::ZERO),
                intensity: illuminant(intensity, mode),
                scale: scale * power.map_or(1.0, |p| p / (4.0 * PI)),
            }),
            LightKind::Spot { intensity, scale, power, cutoff, beam_width, falloff, texture } => {
                let mut spot = Spot {
                    to_world,
                    intensity: illuminant(intensity, mode),
                    scale: *scale,
                    cutoff: cutoff.to_radians(),
                    beam_width: beam_width.to_radians(),
                    falloff: *falloff,
                    texture: *texture,
                };
                spot.scale *= power.map_or(1.0, |p| p / spot.solid_angle());
                Light::Spot(spot)
            }
            LightKind::Directional { irradiance, scale, illuminance } => {
                Light::Directional(Directional {
                    direction: to_world.vector(Vec3::Z).normalize(),
                    irradiance: illuminant(irradiance, mode),
                    scale: scale * illuminance.unwrap_or(1.0),
                })
            }
            LightKind::Beam { power, scale } => Light::Beam(Beam {
                p: to_world.point(Vec3::ZERO),
                direction: to_world.vector(Vec3::Z).normalize(),
                power: illuminant(power, mode),
                scale: *scale,
            }),
            LightKind::Constant { radiance, scale, illuminance } => {
                let scale = scale * illuminance.map_or(1.0, |e| e / PI);
                Light::Environment(Environment::constant(illuminant(radiance, mode), scale))
            }
            LightKind::Image { bitmap, space, layout, scale, illuminance } => {
                let image = ImageMap::new(bitmap, *space);
                let mut light = Environment::image(&image, *layout, *scale, to_world);
                if let Some(e) = illuminance {
                    let own = light.upper_illuminance();
                    if own > 0.0 {
                        light.rescale(e / own);
                    }
                }
                Light::Environment(light)
            }
            LightKind::Portal { bitmap, space, layout, scale, corners } => {
                let image = ImageMap::new(bitmap, *space);
                let light = Environment::portal(&image, *layout, *scale, to_world, *corners);
                let dark = || Environment::constant(CompiledSpectrum::constant(0.0, mode), 0.0);
                Light::Environment(light.unwrap_or_else(dark))
            }
            LightKind::Sky { sky, scale } => {
                Light::Environment(Environment::clear_sky(sky, *scale, to_world, mode))
            }
            LightKind::Sun { radiance, scale, radius } => {
                let center = to_world.vector(Vec3::Z).normalize();
                let radiance = illuminant(radiance, mode);
                let radius = radius.to_radians();
                Light::Environment(Environment::sun(center, radius, radiance, *scale))
            }
            LightKind::Projection { bitmap, space, fov_x, scale, power } => {
                let image = ImageMap::new(bitmap, *space);
                let tan_x = (0.5 * fov_x.to_radians()).tan();
                let tan_y = tan_x * image.height as f32 / image.width as f32;
                let mut light = Projection { to_world, image, tan_x, tan_y, scale: *scale };
                if let Some(p) = power {
                    let own = light.mean_intensity_integral();
                    if own > 0.0 {
                        light.scale *= p / own;
                    }
                }
                Light::Projection(light)
            }
            LightKind::Projector { texture, scale, fov, fov_axis } => {
                let size = match textures.get(texture.0 as usize).map(|t| &t.node) {
                    Some(TextureNode::Bitmap(t)) => [t.bitmap.width, t.bitmap.height],
                    _ => [1, 1],
                };
                let tan = (0.5 * fov.to_radians()).tan();
                let tan = fov_axis.half_extents(size).map(|extent| tan * extent);
                Light::Projector(Projector { to_world, texture: *texture, scale: *scale, tan })
            }
            LightKind::Goniometric { intensity, bitmap, scale, power } => {
                let image = ImageMap::new(bitmap, ColorSpace::Srgb);
                let k = power.map_or(1.0, |p| p / (4.0 * PI * image.mean().max(f32::MIN_POSITIVE)));
                Light::Goniometric(Goniometric {
                    to_world,
                    intensity: illuminant(intensity, mode),
                    image,
                    scale: scale * k,
                })
            }
        }
    }
}
