//! `kaustika render`.

use super::args::RenderArgs;
use super::failure::Failure;
use super::job::Job;
use super::progress::preparing;
use super::viewer::Viewer;
use super::{bake, diagnostics, interrupt, picture};
use kaustika::scene::description::SceneDescription;
use kaustika::stats::Phases;
use kaustika::transport::{Schedule, Session, Workers};
use kaustika::{Denoiser, Setup, SetupError, builtin, load};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Renders a scene as the command line says.
///
/// # Errors
/// If the scene, the command line or the render is at fault.
pub fn run(args: &RenderArgs) -> Result<(), Failure> {
    let cancel = interrupt::install()?;
    picture::check_outputs(&args.output)?;
    args.stats.as_deref().map_or(Ok(()), picture::check_place)?;
    args.denoise.map_or(Ok(()), Denoiser::check).map_err(Failure::usage)?;
    let viewer = args.display.as_deref().map(|address| {
        let name = args.output.first().or(args.scene.as_ref());
        Viewer::connect(address, name.map_or("kaustika".into(), |n| n.display().to_string()))
    });
    let viewer = viewer.transpose()?;
    let workers = Workers::new(args.threads, cancel).map_err(Failure::input)?;
    let workers = if args.quiet { workers } else { workers.told_to(preparing()) };
    let mut phases = Phases::default();

    let start = Instant::now();
    let description = describe(args)?;
    phases.load = start.elapsed().as_secs_f64();

    let start = Instant::now();
    let setup = workers
        .install(|| Setup::new(&description, &args.options()))
        .map_err(|e| refuse(&description, e))?;
    phases.build = start.elapsed().as_secs_f64();
    let outputs = outputs(args, &description);
    // Meshes and images are in the scene by now.
    drop(description);
    picture::check_outputs(&outputs)?;
    check_share(args, setup.method.info().schedule)?;
    args.bake.as_deref().map_or(Ok(()), |path| bake::check(path, &*setup.method))?;

    let Setup { scene, frame, method, spp, record, unasked, notes, .. } = setup;
    notes.iter().filter(|_| !args.quiet).for_each(|note| eprintln!("note: {note}"));
    let mut job = Job::new(args, &record, &outputs, &unasked)?;
    let mut session = Session::new(&scene, &frame, method);
    job.resume(&mut session, &workers)?;
    let rendered = job.render(&mut session, &workers, spp, viewer);
    job.deliver(&session, &workers, phases, rendered)?;
    args.bake.as_deref().map_or(Ok(()), |path| {
        let written = bake::write(path, &scene, &*session.method)?;
        if !args.quiet {
            picture::tell(&written);
        }
        Ok(())
    })
}

/// Reads the scene, shows what there is to say about it and applies the command line.
fn describe(args: &RenderArgs) -> Result<SceneDescription, Failure> {
    let mut description = match &args.scene {
        Some(path) => load(path, &args.define),
        None => builtin::description(),
    };
    diagnostics::show(&description.sources, &description.diagnostics, args.quiet);
    if description.diagnostics.has_errors() {
        return Err(Failure::Told);
    }
    if let Some(environment) = &args.environment {
        environment.replace_in(&mut description).map_err(Failure::input)?;
    }
    Ok(description)
}

fn refuse(description: &SceneDescription, error: SetupError) -> Failure {
    match error {
        SetupError::Scene(e) => {
            diagnostics::show_build_error(&description.sources, &e);
            Failure::Told
        }
        SetupError::Choice(message) => Failure::Usage(message),
    }
}

/// Where the pictures go. Without `-o`: to the file name that the scene gives its film, as EXR in
/// the current folder; of the built-in scene a PNG too, for a first look.
fn outputs(args: &RenderArgs, description: &SceneDescription) -> Vec<PathBuf> {
    if !args.output.is_empty() {
        return args.output.clone();
    }
    if args.scene.is_none() {
        return vec!["kaustika.png".into(), "kaustika.exr".into()];
    }
    let film = description.cameras.first().and_then(|c| c.film.filename.as_deref());
    let stem = film.and_then(|f| Path::new(f).file_stem()).unwrap_or("kaustika".as_ref());
    vec![Path::new(stem).with_extension("exr")]
}

fn check_share(args: &RenderArgs, schedule: Schedule) -> Result<(), Failure> {
    let Some([_, end]) = args.passes else { return Ok(()) };
    if schedule == Schedule::Sequential {
        let message = "this method learns from pass to pass; its passes can't be dealt out";
        return Err(Failure::usage(message));
    }
    match args.spp {
        Some(spp) if end > spp => {
            let message = format!("the share ends at pass {end}, but --spp plans only {spp}");
            Err(Failure::Usage(message))
        }
        _ => Ok(()),
    }
}
