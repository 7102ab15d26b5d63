//! Values on the command line.

use kaustika::film::accumulate::Feature;
use kaustika::film::metrics::VarianceSpace;
use kaustika::spectra::Tonemap;
use std::str::FromStr;

/// Feature layers; `all` are those of the first surface.
#[derive(Clone, Debug)]
pub struct FeatureList(pub Vec<Feature>);

impl FromStr for FeatureList {
    type Err = String;
    fn from_str(text: &str) -> Result<FeatureList, String> {
        match text {
            "all" => Ok(FeatureList(Feature::FIRST_SURFACE.to_vec())),
            _ => text.split(',').map(str::parse).collect::<Result<_, _>>().map(FeatureList),
        }
    }
}

/// KEY=VALUE.
pub fn key_value(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() => Ok((key.trim().into(), value.into())),
        _ => Err("expected KEY=VALUE".into()),
    }
}

/// A whole number.
pub fn whole<T: FromStr>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| "expected a whole number from 0".into())
}

/// More than this are a slip of the keyboard, and take minutes to start.
const MOST_THREADS: usize = 1024;

/// A number of threads.
pub fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if n <= MOST_THREADS => Ok(n),
        _ => Err(format!("expected a whole number from 0 to {MOST_THREADS}")),
    }
}

/// A whole number from 1.
pub fn count(text: &str) -> Result<u64, String> {
    match text.parse() {
        Ok(n) if n > 0 => Ok(n),
        _ => Err("expected a whole number from 1".into()),
    }
}

/// A number.
pub fn finite(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|v: &f32| v.is_finite()).ok_or_else(|| "expected a number".into())
}

/// A number above 0.
pub fn positive(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(v) if v > 0.0 && v.is_finite() => Ok(v),
        _ => Err("expected a number greater than 0".into()),
    }
}

/// WIDTHxHEIGHT.
pub fn resolution(text: &str) -> Result<[u32; 2], String> {
    let parsed = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match parsed {
        Some([w, h]) if w > 0 && h > 0 => Ok([w, h]),
        _ => Err("expected WIDTHxHEIGHT, such as 640x480".into()),
    }
}

fn four<T: FromStr>(text: &str) -> Option<[T; 4]> {
    let values: Option<Vec<T>> = text.split(',').map(|v| v.trim().parse().ok()).collect();
    values?.try_into().ok()
}

/// Four whole numbers.
pub fn pixels(text: &str) -> Result<[u32; 4], String> {
    four(text).ok_or_else(|| "expected four whole numbers from 0, separated by commas".into())
}

/// Four numbers.
pub fn fractions(text: &str) -> Result<[f32; 4], String> {
    four(text)
        .filter(|v| v.iter().all(|v: &f32| v.is_finite()))
        .ok_or_else(|| "expected four numbers, separated by commas".into())
}

/// A..B, the end exclusive.
pub fn passes(text: &str) -> Result<[u64; 2], String> {
    let parsed = text.split_once("..").and_then(|(a, b)| Some([a.parse().ok()?, b.parse().ok()?]));
    match parsed {
        Some([a, b]) if a < b => Ok([a, b]),
        Some(_) => Err("the share is empty: the end is exclusive".into()),
        None => Err("expected A..B, such as 0..16".into()),
    }
}

/// The name of a tone curve.
pub fn tonemap(text: &str) -> Result<Tonemap, String> {
    Tonemap::by_name(text).ok_or_else(|| {
        let known: Vec<_> = Tonemap::NAMES.iter().map(|(n, _)| *n).collect();
        format!("known: {}", known.join(", "))
    })
}

/// The name of a space of colours.
pub fn variance_space(text: &str) -> Result<VarianceSpace, String> {
    match text {
        "xyz" => Ok(VarianceSpace::Xyz),
        "rgb" => Ok(VarianceSpace::Rgb),
        _ => Err("known: xyz, rgb".into()),
    }
}
