//! `kaustika methods`.

use super::args::MethodsArgs;
use super::failure::Failure;
use super::stdout;
use kaustika::setup::find_method;
use kaustika::transport::method::{Bias, Schedule};
use kaustika::transport::registry::{ALL, Entry, Parameter};
use serde_json::{Value, json};

/// Lists the methods with the classes of their paths, or one with its parameters.
///
/// # Errors
/// If there is no method of the name given.
pub fn run(args: &MethodsArgs) -> Result<(), Failure> {
    match &args.name {
        None if args.json => stdout::write_json(&ALL.iter().map(to_json).collect()),
        None => stdout::write(&list()),
        Some(name) => {
            let entry = find_method(name).map_err(Failure::usage)?;
            match args.json {
                true => stdout::write_json(&to_json(entry)),
                false => stdout::write(&describe(entry)),
            }
        }
    }
}

fn list() -> String {
    let longest = |of: fn(&Entry) -> &str| ALL.iter().map(|e| of(e).len()).max().unwrap_or(0);
    let name = longest(|e| e.info.name);
    let paths = longest(|e| e.info.path_class);
    let line = |e: &Entry| {
        let i = e.info;
        format!("{:name$}  {:paths$}  {}\n", i.name, i.path_class, i.summary)
    };
    ALL.iter().map(line).collect()
}

fn describe(entry: &Entry) -> String {
    let i = entry.info;
    let mut text = format!("{}: {}\n\n", i.name, i.summary);
    for (name, value) in [
        ("paths", i.path_class),
        ("misses", i.misses),
        ("estimate", bias(i.bias)),
        ("passes", schedule(i.schedule)),
        ("one spp", i.one_spp),
        ("source", i.source),
    ] {
        text += &format!("{name:10} {value}\n");
    }
    let parameters = (entry.parameters)();
    if !parameters.is_empty() {
        text += "\nparameters (-p KEY=VALUE)\n";
    }
    let cell = |p: &Parameter| format!("{}={}", p.key, p.default);
    let width = parameters.iter().map(|p| cell(p).len()).max().unwrap_or(0);
    for p in &parameters {
        text += &format!("  {:width$}  {}\n", cell(p), p.help);
    }
    text
}

fn to_json(entry: &Entry) -> Value {
    let i = entry.info;
    let parameters: Vec<Value> = (entry.parameters)()
        .iter()
        .map(|p| json!({ "key": p.key, "default": p.default, "help": p.help }))
        .collect();
    json!({
        "name": i.name,
        "summary": i.summary,
        "path_class": i.path_class,
        "misses": i.misses,
        "bias": bias(i.bias),
        "schedule": schedule(i.schedule),
        "one_spp": i.one_spp,
        "source": i.source,
        "parameters": parameters,
    })
}

fn bias(b: Bias) -> &'static str {
    match b {
        Bias::Unbiased => "unbiased",
        Bias::Consistent => "consistent",
        Bias::Biased => "biased",
    }
}

fn schedule(s: Schedule) -> &'static str {
    match s {
        Schedule::Stateless => "stateless",
        Schedule::Sequential => "sequential",
    }
}
