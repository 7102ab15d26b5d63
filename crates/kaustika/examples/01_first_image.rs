//! The first picture: renders the built-in scene and writes `first_image.png`.
//!
//! You learn the way from a description to a picture: description, setup, session, output.
//!
//! ```sh
//! cargo run --release --example 01_first_image [samples a pixel] [file]
//! ```

use kaustika::transport::{Budget, Observer, Progress, Session, Workers, registry};
use kaustika::{RenderOptions, Setup, builtin, film, output};
use std::error::Error;

struct Report;

impl Observer for Report {
    fn committed(&mut self, progress: &Progress, _: &film::accumulate::PassTree) {
        eprint!("\r{} passes in {:.1} s ", progress.passes, progress.elapsed.as_secs_f32());
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let spp = arguments.next().map(|n| n.parse()).transpose()?;
    let file = arguments.next().unwrap_or("first_image.png".into());

    let setup = Setup::new(&builtin::description(), &RenderOptions { spp, ..Default::default() })?;
    let path = registry::find("path").ok_or("no path tracer")?;
    let workers = Workers::new(0, Default::default())?;
    let mut session = Session::new(&setup.scene, &setup.frame, (path.make)(&setup.parameters)?);
    let budget = Budget { end_pass: Some(setup.spp), ..Default::default() };
    let outcome = session.run(&budget, &workers, &mut Report)?;
    let seconds = outcome.elapsed.as_secs_f64();
    let picture = output::picture(&session.tree, None, &setup.record, seconds);
    film::write_picture(&file, &picture, &Default::default())?;
    eprintln!("-> {file}");
    Ok(())
}
