//! Sun and sky: `sunsky` of Mitsuba 3, and `timed_sunsky` at one moment; `sky`, `sun` and `sunsky` of 0.6.
//!
//! Both take the sky of Hosek and Wilkie. The sun is theirs in Mitsuba 3, Preetham's in 0.6. Where
//! the sun stands follows from date, time and place, or is given as a direction in the world.
//! Mitsuba 0.6 has +y up, Mitsuba 3 +z; the description has +z.

use super::convert::{Converter, old, spelling, vec3};
use super::document::Object;
use super::sun_position::Moment;
use super::textures::Role;
use kaustika_math::{Transform, Vec3, safe_acos};
use kaustika_scene::description::{LightKind, SkyDesc};
use kaustika_spectra::{SpectrumDesc, hosek_sun, preetham_sun};
use std::f32::consts::{FRAC_PI_2, PI};

/// Diameter of the sun seen from the earth, degrees.
pub(super) const APERTURE: f32 = 0.5358;

/// What tells the time and the place.
const MOMENT: [&str; 9] =
    ["latitude", "longitude", "timezone", "year", "month", "day", "hour", "minute", "second"];

impl<'a> Converter<'a> {
    /// The lights that a `sunsky`, `sky` or `sun` stands for.
    pub(super) fn daylight(&mut self, object: &'a Object) -> Vec<(LightKind, Transform)> {
        object.ignore(&["resolution"]);
        let (with_sky, with_sun) = (object.plugin != "sun", object.plugin != "sky");
        let transform = self.transform(object, "to_world") * z_up(old(object));
        let turbidity = self.within(object, "turbidity", 3.0, [1.0, 10.0]);
        let albedo = self.albedo(object, if old(object) { 0.2 } else { 0.3 });
        let (stretch, extend) = match old(object) {
            true => (
                self.within(object, "stretch", 1.0, [1.0, 2.0]),
                self.boolean(object, "extend", false),
            ),
            false => (1.0, false),
        };
        let scale = if old(object) { self.number(object, "scale", 1.0) } else { 1.0 };
        let [sky_scale, sun_scale] = match object.plugin.as_str() {
            "sunsky" | "timed_sunsky" => {
                [self.number(object, "sky_scale", scale), self.number(object, "sun_scale", scale)]
            }
            _ => [scale; 2],
        };
        let radius = match old(object) {
            true => 0.5 * APERTURE * self.number(object, "sun_radius_scale", 1.0),
            false => 0.5 * self.number(object, "sun_aperture", APERTURE),
        };
        if !(0.0..90.0).contains(&radius) || (radius == 0.0 && !old(object)) {
            let message = format!("a sun of {}° across is none", 2.0 * radius);
            self.out.diagnostics.error(object.span, message);
            return Vec::new();
        }
        if self.boolean(object, "complex_sun", false) {
            let span = object.get("complex_sun").map(|p| p.span);
            self.out
                .diagnostics
                .warning(span, "a sun that darkens toward its limb is not supported")
                .label("a disc of the same mean is used");
        }
        let sun = match object.plugin.as_str() {
            "timed_sunsky" => match self.course(object) {
                Some(course) if course.is_moment() => self.risen(object, course.sun(0.0)),
                Some(course) => {
                    let sky = SkyDesc { turbidity, albedo, sun: Vec3::Z, stretch, extend };
                    return vec![course.mean(&sky, [sky_scale, sun_scale], transform)];
                }
                None => None,
            },
            _ => self.sun(object, &transform),
        };
        let Some(sun) = sun else { return Vec::new() };

        let mut lights = Vec::new();
        if with_sky && sky_scale > 0.0 {
            let sky = SkyDesc { turbidity, albedo, sun, stretch, extend };
            lights.push((LightKind::Sky { sky, scale: sky_scale }, transform));
        }
        if with_sun && sun_scale > 0.0 {
            lights.extend(sun_light(object, transform, sun, turbidity, radius, sun_scale, stretch));
        }
        lights
    }

    /// The direction to the sun in light space; `None`, with a message, where it is below the
    /// horizon.
    fn sun(&mut self, object: &'a Object, transform: &Transform) -> Option<Vec3> {
        let given = object.has("sun_direction");
        let timed: Vec<&str> = MOMENT.into_iter().filter(|name| object.has(name)).collect();
        let sun = if given {
            if let Some(name) = timed.first() {
                let message = format!(
                    "`{}` and `{}` exclude each other",
                    spelling(object, "sun_direction"),
                    spelling(object, name)
                );
                self.out.diagnostics.error(object.span, message);
                object.ignore(&MOMENT);
            }
            let direction = self.vector(object, "sun_direction")?;
            match transform.inverse().vector(vec3(direction)).try_normalize() {
                Some(sun) => sun,
                None => {
                    let span = object.get("sun_direction").map(|p| p.value_span);
                    self.out.diagnostics.error(span, "the direction is zero");
                    return None;
                }
            }
        } else {
            toward_sun(&self.moment(object), old(object))
        };
        self.risen(object, sun)
    }

    /// The direction, or a message where it is below the horizon.
    fn risen(&mut self, object: &Object, sun: Vec3) -> Option<Vec3> {
        if sun.z >= 0.0 {
            return Some(sun);
        }
        let message = "the sun is below the horizon";
        match old(object) {
            true => self.out.diagnostics.error(object.span, message),
            false => self.out.diagnostics.warning(object.span, message).label("no light"),
        };
        None
    }

    fn moment(&mut self, object: &'a Object) -> Moment {
        let mut number =
            |name: &'static str, default: f32| f64::from(self.number(object, name, default));
        let [latitude, longitude] = [number("latitude", 35.6894), number("longitude", 139.6917)];
        let timezone = number("timezone", 9.0);
        let [minute, second] = [number("minute", 0.0), number("second", 0.0)];
        let hour = number("hour", 15.0) + (minute + second / 60.0) / 60.0;
        let mut integer = |name, default| self.integer(object, name).unwrap_or(default);
        let (year, month, day) = (integer("year", 2010), integer("month", 7), integer("day", 10));
        // Years in which the formula means something; far ones would overflow.
        let year = year.clamp(-4000, 10_000);
        Moment { latitude, longitude, timezone, year, month, day, hour }
    }

    /// A number in a range; one outside is an error, and clamped.
    fn within(
        &mut self,
        object: &'a Object,
        name: &'static str,
        default: f32,
        [low, high]: [f32; 2],
    ) -> f32 {
        let found = self.number(object, name, default);
        if !(low..=high).contains(&found) {
            let span = object.get(name).map(|p| p.span);
            let name = spelling(object, name);
            let message = format!("`{name}` must be in [{low}, {high}], found {found}");
            self.out.diagnostics.error(span, message);
            return default;
        }
        found
    }

    /// The reflectance of the ground.
    fn albedo(&mut self, object: &'a Object, default: f32) -> SpectrumDesc {
        let Some(p) = object.get("albedo") else { return SpectrumDesc::Constant(default) };
        let desc = match (self.plain_value(object, p, Role::Reflectance), self.target(p)) {
            (Some((desc, _)), _) => Some(desc),
            (None, Some(id)) => self.spectrum_object(id, Role::Reflectance).map(|(desc, _)| desc),
            (None, None) => None,
        };
        desc.unwrap_or_else(|| {
            self.wrong_type(object, p, "a number, colour or spectrum");
            SpectrumDesc::Constant(default)
        })
    }
}

/// The direction to the sun in light space.
pub(super) fn toward_sun(moment: &Moment, old: bool) -> Vec3 {
    let (zenith, azimuth) = moment.sun();
    let (sin, cos) = azimuth.sin_cos();
    // Azimuths count from north, which is -z by way of +x in 0.6, and from -x by way of -y in
    // Mitsuba 3.
    let [x, y] = if old { [sin, cos] } else { [-cos, -sin] };
    vec3([x * zenith.sin(), y * zenith.sin(), zenith.cos()])
}

/// The sun's disc of a radius in degrees, as much light as one of its true size; a directional
/// light if it has none.
fn sun_light(
    object: &Object,
    transform: Transform,
    sun: Vec3,
    turbidity: f32,
    radius: f32,
    scale: f32,
    stretch: f32,
) -> Option<(LightKind, Transform)> {
    let zenith = safe_acos(sun.z);
    let radiance = match old(object) {
        true => preetham_sun(turbidity, zenith),
        false => hosek_sun(turbidity, FRAC_PI_2 - zenith, (0.5 * APERTURE).to_radians()),
    };
    // The solid angle of a cone, 4π sin²(r/2).
    let solid_angle = |degrees: f32| 4.0 * PI * (0.5 * degrees.to_radians()).sin().powi(2);
    let (sin, cos) = (zenith * stretch).sin_cos();
    let around = Vec3::new(sun.x, sun.y, 0.0).try_normalize().unwrap_or(Vec3::X);
    let toward = around * sin + Vec3::Z * cos;
    let facing = |d: Vec3| {
        let (s, t) = d.coordinate_system();
        Transform::from_rows([
            [s.x, t.x, d.x, 0.0],
            [s.y, t.y, d.y, 0.0],
            [s.z, t.z, d.z, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ])
    };
    let whole = solid_angle(0.5 * APERTURE);
    if radius == 0.0 {
        let kind = LightKind::Directional {
            irradiance: radiance,
            scale: scale * whole,
            illuminance: None,
        };
        return Some((kind, transform * facing(-toward)?));
    }
    let kind = LightKind::Sun { radiance, scale: scale * whole / solid_angle(radius), radius };
    Some((kind, transform * facing(toward)?))
}

/// From +z up, azimuth from +y toward +x, to the emitter's space: in 0.6 +y is up, and azimuth
/// runs from -z toward +x.
fn z_up(old: bool) -> Transform {
    if !old {
        return Transform::IDENTITY;
    }
    let rows =
        [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    Transform::from_rows(rows).unwrap_or(Transform::IDENTITY)
}
