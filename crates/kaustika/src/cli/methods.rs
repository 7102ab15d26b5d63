//! `kaustika methods`.

use super::args::MethodsArgs;
use super::failure::Failure;
use kaustika::setup::find_method;
use kaustika::transport::method::{Bias, Schedule};
use kaustika::transport::registry::{ALL, Entry};
use serde_json::{Value, json};

/// Lists the methods, or one with its parameters.
///
/// # Errors
/// If there is no method of the name given.
pub fn run(args: &MethodsArgs) -> Result<(), Failure> {
    match &args.name {
        None if args.json => {
            println!("{:#}", Value::Array(ALL.iter().map(to_json).collect()));
        }
        None => list(),
        Some(name) => {
            let entry = find_method(name).map_err(Failure::usage)?;
            match args.json {
                true => println!("{:#}", to_json(entry)),
                false => describe(entry),
            }
        }
    }
    Ok(())
}

fn list() {
    let width = ALL.iter().map(|e| e.info.name.len()).max().unwrap_or(0);
    for e in ALL {
        println!("{:width$}  {}", e.info.name, e.info.summary);
    }
}

fn describe(entry: &Entry) {
    let i = entry.info;
    println!("{}: {}\n", i.name, i.summary);
    println!("paths      {}", i.path_class);
    println!("estimate   {}", bias(i.bias));
    println!("passes     {}", schedule(i.schedule));
    println!("one spp    {}", i.one_spp);
    println!("source     {}", i.source);
    let parameters = (entry.parameters)();
    if parameters.is_empty() {
        return;
    }
    println!("\nparameters (-p KEY=VALUE)");
    let cell = |p: &kaustika::transport::registry::Parameter| format!("{}={}", p.key, p.default);
    let width = parameters.iter().map(|p| cell(p).len()).max().unwrap_or(0);
    for p in &parameters {
        println!("  {:width$}  {}", cell(p), p.help);
    }
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
