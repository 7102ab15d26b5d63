//! Which values a render keeps for each pixel.

use std::fmt;
use std::str::FromStr;

/// A value of the first surface a camera path meets (after passing through nothing).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Feature {
    /// Directional albedo as linear RGB; 1 where light is met, 0 where nothing is.
    Albedo,
    /// Geometric normal in world space, on the front of the surface; in pbrt's scenes on the
    /// viewer's side.
    Normal,
    /// Shading normal in world space, bump and normal maps included, on the same side.
    ShadingNormal,
    /// Distance from the camera along the ray.
    Depth,
    /// World-space position.
    Position,
    /// Surface parameters.
    Uv,
    /// Number of the shape, from 1; 0 for nothing. Of one sample, never averaged.
    ShapeId,
    /// Number of the material, from 1; 0 for nothing. Of one sample, never averaged.
    MaterialId,
    /// Stokes vector of the light that arrives, S₀ to S₃ as linear RGB each, in the frame of the
    /// picture: S₁ along its rows. Not of the first surface; only polarized rendering knows it.
    Stokes,
    /// What roulette and splitting did to a sample's paths: the factor q at the first surface, copies
    /// that splits added, paths that roulette ended, bounces of the longest path, rays traced. Only
    /// methods whose paths branch know it.
    Trees,
}

impl Feature {
    /// Those of the first surface, in the order of their channels.
    pub const FIRST_SURFACE: [Feature; 8] = [
        Feature::Albedo,
        Feature::Normal,
        Feature::ShadingNormal,
        Feature::Depth,
        Feature::Position,
        Feature::Uv,
        Feature::ShapeId,
        Feature::MaterialId,
    ];

    /// All features, in the order of their channels.
    pub fn all() -> impl Iterator<Item = Feature> {
        Feature::FIRST_SURFACE.into_iter().chain([Feature::Stokes, Feature::Trees])
    }

    /// EXR channel names, as pbrt-v4's G-buffer has them where it has them; as Mitsuba 3's for
    /// polarization.
    pub fn channels(self) -> &'static [&'static str] {
        match self {
            Feature::Albedo => &["Albedo.R", "Albedo.G", "Albedo.B"],
            Feature::Normal => &["N.X", "N.Y", "N.Z"],
            Feature::ShadingNormal => &["Ns.X", "Ns.Y", "Ns.Z"],
            Feature::Depth => &["Depth.Z"],
            Feature::Position => &["P.X", "P.Y", "P.Z"],
            Feature::Uv => &["u", "v"],
            Feature::ShapeId => &["ShapeId"],
            Feature::MaterialId => &["MaterialId"],
            Feature::Stokes => &[
                "S0.R", "S0.G", "S0.B", "S1.R", "S1.G", "S1.B", "S2.R", "S2.G", "S2.B", "S3.R",
                "S3.G", "S3.B",
            ],
            Feature::Trees => {
                &["Trees.Factor", "Trees.Added", "Trees.Ended", "Trees.Length", "Trees.Rays"]
            }
        }
    }

    /// True for numbers that name something: the first pass's value is kept.
    pub fn is_id(self) -> bool {
        matches!(self, Feature::ShapeId | Feature::MaterialId)
    }

    fn name(self) -> &'static str {
        match self {
            Feature::Albedo => "albedo",
            Feature::Normal => "normal",
            Feature::ShadingNormal => "sh_normal",
            Feature::Depth => "depth",
            Feature::Position => "position",
            Feature::Uv => "uv",
            Feature::ShapeId => "shape_id",
            Feature::MaterialId => "material_id",
            Feature::Stokes => "stokes",
            Feature::Trees => "trees",
        }
    }
}

impl fmt::Display for Feature {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Feature {
    type Err = String;
    fn from_str(s: &str) -> Result<Feature, String> {
        let named = |f: &Feature| f.name() == s.trim();
        Feature::all().find(named).ok_or_else(|| {
            let known: Vec<_> = Feature::all().map(Feature::name).collect();
            format!("unknown feature layer `{s}`; known: {}", known.join(", "))
        })
    }
}

/// The layout of a pixel: r, g, b, the filter weight, the features in order, r, g, b of each layer
/// by path, then two sums for each of the [`Bands`](super::Bands).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Layers {
    features: Vec<Feature>,
    paths: Vec<String>,
    bands: usize,
}

impl Layers {
    /// The beauty image and these features (each once).
    pub fn new(features: &[Feature]) -> Layers {
        let mut features = features.to_vec();
        features.sort();
        features.dedup();
        Layers { features, paths: Vec::new(), bands: 0 }
    }

    /// With this number of bands.
    pub fn with_bands(self, bands: usize) -> Layers {
        Layers { bands, ..self }
    }

    /// Offset of the bands' first sum within a pixel.
    pub fn offset_of_bands(&self) -> usize {
        self.stride() - 2 * self.bands
    }

    /// And layers of some paths by name; see [`crate::path_expression`].
    pub fn with_paths(self, names: Vec<String>) -> Layers {
        Layers { paths: names, ..self }
    }

    /// Names of the layers by path.
    pub fn paths(&self) -> &[String] {
        &self.paths
    }

    /// Offset of the first number of layer by path `k` within a pixel.
    pub fn path_offset(&self, k: usize) -> usize {
        4 + self.feature_numbers() + 3 * k
    }

    fn feature_numbers(&self) -> usize {
        self.features.iter().map(|f| f.channels().len()).sum()
    }

    /// The features.
    pub fn features(&self) -> &[Feature] {
        &self.features
    }

    /// Numbers a pixel: colour, weight, features, layers by path and bands.
    pub fn stride(&self) -> usize {
        4 + self.feature_numbers() + 3 * self.paths.len() + 2 * self.bands
    }

    /// Offset of a feature's first number within a pixel.
    pub fn offset(&self, feature: Feature) -> Option<usize> {
        let mut at = 4;
        for f in &self.features {
            if *f == feature {
                return Some(at);
            }
            at += f.channels().len();
        }
        None
    }
}
