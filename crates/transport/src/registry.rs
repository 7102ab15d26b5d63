//! The methods by name. To add one: its folder, and one line in [`ALL`].

use crate::bidirectional::{self, Bdpt, Vcm};
use crate::hybrid::{self, Hybrid};
use crate::method::{Method, MethodInfo};
use crate::metropolis::paths::{self, Erpt, Mlt};
use crate::metropolis::primary::{self, PrimarySpace};
use crate::particle::photon_map;
use crate::particle::{self, Vpl};
use crate::path;
use crate::path::guided::{self, Guided};
use crate::radiosity::{self, Radiosity};
use crate::ray_tracing::backward::{self, Backward};
use crate::ray_tracing::ray_tree::{self, RayTree};
use crate::zbuffer::{self, ZBuffer};
use kaustika_scene::description::known_names;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

/// Makes a method from its parameters; the error names the wrong key or value.
pub type Make = fn(&Map<String, Value>) -> Result<Box<dyn Method>, String>;

/// A method that can be made from its parameters.
pub struct Entry {
    /// What it is.
    pub info: &'static MethodInfo,
    /// Its parameters with their defaults and meanings.
    pub parameters: fn() -> Vec<Parameter>,
    /// Makes it.
    pub make: Make,
}

impl Entry {
    /// Whether it has a parameter of this key.
    ///
    /// # Errors
    /// If not; with advice.
    pub fn knows(&self, key: &str) -> Result<(), String> {
        let parameters = (self.parameters)();
        let known: Vec<&str> = parameters.iter().map(|p| p.key).collect();
        if known.contains(&key) {
            return Ok(());
        }
        let (name, advice) = (self.info.name, known_names(key, &known));
        Err(format!("method `{name}` has no parameter `{key}`; {advice}"))
    }
}

/// One parameter of a method.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Key, as `-p KEY=VALUE` takes it.
    pub key: &'static str,
    /// Default value.
    pub default: String,
    /// What it does.
    pub help: &'static str,
}

/// Every method.
pub static ALL: &[Entry] = &[
    Entry { info: &path::INFO, parameters: path::parameters, make: |p| path::make(parse(p)?) },
    Entry {
        info: &guided::INFO,
        parameters: guided::parameters,
        make: |p| Ok(Box::new(Guided::new(parse(p)?))),
    },
    Entry {
        info: &particle::LIGHT_INFO,
        parameters: particle::parameters,
        make: |p| particle::make_light(parse(p)?),
    },
    Entry {
        info: &bidirectional::INFO,
        parameters: bidirectional::parameters,
        make: |p| Ok(Box::new(Bdpt::new(parse(p)?))),
    },
    Entry {
        info: &bidirectional::VCM_INFO,
        parameters: bidirectional::vcm_parameters,
        make: |p| Ok(Box::new(Vcm::new(parse(p)?))),
    },
    Entry {
        info: &bidirectional::PPM_INFO,
        parameters: bidirectional::ppm_parameters,
        make: |p| Ok(Box::new(Vcm::ppm(parse(p)?))),
    },
    Entry {
        info: &photon_map::INFO,
        parameters: photon_map::parameters,
        make: |p| photon_map::make(parse(p)?),
    },
    Entry {
        info: &particle::VPL_INFO,
        parameters: particle::vpl_parameters,
        make: |p| Ok(Box::new(Vpl::new(parse(p)?))),
    },
    Entry {
        info: &primary::INFO,
        parameters: primary::parameters,
        make: |p| Ok(Box::new(PrimarySpace::new(parse(p)?))),
    },
    Entry {
        info: &primary::MULTIPLEXED_INFO,
        parameters: primary::multiplexed_parameters,
        make: |p| Ok(Box::new(PrimarySpace::multiplexed(parse(p)?))),
    },
    Entry {
        info: &paths::INFO,
        parameters: paths::parameters,
        make: |p| Ok(Box::new(Mlt::new(parse(p)?))),
    },
    Entry {
        info: &paths::ERPT_INFO,
        parameters: paths::erpt_parameters,
        make: |p| Ok(Box::new(Erpt::new(parse(p)?))),
    },
    Entry {
        info: &backward::INFO,
        parameters: backward::parameters,
        make: |p| Ok(Box::new(Backward::new(parse(p)?))),
    },
    Entry {
        info: &ray_tree::WHITTED_INFO,
        parameters: ray_tree::whitted_parameters,
        make: |p| Ok(Box::new(RayTree::whitted(parse(p)?))),
    },
    Entry {
        info: &ray_tree::DISTRIBUTED_INFO,
        parameters: ray_tree::distributed_parameters,
        make: |p| Ok(Box::new(RayTree::distributed(parse(p)?))),
    },
    Entry {
        info: &zbuffer::INFO,
        parameters: zbuffer::parameters,
        make: |p| Ok(Box::new(ZBuffer::new(parse(p)?))),
    },
    Entry {
        info: &radiosity::INFO,
        parameters: radiosity::parameters,
        make: |p| Ok(Box::new(Radiosity::new(parse(p)?)?)),
    },
    Entry {
        info: &hybrid::INFO,
        parameters: hybrid::parameters,
        make: |p| Ok(Box::new(Hybrid::new(&hybrid::INFO, parse(p)?)?)),
    },
    Entry {
        info: &hybrid::CHEN_INFO,
        parameters: hybrid::parameters,
        make: |p| Ok(Box::new(Hybrid::new(&hybrid::CHEN_INFO, parse(p)?)?)),
    },
];

/// The method with this name.
pub fn find(name: &str) -> Option<&'static Entry> {
    ALL.iter().find(|e| e.info.name == name)
}

/// Names of the methods that tell their paths apart.
pub fn with_layers() -> impl Iterator<Item = &'static str> {
    ALL.iter().filter(|e| e.info.layers).map(|e| e.info.name)
}

/// Parameters from key-value pairs; an unknown key is an error that lists the known ones.
fn parse<T: DeserializeOwned>(p: &Map<String, Value>) -> Result<T, String> {
    serde_json::from_value(Value::Object(p.clone())).map_err(|e| in_words(&e.to_string()))
}

/// serde's message about a value, with words for Rust's types.
fn in_words(error: &str) -> String {
    let of_value = ["invalid type: ", "invalid value: ", "unknown variant "];
    let (true, Some((found, expected))) =
        (of_value.iter().any(|s| error.starts_with(s)), error.rsplit_once(", expected "))
    else {
        return error.into();
    };
    let expected = match expected {
        "i8" | "i16" | "i32" | "i64" => "a whole number",
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number from 0",
        "f32" | "f64" => "a number",
        "a boolean" => "true or false",
        other => other,
    };
    let found = found.trim_start_matches("invalid type: ").trim_start_matches("invalid value: ");
    format!("expected {expected}, found {found}")
}

/// A parameter's value as it is written: a number or a truth value where it reads as one, else text.
pub fn scalar(text: &str) -> Value {
    match serde_json::from_str::<Value>(text) {
        Ok(v @ (Value::Number(_) | Value::Bool(_))) => v,
        _ => Value::String(text.into()),
    }
}

/// A number of bounces, or -1.
pub(crate) fn bounces<'de, D: serde::Deserializer<'de>>(d: D) -> Result<i64, D::Error> {
    let most = i64::from(u32::MAX);
    let n = i64::deserialize(d)?;
    match (-1..=most).contains(&n) {
        true => Ok(n),
        false => Err(serde::de::Error::custom(format!("{n} is neither -1 nor from 0 to {most}"))),
    }
}

/// A whole number above 0.
pub(crate) fn count<'de, D: serde::Deserializer<'de>>(d: D) -> Result<u32, D::Error> {
    let most = i64::from(u32::MAX);
    let n = i64::deserialize(d)?;
    match u32::try_from(n) {
        Ok(n) if n > 0 => Ok(n),
        _ => Err(serde::de::Error::custom(format!("{n} is not from 1 to {most}"))),
    }
}

/// Photons of an estimate.
pub(crate) fn at_least_two<'de, D: serde::Deserializer<'de>>(d: D) -> Result<usize, D::Error> {
    match count(d)? {
        1 => Err(serde::de::Error::custom("1 photon has no density: 2 or more are needed")),
        n => Ok(n as usize),
    }
}

/// A number above 0.
pub(crate) fn positive<'de, D: serde::Deserializer<'de>>(d: D) -> Result<f32, D::Error> {
    let x = f32::deserialize(d)?;
    match x > 0.0 && x.is_finite() {
        true => Ok(x),
        false => Err(serde::de::Error::custom(format!("{x} is not a number above 0"))),
    }
}
