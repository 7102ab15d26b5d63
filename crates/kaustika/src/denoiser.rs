//! Pictures without their noise: which filter, from which layers, and what the picture says of it.

use kaustika_film::accumulate::Feature;
use kaustika_film::denoise::{Features, Noisy, denoise};
use kaustika_film::{Channel, ChannelKind, MetaValue, Picture};
use std::str::FromStr;
use std::time::Instant;
use thiserror::Error;

/// A filter for finished pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Denoiser {
    /// [`kaustika_film::denoise`].
    Kaustika,
    /// Intel's Open Image Denoise.
    Oidn,
}

/// Why a picture can't be filtered.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum DenoiseError {
    /// This program was built without it.
    #[error(
        "this program was built without Intel's Open Image Denoise; build it with \
         `cargo build --release --features oidn` (docs/denoising.md), or use --denoise alone"
    )]
    NotBuilt,
    /// The picture has no colour.
    #[error("it has no channels R, G and B to take the noise out of")]
    NoColour,
    /// It was filtered before.
    #[error("it has a layer Noisy: the noise was taken out of it before")]
    Twice,
    /// The library's own words.
    #[error("Open Image Denoise: {0}")]
    Library(String),
}

impl FromStr for Denoiser {
    type Err = String;
    fn from_str(text: &str) -> Result<Denoiser, String> {
        match text {
            "kaustika" => Ok(Denoiser::Kaustika),
            "oidn" => Ok(Denoiser::Oidn),
            _ => Err("known: kaustika, oidn".into()),
        }
    }
}

impl Denoiser {
    /// The features it looks at.
    pub const FEATURES: [Feature; 3] = [Feature::Albedo, Feature::ShadingNormal, Feature::Depth];

    /// Asks whether this program has it.
    ///
    /// # Errors
    /// If it was built without.
    pub fn check(self) -> Result<(), DenoiseError> {
        match self {
            Denoiser::Oidn if !cfg!(feature = "oidn") => Err(DenoiseError::NotBuilt),
            _ => Ok(()),
        }
    }

    /// Puts the filtered colour in place of R, G, B, which become the layer `Noisy`; says in the
    /// metadata and returns in words what was done. Other layers, `Variance` and `StdError` among
    /// them, stay those of the noisy picture.
    ///
    /// # Errors
    /// If the picture has no R, G, B, has a layer `Noisy`, or the filter is not there.
    pub fn apply(self, picture: &mut Picture) -> Result<String, DenoiseError> {
        if picture.channel("Noisy.R").is_some() {
            return Err(DenoiseError::Twice);
        }
        let start = Instant::now();
        let (planes, name, note) = match self {
            Denoiser::Kaustika => own(picture)?,
            Denoiser::Oidn => oidn(picture)?,
        };
        for (name, data) in ["R", "G", "B"].into_iter().zip(planes) {
            let Some(channel) = picture.channels.iter_mut().find(|c| c.name == name) else {
                return Err(DenoiseError::NoColour);
            };
            let noisy = std::mem::replace(&mut channel.data, data);
            let (name, kind) = (format!("Noisy.{name}"), channel.kind);
            picture.channels.push(Channel { name, data: noisy, kind });
        }
        picture.set_meta("kaustika.denoised", MetaValue::Text(name.clone()));
        let seconds = start.elapsed().as_secs_f64();
        Ok(format!("denoised in {seconds:.2} s by {name}{note}"))
    }
}

/// R, G, B of a filtered picture, what filtered it, and what else there is to say.
type Filtered = ([Vec<f32>; 3], String, String);

/// The channels of a layer, if all are there.
fn layer<'a, const N: usize>(picture: &'a Picture, names: [&str; N]) -> Option<[&'a [f32]; N]> {
    let found = names.map(|name| picture.channel(name));
    found.iter().all(Option::is_some).then(|| found.map(Option::unwrap_or_default))
}

/// Albedo and normals, those for shading where there are any.
fn features(picture: &Picture) -> Features<'_> {
    let shading = layer(picture, ["Ns.X", "Ns.Y", "Ns.Z"]);
    Features {
        albedo: layer(picture, ["Albedo.R", "Albedo.G", "Albedo.B"]),
        normal: shading.or_else(|| layer(picture, ["N.X", "N.Y", "N.Z"])),
        depth: picture.channel("Depth.Z"),
    }
}

/// Which layers there are, in words.
fn led_by(features: &Features, variance: bool) -> String {
    let known = [
        ("albedo", features.albedo.is_some()),
        ("normal", features.normal.is_some()),
        ("depth", features.depth.is_some()),
        ("variance", variance),
    ];
    let names: Vec<&str> = known.iter().filter(|(_, is)| *is).map(|(name, _)| *name).collect();
    if names.is_empty() { "colour alone".into() } else { names.join(", ") }
}

fn own(picture: &Picture) -> Result<Filtered, DenoiseError> {
    let mean = layer(picture, ["R", "G", "B"]).ok_or(DenoiseError::NoColour)?;
    let samples = match picture.meta("samplesPerPixel") {
        Some(MetaValue::Int(n)) if *n > 1 => Some(*n as f32),
        _ => None,
    };
    let of_one = layer(picture, ["Variance.R", "Variance.G", "Variance.B"]);
    let of_mean = samples
        .zip(of_one)
        .map(|(n, planes)| planes.map(|plane| plane.iter().map(|v| v / n).collect::<Vec<f32>>()));
    let variance = of_mean.as_ref().map(|planes| planes.each_ref().map(Vec::as_slice));
    let features = features(picture);
    let (width, height) = (picture.width as usize, picture.height as usize);
    let done = denoise(&Noisy { width, height, mean, variance }, &features);
    let planes = std::array::from_fn(|c| done.pixels.iter().map(|p| p[c]).collect());
    let led = led_by(&features, variance.is_some());
    let name = format!("Kaustika's filter (local linear fits; {led})");
    let share = 100.0 * done.left_out;
    let note = match share >= 0.05 {
        true => format!("; {share:.1} % of the light was in outliers and is left out"),
        false => String::new(),
    };
    Ok((planes, name, note))
}

#[cfg(not(feature = "oidn"))]
fn oidn(_: &Picture) -> Result<Filtered, DenoiseError> {
    Err(DenoiseError::NotBuilt)
}

#[cfg(feature = "oidn")]
fn oidn(picture: &Picture) -> Result<Filtered, DenoiseError> {
    let mean = layer(picture, ["R", "G", "B"]).ok_or(DenoiseError::NoColour)?;
    let features = features(picture);
    let interleave = |planes: [&[f32]; 3]| -> Vec<f32> {
        (0..picture.pixel_count()).flat_map(|i| planes.map(|p| p[i])).collect()
    };
    let fail = |e: oidn::Error| DenoiseError::Library(e.to_string());
    let device = oidn::Device::new().map_err(fail)?;
    let mut filter = oidn::RayTracing::try_new(&device).map_err(fail)?;
    filter.hdr(true).image_dimensions(picture.width as usize, picture.height as usize);
    // The library takes a normal with an albedo only.
    match (features.albedo, features.normal) {
        (Some(albedo), Some(normal)) => {
            filter.albedo_normal(&interleave(albedo), &interleave(normal));
        }
        (Some(albedo), None) => {
            filter.albedo(&interleave(albedo));
        }
        _ => {}
    }
    let mut colour = interleave(mean);
    filter.filter_in_place(&mut colour).map_err(fail)?;
    let planes = std::array::from_fn(|c| colour.iter().skip(c).step_by(3).copied().collect());
    let depth = None;
    let normal = features.normal.filter(|_| features.albedo.is_some());
    let led = led_by(&Features { depth, normal, ..features }, false);
    Ok((planes, format!("Intel's Open Image Denoise ({led})"), String::new()))
}

/// Takes the layers out of a picture that were kept for the filter alone.
pub fn drop_features(picture: &mut Picture, features: &[Feature]) {
    let unwanted = |c: &Channel| features.iter().any(|f| f.channels().contains(&c.name.as_str()));
    picture.channels.retain(|c| c.kind == ChannelKind::Uint || !unwanted(c));
}
