//! How a picture is made: what its metadata say, and what shares of one render must agree on.

use kaustika_film::{MetaValue, Picture};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// Everything that decides the bits of a pass, and what a reader of the picture wants to know.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Version of the program.
    pub version: String,
    /// The scene file as it was named; `built-in` without one.
    pub scene: String,
    /// [`crate::fingerprint::of_scene`].
    pub fingerprint: String,
    /// Method by name.
    pub method: String,
    /// The method's parameters as far as they were set.
    pub parameters: Map<String, Value>,
    /// `rgb` or `spectral`.
    pub mode: String,
    /// Number of the camera in the scene.
    pub camera: usize,
    /// Width and height of the whole picture.
    pub resolution: [u32; 2],
    /// Pixels rendered: x0, y0, x1, y1, end exclusive.
    pub region: [u32; 4],
    /// Sampler by name.
    pub sampler: String,
    /// Samples the sampler plans for; `None` where its points do not depend on it.
    pub planned_spp: Option<u64>,
    /// Seed.
    pub seed: u64,
    /// Reconstruction filter with its parameters.
    pub filter: String,
    /// How lights are chosen, if the user said.
    pub light_sampler: Option<String>,
    /// Feature layers by name.
    pub layers: Vec<String>,
    /// Channels by wavelength, by name.
    #[serde(default)]
    pub bands: Vec<String>,
    /// pbrt's gbuffer film: true if its positions and normals are in the camera's space.
    #[serde(default)]
    pub gbuffer: Option<bool>,
    /// Layers by path, as `NAME=EXPRESSION`, and names of those that the method adds.
    #[serde(default)]
    pub path_layers: Vec<String>,
    /// The camera's transform, row by row.
    pub world_to_camera: [[f32; 4]; 4],
}

impl Record {
    /// What forbids putting passes of `other` and of this together, as "NAME: THIS here, OTHER
    /// there"; `None` if nothing does. The path of the scene may differ, its contents may not.
    pub fn difference(&self, other: &Record) -> Option<String> {
        let size = |r: &[u32; 2]| format!("{} x {}", r[0], r[1]);
        let region = |r: &[u32; 4]| format!("{},{},{},{}", r[0], r[1], r[2], r[3]);
        let json = |r: &Record| Value::Object(r.parameters.clone()).to_string();
        let plan = |r: &Record| r.planned_spp.map_or("none".into(), |n: u64| n.to_string());
        let lights = |r: &Record| r.light_sampler.clone().unwrap_or("as the scene says".into());
        let pairs = [
            ("version of Kaustika", self.version.clone(), other.version.clone()),
            ("method", self.method.clone(), other.method.clone()),
            ("parameters", json(self), json(other)),
            ("seed", self.seed.to_string(), other.seed.to_string()),
            ("sampler", self.sampler.clone(), other.sampler.clone()),
            ("samples planned", plan(self), plan(other)),
            ("filter", self.filter.clone(), other.filter.clone()),
            ("mode", self.mode.clone(), other.mode.clone()),
            ("camera", self.camera.to_string(), other.camera.to_string()),
            ("resolution", size(&self.resolution), size(&other.resolution)),
            ("crop", region(&self.region), region(&other.region)),
            ("light sampler", lights(self), lights(other)),
            ("layers", self.layers.join(","), other.layers.join(",")),
            ("spectral film", self.bands.join(" "), other.bands.join(" ")),
            ("layers by path", self.path_layers.join(" "), other.path_layers.join(" ")),
        ];
        if let Some((name, here, there)) = pairs.iter().find(|(_, a, b)| a != b) {
            return Some(format!("another {name}: {here} here, {there} there"));
        }
        (self.fingerprint != other.fingerprint).then(|| match self.scene == other.scene {
            true => format!("another scene: {} has changed in between", self.scene),
            false => format!("another scene: {} and {} differ", self.scene, other.scene),
        })
    }

    /// Width and height of the rendered region.
    pub fn size(&self) -> [u32; 2] {
        let [x0, y0, x1, y1] = self.region;
        [x1.saturating_sub(x0), y1.saturating_sub(y0)]
    }

    /// Writes it into a picture's metadata, windows included. Names are pbrt's where it has one.
    pub fn describe(&self, picture: &mut Picture, passes: u64, seconds: f64) {
        let [x0, y0, ..] = self.region;
        let [w, h] = self.resolution;
        picture.display_window = Some([0, 0, w as i32, h as i32]);
        picture.data_origin = [x0 as i32, y0 as i32];
        let text = [
            ("generatedBy", format!("Kaustika {}", self.version)),
            ("kaustika.scene", self.scene.clone()),
            ("kaustika.method", self.method.clone()),
            ("kaustika.parameters", Value::Object(self.parameters.clone()).to_string()),
            ("kaustika.mode", self.mode.clone()),
            ("kaustika.sampler", self.sampler.clone()),
            ("kaustika.seed", self.seed.to_string()),
            ("kaustika.filter", self.filter.clone()),
        ];
        let spectral = [("spectralLayoutVersion", "1.0"), ("emissiveUnits", "W.m^-2.sr^-1")];
        let in_bins = self.bands.iter().any(|name| name.starts_with("S0."));
        for (key, value) in spectral.into_iter().filter(|_| in_bins) {
            picture.set_meta(key, MetaValue::Text(value.into()));
        }
        let paths = self.path_layers.iter().filter_map(|layer| layer.split_once('='));
        let paths = paths.map(|(name, text)| (format!("kaustika.layer.{name}"), text.to_owned()));
        for (key, value) in text.map(|(k, v)| (k.to_owned(), v)).into_iter().chain(paths) {
            picture.set_meta(key, MetaValue::Text(value));
        }
        picture.set_meta("samplesPerPixel", MetaValue::Int(passes.min(i32::MAX as u64) as i32));
        picture.set_meta("renderTimeSeconds", MetaValue::Float(seconds as f32));
        let mut matrix = [0.0; 16];
        for (m, v) in matrix.iter_mut().zip(self.world_to_camera.iter().flatten()) {
            *m = *v;
        }
        picture.set_meta("worldToCamera", MetaValue::Matrix(matrix));
    }
}
