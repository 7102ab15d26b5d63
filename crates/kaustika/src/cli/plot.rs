//! `kaustika plot`: drawings of what a renderer is made of.

use super::failure::Failure;
use super::values::{count, key_value};
use super::{diagnostics, picture, stdout};
use clap::{Args, Subcommand};
use kaustika::formats::pbrt::read_pbrt_str;
use kaustika::load;
use kaustika::plot::brdf::{Lobe, Probe, find};
use kaustika::plot::lobes_svg::{Panel, draw};
use kaustika::scene::description::{MaterialId, SceneDescription};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// `kaustika plot`.
#[derive(Args, Debug)]
pub struct PlotArgs {
    /// What to draw
    #[command(subcommand)]
    pub what: PlotCommand,
}

/// What can be drawn.
#[derive(Subcommand, Debug)]
pub enum PlotCommand {
    /// Lobes of materials in the plane of incidence, diffuse, glossy and singular apart, as SVG
    Brdf(PlotBrdfArgs),
}

/// `kaustika plot brdf`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  kaustika plot brdf '\"conductor\" \"float roughness\" 0.2' -o lobes.svg
  kaustika plot brdf paint steel --scene scene.xml --angle 30,60 --log -o lobes.svg")]
pub struct PlotBrdfArgs {
    /// Materials: names in the scene file, #N by number, or as pbrt writes them:
    /// '"conductor" "float roughness" 0.2'
    #[arg(required = true, value_name = "MATERIAL")]
    pub material: Vec<String>,
    /// Scene file, as `render` takes it
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Value of a scene variable (Mitsuba's $name); may be repeated
    #[arg(short = 'D', long = "define", value_name = "KEY=VALUE", value_parser = key_value)]
    pub define: Vec<(String, String)>,
    /// File to write, .svg or with --json .json; without one it goes to standard output
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Angles of incidence in degrees, separated by commas
    #[arg(long, value_name = "DEGREES", value_delimiter = ',', default_value = "0,35,55,75",
        value_parser = incidence, allow_hyphen_values = true)]
    pub angle: Vec<f32>,
    /// Degrees from value to value
    #[arg(long, value_name = "DEGREES", default_value_t = 1.0, value_parser = step,
        allow_hyphen_values = true)]
    pub step: f32,
    /// Panels a row
    #[arg(long, value_name = "N", value_parser = count, allow_hyphen_values = true)]
    pub columns: Option<u64>,
    /// Three decades instead of one scale
    #[arg(long)]
    pub log: bool,
    /// Write the values as JSON instead
    #[arg(long)]
    pub json: bool,
}

/// Draws.
///
/// # Errors
/// If a material is at fault or the drawing can't be written.
pub fn run(args: &PlotArgs) -> Result<(), Failure> {
    let PlotCommand::Brdf(args) = &args.what;
    args.output.as_deref().map_or(Ok(()), |path| check(path, args.json))?;
    let of_file = args.scene.as_ref().map(|path| sound(load(path, &args.define))).transpose()?;
    let mut panels = Vec::new();
    for wanted in &args.material {
        let (inline, material);
        let description = match (&of_file, wanted.trim_start().starts_with('"')) {
            (_, true) => {
                (inline, material) = inline_material(wanted)?;
                &inline
            }
            (Some(d), false) => {
                material = find(d, wanted).map_err(Failure::Usage)?;
                d
            }
            (None, false) => {
                return Err(Failure::Usage(format!(
                    "where is `{wanted}`? Name its scene with `--scene FILE`, or write a material as \
                     pbrt does: '\"conductor\" \"float roughness\" 0.2'"
                )));
            }
        };
        let probe = Probe::new(description, material).map_err(|e| {
            diagnostics::show_build_error(&description.sources, &e);
            Failure::Told
        })?;
        panels.extend(args.angle.iter().map(|&angle| Panel {
            title: wanted.replace('"', ""),
            lobe: probe.lobe(angle, args.step),
        }));
    }
    let Some(path) = &args.output else {
        return match args.json {
            true => stdout::write_json(&values(&panels)),
            false => stdout::write(&drawing(args, &panels)),
        };
    };
    let text = match args.json {
        true => format!("{:#}\n", values(&panels)),
        false => drawing(args, &panels),
    };
    fs::write(path, text)
        .map_err(|e| Failure::Input(format!("can't write {}: {e}", path.display())))?;
    picture::tell(std::slice::from_ref(path));
    Ok(())
}

/// Refuses a file whose name promises something else, or that could not be written.
fn check(path: &Path, json: bool) -> Result<(), Failure> {
    let (extension, what) = if json { ("json", "values") } else { ("svg", "drawings") };
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension)) {
        let shown = path.display();
        return Err(Failure::Usage(format!("{shown}: {what} are written as .{extension}")));
    }
    picture::check_place(path)
}

fn drawing(args: &PlotBrdfArgs, panels: &[Panel]) -> String {
    draw(panels, columns(args, panels.len()), args.log)
}

fn values(panels: &[Panel]) -> Value {
    panels.iter().map(to_json).collect()
}

/// Panels a row: those of a material, or a square of materials.
fn columns(args: &PlotBrdfArgs, panels: usize) -> usize {
    let square = (panels as f64).sqrt().ceil() as usize;
    let of_angles = if args.angle.len() > 1 { args.angle.len() } else { square };
    args.columns.map_or(of_angles, |n| n as usize)
}

/// A material as pbrt writes it.
fn inline_material(text: &str) -> Result<(SceneDescription, MaterialId), Failure> {
    let whole = format!("WorldBegin\nMaterial {text}\nShape \"disk\"\n");
    let d = sound(read_pbrt_str(&whole, Path::new("the material")))?;
    let material = d.shapes.first().map(|s| s.material);
    let none = || Failure::Usage(format!("`{text}` is no material"));
    material.map(|m| (d, m)).ok_or_else(none)
}

fn sound(description: SceneDescription) -> Result<SceneDescription, Failure> {
    diagnostics::show(&description.sources, &description.diagnostics, false);
    match description.diagnostics.has_errors() {
        true => Err(Failure::Told),
        false => Ok(description),
    }
}

fn to_json(panel: &Panel) -> Value {
    let Lobe { incidence, angles, diffuse, glossy, singular } = &panel.lobe;
    let singular: Vec<Value> =
        singular.iter().map(|(angle, part)| json!({ "angle": angle, "part": part })).collect();
    json!({
        "material": panel.title,
        "incidence": incidence,
        "angles": angles,
        "diffuse": diffuse,
        "glossy": glossy,
        "singular": singular,
    })
}

fn incidence(text: &str) -> Result<f32, String> {
    let angle = text.trim().parse().ok().filter(|a| (0.0..90.0).contains(a));
    angle.ok_or_else(|| "expected an angle from 0 to less than 90".into())
}

fn step(text: &str) -> Result<f32, String> {
    let step = text.parse().ok().filter(|s| (0.01..=30.0).contains(s));
    step.ok_or_else(|| "expected a step from 0.01 to 30".into())
}
