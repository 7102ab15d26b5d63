//! From a description and the user's choices to something that can render.

use kaustika_film::FilterDesc;
use kaustika_film::accumulate::{Feature, Layers};
use kaustika_math::Vec2;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::description::{FilterChoice, SceneDescription, SourceFormat};
use kaustika_scene::{LightSelectionKind, Scene, SceneOptions};
use kaustika_spectra::{ColorMode, ColorSpace, Sensor};
use kaustika_transport::Frame;
use kaustika_transport::method::Method;
use kaustika_transport::registry;
use serde_json::{Map, Value};

/// What the user chose; `None` and empty leave the file's value or the default.
#[derive(Clone, Debug, Default)]
pub struct RenderOptions {
    /// Method by name.
    pub method: Option<String>,
    /// Parameters of the method.
    pub parameters: Vec<(String, String)>,
    /// RGB or spectral.
    pub mode: Option<ColorMode>,
    /// Which camera, by name or number.
    pub camera: Option<String>,
    /// Width and height.
    pub resolution: Option<[u32; 2]>,
    /// Pixels rendered: x0, y0, x1, y1, end exclusive.
    pub crop: Option<[u32; 4]>,
    /// Sampler.
    pub sampler: Option<SamplerKind>,
    /// Reconstruction filter.
    pub filter: Option<FilterDesc>,
    /// Seed.
    pub seed: Option<u64>,
    /// Samples a pixel.
    pub spp: Option<u64>,
    /// Feature layers.
    pub features: Vec<Feature>,
    /// How lights are chosen.
    pub light_sampler: Option<LightSelectionKind>,
}

/// A scene, a frame and a method that fit each other.
pub struct Setup {
    /// The scene.
    pub scene: Scene,
    /// The picture.
    pub frame: Frame,
    /// The method.
    pub method: Box<dyn Method>,
    /// Samples a pixel that were asked for.
    pub spp: u64,
    /// Seed in use.
    pub seed: u64,
    /// Parameters the method was made with, for the record.
    pub parameters: Map<String, Value>,
}

/// Samples a pixel when nobody says how many.
const DEFAULT_SPP: u64 = 64;
/// Pictures larger than this are refused: 2^28 pixels are 16384 squared.
const MAX_PIXELS: u64 = 1 << 28;

impl Setup {
    /// Builds everything; the error is a message for the user.
    ///
    /// # Errors
    /// If the description or the options can't be rendered.
    pub fn new(description: &SceneDescription, options: &RenderOptions) -> Result<Setup, String> {
        let camera_number = choose_camera(description, options.camera.as_deref())?;
        let camera = &description.cameras[camera_number];
        let resolution = options.resolution.unwrap_or(camera.film.resolution);
        let pixels = resolution[0] as u64 * resolution[1] as u64;
        if pixels == 0 || pixels > MAX_PIXELS {
            let [w, h] = resolution;
            return Err(format!(
                "a picture of {w} x {h} pixels can't be rendered; choose at least 1 x 1 and at most 2^28 pixels in all"
            ));
        }
        let mode = options.mode.unwrap_or(match description.format {
            SourceFormat::Pbrt => ColorMode::Spectral,
            _ => ColorMode::Rgb,
        });
        let scene_options = SceneOptions {
            mode,
            camera: camera_number,
            resolution: Some(resolution),
            light_selection: options.light_sampler,
        };
        let scene = Scene::build(description, &scene_options).map_err(|e| e.to_string())?;

        let spp = options.spp.or(camera.spp).unwrap_or(DEFAULT_SPP);
        let seed = options.seed.unwrap_or(camera.seed);
        let kind = options
            .sampler
            .or_else(|| camera.sampler.as_deref().and_then(|s| s.parse().ok()))
            .unwrap_or(SamplerKind::Sobol);
        let filter = options.filter.unwrap_or_else(|| filter_of(&camera.film.filter));
        if let Some(defect) = filter.defect() {
            return Err(format!("the reconstruction filter can't be used: {defect}"));
        }
        let config = SamplerConfig { kind, seed, spp, resolution };
        let mut frame = Frame::new(resolution, filter, config);
        let crop = options.crop.or(camera.film.crop.filter(|_| options.resolution.is_none()));
        if let Some(crop) = crop {
            frame.region = checked_crop(crop, resolution)?;
        }
        let white = camera.film.white_balance.map(kaustika_spectra::daylight_chromaticity);
        frame.sensor = Sensor::new(ColorSpace::Srgb, camera.film.imaging_ratio, white);
        frame.max_component = camera.film.max_component;
        let mut features = options.features.clone();
        features.extend(camera.film.aovs.iter().filter_map(|a| a.parse::<Feature>().ok()));
        frame.layers = Layers::new(&features);

        let name = options.method.as_deref().unwrap_or("path");
        let entry = registry::find(name).ok_or_else(|| {
            let known: Vec<_> = registry::ALL.iter().map(|e| e.info.name).collect();
            format!("unknown method `{name}`; known: {}", known.join(", "))
        })?;
        let parameters = parameters(description, &(entry.parameters)(), &options.parameters);
        let method = (entry.make)(&parameters).map_err(|e| format!("method `{name}`: {e}"))?;
        Ok(Setup { scene, frame, method, spp, seed, parameters })
    }
}

fn choose_camera(description: &SceneDescription, wanted: Option<&str>) -> Result<usize, String> {
    let cameras = &description.cameras;
    if cameras.is_empty() {
        return Err("the scene has no camera".into());
    }
    let Some(wanted) = wanted else { return Ok(0) };
    if let Some(i) = cameras.iter().position(|c| c.name == wanted) {
        return Ok(i);
    }
    match wanted.parse::<usize>() {
        Ok(i) if i < cameras.len() => Ok(i),
        _ => {
            let known: Vec<String> = cameras
                .iter()
                .enumerate()
                .map(|(i, c)| if c.name.is_empty() { i.to_string() } else { c.name.clone() })
                .collect();
            Err(format!("no camera `{wanted}`; known: {}", known.join(", ")))
        }
    }
}

fn checked_crop(c: [u32; 4], [w, h]: [u32; 2]) -> Result<[u32; 4], String> {
    let crop = [c[0].min(w), c[1].min(h), c[2].min(w), c[3].min(h)];
    if crop[0] < crop[2] && crop[1] < crop[3] {
        Ok(crop)
    } else {
        Err(format!(
            "the crop window {},{},{},{} is empty within {w} x {h} pixels",
            c[0], c[1], c[2], c[3]
        ))
    }
}

/// The filter that a file asks for.
fn filter_of(choice: &FilterChoice) -> FilterDesc {
    let r = |r: &[f32; 2]| Vec2::new(r[0], r[1]);
    match choice {
        FilterChoice::Box { radius } => FilterDesc::Box { radius: r(radius) },
        FilterChoice::Triangle { radius } => FilterDesc::Tent { radius: r(radius) },
        FilterChoice::Gaussian { radius, sigma } => {
            FilterDesc::Gaussian { radius: r(radius), sigma: *sigma }
        }
        FilterChoice::Mitchell { radius, b, c } => {
            FilterDesc::Mitchell { radius: r(radius), b: *b, c: *c }
        }
        FilterChoice::LanczosSinc { radius, tau } => {
            FilterDesc::Lanczos { radius: r(radius), tau: *tau }
        }
    }
}

/// The file's values under the user's, as far as the method knows the keys.
fn parameters(
    description: &SceneDescription,
    known: &[registry::Parameter],
    given: &[(String, String)],
) -> Map<String, Value> {
    let file = &description.integrator;
    let mut map = Map::new();
    let mut set = |key: &str, value: Option<Value>| {
        if let (Some(v), true) = (value, known.iter().any(|p| p.key == key)) {
            map.insert(key.into(), v);
        }
    };
    set("max_depth", file.max_depth.map(Value::from));
    let rr_default = (description.format == SourceFormat::Pbrt).then_some(1);
    set("rr_depth", file.rr_depth.or(rr_default).map(Value::from));
    set("hide_emitters", file.hide_emitters.then_some(Value::from(true)));
    for (key, value) in given {
        map.insert(key.clone(), scalar(value));
    }
    map
}

/// A number or a truth value where it reads as one, else text.
fn scalar(text: &str) -> Value {
    match serde_json::from_str::<Value>(text) {
        Ok(v @ (Value::Number(_) | Value::Bool(_))) => v,
        _ => Value::String(text.into()),
    }
}
