//! From a description and the user's choices to something that can render.

use crate::denoiser::Denoiser;
use crate::fingerprint;
use crate::record::Record;
use kaustika_film::FilterDesc;
use kaustika_film::accumulate::{Bands, Feature, Layers};
use kaustika_film::path_expression::{ExpressionError, PathClasses, PathLayer};
use kaustika_math::Vec2;
use kaustika_sampling::{SamplerConfig, SamplerKind};
use kaustika_scene::description::{
    FilterChoice, GBufferSpace, SceneDescription, SourceFormat, Span,
};
use kaustika_scene::{BuildError, LightSelectionKind, Scene, SceneOptions};
use kaustika_spectra::{ColorMode, ColorSpace, Sensor};
use kaustika_transport::Frame;
use kaustika_transport::method::Method;
use kaustika_transport::registry;
use serde_json::{Map, Value};
use thiserror::Error;

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
    /// Part of the picture to render.
    pub crop: Option<Crop>,
    /// Sampler.
    pub sampler: Option<SamplerKind>,
    /// Reconstruction filter.
    pub filter: Option<FilterDesc>,
    /// Seed.
    pub seed: Option<u64>,
    /// Samples a pixel.
    pub spp: Option<u64>,
    /// Layers by path, as `NAME=EXPRESSION`.
    pub path_layers: Vec<String>,
    /// Feature layers.
    pub features: Vec<Feature>,
    /// How lights are chosen.
    pub light_sampler: Option<LightSelectionKind>,
    /// A filter that will look at more features.
    pub denoiser: Option<Denoiser>,
}

/// A part of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Crop {
    /// x0, y0, x1, y1 in pixels, end exclusive; what lies outside the picture is cut off.
    Pixels([u32; 4]),
    /// x0, y0, x1, y1 in fractions of the picture (pbrt's crop window, its order of numbers
    /// apart): the pixels from ⌈w x0⌉ up to ⌈w x1⌉.
    Fractions([f32; 4]),
}

/// Why nothing can be rendered.
#[derive(Clone, Debug, Error)]
pub enum SetupError {
    /// The scene is at fault.
    #[error(transparent)]
    Scene(#[from] BuildError),
    /// A choice of the user does not exist or does not fit; the text lists what does.
    #[error("{0}")]
    Choice(String),
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
    /// What decides the picture's bits.
    pub record: Record,
    /// Features that are kept for the filter alone.
    pub unasked: Vec<Feature>,
    /// What of the file's the method takes no notice of, for the user to know.
    pub notes: Vec<String>,
}

/// Samples a pixel when nobody says how many.
const DEFAULT_SPP: u64 = 64;
/// Pictures larger than this are refused: 2^28 pixels are 16384 squared.
const MAX_PIXELS: u64 = 1 << 28;

impl Setup {
    /// Builds everything.
    ///
    /// # Errors
    /// If the description or the options can't be rendered.
    pub fn new(
        description: &SceneDescription,
        options: &RenderOptions,
    ) -> Result<Setup, SetupError> {
        // Cheap questions first: building a scene may take minutes.
        let name = options.method.as_deref().unwrap_or("path");
        let entry = find_method(name)?;
        let known = (entry.parameters)();
        let parameters = parameters(description, &known, &options.parameters);
        let method = (entry.make)(&parameters).or_else(|e| {
            check_parameters(entry, &options.parameters)?;
            Err(SetupError::Choice(format!("method `{name}`: {e}")))
        })?;

        let camera_number = choose_camera(description, options.camera.as_deref())?;
        let camera = &description.cameras[camera_number];
        let resolution = options.resolution.unwrap_or(camera.film.resolution);
        let pixels = resolution[0] as u64 * resolution[1] as u64;
        if pixels == 0 || pixels > MAX_PIXELS {
            let [w, h] = resolution;
            let message = format!(
                "a picture of {w} x {h} pixels can't be rendered; choose at least 1 x 1 and at most 2^28 pixels in all"
            );
            return Err(match options.resolution {
                Some(_) => SetupError::Choice(message),
                None => BuildError { message, span: camera.span }.into(),
            });
        }

        let spp = options.spp.or(camera.spp).unwrap_or(DEFAULT_SPP);
        let seed = options.seed.unwrap_or(camera.seed);
        let kind = options
            .sampler
            .or_else(|| camera.sampler.as_deref().and_then(|s| s.parse().ok()))
            .unwrap_or(SamplerKind::Sobol);
        let filter = options.filter.unwrap_or_else(|| filter_of(&camera.film.filter));
        if let Some(defect) = filter.defect() {
            let message = format!("the reconstruction filter can't be used: {defect}");
            return Err(SetupError::Choice(message));
        }
        let mut frame =
            Frame::new(resolution, filter, SamplerConfig { kind, seed, spp, resolution });
        let of_file = camera.film.crop.filter(|_| options.resolution.is_none());
        if let Some(crop) = options.crop.or(of_file.map(Crop::Pixels)) {
            frame.region = checked_crop(crop, resolution)?;
        }
        let white = camera.film.white_balance.map(kaustika_spectra::daylight_chromaticity);
        frame.sensor = Sensor::new(ColorSpace::Srgb, camera.film.imaging_ratio, white);
        frame.max_component = camera.film.max_component;
        let mut features = options.features.clone();
        features.extend(camera.film.aovs.iter().filter_map(|a| a.parse::<Feature>().ok()));
        let polarized = parameters.get("polarized") == Some(&Value::Bool(true));
        if polarized {
            features.push(Feature::Stokes);
        } else if features.contains(&Feature::Stokes) {
            let message = "the layer `stokes` needs a polarized render: `-p polarized=true`";
            return Err(SetupError::Choice(message.into()));
        }
        if features.contains(&Feature::Trees) && !method.grows_trees() {
            let message = "the layer `trees` needs a method whose paths branch: `-m guided`, or `path` \
                           with `-p roulette=adjoint`, `efficiency` or `szirmay-kalos`";
            return Err(SetupError::Choice(message.into()));
        }
        let guides = options.denoiser.map_or(&[][..], |_| &Denoiser::FEATURES);
        let unasked: Vec<Feature> =
            guides.iter().copied().filter(|g| !features.contains(g)).collect();
        features.extend(&unasked);
        frame.layers = Layers::new(&features);
        if !options.path_layers.is_empty() {
            let choice = |e: ExpressionError| SetupError::Choice(format!("--layer: {e}"));
            let layers = options.path_layers.iter().map(|l| PathLayer::parse_all(l));
            let layers: Vec<Vec<PathLayer>> = layers.collect::<Result<_, _>>().map_err(choice)?;
            frame.keep_paths(PathClasses::new(layers.concat()).map_err(choice)?);
        }
        let of_method = method.layers();
        frame.keep_layers(&of_method);

        let mode = options.mode.or(method.mode()).unwrap_or(match description.format {
            _ if camera.film.bands.is_some() => ColorMode::Spectral,
            SourceFormat::Pbrt => ColorMode::Spectral,
            _ => ColorMode::Rgb,
        });
        if let Some(desc) = &camera.film.bands {
            if name != "path" || mode == ColorMode::Rgb {
                let message = "the scene's film keeps channels by wavelength, which needs the \
                               method `path` and spectral mode: use them, or another film";
                return Err(SetupError::Choice(message.into()));
            }
            let bands = Bands::new(desc);
            frame.layers = frame.layers.with_bands(bands.names().len());
            frame.bands = Some(bands);
        }
        let scene_options = SceneOptions {
            mode,
            camera: camera_number,
            resolution: Some(resolution),
            light_selection: options.light_sampler,
        };
        let scene = Scene::build(description, &scene_options)?;
        let main_file = description.sources.files.first();
        let record = Record {
            version: env!("CARGO_PKG_VERSION").into(),
            scene: main_file.map_or("built-in".into(), |f| f.path.display().to_string()),
            fingerprint: fingerprint::of_scene(description),
            method: name.into(),
            parameters: parameters.clone(),
            mode: format!("{mode:?}").to_lowercase(),
            camera: camera_number,
            resolution,
            region: frame.region,
            sampler: kind.name().into(),
            planned_spp: depends_on_plan(kind).then_some(spp),
            seed,
            filter: filter.to_string(),
            light_sampler: options.light_sampler.map(|l| format!("{l:?}").to_lowercase()),
            layers: frame.layers.features().iter().map(Feature::to_string).collect(),
            bands: frame.bands.as_ref().map_or(Vec::new(), |b| b.names().to_vec()),
            gbuffer: camera.film.gbuffer.map(|space| space == GBufferSpace::Camera),
            path_layers: frame
                .paths
                .iter()
                .flat_map(|classes| classes.layers().iter().map(PathLayer::to_string))
                .chain(of_method)
                .collect(),
            world_to_camera: camera.transform.inv,
        };
        let notes = unlimited(description, entry).into_iter().collect();
        Ok(Setup { scene, frame, method, spp, seed, parameters, record, unasked, notes })
    }
}

/// The method's entry in the registry.
///
/// # Errors
/// If there is none of this name; the message lists them.
pub fn find_method(name: &str) -> Result<&'static registry::Entry, SetupError> {
    registry::find(name).ok_or_else(|| {
        let known: Vec<_> = registry::ALL.iter().map(|e| e.info.name).collect();
        SetupError::Choice(format!("unknown method `{name}`; known: {}", known.join(", ")))
    })
}

/// True if another planned number of samples gives other points.
fn depends_on_plan(kind: SamplerKind) -> bool {
    match kind {
        SamplerKind::Independent | SamplerKind::Halton | SamplerKind::Sobol => false,
        SamplerKind::Stratified | SamplerKind::ZSobol | SamplerKind::Pmj02 => true,
    }
}

fn choose_camera(
    description: &SceneDescription,
    wanted: Option<&str>,
) -> Result<usize, SetupError> {
    let cameras = &description.cameras;
    if cameras.is_empty() {
        let message =
            "nothing can be rendered without a camera; in a Mitsuba file that is a `<sensor>`"
                .into();
        let start_of_file = Span { file: 0, start: 0, end: 0 };
        let span = description.sources.files.first().map(|_| start_of_file);
        return Err(BuildError { message, span }.into());
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
            Err(SetupError::Choice(format!("no camera `{wanted}`; known: {}", known.join(", "))))
        }
    }
}

fn checked_crop(crop: Crop, [w, h]: [u32; 2]) -> Result<[u32; 4], SetupError> {
    let c = match crop {
        Crop::Pixels(c) => c,
        Crop::Fractions(f) => {
            let edge = |f: f32, n: u32| (f * n as f32).ceil().max(0.0) as u32;
            [edge(f[0], w), edge(f[1], h), edge(f[2], w), edge(f[3], h)]
        }
    };
    let cut = [c[0].min(w), c[1].min(h), c[2].min(w), c[3].min(h)];
    if cut[0] < cut[2] && cut[1] < cut[3] {
        return Ok(cut);
    }
    let [x0, y0, x1, y1] = c;
    let message = format!("the crop window {x0},{y0},{x1},{y1} is empty within {w} x {h} pixels");
    Err(SetupError::Choice(message))
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
    set("rr_depth", file.rr_depth.map(Value::from));
    set("hide_emitters", file.hide_emitters.then_some(Value::from(true)));
    set("polarized", file.polarized.then_some(Value::from(true)));
    for (key, value) in given {
        map.insert(key.clone(), registry::scalar(value));
    }
    map
}

/// A note where the file limits the bounces of a method that knows no limit: its picture is brighter than that of those that do.
fn unlimited(description: &SceneDescription, entry: &registry::Entry) -> Option<String> {
    let most = description.integrator.max_depth?;
    let knows = entry.knows("max_depth").is_ok();
    let of_any_length = entry.info.path_class.contains('*');
    (of_any_length && !knows).then(|| {
        let name = entry.info.name;
        format!(
            "the file's limit of {most} bounces is not obeyed: `{name}` follows light to any number"
        )
    })
}

/// Each parameter of the user's on its own, so that the wrong one can be named. What is wrong alone may be
/// right together with others.
fn check_parameters(entry: &registry::Entry, given: &[(String, String)]) -> Result<(), SetupError> {
    let method = entry.info.name;
    let all =
        Map::from_iter(given.iter().map(|(key, value)| (key.clone(), registry::scalar(value))));
    let fit = (entry.make)(&all).is_ok();
    for (key, value) in given {
        entry.knows(key).map_err(SetupError::Choice)?;
        let alone = Map::from_iter([(key.clone(), registry::scalar(value))]);
        if let (false, Err(e)) = (fit, (entry.make)(&alone)) {
            let message = format!("parameter `{key}` of method `{method}`: {e}");
            return Err(SetupError::Choice(message));
        }
    }
    Ok(())
}
