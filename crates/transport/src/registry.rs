//! The methods by name. To add one: its folder, and one line in [`ALL`].

use crate::method::{Method, MethodInfo};
use crate::path::{self, PathTracer};
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
pub static ALL: &[Entry] = &[Entry {
    info: &path::INFO,
    parameters: path::parameters,
    make: |p| Ok(Box::new(PathTracer::new(parse(p)?))),
}];

/// The method with this name.
pub fn find(name: &str) -> Option<&'static Entry> {
    ALL.iter().find(|e| e.info.name == name)
}

/// Parameters from key-value pairs; an unknown key is an error that lists the known ones.
fn parse<T: DeserializeOwned>(p: &Map<String, Value>) -> Result<T, String> {
    serde_json::from_value(Value::Object(p.clone())).map_err(|e| e.to_string())
}
