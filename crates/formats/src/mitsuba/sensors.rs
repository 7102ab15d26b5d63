//! Cameras with film, filter and sampler.

use super::convert::{Converter, old};
use super::document::{Kind, Object, ObjectId, Value};
use super::shapes::mirror_x;
use super::textures::Role;
use kaustika_math::Transform;
use kaustika_scene::description::{
    BandsDesc, CameraDesc, CameraKind, FilmDesc, FilterChoice, FovAxis,
};

/// Cameras and meters.
const KNOWN: &[&str] = &[
    "perspective",
    "thinlens",
    "orthographic",
    "telecentric",
    "perspective_rdist",
    "spherical",
    "radiancemeter",
    "irradiancemeter",
    "fluxmeter",
    "distant",
    "batch",
];

/// Films that Mitsuba knows.
const FILMS: &[&str] = &["hdrfilm", "specfilm", "ldrfilm", "tiledhdrfilm", "mfilm"];

/// Film settings about the file that is written, which the command line decides here.
const FILE_SETTINGS: &[&str] = &[
    "file_format",
    "pixel_format",
    "component_format",
    "banner",
    "attach_log",
    "compensate",
    "channel_names",
    "sample_border",
    "high_quality_edges",
    "gamma",
    "exposure",
    "tonemap_method",
    "key",
    "burn",
    "digits",
    "variable",
    "filename",
    "srf",
];

impl<'a> Converter<'a> {
    /// A sensor that stands in the scene.
    pub(super) fn sensor(&mut self, id: ObjectId) {
        if let Some(camera) = self.camera(id, None) {
            self.out.cameras.push(camera);
        }
    }

    /// A sensor, perhaps one on a shape.
    pub(super) fn camera(&mut self, id: ObjectId, shape: Option<usize>) -> Option<CameraDesc> {
        let object = self.object(id);
        let (kind, transform, motion) = match self.meter(object, shape) {
            Some(meter) => {
                let (kind, transform) = meter?;
                (kind, transform, Vec::new())
            }
            None => {
                let (kind, turn) = self.optics(object)?;
                let (transform, mut motion) = self.placement(object, "to_world");
                motion.iter_mut().for_each(|key| key.transform = key.transform * turn);
                (kind, transform * turn, motion)
            }
        };
        let shutter = ["shutter_open", "shutter_close"].map(|n| self.number(object, n, 0.0));
        let film = self.film(object);
        let (sampler, spp, seed) = self.sampler(object);
        let medium = self.medium_around(object);
        object.ignore(&["srf"]);
        self.finish(id);
        Some(CameraDesc {
            name: object.id.clone(),
            kind,
            transform,
            motion,
            shutter,
            medium,
            film,
            sampler,
            spp,
            seed,
            span: Some(object.span),
        })
    }

    /// The optics, and the description's camera space to the sensor's.
    fn optics(&mut self, object: &'a Object) -> Option<(CameraKind, Transform)> {
        let plugin = object.plugin.as_str();
        match plugin {
            "perspective" | "thinlens" | "perspective_rdist" | "orthographic" | "telecentric" => {}
            "spherical" => {
                // To pbrt's spherical camera from 0.6's: (x, y, z) = (-z', y', -x').
                let rows = [
                    [0.0, 0.0, -1.0, 0.0],
                    [0.0, 1.0, 0.0, 0.0],
                    [-1.0, 0.0, 0.0, 0.0],
                    [0.0, 0.0, 0.0, 1.0],
                ];
                let turn = Transform::from_rows(rows)?;
                return Some((CameraKind::Spherical { equal_area: false }, turn));
            }
            "fluencemeter" => {
                self.replaced(object, "left out");
                return None;
            }
            _ => {
                self.unknown_plugin(object, KNOWN);
                return None;
            }
        }
        let far_clip = self.number(object, "far_clip", 1e4);
        let near_clip = self.number(object, "near_clip", 1e-2);
        let focus_distance = self.number(object, "focus_distance", far_clip);
        if plugin == "perspective_rdist" {
            let message = "the distortion of the lens is not supported";
            self.out.diagnostics.warning(object.type_span, message).label("left out");
            object.ignore(&["kc"]);
        }
        let lens_radius = match plugin {
            "thinlens" | "telecentric" => self.aperture(object, plugin == "thinlens"),
            _ => 0.0,
        };
        let kind = if matches!(plugin, "orthographic" | "telecentric") {
            CameraKind::Orthographic {
                screen_window: None,
                unit_axis: FovAxis::X,
                lens_radius,
                focus_distance,
                near_clip,
                far_clip,
            }
        } else {
            let (fov, fov_axis) = self.field_of_view(object);
            let principal_point = ["principal_point_offset_x", "principal_point_offset_y"]
                .map(|n| self.number(object, n, 0.0));
            CameraKind::Perspective {
                fov,
                fov_axis,
                principal_point,
                screen_window: None,
                lens_radius,
                focus_distance,
                near_clip,
                far_clip,
            }
        };
        Some((kind, mirror_x()))
    }

    fn aperture(&mut self, object: &'a Object, required: bool) -> f32 {
        match self.optional_number(object, "aperture_radius") {
            Some(radius) => radius,
            None => {
                if required && !object.has("aperture_radius") {
                    let message = "sensor `thinlens` needs `aperture_radius`";
                    self.out.diagnostics.error(object.span, message);
                }
                0.0
            }
        }
    }

    /// `fov` along `fov_axis`, or the diagonal of 36 mm film at `focal_length`, 50 mm by default.
    pub(super) fn field_of_view(&mut self, object: &'a Object) -> (f32, FovAxis) {
        let axes = [
            ("x", FovAxis::X),
            ("y", FovAxis::Y),
            ("smaller", FovAxis::Smaller),
            ("larger", FovAxis::Larger),
            ("diagonal", FovAxis::Diagonal),
        ];
        let axis = self.choice(object, "fov_axis", &axes, FovAxis::X);
        if object.has("fov") {
            if object.get("focal_length").is_some() {
                let message = "`fov` and `focal_length` exclude each other";
                self.out.diagnostics.error(object.span, message);
            }
            let fov = self.number(object, "fov", 50.0);
            if !(fov > 0.0 && fov < 180.0) {
                let span = object.get("fov").map(|p| p.value_span);
                self.out.diagnostics.error(span, "`fov` must lie between 0 and 180 degrees");
            }
            return (fov, axis);
        }
        let millimetres = self.focal_length(object);
        let diagonal = (36.0f32 * 36.0 + 24.0 * 24.0).sqrt();
        let fov = 2.0 * (diagonal / (2.0 * millimetres)).atan().to_degrees();
        (fov, FovAxis::Diagonal)
    }

    fn focal_length(&mut self, object: &'a Object) -> f32 {
        let Some((text, span)) = self.string(object, "focal_length") else { return 50.0 };
        let digits = text.trim().trim_end_matches("mm");
        match super::values::number(digits) {
            Ok(v) if v > 0.0 => v as f32,
            _ => {
                self.out
                    .diagnostics
                    .error(span, format!("expected a focal length like `50mm`, found `{text}`"));
                50.0
            }
        }
    }

    fn film(&mut self, sensor: &'a Object) -> FilmDesc {
        let gaussian = FilterChoice::Gaussian { radius: [2.0; 2], sigma: 0.5 };
        let mut film = FilmDesc::new([768, 576], gaussian);
        let Some((_, id)) = self.child(sensor, Kind::Film) else { return film };
        let object = self.object(id);
        if !FILMS.contains(&object.plugin.as_str()) {
            self.unknown_plugin(object, FILMS);
        }
        let matrix = object.plugin == "mfilm";
        let default = if matrix { [1, 1] } else { film.resolution };
        film.resolution =
            [self.size(object, "width", default[0]), self.size(object, "height", default[1])];
        film.crop = self.crop(object, film.resolution);
        if let Some((_, filter)) = self.child(object, Kind::Filter) {
            film.filter = self.filter(filter);
        }
        film.filename = object.get("filename").and_then(|p| match &p.value {
            Value::String(name) if old(object) => Some(name.clone()),
            _ => None,
        });
        if object.plugin == "specfilm" {
            film.bands = self.responses(object);
        }
        object.ignore(FILE_SETTINGS);
        self.finish(id);
        film
    }

    /// The responses of a `specfilm`, each under the name of its spectrum.
    fn responses(&mut self, film: &'a Object) -> Option<BandsDesc> {
        let mut list = Vec::new();
        for p in &film.parameters {
            let child = self.target(p).filter(|id| self.object(*id).kind == Kind::Texture);
            let scaled = match child {
                Some(id) => self.spectrum_object(id, Role::Unbounded),
                None if FILE_SETTINGS.contains(&p.name.as_str()) => None,
                None if !matches!(p.value, Value::Spectrum(_)) => None,
                None => self.plain_value(film, p, Role::Unbounded),
            };
            if let Some((desc, _)) = scaled {
                p.used.set(true);
                list.push((p.written.clone(), desc));
            } else if child.is_some() {
                self.wrong_type(film, p, "a spectrum");
            }
        }
        if list.is_empty() {
            let message = "film `specfilm` needs a response: `<spectrum name=\"...\">` inside";
            self.out.diagnostics.error(film.span, message);
            return None;
        }
        Some(BandsDesc::Responses(list))
    }

    fn size(&mut self, object: &'a Object, name: &'static str, default: u32) -> u32 {
        let Some(value) = self.integer(object, name) else { return default };
        // More than this is a mistake, and would not fit in memory.
        if (1..=1 << 20).contains(&value) {
            return value as u32;
        }
        let span = object.get(name).map(|p| p.value_span);
        self.out.diagnostics.error(span, format!("`{name}` must lie between 1 and {}", 1 << 20));
        default
    }

    fn crop(&mut self, object: &'a Object, resolution: [u32; 2]) -> Option<[u32; 4]> {
        let names = ["crop_offset_x", "crop_offset_y", "crop_width", "crop_height"];
        let given = names.iter().any(|n| object.has(n));
        let [x, y, w, h] = names.map(|n| self.integer(object, n));
        if !given {
            return None;
        }
        let (x, y) = (x.unwrap_or(0), y.unwrap_or(0));
        let (w, h) = (w.unwrap_or(resolution[0] as i64), h.unwrap_or(resolution[1] as i64));
        let inside = |o: i64, n: i64, all: u32| {
            o >= 0 && n > 0 && o.checked_add(n).is_some_and(|end| end <= all as i64)
        };
        if inside(x, w, resolution[0]) && inside(y, h, resolution[1]) {
            return Some([x, y, x + w, y + h].map(|v| v as u32));
        }
        self.out
            .diagnostics
            .error(object.span, "the crop window reaches beyond the film")
            .hint(format!("the film is {} x {}", resolution[0], resolution[1]));
        None
    }

    /// Mitsuba's filters and their radii.
    fn filter(&mut self, id: ObjectId) -> FilterChoice {
        let object = self.object(id);
        let known = ["box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos"];
        let choice = match object.plugin.as_str() {
            "box" => {
                let radius = if old(object) { self.number(object, "radius", 0.5) } else { 0.5 };
                FilterChoice::Box { radius: [radius; 2] }
            }
            "tent" => FilterChoice::Triangle { radius: [self.number(object, "radius", 1.0); 2] },
            "gaussian" => {
                let sigma = self.number(object, "stddev", 0.5);
                FilterChoice::Gaussian { radius: [4.0 * sigma; 2], sigma }
            }
            "mitchell" => FilterChoice::Mitchell {
                radius: [2.0; 2],
                b: self.number(object, "B", 1.0 / 3.0),
                c: self.number(object, "C", 1.0 / 3.0),
            },
            "catmullrom" => FilterChoice::Mitchell { radius: [2.0; 2], b: 0.0, c: 0.5 },
            "lanczos" => {
                let lobes = self.integer(object, "lobes").unwrap_or(3).clamp(1, 64) as f32;
                FilterChoice::LanczosSinc { radius: [lobes; 2], tau: lobes }
            }
            _ => {
                self.unknown_plugin(object, &known);
                FilterChoice::Gaussian { radius: [2.0; 2], sigma: 0.5 }
            }
        };
        self.finish(id);
        choice
    }

    /// The sampler under its name here, samples a pixel and seed.
    fn sampler(&mut self, sensor: &'a Object) -> (Option<String>, Option<u64>, u64) {
        let Some((_, id)) = self.child(sensor, Kind::Sampler) else { return (None, None, 0) };
        let object = self.object(id);
        // Left Mitsuba's name, right the sampler here that spreads its points in the same way.
        let names = [
            ("independent", "independent"),
            ("stratified", "stratified"),
            ("multijitter", "pmj02"),
            ("orthogonal", "pmj02"),
            ("ldsampler", "pmj02"),
            ("halton", "halton"),
            ("hammersley", "halton"),
            ("faure", "halton"),
            ("sobol", "sobol"),
        ];
        let name = names.iter().find(|(theirs, _)| *theirs == object.plugin).map(|(_, ours)| *ours);
        if name.is_none() {
            let known: Vec<&str> = names.iter().map(|(theirs, _)| *theirs).collect();
            self.out
                .diagnostics
                .warning(object.type_span, format!("unknown sampler `{}`", object.plugin))
                .nearest(&object.plugin, &known);
        }
        let spp = self.integer(object, "sample_count").unwrap_or(4);
        let spp = u64::try_from(spp).ok().filter(|n| *n > 0).unwrap_or_else(|| {
            let span = object.get("sample_count").map(|p| p.value_span);
            self.out.diagnostics.error(span, "`sample_count` must be positive");
            4
        });
        let seed = self.integer(object, "seed").unwrap_or(0);
        object.ignore(&["jitter", "strength", "dimension", "scramble"]);
        self.finish(id);
        // Seeds are bits: negative ones are as good as others.
        (name.map(str::to_string), Some(spp), seed as u64)
    }
}
