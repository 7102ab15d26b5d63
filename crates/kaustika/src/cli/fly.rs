//! `kaustika fly`: a flight through a scene by z-buffer, and how long its frames take.

use super::args::FlyArgs;
use super::failure::Failure;
use super::{counted, diagnostics, interrupt, picture, stdout};
use kaustika::film::Picture;
use kaustika::formats::mesh::{MeshOptions, read_mesh};
use kaustika::math::Vec2;
use kaustika::scene::description::{GeometryDesc, MeshAttribute, TriMesh};
use kaustika::transport::Workers;
use kaustika::transport::zbuffer::{self, Flight, Painted, Rasterizer, ZBufferParams};
use kaustika::{RenderOptions, Setup, SetupError, builtin, load};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

/// Draws the frames of a flight.
///
/// # Errors
/// If the scene or the command line is at fault, or a frame can't be written.
pub fn run(args: &FlyArgs) -> Result<(), Failure> {
    let cancel = interrupt::install()?;
    if let Some(folder) = args.output.as_deref().filter(|f| !f.is_dir()) {
        let folder = folder.display();
        return Err(Failure::Input(format!(
            "there is no folder {folder} to write the frames into, as 0000.png and so on; make it first"
        )));
    }
    let workers = Workers::new(args.threads, cancel).map_err(Failure::input)?;
    let description = match &args.scene {
        Some(path) => load(path, &args.define),
        None => builtin::description(),
    };
    diagnostics::show(&description.sources, &description.diagnostics, false);
    if description.diagnostics.has_errors() {
        return Err(Failure::Told);
    }
    let options = RenderOptions {
        method: Some(zbuffer::INFO.name.into()),
        parameters: args.parameter.clone(),
        camera: args.camera.clone(),
        resolution: args.resolution,
        ..RenderOptions::default()
    };
    let setup = workers.install(|| Setup::new(&description, &options)).map_err(|e| match e {
        SetupError::Scene(e) => {
            diagnostics::show_build_error(&description.sources, &e);
            Failure::Told
        }
        SetupError::Choice(message) => Failure::Usage(message),
    })?;
    drop(description);
    if setup.scene.has_media() {
        eprintln!("note: a z-buffer leaves out the media of this scene");
    }
    let seconds = fly(args, &setup, &workers)?;
    if let Some(folder) = &args.output {
        eprintln!("wrote {} into {}", counted::frames(seconds.len()), folder.display());
    }
    stdout::write(&match args.json {
        true => format!("{}\n", to_json(&setup, &seconds, workers.threads())),
        false => told(&setup, &seconds),
    })
}

/// Draws all frames; the seconds that each took, without writing it, rising.
fn fly(args: &FlyArgs, setup: &Setup, workers: &Workers) -> Result<Vec<f64>, Failure> {
    let Setup { scene, frame, .. } = setup;
    zbuffer::can_draw(scene, frame.size()).map_err(Failure::input)?;
    let params: ZBufferParams = serde_json::from_value(Value::Object(setup.parameters.clone()))
        .map_err(|e| Failure::usage(format!("method `zbuffer`: {e}")))?;
    let camera = zbuffer::flat_view(scene).map_err(Failure::input)?;
    // In the middle of every pixel.
    let middle = Vec2::new(0.5, 0.5);
    let start = zbuffer::view(scene, &camera, frame, middle).map_err(Failure::input)?;
    let mut rasterizer = workers.install(|| Rasterizer::new(scene, &params));
    let flight =
        workers.install(|| Flight::new(scene, &mut rasterizer, (&camera, &start), args.swing));
    let mut painted = args.baked.as_deref().map(painted).transpose()?;
    let mut seconds = Vec::new();
    for i in 0..args.frames {
        if workers.cancelled() {
            return Err(Failure::Input("the flight was interrupted".into()));
        }
        let camera = flight.camera(i as f32 / args.frames as f32);
        let begin = Instant::now();
        let view = zbuffer::view(scene, &camera, frame, middle).map_err(Failure::input)?;
        workers.install(|| match &mut painted {
            Some(painted) => painted.draw(scene, &view),
            None => rasterizer.draw(scene, &view),
        });
        seconds.push(begin.elapsed().as_secs_f64());
        if let Some(folder) = &args.output {
            let color = |x, y| match &painted {
                Some(painted) => painted.color(x, y),
                None => rasterizer.color(x, y),
            };
            write(args, folder, i, color, frame.size())?;
        }
    }
    seconds.sort_by(f64::total_cmp);
    Ok(seconds)
}

/// A mesh with light baked in.
fn painted(path: &Path) -> Result<Painted, Failure> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let mesh = match extension.as_deref() {
        Some("glb" | "gltf") => mesh_of_scene(path)?,
        _ => read_mesh(path, &MeshOptions::default()).map_err(Failure::input)?,
    };
    Painted::new(&mesh).ok_or_else(|| {
        let path = path.display();
        let message = format!(
            "{path}: the mesh has no colours at its vertices (r, g, b); `kaustika render -m radiosity \
             --bake {path}` writes them"
        );
        Failure::Input(message)
    })
}

/// The meshes of a scene file that have colours at their vertices, as one.
fn mesh_of_scene(path: &Path) -> Result<TriMesh, Failure> {
    let description = load(path, &[]);
    if description.diagnostics.has_errors() {
        diagnostics::show(&description.sources, &description.diagnostics, false);
        return Err(Failure::Told);
    }
    let mut all = TriMesh::default();
    let mut colors = Vec::new();
    for shape in &description.shapes {
        let GeometryDesc::Mesh(mesh) = &shape.geometry else { continue };
        let own = mesh.attributes.iter().find(|a| a.name == "vertex_color" && a.channels == 3);
        let Some(own) = own else { continue };
        let first = all.positions.len() as u32;
        all.positions.extend(mesh.positions.iter().map(|p| shape.transform.point(*p)));
        all.indices.extend(mesh.indices.iter().map(|t| t.map(|v| first + v)));
        colors.extend_from_slice(&own.values);
    }
    if !colors.is_empty() {
        let (name, channels) = ("vertex_color".into(), 3);
        all.attributes.push(MeshAttribute { name, channels, per_face: false, values: colors });
    }
    Ok(all)
}

fn write(
    args: &FlyArgs,
    folder: &Path,
    i: u64,
    color: impl Fn(u32, u32) -> [f32; 3],
    [w, h]: [u32; 2],
) -> Result<(), Failure> {
    let pixels: Vec<[f32; 3]> = (0..w * h).map(|k| color(k % w, k / w)).collect();
    let path = folder.join(format!("{i:04}.png"));
    picture::write(&[path], &Picture::from_rgb(w, h, &pixels), &args.look)
}

/// The least that so many of rising numbers do not exceed.
fn quantile(rising: &[f64], part: f64) -> f64 {
    let last = rising.len().saturating_sub(1);
    let at = (part * rising.len() as f64).ceil() as usize;
    rising.get(at.saturating_sub(1).min(last)).copied().unwrap_or(0.0)
}

fn told(setup: &Setup, seconds: &[f64]) -> String {
    let [w, h] = setup.frame.size();
    let (median, slow) = (quantile(seconds, 0.5), quantile(seconds, 0.99));
    format!(
        "{} of {w} x {h}: median {:.1} ms, 99 of 100 within {:.1} ms ({:.0} frames a second)\n",
        counted::frames(seconds.len()),
        1e3 * median,
        1e3 * slow,
        1.0 / median.max(1e-9),
    )
}

fn to_json(setup: &Setup, seconds: &[f64], threads: usize) -> Value {
    json!({
        "frames": seconds.len(),
        "resolution": setup.frame.size(),
        "threads": threads,
        "median_ms": 1e3 * quantile(seconds, 0.5),
        "p99_ms": 1e3 * quantile(seconds, 0.99),
    })
}
