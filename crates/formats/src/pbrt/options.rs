//! What stands before `WorldBegin`: camera, film, filter, sampler, integrator (pbrt-v4,
//! cameras.cpp, film.cpp, filters.cpp, samplers.cpp, cpu/integrators.cpp).

use super::build::Builder;
use super::entity::{CameraEntity, Entity, Place};
use kaustika_math::Transform;
use kaustika_scene::description::{
    BandsDesc, CameraDesc, CameraKind, FilmDesc, FilterChoice, FovAxis, GBufferSpace, Span,
};

const SAMPLERS: [&str; 7] =
    ["halton", "independent", "paddedsobol", "pmj02bn", "sobol", "stratified", "zsobol"];
const INTEGRATORS: [&str; 11] = [
    "ambientocclusion",
    "bdpt",
    "function",
    "lightpath",
    "mlt",
    "path",
    "randomwalk",
    "simplepath",
    "simplevolpath",
    "sppm",
    "volpath",
];
/// Most buckets of a spectral film: two a nanometre.
const MOST_BANDS: i32 = 940;
/// Layers of pbrt's gbuffer film.
const GBUFFER: [&str; 6] = ["albedo", "position", "normal", "sh_normal", "uv", "depth"];

impl Builder {
    /// Camera, film, sampler and integrator.
    pub fn options(&mut self) {
        self.accelerator();
        self.integrator();
        let camera = self.scene.camera.take().unwrap_or_else(|| CameraEntity {
            entity: default("perspective"),
            place: Place { transforms: [Transform::IDENTITY; 2], times: [0.0, 1.0] },
            medium: None,
        });
        let CameraEntity { entity: mut e, place, medium } = camera;
        let shutter = self.shutter(&mut e);
        let film_diagonal = 1e-3 * self.film_diagonal();
        let film = self.film(shutter[1] - shutter[0]);
        let kind = self.camera_kind(&mut e, film_diagonal);
        let what = format!("camera `{}`", e.kind.text);
        e.params.report_unused(&mut self.desc.diagnostics, &what);
        let (sampler, spp, seed) = self.sampler();
        let medium = self.medium(&medium);
        let span = (e.span != Span::default()).then_some(e.span);
        self.desc.cameras.push(CameraDesc {
            name: String::new(),
            kind,
            transform: place.transforms[0],
            motion: place.motion(),
            shutter,
            medium,
            film,
            sampler,
            spp: Some(spp),
            seed,
            span,
        });
    }

    fn shutter(&mut self, e: &mut Entity) -> [f32; 2] {
        let diag = &mut self.desc.diagnostics;
        let open = e.params.float(diag, "shutteropen", 0.0);
        let close = e.params.float(diag, "shutterclose", 1.0);
        if close <= open {
            let message = format!("the shutter opens at {open} and closes at {close}");
            diag.error(e.params.place("shutterclose"), message)
                .hint("`shutterclose` must be later than `shutteropen`");
            return [0.0, 1.0];
        }
        [open, close]
    }

    /// In millimetres.
    fn film_diagonal(&mut self) -> f32 {
        let diag = &mut self.desc.diagnostics;
        self.scene.film.as_mut().map_or(35.0, |f| f.params.float(diag, "diagonal", 35.0))
    }

    fn camera_kind(&mut self, e: &mut Entity, film_diagonal: f32) -> CameraKind {
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        let screen_window = match p.floats(diag, "screenwindow") {
            Some(w) if w.len() == 4 => Some([w[0], w[1], w[2], w[3]]),
            Some(w) => {
                let message = format!("`screenwindow` needs 4 numbers, {} given", w.len());
                diag.error(p.place("screenwindow"), message);
                None
            }
            None => None,
        };
        let aspect = p.float_or_none(diag, "frameaspectratio");
        // Aspect and window say the same; the window counts.
        let screen_window = screen_window.or(aspect
            .filter(|a| *a > 0.0)
            .map(|a| if a > 1.0 { [-a, a, -1.0, 1.0] } else { [-1.0, 1.0, -1.0 / a, 1.0 / a] }));
        if let Some([x0, x1, y0, y1]) = screen_window
            && (x0 == x1 || y0 == y1)
        {
            diag.error(p.place("screenwindow"), "the screen window is empty");
        }
        let lens_radius = p.float(diag, "lensradius", 0.0).max(0.0);
        let far = if e.kind.text == "spherical" { 1e30 } else { 1e6 };
        let focus_distance = p.float(diag, "focaldistance", far);
        let (near_clip, far_clip) = (0.0, f32::INFINITY);
        match e.kind.text.as_str() {
            "orthographic" => CameraKind::Orthographic {
                screen_window,
                unit_axis: FovAxis::Smaller,
                lens_radius,
                focus_distance,
                near_clip,
                far_clip,
            },
            "spherical" => {
                let mapping = p.string(diag, "mapping");
                let equal_area = match mapping.as_ref().map(|m| m.text.as_str()) {
                    None | Some("equalarea") => true,
                    Some("equirectangular") => false,
                    Some(other) => {
                        let span = mapping.as_ref().map_or(e.span, |m| m.span);
                        let message = format!("unknown mapping `{other}` of a spherical camera");
                        diag.error(span, message).nearest(other, &["equalarea", "equirectangular"]);
                        true
                    }
                };
                CameraKind::Spherical { equal_area }
            }
            kind => {
                let mut fov = 90.0;
                match kind {
                    "perspective" => fov = p.float(diag, "fov", 90.0),
                    "realistic" => {
                        if let Some(lens) = self.lens(e, film_diagonal) {
                            return CameraKind::Realistic(lens);
                        }
                        e.params.ignore_rest();
                    }
                    _ => {
                        let known = ["perspective", "orthographic", "spherical", "realistic"];
                        let message = format!("unknown camera `{kind}`");
                        diag.error(e.kind.span, message).nearest(kind, &known);
                        p.ignore_rest();
                    }
                }
                if !(fov > 0.0 && fov < 180.0) {
                    let message = format!("`fov` must lie between 0 and 180 degrees, not {fov}");
                    self.desc.diagnostics.error(e.params.place("fov"), message);
                    fov = 90.0;
                }
                CameraKind::Perspective {
                    fov,
                    fov_axis: FovAxis::Smaller,
                    principal_point: [0.0; 2],
                    screen_window,
                    lens_radius,
                    focus_distance,
                    near_clip,
                    far_clip,
                }
            }
        }
    }

    fn film(&mut self, exposure_time: f32) -> FilmDesc {
        let mut e = self.scene.film.take().unwrap_or_else(|| default("rgb"));
        let filter = self.filter();
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        let (mut aovs, mut bands, mut gbuffer) = (Vec::new(), None, None);
        match e.kind.text.as_str() {
            "rgb" => {}
            "gbuffer" => {
                aovs = GBUFFER.map(String::from).to_vec();
                let system = p.string(diag, "coordinatesystem");
                gbuffer = Some(GBufferSpace::Camera);
                match system.as_ref().map(|s| s.text.as_str()) {
                    None | Some("camera") => {}
                    Some("world") => gbuffer = Some(GBufferSpace::World),
                    Some(other) => {
                        let span = system.as_ref().map_or(e.span, |s| s.span);
                        diag.error(span, format!("unknown coordinate system `{other}`"))
                            .nearest(other, &["camera", "world"]);
                    }
                }
            }
            "spectral" => {
                let count = p.int(diag, "nbuckets", 16);
                let range = [("lambdamin", 360.0), ("lambdamax", 830.0)]
                    .map(|(name, default)| p.float(diag, name, default));
                if !(1..=MOST_BANDS).contains(&count) {
                    let message = format!("`nbuckets` must lie between 1 and {MOST_BANDS}");
                    diag.error(p.place("nbuckets"), message);
                } else if !(range[0] >= 360.0 && range[0] < range[1] && range[1] <= 830.0) {
                    let message = "wavelengths must rise, and lie between 360 and 830 nm";
                    diag.error(p.place("lambdamax"), message);
                } else {
                    bands = Some(BandsDesc::Bins { count: count as u32, range });
                }
            }
            kind => {
                let known = ["rgb", "gbuffer", "spectral"];
                diag.error(e.kind.span, format!("unknown film `{kind}`")).nearest(kind, &known);
            }
        }
        let x = p.int(diag, "xresolution", 1280);
        let y = p.int(diag, "yresolution", 720);
        if x < 1 || y < 1 {
            let message = format!("the film has {x} x {y} pixels");
            let hint = "`xresolution` and `yresolution` must be at least 1";
            diag.error(e.params.place("xresolution"), message).hint(hint);
        }
        let resolution = [x.max(1) as u32, y.max(1) as u32];
        let crop = self.crop(&mut e, resolution);
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        let iso = p.float(diag, "iso", 100.0);
        // Early pbrt-v4 had the exposure time in the film.
        let exposure_time = p.float(diag, "exposuretime", exposure_time);
        let white_balance = p.float(diag, "whitebalance", 0.0);
        if let Some(sensor) = p.string(diag, "sensor")
            && sensor.text != "cie1931"
        {
            let message =
                format!("sensor `{}` is not simulated, the CIE 1931 observer is used", sensor.text);
            diag.warning(sensor.span, message);
        }
        let max_component = p.float_or_none(diag, "maxcomponentvalue");
        p.float(diag, "diagonal", 35.0);
        p.boolean(diag, "savefp16", true);
        let filename = p.string(diag, "filename").map(|f| f.text);
        let what = format!("film `{}`", e.kind.text);
        e.params.report_unused(diag, &what);
        FilmDesc {
            resolution,
            crop,
            filter,
            filename,
            imaging_ratio: exposure_time * iso / 100.0,
            white_balance: (white_balance > 0.0).then_some(white_balance),
            max_component,
            aovs,
            bands,
            gbuffer,
        }
    }

    /// `pixelbounds` and `cropwindow`, both x0, x1, y0, y1; the window counts.
    fn crop(&mut self, e: &mut Entity, [w, h]: [u32; 2]) -> Option<[u32; 4]> {
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        let bounds = p.ints(diag, "pixelbounds");
        let window = p.floats(diag, "cropwindow");
        let (name, crop) = if let Some(c) = window {
            if c.len() != 4 {
                let message = format!("`cropwindow` needs 4 numbers, {} given", c.len());
                diag.error(p.place("cropwindow"), message);
                return None;
            }
            // Edges are rounded up, so that neighbouring windows share no pixel.
            let edge = |v: f32, n: u32| ((v.clamp(0.0, 1.0) * n as f32).ceil() as u32).min(n);
            let crop = [
                edge(c[0].min(c[1]), w),
                edge(c[2].min(c[3]), h),
                edge(c[0].max(c[1]), w),
                edge(c[2].max(c[3]), h),
            ];
            ("cropwindow", crop)
        } else if let Some(b) = bounds {
            if b.len() != 4 {
                let message = format!("`pixelbounds` needs 4 numbers, {} given", b.len());
                diag.error(p.place("pixelbounds"), message);
                return None;
            }
            let clamp = |v: i32, n: u32| (v.max(0) as u32).min(n);
            let crop = [clamp(b[0], w), clamp(b[2], h), clamp(b[1], w), clamp(b[3], h)];
            if crop.map(|v| v as i32) != [b[0], b[2], b[1], b[3]] {
                let message = "the pixel bounds reach beyond the film and are cut";
                diag.warning(p.place("pixelbounds"), message);
            }
            ("pixelbounds", crop)
        } else {
            return None;
        };
        if crop[0] >= crop[2] || crop[1] >= crop[3] {
            let hint: String = match name {
                "cropwindow" => "write x0 x1 y0 y1 as fractions of the film, from 0 to 1".into(),
                _ => format!("write x0 x1 y0 y1 in pixels within the film's {w} x {h}"),
            };
            diag.error(p.place(name), format!("`{name}` leaves no pixel")).hint(hint);
            return None;
        }
        (crop != [0, 0, w, h]).then_some(crop)
    }

    fn filter(&mut self) -> FilterChoice {
        let mut e = self.scene.filter.take().unwrap_or_else(|| default("gaussian"));
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        let known =
            [("box", 0.5), ("gaussian", 1.5), ("mitchell", 2.0), ("sinc", 4.0), ("triangle", 2.0)];
        let kind = known.iter().find(|(n, _)| *n == e.kind.text);
        let &(name, width) = kind.unwrap_or_else(|| {
            let message = format!("unknown filter `{}`", e.kind.text);
            diag.error(e.kind.span, message).nearest(&e.kind.text, &known.map(|(n, _)| n));
            &known[1]
        });
        let radius = [p.float(diag, "xradius", width), p.float(diag, "yradius", width)];
        if !radius.iter().all(|r| *r > 0.0) {
            let message = "the radius of the filter must be above 0";
            diag.error(p.place("xradius"), message);
        }
        let filter = match name {
            "box" => FilterChoice::Box { radius },
            "mitchell" => {
                let third = 1.0 / 3.0;
                let (b, c) = (p.float(diag, "B", third), p.float(diag, "C", third));
                FilterChoice::Mitchell { radius, b, c }
            }
            "sinc" => FilterChoice::LanczosSinc { radius, tau: p.float(diag, "tau", 3.0) },
            "triangle" => FilterChoice::Triangle { radius },
            _ => FilterChoice::Gaussian { radius, sigma: p.float(diag, "sigma", 0.5) },
        };
        p.report_unused(diag, &format!("filter `{name}`"));
        filter
    }

    /// Name, samples a pixel and seed.
    fn sampler(&mut self) -> (Option<String>, u64, u64) {
        let mut e = self.scene.sampler.take().unwrap_or_else(|| default("zsobol"));
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        let name = if SAMPLERS.contains(&e.kind.text.as_str()) {
            e.kind.text.clone()
        } else {
            let message = format!("unknown sampler `{}`, using `zsobol`", e.kind.text);
            diag.warning(e.kind.span, message).nearest(&e.kind.text, &SAMPLERS);
            "zsobol".to_string()
        };
        let seed = p.int(diag, "seed", self.scene.seed.unwrap_or(0));
        let samples = if name == "stratified" {
            p.boolean(diag, "jitter", true);
            let (x, y) = (p.int(diag, "xsamples", 4), p.int(diag, "ysamples", 4));
            x.max(1) as u64 * y.max(1) as u64
        } else {
            p.string(diag, "randomization");
            let usual = if name == "independent" { 4 } else { 16 };
            let samples = p.int(diag, "pixelsamples", usual);
            if samples < 1 {
                let message = format!("{samples} samples a pixel, using 1");
                diag.warning(p.place("pixelsamples"), message);
            }
            samples.max(1) as u64
        };
        p.report_unused(diag, &format!("sampler `{name}`"));
        // Ours under pbrt's name or under that of the same construction.
        let ours = match name.as_str() {
            "paddedsobol" => "sobol",
            "pmj02bn" => "pmj02",
            name => name,
        };
        (Some(ours.to_string()), samples, seed as u32 as u64)
    }

    fn integrator(&mut self) {
        let mut e = self.scene.integrator.take().unwrap_or_else(|| default("volpath"));
        let diag = &mut self.desc.diagnostics;
        let p = &mut e.params;
        if !INTEGRATORS.contains(&e.kind.text.as_str()) {
            let message = format!("unknown integrator `{}`, using `volpath`", e.kind.text);
            diag.warning(e.kind.span, message).nearest(&e.kind.text, &INTEGRATORS);
            e.kind.text = "volpath".to_string();
            p.int(diag, "maxdepth", 5);
            p.ignore_rest();
        }
        let depth = p.int(diag, "maxdepth", 5);
        if depth < 0 {
            diag.error(p.place("maxdepth"), format!("`maxdepth` is {depth}"));
        }
        let sampler = p.string(diag, "lightsampler");
        let light_sampler = sampler.and_then(|s| {
            let known = ["uniform", "power", "bvh", "exhaustive"];
            if known.contains(&s.text.as_str()) {
                return Some(s.text);
            }
            let message = format!("unknown light sampler `{}`, using `bvh`", s.text);
            diag.warning(s.span, message).nearest(&s.text, &known);
            None
        });
        if p.boolean(diag, "regularize", false) {
            let message = "`regularize` makes pictures wrong in favour of less noise, ignored";
            diag.warning(p.place("regularize"), message);
        }
        let name = e.kind.text.as_str();
        let further: &[&str] = match name {
            "simplepath" => &["samplelights", "samplebsdf"],
            "ambientocclusion" => &["cossample", "maxdistance"],
            "bdpt" => &["visualizestrategies", "visualizeweights"],
            "mlt" => &[
                "bootstrapsamples",
                "chains",
                "mutationsperpixel",
                "largestepprobability",
                "sigma",
            ],
            "sppm" => &["photonsperiteration", "radius", "seed"],
            "function" => &["function", "filename", "skipbad", "imagefilename"],
            _ => &[],
        };
        // Known, but ours are set on the command line.
        for q in p.own.iter_mut().filter(|q| further.contains(&q.name.as_str())) {
            q.used = true;
        }
        p.report_unused(diag, &format!("integrator `{name}`"));
        let integrator = &mut self.desc.integrator;
        integrator.name = name.to_string();
        integrator.max_depth = Some(depth.max(0) as u32);
        integrator.light_sampler = light_sampler;
        integrator.span = (e.span != Span::default()).then_some(e.span);
    }

    /// Ours is not chosen by the scene.
    fn accelerator(&mut self) {
        let Some(e) = self.scene.accelerator.take() else { return };
        let known = ["bvh", "kdtree"];
        if !known.contains(&e.kind.text.as_str()) {
            let message = format!("unknown accelerator `{}`, ignored", e.kind.text);
            let diag = &mut self.desc.diagnostics;
            diag.warning(e.kind.span, message).nearest(&e.kind.text, &known);
        }
    }
}

/// An entity that no file names.
fn default(kind: &str) -> Entity {
    let mut e = Entity::default();
    e.kind.text = kind.to_string();
    e
}
